"""What linear strains leave out of the largest pressure, in plane strain: docs/evidence/accuracy.md.

    python benchmarks/finite_strain.py [--record]

An elastic ring, held at its far circle, presses a rigid plane or a rigid circle without friction: with small
strains, and the distance along the ring's own undeformed normals as in femic; and in total Lagrangian form,
with the exact distance, and two laws that agree for small strains. It is a second route beside CalculiX
(tools/calculix): no code of that, fine meshes, and another law than that of St. Venant and Kirchhoff.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import block_array, csr_array
from scipy.sparse.linalg import spsolve
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, LinearForm, MeshTri, MeshTri2
from skfem.helpers import ddot, det, eye, grad, inv, mul, trace, transpose
from tables import Record, arguments, keep, print_table

Array = np.ndarray
E, NU = 210e3, 0.3
LAME, G = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
MODULUS = E / (1 - NU**2)  # combined: the obstacle is rigid
ACROSS, STRETCH = 10, 1.5  # cells along the half-width, and how they grow beyond it
WIDER = 1.3  # part of the circle with equal cells, over the expected half-width
NEAR_PEAK = 0.6  # share of the largest pressure, from which on the peak is fitted
MOST_STEPS, SETTLED = 80, 1e-9
SMALL, KIRCHHOFF, NEO_HOOKE = "small", "St. Venant-Kirchhoff", "neo-Hooke"


@dataclass(frozen=True)
class Solid:
    """An elastic ring whose contact circle has a `radius` [mm], held at the circle of radius `far`.

    It touches at (0, 0) an obstacle above it, a rigid circle of radius `obstacle` [mm], infinite for a plane.
    A ring with far > radius is a hole about a pin, one with far < radius a roller under a plane or in a
    groove.
    `half_width` [mm] is expected of the contact.
    """

    radius: float
    far: float
    obstacle: float
    half_width: float

    @property
    def hole(self) -> bool:
        """Whether the ring surrounds the obstacle."""
        return self.far > self.radius

    @cached_property
    def mesh(self) -> MeshTri2:
        """The right half of the ring; its chart (angle, depth) has the same numbers of nodes."""
        nodes = self._placed(self.chart)
        return MeshTri2(nodes, self._grid.t)

    @cached_property
    def _grid(self) -> MeshTri2:
        cell, width = self.half_width / ACROSS, WIDER * self.half_width
        angles = graded(cell / self.radius, width / self.radius, np.pi)
        depths = graded(cell, width, abs(self.far - self.radius))
        return MeshTri2.from_mesh(MeshTri.init_tensor(angles, depths))

    @property
    def chart(self) -> Array:
        """Angles from the lowest point [rad] and depths below the contact circle [mm] of nodes, (2, n)."""
        return np.asarray(self._grid.doflocs)

    def _placed(self, chart: Array) -> Array:
        angle, depth = chart
        out = 1.0 if self.hole else -1.0
        radius = self.radius + out * depth
        return np.stack([radius * np.sin(angle), out * (self.radius - radius * np.cos(angle))])

    @cached_property
    def contact(self) -> Array:
        """Numbers of the nodes of the contact circle by angle: vertices and mid-side nodes in turn."""
        on_circle = np.flatnonzero(self.chart[1] < 1e-12)
        return on_circle[np.argsort(self.chart[0][on_circle])]

    def gap(self, at: Array, approach: float) -> tuple[Array, Array, Array]:
        """Exact gap of points (2, m) [mm], its gradient (2, m), and its second derivatives (2, 2, m)."""
        if np.isinf(self.obstacle):
            down = np.zeros_like(at)
            down[1] = -1.0
            return -approach - at[1], down, np.zeros((2, 2, at.shape[1]))
        out = 1.0 if self.hole else -1.0
        apart = at - np.array([[0.0], [out * self.obstacle - approach]])
        radius = np.hypot(*apart)
        towards = apart / radius
        bend = (np.eye(2)[..., None] - towards[:, None] * towards[None]) / radius
        return out * (radius - self.obstacle), out * towards, out * bend

    def linear_gap(self, approach: float) -> tuple[Array, Array]:
        """Gap of the undeformed contact nodes along their own normals (m,), and minus these (2, m)."""
        angle = self.chart[0][self.contact]
        out = -1.0 if self.hole else 1.0
        normal = np.stack([out * np.sin(angle), np.cos(angle)])
        at = self._placed(self.chart[:, self.contact])
        if np.isinf(self.obstacle):
            distance = -at[1] / normal[1]
        else:
            apart = at - np.array([[0.0], [-out * self.obstacle]])
            along, rest = np.sum(apart * normal, axis=0), np.sum(apart**2, axis=0) - self.obstacle**2
            root = np.sqrt(np.maximum(along**2 - rest, 0))
            distance = -along - root if self.hole else -along + root
        return distance - approach * normal[1], -normal


def graded(cell: float, equal: float, length: float) -> Array:
    """Points from 0 to `length`: cells of one size as far as `equal`, then growing ones."""
    points = list(np.linspace(0, equal, round(equal / cell) + 1))
    while points[-1] < length:
        cell *= STRETCH
        points.append(points[-1] + cell)
    inner = np.array(points)
    beyond = inner > equal
    inner[beyond] = equal + (inner[beyond] - equal) * (length - equal) / (inner[-1] - equal)
    return inner


def stress(F: Any, law: str) -> Any:
    """First Piola-Kirchhoff stress of the deformation gradient F (plane strain)."""
    one = eye(1.0 + 0 * F[0, 0], 2)
    if law == SMALL:
        strain = (F + transpose(F)) / 2 - one
        return LAME * eye(trace(strain), 2) + 2 * G * strain
    if law == KIRCHHOFF:
        strain = (mul(transpose(F), F) - one) / 2
        return mul(F, LAME * eye(trace(strain), 2) + 2 * G * strain)
    back = transpose(inv(F))
    return G * (F - back) + LAME * np.log(det(F)) * back


def tangent(F: Any, H: Any, law: str) -> Any:
    """Derivative of the stress in the direction H."""
    if law == SMALL:
        strain = (H + transpose(H)) / 2
        return LAME * eye(trace(strain), 2) + 2 * G * strain
    if law == KIRCHHOFF:
        strain = (mul(transpose(F), F) - eye(1.0 + 0 * F[0, 0], 2)) / 2
        change = (mul(transpose(F), H) + mul(transpose(H), F)) / 2
        second = LAME * eye(trace(strain), 2) + 2 * G * strain
        return mul(H, second) + mul(F, LAME * eye(trace(change), 2) + 2 * G * change)
    back = transpose(inv(F))
    turned = mul(mul(back, transpose(H)), back)
    return G * (H + turned) + LAME * (ddot(back, H) * back - np.log(det(F)) * turned)


@dataclass(frozen=True)
class Found:
    """Load [N/mm] of both halves and largest pressure [MPa] at an approach [mm], and the solution."""

    load: float
    p_max: float
    u: Array
    force: Array


class Ring:
    """A solid with its basis: solves contacts at approaches."""

    def __init__(self, solid: Solid) -> None:
        self.solid = solid
        self.basis = Basis(solid.mesh, ElementVector(ElementTriP2()), intorder=3)
        # the mid-side nodes of MeshTri2 are numbered like its facets
        self.at_nodes = np.hstack([self.basis.nodal_dofs, self.basis.facet_dofs])  # (2, n_nodes)
        angle, depth = solid.chart
        held = self.at_nodes[:, depth > depth.max() - 1e-9].ravel()
        on_axis = self.at_nodes[0, (angle < 1e-12) | (angle > np.pi - 1e-12)]
        self.free = np.setdiff1d(np.arange(self.basis.N), np.concatenate([held, on_axis]))

    def forces(self, u: Array, law: str) -> tuple[Array, csr_array]:
        """Internal forces and their derivatives."""

        @LinearForm
        def internal(v: Any, w: Any) -> Any:
            return ddot(stress(grad(w["u"]) + eye(1.0 + 0 * w.x[0], 2), law), grad(v))

        @BilinearForm
        def derivative(du: Any, v: Any, w: Any) -> Any:
            return ddot(tangent(grad(w["u"]) + eye(1.0 + 0 * w.x[0], 2), grad(du), law), grad(v))

        field = self.basis.interpolate(u)
        return internal.assemble(self.basis, u=field), csr_array(derivative.assemble(self.basis, u=field))

    def solve(self, approach: float, law: str, near: Found | None = None) -> Found:
        """Solve the contact by Newton's method, for nodes in contact that change with their force and gap."""
        dofs = self.at_nodes[:, self.solid.contact]  # (2, m)
        below = self.solid.chart[0][self.solid.contact] < np.pi / 2
        gaps = self._gaps(approach, law)
        u, force = (np.zeros(self.basis.N), np.zeros(len(below))) if near is None else (near.u, near.force)
        active = below & (gaps(u)[0] < 0 if near is None else force > 0)
        for _ in range(MOST_STEPS):
            change, force = self._step(u, gaps(u), (active, force), law)
            u = u + change
            before, active = active, below & np.where(active, force > 0, gaps(u)[0] < 0)
            if np.array_equal(before, active) and np.max(np.abs(change)) < SETTLED * self.solid.half_width:
                break
        else:
            raise RuntimeError(f"no contact found at an approach of {approach:g} mm")
        at = self.solid.mesh.doflocs[:, self.solid.contact]
        p = force / lengths(at if law == SMALL else at + u[dofs])
        p_max = peak(self.solid.chart[0][self.solid.contact] * self.solid.radius, p)
        return Found(float(-2 * gaps(u)[1][1] @ force), p_max, u, force)

    def _step(
        self, u: Array, gaps: tuple[Array, Array, Array], state: tuple[Array, Array], law: str
    ) -> tuple[Array, Array]:
        """A step of Newton's method from displacements u: its change, and the forces of nodes (m,)."""
        (gap, slope, bend), (active, force) = gaps, state
        m, dofs, free = np.flatnonzero(active), self.at_nodes[:, self.solid.contact], self.free
        internal, stiffness = self.forces(u, law)
        places = (np.tile(np.arange(len(m)), 2), dofs[:, m].ravel())
        rows = csr_array((slope[:, m].ravel(), places), shape=(len(m), self.basis.N))[:, free]
        i, j = np.broadcast_arrays(dofs[:, None, m], dofs[None, :, m])
        curved = (bend[:, :, m] * force[m]).ravel()
        stiffness = stiffness - csr_array((curved, (i.ravel(), j.ravel())), shape=stiffness.shape)
        system = block_array([[stiffness[free][:, free], -rows.T], [rows, None]], format="csc")
        solution = spsolve(system, np.concatenate([-internal[free], -gap[m]]))
        change, forces = np.zeros(self.basis.N), np.zeros(len(active))
        change[free], forces[m] = solution[: len(free)], solution[len(free) :]
        return change, forces

    def _gaps(self, approach: float, law: str) -> Callable[[Array], tuple[Array, Array, Array]]:
        """Gaps of the contact nodes, gradients and second derivatives as a function of displacements."""
        dofs = self.at_nodes[:, self.solid.contact]
        at = self.solid.mesh.doflocs[:, self.solid.contact]
        distance, slope = self.solid.linear_gap(approach)
        straight = np.zeros((2, 2, len(distance)))
        if law == SMALL:
            return lambda u: (distance + np.sum(slope * u[dofs], axis=0), slope, straight)
        return lambda u: self.solid.gap(at + u[dofs], approach)


