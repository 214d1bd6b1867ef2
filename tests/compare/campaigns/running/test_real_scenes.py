"""Campaigns of real scenes: results are those of single runs, and models are shared."""

import numpy as np
import pytest
import xarray as xr

from compare.campaigns import plan as planning
from compare.campaigns.plan import sweep_plan
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.results.ics import compute
from tests.coarse import coarse_sections
from tests.compare.campaigns.campaigns import CHEAP, OF_UPPER, campaign_in, errors_of, swept

OF_THE_RUN = ["seconds", "model_seconds", "ic_seconds", "digest"]


@pytest.fixture(scope="module", autouse=True)
def _coarse():
    """How accurate C is does not matter here."""
    with coarse_sections():
        yield


@pytest.fixture(scope="module")
def real(client, tmp_path_factory):
    """A campaign of two scenes that share the lower body, its folder, the end, and its dataset."""
    folder = tmp_path_factory.mktemp("real")
    campaign = campaign_in(folder, OF_UPPER)
    return campaign, folder, *swept(campaign, folder, client)


def test_results_equal_those_of_single_runs_exactly(real):
    campaign, folder, _, dataset = real
    assert campaign.order[-1] == 1
    scene = campaign.scene((12.0,))
    store = Store(folder / "alone")
    results = compute(scene, RunOptions(2, store))
    alone = errors_of(results)
    of_campaign = dataset.sel(R=12)
    for name in ("error", "rms", "weight", "estimate_refinement", "vanishes"):
        expected = alone[name].transpose(*of_campaign[name].dims)
        np.testing.assert_array_equal(of_campaign[name], expected)
    assert of_campaign.error.isnull().any()  # components that the scene does not ask for
    assert of_campaign.unknowns == max(cost.unknowns for cost in results.models.values())
    assert float(of_campaign.error.sel(variant="C", i="n", j="n").max()) > 0


def test_models_that_scenes_share_are_solved_once(real):
    _, _, done, _ = real
    assert (done.scenes, done.finished, done.failed, done.reused) == (2, 2, 0, 0)
    assert done.models == 3  # the lower body, and two upper ones
    assert done.models_reused == 4  # both of each scene


def test_campaign_in_the_same_store_reuses_results(real, client, tmp_path):
    """Another scene, the same bodies: nothing but approximations is left to do."""
    _, folder, _, dataset = real
    other = campaign_in(
        tmp_path, OF_UPPER.replace('"A", "Bhat"', '"A", "B"').replace("[11.0, 12.0]", "[12.0]")
    )
    done, reused = swept(other, tmp_path, client, store=Store(folder / "store"))
    assert (done.models, done.reused) == (0, 0)
    same = {"variant": ["A", "C"]}
    xr.testing.assert_equal(
        reused.drop_vars(OF_THE_RUN).sel(same).isel(R=0), dataset.drop_vars(OF_THE_RUN).sel(same).sel(R=12)
    )
    again = campaign_in(tmp_path, OF_UPPER.replace("[sweep.R]", "[sweep.other]"), "third")
    done, reused = swept(again, tmp_path / "third", client, store=Store(folder / "store"))
    assert (done.models, done.reused) == (0, 2)
    xr.testing.assert_equal(reused.rename(other="R"), dataset)


def test_plan_counts_models_and_stored_scenes(real, tmp_path):
    campaign, folder, _, _ = real
    plan = sweep_plan(campaign, Store(tmp_path))
    assert (plan.scenes, plan.reused, plan.models) == (2, 0, 3)
    assert plan.seconds > 0
    assert 200 < plan.memory < 1000
    plan = sweep_plan(campaign, Store(folder / "store"))
    assert (plan.scenes, plan.reused, plan.models) == (2, 2, 0)


def test_plan_counts_each_contact_of_a_scene(tmp_path):
    """Those of a scene with two ICs, one load, one coefficient and three creepages took 7 s in all."""
    contact = 'contact = { loads = [1e4], ics = ["A", "Bhat"], elements = 8, friction = [0.2, 0.3], '
    text = (
        CHEAP.replace(
            "[set]\n", f'keep = ["contact"]\n[set]\n{contact}%s }}\nupper = {{ rolling_radius = 400.0 }}\n'
        )
        + "[sweep.nu]\nkeys = ['upper.nu']\nvalues = [0.1, 0.2, 0.3, 0.4]\n"
    )
    rolling = 'motion = "rolling", longitudinal = [-0.002, 0.0, 0.002]'
    plan = sweep_plan(campaign_in(tmp_path, text % rolling), Store())
    assert (plan.scenes, plan.models) == (4, 0)
    assert plan.seconds == pytest.approx(4 * 14.0, rel=0.3)
    more = sweep_plan(campaign_in(tmp_path, text % rolling.replace("0.0,", "0.0, 0.001,")), Store())
    assert more.seconds / plan.seconds == pytest.approx(4 / 3)


def test_models_are_counted_for_a_limited_time(real, tmp_path, monkeypatch):
    """Those of contact on grids of its own take seconds a scene; at least those of one scene are."""
    monkeypatch.setattr(planning, "LONGEST", 0.0)
    plan = sweep_plan(real[0], Store(tmp_path))
    assert (plan.counted, plan.models) == (1, 2)
