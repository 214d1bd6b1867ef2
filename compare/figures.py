"""Figures of a comparison: sections, curves along the lines, error against seconds (matplotlib)."""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from skfem import MeshTri

from approx.variants import VARIANTS
from compare.pipeline import Results
from compare.scenes.scene import Scene
from geometries.bodies import Body
from geometries.patches import OffsetLine

Array = NDArray[np.float64]

SYMBOLS = {name: variant.symbol for name, variant in VARIANTS.items()} | {"C": "C", "C_solid": "C (solid)"}
STYLES: dict[str, dict[str, Any]] = {  # the first on top: mix coincides with others
    "mix": {"color": "tab:purple", "linestyle": (0, (1, 3)), "linewidth": 2.2},
    "A": {"color": "tab:blue", "linestyle": (0, (5, 2))},
    "B": {"color": "tab:orange", "linestyle": "-"},
    "Bbar": {"color": "tab:green", "linestyle": (0, (3, 1, 1, 1))},
    "Bhat": {"color": "tab:red", "linestyle": (0, (2, 1))},
    "Bhat_prime": {"color": "tab:brown", "linestyle": (0, (6, 1))},
    "C": {"color": "black", "linewidth": 1.8, "zorder": 1},
}
CHECK: dict[str, Any] = {
    "color": "black",
    "marker": "o",
    "markersize": 4,
    "mfc": "white",
    "linestyle": "none",
}
CHECK_MARKS = 24  # on a line
MARKERS = {
    "A": "s",
    "B": "o",
    "Bbar": "^",
    "Bhat": "D",
    "mix": "P",
    "Bhat_prime": "v",
    "C": "*",
    "C_solid": "X",
}
STYLE: Any = {"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.2, "figure.dpi": 110}
INVISIBLE = 1e-9  # of a dimensionless IC
ON_HUB = 1e-9  # of its depth: a contour that ends there ends on the hub
LEAST_DRAWN = 1e-6  # error: less is rounding
HALF_WINDOW = 1.4  # of the zoomed section, in reach of the longest line


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG and return its path."""
    figure.savefig(path)
    return path


def sections(scene: Scene) -> Figure:
    """Both sections whole and near the contact, with the patch and the offset lines."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 4.6), layout="constrained")
        whole, near, plan = figure.subplots(1, 3)
        reach = max(np.max(np.abs(line.s)) for line in scene.lines)
        for axes, window in ((whole, None), (near, HALF_WINDOW * reach)):
            for name, colour in (("lower", "tab:blue"), ("upper", "tab:red")):
                _draw_body(axes, scene.bodies[name], name, colour)
            axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]")
            if window:
                axes.set(xlim=(-window, window), ylim=(-window, window))
        _draw_marks(near, scene)
        whole.set_title("sections, clamped at the far arc")
        near.set_title("near the contact")
        near.legend(loc="upper left", fontsize=8)
        _draw_plan(plan, scene)
        return figure


def _draw_body(axes: Axes, body: Body, name: str, colour: str) -> None:
    far = body.domain.far_radius
    start, end = body.s_range
    near = np.linspace(max(start, -0.1 * far), min(end, 0.1 * far), 401)
    s = np.union1d(np.linspace(start, end, 801), near)
    contour = body.contour.position(s)
    clamped = _closing(body, contour[:, -1], contour[:, 0])
    axes.fill(*np.hstack([contour, clamped]), facecolor=colour, alpha=0.15, label=f"{name} body")
    axes.plot(*clamped, color=colour, linewidth=2.5)
    axes.plot(*contour, color=colour, linewidth=1)


def _closing(body: Body, right: Array, left: Array) -> Array:
    """Far arc and hub from the contour's right end to its left end, shape (2, n)."""
    return np.hstack([_to_hub(body, right), _to_hub(body, left)[:, ::-1]])


def _to_hub(body: Body, end: Array) -> Array:
    """The far arc from an end of the contour to the hub or the pole; only the end if it lies on the hub."""
    far, (y, z) = body.domain.far_radius, end
    if body.side * z > (1 - ON_HUB) * body.depth:
        return end[:, None]
    ends = np.arctan2(body.side * z, abs(y)), np.arcsin(min(1.0, body.depth / far))
    angle = np.linspace(*ends, 101)
    return far * np.stack([np.sign(y) * np.cos(angle), body.side * np.sin(angle)])


