"""The charts and pictures of the page of `femic run`; a new one is one more entry of `FIGURES`.

They are curves of ICs along lines, drawn from the dataset of `femic.results.ics_dataset.to_dataset`; sections
of the scene, its developed surface, and the meshes of its bodies; and errors over seconds.
"""

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from skfem import MeshTri

from compare.report import static, views
from compare.report.charts import Chart, Curve, Panel, chart_of, mark_points
from compare.report.looks import Look, drawing_order, looks_of, symbol_of
from compare.report.parts import Picture
from compare.report.static import RC
from femic.results.ics import Results
from femic.scenes.scene import Scene
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.patches import OffsetLine

# --- curves along lines ---------------------------------------------------------------------------------


INVISIBLE = 1e-9  # dimensionless IC below which a curve is rounding
ESTIMATES = {"C": "estimate", "C_solid": "estimate_solid"}  # variables with the errors of both engines
MOST_COLUMNS = 4


@dataclass(frozen=True)
class Units:
    """Factors of lengths [mm] and of ICs [mm/N] in a chart, and how its axes name them."""

    length: float
    ic: float
    across: str
    up: str
    rounding: float  # IC that is shown as zero


def absolute(dataset: xr.Dataset) -> Units:
    """Return the units of a scene's own page."""
    ic = 1e6
    return Units(1.0, ic, " [mm]", " [µm/kN]", INVISIBLE * ic / _unit(dataset))


def dimensionless(dataset: xr.Dataset) -> Units:
    """Return the units in which ICs of bodies of other sizes and moduli compare."""
    return Units(1 / dataset.reference_length, _unit(dataset), " / L  [-]", " · E · L  [-]", INVISIBLE)


def _unit(dataset: xr.Dataset) -> float:
    return float(dataset.reference_E * dataset.reference_length)


def chart(scene: Scene, dataset: xr.Dataset) -> Chart:
    """Return the ICs of a scene, a step per component: curves and differences from C, then other bodies."""
    first, *others = combined_first(scene.compared)
    units, steps = absolute(dataset), {}
    for component in scene.components:
        curves_of_first = _panels(scene, dataset, component, [first], units)
        differences = map(of_differences, _panels(scene, minus_c(dataset), component, [first], units))
        curves_of_others = _panels(scene, dataset, component, others, units)
        steps[component] = [*curves_of_first, *differences, *curves_of_others]
    return by_component(steps, len(scene.lines))


def by_component(steps: Mapping[str, Sequence[Panel]], lines: int) -> Chart:
    """Return a chart of panels by component, a column per line; it starts with nn."""
    start = "nn" if "nn" in steps else next(iter(steps))
    columns = min(max(2, lines), MOST_COLUMNS)
    return Chart("curves", steps, columns, "component", heights=0.75, start=start)


def combined_first(bodies: Iterable[str]) -> list[str]:
    """Return bodies in their order, but both together first."""
    return sorted(bodies, key=lambda body: body != "combined")


def main_body(bodies: Iterable[str]) -> str:
    """Return the body that pages speak of: both together, or else the first."""
    return combined_first(bodies)[0]


def curves(scene: Scene, dataset: xr.Dataset, component: str) -> Figure:
    """Return a figure of one component, dimensionless: a row per body, a column per line of the scene."""
    panels = list(_panels(scene, dataset, component, scene.compared, dimensionless(dataset)))
    return static.picture(_chart(panels, dataset, len(scene.lines)))


def _panels(
    scene: Scene, dataset: xr.Dataset, component: str, bodies: Sequence[str], units: Units
) -> Iterator[Panel]:
    """Yield the panels of bodies along the lines of a scene, without halves that symmetry repeats."""
    for body, line in product(bodies, scene.lines):
        part = along_line(dataset, line.name, body, component, units).isel(point=shown_half(scene, line))
        marks = joints(scene, part["at"].values, units) if line.along == "s" else ()
        yield replace(_panel(part, component, units), title=f"{body}, {line.name}", marks=marks)


def chart_in(dataset: xr.Dataset, component: str) -> Chart:
    """Return a chart of one component of labelled ICs, dimensionless: a row per body, a column per line."""
    lines, units = list(dict.fromkeys(dataset.line.values)), dimensionless(dataset)
    panels = [
        replace(
            _panel(along_line(dataset, line, body, component, units), component, units),
            title=f"{component}, {body}, {line}",
        )
        for body, line in product(dataset.body.values, lines)
    ]
    return _chart(panels, dataset, len(lines))


