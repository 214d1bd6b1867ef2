"""`femic calibrate-map`: what lies between the nodes, and where a map ends."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from approx.calibration import fit
from approx.effective import EffectiveProperties, Transition
from compare.cli.main import DONE, exit_code
from compare.reports.calibration import maps as calibration_map
from compare.reports.calibration.maps import MOST_GEOMETRIES, Axes, compute_map, fit_at, scene_at
from compare.results.calibration import Calibrated, target_from
from compare.scenes.load import load_scene
from geometries.errors import WrongInput
from tests.compare.conftest import scene_text
from tests.compare.reports.test_calibration import HARMONIC


def smooth(scene, _means):
    """A calibration whose C is B-hat-prime with properties that vary smoothly from node to node."""
    flank = scene.bodies["lower"].contour.inclination(30.0)
    ratio = scene.bodies["upper"].contour.inclination(1.0) / scene.bodies["lower"].contour.inclination(1.0)
    true = EffectiveProperties(mismatch_k=Transition(-0.2 * flank * ratio, 9 + 2 * flank, 0.9, 2 + ratio))
    target = target_from(scene, np.ones((1, 80)))
    target = replace(target, ics=target.of(true))
    return Calibrated(scene, None, {"combined": fit(target)}, {"combined": target})


@pytest.fixture(scope="module")
def synthetic(tmp_path_factory):
    """A map of four by four nodes whose truth is known, and its base."""
    path = tmp_path_factory.mktemp("map") / "mine.toml"
    path.write_text(scene_text(engine=HARMONIC), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(calibration_map, "calibrate", smooth)
        return compute_map(str(path), Axes((20.0, 30.0, 40.0, 50.0), (1.0, 1.2, 1.5, 2.0))), path


def test_a_map_knows_what_lies_between_its_nodes(synthetic):
    found, _ = synthetic
    assert found.sizes["left_out"] == 9
    worst = found.residual.sel(measure="worst")
    assert worst.sel(by="fit").max() < 1e-6
    assert worst.sel(by="map").max() < 0.01
    assert worst.sel(by="Bhat").min() > 0.5
    middle = fit_at(found, 33.0, 1.3).effective.mismatch_k
    assert middle.far == pytest.approx(-0.2 * np.radians(33) / 1.3, rel=0.02)
    assert middle.r_inf == pytest.approx(9 + 2 * np.radians(33), rel=0.02)


def test_at_its_nodes_a_map_is_their_fit(synthetic):
    found, _ = synthetic
    at_node = fit_at(found, 30.0, 1.5)
    expected = found.value.sel(flank=30.0, ratio=1.5).values
    # C is the node's to rounding; this C hardly determines r_inf and n, whose digits are fewer
    np.testing.assert_allclose([parameter.value for parameter in at_node.parameters], expected, rtol=2e-3)


def test_a_map_ends_at_its_nodes(synthetic):
    found, _ = synthetic
    with pytest.raises(WrongInput, match=r"flank = 51 degrees, ratio = 1: outside the map, 20 \.\.\. 50"):
        fit_at(found, 51.0, 1.0)


@pytest.mark.slow
def test_a_map_of_computed_c(tmp_path):
    """Two flank inclinations, two ratios, linear between them, from the command line."""
    path, out = tmp_path / "mine.toml", tmp_path / "out"
    path.write_text(scene_text(engine=HARMONIC), encoding="utf-8")
    axes = ["--flanks", "20", "24", "--ratios", "1", "1.04"]
    assert exit_code(["calibrate-map", str(path), *axes, "--out", str(out)]) == DONE
    assert (out / "calibration_map.png").is_file()
    with xr.open_dataset(out / "calibration_map.nc", engine="h5netcdf") as found:
        rms = found.residual.sel(measure="rms").isel(left_out=0)
        assert rms.sel(by="map") < 1.1 * rms.sel(by="fit") < rms.sel(by="Bhat")


def test_a_node_has_its_arcs_and_all_else_of_the_scene(synthetic):
    _, path = synthetic
    base = load_scene(str(path))
    scene = scene_at(base.text, base.reference_length, (20.0, 1.04))
    ends = [body.contour.inclination(np.array([-30.0, 30.0])) for body in scene.bodies.values()]
    np.testing.assert_allclose(np.degrees(ends), [[-20, 20], [-20, 20]])
    np.testing.assert_allclose(1 / scene.bodies["upper"].contour.inclination(1.0), 10.4, rtol=1e-6)
    assert scene.patch == base.patch
    assert scene.check is None


@pytest.mark.parametrize(
    ("flanks", "ratios", "message"),
    [
        ((20.0,), (1.0, 1.1), "flanks = "),
        ((20.0, 10.0), (1.0, 1.1), "two or more, growing"),
        ((20.0, 86.0), (1.0, 1.1), "within 0 ... 85"),
        ((20.0, 30.0), (0.9, 1.1), "ratios = "),
        (tuple(np.linspace(10, 60, 6)), tuple(np.linspace(1, 2, 5)), f"at most {MOST_GEOMETRIES}"),
    ],
)
def test_impossible_maps_are_refused(flanks, ratios, message):
    with pytest.raises(WrongInput, match=message):
        Axes(flanks, ratios)
