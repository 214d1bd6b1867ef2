"""Figure of error against seconds of each variant."""

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.ics.compute import Results
from compare.report.panels import figure_grid
from compare.report.styles import MARKERS, STYLES, SYMBOLS
from femic.scenes.scene import Scene

LEAST_DRAWN = 1e-6  # error: smaller errors are rounding and are drawn here


def error_against_seconds(results: Results, errors: xr.Dataset) -> Figure:
    """Draw the worst error of each variant over all lines against its seconds, one panel per body."""
    scene = results.scene
    with figure_grid(1, len(scene.compared), (4.1, 3.3), sharey=True) as (figure, grid):
        for axes, body in zip(grid[0], scene.compared, strict=True):
            body_errors = errors.sel(body=body)
            for variant in results.computed(body):
                _draw_errors(axes, results.seconds[variant, body], body_errors.sel(variant=variant), scene)
            axes.set(title=body, xlabel=f"seconds for {len(results.points.x)} points [s]")
        grid[0, 0].set_ylabel("worst error over the lines [-],\none mark per component")
    return figure


def _draw_errors(axes: Axes, seconds: float, variant_errors: xr.Dataset, scene: Scene) -> None:
    """Draw a mark per component, hollow if it vanishes in C: its error is then a share of 0.05 max |C_nn|."""
    worst, name = variant_errors.error.max("line"), str(variant_errors.variant.item())
    style = {"color": STYLES[name]["color"], "linestyle": "none", "marker": MARKERS[name]}
    marks = [
        (
            max(worst.sel(i=c[0], j=c[1]).item(), LEAST_DRAWN),
            bool(variant_errors.vanishes.sel(i=c[0], j=c[1])),
        )
        for c in scene.components
    ]
    for hollow, label in ((False, SYMBOLS[name]), (True, "_zeros")):
        values = [value for value, vanishes in marks if vanishes == hollow]
        more = " (estimate; all its models)" if name == "C" and not hollow else ""
        fill = {"mfc": "none"} if hollow else {}
        axes.loglog([seconds] * len(values), values, label=label + more, **style, **fill)
    if any(hollow for _, hollow in marks):
        axes.set_title("hollow: C vanishes, share of 0.05 C_nn", loc="right", fontsize=7, color="grey", y=0.0)