def _chart(panels: Sequence[Panel], dataset: xr.Dataset, columns: int) -> Chart:
    """Return a chart of panels, which name the length that makes abscissas dimensionless."""
    length = f",  L = {dataset.reference_length:g} mm"
    return chart_of("curves", [replace(panel, across=panel.across + length) for panel in panels], columns)


def along_line(dataset: xr.Dataset, line: str, body: str, component: str, units: Units) -> xr.Dataset:
    """Return a component of a body along a line, and its estimates, in units over the coordinate `at`."""
    on_line = dataset.isel(point=np.flatnonzero(dataset.line.values == line))
    along = "x" if np.ptp(on_line.s.values) == 0 else "s"
    curve = on_line.sel(body=body, i=component[0], j=component[1])
    return _scale(curve, units.length * on_line[along].values, units).assign_attrs(
        across=f"{along}{units.across}"
    )


def _scale(curve: xr.Dataset, at: ArrayLike, units: Units) -> xr.Dataset:
    names = [name for name in ("ic", *ESTIMATES.values()) if name in curve]
    return (curve[names] * units.ic).assign_coords(at=("point", np.asarray(at)))


def _panel(part: xr.Dataset, component: str, units: Units) -> Panel:
    """Return the panel of ICs of `along_line`; those that were not computed are left out."""
    names = [str(name) for name in part.variant.values]
    looks = looks_of(names)
    drawn = [name for name in drawing_order(names) if not part.ic.sel(variant=name).isnull().all()]
    return Panel(
        "",
        part.attrs.get("across", ""),
        f"{component}{units.up}",
        [_curve(part, name, looks[name]) for name in drawn],
        least=units.rounding,
    )


def _curve(part: xr.Dataset, name: str, look: Look) -> Curve:
    """Return a curve, with its estimate where it has one; C of the other engine as a few marks."""
    values, estimate = part.ic.sel(variant=name).values, ESTIMATES.get(name, "")
    band = part[estimate].values if estimate in part else None
    return mark_points(Curve(symbol_of(name), part["at"].values, values, look, band))


def minus_c(dataset: xr.Dataset) -> xr.Dataset:
    """Return the differences of ICs from C; what remains of C is its estimate."""
    return dataset.assign(ic=dataset.ic - dataset.ic.sel(variant="C", drop=True))


def of_differences(panel: Panel) -> Panel:
    """Return a panel of curves of `minus_c` with its title."""
    return replace(panel, title=f"{panel.title}: minus C", up=f"Δ{panel.up}")


def draw_curve(axes: Axes, at: ArrayLike, curve: xr.Dataset) -> None:
    """Draw one component on one line, dimensionless: C with its error band, and every approximation.

    `curve` is a part of the dataset of `femic.results.ics_dataset` with the dims variant and point, drawn
    against the abscissas `at`.
    """
    units = dimensionless(curve)
    static.draw_panel(axes, _panel(_scale(curve, at, units), "", units))


def joints(scene: Scene, at: Array, units: Units) -> tuple[float, ...]:
    """Return abscissas of the joints of arcs and flanks, within the range of `at`."""
    places = {units.length * round(s, 9) for body in scene.bodies.values() for s in body.contour.joints}
    return tuple(sorted(place for place in places if at[0] <= place <= at[-1]))


def shown_half(scene: Scene, line: OffsetLine) -> Mask:
    """Return which points of a line are shown, (n,): without the half that symmetry repeats."""
    mirrored = scene.patch.s == 0 and all(body.contour.symmetric for body in scene.bodies.values())
    symmetric = line.along == "x" or mirrored
    return line.running >= (0 if symmetric else -np.inf)


# --- sections and meshes --------------------------------------------------------------------------------


ON_HUB = 1e-9  # share of the depth: a contour that ends closer to the hub ends on it
BESIDE_OUTLINE = 1.1  # half-width of the whole section, over the size of an outline
HALF_WINDOW = 1.4  # half-width of the zoomed section, over the largest |s| of the lines


