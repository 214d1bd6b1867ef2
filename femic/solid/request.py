"""The request for a model of the solid engine."""

from dataclasses import dataclass

from femic.engine import Specification
from femic.meshing.cell_size import Cells
from femic.models import Points, SolverChoice
from geometries.bodies import Body
from geometries.patches import Load


@dataclass(frozen=True)
class SolidRequest:
    """What one model is built and solved for. Points are relative to each load in x."""

    body: Body
    loads: tuple[Load, ...]
    points: Points
    cells: Cells
    solver: SolverChoice = "auto"


def request_for(specification: Specification) -> SolidRequest:
    """The request for a specified model; its accuracy is set by its cells alone."""
    return SolidRequest(
        specification.body,
        specification.loads,
        specification.points,
        specification.cells,
        specification.solver,
    )
