"""`femic run` computes a scene and writes its results, figures and report into a folder."""

import logging
from pathlib import Path

import xarray as xr

from compare.ics import dataset as data
from compare.ics import page
from compare.ics.compute import Results, compute
from compare.ics.fields import write_fields
from compare.ics.figures import error_against_seconds
from compare.report import sections, views
from compare.report.curves import curves
from compare.report.styles import save
from femic.cache import folders
from femic.cache.files import write_dataset, write_text
from femic.reference.engine import Fields
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes import receipts
from femic.scenes.scene import Scene

COMMAND = "run"

log = logging.getLogger(__name__)


def run_scene(scene: Scene, out: Path, options: RunOptions = DEFAULT) -> Path:
    """Compute the scene; write `ics.nc`, `errors.nc`, CSV files, figures and `report.html`; return its path.

    Solved models are kept in the store, so that an interrupted run continues after the last of them.
    """
    folders.make(out)
    receipts.withdraw(out, COMMAND)
    results = compute(scene, options)
    dataset = data.to_dataset(results)
    errors = data.errors(results, dataset)
    write_dataset(dataset, out / "ics.nc")
    write_dataset(errors, out / "errors.nc")
    data.write_curves(dataset, scene.components, out)
    write_text(scene.text, out / "scene.toml")
    figures = draw(results, dataset, errors, out / "figures")
    path = page.write(out / "report.html", results, errors, figures)
    if scene.fields:
        write_fields(results, out / "fields", options.watch)
    receipts.leave(out, COMMAND, key_of(scene), ["ics.nc", "errors.nc", path.name])
    return path


def key_of(scene: Scene) -> str:
    """The key of all that the ICs and errors of a scene depend on."""
    return receipts.key_of(scene, data.__name__)


def draw(results: Results, dataset: xr.Dataset, errors: xr.Dataset, folder: Path) -> dict[str, list[Path]]:
    """Draw all figures of the report as PNG files; returns their paths by the part of the report."""
    scene = results.scene
    folder.mkdir(exist_ok=True)
    return {
        "scene": [
            save(sections.sections(scene), folder / "sections.png"),
            *_draw_sections(results, folder),
            *_draw_meshes(results, scene.settings.engine.fields, folder),
        ],
        "curves": [
            save(curves(results, dataset, component), folder / f"curves_{component}.png")
            for component in scene.components
        ],
        "cost": [save(error_against_seconds(results, errors), folder / "error_against_seconds.png")],
    }


def _draw_sections(results: Results, folder: Path) -> list[Path]:
    """Draw the section mesh of each solved body that has one; returns the paths."""
    return [
        save(sections.section_mesh(*reference.drawn, results.scene, name), folder / f"mesh_{name}.png")
        for name, reference in results.references.items()
        if reference.drawn is not None
    ]


def _draw_meshes(results: Results, fields: Fields | None, folder: Path) -> list[Path]:
    """Draw the mesh of each solved body, if this machine can draw in 3D, and the last body's surface mesh."""
    if fields is None:
        return []
    paths = []
    in_3d = views.can_render()
    if not in_3d:
        log.warning(f"no 3D pictures of the meshes: {views.NO_RENDERING}. All other figures are drawn")
    for name, job in results.jobs.items():
        solid = fields.mesh(job.request(results.references[name].level))
        side = -1 if solid.half_section and job.patch.s < 0 else 1  # a half section models s >= 0 only
        if in_3d:
            paths.append(folder / f"mesh_{name}.png")
            patch = job.body.surface.position(0.0, side * job.patch.s)
            title = f"{name} body, {solid.mesh.nelements:,} cells"
            vertices = solid.nodes[:, : solid.n_vertices]
            views.draw_mesh(vertices, solid.mesh.t, patch, paths[-1], title=title)
    surface = sections.surface_mesh(solid.trace.basis.mesh, results.scene, name, side=side)
    paths.append(save(surface, folder / "mesh_surface.png"))
    return paths