def lengths(nodes: Array) -> Array:
    """Integrals of the shape functions along a chain of three-node edges through nodes (2, m), (m,)."""
    w = np.zeros(nodes.shape[1])
    for t, weight in zip((-np.sqrt(0.6), 0.0, np.sqrt(0.6)), (5 / 9, 8 / 9, 5 / 9), strict=True):
        values = np.array([t * (t - 1) / 2, 1 - t * t, t * (t + 1) / 2])
        slopes = np.array([t - 0.5, -2 * t, t + 0.5])
        edges = np.stack([nodes[:, :-2:2], nodes[:, 1:-1:2], nodes[:, 2::2]])  # (3, 2, k)
        speed = np.hypot(*np.einsum("a,ack->ck", slopes, edges))
        for k in range(3):
            part = weight * values[k] * speed
            w[k : len(w) - 2 + k : 2] += part
    return w


def peak(s: Array, p: Array) -> float:
    """Largest pressure [MPa] of the parabola of p^2 over s that fits best near the peak."""
    near = p > NEAR_PEAK * np.max(p)
    return float(
        np.sqrt(np.linalg.lstsq(np.stack([np.ones(near.sum()), s[near] ** 2], 1), p[near] ** 2)[0][0])
    )


SHAPES = {  # contact circle, held circle and obstacle [mm]; rollers and holes
    "roller 10 mm under a plane": Solid(10.0, 2.0, np.inf, 1.0),
    "roller 10 mm in a groove of 12 mm": Solid(10.0, 2.0, 12.0, 1.0),
    "roller 10 mm in a groove of 10.5 mm": Solid(10.0, 2.0, 10.5, 1.0),
    "pin 8 mm in a hole of 10 mm": Solid(10.0, 60.0, 8.0, 1.0),
    "pin 9.5 mm in a hole of 10 mm": Solid(10.0, 60.0, 9.5, 1.0),
}
CHANGES = ["p_max at the same approach", "load at the same approach", "p_max at the same load"]
RECORD = Record(
    "finite_strain.plane_strain",
    "Finite strain in plane strain",
    "Relative changes by finite strain, divided by p_max / E, at p_max from 0.25 to 1.3 % of E. An elastic "
    "roller or hole against a rigid body.",
    "python benchmarks/finite_strain.py",
)
STRAINS = (0.0025, 0.005, 0.01)  # aimed at, largest pressure over E


