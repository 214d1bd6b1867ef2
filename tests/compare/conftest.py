"""Scenes that are small enough to run in a test, and Geometry 1 solved once for many."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from femic.reference.engines import SOLID
from femic.reference.run_options import RunOptions
from femic.results.ics import compute, refinement_shares
from femic.results.ics_dataset import errors, to_dataset
from femic.scenes.load import load_scene
from tests.coarse import tuned_sections

COARSE_ENGINE = """
[engine]
kind = "solid"
smallest_cell = 0.1
growth = 0.5
line_growth = 0.4
far_radius = 60.0
half_length = 60.0
tolerance = 0.5
"""
FINER_ENGINE = COARSE_ENGINE.replace("growth = 0.5", "growth = 0.3").replace(
    "line_growth = 0.4", "line_growth = 0.2"
)
SHORT_LINES = """
[[lines]]
along = "x"
s = 1.6
reach = 6.0
points = 25
[[lines]]
along = "s"
x = 1.6
reach = 6.0
points = 25
"""
BODY = """
[{name}]
E = {E}
nu = 0.3
contour = {{ kind = "arc", radius = 10.0, flank_inclination_deg = {flanks} }}
"""


def scene_text(top="", *, flanks="25.0", engine=COARSE_ENGINE, lines=SHORT_LINES, upper_E=210e3):
    bodies = BODY.format(name="lower", E=210e3, flanks=flanks) + BODY.format(
        name="upper", E=upper_E, flanks=flanks
    )
    top = f"rotation_reach = 10.0\n{top}"
    return f"{top}\n{bodies}\n[patch]\na = 0.3\nb = 0.2\n{lines}\n{engine}"


@pytest.fixture
def write_scene(tmp_path):
    def write(*arguments, **named) -> Path:
        path = tmp_path / "mine.toml"
        path.write_text(scene_text(*arguments, **named), encoding="utf-8")
        return path

    return write


@pytest.fixture
def as_tuned():
    """C as accurate as everywhere, in a file of tests with coarse C."""
    with tuned_sections():
        yield


@pytest.fixture(scope="session")
def geometry1():
    """Geometry 1 by the harmonic engine at tolerance 0.001: (results, dataset, errors)."""
    results = compute(
        load_scene("geometry1", {"engine": {"check": False, "tolerance": 0.001}}), RunOptions(2)
    )
    dataset = to_dataset(results)
    return results, dataset, errors(results, dataset)


@pytest.fixture(scope="session")
def geometry1_checked():
    """The same with the solid engine's C at tolerance 3 % (a minute and a half)."""
    scene = load_scene("geometry1")
    cells = SOLID.first_cells(0.03, scene.patch)
    check = replace(scene.check, settings=replace(scene.check.settings, tolerance=0.03, cells=cells))
    results = compute(replace(scene, check=check), RunOptions(1))
    dataset = to_dataset(results)
    return results, dataset, errors(results, dataset)


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """Results of a coarse scene with unlike bodies: (results, dataset, errors)."""
    path = tmp_path_factory.mktemp("scenes") / "small.toml"
    path.write_text(scene_text(upper_E=70e3, engine=FINER_ENGINE), encoding="utf-8")
    results = compute(load_scene(str(path)), RunOptions(1))
    dataset = to_dataset(results)
    return results, dataset, errors(results, dataset)


def estimated_errors(results):
    """Estimated errors of C by (solved body, line), (3, 3): shares of the scale of refinement."""
    return {
        (body, line): errors
        for body, reference in results.references.items()
        for line, errors in refinement_shares(results, body, reference.c.estimate).items()
    }


def on_line(dataset, line):
    return dataset.isel(point=np.flatnonzero(dataset.line.values == line))
