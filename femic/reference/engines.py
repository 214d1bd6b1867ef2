"""All engines by name: a new engine is a folder with a record, and an entry here."""

from collections.abc import Callable, Mapping

from femic.reference.engine import Engine
from femic.reference.harmonic.record import HARMONIC
from femic.reference.solid.record import SOLID

ENGINES: Mapping[str, Engine] = {engine.name: engine for engine in (HARMONIC, SOLID)}


def kinds_that(can: Callable[[Engine], object]) -> str:
    """Return the setting of a scene file that chooses an engine with a property: engine.kind = 'harmonic'."""
    names = [repr(name) for name, engine in ENGINES.items() if can(engine)]
    return f"engine.kind = {' or '.join(names)}"
