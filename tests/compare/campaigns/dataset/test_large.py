"""Large datasets of campaigns: zarr stores that are written by chunks, gone on with, appended to."""

import errno
import os
import shutil

import numpy as np
import pytest
import xarray as xr
import zarr

from compare.campaigns.dataset import DIGEST, CampaignDataset, open_sweep
from compare.campaigns.run import compute_sweep
from compare.campaigns.tasks import campaign_tasks
from femic.cache.store import Store
from geometries.errors import Failure
from tests.compare.campaigns import campaigns


@pytest.mark.parametrize("chunk", [50, *(pytest.param(chunk, marks=pytest.mark.slow) for chunk in (1, 1e6))])
@pytest.mark.usefixtures("light_scenes")
def test_large_dataset_equals_the_small_one(client, tmp_path, monkeypatch, chunk):
    campaign, store = campaigns.campaign_in(tmp_path, campaigns.LIGHT), Store(tmp_path / "store")
    _, small = campaigns.swept(campaign, tmp_path / "small", client, store=store)
    campaigns.all_are_large(monkeypatch, chunk)
    _, large = campaigns.swept(campaign, tmp_path / "large", client, store=store)
    assert (tmp_path / "large" / "sweep.zarr").is_dir()
    xr.testing.assert_equal(large.load().drop_vars("failure"), small.drop_vars("failure"))
    assert large.failure.values.tolist() == small.failure.values.tolist()
    assert large.attrs == small.attrs
    assert float(large.powers.sel(E=3, nu=0.2, power="two")) == 9


@pytest.mark.usefixtures("large_there")
def test_second_run_takes_a_large_dataset_as_it_is(light_scenes, sweep, tmp_path):
    first = open_sweep(tmp_path).load()
    shutil.rmtree(tmp_path / "store")
    done, again = sweep()
    assert (done.reused, done.failed, len(light_scenes)) == (15, 3, 0)
    xr.testing.assert_identical(again.load(), first)


@pytest.mark.usefixtures("large_there")
def test_scenes_are_appended_to_a_large_dataset(light_scenes, sweep, tmp_path):
    """More values at the end of both axes; nothing that is there is read back or computed."""
    shutil.rmtree(tmp_path / "store")
    done, dataset = sweep(campaigns.LONGER.replace("0.3]", "0.3, 0.4]"))
    assert set(light_scenes) == {(10, nu) for nu in (0.1, 0.2, 0.3, 0.4)} | {
        (e, 0.4) for e in (1, 3, 5, 7, 9, 10)
    }
    assert (done.reused, done.failed, dict(dataset.sizes)) == (15, 4, {"E": 6, "nu": 4, "power": 2})
    campaigns.assert_sums(dataset)


@pytest.mark.usefixtures("large_there", "light_scenes")
def test_results_of_other_inputs_do_not_outlive_the_start_of_a_run(tmp_path):
    """One scene was computed from files that have changed since; the run ends before it is computed."""
    shutil.rmtree(tmp_path / "store")
    zarr.open_group(tmp_path / "sweep.zarr")[DIGEST][1, 2] = 99

    def interrupted(_):
        raise KeyboardInterrupt

    campaign = campaigns.campaign_in(tmp_path, campaigns.LIGHT)
    with pytest.raises(KeyboardInterrupt):
        compute_sweep(CampaignDataset(campaign, tmp_path), Store(tmp_path / "store"), interrupted)
    left = open_sweep(tmp_path)
    assert int(left.seconds.isnull().sum()) == 1
    assert left.isel(E=1, nu=2)[["seconds", "sum", "powers"]].isnull().all()


@pytest.mark.parametrize("large", [False, True])
def test_random_points_are_samples_and_more_are_appended(light_scenes, sweep, tmp_path, monkeypatch, large):
    """To a large dataset without a store; a small one is written anew with what is in the store."""
    if large:
        campaigns.all_are_large(monkeypatch)
    sweep(campaigns.RANDOM % 6)
    if large:
        shutil.rmtree(tmp_path / "store")
    done, dataset = sweep(campaigns.RANDOM % 11)
    campaign = campaigns.campaign_in(tmp_path, campaigns.RANDOM % 11)
    assert (done.reused, len(light_scenes), dict(dataset.sizes)) == (6, 11, {"sample": 11, "power": 2})
    np.testing.assert_array_equal(np.column_stack([dataset.E, dataset.nu]), campaign.listed)
    np.testing.assert_array_equal(dataset["sum"], dataset.E + dataset.nu)


@pytest.mark.usefixtures("large_there")
def test_large_dataset_with_values_inserted_is_written_anew(light_scenes, sweep):
    done, dataset = sweep(campaigns.LIGHT.replace("0.2, 0.3", "0.15, 0.2, 0.3"))
    assert (done.reused, len(light_scenes)) == (15, 5)
    campaigns.assert_sums(dataset)


