"""Contact with friction at its limits: steady rolling, compression, rolling from rest."""

from compare.validation.extremes import histories, rolling
from compare.validation.extremes.cases import FRICTION, Limit
from compare.validation.extremes.contacts import ContactLimit
from femic.reference.run_options import RunOptions


def limits(options: RunOptions) -> list[Limit]:
    """Return the limits of contact with friction, with cases within and beyond them."""
    parts = [
        *rolling.limits(),
        *histories.limits(),
        ContactLimit("units, sides", "any", rolling.invariances(options)),
    ]
    return [part.as_limit(FRICTION, options) for part in parts]
