"""The charts and pictures of the report of `femic run`; a new one is one more entry of `FIGURES`."""

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import xarray as xr

from compare.ics import curves, sections
from compare.ics.compute import Results
from compare.report import views
from compare.report.charts import Chart, Curve, Panel, chart_of
from compare.report.looks import Look, looks_of, symbol_of
from compare.report.parts import Picture
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


def figures(output: RunOutput, section: str) -> Iterator[Picture | Chart]:
    """Yield charts and pictures of a section of `FIGURES`; those in 3D are written into the folder."""
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


def _curves(output: RunOutput) -> Iterator[Chart]:
    yield curves.chart(output.results.scene, output.ics)


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
    """Yield a mark per component, hollow if it vanishes in C: its error is then a of 0.05 max |C_nn|."""
    worst, name = variant_errors.error.max("line"), str(variant_errors.variant.item())
    hollow_look = replace(look, dash="", marker=f"{look.marker.removesuffix('-open')}-open")
    for hollow, marked in ((True, hollow_look), (False, replace(look, dash=""))):
        values = [
            max(worst.sel(i=c[0], j=c[1]).item(), LEAST_DRAWN)
            for c in scene.components
            if bool(variant_errors.vanishes.sel(i=c[0], j=c[1])) == hollow
        ]
        if values:
            yield Curve(symbol_of(name), [seconds] * len(values), values, marked)
