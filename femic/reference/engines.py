"""All engines by name: a new engine is a folder with a record, and an entry here."""

from collections.abc import Mapping
from typing import Literal

from femic.reference.engine import Engine
from femic.reference.harmonic.record import HARMONIC
from femic.reference.solid.record import SOLID

EngineName = Literal["harmonic", "solid"]

ENGINES: Mapping[EngineName, Engine] = {"harmonic": HARMONIC, "solid": SOLID}
