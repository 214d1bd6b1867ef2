"""Figures of calibrations: effective properties, C_xn without curvature, C_sn with a refitted translation."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from approx.target import pointwise_k
from compare.calibration.compute import Calibrated
from compare.ics.compute import points_of, reference_of
from compare.ics.curves import shown_half
from compare.report.panels import Panel, add_scene_legends, draw_scenes
from compare.report.styles import COLOURS, DASHES, RC, STYLES, SYMBOLS
from geometries.arrays import Array
from geometries.patches import N, OffsetLine, S, indices

MARKERS_OF_LINES = ("o", "x", "+", "^", "s")
PROPERTIES = {"mismatch_k": "K [-]", "G": "G [MPa]", "nu": "ν [-]"}
WITHOUT, REFITTED = "C without curvature", "C, translation refitted to B̂′"
EXTRA: dict[str, dict[str, Any]] = {
    WITHOUT: {"color": "grey", "linewidth": 2.2, "zorder": 1},
    REFITTED: {"color": "tab:cyan", "linewidth": 2.2, "zorder": 1},
}
OVERLAID = {  # figures of both bodies: the component and its curves
    "xn": ("xn", ("C", "A", "B", "Bhat", "Bhat_prime")),
    "xn_without_curvature": ("xn", ("C", "Bhat_prime", WITHOUT)),
    "sn": ("sn", ("C", "B", "Bhat", "Bhat_prime", REFITTED)),
}


def effective(calibrations: Sequence[Calibrated], body: str) -> Figure:
    """Draw the fitted properties of a body against distance, for K also the value at each point of C."""
    fitted = [calibrated for calibrated in calibrations if body in calibrated.fits]
    names = list(
        dict.fromkeys(name for calibrated in fitted for name in calibrated.scene.calibration.properties)
    )
    with mpl.rc_context(RC):
        figure = Figure(figsize=(5.6 * len(names), 4.2), layout="constrained")
        for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
            for calibrated, colour in zip(fitted, COLOURS, strict=False):
                _draw_property(axes, calibrated, body, name, colour)
            axes.set(xlabel="r / L  [-]", ylabel=f"effective {PROPERTIES[name]}", title=f"{body} {name}")
            axes.legend(fontsize=7)
        return figure


def _draw_property(axes: Axes, calibrated: Calibrated, body: str, name: str, colour: str) -> None:
    target, scene = calibrated.targets[body], calibrated.scene
    transition = getattr(calibrated.fits[body].effective, name)
    if transition is None:
        return
    length = scene.reference_length
    r = np.linspace(0, float(np.max(target.r)), 400)
    curve = transition.at(r, getattr(target.solid.constants, name))
    axes.plot(r / length, curve, color=colour, linewidth=1.8, label=f"{scene.name}: fit")
    if name != "mismatch_k" or target.components != ("xn",):
        return
    pointwise = pointwise_k(target)[0]
    start = 0
    for line, marker in zip(scene.calibration.lines, MARKERS_OF_LINES * 9, strict=False):
        shown = np.arange(start, start + len(line.x), max(1, len(line.x) // 40))
        start += len(line.x)
        axes.plot(
            target.r[shown] / length,
            pointwise[shown],
            marker,
            color=colour,
            markersize=3.5,
            mfc="none",
            linestyle="none",
            label=f"{scene.name}: C_xn on {line.name.removeprefix('fit ')}",
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


def overlaid(calibrations: Sequence[Calibrated], figure_name: str) -> Figure:
    """Draw a figure of `OVERLAID`: combined ICs of all scenes, a panel per line, a line style per scene."""
    component, names = OVERLAID[figure_name]
    columns = max(len(calibrated.scene.lines) for calibrated in calibrations)
    styles = {SYMBOLS.get(name, name): _style(name) for name in reversed(names)}  # C lies behind the others
    with mpl.rc_context(RC):
        figure = Figure(figsize=(4.1 * columns, 4.0), layout="constrained")
        for k, axes in enumerate(figure.subplots(1, columns, squeeze=False)[0]):
            panels = {
                dashes: _panel(calibrated, calibrated.scene.lines[k], component, names)
                for calibrated, dashes in zip(calibrations, DASHES, strict=False)
                if k < len(calibrated.scene.lines)
            }
            draw_scenes(axes, panels, styles)
        figure.axes[0].set_ylabel(f"combined {component} · E · L  [-]")
        lengths = {calibrated.scene.name: calibrated.scene.reference_length for calibrated in calibrations}
        add_scene_legends(figure, lengths, styles)
        return figure


def _panel(calibrated: Calibrated, line: OffsetLine, component: str, names: Sequence[str]) -> Panel:
    scene, shown = calibrated.scene, shown_half(calibrated.scene, line)
    unit, part = scene.reference_E * scene.reference_length, calibrated.results.lines[line.name]
    return Panel(
        f"{component} on {line.name}",
        f"{line.along} / L  [-]",
        line.running[shown] / scene.reference_length,
        "",
        {SYMBOLS.get(name, name): unit * curve(calibrated, name, component, part)[shown] for name in names},
    )


def _style(name: str) -> dict[str, Any]:
    return EXTRA.get(name) or {"color": STYLES[name]["color"], "linewidth": 2.0 if name == "C" else 1.3}
