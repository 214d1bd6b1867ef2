"""Benchmarks of the analytic ICs: digits and seconds (docs/evidence/accuracy.md, performance.md).

    python benchmarks/analytic.py [accuracy] [speed] [hat] [library] [--record]

accuracy  digits of the exact form and of the corner sums against 120-digit arithmetic
speed     nanoseconds per point and set of nine components: textbook form, exact form, lag grid, variants
hat       bilinear elements: errors against a finer rule, microseconds per point
library   the half-space kernels of slippy, if it is installed: error and nanoseconds
"""

from collections.abc import Callable, Iterator, Sequence
from time import perf_counter
from tracemalloc import get_traced_memory, start, stop

import numpy as np
from tables import Record, arguments, print_table

from approx import kernels as hat
from approx import kernels as rectangle
from approx.effective import EffectiveProperties, Transition
from approx.halfspace import HalfSpace, ics_from_integrals
from approx.variants import VARIANTS, approximate
from compare.validation.extremes import analytic as exact
from geometries.contours import arc
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch
from geometries.surfaces import UPPER, Surface

Array = np.ndarray
Form = Callable[[Patch, Array, Array], Array]
Case = tuple[Patch, float, float]
STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
PATCH = Patch(0.2, 0.3)
POINTS = 200_000
LAGS = (512, 400)
REPETITIONS = 7


def textbook(patch: Patch, x: Array, s: Array) -> Array:
    """Return the sums of logarithms over the corners, as they are usually programmed."""
    total = np.zeros((5, *x.shape))
    for i in (1, -1):
        for j in (1, -1):
            X, S = x + i * patch.a, s + j * patch.b
            R = np.sqrt(X * X + S * S)
            log = np.log(R)
            parts = (
                S * np.log(X + R),
                X * np.log(S + R),
                -R,
                S * log + X * np.arctan(S / X),
                X * log + S * np.arctan(X / S),
            )
            for row, part in enumerate(parts):
                total[row] += i * j * part
    return total


def seconds(call: Callable[[], object]) -> float:
    times = []
    for _ in range(REPETITIONS):
        begin = perf_counter()
        call()
        times.append(perf_counter() - begin)
    return min(times)


def megabytes(call: Callable[[], object]) -> float:
    start()
    call()
    peak = get_traced_memory()[1]
    stop()
    return peak / 2**20


# --- accuracy ------------------------------------------------------------------------------------------


def worst_error(form: Form, cases: Sequence[Case]) -> float:
    """Return largest relative error of the nine components of one steel body; infinite where it is nan."""
    constants, worst = one_body(STEEL, UPPER), 0.0
    with np.errstate(all="ignore"):
        for patch, x, s in cases:
            integrals = np.array([float(v) for v in exact.exact_integrals(patch, x, s)])
            truth = ics_from_integrals(constants, integrals)
            got = ics_from_integrals(constants, form(patch, np.array(x), np.array(s)))
            errors = np.abs(got - truth)[truth != 0] / np.abs(truth[truth != 0])
            worst = max(worst, float(np.max(np.where(np.isnan(errors), np.inf, errors))))
    return worst


def shown(error: float) -> str:
    return f"{error:.0e}" if np.isfinite(error) else "not a number"


