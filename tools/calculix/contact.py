"""A frictionless contact beside the crown: CalculiX's mortar contact against femic's, by elements and by C.

CalculiX is given the approach of the far arcs, and has its mortar contact, which has no penalty.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from deck import Output, Part, element_faces, run
from meshing import Fineness, Mesh, Rectangle, mesh

from femic.contact.finite_elements.meshed_contact import Bodies
from femic.contact.finite_elements.result import fe_contact
from femic.contact.motions.none import solve_frictionless
from femic.contact.pairs.quantities import numbers
from femic.contact.undeformed import Undeformed
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.arrays import Array
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material

LOWER, UPPER = "LOWER", "UPPER"
STEEL = Material(210e3, 0.3)
LENGTH = 3.0  # half of a body along x, in far radii
AROUND = 1.35  # surfaces on which contact is sought, over the expected patch
GROWTH = 3.0  # of cells with the distance from the patch, times the cells along its half-width
NEAR_PEAK = 0.6  # share of the largest pressure, from which on the peak is fitted


@dataclass(frozen=True)
class Arcs:
    """A wheel on a rail, both of arcs [mm] with flanks at `flank` [degrees], of one material.

    The wheel is moved by `shift` [mm]; its rolling radius may be infinite. Far arcs of `far_radius` [mm].
    """

    rail: float
    wheel: float
    rolling_radius: float
    shift: float
    flank: float = 60.0
    material: Material = STEEL
    far_radius: float = 30.0

    @property
    def bodies(self) -> tuple[Body, Body]:
        """Lower and upper body."""
        flank, domain = np.radians(self.flank), Domain(self.far_radius, LENGTH * self.far_radius)
        lower = Body(-1, arc(self.rail, flank, flank), self.material, domain)
        upper = Body(
            +1, arc(self.wheel, flank, flank), self.material, domain, rolling_radius=self.rolling_radius
        )
        return lower, upper

    @property
    def undeformed(self) -> Undeformed:
        """The undeformed distance."""
        lower, upper = self.bodies
        return Undeformed(upper.surface, lower.surface, lower.contour.limits, self.shift)

    def scene(self, contact: dict[str, Any]) -> Any:
        """The scene of femic without a discount, with some keys of its contact."""

        def body(radius: float, rolling_radius: float) -> dict[str, Any]:
            contour = {"kind": "arc", "radius": radius, "flank_inclination_deg": self.flank}
            table = {"E": self.material.E, "nu": self.material.nu, "contour": contour}
            return table | ({"rolling_radius": rolling_radius} if np.isfinite(rolling_radius) else {})

        changes = {
            "lower": body(self.rail, np.inf),
            "upper": body(self.wheel, self.rolling_radius),
            "discount": "none",
            "lines": [{"along": "x", "s": 0.0, "reach": 5.0}],  # there have to be some
            "contact": contact | {"shift": self.shift},
            "engine": {"far_radius": self.far_radius, "check": False},
        }
        return load_scene("geometry2", changes)


@dataclass(frozen=True)
class Patch:
    """An expected patch: its half-length along x, and its ends on the lower contour [mm]."""

    a: float
    s: tuple[float, float]

    @property
    def b(self) -> float:
        """Half-width [mm]."""
        return (self.s[1] - self.s[0]) / 2


@dataclass(frozen=True)
class Run:
    """How CalculiX solves a contact: cells along the half-width of the patch; a folder for its files."""

    cells: float
    folder: Path
    large: bool = False  # displacements (NLGEOM)


@dataclass(frozen=True)
class Found:
    """Load [N], lateral force on the upper body over it, largest pressure [MPa] with its estimated error."""

    load: float
    lateral: float
    p_max: float
    size: str = ""  # of what was solved
    estimate: float | None = None


def by_elements(pair: Arcs, load: float, cells: float) -> tuple[Found, float, Patch]:
    """The contact under a load [N] by femic's finite elements; its approach [mm], and its patch."""
    lower, upper = pair.bodies
    contact = fe_contact(Bodies(lower, upper, lower.contour.limits, pair.shift), load, cells=cells)
    found = Found(
        load,
        contact.numbers.F_y / load,
        peak(contact.x, contact.s, contact.p),
        f"{sum(contact.unknowns) // 3} nodes",
        contact.estimate.p_max,
    )
    return found, contact.numbers.approach, Patch(contact.numbers.a, contact.s_range)


def by_c(pair: Arcs, approach: float, elements: int) -> Found:
    """The contact at an approach [mm] by C."""
    scene = pair.scene({"approaches": [approach], "ics": ["C"], "elements": elements})
    solved = solve_frictionless(scene.contact_problem, RunOptions(1))
    (contact,) = solved.contacts.values()
    known, grid = numbers(contact.on_grid, contact.normal), contact.on_grid.grid
    x, s = np.meshgrid(contact.on_grid.x, grid.strips, indexing="ij")
    p_max = peak(x.ravel(), s.ravel(), contact.normal.p.ravel())
    load = float(contact.normal.load)
    return Found(load, known["F_y"] / load, p_max, f"{grid.n_x} × {grid.n_s} elements")


