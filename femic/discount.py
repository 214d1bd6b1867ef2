"""The rigid-body discount: what a far support adds to the displacements, and its subtraction.

Far from the contact a body moves rigidly, by a symmetric compliance. D[I, J] = Phi(I)^T M Phi(J) is
subtracted: Phi(J) carries a unit load at J to its wrench (forces along x, y, z and the moment about
the x axis through the contact centre), Phi(I)^T a rigid motion to the local displacement at I. M is
one symmetric matrix per body, so reciprocity is kept; on a wheel x and z are those half way between I and
J. Source: [BVSV] section 5.1, design section 4.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from approx.halfspace import HalfSpace
from approx.variants import approximate
from femic.models import Points
from femic.symmetry import N, S, X
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Load, Patch

Array = NDArray[np.float64]

FX, FY, FZ, MOMENT = range(4)
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


def wrench(body: Body, xi: ArrayLike, s: ArrayLike) -> Array:
    """Phi: wrench of unit loads in the local directions at (xi, s), shape (4, 3, n)."""
    force = np.swapaxes(body.surface.axes(xi, s), 0, 1)  # (component, direction, n)
    _, y, z = body.surface.position(xi, s)
    return np.concatenate([force, (y * force[2] - z * force[1])[None]])


def rigid_part(m: Array, body: Body, points: Points, load: Load) -> Array:
    """D = Phi(I)^T M Phi(J) [mm/N] of a load at the points, shape (3, n)."""
    observer, of_load = wrenches(body, points, load.patch.s)
    return np.einsum("aip,ab,bp->ip", observer, m, of_load[:, load.direction])


def wrenches(body: Body, points: Points, s_load: float) -> tuple[Array, Array]:
    """Wrenches (4, 3, n) of unit loads at points and at the load, seen from half way between them.

    On a body of revolution each other place would break reciprocity: M turns with the place.
    """
    half = body.surface.chart_x(points.x, points.s, s_load) / 2
    return wrench(body, half, points.s), wrench(body, -half, np.full_like(half, s_load))


def conditions(body: Body, rule: DiscountRule, loads: tuple[Load, ...]) -> list[Condition]:
    """What determines the entries of M that concern the given loads.

    C_jj = A_jj three elements away along x; under the lateral load u_z(reach) - u_z(-reach) equals
    that of A_ns on a plane. Off-centre loads need all entries, also phi-phi: under a normal load at
    the moment arm, the part of C_nn that is antisymmetric about the load is that of B-hat. In
    sections without symmetry, which couple s and n: the first difference vanishes under the normal
    load, C_sn + C_ns does three elements away, and phi-phi is fitted to moment loads on both sides.
    """
    directions = {load.direction for load in loads}
    off_centre = any(load.patch.s != 0 and load.direction != X for load in loads)
    coupled = not body.contour.symmetric and not directions.isdisjoint({S, N})
    lateral, normal = (d in directions or coupled or off_centre for d in (S, N))
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