def _draw_marks(axes: Axes, scene: Scene) -> None:
    contour = scene.bodies["lower"].contour
    patch = contour.position(scene.patch.s + np.linspace(-scene.patch.b, scene.patch.b, 9))
    axes.plot(*patch, color="black", linewidth=4, label="patch")
    for line in scene.lines:
        points = contour.position(line.s if line.along == "s" else line.s[:1])
        axes.plot(*points, "k:" if line.along == "s" else "kx", linewidth=1.5, label=f"line {line.name}")
    if contour.joints:
        axes.plot(
            *contour.position(np.array(contour.joints)),
            "ko",
            markersize=4,
            mfc="white",
            label="arc/flank joint",
        )


def _draw_plan(axes: Axes, scene: Scene, side: int = 1) -> None:
    """Lines and patch on the developed surface; side -1: mirrored in s."""
    for line in scene.lines:
        axes.plot(side * line.s, line.x, linewidth=1.2, label=f"line {line.name}")
    a, b, centre = scene.patch.a, scene.patch.b, side * scene.patch.s
    axes.fill(centre + b * np.array([-1, 1, 1, -1]), [-a, -a, a, a], color="black", label="patch")
    for s in scene.bodies["lower"].contour.joints:
        axes.axvline(side * s, color="grey", linestyle=":", linewidth=1)
    axes.set(xlabel="s [mm]", ylabel="x [mm]", title="developed surface")
    axes.legend(loc="upper left", fontsize=8)


def _mark_joints(axes: Axes, scene: Scene, at: Array) -> None:
    """Dotted lines where arcs and flanks join, within the range `at` of s / L."""
    joints = {round(s, 9) for body in scene.bodies.values() for s in body.contour.joints}
    inside = [s / scene.reference_length for s in joints if at[0] <= s / scene.reference_length <= at[-1]]
    for s in inside:
        axes.axvline(s, color="grey", linestyle=":", linewidth=1, label="_joint")
    if inside:
        axes.annotate(
            " flank",
            (max(inside), 0.02),
            xycoords=("data", "axes fraction"),
            fontsize=7,
            color="grey",
            ha="left",
            va="bottom",
        )


def curves(results: Results, dataset: xr.Dataset, component: str) -> Figure:
    """One component along every line (columns) for every body (rows), dimensionless."""
    scene = results.scene
    with mpl.rc_context(STYLE):
        rows, columns = len(scene.compared), len(scene.lines)
        figure = Figure(figsize=(4.1 * columns, 2.7 * rows + 0.6), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False)
        for r, body in enumerate(scene.compared):
            for c, line in enumerate(scene.lines):
                on_line = dataset.isel(point=results.lines[line.name])
                curve = on_line.sel(body=body, i=component[0], j=component[1])
                _draw_curve(grid[r, c], scene, line, curve)
                if c == 0:
                    grid[r, c].set_ylabel(f"{body}\nIC · E · L  [-]")
                if r == 0:
                    grid[r, c].set_title(f"{component} on {line.name}")
                if r == rows - 1:
                    grid[r, c].set_xlabel(f"{line.along} / L  [-],  L = {scene.reference_length:g} mm")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
        return figure


def _draw_curve(axes: Axes, scene: Scene, line: OffsetLine, curve: xr.Dataset) -> None:
    shown = _shown(scene, line)
    at = line.running[shown] / scene.reference_length
    draw_curve(axes, at, curve.isel(point=shown))
    if line.along == "s":
        _mark_joints(axes, scene, at)


def draw_curve(axes: Axes, at: Array, curve: xr.Dataset) -> None:
    """One component on one line, dimensionless: C with its error band, and every approximation.

    `curve` is a part of the dataset of `compare.dataset.to_dataset` with the dims variant and point,
    drawn against the abscissas `at`.
    """
    unit = curve.reference_E * curve.reference_length
    c, band = curve.ic.sel(variant="C").values * unit, curve.estimate.values * unit
    axes.fill_between(at, c - band, c + band, color="black", alpha=0.2, linewidth=0, label="C ± estimate")
    if "C_solid" in curve.variant:
        marked = slice(None, None, max(1, len(at) // CHECK_MARKS))
        values, known = curve.ic.sel(variant="C_solid").values * unit, curve.estimate_solid.values * unit
        label = SYMBOLS["C_solid"] + " ± estimate"
        axes.errorbar(at[marked], values[marked], known[marked], label=label, zorder=2, **CHECK)
    drawn = [variant for variant in curve.variant.values if variant in STYLES]
    for variant in sorted(drawn, key=list(STYLES).index, reverse=True):
        values = curve.ic.sel(variant=variant).values * unit
        if not np.all(np.isnan(values)):
            axes.plot(at, values, label=SYMBOLS[variant], **STYLES[variant])
    show_zero(axes)


def show_zero(axes: Axes) -> None:
    """A curve that vanishes by symmetry is shown as a line, not as blown-up rounding noise."""
    if max(np.max(np.abs(drawn.get_ydata())) for drawn in axes.get_lines()) < INVISIBLE:
        axes.set_ylim(-1e-3, 1e-3)
        axes.annotate("0 by symmetry", (0.5, 0.6), xycoords="axes fraction", ha="center", color="grey")


def _shown(scene: Scene, line: OffsetLine) -> NDArray[np.bool_]:
    """The half of a line that symmetry does not repeat."""
    mirrored = scene.patch.s == 0 and all(body.contour.symmetric for body in scene.bodies.values())
    symmetric = line.along == "x" or mirrored
    return line.running >= (0 if symmetric else -np.inf)


def error_against_seconds(results: Results, errors: xr.Dataset) -> Figure:
    """Worst error of each variant over all lines against the seconds that it took, per body."""
    scene = results.scene
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.1 * len(scene.compared), 3.8), layout="constrained")
        grid = figure.subplots(1, len(scene.compared), squeeze=False, sharey=True)[0]
        for axes, body in zip(grid, scene.compared, strict=True):
            of_body = errors.sel(body=body)
            for variant in results.variants:
                if not np.isnan(results.seconds[variant, body]):
                    _draw_errors(axes, results.seconds[variant, body], of_body.sel(variant=variant), scene)
            axes.set(title=body, xlabel=f"seconds for {len(results.points.x)} points [s]")
        grid[0].set_ylabel("worst error over the lines [-],\none mark per component")
        grid[0].legend()
        return figure


