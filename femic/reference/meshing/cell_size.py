"""The size of cells, by the same rule for sections and solids, as Gmsh's background field."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType

from geometries.arrays import Array
from geometries.bodies import Body

ROUND_SHARE = 0.5  # largest cell over its distance from the axis of revolution


@dataclass(frozen=True)
class Cells:
    """Target cell size h = sqrt(smallest^2 + (line_growth r)^2 + (growth d)^2) [mm].

    r is the distance from the nearest patch centre, d from the nearest point where results are read. In a
    section d is the distance from the nearest end of a loaded strip, and there is no r.
    """

    smallest: float
    growth: float
    line_growth: float

    def scaled(self, factor: float) -> "Cells":
        """Cells that are `factor` times as large everywhere."""
        return Cells(factor * self.smallest, factor * self.growth, factor * self.line_growth)


def distance(gmsh: ModuleType, points: Array) -> int:
    """Add a field of Gmsh, the distance to the nearest of points (3, n) [mm]; returns its number."""
    tags = [gmsh.model.occ.addPoint(*point) for point in points.T]
    gmsh.model.occ.synchronize()
    field = gmsh.model.mesh.field.add("Distance")
    gmsh.model.mesh.field.setNumbers(field, "PointsList", tags)
    return int(field)


def size_about_axis(body: Body) -> str:
    """Formula of cells in proportion to the distance from the axis of a body of revolution."""
    return f"{ROUND_SHARE:g}*sqrt(x^2+(z-({body.side * body.rolling_radius:.17g}))^2)"


def set_cell_size(gmsh: ModuleType, sizes: Sequence[str]) -> None:
    """Set the size of cells to the least of some sizes, formulas of the fields F1, F2, ..."""
    field = gmsh.model.mesh.field
    evaluated = [field.add("MathEval") for _ in sizes]
    for tag, formula in zip(evaluated, sizes, strict=True):
        field.setString(tag, "F", formula)
    size = field.add("Min")
    field.setNumbers(size, "FieldsList", evaluated)
    field.setAsBackgroundMesh(size)
    for source in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