def sections(scene: Scene) -> Figure:
    """Draw both sections, whole and near the contact, with the patch and the offset lines."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(11, 4.6), layout="constrained")
        whole, near, plan = figure.subplots(1, 3)
        for axes in (whole, near):
            for name, colour in (("lower", "tab:blue"), ("upper", "tab:red")):
                _draw_body(axes, scene.bodies[name], name, colour)
            axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]")
        window = HALF_WINDOW * max(np.max(np.abs(line.s)) for line in scene.lines)
        near.set(xlim=(-window, window), ylim=(-window, window))
        _draw_marks(near, scene)
        outlines = [body.outline.size for body in scene.bodies.values() if body.outline is not None]
        if outlines:  # the other body may have a far arc, and be much larger
            limits = BESIDE_OUTLINE * max(outlines) * np.array([-1, 1])
            whole.set(xlim=limits, ylim=limits)
        whole.set_title("sections, clamped at the thick lines")
        near.set_title("near the contact")
        near.legend(loc="upper left", fontsize=8)
        _draw_plan(plan, scene)
        return figure


def _draw_body(axes: Axes, body: Body, name: str, colour: str) -> None:
    far_radius = body.domain.far_radius
    start, end = body.s_range
    s_near_contact = np.linspace(max(start, -0.1 * far_radius), min(end, 0.1 * far_radius), 401)
    s = np.union1d(np.linspace(start, end, 801), s_near_contact)
    contour = body.contour.position(s)
    free = np.empty((2, 0)) if body.outline is None else body.outline.beyond(body.contour)
    clamped = _closing(body, contour[:, -1], contour[:, 0]) if body.outline is None else body.outline.support
    boundary = np.hstack([contour, clamped if body.outline is None else free])
    axes.fill(*boundary, facecolor=colour, alpha=0.15, label=f"{name} body")
    if body.outline is not None:
        axes.plot(*np.hstack([contour[:, -1:], free, contour[:, :1]]), color=colour, linewidth=1)
    axes.plot(*clamped, color=colour, linewidth=2.5)
    axes.plot(*contour, color=colour, linewidth=1)


def _closing(body: Body, right: Array, left: Array) -> Array:
    """Return points of far arc and hub from the contour's right end to its left end, (2, n) [mm]."""
    return np.hstack([_to_hub(body, right), _to_hub(body, left)[:, ::-1]])


def _to_hub(body: Body, end: Array) -> Array:
    """Return points of the far arc from an end of the contour to the hub or the pole, (2, n) [mm].

    An end that lies on the hub is returned alone.
    """
    far_radius, (y, z) = body.domain.far_radius, end
    if body.side * z > (1 - ON_HUB) * body.depth:
        return end[:, None]
    angles_of_ends = np.arctan2(body.side * z, abs(y)), np.arcsin(min(1.0, body.depth / far_radius))
    angle = np.linspace(*angles_of_ends, 101)
    return far_radius * np.stack([np.sign(y) * np.cos(angle), body.side * np.sin(angle)])


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
    """Draw lines and patch on the developed surface; side -1: mirrored in s."""
    for line in scene.lines:
        axes.plot(side * line.s, line.x, linewidth=1.2, label=f"line {line.name}")
    a, b, centre = scene.patch.a, scene.patch.b, side * scene.patch.s
    axes.fill(centre + b * np.array([-1, 1, 1, -1]), [-a, -a, a, a], color="black", label="patch")
    for s in scene.bodies["lower"].contour.joints:
        axes.axvline(side * s, color="grey", linestyle=":", linewidth=1)
    axes.set(xlabel="s [mm]", ylabel="x [mm]", title="developed surface")
    axes.legend(loc="upper left", fontsize=8)


def surface_mesh(chart: MeshTri, scene: Scene, body: str, *, side: int) -> Figure:
    """Draw the contact surface's mesh in its chart (x, s): where the lines run, and near the patch.

    `side` -1: the model is the mirror image of the side of the patch.
    """
    x, s = chart.p
    with mpl.rc_context(RC | {"axes.grid": False}):
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


def section_mesh(vertices: Array, triangles: Indices, scene: Scene, body: str) -> Figure:
    """Draw the section's mesh, whole and near the patch; vertices (2, n) [mm], triangles (3, m)."""
    y, z = vertices
    with mpl.rc_context(RC | {"axes.grid": False}):
        figure = Figure(figsize=(10, 4.8), layout="constrained")
        patch_y, patch_z = scene.bodies[body].contour.position(scene.patch.s)
        half_window = 8 * max(scene.patch.a, scene.patch.b)
        whole, close_up = figure.subplots(1, 2)
        for axes in (whole, close_up):
            axes.triplot(y, z, triangles.T, linewidth=0.3, color="tab:blue")
            axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]")
        whole.set_title(f"{triangles.shape[1]:,} cells")
        near = np.maximum(np.abs(y - patch_y), np.abs(z - patch_z)) <= half_window
        room = 0.05 * half_window
        close_up.set(
            title="near the patch",
            xlim=(np.min(y[near]) - room, np.max(y[near]) + room),
            ylim=(np.min(z[near]) - room, np.max(z[near]) + room),
        )
        half = " (y ≥ 0: the other half is its mirror image)" if np.min(y) >= 0 else ""
        figure.suptitle(f"section of the {body} body{half}")
        return figure


