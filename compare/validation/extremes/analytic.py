"""The analytic ICs at their limits, compared with formulas in many digits.

These formulas are separate ones of the ICs of a half-space and of rotations: corner sums, matrix products.
Cases are the corners of the ranges, and further ones drawn by hypothesis. These are reproducible, but depend
on the code and on the loaded modules, since hypothesis also uses constants of them.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, TypeAlias

import mpmath
import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from approx.forms import rotation_between
from approx.pair import Pair, Solid
from compare.validation.extremes.cases import ANALYTIC, BeyondLimit, Limit, WithinLimit, refusal
from femic.reference.run_options import RunOptions
from geometries.contours import arc, plane
from geometries.materials import Material
from geometries.patches import Patch
from geometries.surfaces import LOWER, UPPER, Surface

# --- formulas in many digits ----------------------------------------------------------------------------


Number: TypeAlias = Any  # a number of mpmath, which has no types

DIGITS = 300  # corner sums lose r^2 / (a b), 1e20 * 1e12, and near each of both axes 1e-60


def exact_integrals(patch: Patch, x: float, s: float) -> list[Number]:
    """Return I_xx, I_ss, I_xs, J_x, J_s [mm], integrals over a patch at (x, s) [mm], as sums over corners.

    Those that vanish by symmetry are exactly 0.
    """
    with mpmath.workdps(DIGITS):
        a, b, at_x, at_s = (mpmath.mpf(float(v)) for v in (patch.a, patch.b, x, s))
        total = [mpmath.mpf(0)] * 5
        for i, j in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            corner_terms = _at_corner(at_x + i * a, at_s + j * b)
            total = [t + i * j * v for t, v in zip(total, corner_terms, strict=True)]
    vanishes = (False, False, x == 0 or s == 0, x == 0, s == 0)
    return [mpmath.mpf(0) if zero else v for zero, v in zip(vanishes, total, strict=True)]


def _at_corner(X: Number, S: Number) -> list[Number]:
    R = mpmath.sqrt(X * X + S * S)
    log = mpmath.log(R) if R else mpmath.mpf(0)
    return [
        S * mpmath.asinh(X / abs(S)) if S else mpmath.mpf(0),
        X * mpmath.asinh(S / abs(X)) if X else mpmath.mpf(0),
        -R,
        S * log + (X * mpmath.atan(S / X) if X else 0),
        X * log + (S * mpmath.atan(X / S) if S else 0),
    ]


def one_body(material: Material, side: int, integral_values: Sequence[Number]) -> list[list[Number]]:
    """Return A of one body [mm/MPa], 3 x 3, from the integrals [mm]."""
    with mpmath.workdps(DIGITS):
        E, nu = mpmath.mpf(material.E), mpmath.mpf(material.nu)
        scale = (1 + nu) / (mpmath.pi * E)  # 1 / (2 pi G)
        I_xx, I_ss, I_xs, J_x, J_s = integral_values
        nn = scale * (1 - nu) * (I_xx + I_ss)
        xn, sn = (-scale * side * (1 - 2 * nu) / 2 * J for J in (J_x, J_s))
        xs = scale * nu * I_xs
        return [[nn + scale * nu * I_xx, xs, xn], [xs, nn + scale * nu * I_ss, sn], [-xn, -sn, nn]]


def rotation(delta_i: float, delta_j: float, theta: float, side: int) -> Number:
    """Return the rotation T = R_x(delta_I) R_y(side theta) R_x(-delta_J), a 3 x 3 matrix; angles in rad."""

    def about_x(angle: float) -> Number:
        c, s = mpmath.cos(angle), mpmath.sin(angle)
        return mpmath.matrix([[1, 0, 0], [0, c, -s], [0, s, c]])

    with mpmath.workdps(DIGITS):
        angle = side * mpmath.mpf(theta)
        c, s = mpmath.cos(angle), mpmath.sin(angle)
        about_y = mpmath.matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        return about_x(delta_i) * about_y * about_x(-delta_j)


# --- limits ---------------------------------------------------------------------------------------------


DRAWN_CASES = 150  # cases that hypothesis draws for each parameter
SMALLEST_NONZERO = 1e-60  # smaller values are drawn as 0: the digits would not suffice
DRAWING = settings(
    max_examples=DRAWN_CASES,
    derandomize=True,
    deadline=None,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)
IN_DIGITS = f"{DIGITS} digits"


@dataclass(frozen=True)
class HalfSpaces:
    """Two half-spaces, a patch, and an observer whose place is given in half-sides of the patch."""

    nu: float = 0.28
    size: float = 0.3  # b [mm]
    aspect: float = 0.7  # a / b
    x: float = 0.4  # over a
    s: float = -1.7  # over b
    ratio: float = 1.0  # E of the upper body over E of the lower body

    def error(self) -> float:
        """Return the largest relative error of a component of A of both bodies [-].

        It is infinite if a component that vanishes is not computed as 0.
        """
        patch = Patch(self.size * self.aspect, self.size)
        x, s = self.x * patch.a, self.s * patch.b
        lower, upper = Material(210e3, self.nu), Material(210e3 * self.ratio, self.nu / 2)
        pair = Pair(Solid(upper, Surface(UPPER, plane())), Solid(lower, Surface(LOWER, plane())))
        ics = pair.approximate("A", patch, (np.array(x), np.array(s)))
        integrals = exact_integrals(patch, x, s)
        bodies = one_body(upper, UPPER, integrals), one_body(lower, LOWER, integrals)
        return max(
            _relative(float(ics[i, j]), [body_ics[i][j] for body_ics in bodies]) for i, j in np.ndindex(3, 3)
        )


def _relative(computed: float, parts: list[Number]) -> float:
    """Return the error of a sum as a share of the sum of the sizes of its parts."""
    size = sum(abs(part) for part in parts)
    if size == 0:
        return 0.0 if computed == 0 else np.inf
    with mpmath.workdps(DIGITS):
        return float(abs(computed - sum(parts)) / size)


@dataclass(frozen=True)
class RotatedElements:
    """Two elements on a surface of revolution, or on a prismatic one."""

    flank: float = 60.0  # degrees
    rolling_radius: float = np.inf
    x: float = 3.0  # mm
    s: float = 4.0
    s_load: float = -7.0
    side: int = UPPER

    def error(self) -> float:
        """Return the largest error of an entry of the rotation T between the two elements [-]."""
        angle = np.radians(self.flank)
        surface = Surface(self.side, arc(10.0, angle, angle), self.rolling_radius)
        computed = rotation_between(surface, (np.array(self.x), np.array(self.s)), self.s_load).matrix
        z = surface.contour.position(np.array([self.s, self.s_load]))[1].mean()
        theta = self.x / (self.rolling_radius - self.side * z)
        delta_i, delta_j = surface.contour.inclination(np.array([self.s, self.s_load]))
        expected = rotation(float(delta_i), float(delta_j), theta, self.side)
        return max(float(abs(float(computed[i, j]) - expected[i, j])) for i, j in np.ndindex(3, 3))


Case = HalfSpaces | RotatedElements
BeyondCase = Callable[[RunOptions], BeyondLimit]


def limits() -> list[Limit]:
    """Return the limits of the analytic ICs, with cases within and beyond them."""
    near, decades = st.floats(-3, 3).map(_or_zero), st.floats(-6, 6)
    half = HalfSpaces()
    at = st.builds(lambda x, s: replace(half, x=x, s=s), near, near)
    nu = st.builds(lambda case, nu: replace(case, nu=nu), at, st.floats(0, 0.5).map(_or_zero))
    aspect = st.builds(lambda case, exponent: replace(case, aspect=10**exponent), at, decades)
    ratio = st.builds(lambda case, exponent: replace(case, ratio=10**exponent), at, decades)
    far = st.builds(_at_distance, st.floats(-3, 10), st.floats(1e-9, 6.28))
    at_s = st.floats(-20, 20)
    sides = st.sampled_from([1, -1])
    flanks = st.builds(RotatedElements, st.floats(0, 89.9), st.just(np.inf), near, at_s, at_s, sides)
    radii = st.floats(1.4, 12).map(lambda exponent: 10**exponent)
    wheels = st.builds(RotatedElements, st.just(30.0), radii, near, at_s, at_s, st.just(UPPER))
    extremes, places = (10.0**-6, 10.0**6), (0.0, 1.0, 1e10)
    return [
        _limit(
            "ν",
            "0 … 0.5",
            nu,
            [replace(half, nu=v) for v in (0.0, 0.5)],
            refusal("ν = 0.51", lambda _: replace(half, nu=0.51).error()),
        ),
        _limit(
            "patch aspect a/b",
            "1e-6 … 1e6",
            aspect,
            [replace(half, aspect=value, x=x) for value in extremes for x in (0.0, 1.0, 1 + 1e-12)],
            _computed("a/b = 1e9", replace(half, aspect=1e9)),
        ),
        _limit(
            "distance / patch",
            "0 … 1e10",
            far,
            [replace(half, x=x, s=s) for x in places for s in places],
            _computed("1e14", replace(half, x=1e14, s=-1e14)),
            refusal("lengths of 1e80 mm", lambda _: replace(half, size=1e80).error()),
        ),
        _limit("flank inclination", "any", flanks, [RotatedElements(89.9, s=100.0, s_load=-100.0)]),
        _limit(
            "R_roll",
            "any",
            wheels,
            [RotatedElements(30.0, radius) for radius in (25.0, 1e12, np.inf)],
            refusal("R_roll = -1 mm", lambda _: RotatedElements(rolling_radius=-1.0).error()),
        ),
        _limit(
            "modulus ratio",
            "1e-6 … 1e6",
            ratio,
            [replace(half, ratio=value) for value in extremes],
            _computed("1e12", replace(half, ratio=1e12)),
        ),
    ]


def _or_zero(value: float) -> float:
    return value if abs(value) > SMALLEST_NONZERO else 0.0


def _at_distance(decades: float, angle: float) -> HalfSpaces:
    r = 10**decades
    return HalfSpaces(x=r * float(np.cos(angle)), s=r * float(np.sin(angle)))


def _limit(
    name: str, allowed: str, strategy: st.SearchStrategy[Case], corners: Sequence[Case], *beyond: BeyondCase
) -> Limit:
    """Return a limit whose cases are corners of the range, and those that hypothesis draws."""
    reached = [lambda _: _worst(f"{len(corners)} corners", corners), lambda _: _drawn_cases(strategy)]
    return Limit(ANALYTIC, name, allowed, reached, beyond)


def _worst(label: str, cases: Iterable[Case]) -> WithinLimit:
    """Return the largest error of several cases, with the mean seconds of a case."""
    start = perf_counter()
    errors = [case.error() for case in cases]
    return WithinLimit(label, max(errors), None, None, IN_DIGITS, (perf_counter() - start) / len(errors))


def _drawn_cases(strategy: st.SearchStrategy[Case]) -> WithinLimit:
    """Return the largest error of cases that hypothesis draws from a strategy."""
    cases: list[Case] = []

    @DRAWING
    @given(strategy)
    def draw(case: Case) -> None:
        cases.append(case)

    draw()
    return _worst(f"{len(cases)} drawn", cases)


def _computed(label: str, case: HalfSpaces) -> BeyondCase:
    """Return a case beyond the limits that is computed nevertheless, with its error."""
    return lambda _: BeyondLimit(label, f"computed: error {case.error():.0e}", computed=True)