def by_calculix(pair: Arcs, approach: float, patch: Patch, how: Run) -> Found:
    """The contact at an approach [mm] by CalculiX."""
    lower, upper = meshed(pair, patch, how.cells)
    parts = Part(LOWER, lower), Part(UPPER, upper, len(lower.nodes) + 1, len(lower.cells) + 1)
    lines = input_lines(parts, surfaces(pair, patch), approach, large=how.large)
    return found(run(lines, how.folder, "large" if how.large else "small"), parts)


def surfaces(pair: Arcs, patch: Patch) -> tuple[Rectangle, Rectangle]:
    """Where contact is sought on lower and upper body."""
    middle = sum(patch.s) / 2
    ends = np.array([middle - AROUND * patch.b, middle + AROUND * patch.b])
    on_both = ends, pair.undeformed.opposite(ends)
    lower, upper = (Rectangle(AROUND * patch.a, *map(float, each)) for each in on_both)
    return lower, upper


def meshed(pair: Arcs, patch: Patch, cells: float) -> tuple[Mesh, Mesh]:
    """Mesh both bodies; the upper one in its place at first touch."""
    x, s = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, 9), np.linspace(-1, 1, 13)))
    x, s = np.stack([x, s])[:, np.hypot(x, s) < 1.01]
    meshes = []
    for body, rectangle in zip(pair.bodies, surfaces(pair, patch), strict=True):
        middle, half = rectangle.s_start + rectangle.s_end, rectangle.s_end - rectangle.s_start
        points = body.surface.position(patch.a * x, middle / 2 + half / AROUND / 2 * s)
        meshes.append(mesh(body, Fineness(patch.b / cells, GROWTH / cells, points), rectangle))
    lower, upper = meshes
    place = np.array([0.0, pair.shift, pair.undeformed.touching[1]])
    return lower, replace(upper, nodes=upper.nodes + place)


def input_lines(
    parts: tuple[Part, Part], sought: tuple[Rectangle, Rectangle], approach: float, *, large: bool
) -> Iterator[str]:
    """Input: bodies, surfaces, supports, and a step in which the upper body comes down."""
    for part, rectangle in zip(parts, sought, strict=True):
        yield from part.lines()
        yield f"*SURFACE,NAME=TOUCH-{part.name},TYPE=ELEMENT"
        yield from element_faces(part, part.mesh.faces_in(rectangle))
    yield from ("*SURFACE INTERACTION,NAME=SMOOTH", "*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=HARD")
    yield from ("*CONTACT PAIR,INTERACTION=SMOOTH,TYPE=MORTAR", f"TOUCH-{LOWER},TOUCH-{UPPER}", "*BOUNDARY")
    yield from (f"FAR-{LOWER},1,3", f"FAR-{UPPER},1,2", f"CUT-{LOWER},1", f"CUT-{UPPER},1")
    yield from (f"*STEP,INC=100{',NLGEOM' if large else ''}", "*STATIC,SOLVER=SPOOLES", "1.,1.")
    yield from ("*BOUNDARY", f"FAR-{UPPER},3,3,{-approach:.14g}")
    yield from (f"*NODE PRINT,NSET=FAR-{UPPER},TOTALS=ONLY", "RF", "*CONTACT FILE", "CDIS,CSTR", "*END STEP")


def found(output: Output, parts: tuple[Part, Part]) -> Found:
    """Read load, lateral force and the largest pressure; half of the bodies is modelled.

    Pressures are those at vertices: CalculiX's mortar contact transforms the functions of mid-side nodes,
    where pressures are 3 % too small, on the plane of symmetry 17 %.
    """
    force = -2 * output.total_forces()[f"FAR-{UPPER}"]
    mesh, pressures = parts[0].mesh, output.contact_pressures()
    vertices = [node for node in np.unique(mesh.surface[:, :3]) + 1 if node in pressures]
    x, s = mesh.chart[np.array(vertices) - 1].T
    p_max = peak(x, s, np.array([pressures[node] for node in vertices]))
    nodes = sum(len(part.mesh.nodes) for part in parts)
    return Found(float(force[2]), float(force[1] / force[2]), p_max, f"{nodes} nodes")


def peak(x: Array, s: Array, p: Array) -> float:
    """Largest pressure [MPa] of a least-squares paraboloid of p^2, even in x, about the peak of p (n,)."""
    near = p > NEAR_PEAK * np.max(p)
    x, s, squared = x[near], s[near] - np.mean(s[near]), p[near] ** 2
    terms = np.stack([np.ones_like(x), s, s**2, x**2], axis=1)
    one, slope, bend, _ = np.linalg.lstsq(terms, squared, rcond=None)[0]
    return float(np.sqrt(one - slope**2 / (4 * bend)))
