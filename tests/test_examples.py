"""The scripts in examples/, at a coarse size: their pictures, and what they show."""

import runpy
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.image import imread

from compare.pages.styles import STYLES

EXAMPLES = Path(__file__).parent.parent / "examples"
COARSE = 0.2  # about where cells stop growing with the tolerance (femic.reference.cells_for)
DRAWN = 100  # pixels that are in the colour of a curve, at least


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    """Folder and returned numbers of an example, which runs once."""
    found = {}

    def run(name):
        if name not in found:
            out = tmp_path_factory.mktemp(name)
            found[name] = out, script(name).main(out=out, tolerance=COARSE)
        return found[name]

    return run


def script(name):
    spec = spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


LONG = {"flank_sweep", "cylinder_factor"}


def names():
    """All examples; the long ones are slow."""
    found = sorted(path.stem for path in EXAMPLES.glob("*.py"))
    return [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in found]


@pytest.mark.parametrize("name", names())
def test_the_picture_shows_the_curves(name, outcome):
    out, _ = outcome(name)
    pixels = imread(out / f"{name}.png")[..., :3]
    for variant in ("A", "B", "Bhat", "C"):
        drawn = np.all(np.abs(pixels - to_rgb(STYLES[variant]["color"])) < 1 / 255, axis=-1)
        assert np.count_nonzero(drawn) > DRAWN, variant


@pytest.mark.filterwarnings("ignore:Cyclopts application invoked without tokens")
@pytest.mark.parametrize("name", names())
def test_a_second_run_from_the_shell_solves_nothing_again(name, outcome, monkeypatch):
    out, _ = outcome(name)
    before = solved(out)
    (out / f"{name}.png").unlink()
    path = str(EXAMPLES / f"{name}.py")
    monkeypatch.setattr("sys.argv", [path, "--out", str(out), "--tolerance", str(COARSE)])
    runpy.run_path(path, run_name="__main__")
    assert (out / f"{name}.png").is_file()
    assert before == solved(out) != {}


def solved(out):
    return {path: path.stat().st_mtime_ns for path in out.rglob("*-*.nc")}


def test_on_the_flank_a_has_the_wrong_sign_and_b_the_right_one(outcome):
    _, sn = outcome("one_figure")
    flank = sn.ic[:, sn.s.values >= 10 * np.radians(25.5)]
    assert np.all(flank.sel(variant=["C", "B", "Bhat"]) < 0)
    assert np.all(flank.sel(variant="A") > 0)


def test_the_rail_head_is_known_to_the_tolerance(outcome):
    _, worst = outcome("custom_section")
    assert np.all(worst.sel(variant="C") <= COARSE)
    a, b, b_hat = worst.sel(i="s", variant=["A", "B", "Bhat"])
    assert b < b_hat < 0.5
    assert a > 1  # wrong sign


@pytest.mark.slow
def test_errors_grow_with_the_flanks(outcome):
    _, worst = outcome("flank_sweep")
    planes, steepest = worst.sel(angle=0), worst.sel(angle=60)
    assert np.all(planes <= planes.sel(variant="C"))  # on planes all are exact
    assert np.all(worst.sel(i="n", variant="A").diff("angle") > 0)
    assert np.all((steepest > worst.sel(angle=15)).sel(i="s", variant=["B", "Bhat"]))
    np.testing.assert_allclose(worst.sel(i="s", variant="A")[1:], 1)  # A_sn of equal bodies is 0


@pytest.mark.slow
def test_the_factor_of_the_cylinder_cancels_for_equal_bodies_and_helps_only_the_upper_one_everywhere(outcome):
    _, worst = outcome("cylinder_factor")
    b, faded = (
        worst.sel(variant=variant, line=["s = 1.6 mm", "x = 1.6 mm"]) for variant in ("B", "B with factor")
    )
    combined = {"scene": "geometry1", "body": "combined"}
    np.testing.assert_allclose(faded.sel(combined), b.sel(combined), rtol=1e-12)
    assert np.all(faded.sel(body="upper") < b.sel(body="upper"))
    lower = (faded / b).sel(body="lower")
    assert np.all(lower.sel(line="x = 1.6 mm") < 1)
    assert np.all(lower.sel(line="s = 1.6 mm") > 1.5)
