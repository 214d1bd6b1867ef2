"""The analytic ICs at their extremes, against formulas in many digits: corners, and cases of hypothesis."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from approx.orientation import turn_between
from approx.pair import Pair, Solid
from compare.studies.extremes import exact
from compare.studies.extremes.drawing import drawing
from compare.studies.extremes.found import ANALYTIC, Beyond, Parameter, Reached
from geometries.contours import arc, plane
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.patches import Patch
from geometries.surfaces import LOWER, UPPER, Surface

EXAMPLES = 150  # drawn for each parameter
LEAST = 1e-60  # what is smaller is drawn as 0, or the many digits would not do
IN_DIGITS = f"{exact.DIGITS} digits"


@dataclass(frozen=True)
class HalfSpaces:
    """Two half-spaces, a patch, an observer (in patches of either side), and ratios of sizes."""

    nu: float = 0.28
    size: float = 0.3  # b [mm]
    aspect: float = 0.7  # a / b
    x: float = 0.4  # over a
    s: float = -1.7  # over b
    ratio: float = 1.0  # E of the upper over that of the lower body

    def error(self) -> float:
        """Largest relative error of a component of A of both bodies; what vanishes must be 0."""
        patch = Patch(self.size * self.aspect, self.size)
        x, s = self.x * patch.a, self.s * patch.b
        lower, upper = Material(210e3, self.nu), Material(210e3 * self.ratio, self.nu / 2)
        pair = Pair(Solid(upper, Surface(UPPER, plane())), Solid(lower, Surface(LOWER, plane())))
        got = pair.approximate("A", patch, (np.array(x), np.array(s)))
        of = exact.integrals(patch, x, s)
        bodies = exact.one_body(upper, UPPER, of), exact.one_body(lower, LOWER, of)
        return max(_relative(float(got[i, j]), [one[i][j] for one in bodies]) for i, j in np.ndindex(3, 3))


def _relative(got: float, parts: list[exact.Number]) -> float:
    """Error of a sum, as a share of the sum of the sizes of its parts."""
    size = sum(abs(part) for part in parts)
    if size == 0:
        return 0.0 if got == 0 else np.inf
    with exact.many_digits():
        return float(abs(got - sum(parts)) / size)


@dataclass(frozen=True)
class Turned:
    """Two elements on a surface of revolution."""

    flank: float = 60.0  # degrees
    rolling_radius: float = np.inf
    x: float = 3.0  # mm
    s: float = 4.0
    s_load: float = -7.0
    side: int = UPPER

    def error(self) -> float:
        """Largest error of an entry of T."""
        angle = np.radians(self.flank)
        surface = Surface(self.side, arc(10.0, angle, angle), self.rolling_radius)
        got = turn_between(surface, (np.array(self.x), np.array(self.s)), self.s_load).matrix
        z = surface.contour.position(np.array([self.s, self.s_load]))[1].mean()
        theta = self.x / (self.rolling_radius - self.side * z)
        delta_i, delta_j = surface.contour.inclination(np.array([self.s, self.s_load]))
        truth = exact.turn(float(delta_i), float(delta_j), theta, self.side)
        return max(float(abs(float(got[i, j]) - truth[i, j])) for i, j in np.ndindex(3, 3))


Case = HalfSpaces | Turned
Untried = Callable[[], Beyond]


def parameters() -> list[Parameter]:
    """All rows of the analytic column."""
    within = st.floats(-3, 3).map(_or_zero)
    half = HalfSpaces()
    near = st.builds(lambda x, s: replace(half, x=x, s=s), within, within)
    nu = st.builds(lambda case, nu: replace(case, nu=nu), near, st.floats(0, 0.5).map(_or_zero))
    aspect = st.builds(lambda case, e: replace(case, aspect=10**e), near, st.floats(-6, 6))
    ratio = st.builds(lambda case, e: replace(case, ratio=10**e), near, st.floats(-6, 6))
    far = st.builds(_at_distance, st.floats(-3, 10), st.floats(1e-9, 6.28))
    turns = st.builds(
        Turned, st.floats(0, 89.9), st.just(np.inf), within, _s(), _s(), st.sampled_from([1, -1])
    )
    wheels = st.builds(
        lambda e, *rest: Turned(30.0, 10**e, *rest), st.floats(1.4, 12), within, _s(), _s(), st.just(UPPER)
    )
    return [
        _row("ν", "0 … 0.5", nu, [replace(half, nu=v) for v in (0.0, 0.5)], [_refused("ν = 0.51", _nu)]),
        _row(
            "patch aspect a/b",
            "1e-6 … 1e6",
            aspect,
            [replace(half, aspect=10.0**e, x=x) for e in (-6, 6) for x in (0.0, 1.0, 1 + 1e-12)],
            [_computed("a/b = 1e9", replace(half, aspect=1e9))],
        ),
        _row(
            "distance / patch",
            "0 … 1e10",
            far,
            [replace(half, x=x, s=s) for x in (0.0, 1.0, 1e10) for s in (0.0, 1.0, 1e10)],
            [
                _computed("1e14", replace(half, x=1e14, s=-1e14)),
                _refused("lengths of 1e80 mm", lambda: replace(half, size=1e80).error()),
            ],
        ),
        _row("flank inclination", "any", turns, [Turned(89.9, s=100.0, s_load=-100.0)], []),
        _row(
            "R_roll",
            "any",
            wheels,
            [Turned(30.0, radius) for radius in (25.0, 1e12, np.inf)],
            [_refused("R_roll = -1 mm", lambda: Turned(rolling_radius=-1.0).error())],
        ),
        _row(
            "modulus ratio",
            "1e-6 … 1e6",
            ratio,
            [replace(half, ratio=10.0**e) for e in (-6, 6)],
            [_computed("1e12", replace(half, ratio=1e12))],
        ),
    ]


def _or_zero(value: float) -> float:
    return value if abs(value) > LEAST else 0.0


def _s() -> st.SearchStrategy[float]:
    return st.floats(-20, 20)


def _at_distance(decades: float, angle: float) -> HalfSpaces:
    r = 10**decades
    return HalfSpaces(x=r * float(np.cos(angle)), s=r * float(np.sin(angle)))


def _nu() -> object:
    return Material(210e3, 0.51)


def _row(
    name: str,
    allowed: str,
    drawn: st.SearchStrategy[Case],
    corners: Iterable[Case],
    beyond: Sequence[Untried],
) -> Parameter:
    cases = list(corners)
    reached = [lambda: _worst(f"{len(cases)} corners", cases), lambda: _drawn(drawn)]
    return Parameter(ANALYTIC, name, allowed, reached, beyond)


def _worst(at: str, cases: Iterable[Case]) -> Reached:
    """The largest error of some cases, and the seconds of one."""
    start = perf_counter()
    errors = [case.error() for case in cases]
    return Reached(at, max(errors), None, None, IN_DIGITS, (perf_counter() - start) / len(errors))


def _drawn(strategy: st.SearchStrategy[Case]) -> Reached:
    """The largest error of the cases that hypothesis draws."""
    cases: list[Case] = []

    @drawing(EXAMPLES)
    @given(strategy)
    def draw(case: Case) -> None:
        cases.append(case)

    draw()
    return _worst(f"{len(cases)} drawn", cases)


def _refused(at: str, call: Callable[[], object]) -> Untried:
    def case() -> Beyond:
        try:
            call()
        except WrongInput as error:
            return Beyond(at, str(error))
        return Beyond(at, "")

    return case


def _computed(at: str, case: HalfSpaces) -> Untried:
    """Beyond what was asked for, and still right."""
    return lambda: Beyond(at, f"computed: error {case.error():.0e}")