@pytest.fixture
def taken(light_scenes, large_there, tmp_path):  # noqa: ARG001
    """What a second run begins with: all 15 scenes of a large dataset."""
    campaign = campaigns.campaign_in(tmp_path, campaigns.LIGHT)
    dataset = CampaignDataset(campaign, tmp_path)
    assert dataset.resume(first_digest(campaign, tmp_path)) == ""
    return dataset


def first_digest(campaign, folder):
    _, task = next(campaign_tasks(campaign, Store(folder / "store")))
    return task.digest


def test_removed_scene_is_missing_and_its_digest_goes_before_its_values_change(taken, tmp_path):
    """A run that is killed between leaves no scene with a digest and values of something else."""
    digest = int(taken.digests[4])
    assert taken.has(4, digest)
    assert not taken.has(4, digest + 1)
    taken.remove(4)
    taken.flush()
    assert list(np.flatnonzero(open_sweep(tmp_path).digest.values.ravel() == 0)) == [4]
    result = open_sweep(taken.write())
    assert np.isnan(result["sum"].values.ravel()[4])
    assert np.isnan(result.seconds.values.ravel()[4])
    assert int(result["sum"].isnull().sum()) == 3 + 1
    assert result.attrs["computed"] == 15 - 3 - 1


def test_values_without_a_digest_are_removed(taken):
    """Those that a run wrote before it was killed, of files that may have changed since."""
    taken.seconds[4], taken.digests[4] = np.nan, 0
    taken.remove(4)
    assert np.isnan(open_sweep(taken.write())["sum"].values.ravel()[4])


def test_run_killed_at_its_start_loses_nothing(taken, tmp_path):
    result = open_sweep(tmp_path)
    assert np.all(result.digest.values.ravel() == taken.digests)
    assert int((result.failure == "seven").sum()) == 3


def test_large_dataset_of_other_files_is_discarded(taken, tmp_path):
    """Its variables may have had other shapes."""
    dataset = CampaignDataset(taken.campaign, tmp_path)
    assert dataset.resume(1 + first_digest(taken.campaign, tmp_path)) == ""
    assert not dataset.template.data_vars
    assert np.all(np.isnan(dataset.seconds))


@pytest.mark.usefixtures("light_scenes")
def test_full_disk_under_a_large_dataset_is_reported(sweep, monkeypatch):
    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    campaigns.all_are_large(monkeypatch)
    monkeypatch.setattr("compare.campaigns.dataset.CampaignDataset.flush", full)
    with pytest.raises(Failure, match=r"sweep\.zarr cannot be written .*No space left.*make room"):
        sweep()


@pytest.mark.usefixtures("light_scenes")
def test_campaign_that_becomes_small_or_large_leaves_one_dataset(sweep, tmp_path, monkeypatch):
    """And one that becomes large."""
    shorter = campaigns.LIGHT.replace("[0.1, 0.2, 0.3]", "[0.1]")
    _, small = sweep(shorter)
    monkeypatch.setattr("compare.campaigns.dataset.LARGEST_FILE", 500)  # 48 bytes a scene
    _, large = sweep()
    assert [path.name for path in tmp_path.glob("sweep.*")] == ["sweep.zarr"]
    np.testing.assert_array_equal(large.powers.sel(nu=[0.1]), small.powers)
    _, again = sweep(shorter)
    assert [path.name for path in tmp_path.glob("sweep.*")] == ["sweep.nc"]
    xr.testing.assert_identical(again, small)


def test_dataset_that_becomes_large_keeps_its_scenes(sweep, tmp_path, monkeypatch):
    """The first scenes lack what makes it large."""

    def large(scene, _means):
        e = scene.bodies["lower"].material.E
        if e in (1, 5, 9):
            raise Failure("not one of the first")
        return xr.Dataset({"many": ("k", np.full(1000, e))})

    monkeypatch.setattr("compare.campaigns.dataset.LARGEST_FILE", 15 * 900)
    campaigns.register(monkeypatch, errors=campaigns.light, advice=large)
    _, dataset = sweep('keep = ["errors", "advice"]' + campaigns.LIGHT)
    assert (tmp_path / "sweep.zarr").is_dir()
    ok = dataset.sel(E=[3])
    np.testing.assert_array_equal(ok.many, np.broadcast_to(ok.E, (3, 1000, 1)).transpose(2, 0, 1))
    np.testing.assert_array_equal(dataset["sum"].sel(E=5), 5 + dataset.nu)
    assert dataset.many.sel(E=5).isnull().all()
