"""Meshing with Gmsh: the boundary of a section, the size of cells, and the cells that Gmsh has made.

The only module that loads Gmsh: late, because Gmsh needs system libraries, and one model at a time.

The boundary of a section is a loop of Gmsh curves: contact contour, and far arc and hub, or an outline. The
curves may deviate a little from the true contour; the meshes move their nodes onto it. The size of cells, by
the same rule for sections and solids, is Gmsh's background field.
"""

import ctypes
import signal
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from types import ModuleType

import numpy as np

from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.errors import Failure

# --- Gmsh ---


@contextmanager
def gmsh_session() -> Iterator[ModuleType]:
    """A context with an empty, silent, repeatable Gmsh model; Python keeps the handling of Ctrl-C.

    Raises Failure where a system library that Gmsh needs is missing, and for errors of Gmsh.
    """
    try:
        import gmsh
    except OSError as error:
        raise Failure(
            f"Gmsh cannot be loaded: {error}. Run `sh tools/system-libraries.sh`, which installs the "
            "missing system packages or lists what to request from the administrator"
        ) from error
    gmsh.initialize(interruptible=False)
    # Gmsh lets writes to closed connections end the process (SIGPIPE): they shall raise again. Python can say
    # that in the main thread only, C in any.
    if signal.getsignal(signal.SIGPIPE) is signal.SIG_IGN:
        set_handler = ctypes.CDLL(None).signal
        set_handler.argtypes, set_handler.restype = (ctypes.c_int, ctypes.c_void_p), ctypes.c_void_p
        set_handler(signal.SIGPIPE, signal.SIG_IGN.value)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield gmsh
    except Exception as error:
        if type(error) is Exception:  # what Gmsh raises
            raise Failure(
                f"Gmsh: {error}. Likely cause: a contour that crosses itself or the far arc"
            ) from error
        raise
    finally:
        gmsh.finalize()


# --- the boundary of a section ---

SAMPLES_PER_CURVE = 81  # points of the contour per curve of Gmsh


def add_section(
    gmsh: ModuleType, body: Body, *, half_section: bool, breaks: Sequence[float] = ()
) -> tuple[int, list[int]]:
    """Add the section as a plane surface in x = 0; returns its tag and those of the contour's curves.

    With `half_section` only y >= 0 is added. The contour consists of one curve per smooth piece; it is also
    divided at the arc lengths `breaks` [mm].
    """
    occ, contour = gmsh.model.occ, body.contour
    s_start, s_end = 0.0 if half_section else body.s_range[0], body.s_range[1]
    inner = [s for s in (*contour.joints, *breaks) if s_start < s < s_end]
    places = np.unique([s_start, *inner, s_end])
    tags = [occ.addPoint(0, *contour.position(s)) for s in places]
    curves = []
    for (low, high), ends in zip(pairwise(places), pairwise(tags), strict=True):
        s = np.linspace(low, high, SAMPLES_PER_CURVE)
        if np.ptp(contour.inclination(s)) < 1e-12:
            curves.append(int(occ.addLine(*ends)))
        else:
            between = [occ.addPoint(0, y, z) for y, z in contour.position(s[1:-1]).T]
            curves.append(int(occ.addSpline([ends[0], *between, ends[1]])))
    if body.outline is None:
        closing = _add_closing(gmsh, body, (tags[0], tags[-1]), half_section)
    else:  # its edges from the contour's right end to its left end
        outline = body.outline
        points = outline.right_half_beyond(contour) if half_section else outline.beyond(contour)
        corners = [tags[-1], *(occ.addPoint(0, y, z) for y, z in points.T), tags[0]]
        closing = [occ.addLine(*pair) for pair in pairwise(corners)]
    loop = occ.addCurveLoop([*curves, *closing])
    return int(occ.addPlaneSurface([loop])), curves


def _add_closing(gmsh: ModuleType, body: Body, ends: tuple[int, int], half_section: bool) -> list[int]:
    """Add curves from the contour's right end along far arc and hub to its left end; returns their tags."""
    occ, far = gmsh.model.occ, body.domain.far_radius
    centre = occ.addPoint(0, 0, 0)
    top = min(far, body.depth)
    corner = np.sqrt(far**2 - top**2)  # where far arc and hub meet; 0 without a hub
    pole = occ.addPoint(0, 0, body.side * top)

    def to_pole(end: int, s: float, side: int) -> list[int]:
        z = body.contour.position(s)[1]
        if body.side * z > (1 - 1e-9) * body.depth:
            return [occ.addLine(end, pole)]
        if not corner:
            return [occ.addCircleArc(end, centre, pole)]
        hub_end = occ.addPoint(0, side * corner, body.side * top)
        return [occ.addCircleArc(end, centre, hub_end), occ.addLine(hub_end, pole)]

    right = to_pole(ends[1], body.s_range[1], +1)
    left = [occ.addLine(pole, ends[0])] if half_section else to_pole(ends[0], body.s_range[0], -1)[::-1]
    return [*right, *left]


# --- the size of cells ---

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


# --- cells that Gmsh has made ---

SIMPLEX = {2: (2, "triangles"), 3: (4, "tetrahedra")}  # Gmsh's number of a type of cells, by dimension


def collect_cells(
    gmsh: ModuleType, dimension: int, boundary: Iterable[int]
) -> tuple[Array, Indices, Indices]:
    """Points (3, n) [mm], cells (dimension + 1, m), and faces (dimension, k) of some boundary entities.

    `boundary` holds the tags of these entities. Points that no cell uses are left out. Raises Failure where
    Gmsh left other cells than triangles or tetrahedra.
    """
    number, name = SIMPLEX[dimension]
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    types, _, nodes = gmsh.model.mesh.getElements(dimension)
    if list(types) != [number]:
        raise Failure(f"Gmsh left cells of types {list(types)} where {name} were expected")
    used, flat = np.unique(nodes[0], return_inverse=True)
    order = np.argsort(tags)
    points = xyz.reshape(-1, 3)[order[np.searchsorted(tags, used, sorter=order)]].T
    faces = [
        np.searchsorted(used, gmsh.model.mesh.getElements(dimension - 1, entity)[2][0]) for entity in boundary
    ]
    return points, flat.reshape(-1, dimension + 1).T, np.concatenate(faces).reshape(-1, dimension).T


def edge_numbers(edges: Indices, pairs: Indices) -> Indices:
    """Numbers of the columns of `edges` (2, n_edges) that join the vertices `pairs` (2, n), shape (n,)."""
    n_vertices = int(edges.max()) + 1
    keys = np.sort(edges, axis=0).astype(np.int64).T @ [n_vertices, 1]
    order = np.argsort(keys)
    return order[np.searchsorted(keys, np.sort(pairs, axis=0).T @ [n_vertices, 1], sorter=order)]
