"""Figures of calibrations: effective properties, C_xn without curvature, C_sn with another translation."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from approx.target import indices, pointwise_k
from compare.pages.curves import shown_half
from compare.pages.panels import Panel, draw, finish
from compare.pages.styles import COLOURS, DASHES, RC, STYLES, SYMBOLS
from compare.reports.calibration.fits import Calibrated
from compare.results.compute import reference_of
from geometries.arrays import Array
from geometries.patches import N, OffsetLine, S

MARKERS_OF_LINES = ("o", "x", "+", "^", "s")
PROPERTIES = {"mismatch_k": "K [-]", "G": "G [MPa]", "nu": "ν [-]"}
WITHOUT, REFITTED = "C without curvature", "C, translation refitted to B̂′"
EXTRA: dict[str, dict[str, Any]] = {
    WITHOUT: {"color": "grey", "linewidth": 2.2, "zorder": 1},
    REFITTED: {"color": "tab:cyan", "linewidth": 2.2, "zorder": 1},
}


def effective(found: Sequence[Calibrated], body: str) -> Figure:
    """The fitted properties of a body against distance; of K also the value that each point of C asks for."""
    fitted = [one for one in found if body in one.fits]
    names = list(dict.fromkeys(name for one in fitted for name in one.scene.calibration.properties))
    with mpl.rc_context(RC):
        figure = Figure(figsize=(5.6 * len(names), 4.2), layout="constrained")
        for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
            for one, colour in zip(fitted, COLOURS, strict=False):
                _draw_property(axes, one, body, name, colour)
            axes.set(xlabel="r / L  [-]", ylabel=f"effective {PROPERTIES[name]}", title=f"{body} {name}")
            axes.legend(fontsize=7)
        return figure


def _draw_property(axes: Axes, one: Calibrated, body: str, name: str, colour: str) -> None:
    target, scene = one.targets[body], one.scene
    transition = getattr(one.fits[body].effective, name)
    if transition is None:
        return
    length = scene.reference_length
    r = np.linspace(0, float(np.max(target.r)), 400)
    curve = transition.at(r, getattr(target.solid.constants, name))
    axes.plot(r / length, curve, color=colour, linewidth=1.8, label=f"{scene.name}: fit")
    if name != "mismatch_k" or target.components != ("xn",):
        return
    asked = pointwise_k(target)[0]
    start = 0
    for line, marker in zip(scene.calibration.lines, MARKERS_OF_LINES * 9, strict=False):
        part = slice(start, start + len(line.x))
        start = part.stop
        shown = np.arange(part.start, part.stop)[:: max(1, len(line.x) // 40)]
        axes.plot(
            target.r[shown] / length,
            asked[shown],
            marker,
            color=colour,
            markersize=3.5,
            mfc="none",
            linestyle="none",
            label=f"{scene.name}: C_xn on {line.name.removeprefix('fit ')}",
        )


def without_curvature(found: Sequence[Calibrated]) -> Figure:
    """C_xn of both bodies with and without what the curvature of wheels adds to B-hat, and B-hat-prime."""
    return _overlaid(found, "xn", ("C", "Bhat_prime", WITHOUT))


def translation_refitted(found: Sequence[Calibrated]) -> Figure:
    """C_sn of both bodies by B, B-hat, B-hat-prime, C, and C with its translation refitted."""
    return _overlaid(found, "sn", ("C", "B", "Bhat", "Bhat_prime", REFITTED))


def overlaid(found: Sequence[Calibrated], component: str) -> Figure:
    """A component of both bodies by A, B, B-hat, B-hat-prime and C."""
    return _overlaid(found, component, ("C", "A", "B", "Bhat", "Bhat_prime"))


def translation(one: Calibrated) -> float:
    """The vertical translation [mm/N] of C that brings C_sn closest to B-hat-prime on the scene's lines.

    In local directions of the lower body: its s component is -sin(delta) of it.
    """
    points = np.concatenate([np.arange(*_part(one, line).indices(10**9)) for line in one.scene.lines])
    lean = np.sin(one.scene.bodies["lower"].contour.inclination(one.results.points.s[points]))
    c = reference_of(one.results, "combined").ic[S, N, points]
    lack = one.results.approximations["Bhat_prime", "combined"][S, N, points] - c
    return -float(lean @ lack) / max(float(lean @ lean), 1e-300)


def _part(one: Calibrated, line: OffsetLine) -> slice:
    return one.results.lines[line.name]


def curve(one: Calibrated, name: str, component: str, part: slice) -> Array:
    """A component of both bodies [mm/N]: C, an approximation or one of `EXTRA`."""
    i, j = indices(component)
    c = reference_of(one.results, "combined").ic[i, j, part]
    x, s = one.results.points.x[part], one.results.points.s[part]
    patch = one.scene.patch
    if name == "C":
        return np.asarray(c)
    if name == WITHOUT:
        return np.asarray(c - one.scene.pair.curvature(patch, (x, s))[i, j] / patch.area)
    if name == REFITTED:
        return np.asarray(c - np.sin(one.scene.bodies["lower"].contour.inclination(s)) * translation(one))
    return np.asarray(one.results.approximations[name, "combined"][i, j, part])


def _overlaid(found: Sequence[Calibrated], component: str, names: Sequence[str]) -> Figure:
    """Combined ICs of all scenes line by line; colours tell variants, line styles scenes."""
    columns = max(len(one.scene.lines) for one in found)
    styles = {SYMBOLS.get(name, name): _style(name) for name in names}
    with mpl.rc_context(RC):
        figure = Figure(figsize=(4.1 * columns, 4.0), layout="constrained")
        for k, axes in enumerate(figure.subplots(1, columns, squeeze=False)[0]):
            of_scenes = [
                (one, dashes) for one, dashes in zip(found, DASHES, strict=False) if k < len(one.scene.lines)
            ]
            for one, dashes in of_scenes:
                panel = _panel(one, one.scene.lines[k], component, names)
                draw(axes, panel, {name: style | {"linestyle": dashes} for name, style in styles.items()})
            finish(axes, panel)
        figure.axes[0].set_ylabel(f"combined {component} · E · L  [-]")
        _legends(figure, found, styles)
        return figure


def _panel(one: Calibrated, line: OffsetLine, component: str, names: Sequence[str]) -> Panel:
    scene, shown = one.scene, shown_half(one.scene, line)
    unit = scene.reference_E * scene.reference_length
    of_names = {name: unit * curve(one, name, component, _part(one, line))[shown] for name in names}
    return Panel(
        f"{component} on {line.name}",
        f"{line.along} / L  [-]",
        line.running[shown] / scene.reference_length,
        "",
        {SYMBOLS.get(name, name): values for name, values in of_names.items()},
    )


def _style(name: str) -> dict[str, Any]:
    return EXTRA.get(name) or {"color": STYLES[name]["color"], "linewidth": 2.0 if name == "C" else 1.3}


def _legends(figure: Figure, found: Sequence[Calibrated], styles: Mapping[str, dict[str, Any]]) -> None:
    scenes = [
        Line2D([], [], color="dimgrey", linestyle=dashes, label=f"{one.scene.name} (L = {length:g} mm)")
        for one, dashes in zip(found, DASHES, strict=False)
        for length in (one.scene.reference_length,)
    ]
    colours = [Line2D([], [], label=name, **style) for name, style in styles.items()]
    figure.legend(handles=scenes, loc="outside upper center", ncols=len(scenes), handlelength=4)
    figure.legend(handles=colours, loc="outside lower center", ncols=len(colours))
