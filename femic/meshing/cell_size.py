"""How large cells are: the same rule for sections and solids, as Gmsh's background field."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType

from geometries.arrays import Array
from geometries.bodies import Body

ROUND = 0.5  # largest cell over its distance from the axis of revolution


@dataclass(frozen=True)
class Cells:
    """Target cell size h = sqrt(smallest^2 + (line_growth r)^2 + (growth d)^2).

    r is the distance from the nearest patch centre, d from the nearest point where results are read. In a
    section d is the distance from the nearest end of a loaded strip, and there is no r.
    """

    smallest: float
    growth: float
    line_growth: float

    def scaled(self, factor: float) -> "Cells":
        """Cells `factor` times as large everywhere."""
        return Cells(factor * self.smallest, factor * self.growth, factor * self.line_growth)


def distance(gmsh: ModuleType, points: Array) -> int:
    """Number of a field: the distance to the nearest of some points (3, n)."""
    tags = [gmsh.model.occ.addPoint(*point) for point in points.T]
    gmsh.model.occ.synchronize()
    field = gmsh.model.mesh.field.add("Distance")
    gmsh.model.mesh.field.setNumbers(field, "PointsList", tags)
    return int(field)


def round_the_axis(body: Body) -> str:
    """Cells in proportion to the distance from the axis of a body of revolution, as a formula."""
    return f"{ROUND:g}*sqrt(x^2+(z-({body.side * body.rolling_radius:.17g}))^2)"


def set_cell_size(gmsh: ModuleType, sizes: Sequence[str]) -> None:
    """Take the least of some sizes, formulas of fields F1, F2, ..."""
    field = gmsh.model.mesh.field
    evaluated = [field.add("MathEval") for _ in sizes]
    for tag, formula in zip(evaluated, sizes, strict=True):
        field.setString(tag, "F", formula)
    size = field.add("Min")
    field.setNumbers(size, "FieldsList", evaluated)
    field.setAsBackgroundMesh(size)
    for source in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
