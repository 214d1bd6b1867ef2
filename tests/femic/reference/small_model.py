"""A small model, and as a script: solve it into a store and say in a log which wavenumbers were solved."""

import sys
from pathlib import Path

import numpy as np

from femic.cache.store import Store
from femic.reference.engine import Points
from femic.reference.engines import HARMONIC
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.meshing import Cells
from femic.reference.refinement import solve_models
from femic.reference.run_options import Level, RunOptions, Task
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER

BODY = Body(LOWER, arc(10.0, 0.3, 0.4), Material(210e3, 0.28), Domain(60.0, np.inf))
LOADS = tuple(Load(Patch(0.4, 0.5), direction) for direction in range(3))
POINTS = Points(np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.5, 1.5]))
TASK = Task("lower", Level(), HarmonicRequest(BODY, LOADS, POINTS, Cells(0.2, 0.7, 0.7), 1e-8), 100_000)


def main(location: str, log: str) -> None:
    """Solve, counting."""
    respond = SectionSolver.__call__

    def counted(self, k, shares=(1.0,)):
        with Path(log).open("a") as lines:
            lines.writelines(f"{one!r}\n" for one in k)
        return respond(self, k, shares)

    SectionSolver.__call__ = counted
    list(solve_models([(HARMONIC, TASK)], RunOptions(2, Store(location))))


if __name__ == "__main__":
    main(*sys.argv[1:])