# --- all figures ----------------------------------------------------------------------------------------


SCENE, CURVES, COST = "The scene", "Influence coefficients along the lines", "Cost"  # sections with figures
LEAST_DRAWN = 1e-6  # error: smaller errors are rounding and are drawn here

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class RunOutput:
    """The results of a run as they are drawn and reported."""

    results: Results
    ics: xr.Dataset
    errors: xr.Dataset
    folder: Path  # of figures


def figures(output: RunOutput, section: str) -> Iterator[Picture | Chart]:
    """Yield charts and pictures of a section of `FIGURES`; those in 3D are written into the folder."""
    for draw in FIGURES[section]:
        yield from draw(output)


def _scene(output: RunOutput) -> Iterator[Picture]:
    yield Picture("sections", sections(output.results.scene))


def _section_meshes(output: RunOutput) -> Iterator[Picture]:
    """Yield the section mesh of each solved body that has one."""
    for body, reference in output.results.references.items():
        if reference.drawn is not None:
            figure = section_mesh(*reference.drawn, output.results.scene, body)
            yield Picture(f"mesh_{body}", figure)


def _solid_meshes(output: RunOutput) -> Iterator[Picture]:
    """Yield the mesh of each solved body, if this machine draws in 3D, and the last body's surface mesh."""
    results = output.results
    engine = results.scene.settings.engine
    if not engine.has_fields:
        return
    in_3d = views.can_render()
    if not in_3d:
        log.warning(f"no 3D pictures of the meshes: {views.NO_RENDERING}. All other figures are drawn")
    for body, job in results.jobs.items():
        solid = engine.mesh(job.request(results.references[body].level))
        side = -1 if solid.half_section and job.patch.s < 0 else 1  # a half section models s >= 0 only
        if in_3d:
            path = output.folder / f"mesh_{body}.png"
            patch = job.body.surface.position(0.0, side * job.patch.s)
            title = f"{body} body, {solid.mesh.nelements:,} cells"
            vertices = solid.nodes[:, : solid.n_vertices]
            views.draw_mesh(vertices, solid.mesh.t, patch, path, title=title)
            yield Picture(path.stem, path)
    surface = surface_mesh(solid.trace.basis.mesh, results.scene, body, side=side)
    yield Picture("mesh_surface", surface)


def _curves(output: RunOutput) -> Iterator[Chart]:
    yield chart(output.results.scene, output.ics)


def _cost(output: RunOutput) -> Iterator[Chart]:
    yield error_against_seconds(output.results, output.errors)


FIGURES: dict[str, tuple[Callable[[RunOutput], Iterator[Picture | Chart]], ...]] = {
    SCENE: (_scene, _section_meshes, _solid_meshes),
    CURVES: (_curves,),
    COST: (_cost,),
}


def error_against_seconds(results: Results, errors: xr.Dataset) -> Chart:
    """Return the worst error of each variant over all lines against its seconds, a panel per body."""
    scene = results.scene
    looks = looks_of(results.variants)
    panels = []
    for body in scene.compared:
        marks = [
            mark
            for name in results.computed(body)
            for mark in _marks(
                errors.sel(body=body, variant=name), results.seconds[name, body], looks[name], scene
            )
        ]
        across = f"seconds for {len(results.points.x)} points [s]"
        panels.append(Panel(body, across, "worst error [-]", marks, log_x=True, log_y=True))
    return chart_of("error_against_seconds", panels, max(2, len(panels)))


def _marks(variant_errors: xr.Dataset, seconds: float, look: Look, scene: Scene) -> Iterator[Curve]:
    """Yield a mark per component, hollow where it vanishes in C: the error is a share of 0.05 max |C_nn|."""
    worst, name = variant_errors.error.max("line"), str(variant_errors.variant.item())
    hollow_look = replace(look, dash="", marker=f"{look.marker.removesuffix('-open')}-open")
    for hollow, mark in ((True, hollow_look), (False, replace(look, dash=""))):
        values = [
            max(worst.sel(i=c[0], j=c[1]).item(), LEAST_DRAWN)
            for c in scene.components
            if bool(variant_errors.vanishes.sel(i=c[0], j=c[1])) == hollow
        ]
        if values:
            yield Curve(symbol_of(name), [seconds] * len(values), values, mark)
