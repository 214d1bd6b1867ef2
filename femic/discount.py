"""The rigid-body discount: what a far support adds to the displacements, and its subtraction.

Far from the contact a body moves rigidly, by a symmetric compliance. D[I, J] is subtracted: the displacement
at I of the rigid motion that a unit load at J causes. M is that compliance, one symmetric matrix per body: of
forces along x, y, z and the moment about the x axis, all at the contact centre. On a prismatic body
D = Phi(I)^T M Phi(J), where Phi carries a unit load to these forces.

A body of revolution moves rigidly in its own way, which looks the same from all places along x. Five
motions do: a translation in the plane of rolling, alike in x and z (M_zz); a spin about the axle, which moves
each point along x in proportion to its radius (M_xx - M_zz at the contact centre); a translation along y; a
tilt of the axle, alike about x and z (M_yphi / R_roll); one that comes with the first translation
(M_yz / R_roll). With these D is rigid for each load, reciprocal, and a function of the lag. M has two entries
more, phi-phi and z-phi: what tilts of the axle leave of them turns the load's section about its contact
centre. Seen from elsewhere that is rigid but for a translation along y, the turn times the height of the
observer's contact centre over the load's. It is left out: with it, D would not be reciprocal, or loads at the
contact centre would depend on phi-phi. Source: [BVSV] section 5.1, design section 4.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from approx.halfspace import HalfSpace
from approx.variants import approximate
from femic.models import Points
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Load, N, Patch, S, X

FX, FY, FZ, MOMENT = range(4)  # of M; generalized forces are these,
TURN, SPIN = 4, 5  # a moment about z, one about the axle
ENTRIES = (  # of M that are not always 0
    (FX, FX),
    (FY, FY),
    (FZ, FZ),
    (FY, MOMENT),
    (FY, FZ),
    (MOMENT, MOMENT),
    (FZ, MOMENT),
)
AXES = ("x", "y", "z", "phi")
ELEMENTS_AWAY = 3  # centre to centre, where C_jj must equal A_jj
NEAR, RIGHT, LEFT = range(3)  # the first points of `DiscountRule.points`
BESIDE = {+1: (3, 4), -1: (5, 6)}  # those on both sides of the moment load at +-moment_arm


@dataclass(frozen=True)
class DiscountRule:
    """Where M is fitted: loads at s = 0 and `moment_arm`, observers at +-rotation_reach [mm]."""

    a: float
    b: float
    rotation_reach: float
    moment_arm: float

    def load(self, direction: int, s: float = 0.0) -> Load:
        """A load of the rule."""
        return Load(Patch(self.a, self.b, s), direction)

    def moment_load(self, side: int = 1) -> Load:
        """A normal load that turns the body about x."""
        return self.load(N, side * self.moment_arm)

    def points(self, body: Body) -> Points:
        """Three elements away along x, s = +-reach, and as far on both sides of each moment load."""
        low, high = body.contour.extent
        beside = min(self.rotation_reach, high - self.moment_arm, -low - self.moment_arm)
        around = [side * self.moment_arm + d for side in (1, -1) for d in (beside, -beside)]
        s = np.array([0.0, self.rotation_reach, -self.rotation_reach, *around])
        x = np.zeros_like(s)
        x[NEAR] = ELEMENTS_AWAY * 2 * self.a
        return Points(x, s)


@dataclass(frozen=True)
class Condition:
    """One equation for M: `measure` of the displacements (3, n_points) under `loads` must be `target`."""

    entry: tuple[int, int]  # the entry of M that it determines
    loads: tuple[Load, ...]
    measure: Callable[..., float]
    target: float


def rigid_part(m: Array, body: Body, points: Points, load: Load) -> Array:
    """D [mm/N] of a load at the points, shape (3, n)."""
    return discount(m, motions(body, points, load.patch.s))[:, load.direction]


def discount(m: Array, unit: Array) -> Array:
    """D [mm/N] of a body whose compliance is M, from its `motions`, shape (3, 3, n)."""
    return np.tensordot([m[entry] for entry in ENTRIES], unit, axes=1)


def motions(body: Body, points: Points, s_load: float) -> Array:
    """D between points and a load at arc length s [mm], per unit of each of `ENTRIES`; (7, 3, 3, n)."""
    surface = body.surface
    xi = surface.chart_x(points.x, points.s, s_load)
    s_loads = np.full_like(xi, s_load)
    here, there = generalized(body, xi / 2, points.s), generalized(body, -xi / 2, s_loads)  # from half way

    def both(a: int, b: int) -> Array:
        return np.einsum("ip,jp->ijp", here[a], there[b])

    def mutual(a: int, b: int) -> Array:
        return both(a, b) + both(b, a)

    spin, tilt = both(SPIN, SPIN), both(MOMENT, MOMENT) + both(TURN, TURN)
    tilt_with_z = mutual(FZ, MOMENT) - mutual(FX, TURN)
    turned, turned_with_z = _section_turns(body, points.s, s_loads, xi / body.rolling_radius)
    lean = body.side / body.rolling_radius
    by_entry = {
        (FX, FX): spin,
        (FY, FY): both(FY, FY),
        (FZ, FZ): both(FX, FX) + both(FZ, FZ) - spin,
        (FY, MOMENT): mutual(FY, MOMENT) + lean * (tilt - turned),
        (FY, FZ): mutual(FY, FZ) + lean * (tilt_with_z - turned_with_z),
        (MOMENT, MOMENT): turned,
        (FZ, MOMENT): turned_with_z,
    }
    return np.stack([by_entry[entry] for entry in ENTRIES])


def generalized(body: Body, xi: ArrayLike, s: ArrayLike) -> Array:
    """Generalized forces of unit loads in the local directions at (xi, s), shape (6, 3, n).

    Forces along x, y, z, moments about x and z through the contact centre at xi = 0, and the moment
    about the axle over that of a force along x at the contact centre.
    """
    surface = body.surface
    force = np.swapaxes(surface.axes(xi, s), 0, 1)  # (component, direction, n)
    moment = np.cross(surface.position(xi, s)[:, None], force, axis=0)
    spin = np.zeros_like(force[:1])
    spin[:, X] = 1 - body.side * body.contour.position(s)[1] / body.rolling_radius
    return np.concatenate([force, moment[:1], moment[2:], spin])


def _section_turns(body: Body, s: Array, s_load: Array, angle: Array) -> tuple[Array, Array]:
    """Turns of sections about their contact centres, (3, 3, n): under moments there, under forces along z.

    The turn of the load's section is seen, at some angle about the axle, as one about x and one about z.
    """
    here, there = (_in_own_section(body, at) for at in (s, s_load))
    sin, cos = np.sin(angle), np.cos(angle)
    seen_here, seen_there = cos * here.moment + sin * here.lever, cos * there.moment - sin * there.lever

    def outer(of_observer: Array, of_load: Array) -> Array:
        return np.einsum("ip,jp->ijp", of_observer, of_load)

    turned = outer(seen_here, there.moment) - outer(here.moment, sin * there.lever)
    return turned, outer(seen_here, there.radial) + outer(here.radial, seen_there)


@dataclass(frozen=True)
class _InSection:
    """Of unit loads x, s, n, (3, n) each: moment about x at the section's contact centre, force along z.

    `lever` is y of a load along x, with the sign of the turn about z that it sees.
    """

    moment: Array
    radial: Array
    lever: Array


def _in_own_section(body: Body, s: Array) -> _InSection:
    forces = generalized(replace(body, rolling_radius=np.inf, hub_radius=None), np.zeros_like(s), s)
    lever = np.zeros_like(forces[0])
    lever[X] = body.side * body.contour.position(s)[0]
    return _InSection(forces[MOMENT], forces[FZ], lever)


def conditions(body: Body, rule: DiscountRule, loads: tuple[Load, ...]) -> list[Condition]:
    """What determines the entries of M that concern the given loads.

    C_jj = A_jj three elements away along x; under the lateral load u_z(reach) - u_z(-reach) equals
    that of A_ns on a plane. Off-centre loads need all entries, also phi-phi: under a normal load at
    the moment arm, the part of C_nn that is antisymmetric about the load is that of B-hat. In
    sections without symmetry, which couple s and n: the first difference vanishes under the normal
    load, C_sn + C_ns does three elements away, and phi-phi is fitted to moment loads on both sides. A load
    along x moves a prismatic body along x only; from elsewhere on a wheel, that is a motion along z, too.
    """
    directions = {load.direction for load in loads}
    in_section = directions if np.isfinite(body.rolling_radius) else directions - {X}
    off_centre = any(load.patch.s != 0 and load.direction in in_section for load in loads)
    coupled = not body.contour.symmetric and bool(in_section)
    lateral = S in directions or coupled or off_centre
    normal = bool(in_section - {S}) or coupled or off_centre
    found: list[Condition] = []
    if X in directions:
        found.append(_near(body, rule, X))
    if lateral:
        found += [_near(body, rule, S), _tilt_under_lateral_load(body, rule)]
    if normal:
        found.append(_near(body, rule, N))
    if coupled:
        found += [_tilt_under_normal_load(body, rule), _coupling(rule)]
    if off_centre:
        found.append(_turning(body, rule))
    return found


def observers(body: Body, rule: DiscountRule, fit: list[Condition]) -> Points:
    """The rule's points that the conditions look at: those beside moment loads only if there are any."""
    points = rule.points(body)
    n = len(points.x) if any(c.entry == (MOMENT, MOMENT) for c in fit) else len((NEAR, RIGHT, LEFT))
    return Points(points.x[:n], points.s[:n])


