"""The scripts in examples/, at a coarse size: their pictures, and what they show."""

import runpy
from dataclasses import replace
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.image import imread

import femic
from approx.forms import FORMS
from approx.variants import VARIANTS
from compare.report.looks import OWN
from compare.report.static import line_style
from geometries.materials import both_bodies

EXAMPLES = Path(__file__).parent.parent / "examples"
FEW = 8  # elements across a patch
COARSE = 0.2  # about where cells stop growing with the tolerance (femic.reference.result.cells_for)
DRAWN = 100  # pixels that are in the colour of a curve, at least


@pytest.fixture(autouse=True)
def registries():
    """Restore the registries of forms and approximations, to which examples add their own."""
    before = [(registry, dict(registry)) for registry in (FORMS, VARIANTS)]
    yield
    for registry, entries in before:
        registry.clear()
        registry.update(entries)


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    """Folder and returned numbers of an example, which runs once."""

    @cache
    def run(name):
        out = tmp_path_factory.mktemp(name)
        return out, script(name).main(out=out, tolerance=COARSE, **KEYS.get(name, {}))

    return run


def script(name):
    spec = spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


LONG = {"custom_section", "flank_sweep", "cylinder_factor", "elliptic_wheel", "dissimilar_bodies"}
KEYS = {"dissimilar_bodies": {"elements": FEW}}
DRAWS = {"elliptic_wheel": (), "dissimilar_bodies": ("A", "Bhat", "mix", "Bhat_prime", "C")}


def names():
    """All examples; the long ones are slow."""
    examples = sorted(path.stem for path in EXAMPLES.glob("*.py"))
    return [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in examples]


@pytest.mark.filterwarnings("ignore:Cyclopts application invoked without tokens")
@pytest.mark.parametrize("name", names())
def test_the_picture_shows_the_curves_and_a_second_run_from_the_shell_solves_nothing(
    name, outcome, monkeypatch
):
    out, _ = outcome(name)
    picture = out / f"{name}.png"
    pixels = imread(picture)[..., :3]
    for variant in DRAWS.get(name, ("A", "B", "Bhat", "C")):
        drawn = np.all(np.abs(pixels - to_rgb(line_style(OWN[variant])["color"])) < 1 / 255, axis=-1)
        assert np.count_nonzero(drawn) > DRAWN, variant
    before, path = solved(out), str(EXAMPLES / f"{name}.py")
    picture.unlink()
    keys = [word for key, value in KEYS.get(name, {}).items() for word in (f"--{key}", str(value))]
    monkeypatch.setattr("sys.argv", [path, "--out", str(out), "--tolerance", str(COARSE), *keys])
    runpy.run_path(path, run_name="__main__")
    assert picture.is_file()
    assert before == solved(out) != {}


def solved(out):
    return {path: path.stat().st_mtime_ns for path in out.rglob("*-*.nc")}


def test_on_the_flank_a_has_the_wrong_sign_and_b_the_right_one(outcome):
    _, sn = outcome("one_figure")
    flank = sn.ic[:, sn.s.values >= 10 * np.radians(25.5)]
    assert np.all(flank.sel(variant=["C", "B", "Bhat"]) < 0)
    assert np.all(flank.sel(variant="A") > 0)


@pytest.mark.slow
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
def test_cylinder_factor_cancels_for_equal_bodies_and_helps_the_upper_body(outcome):
    _, worst = outcome("cylinder_factor")
    b, faded = (worst.sel(variant=variant, line=["s = 1.6 mm", "x = 1.6 mm"]) for variant in ("B", "B_faded"))
    combined = {"scene": "geometry1", "body": "combined"}
    np.testing.assert_allclose(faded.sel(combined), b.sel(combined), rtol=1e-12)
    assert np.all(faded.sel(body="upper") < b.sel(body="upper"))
    lower = (faded / b).sel(body="lower")
    assert np.all(lower.sel(line="x = 1.6 mm") < 1)
    assert np.all(lower.sel(line="s = 1.6 mm") > 1.5)


KNOWN = 0.003  # tolerance with which the difference of the wheels is known


@pytest.mark.slow
def test_c_of_the_elliptic_wheel_differs_from_the_arc_by_a_quarter_percent(tmp_path):
    result = script("elliptic_wheel").main(out=tmp_path, tolerance=KNOWN)
    assert 0.002 < float(result.difference.max()) < 0.0025
    assert np.all(result.difference.sel(component=["xn", "nn"]) < 0.0008)
    across = result.sel(line="x = 1.6 mm", component=["ss", "sn", "ns", "nn"])
    assert np.all(across.resolved > 3)  # differences are those of the bodies, not errors of C
    assert np.all(np.isnan(result.difference.sel(line="s = 0 mm", component=["xs", "sn", "ns"])))


@pytest.mark.slow
def test_an_ellipse_of_equal_axes_is_the_arc(tmp_path):
    """Another contour of the same shape: C differs by less than the estimates."""
    example, options = script("elliptic_wheel"), femic.Options(COARSE, store=str(tmp_path))
    circle = replace(example.GEOMETRY_2.upper, contour=femic.ellipse(10.1, 10.1, 60.0))
    arc, ellipse = (example.wheel(body, options) for body in (example.GEOMETRY_2.upper, circle))
    result = example.differences(arc, ellipse)
    assert float(result.resolved.max()) < 0.01


@pytest.mark.slow
def test_moduli_keep_the_combined_compliance_and_only_k_of_a_changes():
    example = script("dissimilar_bodies")
    stiff_wheel, stiff_rail, alike = (
        both_bodies(pair.upper.material, pair.lower.material)
        for pair in (example.with_ratio(example.PAIR, ratio) for ratio in (10.0, 0.1, 1.0))
    )
    for pair in (stiff_wheel, stiff_rail):
        assert pytest.approx(alike.G, rel=1e-14) == pair.G
        assert pair.nu == pytest.approx(alike.nu, rel=1e-14)
    assert stiff_wheel.mismatch_k == pytest.approx(-stiff_rail.mismatch_k, rel=1e-13)
    assert alike.mismatch_k == 0.0


@pytest.mark.slow
def test_bhat_prime_covers_the_mismatch_of_moduli_and_their_c_is_not_solved_again(outcome):
    """A fit and a grid need two models of each body; C is linear in 1 / E at the same Poisson's ratio."""
    out, result = outcome("dissimilar_bodies")
    assert result.sizes["ratio"] == 5
    assert len({path.name for path in out.rglob("harmonic-*.nc")}) == 4
    mismatched = result.sel(ratio=[0.1, 10.0])
    assert np.all(mismatched.rms.sel(ics="Bhat_prime") < mismatched.rms.sel(ics="Bhat"))
    assert np.all(result.rms.sel(ics="C") == 0)
