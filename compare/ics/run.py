"""`femic run` computes a scene and writes its results, figures and report into a folder."""

import logging
from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from compare.ics import dataset as data
from compare.ics import sections
from compare.ics.compute import Results, compute
from compare.ics.curves import curves
from compare.ics.fields import write_fields
from compare.ics.figures import error_against_seconds
from compare.ics.page import page_of
from compare.report import views
from compare.report.parts import Picture, write_page
from femic.cache import folders
from femic.cache.files import write_dataset, write_text
from femic.reference.engine import Fields
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes import receipts
from femic.scenes.scene import Scene

COMMAND = "run"
FILES = ("ics.nc", "errors.nc", "report.html")

log = logging.getLogger(__name__)


def run_scene(scene: Scene, out: Path, options: RunOptions = DEFAULT) -> Path:
    """Compute the scene; write `ics.nc`, `errors.nc`, CSV files, figures and `report.html`; return its path.

    Solved models are stored, so that an interrupted run continues after the last of them.
    """
    with receipts.renewed(out, COMMAND, key_of(scene), FILES):
        results = compute(scene, options)
        dataset = data.to_dataset(results)
        errors = data.errors(results, dataset)
        write_dataset(dataset, out / "ics.nc")
        write_dataset(errors, out / "errors.nc")
        data.write_curves(dataset, scene.components, out)
        write_text(scene.text, out / "scene.toml")
        figures = draw(results, dataset, errors, folders.make(out / "figures"))
        path = write_page(page_of(results, errors, figures), out / "report.html")
        if scene.fields:
            write_fields(results, out / "fields", options.watch)
    return path


def key_of(scene: Scene) -> str:
    """Return the key of all inputs of the ICs and errors of a scene."""
    return receipts.key_of(scene, data.__name__)


def draw(results: Results, dataset: xr.Dataset, errors: xr.Dataset, folder: Path) -> dict[str, list[Picture]]:
    """Return the figures of the page by section; 3D pictures are written into the folder of figures."""
    scene = results.scene
    return {
        "scene": [
            Picture("sections", sections.sections(scene)),
            *_draw_sections(results),
            *_draw_meshes(results, scene.settings.engine.fields, folder),
        ],
        "curves": [
            Picture(f"curves_{component}", curves(results, dataset, component))
            for component in scene.components
        ],
        "cost": [Picture("error_against_seconds", error_against_seconds(results, errors))],
    }


def _draw_sections(results: Results) -> Iterator[Picture]:
    """Yield the section mesh of each solved body that has one."""
    for name, reference in results.references.items():
        if reference.drawn is not None:
            yield Picture(f"mesh_{name}", sections.section_mesh(*reference.drawn, results.scene, name))


def _draw_meshes(results: Results, fields: Fields | None, folder: Path) -> Iterator[Picture]:
    """Yield the mesh of each solved body, if this machine draws in 3D, and the last body's surface mesh."""
    if fields is None:
        return
    in_3d = views.can_render()
    if not in_3d:
        log.warning(f"no 3D pictures of the meshes: {views.NO_RENDERING}. All other figures are drawn")
    for name, job in results.jobs.items():
        solid = fields.mesh(job.request(results.references[name].level))
        side = -1 if solid.half_section and job.patch.s < 0 else 1  # a half section models s >= 0 only
        if in_3d:
            path = folder / f"mesh_{name}.png"
            patch = job.body.surface.position(0.0, side * job.patch.s)
            title = f"{name} body, {solid.mesh.nelements:,} cells"
            vertices = solid.nodes[:, : solid.n_vertices]
            views.draw_mesh(vertices, solid.mesh.t, patch, path, title=title)
            yield Picture(path.stem, path)
    surface = sections.surface_mesh(solid.trace.basis.mesh, results.scene, name, side=side)
    yield Picture("mesh_surface", surface)
