"""The figures of the report of `femic run`; a new figure is one more entry of `FIGURES`."""

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.ics import sections
from compare.ics.compute import Results
from compare.ics.curves import curves
from compare.report import views
from compare.report.panels import figure_grid
from compare.report.parts import Picture
from compare.report.styles import MARKERS, STYLES, SYMBOLS
from femic.scenes.scene import Scene

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


def pictures(output: RunOutput, section: str) -> Iterator[Picture]:
    """Yield the figures of a section of `FIGURES`; 3D pictures are written into the folder of figures."""
    for draw in FIGURES[section]:
        yield from draw(output)


def _scene(output: RunOutput) -> Iterator[Picture]:
    yield Picture("sections", sections.sections(output.results.scene))


def _section_meshes(output: RunOutput) -> Iterator[Picture]:
    """Yield the section mesh of each solved body that has one."""
    for body, reference in output.results.references.items():
        if reference.drawn is not None:
            figure = sections.section_mesh(*reference.drawn, output.results.scene, body)
            yield Picture(f"mesh_{body}", figure)


def _solid_meshes(output: RunOutput) -> Iterator[Picture]:
    """Yield the mesh of each solved body, if this machine draws in 3D, and the last body's surface mesh."""
    results = output.results
    fields = results.scene.settings.engine.fields
    if fields is None:
        return
    in_3d = views.can_render()
    if not in_3d:
        log.warning(f"no 3D pictures of the meshes: {views.NO_RENDERING}. All other figures are drawn")
    for body, job in results.jobs.items():
        solid = fields.mesh(job.request(results.references[body].level))
        side = -1 if solid.half_section and job.patch.s < 0 else 1  # a half section models s >= 0 only
        if in_3d:
            path = output.folder / f"mesh_{body}.png"
            patch = job.body.surface.position(0.0, side * job.patch.s)
            title = f"{body} body, {solid.mesh.nelements:,} cells"
            vertices = solid.nodes[:, : solid.n_vertices]
            views.draw_mesh(vertices, solid.mesh.t, patch, path, title=title)
            yield Picture(path.stem, path)
    surface = sections.surface_mesh(solid.trace.basis.mesh, results.scene, body, side=side)
    yield Picture("mesh_surface", surface)


def _curves(output: RunOutput) -> Iterator[Picture]:
    scene = output.results.scene
    for component in scene.components:
        yield Picture(f"curves_{component}", curves(scene, output.ics, component))


def _cost(output: RunOutput) -> Iterator[Picture]:
    yield Picture("error_against_seconds", error_against_seconds(output.results, output.errors))


FIGURES: dict[str, tuple[Callable[[RunOutput], Iterator[Picture]], ...]] = {
    SCENE: (_scene, _section_meshes, _solid_meshes),
    CURVES: (_curves,),
    COST: (_cost,),
}


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
