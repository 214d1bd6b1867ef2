"""C of one load beside the crown, raw: CalculiX against the harmonic engine, on a rail and on a wheel."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from deck import Part, face_loads, nodal_forces, node_set, run
from meshing import Fineness, Mesh, Rectangle, mesh

from femic.reference.engine import Points, Request
from femic.reference.engines import ENGINES
from femic.reference.run_options import Level, RunOptions, Task
from geometries.arrays import Array
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.patches import COMPONENTS, DIRECTIONS, Load, Patch, S, X, indices

FAR, LENGTHS = 40.0, 3.0  # mm; half-length along x, in far radii
TOLERANCE, LEAST = 1e-3, 1e-8  # of the harmonic engine: share, and mm/N below which waves are not resolved
EVEN, ODD = (S, 2), (X,)  # directions of loads, by the symmetry in x of their displacements


@dataclass(frozen=True)
class LoadedBody:
    """A body, a patch on it, and where displacements are read: x, s [mm]."""

    name: str
    body: Body
    patch: Patch
    points: tuple[tuple[float, float], ...]

    @property
    def chart(self) -> Array:
        """Coordinates (xi, s) of the points [mm], shape (n, 2)."""
        x, s = np.array(self.points).T
        return np.stack([self.body.surface.chart_x(x, s, self.patch.s), s], axis=1)

    @property
    def rectangle(self) -> Rectangle:
        """The loaded half of the patch."""
        patch = self.patch
        length = float(self.body.surface.chart_x(patch.a, patch.s, patch.s))
        return Rectangle(length, patch.s - patch.b, patch.s + patch.b)


def observers(s: float) -> tuple[tuple[float, float], ...]:
    """Points at and around a load at arc length s."""
    return (
        (0, s),
        (0, s + 0.3),
        (0, s + 1.6),
        (0, s - 1.6),
        (1.5, s),
        (1.5, s + 1.6),
        (5, s),
        (0, 0),
        (0, -s),
    )


def rail(length: float = LENGTHS) -> LoadedBody:
    """The lower body of Geometry 1, loaded 3 mm beside its crown."""
    flank = np.radians(25.5)
    domain = Domain(FAR, length * FAR)
    body = Body(-1, arc(10.0, flank, flank), Material(210e3, 0.28), domain)
    return LoadedBody("rail", body, Patch(0.2, 0.2, 3.0), observers(3.0))


def wheel(length: float = LENGTHS) -> LoadedBody:
    """The upper body of Geometry 2, of revolution, loaded 3 mm beside its crown."""
    flank = np.radians(60.0)
    domain = Domain(FAR, length * FAR)
    body = Body(+1, arc(10.1, flank, flank), Material(210e3, 0.3), domain, rolling_radius=500.0)
    return LoadedBody("wheel", body, Patch(0.167, 0.158, 3.0), observers(3.0))


def by_femic(loaded: LoadedBody) -> Array:
    """Raw displacements per unit total load [mm/N], shape (n, 3, 3): point, displacement, load."""
    engine = ENGINES["harmonic"]
    endless = replace(loaded.body, domain=Domain(loaded.body.domain.far_radius, np.inf))
    loads = tuple(Load(loaded.patch, direction) for direction in range(3))
    x, s = np.array(loaded.points, dtype=float).T
    cells = engine.first_cells(TOLERANCE, loaded.patch)
    model = Request(endless, loads, Points(x, s), cells, tolerance=TOLERANCE, least_scale=LEAST)
    request = engine.request(model)
    (solved,) = engine.solve([Task(loaded.name, Level(), request, 10**7)], RunOptions(1))
    return np.transpose(engine.displacements(solved.model, loads, request.points).u, (2, 1, 0))


def by_calculix(loaded: LoadedBody, growth: float, folder: Path) -> tuple[Array, Mesh]:
    """The same by CalculiX, and the mesh, whose cells grow by `growth` times the distance."""
    chart, patch = loaded.chart, loaded.patch
    points = loaded.body.surface.position(*chart.T)
    meshed = mesh(loaded.body, Fineness(0.4 * min(patch.a, patch.b), growth, points), loaded.rectangle)
    reads = [meshed.interpolation(*point) for point in chart]
    result = np.empty((len(chart), 3, 3))
    axes = loaded.body.surface.axes(*chart.T)  # (direction, component, point)
    for directions, held in ((EVEN, "1,1"), (ODD, "2,3")):
        lines = input_lines(loaded, meshed, directions, held)
        output = run(lines, folder, f"{loaded.name}-{''.join(DIRECTIONS[d] for d in directions)}")
        for direction, values in zip(directions, output.nodal(), strict=True):
            for k, (nodes, weights) in enumerate(reads):
                u = weights @ np.array([values[int(node) + 1] for node in nodes])
                result[k, :, direction] = axes[..., k] @ u
    return result, meshed


def input_lines(loaded: LoadedBody, meshed: Mesh, directions: Sequence[int], held: str) -> Iterator[str]:
    """Input with a step per direction of the load; `held` are the components that vanish in x = 0."""
    part = Part("BODY", meshed)
    yield from part.lines()
    read = np.unique(np.concatenate([meshed.interpolation(*point)[0] for point in loaded.chart]))
    yield from node_set("READ", part.node(read))
    yield from ("*BOUNDARY", "FAR-BODY,1,3", f"CUT-BODY,{held}")
    faces = meshed.faces_in(loaded.rectangle)
    for direction in directions:
        traction = np.eye(3)[direction] / loaded.patch.area
        yield from ("*STEP", "*STATIC,SOLVER=SPOOLES")
        yield from nodal_forces(part, face_loads(meshed, faces, traction))
        yield from ("*NODE PRINT,NSET=READ", "U", "*END STEP")


def rows(loaded: LoadedBody, growth: float, folder: Path) -> Iterator[list[str]]:
    """Rows of components, with the largest difference over the points [1e-6 mm/N]."""
    theirs, meshed = by_calculix(loaded, growth, folder)
    ours = by_femic(loaded)
    for component in COMPONENTS:
        i, j = indices(component)
        largest = float(np.max(np.abs(ours[:, i, j])))
        k = int(np.argmax(np.abs(theirs - ours)[:, i, j]))
        x, s = loaded.points[k]
        share = float(theirs[k, i, j] - ours[k, i, j]) / largest
        numbers = [f"{1e6 * values[k, i, j]:.4f}" for values in (theirs, ours)]
        name = f"{loaded.name}, {len(meshed.nodes)} nodes"
        yield [name, component, f"({x:g}, {s:g})", *numbers, f"{1e6 * largest:.4f}", f"{share:+.2%}"]


HEADER = ["body", "ij", "(x, s) [mm]", "CalculiX", "femic", "largest of all points", "difference over that"]
