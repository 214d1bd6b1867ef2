"""The run of a campaign: nothing finished is lost or done twice, one failure does not stop the others."""

import numpy as np
import pytest
import xarray as xr

from compare.campaigns import dataset as outcomes
from compare.campaigns import run as running
from compare.campaigns.dataset import CampaignDataset, SceneOutcome, open_sweep
from compare.campaigns.run import SCENES_PER_WORKER, Options, compute_sweep
from femic.cache.store import Store
from tests.compare.campaigns import campaigns


def test_campaign_has_a_dataset_and_a_second_run_computes_nothing(light_scenes, client, tmp_path):
    """One that fails is recorded, and the others go on."""
    campaign = campaigns.campaign_in(tmp_path, campaigns.LIGHT)
    done, first = campaigns.swept(campaign, tmp_path, client)
    assert (len(light_scenes), done.finished, done.failed) == (15, 15, 3)
    assert dict(first.sizes) == {"E": 5, "nu": 3, "power": 2}
    campaigns.assert_sums(first)
    ok = first.drop_sel(E=7)
    np.testing.assert_array_equal(ok.powers.sel(power="two"), (ok.E**2 + 0 * ok.nu))
    assert first["sum"].attrs["units"] == "1"
    assert np.sum(first.failure.values != "") == 3
    assert np.all(first.seconds >= 0)

    def no_cluster(_):
        raise AssertionError("a cluster was started")

    done = compute_sweep(CampaignDataset(campaign, tmp_path), Store(tmp_path / "store"), no_cluster)
    assert (len(light_scenes), done.reused, done.failed) == (15, 15, 3)
    xr.testing.assert_identical(open_sweep(tmp_path), first)


def test_failures_are_tried_again_when_asked_and_scenes_of_new_values_are_computed(light_scenes, sweep):
    sweep()
    del light_scenes[:]
    done, _ = sweep(options=Options(retry=True))
    assert sorted(light_scenes) == [(7, 0.1), (7, 0.2), (7, 0.3)]
    assert (done.reused, done.failed) == (12, 3)
    del light_scenes[:]
    done, dataset = sweep(campaigns.LIGHT.replace("[0.1, 0.2, 0.3]", "[0.1, 0.15, 0.2, 0.3]"))
    assert {nu for _, nu in light_scenes} == {0.15}
    assert (done.reused, dataset.sizes["nu"]) == (15, 4)


@pytest.mark.usefixtures("light_scenes")
def test_unexpected_errors_are_recorded_but_not_stored(sweep, tmp_path, monkeypatch):
    campaigns.register(monkeypatch, errors=lambda *_: 1 / 0)
    _, dataset = sweep()
    assert set(dataset.failure.values.ravel()) == {"ZeroDivisionError: division by zero"}
    monkeypatch.undo()
    assert len(outcomes.keys_in(Store(tmp_path / "store"))) == 1  # the probe


def test_interrupted_campaign_continues(light_scenes, sweep, tmp_path):
    """What is finished is in the dataset, too."""

    def interrupt(progress):
        if progress.finished == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep(options=Options(interrupt))
    early = open_sweep(tmp_path)
    assert int(np.sum(early.seconds.notnull())) == 5
    done, dataset = sweep()
    assert done.finished == 15
    assert done.reused >= 5
    assert len(light_scenes) - len(set(light_scenes)) == 0  # none was computed twice
    seen = early.seconds.notnull() & (early.failure == "")
    np.testing.assert_array_equal(dataset["sum"].values[seen], early["sum"].values[seen])


def test_scenes_are_submitted_in_the_order_of_the_campaign_by_windows(
    light_scenes, client, tmp_path, monkeypatch
):
    """They are submitted in exactly this order, coarse first; within a window Dask may swap some."""
    submitted, with_scheduler = [], []
    following, begin = running._Run.next_unfinished, running._Run._begin

    def noted(run):
        scene = following(run)
        submitted.extend([] if scene is None else [scene[0]])
        return scene

    def counted(run, *scene):
        begin(run, *scene)
        with_scheduler.append(run.begun)

    monkeypatch.setattr(running._Run, "next_unfinished", noted)
    monkeypatch.setattr(running._Run, "_begin", counted)
    campaign = campaigns.campaign_in(tmp_path, campaigns.LIGHT)
    campaigns.swept(campaign, tmp_path, client)
    assert max(with_scheduler) == SCENES_PER_WORKER
    assert submitted == list(campaign.order)
    coarse = {(e, nu) for e in (1, 5, 9) for nu in (0.1, 0.2, 0.3)}
    assert {campaign.point(number) for number in submitted[:9]} == coarse
    swapped = SCENES_PER_WORKER - 1
    assert set(light_scenes[: len(coarse) - swapped]) <= coarse
    assert coarse <= set(light_scenes[: len(coarse) + swapped])


def test_scene_with_results_of_another_shape_has_failed(tmp_path):
    dataset = CampaignDataset(campaigns.campaign_in(tmp_path, campaigns.LIGHT), tmp_path)
    for number, n in enumerate((2, 3)):
        dataset.add(number, SceneOutcome(xr.Dataset({"y": ("k", np.ones(n))}, coords={"k": np.arange(n)})))
    assert dataset.failures == {
        1: "its results have a different shape from those of earlier scenes: y has {'k': 3}, not {'k': 2}"
    }


@pytest.mark.parametrize("large", [False, True])
def test_differing_labels_are_numbered(tmp_path, monkeypatch, large):
    """Also where they are numbers, and have been written as such."""
    if large:
        campaigns.all_are_large(monkeypatch)
    dataset = CampaignDataset(campaigns.campaign_in(tmp_path, campaigns.LIGHT), tmp_path)
    for number in range(2):
        one = xr.Dataset(
            {"y": (("load", "k"), [[1.0, 2.0]])}, coords={"load": [10.0 + number], "k": ["a", "b"]}
        )
        dataset.add(number, SceneOutcome(one), 1)
        written = open_sweep(dataset.write())
        assert list(written["load"].values) == ([10.0] if number == 0 else ["load 0"])
        assert list(written.k.values) == ["a", "b"]
