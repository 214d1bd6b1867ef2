"""`femic run` computes a scene and writes its results, figures and report into a folder."""

from pathlib import Path

from compare.ics import dataset as data
from compare.ics.compute import compute
from compare.ics.fields import write_fields
from compare.ics.figures import RunOutput
from compare.ics.page import page_of
from compare.report.parts import write_page
from femic.cache import folders
from femic.cache.files import write_dataset, write_text
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes import receipts
from femic.scenes.scene import Scene

COMMAND = "run"
FILES = ("ics.nc", "errors.nc", "report.html")


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
        output = RunOutput(results, dataset, errors, folders.make(out / "figures"))
        path = write_page(page_of(output), out / "report.html")
        if scene.fields:
            write_fields(results, out / "fields", options.watch)
    return path


def key_of(scene: Scene) -> str:
    """Return the key of all inputs of the ICs and errors of a scene."""
    return receipts.key_of(scene, data.__name__)
