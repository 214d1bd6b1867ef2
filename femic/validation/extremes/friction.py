"""Contact with friction at its limits: steady rolling, compression, rolling from rest."""

from femic.reference.run_options import RunOptions
from femic.validation.extremes import histories, rolling
from femic.validation.extremes.cases import FRICTION, Limit
from femic.validation.extremes.contacts import ContactLimit


def limits(options: RunOptions) -> list[Limit]:
    """Return the limits of contact with friction, with cases within and beyond them."""
    parts = [
        *rolling.limits(),
        *histories.limits(),
        ContactLimit("units, sides", "any", rolling.invariances(options)),
    ]
    return [part.of(FRICTION, options) for part in parts]
