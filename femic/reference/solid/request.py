"""The request for a model of the solid engine."""

from dataclasses import dataclass

from femic.reference.engine import Request, Specification
from femic.reference.models import SolverChoice


@dataclass(frozen=True)
class SolidRequest(Request):
    """The input of one model."""

    solver: SolverChoice = "auto"


def request_for(model: Specification) -> SolidRequest:
    """Return the request for a model; its cells alone determine its accuracy."""
    return SolidRequest(model.body, model.loads, model.points, model.cells, model.solver)
