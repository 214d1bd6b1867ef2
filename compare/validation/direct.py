"""Statements 1 to 5: components that a plane has, too, and how the deviations of two bodies add up."""

import numpy as np
from numpy.typing import NDArray

from compare.pipeline import Results
from compare.validation.curves import (
    BODIES,
    CONCAVE,
    CONVEX,
    Measured,
    along,
    beyond,
    curve,
    error,
    line_at,
    panel,
)
from compare.validation.runs import GEOMETRIES, Runs

Array = NDArray[np.float64]

BESIDE = 0.15  # reference lengths away: from here on curves are drawn that are steep beside the load
CANCEL, ADD = ("nn", "ss", "xx", "xs"), ("xn", "sn")


def nn_follows(runs: Runs) -> Measured:
    """Statement 1."""
    found = {name: runs.geometry(name) for name in GEOMETRIES}
    values = {
        f"{variant} {way}": {
            name: error(results, variant, "combined", "nn", along(results, direction))
            for name, results in found.items()
        }
        for variant, way, direction in (
            ("B", "lateral", "s"),
            ("A", "lateral", "s"),
            ("A", "along x", "x"),
            ("B", "along x", "x"),
        )
    }
    panels = [
        panel(results, ("A", "B"), ("combined", "nn"), along(results, direction)[0])
        for direction in "sx"
        for results in found.values()
    ]
    return Measured(values, tuple(panels))


def xx_is_alike(runs: Runs) -> Measured:
    """Statement 2."""
    found = [runs.geometry(name) for name in GEOMETRIES]
    errors = {results.scene.name: error(results, "A", "combined", "xx") for results in found}
    first, second = (_xx_from_a(results) for results in found)
    apart = {"both": float(np.max(np.abs(first - second)))}
    panels = [
        panel(results, ("A",), ("combined", "xx"), along(results, direction)[0])
        for direction in "xs"
        for results in found
    ]
    return Measured({"A": errors, "alike": apart}, tuple(panels))


def _xx_from_a(results: Results) -> Array:
    """(C_xx - A_xx) / scale of each line, at all points."""
    parts = []
    for line in results.scene.lines:
        c, a = (curve(results, variant, "combined", "xx", [line]) for variant in ("C", "A"))
        parts.append((c - a) / np.max(np.abs(c)))  # |C_xx| is the larger part of the scale
    return np.concatenate(parts)


def ss_falls_faster(runs: Runs) -> Measured:
    """Statement 3."""
    found = {name: runs.geometry(name) for name in GEOMETRIES}
    lacking = {
        f"{name}, {body}": _lacking(results, body) for name, results in found.items() for body in BODIES
    }
    of = "{}, {}".format
    first, second = GEOMETRIES
    geometry = lacking[of(second, "combined")] - lacking[of(first, "combined")]
    convex = lacking[of(second, CONVEX)] - lacking[of(second, CONCAVE)]
    panels = [
        beyond(panel(results, ("A", "B"), (body, "ss"), line_at(results, 0.0)), BESIDE)
        for body in BODIES
        for results in found.values()
    ]
    values = {"faster": lacking, "geometry": {"both": geometry}, "convex": {second: convex}}
    return Measured(values, tuple(panels))


def _lacking(results: Results, body: str) -> float:
    """1 - C_ss / B_ss at x = reference length, s = 0."""
    line, length = line_at(results, 0.0), results.scene.reference_length
    c, b = (np.interp(length, line.x, curve(results, variant, body, "ss", [line])) for variant in ("C", "B"))
    return float(1 - c / b)


def xs_of_bodies(runs: Runs) -> Measured:
    """Statement 4."""
    found = {name: runs.geometry(name) for name in GEOMETRIES}
    ratio = {
        name: error(results, "A", CONVEX, "xs") / error(results, "A", CONCAVE, "xs")
        for name, results in found.items()
    }
    pairs = {
        f"{name}, {body}": [error(results, variant, body, "xs") for variant in ("B", "Bhat")]
        for name, results in found.items()
        for body in BODIES
    }
    largest = {
        f"largest |C_xs - A_xs| E L: {name}, {body}": float(
            np.max(np.abs(curve(results, "C", body, "xs") - curve(results, "A", body, "xs")))
        )
        for name, results in found.items()
        for body in (CONVEX, CONCAVE)
    }
    better = {case: b / b_hat for case, (b, b_hat) in pairs.items()}
    left = {case: min(errors) for case, errors in pairs.items()}
    panels = [
        panel(results, ("A", "B", "Bhat"), (body, "xs"), along(results, "s")[0])
        for body in BODIES
        for results in found.values()
    ]
    return Measured({"convex": ratio, "better": better, "left": left}, tuple(panels), largest)


def bodies_cancel_or_add(runs: Runs) -> Measured:
    """Statement 5."""
    found = {name: runs.geometry(name) for name in GEOMETRIES}

    def share(results: Results, component: str) -> float:
        upper, lower = (
            curve(results, "C", body, component) - curve(results, "A", body, component)
            for body in (CONCAVE, CONVEX)
        )
        norms = np.linalg.norm(upper), np.linalg.norm(lower)
        return float(np.linalg.norm(upper + lower) / np.sum(norms))

    cancel, add = (
        {f"{name}, {c}": share(results, c) for name, results in found.items() for c in components}
        for components in (CANCEL, ADD)
    )
    panels = [
        panel(found[GEOMETRIES[0]], ("A",), (body, component), along(found[GEOMETRIES[0]], direction)[0])
        for component, direction in (("nn", "s"), ("sn", "s"), ("xn", "x"))
        for body in BODIES
    ]
    return Measured({"cancel": cancel, "add": add}, tuple(panels), columns=3)
