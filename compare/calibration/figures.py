"""Charts of calibrations: fitted properties and what they leave of C; C without curvature, and translated."""

from collections.abc import Iterator, Sequence
from itertools import cycle

import numpy as np

from approx.target import pointwise_k
from compare.calibration.compute import Calibrated
from compare.ics.compute import points_of, reference_of
from compare.ics.curves import shown_half
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import FURTHER, Look, looks_of, symbol_of, without_marker
from geometries.arrays import Array
from geometries.patches import N, OffsetLine, S, indices

PROPERTIES = {"mismatch_k": "K [-]", "G": "G [MPa]", "nu": "ν [-]"}
COMPARED = ("Bhat", "Bhat_prime")  # without and with the fit
WITHOUT, REFITTED = "C without curvature", "C, translation refitted to B̂′"
OTHER_C = {  # the component that each C is about, and the ICs beside it
    WITHOUT: ("xn", ("Bhat_prime", "C"), Look("#808080", "dash", width=2.2)),
    REFITTED: ("sn", ("B", "Bhat", "Bhat_prime", "C"), Look("#17a2a2", "dash", width=2.2)),
}
MARKERS = ("circle-open", "square-open", "diamond-open", "triangle-up-open", "hexagon-open")
MARKED = 20  # most marks of a line
MICROMETRES_PER_KILONEWTON = 1e6  # of mm/N


def fits(calibrations: Sequence[Calibrated]) -> Chart:
    """Return the fitted properties over the distance, and what they leave of C, a step per scene."""
    steps = {calibrated.scene.name: list(_of_fits(calibrated, calibrations)) for calibrated in calibrations}
    return Chart("fits", steps, 2, "scene", 0.95, next(iter(steps)))


def _of_fits(calibrated: Calibrated, others: Sequence[Calibrated]) -> Iterator[Panel]:
    for body in calibrated.fits:
        for name in calibrated.scene.calibration.properties:
            yield _property(calibrated, others, body, name)
    for body, target in calibrated.targets.items():
        for component in target.components:
            yield _residual(calibrated, body, component)


def _property(calibrated: Calibrated, others: Sequence[Calibrated], body: str, name: str) -> Panel:
    """Return a property over the distance, as fitted in all scenes; if only xn is fitted, the K of points."""
    target = calibrated.targets[body]
    curves = list(_marks(calibrated, body)) if (name, target.components) == ("mismatch_k", ("xn",)) else []
    for other, look in zip(others, cycle(FURTHER), strict=False):
        transition = getattr(other.fits[body].effective, name) if body in other.fits else None
        if transition is not None:
            r = np.linspace(0.0, float(np.max(other.targets[body].r)), 200)
            half_space = getattr(other.targets[body].solid.constants, name)
            curves.append(Curve(f"fit, {other.scene.name}", r, transition.at(r, half_space), look))
    return Panel(f"{body}: effective {PROPERTIES[name]}", "r [mm]", PROPERTIES[name], curves)


def _lines(calibrated: Calibrated) -> Iterator[tuple[str, slice]]:
    """Yield the lines of the calibration, and which of its points are theirs."""
    start = 0
    for line in calibrated.scene.calibration.lines:
        yield line.name.removeprefix("fit "), slice(start, start + len(line.x))
        start += len(line.x)


def _marks(calibrated: Calibrated, body: str) -> Iterator[Curve]:
    """Yield the K with which B-hat has the value of C at a point, for some points of each line."""
    target = calibrated.targets[body]
    k = pointwise_k(target)[0]
    for (line, part), marker in zip(_lines(calibrated), cycle(MARKERS), strict=False):
        r, k_of_line = target.r[part], k[part]
        shown = slice(None, None, -(-len(r) // MARKED))
        yield Curve(f"K at {line}", r[shown], k_of_line[shown], Look("#808080", "", marker))


def _residual(calibrated: Calibrated, body: str, component: str) -> Panel:
    """Return differences of approximations from C at the fitted points, and its estimate [% of max |C|]."""
    target, looks = calibrated.targets[body], looks_of(("C", *COMPARED))
    k = target.components.index(component)
    unit, error = 100 / target.scales[k], np.broadcast_to(target.error, target.ics.shape)[k]
    ics = {
        "C": target.ics[k],
        "Bhat": target.approximate("Bhat")[k],
        "Bhat_prime": target.bhat_prime(calibrated.fits[body].effective)[k],
    }
    curves = [
        Curve(
            symbol_of(name),
            target.r[part],
            unit * (values - ics["C"])[part],
            without_marker(looks[name]),
            unit * error[part] if name == "C" else None,
        )
        for name, values in ics.items()
        for _, part in _lines(calibrated)
    ]
    return Panel(
        f"{body}: {component} minus C, fitted points",
        "r [mm]",
        f"Δ{component} [% of max |C|]",
        curves,
    )


def translation(calibrated: Calibrated) -> float:
    """Return the vertical translation [mm/N] that brings C_sn closest to B-hat-prime on the scene's lines.

    In local directions of the lower body, its s component is the translation times -sin(delta).
    """
    points = points_of(calibrated.results, calibrated.scene.lines)
    lean = _lean(calibrated, calibrated.results.points.s[points])
    c = reference_of(calibrated.results, "combined").ic[S, N, points]
    difference = calibrated.results.approximations["Bhat_prime", "combined"][S, N, points] - c
    return -float(lean @ difference) / max(float(lean @ lean), 1e-300)


def _lean(calibrated: Calibrated, s: Array) -> Array:
    """Return the sine of the lower body's inclination at arc lengths, (n,)."""
    return np.sin(calibrated.scene.bodies["lower"].contour.inclination(s))


def curve(calibrated: Calibrated, name: str, component: str, part: slice) -> Array:
    """Return a component of both bodies [mm/N], (n,), at points: C, an approximation or one of `EXTRA`."""
    i, j = indices(component)
    c = reference_of(calibrated.results, "combined").ic[i, j, part]
    x, s = calibrated.results.points.x[part], calibrated.results.points.s[part]
    patch = calibrated.scene.patch
    if name == "C":
        return np.asarray(c)
    if name == WITHOUT:
        return np.asarray(c - calibrated.scene.pair.curvature(patch, (x, s))[i, j] / patch.area)
    if name == REFITTED:
        return np.asarray(c - _lean(calibrated, s) * translation(calibrated))
    return np.asarray(calibrated.results.approximations[name, "combined"][i, j, part])


def other_c(calibrations: Sequence[Calibrated]) -> Chart:
    """Return C without curvature, and with another translation, beside B-hat-prime; a step per scene."""
    steps = {
        calibrated.scene.name: [
            _beside(calibrated, name, line) for name in OTHER_C for line in calibrated.scene.lines
        ]
        for calibrated in calibrations
    }
    columns = max(len(calibrated.scene.lines) for calibrated in calibrations)
    return Chart("other_c", steps, columns, "scene", start=next(iter(steps)))


def _beside(calibrated: Calibrated, name: str, line: OffsetLine) -> Panel:
    component, others, look = OTHER_C[name]
    scene, part = calibrated.scene, calibrated.results.lines[line.name]
    shown = shown_half(scene, line)
    looks = {name: look} | looks_of(others)
    curves = [
        Curve(
            one if one == name else symbol_of(one),
            line.running[shown],
            MICROMETRES_PER_KILONEWTON * curve(calibrated, one, component, part)[shown],
            without_marker(looks[one]),
        )
        for one in looks
    ]
    return Panel(f"combined, {line.name}", f"{line.along} [mm]", f"{component} [µm/kN]", curves)