def fit_discount(body: Body, rule: DiscountRule, fit: list[Condition], u: Mapping[Load, Array]) -> Array:
    """M [mm/N, 1/N, 1/(N mm)], shape (4, 4), from displacements (3, n) at the observers.

    Entries that no condition determines are 0.
    """
    if not fit:
        return np.zeros((4, 4))
    points = rule.points(body)
    entries = [_symmetric_entry(condition.entry) for condition in fit]
    matrix = [
        [c.measure(*(rigid_part(entry, body, points, load) for load in c.loads)) for entry in entries]
        for c in fit
    ]
    defects = [c.measure(*(u[load] for load in c.loads)) - c.target for c in fit]
    return np.asarray(np.tensordot(np.linalg.solve(matrix, defects), entries, axes=1))


def _near(body: Body, rule: DiscountRule, j: int) -> Condition:
    """C_jj = A_jj three elements away; j = 0, 1, 2 turns the entries xx, yy, zz."""
    a = _half_space("A", body, rule.load(j).patch, rule.points(body))
    return Condition((j, j), (rule.load(j),), lambda u: float(u[j, NEAR]), float(a[j, j, NEAR]))


def _tilt_under_lateral_load(body: Body, rule: DiscountRule) -> Condition:
    a = _half_space("A", body, rule.load(S).patch, rule.points(body))
    target = float(a[N, S, RIGHT] - a[N, S, LEFT])
    return Condition((FY, MOMENT), (rule.load(S),), lambda u: _tilt(body, rule, u), target)