def accuracy() -> None:
    rng = np.random.default_rng(0)

    def spread(r: float, patch: Patch = PATCH) -> list[Case]:
        angles = rng.uniform(0, 2 * np.pi, 200)
        return [(patch, r * np.cos(t), r * np.sin(t)) for t in angles]

    groups = {
        "within 3 patches": [(PATCH, *rng.uniform(-1, 1, 2)) for _ in range(200)],
        "100 patches away": spread(40.0),
        "1e4 patches away": spread(4e3),
        "1e8 patches away": spread(4e7),
        "1e10 patches away": spread(4e9),
        "on edge lines": [(PATCH, PATCH.a, v) for v in rng.uniform(-3, 3, 100)],
        "1e-12 beside an edge line": [(PATCH, PATCH.a * (1 + 1e-12), v) for v in rng.uniform(-3, 3, 100)],
        "1e-6 beside an axis": [(PATCH, 1e-6, v) for v in rng.uniform(-3, 3, 100)],
        "aspect 1e6, within 3 patches": [
            (Patch(300.0, 3e-4), u, v) for u, v in rng.uniform(-1, 1, (200, 2)) * [900, 9e-4]
        ],
        "aspect 1e6, 1e4 patches away": spread(3e6, Patch(300.0, 3e-4)),
    }
    print_table(
        ["observers", "textbook form", "femic"],
        (
            [
                name,
                shown(worst_error(textbook, cases)),
                shown(worst_error(rectangle.over_rectangle, cases)),
            ]
            for name, cases in groups.items()
        ),
        record=Record(
            "analytic.digits",
            "Digits of A",
            "Largest relative error of one of the nine components of A (steel) against 120 digits. The "
            "textbook form is the usual sum of logarithms over the corners of the patch.",
            "python benchmarks/analytic.py accuracy",
        ),
    )


# --- speed ---------------------------------------------------------------------------------------------


def speed() -> None:
    rng = np.random.default_rng(0)
    x, s = rng.uniform(-25, 25, (2, POINTS))
    lag_x, lag_s = np.meshgrid(
        2 * PATCH.a * np.arange(LAGS[0]), 2 * PATCH.b * np.arange(LAGS[1]), indexing="ij"
    )
    half_space = HalfSpace(both_bodies(STEEL, BRASS))
    calls = {
        f"textbook form, {POINTS} scattered points": (
            lambda: ics_from_integrals(half_space.constants, textbook(PATCH, x, s)),
            POINTS,
        ),
        f"femic, {POINTS} scattered points": (lambda: half_space.ics(PATCH, x, s), POINTS),
        "textbook form, lags 512 x 400": (
            lambda: ics_from_integrals(half_space.constants, textbook(PATCH, lag_x, lag_s)),
            lag_x.size,
        ),
        "femic, lags 512 x 400": (lambda: half_space.lags(PATCH, *LAGS), lag_x.size),
        "femic, 100 points": (lambda: half_space.ics(PATCH, x[:100], s[:100]), 100),
    }
    base = {}

    def rows() -> Iterator[list[str]]:
        for name, (call, n) in calls.items():
            each = seconds(call) / n * 1e9
            kind = "lags" if "lags" in name else "scattered"
            base.setdefault(kind, each)
            yield [name, f"{each:.0f}", f"{each / base[kind]:.2f}", f"{megabytes(call):.0f}"]

    print_table(
        ["what", "time per point [ns]", "time over that of the textbook form", "memory with the result [MB]"],
        rows(),
        record=Record(
            "analytic.speed",
            "A: seconds",
            "All nine components of both bodies, on one core.",
            "python benchmarks/analytic.py speed",
        ),
    )
    fade = EffectiveProperties(mismatch_k=Transition(0.1, 12.0, 1.5, 2.5))
    solid = HalfSpace(both_bodies(STEEL, BRASS), effective=fade)
    wheel = Surface(UPPER, arc(10.0, 1.0, 1.0), 500.0)

    def each_variant() -> Iterator[list[str]]:
        for name in VARIANTS:
            took = seconds(lambda name=name: approximate(name, solid, wheel, PATCH, (x, s)))
            yield [name, f"{took / POINTS * 1e9:.0f}"]

    print_table(
        ["ICs", "time per point [ns]"],
        each_variant(),
        record=Record(
            "analytic.variants",
            "Approximations: seconds",
            "All nine components of both bodies at 200,000 scattered points of a wheel, on one core.",
            "python benchmarks/analytic.py speed",
        ),
    )


# --- bilinear elements ---------------------------------------------------------------------------------


