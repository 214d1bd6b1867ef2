"""Contact of two bodies in several places at once: a grid on each, one approach, one load.

Patches may lie so far apart that one grid over all of them would hardly resolve any: tread and flange of a
wheel. Each place has a grid of its own then, an *area*. The pressures of all areas are one bound-constrained
problem: under one approach of the bodies they carry the load together. Within an area displacements are those
of its ICs, between areas those of the same approximation (`Coupling`).

Distances are those of the displaced bodies: the upper one comes down by the approach zeta along the direction
of the load, and the distance along the normals of the lower surface is taken there, not linearised in zeta.
Theory: docs/theory/contact.md.

`touching_beyond` tells where bodies on one grid touch beyond it, too.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import permutations

import numpy as np

from approx.pair import Pair
from femic.contact.exact.hertz import combined_modulus
from femic.contact.loading import Loading
from femic.contact.normal import (
    Bounded,
    NormalContact,
    NormalProblem,
    PotentialAreaTooSmall,
    PressureSolution,
    pressures,
)
from femic.contact.operators.protocols import Operator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.patch import block_mean, centre_of_pressure, near_ends
from femic.contact.undeformed import SAMPLES
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import Grid, N, Patch

# --- contact in several areas ---

NODES = 9  # of the interpolation between areas, along x and s of each
POINT = 1e-4  # sides of the element that stands for a point force between areas, over their distance
SETTLED = 1e-6  # change of the approach between two distances, as a share of it
MOST_STEPS = 40  # distances of the displaced body

Rectangle = tuple[float, tuple[float, float]]  # half-length along x, range of s [mm] of a grid


class AreaTooSmall(Failure):
    """The contact comes near some ends of the grid of an area, which has this `number`."""

    def __init__(self, number: int, short: PotentialAreaTooSmall) -> None:
        super().__init__(str(short))
        self.number, self.short = number, short


@dataclass(frozen=True, eq=False)
class Coupling:
    """Displacements along the normals of some areas by the pressures of others.

    Fields of far loads are smooth: pressures count by their moments about `NODES` by `NODES` Chebyshev nodes,
    and displacements are interpolated from such nodes with the same polynomials, so that the coupling is
    symmetric. `between` has the displacement [mm/N] at the nodes of area i by forces at those of area j.
    """

    boxes: tuple[Rectangle, ...]
    between: dict[tuple[int, int], Array]

    def displacements(self, grids: Sequence[Grid], p: Sequence[Array]) -> list[Array]:
        """Displacements [mm] in each area by the pressures [MPa] of the others, (n_x, n_s) each."""
        if not self.between:
            return [np.zeros_like(own) for own in p]
        bases = [_bases(grid, box) for grid, box in zip(grids, self.boxes, strict=True)]
        moments = [
            (along_x.T @ own @ along_s * grid.area).ravel()
            for (along_x, along_s), own, grid in zip(bases, p, grids, strict=True)
        ]
        at_nodes = [np.zeros(NODES * NODES) for _ in p]
        for (i, j), ics in self.between.items():
            at_nodes[i] += ics @ moments[j]
        return [
            along_x @ values.reshape(NODES, NODES) @ along_s.T
            for (along_x, along_s), values in zip(bases, at_nodes, strict=True)
        ]


@dataclass(frozen=True, eq=False)
class Areas:
    """Two bodies on the grids of several areas, the nn ICs on each, and the direction of load and approach.

    `roll` [rad] is the angle of that direction to the z axis, in the (y, z) plane: the load is along
    (sin roll, cos roll).
    """

    on_grids: tuple[PairOnGrid, ...]
    operators: tuple[Operator, ...]
    coupling: Coupling
    roll: float = 0.0

    @classmethod
    def with_approximation(
        cls, variant: str, bodies: PairOnGrid, grids: Sequence[Grid], roll: float = 0.0
    ) -> "Areas":
        """Return areas on some grids with an approximation of the ICs."""
        on_grids = tuple(replace(bodies, grid=grid) for grid in grids)
        operators = tuple(on_grid.operator(variant) for on_grid in on_grids)
        boxes = tuple((grid.n_x * grid.dx / 2, grid.extent) for grid in grids)
        return cls(on_grids, operators, coupling(variant, bodies.pair, boxes), roll)

    @property
    def grids(self) -> tuple[Grid, ...]:
        """The grids."""
        return tuple(on_grid.grid for on_grid in self.on_grids)

    def distances_at(self, approach: float) -> list[Array]:
        """Distances [mm] of the bodies displaced by an approach [mm], (n_x, n_s) of each area."""
        down, aside = approach * np.cos(self.roll), -approach * np.sin(self.roll)
        return [on_grid.distance_at(down, aside) for on_grid in self.on_grids]

    @cached_property
    def levels(self) -> "_Level":
        """The grids and, of elements twice as large each time, coarser ones."""
        cosines = [
            np.cos(on_grid.undeformed.lower.contour.inclination(on_grid.grid.strips) - self.roll)
            for on_grid in self.on_grids
        ]
        problems = [
            NormalProblem(on_grid.grid, operator, on_grid.flat, on_grid.distance, cosine)
            for on_grid, operator, cosine in zip(self.on_grids, self.operators, cosines, strict=True)
        ]
        return _Level(tuple(problems), self.coupling)

    def solve_about(
        self, approach: float, load: float, start: "AreasContact | None" = None
    ) -> "AreasContact":
        """Return the contact under a load [N] with the distance linearised about an approach [mm]."""
        distances = [
            distance + approach * problem.cosine
            for distance, problem in zip(self.distances_at(approach), self.levels.problems, strict=True)
        ]
        contacts = self.levels.solve(distances, load, start.contacts if start else None)
        return AreasContact(self, tuple(contacts))

    def solve(self, load: float, about: float = 0.0) -> "AreasContact":
        """Return the contact under a load [N] along the approach, of which `about` [mm] is a guess.

        Raises Failure as `pressures`, and where no approach goes with the distance that it
        leads to; `AreaTooSmall` where a patch comes near the end of its grid.
        """
        before, steps = about, list[tuple[float, float]]()
        solution = None
        for _ in range(MOST_STEPS):
            solution = self.solve_about(before, load, solution)
            after = solution.approach
            if abs(after - before) <= SETTLED * abs(after):
                return solution.with_room()
            steps.append((before, after - before))
            before = after
            if len(steps) > 1:  # by the secant of what two steps changed, unless that leads far away
                (x_0, f_0), (x_1, f_1) = steps[-2:]
                secant = after if f_1 == f_0 else x_1 - f_1 * (x_1 - x_0) / (f_1 - f_0)
                before = secant if abs(secant - after) <= abs(f_1) else after
        raise Failure(
            f"contact at {load:g} N: the approach and the distance of the displaced bodies do not settle "
            f"({before:g}, then {after:g} mm)"
        )


@dataclass(frozen=True, eq=False)
class AreasContact:
    """The pressures and gaps of all areas, under one approach [mm]."""

    areas: Areas
    contacts: tuple[NormalContact, ...]

    @property
    def approach(self) -> float:
        """Approach [mm], along the direction of the load."""
        return self.contacts[0].approach

    @property
    def parts(self) -> Iterator[tuple[PairOnGrid, NormalContact]]:
        """The bodies on the grid of each area, and the contact there."""
        return zip(self.areas.on_grids, self.contacts, strict=True)

    @property
    def force(self) -> Array:
        """Force of the pressures on the upper body along x, y, z [N], shape (3,)."""
        forces = [on_grid.resultant(contact.tractions).force for on_grid, contact in self.parts]
        return np.asarray(np.sum(forces, axis=0))

    @property
    def coarser(self) -> "AreasContact | None":
        """The same contact on elements twice as large, None where a grid is too small for that."""
        coarser = [contact.coarser for contact in self.contacts]
        found = tuple(contact for contact in coarser if contact is not None)
        if len(found) < len(coarser):
            return None
        on_grids = tuple(
            replace(on_grid, grid=contact.problem.grid)
            for on_grid, contact in zip(self.areas.on_grids, found, strict=True)
        )
        operators = tuple(contact.problem.operator for contact in found)
        return AreasContact(replace(self.areas, on_grids=on_grids, operators=operators), found)

    def displacements(self) -> list[Array]:
        """Displacements [mm] in each area by the pressures of the others, (n_x, n_s) each."""
        return self.areas.coupling.displacements(self.areas.grids, [contact.p for contact in self.contacts])

    def with_room(self) -> "AreasContact":
        """Return the contact; raise `AreaTooSmall` where a patch comes near the end of its grid."""
        for number, contact in enumerate(self.contacts):
            if ends := near_ends(contact.in_contact):
                raise AreaTooSmall(number, PotentialAreaTooSmall(ends, Loading(approach=self.approach)))
        return self


@dataclass(frozen=True, eq=False)
class _Level:
    """The problems of all areas on elements of one size; distances are those of each solution."""

    problems: tuple[NormalProblem, ...]
    coupling: Coupling

    @cached_property
    def coarser(self) -> "_Level | None":
        """The level of elements twice as large, None where a grid is too small for that."""
        if not all(problem.has_coarser for problem in self.problems):
            return None
        return _Level(tuple(problem.coarsened for problem in self.problems), self.coupling)

    def solve(
        self, distances: Sequence[Array], load: float, start: Sequence[NormalContact] | None
    ) -> list[NormalContact]:
        """Return the contacts of all areas with distances [mm] that include zeta cos(delta)."""
        problems = [
            replace(problem, distance=distance)
            for problem, distance in zip(self.problems, distances, strict=True)
        ]
        coarse: list[NormalContact] | list[None] = [None] * len(problems)
        p = None if start is None else [contact.p for contact in start]
        may_coarsen = all(np.any(np.isfinite(block_mean(d))) for d in distances) if self.coarser else False
        if self.coarser is not None and may_coarsen:
            below = [contact.coarser for contact in start] if start is not None else [None]
            found = [contact for contact in below if contact is not None]
            coarse = self.coarser.solve(
                [block_mean(d) for d in distances], load, found if len(found) == len(problems) else None
            )
            if p is None:
                p = [contact.p.repeat(2, axis=0).repeat(2, axis=1) for contact in coarse]
        solution = self._solve_together(problems, load, p)
        return [
            NormalContact(problem, own, coarser)
            for problem, own, coarser in zip(problems, solution, coarse, strict=True)
        ]

    def _solve_together(
        self, problems: Sequence[NormalProblem], load: float, start: Sequence[Array] | None
    ) -> list[PressureSolution]:
        """Return the solutions of all areas, from some pressures (n_x, n_s) or from none.

        They are one problem in variables sqrt(element area) p, so that the ICs stay symmetric.
        """
        alone, grids = [problem.bounded for problem in problems], [problem.grid for problem in problems]
        roots = [np.sqrt(grid.area) for grid in grids]
        ends = np.cumsum([own.h.size for own in alone])[:-1]

        def join(parts: Sequence[Array]) -> Array:
            return np.concatenate([root * part.ravel() for root, part in zip(roots, parts, strict=True)])

        def apart(v: Array) -> list[Array]:
            parts = zip(alone, np.split(v, ends), roots, strict=True)
            return [part.reshape(own.h.shape) / root for own, part, root in parts]

        def compliance(v: Array) -> Array:
            p = apart(v)
            parts = zip(alone, p, self.coupling.displacements(grids, p), strict=True)
            return join([own.compliance(pressed) + by_others for own, pressed, by_others in parts])

        def inverse(v: Array) -> Array:
            return join([own.inverse(gap) for own, gap in zip(alone, apart(v), strict=True)])

        bounded = Bounded(compliance, inverse, join([own.h for own in alone]), join([own.c for own in alone]))
        solution = pressures(bounded, load=load, start=None if start is None else join(start))
        parts = zip(apart(solution.p), apart(solution.gap), strict=True)
        return [replace(solution, p=p, gap=gap) for p, gap in parts]


# --- displacements between areas ---

NO_COUPLING = Coupling((), {})


@lru_cache(maxsize=32)
def coupling(variant: str, pair: Pair, boxes: tuple[Rectangle, ...]) -> Coupling:
    """Return the coupling of areas by an approximation of the ICs; one that is not reciprocal is averaged."""
    one_way = {
        (i, j): _point_forces(variant, pair, boxes[i], boxes[j])
        for i, j in permutations(range(len(boxes)), 2)
    }
    return Coupling(boxes, {(i, j): (ics + one_way[j, i].T) / 2 for (i, j), ics in one_way.items()})


def _point_forces(variant: str, pair: Pair, at: Rectangle, by: Rectangle) -> Array:
    """Return displacements along n at the nodes of a box by forces along n at those of another [mm/N]."""
    (x_i, s_i), (x_j, s_j) = (_nodes(box) for box in (at, by))
    half = POINT * max(float(np.min(np.abs(np.subtract.outer(s_i, s_j)))), 1e-6)
    lags = np.subtract.outer(x_i, x_j)  # (NODES, NODES)
    ics = np.empty((NODES, NODES, NODES, NODES))
    for k, s in enumerate(s_j):
        element = Patch(half, half, s=float(s))
        strip_ics = pair.approximate(variant, element, (lags[:, None, :], s_i[None, :, None]))
        ics[..., k] = strip_ics[N, N] / (4 * half**2)
    return ics.reshape(NODES * NODES, NODES * NODES)


def _nodes(box: Rectangle) -> tuple[Array, Array]:
    """Return the Chebyshev nodes of a box along x and s [mm], (NODES,) each."""
    unit = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    half_x, (low, high) = box
    return half_x * unit, (low + high) / 2 + (high - low) / 2 * unit


@lru_cache(maxsize=128)
def _bases(grid: Grid, box: Rectangle) -> tuple[Array, Array]:
    """Return Lagrange's polynomials of the nodes at the centres of elements, (n_x or n_s, NODES)."""
    x = np.asarray(grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2))
    bases = []
    for at, nodes in zip((x, grid.strips), _nodes(box), strict=True):
        apart, others = at[:, None] - nodes, [np.delete(np.arange(NODES), k) for k in range(NODES)]
        polynomials = [
            np.prod(apart[:, rest] / (nodes[k] - nodes[rest]), axis=1) for k, rest in enumerate(others)
        ]
        bases.append(np.stack(polynomials, axis=-1))
    return bases[0], bases[1]


# --- places beyond a grid ---


def touching_beyond(on_grid: PairOnGrid, contact: NormalContact) -> Array:
    """Return arc lengths [mm] beyond the ends of a grid at which the bodies would overlap, (n,).

    There the undeformed distance at x = 0 is less than the approach and the displacement of both surfaces, as
    half-spaces have it at a distance from the load of the contact.
    """
    (start, end), grid = on_grid.undeformed.s_range, on_grid.grid
    s = np.linspace(start, end, SAMPLES)
    s = s[(s < grid.extent[0]) | (s > grid.extent[1])]
    if not s.size:
        return s
    extra = 0.0 if on_grid.extra_gap is None else on_grid.extra_gap.at(np.zeros(1), s)
    distance = on_grid.undeformed.distance(0.0, s) + extra
    cosine = np.cos(on_grid.undeformed.lower.contour.inclination(s))
    modulus = combined_modulus(on_grid.pair.upper.material, on_grid.pair.lower.material)
    away = np.abs(s - centre_of_pressure(contact.p, grid.strips))
    displacement = float(np.sum(contact.p)) * grid.area / (np.pi * modulus * away)
    return np.asarray(s[contact.approach * cosine - distance > displacement])