def _draw_errors(axes: Axes, seconds: float, of_variant: xr.Dataset, scene: Scene) -> None:
    """A mark per component; hollow where C vanishes, whose errors are shares of 0.05 max |C_nn|."""
    worst, name = of_variant.error.max("line"), str(of_variant.variant.item())
    style = {"color": STYLES.get(name, CHECK)["color"], "linestyle": "none", "marker": MARKERS[name]}
    marked = [
        (max(worst.sel(i=c[0], j=c[1]).item(), LEAST_DRAWN), bool(of_variant.vanishes.sel(i=c[0], j=c[1])))
        for c in scene.components
    ]
    for gone, label in ((False, SYMBOLS[name]), (True, "_zeros")):
        values = [value for value, vanishes in marked if vanishes == gone]
        more = " (estimate; all its models)" if name == "C" and not gone else ""
        fill = {"mfc": "none"} if gone else {}
        axes.loglog([seconds] * len(values), values, label=label + more, **style, **fill)
    if any(gone for _, gone in marked):
        axes.set_title("hollow: C vanishes, share of 0.05 C_nn", loc="right", fontsize=7, color="grey", y=0.0)


def surface_mesh(chart: MeshTri, scene: Scene, body: str, *, side: int) -> Figure:
    """The contact surface's mesh in its chart (x, s): where the lines run, and near the patch.

    side -1: the model is the mirror image of the side of the patch.
    """
    x, s = chart.p
    with mpl.rc_context(STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(10, 4.8), layout="constrained")
        reach = max(float(np.max(np.abs(line.running))) for line in scene.lines)
        windows = {
            "where the lines run": (0.0, 1.2 * reach),
            "near the patch": (side * scene.patch.s, 8 * max(scene.patch.a, scene.patch.b)),
        }
        for axes, (title, (centre, window)) in zip(figure.subplots(1, 2), windows.items(), strict=True):
            axes.triplot(s, x, chart.t.T, linewidth=0.3, color="tab:blue")
            _draw_plan(axes, scene, side)
            axes.set(xlim=(max(s.min(), centre - window), centre + window), ylim=(0, window))
            axes.set(aspect="equal", title=title)
            axes.get_legend().remove()
        figure.suptitle(f"surface mesh of the {body} body (modelled part; the rest follows by symmetry)")
        return figure


def section_mesh(vertices: Array, triangles: NDArray[np.int64], scene: Scene, body: str) -> Figure:
    """The section's mesh, whole and near the patch."""
    y, z = vertices
    with mpl.rc_context(STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(10, 4.8), layout="constrained")
        at_y, at_z = scene.bodies[body].contour.position(scene.patch.s)
        near = 8 * max(scene.patch.a, scene.patch.b)
        whole, close = figure.subplots(1, 2)
        for axes in (whole, close):
            axes.triplot(y, z, triangles.T, linewidth=0.3, color="tab:blue")
            axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]")
        whole.set_title(f"{triangles.shape[1]:,} cells")
        close.set(title="near the patch", xlim=(at_y - near, at_y + near), ylim=(at_z - near, at_z + near))
        half = " (y ≥ 0: the other half is its mirror image)" if np.min(y) >= 0 else ""
        figure.suptitle(f"section of the {body} body{half}")
        return figure
