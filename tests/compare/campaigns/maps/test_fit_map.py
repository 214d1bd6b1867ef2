"""Fits between the scenes of a campaign. C of these tests is B-hat-prime by properties that vary smoothly."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from approx.calibration import fit
from approx.effective import EffectiveProperties, Transition
from compare.campaigns import kinds
from compare.campaigns.maps import fit_at, leave_one_out, open_fits
from femic.reference.run_options import RunOptions
from femic.results.calibration import FittedScene, target_from
from femic.scenes.errors import BadScene
from geometries.errors import WrongInput
from tests.compare.campaigns.campaigns import campaign_in, collect

CAMPAIGN = """
scene = "geometry1"
keep = ["calibration"]
[set]
calibration = { points = 16, s = [0.0] }
[sweep.flank]
keys = ["lower.contour.flank_inclination_deg", "upper.contour.flank_inclination_deg"]
values = [20, 30, 40]
[sweep.ratio]
keys = { "upper.contour.radius" = 10.0 }
values = [1.0, 1.2, 1.5]
spacing = "inverse"
"""


def true(flank, ratio):
    return EffectiveProperties(mismatch_k=Transition(-0.2 * flank / ratio, 9 + 2 * flank, 0.9, 2 + 1 / ratio))


def smooth(scene, _means):
    """A calibration whose C is B-hat-prime with properties that vary smoothly from scene to scene."""
    flank = scene.bodies["lower"].contour.inclination(30.0)
    ratio = scene.bodies["upper"].contour.core.radius / scene.bodies["lower"].contour.core.radius
    target = target_from(scene, np.ones((1, 16)))
    target = replace(target, ics=target.bhat_prime(true(flank, ratio)))
    return FittedScene(scene, None, None, {"combined": fit(target)}, {"combined": target})


@pytest.fixture(scope="module")
def fits(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fits")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kinds, "calibrate", smooth)
        campaign = campaign_in(folder, CAMPAIGN)
        return open_fits(collect(campaign, folder, lambda scene: kinds.calibration(scene, RunOptions())))


def test_fit_between_scenes_recovers_the_smooth_properties(fits):
    fitted = fit_at(fits, (33.0, 1.3)).effective.mismatch_k
    expected = true(np.radians(33), 1.3).mismatch_k
    assert fitted.far == pytest.approx(expected.far, rel=0.02)
    assert fitted.r_inf == pytest.approx(expected.r_inf, rel=0.02)


def test_fit_at_a_scene_is_the_own_fit_of_the_scene(fits):
    """C is that of the scene to rounding; it hardly determines r_inf and n, whose digits are fewer."""
    own = fits.dataset.fit_value.sel(flank=30.0, ratio=1.5).isel(fitted_body=0).values
    fitted = [parameter.value for parameter in fit_at(fits, (30.0, 1.5)).parameters]
    np.testing.assert_allclose(fitted, own, rtol=2e-3)


def test_nothing_is_extrapolated(fits):
    with pytest.raises(WrongInput, match=r"flank = 51: outside the map, 20 \.\.\. 40"):
        fit_at(fits, (51.0, 1.0))


@pytest.mark.slow  # between scenes the first test has the accuracy of the map
def test_left_out_nodes_are_predicted_by_the_others(fits):
    """Every inner node along each axis, once; the map is nearly as good there as the node's own fit."""
    deviations = leave_one_out(fits)
    assert deviations.sizes["node"] == 3 + 3
    assert set(deviations.flank.values[deviations.along.values == "flank"]) == {30.0}
    assert set(deviations.ratio.values[deviations.along.values == "ratio"]) == {1.2}
    worst = deviations.worst
    assert float(worst.sel(by="own").max()) < 1e-6
    assert 1e-6 < float(worst.sel(by="map").max()) < 0.03
    assert float(worst.sel(by="Bhat").min()) > 0.5
    assert np.all(deviations.rms <= deviations.worst)


def test_other_files_are_refused(tmp_path):
    xr.Dataset(attrs={"points": "samples"}).to_netcdf(tmp_path / "one.nc", engine="h5netcdf")
    with pytest.raises(BadScene, match="needs points = 'all'"):
        open_fits(tmp_path / "one.nc")