def hat_cases(patch: Patch, rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Return points on the scale of either side, and nodes of the grid."""
    a, b = patch.a, patch.b
    x = np.concatenate([a * 10 ** rng.uniform(-2, 1, n), b * 10 ** rng.uniform(-2, 4, n)])
    s = np.concatenate([b * 10 ** rng.uniform(-2, 4, n), a * 10 ** rng.uniform(-2, 1, n)])
    return np.append(x, 2 * a * rng.integers(0, 3, n)), np.append(s, 2 * b * rng.integers(0, 6, n))


def bilinear() -> None:
    def rows() -> Iterator[list[str]]:
        for aspect in (1, 1.5, 50, 1e3, 1e6):
            patch = Patch(1.0, 1.0 / aspect)
            x, s = hat_cases(patch, np.random.default_rng(0), 60)
            took = seconds(lambda patch=patch, x=x, s=s: hat.over_hat(patch, x, s))
            got, fine = hat.over_hat(patch, x, s), with_finer_rules(patch, x, s)
            of_largest = np.max(np.abs(got - fine) / np.max(np.abs(fine), axis=0))
            scale = np.abs(fine)
            scale[:2] = fine[0] + fine[1]
            own = np.max(np.divide(np.abs(got - fine), scale, out=np.zeros_like(scale), where=scale > 0))
            yield [f"{aspect:g}", f"{of_largest:.0e}", f"{own:.0e}", f"{took / len(x) * 1e6:.0f}"]

    print_table(
        ["aspect", "error over the largest integral", "error over the value", "time per point [µs]"],
        rows(),
        record=Record(
            "analytic.bilinear",
            "Bilinear elements",
            "Errors near the load, against a rule of twice the nodes.",
            "python benchmarks/analytic.py hat",
        ),
    )
    took = seconds(lambda: hat.over_hat_lags(PATCH, 128, 64))
    print(f"\nLags 128 x 64: {took * 1e3:.0f} ms, {took / 128 / 64 * 1e9:.0f} ns each.")


def with_finer_rules(patch: Patch, x: Array, s: Array) -> Array:
    before = hat.GAUSS, hat.LEAST, hat.MOST
    hat.GAUSS, hat.LEAST, hat.MOST = (48,), 301, 301
    try:
        return hat.over_hat(patch, x, s)
    finally:
        hat.GAUSS, hat.LEAST, hat.MOST = before


# --- another library -----------------------------------------------------------------------------------


def library() -> None:
    try:
        from slippy.core.elastic_material import elastic_influence_matrix_spatial as of_slippy  # noqa: PLC0415
    except ImportError:
        print("\nslippy is not installed: no comparison.")
        return
    shape, components = (257, 201), ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")

    def nine_of_slippy(spacing: tuple[float, float]) -> Array:
        return np.array([of_slippy(c, shape, spacing, STEEL.G, STEEL.nu) for c in components])

    def rows() -> Iterator[list[str]]:
        for a, b in ((0.2, 0.2), (0.2, 0.3)):
            patch, solid = Patch(a, b), HalfSpace(one_body(STEEL, UPPER))
            centre = (shape[0] // 2, shape[1] // 2)
            theirs = nine_of_slippy((2 * a, 2 * b))[8, centre[0] :, centre[1] :]
            ours = solid.lags(patch, shape[1] - centre[1], shape[0] - centre[0])[2, 2].T
            error = np.max(np.abs(theirs - ours) / ours)
            per_point = seconds(lambda a=a, b=b: nine_of_slippy((2 * a, 2 * b))) / np.prod(shape) * 1e9
            yield [f"{2 * a:g} × {2 * b:g} mm", f"{error:.0e}", f"{per_point:.0f}"]

    print_table(
        ["element", "largest relative error of nn", "time per point [ns]"],
        rows(),
        record=Record(
            "analytic.slippy",
            "slippy 0.5.2: ICs of half-spaces",
            "All nine components on 257 × 201 lags by slippy; its nn against femic's A.",
            "python benchmarks/analytic.py library",
        ),
    )


PARTS = {"accuracy": accuracy, "speed": speed, "hat": bilinear, "library": library}

if __name__ == "__main__":
    for part in arguments() or PARTS:
        PARTS[part]()
