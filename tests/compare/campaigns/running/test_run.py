"""The run of a campaign: nothing finished is lost or done twice, one failure does not stop the others."""

import numpy as np
import pytest
import xarray as xr

from compare.campaigns import collected as outcomes
from compare.campaigns import run as running
from compare.campaigns.collected import Collected
from compare.campaigns.crew import SCENES_PER_WORKER
from compare.campaigns.integrity import open_sweep
from compare.campaigns.run import Options, compute_sweep
from femic.cache.store import Store
from tests.compare.campaigns.campaigns import LIGHT, RANDOM, campaign_in, register, swept


@pytest.mark.usefixtures("light_scenes")
def test_the_dataset_has_the_swept_keys_as_dims(sweep):
    done, dataset = sweep()
    assert dict(dataset.sizes) == {"E": 9, "nu": 3, "power": 2}
    ok = dataset.sel(E=[1, 2, 3, 4, 5, 6, 8, 9])
    np.testing.assert_array_equal(ok["sum"], (ok.E + ok.nu).transpose("E", "nu"))
    np.testing.assert_array_equal(ok.powers.sel(power="two"), (ok.E**2 + 0 * ok.nu))
    assert dataset["sum"].attrs["units"] == "1"
    assert done.finished == 27


@pytest.mark.usefixtures("light_scenes")
def test_failed_scene_is_recorded_and_the_others_continue(sweep):
    done, dataset = sweep()
    assert done.failed == 3
    assert np.all(dataset.failure.sel(E=7) == "seven")
    assert np.all(np.isnan(dataset["sum"].sel(E=7)))
    assert np.sum(dataset.failure.values != "") == 3
    assert np.all(dataset.seconds >= 0)


def test_second_run_computes_nothing(light_scenes, client, tmp_path):
    campaign = campaign_in(tmp_path, LIGHT)
    _, first = swept(campaign, tmp_path, client)
    assert len(light_scenes) == 27

    def no_cluster(_):
        raise AssertionError("a cluster was started")

    done = compute_sweep(Collected(campaign, tmp_path), Store(tmp_path / "store"), no_cluster)
    assert (len(light_scenes), done.reused, done.failed) == (27, 27, 3)
    xr.testing.assert_identical(open_sweep(tmp_path), first)


def test_failures_are_tried_again_when_asked(light_scenes, sweep):
    sweep()
    del light_scenes[:]
    done, _ = sweep(options=Options(retry=True))
    assert sorted(light_scenes) == [(7, 0.1), (7, 0.2), (7, 0.3)]
    assert (done.reused, done.failed) == (24, 3)


@pytest.mark.usefixtures("light_scenes")
def test_unexpected_errors_are_recorded_but_not_stored(sweep, tmp_path, monkeypatch):
    register(monkeypatch, errors=lambda *_: 1 / 0)
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
    assert done.finished == 27
    assert done.reused >= 5
    assert len(light_scenes) - len(set(light_scenes)) == 0  # none was computed twice
    seen = early.seconds.notnull() & (early.failure == "")
    np.testing.assert_array_equal(dataset["sum"].values[seen], early["sum"].values[seen])


def test_only_scenes_of_new_values_are_computed(light_scenes, sweep):
    sweep()
    del light_scenes[:]
    done, dataset = sweep(LIGHT.replace("[0.1, 0.2, 0.3]", "[0.1, 0.15, 0.2, 0.3]"))
    assert {nu for _, nu in light_scenes} == {0.15}
    assert (done.reused, dataset.sizes["nu"]) == (27, 4)


@pytest.mark.usefixtures("light_scenes")
def test_random_points_are_samples(client, tmp_path):
    campaign = campaign_in(tmp_path, RANDOM % 6)
    _, dataset = swept(campaign, tmp_path, client)
    assert dict(dataset.sizes) == {"sample": 6, "power": 2}
    np.testing.assert_array_equal(np.column_stack([dataset.E, dataset.nu]), campaign.listed)
    np.testing.assert_array_equal(dataset["sum"], dataset.E + dataset.nu)


def test_scenes_are_submitted_in_the_order_of_the_campaign(light_scenes, client, tmp_path, monkeypatch):
    """They are submitted in exactly this order, coarse first; within a window Dask may swap some."""
    submitted, following = [], running._Run.next_unfinished

    def noted(run):
        scene = following(run)
        submitted.extend([] if scene is None else [scene[0]])
        return scene

    monkeypatch.setattr(running._Run, "next_unfinished", noted)
    campaign = campaign_in(tmp_path, LIGHT)
    swept(campaign, tmp_path, client)
    assert submitted == list(campaign.order)
    places = [divmod(number, 3) for number in submitted[:9]]
    coarse = {(e, nu) for e in (1, 5, 9) for nu in (0.1, 0.2, 0.3)}
    assert {(1 + e, (0.1, 0.2, 0.3)[nu]) for e, nu in places} == coarse
    swapped = SCENES_PER_WORKER - 1
    assert set(light_scenes[: len(coarse) - swapped]) <= coarse
    assert coarse <= set(light_scenes[: len(coarse) + swapped])


@pytest.mark.usefixtures("light_scenes")
def test_at_most_one_window_is_submitted(sweep, monkeypatch):
    with_scheduler = []
    submit = running._Run._submit

    def counted(run, crew):
        submit(run, crew)
        with_scheduler.append(len(run.listing) + len(run.scenes))

    monkeypatch.setattr(running._Run, "_submit", counted)
    sweep()
    assert max(with_scheduler) == SCENES_PER_WORKER


@pytest.mark.usefixtures("light_scenes")
def test_scene_with_results_of_another_shape_has_failed(sweep, monkeypatch):
    def longer(scene, _means):
        n = 3 if scene.bodies["lower"].material.E == 3 else 2
        return xr.Dataset({"y": ("k", np.ones(n))}, coords={"k": np.arange(n)})

    register(monkeypatch, errors=longer)
    done, dataset = sweep()
    assert done.failed == 3
    assert "other shapes than in earlier scenes: y has {'k': 3}" in str(dataset.failure.sel(E=3)[0].item())


@pytest.mark.usefixtures("light_scenes")
def test_differing_labels_are_numbered(sweep, monkeypatch):
    def named(scene, _means):
        return xr.Dataset(
            {"y": (("line", "k"), np.ones((1, 2)))},
            coords={"line": [f"s = {scene.bodies['lower'].material.E:g} mm"], "k": ["a", "b"]},
        )

    register(monkeypatch, errors=named)
    _, dataset = sweep()
    assert list(dataset.line.values) == ["line 0"]
    assert list(dataset.k.values) == ["a", "b"]
