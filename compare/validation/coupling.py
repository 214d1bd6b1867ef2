"""Statements 6 to 10 and 13: normal against tangential directions, xn and sn."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from approx.halfspace import HalfSpace
from approx.orientation import Turn, both_turned, load_turned, turn_between
from compare.figures import SYMBOLS
from compare.pipeline import Results, reference_of
from compare.validation.curves import (
    BODIES,
    CONCAVE,
    CONVEX,
    Measured,
    along,
    curve,
    deviation,
    error,
    line_at,
    panel,
    rms,
    unit,
)
from compare.validation.runs import GEOMETRIES, Runs

Array = NDArray[np.float64]

NEAR = 0.3  # reference lengths: near the load
GAIN = 0.9  # error with the factor over that without: a gain
S, N = 1, 2
TURNED: Mapping[str, Callable[[Array, Turn], Array]] = {"B": load_turned, "Bhat": both_turned}


def xn_of_bodies(runs: Runs) -> Measured:
    """Statement 6."""
    found = {name: runs.geometry(name) for name in GEOMETRIES}

    in_b, in_c = (
        {
            f"{name}, {line.name}": rms(curve(results, variant, larger, "xn", [line]))
            / rms(curve(results, variant, smaller, "xn", [line]))
            for name, results in found.items()
            for line in along(results, "x")
        }
        for variant, larger, smaller in (("B", CONCAVE, CONVEX), ("C", CONVEX, CONCAVE))
    )
    poor = {name: error(r, "B", "combined", "xn") for name, r in found.items()}
    panels = [
        panel(results, ("A", "B"), (body, "xn"), along(results, "x")[0])
        for body in BODIES
        for results in found.values()
    ]
    return Measured({"poor": poor, "in B": in_b, "in C": in_c}, tuple(panels))


def xn_of_fit(runs: Runs) -> Measured:
    """Statement 7."""
    found = {name: runs.fitted(name) for name in GEOMETRIES}
    close = {name: error(r, "Bhat_prime", "combined", "xn", along(r, "x")) for name, r in found.items()}
    excess = {name: _excess(results) for name, results in found.items()}
    first, second = GEOMETRIES
    panels = [
        panel(results, ("Bhat", "Bhat_prime"), ("combined", "xn"), line)
        for results in found.values()
        for line in along(results, "x")
    ]
    geometry = {"both": excess[first] - excess[second]}
    return Measured({"close": close, "too large": excess, "geometry": geometry}, tuple(panels))


def _excess(results: Results) -> float:
    """Mean of (B-hat-prime - C) sgn C / max |C| of xn near the load, on the lines along x."""
    parts = []
    for line in along(results, "x"):
        c, fit = (curve(results, variant, "combined", "xn", [line]) for variant in ("C", "Bhat_prime"))
        beside = results.scene.patch.a, NEAR * results.scene.reference_length
        near = (np.abs(line.x) > beside[0]) & (np.abs(line.x) <= beside[1])
        parts.append(((fit - c) * np.sign(c) / np.max(np.abs(c)))[near])
    return float(np.mean(np.concatenate(parts)))


def xn_of_geometries(runs: Runs) -> Measured:
    """Statement 8."""
    found = {name: runs.geometry(name) for name in GEOMETRIES} | {"not revolved": runs.not_revolved()}
    sizes = {
        name: rms(curve(results, "C", "combined", "xn", [line_at(results, 0.0)]))
        for name, results in found.items()
    }
    first, second, not_revolved = sizes.values()
    values = {
        "larger": {"both": second / first},
        "curvature": {"both": abs((second - not_revolved) / (second - first))},
    }
    wheel = found[GEOMETRIES[1]]
    line = line_at(wheel, 0.0)
    more = {"C, not revolved": curve(found["not revolved"], "C", "combined", "xn", [line])}
    panels = (
        panel(wheel, (), ("combined", "xn"), line, more),
        panel(found[GEOMETRIES[0]], (), ("combined", "xn"), line_at(found[GEOMETRIES[0]], 0.0)),
    )
    return Measured(values, panels, {f"rms of C_xn, {name}": size for name, size in sizes.items()})


def sn_of_bodies(runs: Runs) -> Measured:
    """Statement 9."""
    found = {name: runs.fitted(name) for name in GEOMETRIES}

    def ratio(results: Results, variant: str) -> float:
        return error(results, variant, "combined", "sn") / error(results, "Bhat", "combined", "sn")

    first = found[GEOMETRIES[0]]
    values = {
        "convex": {name: _above_a(results, CONVEX) for name, results in found.items()},
        "concave": {name: _above_a(results, CONCAVE) for name, results in found.items()},
        "B": {name: ratio(results, "B") for name, results in found.items()},
        "B̂′": {name: ratio(results, "Bhat_prime") for name, results in found.items()},
        "translation": {name: _translation(results) for name, results in found.items()},
        "flank": {GEOMETRIES[0]: _furthest_misfit(first)},
    }
    panels = [
        panel(results, ("A", "B", "Bhat", *fitted), (body, "sn"), along(results, "s")[0])
        for body, fitted in (("combined", ("Bhat_prime",)), (CONVEX, ()), (CONCAVE, ()))
        for results in found.values()
    ]
    return Measured(values, tuple(panels))


def _above_a(results: Results, body: str) -> float:
    """Mean of (C - A) sgn A / max |A| of sn on the line along s, s > 0.

    In the sign of A: the source draws each body in its own frame, in which A_sn of both is alike; here
    those of lower and upper body have opposite signs.
    """
    line = along(results, "s")[0]
    c, a = (curve(results, variant, body, "sn", [line])[line.s > 0] for variant in ("C", "A"))
    return float(np.mean((c - a) * np.sign(a) / np.max(np.abs(a))))


def _translation(results: Results) -> float:
    """Part of the squares of C_sn - B-hat_sn that the best vertical translation of both bodies explains."""
    off = curve(results, "C", "combined", "sn") - curve(results, "Bhat", "combined", "sn")
    s = np.concatenate([line.s for line in results.scene.lines])
    lean = np.sin(results.scene.bodies["lower"].contour.inclination(s))
    left = off - lean * (lean @ off) / (lean @ lean)
    return float(1 - (left @ left) / (off @ off))


def _furthest_misfit(results: Results) -> float:
    """|s| of the largest |C_sn - B-hat_sn| on the line along s, over that of the joint."""
    line = along(results, "s")[0]
    off = curve(results, "C", "combined", "sn", [line]) - curve(results, "Bhat", "combined", "sn", [line])
    joint = results.scene.bodies["lower"].contour.joints[-1]
    return float(abs(line.s[np.argmax(np.abs(off))]) / joint)


def factor_of_the_cylinder(runs: Runs) -> Measured:
    """Statement 10; not of both bodies together: where they are alike, A_sn and with it the factor cancel."""
    found = {name: runs.geometry(name) for name in GEOMETRIES}
    ratios, panels = {}, []
    for name, results in found.items():
        for body in (CONVEX, CONCAVE):
            with_factor = {variant: _with_factor(results, variant, body) for variant in TURNED}
            c = reference_of(results, body).ic
            for variant, ics in with_factor.items():
                without = error(results, variant, body, "sn")
                ratios[f"{name}, {body}, {variant}"] = deviation(results, ics - c, body, "sn") / without
            line = along(results, "s")[0]
            part = results.lines[line.name]
            more = {
                f"{SYMBOLS[variant]} with the factor": unit(results) * ics[S, N, part]
                for variant, ics in with_factor.items()
            }
            panels.append(panel(results, ("B", "Bhat"), (body, "sn"), line, more))
    gained = float(np.mean([ratio <= GAIN for ratio in ratios.values()]))
    details = {f"error with over without: {case}": ratio for case, ratio in ratios.items()}
    return Measured({"gain": {"all": gained}}, tuple(panels), details, columns=3)


def _with_factor(results: Results, variant: str, body: str) -> Array:
    """B or B-hat [mm/N] from A with sn and ns times (pi - |alpha|) / pi, alpha between the two normals."""
    scene, points = results.scene, (results.points.x, results.points.s)
    total = np.zeros((3, 3, len(points[0])))
    for name in ("upper", "lower") if body == "combined" else (body,):
        solid = getattr(scene.pair, name)
        a = HalfSpace(solid.constants).ics(scene.patch, points[0], points[1] - scene.patch.s)
        inclination = solid.surface.contour.inclination
        alpha = np.abs(inclination(points[1]) - inclination(scene.patch.s))
        a[[S, N], [N, S]] *= (np.pi - alpha) / np.pi
        total += TURNED[variant](a, turn_between(solid.surface, points, scene.patch.s))
    return total / scene.patch.area


def xn_without_fit(runs: Runs) -> Measured:
    """Statement 13."""
    found = {name: runs.geometry(name) for name in GEOMETRIES}
    errors = {
        (name, body): {variant: error(results, variant, body, "xn") for variant in ("A", "B", "Bhat")}
        for name, results in found.items()
        for body in BODIES
    }
    values = {f"{name}, {body}": e["A"] / min(e["B"], e["Bhat"]) for (name, body), e in errors.items()}
    details = {
        f"error of {variant}_xn: {name}, {body}": value
        for (name, body), of in errors.items()
        for variant, value in of.items()
    }
    panels = [
        panel(results, ("A", "B", "Bhat"), (body, "xn"), along(results, "x")[0])
        for body in BODIES
        for results in found.values()
    ]
    return Measured({"A": values}, tuple(panels), details)
