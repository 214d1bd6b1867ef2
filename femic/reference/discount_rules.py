"""Rules that determine the compliance M of the rigid-body discount, and so which motions count as rigid.

- `SourceRule` makes ICs of one load comparable with ICs of half-spaces, as [BVSV] section 5.1 does: M has all
  of its entries, including the ones that bend a slender section under a load beside its crown.
- `ApproachRule` subtracts only the rigid part of the normal approach, M_zz. The rest of the response of the
  bodies and their supports, bending included, is elastic and local, and contact needs it.
- `NoRule` subtracts nothing.

The approach is matched at the load itself. C_nn - A_nn is not smooth there: near a load on a body with mean
curvature kappa / 2 (kappa is the sum of both principal curvatures, positive where the body is convex) it
varies as -(1 - 2 nu)^2 kappa / (8 pi G) ln r. So the limit of small loads exists only for the sum of two
bodies with equal profiles, where the logarithms cancel, and M_zz is matched under a load of fixed size, which
does not depend on the elements. (`tests/femic/reference/test_discount_rules.py` checks the coefficient.)
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from approx.pair import Solid
from femic.reference.discount import FY, FZ, MOMENT, Condition
from femic.reference.models import Points
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.patches import Load, N, Patch, S, X

ELEMENTS_AWAY = 3  # distance in elements, centre to centre, at which the source has C_jj = A_jj
Z = 2  # number of the global axis z
NEAR, RIGHT, LEFT = range(3)  # the first points of `SourceRule.points`
BESIDE_LOAD = {+1: (3, 4), -1: (5, 6)}  # the points on both sides of the moment load at +-moment_arm


@dataclass(frozen=True)
class NoRule:
    """Nothing is subtracted."""

    def points(self, body: Body) -> Points:  # noqa: ARG002 (none, of any body)
        """No observer."""
        return Points(np.empty(0), np.empty(0))

    def conditions(self, body: Body, loads: Sequence[Load]) -> list[Condition]:  # noqa: ARG002
        """No condition."""
        return []

    def observers(self, body: Body, fit: Sequence[Condition]) -> Points:  # noqa: ARG002
        """No observer."""
        return self.points(body)


@dataclass(frozen=True)
class ApproachRule:
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

    def observers(self, body: Body, fit: Sequence[Condition]) -> Points:  # noqa: ARG002 (all that there are)
        """The observer at the centre of the load."""
        return self.points(body)


@dataclass(frozen=True)
class SourceRule:
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
        needed: list[Condition] = []
        if X in directions:
            needed.append(_near(body, self, X))
        if lateral:
            needed += [_near(body, self, S), _tilt_under_lateral_load(body, self)]
        if normal:
            needed.append(_near(body, self, N))
        if coupled:
            needed += [_tilt_under_normal_load(body, self), _coupling(self)]
        if off_centre:
            needed.append(_turning(body, self))
        return needed

    def observers(self, body: Body, fit: Sequence[Condition]) -> Points:
        """The points that the conditions read; those beside moment loads only where they are used."""
        points = self.points(body)
        turning = any(condition.entry == (MOMENT, MOMENT) for condition in fit)
        used = slice(None if turning else len((NEAR, RIGHT, LEFT)))
        return Points(points.x[used], points.s[used])


def _near(body: Body, rule: SourceRule, j: int) -> Condition:
    """C_jj = A_jj three elements away; j = 0, 1, 2 determines the entry xx, yy, zz."""
    a = half_space("A", body, rule.load(j).patch, rule.points(body))
    return Condition((j, j), (rule.load(j),), lambda u: float(u[j, NEAR]), float(a[j, j, NEAR]))


def _tilt_under_lateral_load(body: Body, rule: SourceRule) -> Condition:
    """Under the lateral load u_z(reach) - u_z(-reach) equals that of A_ns on a plane."""
    a = half_space("A", body, rule.load(S).patch, rule.points(body))
    target = float(a[N, S, RIGHT] - a[N, S, LEFT])
    return Condition((FY, MOMENT), (rule.load(S),), lambda u: _tilt(body, rule, u), target)


def _tilt_under_normal_load(body: Body, rule: SourceRule) -> Condition:
    """Under the normal load u_z(reach) - u_z(-reach) vanishes."""
    return Condition((FZ, MOMENT), (rule.load(N),), lambda u: _tilt(body, rule, u), 0.0)


def _tilt(body: Body, rule: SourceRule, u: Array) -> float:
    """u_z(reach) - u_z(-reach) at x = 0, of displacements u (3, n_points) at the observers."""
    ends = [RIGHT, LEFT]
    to_vertical = body.surface.axes(0.0, rule.points(body).s[ends])[:, Z]  # (3 directions, 2)
    right, left = np.sum(to_vertical * u[:, ends], axis=0)
    return float(right - left)


def _coupling(rule: SourceRule) -> Condition:
    """C_sn + C_ns vanishes three elements away."""

    def measure(u_n: Array, u_s: Array) -> float:
        return float(u_n[S, NEAR] + u_s[N, NEAR])

    return Condition((FY, FZ), (rule.load(N), rule.load(S)), measure, 0.0)


def _turning(body: Body, rule: SourceRule) -> Condition:
    """Under moment loads the part of C_nn antisymmetric about the load equals the same part of B-hat."""
    sides = (1,) if body.symmetric else (1, -1)
    loads = tuple(rule.moment_load(side) for side in sides)

    def antisymmetric(*u: Array) -> float:
        """C_nn further out minus C_nn further in, summed over the loads."""
        return float(
            sum(
                side * (displacements[N, BESIDE_LOAD[side][0]] - displacements[N, BESIDE_LOAD[side][1]])
                for side, displacements in zip(sides, u, strict=True)
            )
        )

    b_hat = [half_space("Bhat", body, load.patch, rule.points(body))[:, N] for load in loads]
    return Condition((MOMENT, MOMENT), loads, antisymmetric, antisymmetric(*b_hat))


def half_space(variant: str, body: Body, patch: Patch, points: Points) -> Array:
    """ICs [mm/N] of an approximation at points, shape (3, 3, n)."""
    return Solid(body.material, body.surface).approximate(variant, patch, (points.x, points.s)) / patch.area
