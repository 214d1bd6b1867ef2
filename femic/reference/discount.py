"""The rigid-body discount: the rigid motion that a far support allows, and its subtraction.

Far from the contact a load moves the body rigidly. D[I, J], the displacement at I by the rigid motion that a
unit load at J causes, is subtracted from the displacements. M is the compliance of these motions, one
symmetric matrix per body: under forces along x, y, z and a moment about the x axis, all at the contact
centre. On a prismatic body D = Phi(I)^T M Phi(J), where Phi takes a unit load to these forces and this
moment.

The rigid motions of a body of revolution must look the same from all positions along x. Five of them do: a
translation in the plane of rolling, alike in x and z (M_zz); a spin about the axle, which moves each point
along x in proportion to its radius (M_xx - M_zz at the contact centre); a translation along y; a tilt of the
axle, alike about x and z (M_yphi / R_roll); a tilt that comes with the first translation (M_yz / R_roll).
With these, D is rigid for each load, reciprocal, and a function of the lag. M has two more entries, phi-phi
and z-phi. The tilts of the axle cover a part of them; the rest turns the load's section about its contact
centre. Seen from another position this turn is rigid except for a translation along y, the turn times the
height of the observer's contact centre over the load's. This translation is left out: with it, D would not be
reciprocal, or loads at the contact centre would depend on phi-phi. Source: [BVSV] section 5.1;
docs/theory/discount.md.

A rule determines M, and so which motions count as rigid.

- `SourceRule` makes ICs of one load comparable with ICs of half-spaces, as [BVSV] section 5.1 does: M has all
  of its entries, including the ones that bend a slender section under a load beside its crown.
- `ApproachRule` subtracts only the rigid part of the normal approach, M_zz. The rest of the response of the
  bodies and their supports, bending included, is elastic and local, and contact needs it.
- `Rule` itself subtracts nothing.

The approach is matched at the load itself. C_nn - A_nn is not smooth there: near a load on a body with mean
curvature kappa / 2 (kappa is the sum of both principal curvatures, positive where the body is convex) it
varies as -(1 - 2 nu)^2 kappa / (8 pi G) ln r. So the limit of small loads exists only for the sum of two
bodies with equal profiles, where the logarithms cancel, and M_zz is matched under a load of fixed size, which
does not depend on the elements. (`tests/femic/reference/test_discount_rules.py` checks the coefficient.)
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from approx.pair import Solid
from femic.reference.engine import Points
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.patches import Load, N, Patch, S, X

# --- the compliance M and its rigid motions ---

FX, FY, FZ, MOMENT = range(4)  # rows and columns of M; the first generalized forces
TURN, SPIN = 4, 5  # further generalized forces: a moment about z, a moment about the axle
Entry = tuple[int, int]
# entries of M that are not always 0
ENTRIES: tuple[Entry, ...] = (
    (FX, FX),
    (FY, FY),
    (FZ, FZ),
    (FY, MOMENT),
    (FY, FZ),
    (MOMENT, MOMENT),
    (FZ, MOMENT),
)
AXES = ("x", "y", "z", "phi")


Measure = Callable[..., float]  # of displacements (3, n_points) under each load


@dataclass(frozen=True)
class Condition:
    """One equation for M: `measure` of the displacements (3, n_points) under `loads` must be `target`."""

    entry: Entry  # the entry of M that it determines
    loads: tuple[Load, ...]
    measure: Measure
    target: float


def rigid_part(m: Array, body: Body, points: Points, load: Load) -> Array:
    """D [mm/N] of a unit load at the points, shape (3, n)."""
    return discount(m, motions(body, points, load.patch.s))[:, load.direction]


def discount(m: Array, unit: Array, entries: Sequence[Entry] = ENTRIES) -> Array:
    """D [mm/N] of a body whose compliance is M, from its `motions` (`unit`), shape (3, 3, n).

    Only some `entries` of M count.
    """
    return np.tensordot(np.array([m[entry] for entry in entries]), unit, axes=1)


def motions(body: Body, points: Points, s_load: float, entries: Sequence[Entry] = ENTRIES) -> Array:
    """D between points and a load at arc length s_load [mm], per unit of some entries of M.

    Shape (len(entries), 3, 3, n); x and s of the points may also have shapes that broadcast together.
    """
    surface = body.surface
    xi = surface.chart_x(points.x, points.s, s_load)
    s_loads = np.full_like(points.s, s_load, dtype=float)
    seen = generalized(body, xi / 2, points.s), generalized(body, -xi / 2, s_loads)  # seen from half way

    def product(a: int, b: int) -> Array:
        return _outer(seen[0][a], seen[1][b])

    def mutual(a: int, b: int) -> Array:
        return product(a, b) + product(b, a)

    @cache
    def turns() -> tuple[Array, Array]:
        return _section_turns(body, points.s, s_loads, xi / body.rolling_radius)

    def tilt() -> Array:
        return product(MOMENT, MOMENT) + product(TURN, TURN) - turns()[0]

    def tilt_with_z() -> Array:
        return mutual(FZ, MOMENT) - mutual(FX, TURN) - turns()[1]

    lean = body.side / body.rolling_radius
    by_entry: dict[Entry, Callable[[], Array]] = {
        (FX, FX): lambda: product(SPIN, SPIN),
        (FY, FY): lambda: product(FY, FY),
        (FZ, FZ): lambda: product(FX, FX) + product(FZ, FZ) - product(SPIN, SPIN),
        (FY, MOMENT): lambda: mutual(FY, MOMENT) + lean * tilt(),
        (FY, FZ): lambda: mutual(FY, FZ) + lean * tilt_with_z(),
        (MOMENT, MOMENT): lambda: turns()[0],
        (FZ, MOMENT): lambda: turns()[1],
    }
    unit = np.empty((len(entries), *product(FX, FX).shape))
    for motion, entry in zip(unit, entries, strict=True):
        motion[...] = by_entry[entry]()
    return unit


def generalized(body: Body, xi: ArrayLike, s: ArrayLike) -> Array:
    """Generalized forces of unit loads in the local directions at (xi, s) [mm], shape (6, 3, n).

    They are forces along x, y, z, moments [mm] about x and z through the contact centre at xi = 0, and the
    moment about the axle over the moment of a unit force along x at the contact centre.
    """
    surface = body.surface
    force = np.swapaxes(surface.axes(xi, s), 0, 1)  # (component, direction, n)
    moment = np.cross(surface.position(xi, s)[:, None], force, axis=0)
    spin = np.zeros_like(force[:1])
    spin[:, X] = 1 - body.side * body.contour.position(s)[1] / body.rolling_radius
    return np.concatenate([force, moment[:1], moment[2:], spin])


def _section_turns(body: Body, s: Array, s_load: Array, angle: Array) -> tuple[Array, Array]:
    """Displacements by turns of sections about their contact centres, shape (3, 3, n) each.

    The first turns are caused by moments about the contact centre, the second by forces along z. An observer
    at an angle about the axle [rad] sees the turn of the load's section as a turn about x and one about z.
    """
    in_section = replace(body, rolling_radius=np.inf, hub_radius=None)
    seen = []
    for place in (s, s_load):
        forces = generalized(in_section, np.zeros_like(place), place)
        # y of a load along x, with the sign of the turn about z that it sees
        lever = np.zeros_like(forces[0])
        lever[X] = body.side * body.contour.position(place)[0]
        seen.append((forces[MOMENT], forces[FZ], lever))
    (moment, radial, lever), (load_moment, load_radial, load_lever) = seen
    sin, cos = np.sin(angle), np.cos(angle)
    turned_moment = cos * moment + sin * lever
    load_moment_seen = cos * load_moment - sin * load_lever
    turned = _outer(turned_moment, load_moment) - _outer(moment, sin * load_lever)
    return turned, _outer(turned_moment, load_radial) + _outer(radial, load_moment_seen)


def _outer(observer: Array, load: Array) -> Array:
    """Products (3, 3, n) of values (3, n) at observers and at loads."""
    return observer[:, None] * load[None]


# --- rules ---


class Rule:
    """The observers and conditions that determine M; here there are none, and nothing is subtracted."""

    def points(self, body: Body) -> Points:  # noqa: ARG002
        """All observers that conditions may read."""
        return Points(np.empty(0), np.empty(0))

    def conditions(self, body: Body, loads: Sequence[Load]) -> list[Condition]:  # noqa: ARG002
        """The conditions that determine the entries of M for the given loads."""
        return []

    def observers(self, body: Body, fit: Sequence[Condition]) -> Points:  # noqa: ARG002
        """The first of `points`, as many as the given conditions read."""
        return self.points(body)


def fit_discount(body: Body, rule: Rule, fit: Sequence[Condition], u: Mapping[Load, Array]) -> Array:
    """M [mm/N, 1/N, 1/(N mm)], shape (4, 4), from displacements (3, n) [mm/N] at the observers.

    Entries that no condition determines are 0.
    """
    if not fit:
        return np.zeros((4, 4))
    points, entries = rule.points(body), np.zeros((len(fit), 4, 4))
    for m, condition in zip(entries, fit, strict=True):
        m[condition.entry] = m[condition.entry[::-1]] = 1.0
    matrix = [
        [condition.measure(*(rigid_part(m, body, points, load) for load in condition.loads)) for m in entries]
        for condition in fit
    ]
    defects = [
        condition.measure(*(u[load] for load in condition.loads)) - condition.target for condition in fit
    ]
    return np.asarray(np.tensordot(np.linalg.solve(matrix, defects), entries, axes=1))


ELEMENTS_AWAY = 3  # distance in elements, centre to centre, at which the source has C_jj = A_jj
Z = 2  # number of the global axis z
NEAR, RIGHT, LEFT = range(3)  # the first points of `SourceRule.points`
BESIDE_LOAD = {+1: (3, 4), -1: (5, 6)}  # the points on both sides of the moment load at +-moment_arm


@dataclass(frozen=True)
class ApproachRule(Rule):
    """M_zz alone, such that C_nn = A_nn at the centre of a load on |x|, |s| <= `half_side` [mm]."""

    half_side: float

    def points(self, body: Body) -> Points:  # noqa: ARG002 (the same of any body)
        """The observer at the centre of the load."""
        return Points(np.zeros(1), np.zeros(1))

    def conditions(self, body: Body, loads: Sequence[Load]) -> list[Condition]:
        """The condition for M_zz; none where nothing is loaded."""
        if not loads:
            return []
        load = Load(Patch(self.half_side, self.half_side), N)
        a_nn = half_space("A", body, load.patch, self.points(body))[N, N, 0]
        return [Condition((FZ, FZ), (load,), lambda u: float(u[N, 0]), float(a_nn))]


@dataclass(frozen=True)
class SourceRule(Rule):
    """Where M is fitted [mm]: loads at s = 0 and +-moment_arm, observers up to s = +-rotation_reach.

    Observers beside moment loads lie up to s = +-(moment_arm + rotation_reach). Loads are uniform over
    patches of half-sides a, b [mm].
    """

    a: float
    b: float
    rotation_reach: float
    moment_arm: float

    def load(self, direction: int, s: float = 0.0) -> Load:
        """The unit load in a direction at arc length s [mm]."""
        return Load(Patch(self.a, self.b, s), direction)

    def moment_load(self, side: int = 1) -> Load:
        """The normal load at s = side * moment_arm, which turns the body about x."""
        return self.load(N, side * self.moment_arm)

    def points(self, body: Body) -> Points:
        """The observers: 3 elements away along x, at s = +-rotation_reach, beside both moment loads.

        The last ones lie `rotation_reach` from the moment loads, or less where the contour ends earlier.
        """
        low, high = body.contour.extent
        distance = min(self.rotation_reach, high - self.moment_arm, -low - self.moment_arm)
        beside_loads = [side * self.moment_arm + d for side in (1, -1) for d in (distance, -distance)]
        s = np.array([0.0, self.rotation_reach, -self.rotation_reach, *beside_loads])
        x = np.zeros_like(s)
        x[NEAR] = ELEMENTS_AWAY * 2 * self.a
        return Points(x, s)

    def conditions(self, body: Body, loads: Sequence[Load]) -> list[Condition]:
        """The conditions that determine the entries of M which concern the given loads.

        - C_jj = A_jj three elements away along x.
        - Under the lateral load u_z(reach) - u_z(-reach) equals that of A_ns on a plane.
        - Off-centre loads need all entries, also phi-phi: under a normal load at the moment arm, the part of
          C_nn that is antisymmetric about the load equals the same part of B-hat.
        - Sections without symmetry couple s and n. There u_z(reach) - u_z(-reach) vanishes under the normal
          load, C_sn + C_ns vanishes three elements away, and phi-phi is fitted to moment loads on both sides.

        A load along x moves a prismatic body along x only; from another position on a wheel this is also a
        motion along z.
        """
        directions = {load.direction for load in loads}
        section_directions = directions if np.isfinite(body.rolling_radius) else directions - {X}
        off_centre = any(load.patch.s != 0 and load.direction in section_directions for load in loads)
        coupled = not body.symmetric and bool(section_directions)
        lateral = S in directions or coupled or off_centre
        normal = bool(section_directions - {S}) or coupled or off_centre
        points = self.points(body)
        ends = [RIGHT, LEFT]
        to_vertical = body.surface.axes(0.0, points.s[ends])[:, Z]  # (3 directions, 2)

        def condition(entry: Entry, loads: Sequence[Load], target: float, measure: Measure) -> Condition:
            return Condition(entry, tuple(loads), lambda *u: float(measure(*u)), float(target))

        def near(j: int) -> Condition:
            a = half_space("A", body, self.load(j).patch, points)
            return condition((j, j), [self.load(j)], a[j, j, NEAR], lambda u: u[j, NEAR])

        def tilt(u: Array) -> float:
            """u_z(reach) - u_z(-reach) at x = 0, of displacements u (3, n_points) at the observers."""
            right, left = np.sum(to_vertical * u[:, ends], axis=0)
            return float(right - left)

        needed: list[Condition] = []
        if X in directions:
            needed.append(near(X))
        if lateral:
            a = half_space("A", body, self.load(S).patch, points)[N, S]
            needed += [near(S), condition((FY, MOMENT), [self.load(S)], a[RIGHT] - a[LEFT], tilt)]
        if normal:
            needed.append(near(N))
        if coupled:
            loads = [self.load(N), self.load(S)]
            needed += [
                condition((FZ, MOMENT), loads[:1], 0.0, tilt),
                condition((FY, FZ), loads, 0.0, lambda u_n, u_s: u_n[S, NEAR] + u_s[N, NEAR]),
            ]
        if off_centre:
            sides = (1,) if body.symmetric else (1, -1)
            moment_loads = [self.moment_load(side) for side in sides]

            def antisymmetric(*u: Array) -> float:
                """C_nn further out minus C_nn further in, summed over the loads."""
                differences = [
                    side * (of_load[N, BESIDE_LOAD[side][0]] - of_load[N, BESIDE_LOAD[side][1]])
                    for side, of_load in zip(sides, u, strict=True)
                ]
                return float(sum(differences))

            b_hat = [half_space("Bhat", body, load.patch, points)[:, N] for load in moment_loads]
            target = antisymmetric(*b_hat)
            needed.append(condition((MOMENT, MOMENT), moment_loads, target, antisymmetric))
        return needed

    def observers(self, body: Body, fit: Sequence[Condition]) -> Points:
        """The points that the conditions read; those beside moment loads only where they are used."""
        points = self.points(body)
        turning = any(condition.entry == (MOMENT, MOMENT) for condition in fit)
        used = slice(None if turning else len((NEAR, RIGHT, LEFT)))
        return Points(points.x[used], points.s[used])


def half_space(variant: str, body: Body, patch: Patch, points: Points) -> Array:
    """ICs [mm/N] of an approximation at points, shape (3, 3, n)."""
    return Solid(body.material, body.surface).approximate(variant, patch, (points.x, points.s)) / patch.area
