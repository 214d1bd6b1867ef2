"""The request for a model of the solid engine."""

from dataclasses import dataclass

from femic.reference.engine import Request, Specification
from femic.reference.models import SolverChoice


@dataclass(frozen=True)
class SolidRequest(Request):
    """What one model is built and solved for."""

    solver: SolverChoice = "auto"


def request_for(asked: Specification) -> SolidRequest:
    """The request for a specified model; its accuracy is set by its cells alone."""
    return SolidRequest(asked.body, asked.loads, asked.points, asked.cells, asked.solver)