def expected(solid: Solid, strain: float) -> tuple[Solid, float]:
    """The solid with Hertz's half-width at a largest pressure, and an approach that is about right [mm]."""
    bend = (-1 if solid.hole else 1) * (1 / solid.radius - 1 / solid.obstacle)
    half_width = 2 * strain * E / (MODULUS * bend)
    depth = abs(solid.far - solid.radius)
    return replace(solid, half_width=half_width), half_width**2 * bend / 2 * np.log(4 * depth / half_width)


@dataclass(frozen=True)
class Change:
    """Changes by finite strains over p_max / E: of p_max and load at an approach, of p_max at a load."""

    p_max: float
    load: float
    p_max_at_load: float


def changes(solid: Solid, strain: float) -> Iterator[tuple[str, float, Change]]:
    """Yield law, strain and changes of a solid about a strain."""
    solid, approach = expected(solid, strain)
    ring = Ring(solid)
    small = ring.solve(approach, SMALL)
    less = ring.solve(0.98 * approach, SMALL, small)
    growth = np.log(small.p_max / less.p_max) / np.log(small.load / less.load)
    found = small.p_max / E
    for law in (KIRCHHOFF, NEO_HOOKE):
        large = ring.solve(approach, law, small)
        p_max, load = large.p_max / small.p_max - 1, large.load / small.load - 1
        yield law, found, Change(p_max / found, load / found, (p_max - growth * load) / found)


def main() -> None:
    """Print the table; keep the ranges over the strains."""
    arguments()
    measured = [
        (name, law, found, list(vars(change).values()))
        for name, solid in SHAPES.items()
        for strain in STRAINS
        for law, found, change in changes(solid, strain)
    ]
    rows = [
        [name, law, f"{found:.2%}", *map("{:+.2f}".format, values)] for name, law, found, values in measured
    ]
    print_table(["bodies", "law", "p_max / E", *CHANGES], rows)
    kept = []
    for name in SHAPES:
        for law in (KIRCHHOFF, NEO_HOOKE):
            of_case = np.array([values for *case, _, values in measured if case == [name, law]])
            ranges = zip(of_case.min(axis=0), of_case.max(axis=0), strict=True)
            kept.append([name, law, *(f"{low:+.2f} … {high:+.2f}" for low, high in ranges)])
    keep(RECORD, ["bodies", "law", *CHANGES], kept)


if __name__ == "__main__":
    main()
