"""Steps of refinement, and the orders at which errors fall with them.

Errors are taken to fall like h^3 and L^-2 by both engines. Measured are h^3 by the solid engine, h^4 by the
harmonic one, and L^-2 by both (docs/solid-engine.md, docs/harmonic-engine.md).
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

COARSER = 1.5  # cells of a step over those of the next
LARGER = 2.0  # domain of a step over that of the step before
HIGHER = 2.0  # largest wavenumber of a step over that of the step before
MESH_ORDER, TRUNCATION_ORDER = 3, 2  # of the errors, in cell size and in 1 / domain size
WAVES_ORDER = 3  # of the error due to the largest wavenumber
MODELS = ("fine", "coarse", "small")  # models that give C and its error, the most expensive first


@dataclass(frozen=True)
class Level:
    """Numbers of steps by which a model is refined beyond the first model of its job."""

    cells: int = 0
    domain: int = 0
    waves: int = 0  # of the harmonic engine: each step has larger wavenumbers, and more of them

    def models(self, names: Iterable[str]) -> dict[str, "Level"]:
        """The levels of the models, by their names in `MODELS`, that give C at this level and its error."""
        coarse = replace(self, cells=self.cells - 1)
        level_of_model = {"fine": self, "coarse": coarse, "small": replace(coarse, domain=self.domain - 1)}
        return {name: level_of_model[name] for name in names}


def factors(level: Level) -> tuple[float, float]:
    """Size of the cells and of the domain at a level, as multiples of the job's own."""
    return COARSER**-level.cells, LARGER**level.domain
