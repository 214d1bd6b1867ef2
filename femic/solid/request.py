"""What a model of the solid engine is built and solved for."""

from dataclasses import dataclass

from femic.engine import Specification
from femic.meshing.cell_size import Cells
from femic.models import Points, SolverChoice
from geometries.bodies import Body
from geometries.patches import Load


@dataclass(frozen=True)
class SolidRequest:
    """What one model is built and solved for; points are relative to each load in x."""

    body: Body
    loads: tuple[Load, ...]
    points: Points
    cells: Cells
    solver: SolverChoice = "auto"


def request_for(asked: Specification) -> SolidRequest:
    """The request for a model: its cells alone make it accurate."""
    return SolidRequest(asked.body, asked.loads, asked.points, asked.cells, asked.solver)