def _tilt_under_normal_load(body: Body, rule: DiscountRule) -> Condition:
    return Condition((FZ, MOMENT), (rule.load(N),), lambda u: _tilt(body, rule, u), 0.0)


def _tilt(body: Body, rule: DiscountRule, u: Array) -> float:
    """u_z(reach) - u_z(-reach) at x = 0."""
    ends = [RIGHT, LEFT]
    to_vertical = body.surface.axes(0.0, rule.points(body).s[ends])[:, FZ]  # (3 directions, 2)
    right, left = np.sum(to_vertical * u[:, ends], axis=0)
    return float(right - left)


def _coupling(rule: DiscountRule) -> Condition:
    def measure(u_n: Array, u_s: Array) -> float:
        return float(u_n[S, NEAR] + u_s[N, NEAR])

    return Condition((FY, FZ), (rule.load(N), rule.load(S)), measure, 0.0)


def _turning(body: Body, rule: DiscountRule) -> Condition:
    sides = (1,) if body.contour.symmetric else (1, -1)
    loads = tuple(rule.moment_load(side) for side in sides)

    def antisymmetric(*u: Array) -> float:
        """C_nn further out minus C_nn further in, summed over the loads."""
        return float(
            sum(
                side * (v[N, BESIDE[side][0]] - v[N, BESIDE[side][1]])
                for side, v in zip(sides, u, strict=True)
            )
        )

    b_hat = [_half_space("Bhat", body, load.patch, rule.points(body))[:, N] for load in loads]
    return Condition((MOMENT, MOMENT), loads, antisymmetric, antisymmetric(*b_hat))


def _half_space(variant: str, body: Body, patch: Patch, points: Points) -> Array:
    half_space = HalfSpace(one_body(body.material, body.side))
    return approximate(variant, half_space, body.surface, patch, (points.x, points.s)) / patch.area


def _symmetric_entry(entry: tuple[int, int]) -> Array:
    m = np.zeros((4, 4))
    m[entry] = m[entry[::-1]] = 1.0
    return m
