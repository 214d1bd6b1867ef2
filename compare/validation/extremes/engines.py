"""C by both engines at their limits, compared with A on planes and with a more accurate C elsewhere."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.stats.qmc import LatinHypercube

from compare.validation.extremes.cases import HARMONIC, SOLID, BeyondLimit, Limit, WithinLimit, refusal
from femic.reference.job import component_of
from femic.reference.run_options import RunOptions
from femic.results.ics import Results, compute, reference_ics, refinement_shares, select_ics, solver_seconds
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene

SIX = ("nn", "ss", "xx", "xs", "xn", "sn")
TOLERANCE = {HARMONIC: 0.01, SOLID: 0.1}
REFERENCE_SETTINGS = {  # of the C against which errors are measured if there is no closed form
    "tolerance": 0.001,
    "growth": 0.2,  # cells < 1/2
    "far_radius": 3000.0,  # domain > 2 times
}
DRAWN_PLANES = 40  # plane scenes drawn
DRAWN_TOLERANCES = (0.1, 0.01, 0.001)  # of their C, in turn
# the outline of the patch has a row of its own: near it, a tolerance of 0.001 needs 100,000 unknowns
DRAWN_BESIDE = 1.5  # of half-sides, the nearest line beside the patch
DRAWN_AWAY = 0.1  # of half-sides, how near to the outline points of lines through the patch are
ROUNDING_SHARE = 1e-9  # of the scale of refinement: smaller estimates count as this
DRAWN_RANGE = f"ν, a/b 0.1 … 10, 0.1 … 1 mm, a line {DRAWN_BESIDE:g} … 8 b beside the load"
POINTS = 102  # of a line, at least; none lies on the outline of the patch, which has a row of its own
Changes = Mapping[str, Any]
NO_CHANGES: Changes = {}


@dataclass(frozen=True)
class SceneCase:
    """A built-in scene with changes, under a label."""

    label: str
    base: str
    changes: Changes

    def scene(self, engine: str, settings: Changes = NO_CHANGES) -> Scene:
        """Return the scene, with one engine and without a check by the other."""
        return load_scene(self.base, {**self.changes, "engine": {"kind": engine, "check": False, **settings}})

    def refused(self, engine: str) -> Callable[[RunOptions], BeyondLimit]:
        """Return the case beyond the limits of an engine, which reading the scene refuses."""
        return refusal(self.label, lambda _: self.scene(engine))


LimitCases = tuple[str, str, list[SceneCase], list[SceneCase]]  # name, range, cases within and beyond it


def harmonic_limits() -> list[Limit]:
    """Return the limits of the harmonic engine, with cases within and beyond them."""
    drawn = Limit(HARMONIC, "all of a plane at once", DRAWN_RANGE, [drawn_planes])
    return [*_limits(HARMONIC, _harmonic()), drawn]


def solid_limits() -> list[Limit]:
    """Return the limits of the solid engine, with cases within and beyond them."""
    return _limits(SOLID, _solid())


def _limits(engine: str, cases: list[LimitCases]) -> list[Limit]:
    return [
        Limit(
            engine,
            name,
            allowed,
            [partial(solve_case, engine, case) for case in within],
            [case.refused(engine) for case in beyond],
        )
        for name, allowed, within, beyond in cases
    ]


def solve_case(engine: str, case: SceneCase, options: RunOptions) -> WithinLimit:
    """Return a case with its errors against a finer C, on planes against A."""
    results = compute(case.scene(engine, {"tolerance": TOLERANCE[engine]}), options)
    finer = None if case.base == "flat" else compute(case.scene(HARMONIC, REFERENCE_SETTINGS), options)
    return within_limit(case, results, finer)


def within_limit(case: SceneCase, results: Results, finer: Results | None = None) -> WithinLimit:
    """Return the largest error, estimate, and error over estimate [-] of all lines and components."""
    errors, estimates, used = map(max, zip(*component_errors(results, finer), strict=True))
    against = "A" if finer is None else "a finer C"
    return WithinLimit(case.label, errors, estimates, used, against, solver_seconds(results.models))


def drawn_planes(options: RunOptions) -> WithinLimit:
    """Return the case with the largest error over its estimate among planes of a Latin hypercube."""
    reached: list[WithinLimit] = []
    used: list[float] = []
    lowest, highest = np.array([[0.0, -1.0, -1.0, DRAWN_BESIDE], [0.49, 1.0, 0.0, 8.0]])
    drawn = lowest + (highest - lowest) * LatinHypercube(4, rng=0).random(DRAWN_PLANES)
    for number, (nu, aspect, size, beside) in enumerate(drawn.tolist()):
        case = flat(nu=nu, aspect=10**aspect, size=10**size, beside=beside)
        tolerance = DRAWN_TOLERANCES[number % len(DRAWN_TOLERANCES)]
        results = compute(case.scene(HARMONIC, {"tolerance": tolerance}), options)
        reached.append(within_limit(case, results))
        used.extend(share for _, _, share in component_errors(results))
    held = sum(share <= 1 for share in used)
    note = f"{len(reached)} scenes: {held} of {len(used)} errors (of components on lines) within estimates"
    return replace(max(reached, key=lambda case: case.used or 0.0), note=note)


def points_off_outline(a: float, reach: float) -> int:
    """Return how many points a line along x to +-reach [mm] has, none of them beside x = +-a."""
    for points in range(POINTS, 2 * POINTS, 2):
        if np.min(np.abs(np.abs(np.linspace(-reach, reach, points)) - a)) >= DRAWN_AWAY * a:
            return points
    raise ValueError(f"no line of points off x = {a:g} mm up to {reach:g} mm")


def _harmonic() -> list[LimitCases]:
    return [
        ("ν", "0 … 0.4999", [flat(nu=0.0), flat(nu=0.4999)], [flat(nu=0.49995)]),
        ("patch aspect a/b", "0.01 … 100", [flat(aspect=0.01), flat(aspect=100.0)], [flat(aspect=0.005)]),
        ("distance / half-side", "0 … 1000", [flat(distance=1000.0)], [flat(distance=3300.0)]),
        ("flank inclination", "0 … 85°", [curved(flank=0.0), curved(flank=85.0)], [curved(flank=86.0)]),
        ("R_roll [mm]", "20 … ∞", [wheel(20.0), wheel(1e6)], [wheel(19.0)]),
        ("R_w / R_r − 1", "≥ 0", [ratio(1.0), ratio(10.0)], []),
        ("modulus ratio", "1e-6 … 1e6", [moduli(1e-6), moduli(1e6)], []),
        ("observer", "anywhere", [on_outline()], []),
    ]


def _solid() -> list[LimitCases]:
    return [
        ("ν", "0 … 0.49", [flat(nu=0.0), flat(nu=0.49)], [flat(nu=0.495)]),
        ("patch aspect a/b", "0.1 … 10", [flat(aspect=0.1), flat(aspect=10.0)], [flat(aspect=0.05)]),
        ("distance / half-side", "0 … 200", [flat(distance=200.0)], [flat(distance=820.0)]),
        ("flank inclination", "0 … 75°", [curved(flank=0.0), curved(flank=75.0)], [curved(flank=76.0)]),
        ("R_roll [mm]", "50 … ∞", [wheel(50.0), wheel(1e6)], [wheel(49.0)]),
        ("R_w / R_r − 1", "≥ 0", [ratio(10.0)], []),
        ("modulus ratio", "1e-6 … 1e6", [moduli(1e-6), moduli(1e6)], []),
        ("observer", "anywhere", [on_outline()], []),
    ]


def flat(
    *, nu: float = 0.28, aspect: float = 1.0, size: float = 0.2, distance: float = 25.0, beside: float = 4.0
) -> SceneCase:
    """Return one half-space, with lines along x through and beside the patch, and a line along s.

    `size` is half the side of the patch along s [mm], `aspect` that along x over it. The line along s lies at
    `distance` times the smaller half-side, the line beside the patch at `beside` times `size`.
    """
    b, a = size, size * aspect
    reach = 25 * max(a, b)
    parameters = {"ν": (nu, 0.28), "a/b": (aspect, 1.0), "distance / half-side": (distance, 25.0)}
    label = ", ".join(
        f"{name} = {value:.5g}" for name, (value, usual) in parameters.items() if value != usual
    )
    changes = {
        "lower": {"nu": nu},
        "upper": {"nu": nu},
        "patch": {"a": a, "b": b},
        "lines": _lines(beside * b, distance * min(a, b), reach, points_off_outline(a, reach)),
    }
    return SceneCase(label, "flat", {**_comparison("lower"), **changes})


def on_outline() -> SceneCase:
    """Return one half-space, with points on the outline of the patch."""
    plane = flat()
    patch = plane.changes["patch"]
    lines = [
        {"along": "x", "s": 0.0, "reach": 5 * patch["a"], "points": 11},
        {"along": "s", "x": 0.0, "reach": 5 * patch["b"], "points": 11},
    ]
    return SceneCase("on the outline of the patch", plane.base, {**plane.changes, "lines": lines})


def _comparison(body: str) -> Changes:
    return {"bodies": [body], "components": list(SIX), "variants": ["A"]}


def _lines(s: float, x: float, reach: float, points: int) -> list[dict[str, Any]]:
    """Return lines along x at s and through the load, and a line along s at x."""
    sampled = {"reach": reach, "points": points}
    return [
        {"along": "x", "s": s, **sampled},
        {"along": "x", "s": 0.0, **sampled},
        {"along": "s", "x": x, **sampled},
    ]


def _of_geometry1(label: str, changes: Changes, body: str = "lower", reach: float = 25.0) -> SceneCase:
    return SceneCase(
        label, "geometry1", {**_comparison(body), "lines": _lines(1.6, 1.6, reach, 101), **changes}
    )


def _arc(flank: float, radius: float = 10.0) -> Changes:
    return {"contour": {"kind": "arc", "radius": radius, "flank_inclination_deg": flank}}


def curved(flank: float) -> SceneCase:
    """Return the lower body of Geometry 1 with another flank inclination [deg]."""
    return _of_geometry1(f"{flank:g}°", {"lower": _arc(flank), "upper": _arc(flank)})


def wheel(rolling_radius: float) -> SceneCase:
    """Return the upper body of Geometry 1, revolved with a rolling radius [mm]."""
    changes = {"upper": {"rolling_radius": rolling_radius}}
    return _of_geometry1(f"{rolling_radius:g} mm", changes, "upper", min(25.0, rolling_radius / 5))


def ratio(over: float) -> SceneCase:
    """Return both bodies of Geometry 1 with a ratio `over` of the upper to the lower radius."""
    return _of_geometry1(f"{over - 1:g}", {"upper": _arc(25.5, 10.0 * over)}, "combined")


def moduli(over: float) -> SceneCase:
    """Return both half-spaces; the upper one's modulus of elasticity is `over` times 210 GPa."""
    plane = flat()
    changes = {**plane.changes, "bodies": ["combined"], "upper": {"E": 210e3 * over}}
    return SceneCase(f"{over:g}", plane.base, changes)


def component_errors(results: Results, finer: Results | None = None) -> Iterator[tuple[float, float, float]]:
    """Yield error, estimate and error over estimate [-] of every component on every line.

    Errors of C are measured against A or a finer C, on the scale of refinement, as the tolerance.
    A component that vanishes by symmetry has an error of rounding and no estimate: estimates count as
    `ROUNDING_SHARE` at least.
    """
    body = results.scene.compared[0]
    c = reference_ics(results, body)
    truth = select_ics(results, "A", body) if finer is None else reference_ics(finer, body).ic
    errors, estimates = (refinement_shares(results, body, ics) for ics in (c.ic - truth, c.estimate))
    for line in errors:
        for name in SIX:
            error, estimate = component_of(errors[line], name), component_of(estimates[line], name)
            yield error, estimate, error / max(estimate, ROUNDING_SHARE)
