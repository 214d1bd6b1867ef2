"""What may go wrong with a campaign: disks, workers, files, other runs, some of the results of a scene."""

import errno
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from distributed import KilledWorker

from compare.campaigns import dataset as outcomes
from compare.campaigns import tasks
from compare.campaigns.dataset import open_sweep
from compare.campaigns.run import Progress, task_report
from compare.campaigns.tasks import TaskReport, Unusable
from femic.cache.folders import locked
from femic.cache.store import Store
from geometries.errors import Failure
from tests.compare.campaigns.campaigns import LIGHT, light, register


@pytest.mark.parametrize("room", [0, 6])  # for the probe, and five scenes
def test_full_disk_ends_the_campaign_and_keeps_finished_scenes(
    light_scenes, sweep, tmp_path, monkeypatch, room
):
    system = type(Store(tmp_path / "store")._fs)
    write, written = system.pipe_file, []

    def full(fs, path, data):
        written.append(path)
        if len(written) > room:
            Path(path).write_bytes(data[:9])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        write(fs, path, data)

    monkeypatch.setattr(system, "pipe_file", full)
    with pytest.raises(
        Unusable, match=r"accepts no more data \(.*No space left on device\)\. Free some space"
    ):
        sweep()
    if not room:
        assert not light_scenes
        return
    assert int(np.sum(open_sweep(tmp_path).seconds.notnull())) == room - 1
    monkeypatch.setattr(system, "pipe_file", write)
    done, _ = sweep()
    assert (done.reused, done.finished) == (room - 1, 15)


def test_worker_with_other_code_is_refused_before_and_during_the_work(light_scenes, sweep, monkeypatch):
    here = tasks.origin
    monkeypatch.setattr(tasks, "origin", lambda store: replace(here(store), digest="0123456789ab"))
    with pytest.raises(Unusable, match=r"0123456789ab.*install the same version"):
        sweep()
    monkeypatch.setattr(tasks, "worker_problem", lambda _: "")  # it joins later
    with pytest.raises(Unusable, match=r"0123456789ab.*install the same version"):
        sweep()
    assert not light_scenes


def test_time_left_counts_scenes_that_are_not_computed_yet():
    assert Progress(10).seconds_left is None
    assert Progress(10, finished=4, reused=4, seconds=1.0).seconds_left is None
    assert Progress(10, finished=6, reused=4, seconds=8.0).seconds_left == pytest.approx(16.0)


def test_worker_that_dies_repeatedly_fails_its_scene():
    class Ended:
        def result(self, **_):
            raise KilledWorker("task", None, 3)

    failure = task_report(Ended()).failure
    assert failure.startswith("its worker died 4 times, most likely because memory ran out. Use fewer w")


@pytest.mark.usefixtures("light_scenes")
def test_second_run_in_the_same_folder_is_refused(sweep, tmp_path):
    with locked(tmp_path), pytest.raises(Failure, match="another femic run writes there"):
        sweep()
    done, _ = sweep()
    assert done.finished == 15


def test_results_of_a_scene_whose_file_changes_meanwhile_are_not_stored(sweep, tmp_path, monkeypatch):
    file, points = tmp_path / "gap.txt", "0 0 0\n1 0 0\n0 1 {}\n"
    file.write_text(points.format(0), encoding="utf-8")

    def changing(scene, _means):
        if scene.bodies["lower"].material.E == 5:
            file.write_text(points.format(scene.bodies["upper"].material.nu), encoding="utf-8")
        return xr.Dataset({"y": ((), 1.0)})

    register(monkeypatch, errors=changing)
    _, dataset = sweep(LIGHT + '[set.contact]\nextra_gap = "gap.txt"\n')
    message = "a file named in the scene changed during the run; run the command again"
    assert set(dataset.failure.sel(E=5).values) == {message}
    assert not dataset.digest.values[dataset.failure.values == message].any()
    assert len(outcomes.keys_in(Store(tmp_path / "store"))) - 1 == int((dataset.failure == "").sum())


BOTH = 'keep = ["errors", "advice"]' + LIGHT


def test_failed_kind_of_results_leaves_the_others(sweep, monkeypatch):
    """The first scenes in the order are among those that fail; kinds that fail alike give one message."""

    def hard(scene, _means):
        e, nu = scene.bodies["lower"].material.E, scene.bodies["upper"].material.nu
        if e < 6 or (e, nu) == (7, 0.3):
            raise Failure("seven" if e == 7 else f"{e:g} is too soft")
        return xr.Dataset({"hard": ((), e)})

    register(monkeypatch, errors=light, advice=hard)
    done, dataset = sweep(BOTH)
    assert done.failed == 12  # 1, 3, 5, and 7
    soft, seven, both = (dataset.sel(E=e) for e in (3, 7, 9))
    assert set(soft.failure.values) == {"advice: 3 is too soft"}
    assert list(seven.failure.values) == ["errors: seven", "errors: seven", "seven"]
    assert set(both.failure.values) == {""}
    assert soft.hard.isnull().all()
    assert seven["sum"].isnull().all()
    np.testing.assert_array_equal(soft["sum"], 3 + soft.nu)
    np.testing.assert_array_equal(seven.hard, [7, 7, np.nan])
    np.testing.assert_array_equal(both.hard, 9)


def test_model_that_kills_workers_leaves_stored_results(sweep, tmp_path, monkeypatch):
    def killed(*_):
        return TaskReport("its worker died 4 times")

    register(monkeypatch, errors=light, advice=light)
    sweep(folder=tmp_path / "first", store=Store(tmp_path / "store"))
    monkeypatch.setattr(tasks, "list_models", killed)
    done, dataset = sweep(BOTH)
    assert done.failed == 15
    assert set(dataset.failure.values.ravel()) == {"its worker died 4 times"}
    np.testing.assert_array_equal(dataset["sum"].sel(E=5), 5 + dataset.nu)
    assert not dataset.digest.any()  # it is tried again
