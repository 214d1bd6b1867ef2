"""Curves of ICs along lines, drawn from the dataset of `compare.ics.dataset.to_dataset`."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.report.panels import Panel, draw, panel_figure, show_zero, styles_of
from compare.report.styles import SYMBOLS
from femic.scenes.scene import Scene
from geometries.arrays import Array, Mask
from geometries.patches import OffsetLine


def curves(scene: Scene, dataset: xr.Dataset, component: str) -> Figure:
    """Return a figure of one component, dimensionless: a row per body, a column per line of the scene."""
    panels = list(_panels(scene, dataset, component))
    return panel_figure(panels, len(scene.lines), (4.1, 2.7))


def _panels(scene: Scene, dataset: xr.Dataset, component: str) -> Iterator[Panel]:
    """Yield the panels row by row; only those at the edges of the grid have labels."""
    for body in scene.compared:
        for line in scene.lines:
            panel = line_panel(dataset, line.name, body, component).part(shown_half(scene, line))
            first_row, last_row = body == scene.compared[0], body == scene.compared[-1]
            yield replace(
                panel,
                title=f"{component} on {line.name}" if first_row else "",
                across=f"{panel.across},  L = {scene.reference_length:g} mm" if last_row else "",
                up=_ordinate(body) if line is scene.lines[0] else "",
                marks=joints(scene, panel.at) if line.along == "s" else (),
            )


def curves_in(dataset: xr.Dataset, component: str) -> Figure:
    """Return a figure of one component of labelled ICs, dimensionless: a row per body, a column per line."""
    lines, panels = list(dict.fromkeys(dataset.line.values)), []
    for body, line in product(dataset.body.values, lines):
        panel = line_panel(dataset, line, body, component)
        title, across = f"{component} on {line}", f"{panel.across},  L = {dataset.reference_length:g} mm"
        panels.append(replace(panel, title=title, across=across, up=_ordinate(body)))
    return panel_figure(panels, len(lines))


def _ordinate(body: str) -> str:
    return f"{body}\nIC · E · L  [-]"


def line_panel(dataset: xr.Dataset, line: str, body: str, component: str) -> Panel:
    """Return the curves of a component of a body along a line, dimensionless, with its abscissa."""
    on_line = dataset.isel(point=np.flatnonzero(dataset.line.values == line))
    along = "x" if np.ptp(on_line.s.values) == 0 else "s"
    curve = on_line.sel(body=body, i=component[0], j=component[1])
    abscissas = on_line[along].values / dataset.reference_length
    return replace(panel_of(curve, abscissas), across=f"{along} / L  [-]")


def panel_of(curve: xr.Dataset, at: Array) -> Panel:
    """Return a panel of one component on one line, dimensionless, over the abscissas `at`, without labels.

    `curve` is a part of the dataset with the dims variant and point.
    """
    unit = curve.reference_E * curve.reference_length
    by_variant = {str(v): unit * curve.ic.sel(variant=v).values for v in curve.variant.values}
    return Panel(
        "",
        "",
        at,
        "",
        {SYMBOLS.get(name, name): values for name, values in by_variant.items()},
        unit * curve.estimate.values if "estimate" in curve else None,
        unit * curve.estimate_solid.values if "estimate_solid" in curve else None,
    )


def draw_curve(axes: Axes, at: Array, curve: xr.Dataset) -> None:
    """Draw one component on one line, dimensionless: C with its error band, and every approximation.

    `curve` is a part of the dataset of `compare.ics.dataset.to_dataset` with the dims variant and point,
    drawn against the abscissas `at`.
    """
    panel = panel_of(curve, at)
    draw(axes, panel, styles_of([panel]))
    show_zero(axes)


def joints(scene: Scene, at: Array) -> tuple[float, ...]:
    """Return abscissas s / L of the joints of arcs and flanks, within the range of `at`."""
    joint_abscissas = {
        round(s, 9) / scene.reference_length for body in scene.bodies.values() for s in body.contour.joints
    }
    return tuple(sorted(s for s in joint_abscissas if at[0] <= s <= at[-1]))


def shown_half(scene: Scene, line: OffsetLine) -> Mask:
    """Return which points of a line are shown, (n,): without the half that symmetry repeats."""
    mirrored = scene.patch.s == 0 and all(body.contour.symmetric for body in scene.bodies.values())
    symmetric = line.along == "x" or mirrored
    return line.running >= (0 if symmetric else -np.inf)
