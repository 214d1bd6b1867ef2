"""Registrations of a session, such as forms of ICs of its own: workers must have the same ones.

A worker that does not know a form would fail all scenes that use it; one that knows another form of that name
would give other results.
"""

import re
from collections.abc import Mapping

from approx.forms import FORMS
from approx.variants import VARIANTS, forms_of
from femic.campaigns.results import registry
from femic.contact.motions import MOTIONS
from femic.reference.engines import ENGINES
from femic.scenes.contours import CONTOURS

ADDRESS = re.compile(r" at 0x\w+")  # of a function, in its repr
MAIN_OF_WORKER = "__mp_main__"  # the name of the script that is run, in processes that it starts


def registrations() -> dict[str, str]:
    """Return the definitions of all registered names as texts, which are the same in all processes."""
    registered: dict[str, Mapping[str, object]] = {
        "form": FORMS,
        "variant": {name: forms_of(name) for name in VARIANTS},
        "contour": CONTOURS,
        "motion": MOTIONS,
        "engine": ENGINES,
        "kind of results": dict.fromkeys(registry.KINDS),
    }
    return {
        f"{what} {name!r}": ADDRESS.sub("", repr(entry)).replace(MAIN_OF_WORKER, "__main__")
        for what, entries in registered.items()
        for name, entry in entries.items()
    }


def differing(expected: Mapping[str, str]) -> list[str]:
    """Return the registrations that this process lacks, has in addition, or has with another definition."""
    own = registrations()
    return [name for name in {**expected, **own} if own.get(name) != expected.get(name)]
