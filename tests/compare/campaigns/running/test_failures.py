"""What may go wrong with a campaign: disks, workers, schedulers, files, other runs."""

import errno
import os
import socket
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import dask
import numpy as np
import psutil
import pytest
import xarray as xr
from distributed import KilledWorker

from compare.campaigns import cluster, tasks
from compare.campaigns import dataset as outcomes
from compare.campaigns.cluster import existing_cluster, parse_address, require_scheduler, size_for
from compare.campaigns.dataset import open_sweep
from compare.campaigns.run import Options, Progress, task_report
from compare.campaigns.tasks import Unusable
from femic.cache.folders import locked
from femic.cache.store import Store
from geometries.errors import Failure
from tests.compare.campaigns.campaigns import LIGHT, campaign_in, register, swept, threads


@pytest.mark.usefixtures("light_scenes")
def test_full_disk_ends_the_campaign_and_keeps_finished_scenes(sweep, tmp_path, monkeypatch):
    system = type(Store(tmp_path / "store")._fs)
    write, written = system.pipe_file, []

    def full(fs, path, data):
        written.append(path)
        if len(written) > 6:
            Path(path).write_bytes(data[:9])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        write(fs, path, data)

    monkeypatch.setattr(system, "pipe_file", full)
    with pytest.raises(Unusable, match=r"accepts no more data \(.*No space left on device\): make room"):
        sweep()
    assert int(np.sum(open_sweep(tmp_path).seconds.notnull())) == 5  # and the probe
    monkeypatch.setattr(system, "pipe_file", write)
    done, _ = sweep()
    assert (done.reused, done.finished) == (5, 27)


def test_full_disk_is_reported_before_any_scene(light_scenes, sweep, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(type(Store(tmp_path)._fs), "pipe_file", full)
    with pytest.raises(Unusable, match="accepts no more data"):
        sweep()
    assert not light_scenes


def test_worker_with_other_code_is_refused_before_and_during_the_work(light_scenes, sweep, monkeypatch):
    here = tasks.origin
    monkeypatch.setattr(tasks, "origin", lambda store: replace(here(store), digest="0123456789ab"))
    with pytest.raises(Unusable, match=r"0123456789ab.*install the same version"):
        sweep()
    monkeypatch.setattr(tasks, "worker_problem", lambda _: "")  # it joins later
    with pytest.raises(Unusable, match=r"0123456789ab.*install the same version"):
        sweep()
    assert not light_scenes


def test_worker_without_the_store_is_refused(tmp_path):
    assert "does not see the store" in tasks.worker_problem(tasks.origin(Store(tmp_path)))


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nowhere at all"])
def test_scheduler_that_does_not_answer_is_reported(address):
    message = rf"no scheduler answers at {address} within 0\.2 s .* is the address right"
    with pytest.raises(Failure, match=message), existing_cluster(address, timeout=0.2):
        pass


def test_number_of_workers_fits_into_memory():
    assert size_for(8, 100, 900.0, 10_000.0).workers == 8
    few = size_for(8, 100, 3000.0, 10_000.0)
    assert few.workers == 3
    assert few.memory == pytest.approx(3000)
    assert "3 instead of 8 workers: models take up to 3000 MB" in few.note
    assert size_for(8, 2, 100.0, 10_000.0).workers == 2
    assert size_for(8, 100, 30_000.0, 10_000.0).workers == 1


def test_time_left_counts_scenes_that_are_not_computed_yet():
    assert Progress(10).seconds_left is None
    assert Progress(10, finished=4, reused=4, seconds=1.0).seconds_left is None
    assert Progress(10, finished=6, reused=4, seconds=8.0).seconds_left == pytest.approx(16.0)


def test_worker_that_dies_repeatedly_fails_its_scene():
    class Ended:
        def result(self, **_):
            raise KilledWorker("task", None, 3)

    failure = task_report(Ended()).failure
    assert failure.startswith("its worker died 4 times, most likely for memory: give fewer workers")


@pytest.mark.usefixtures("light_scenes")
def test_lost_scheduler_is_reported_and_finished_scenes_are_kept(tmp_path):
    with dask.config.set({"distributed.comm.timeouts.connect": "1s"}), threads() as own:

        def go(progress):
            if progress.finished == 3:
                own.sync(own.scheduler.close)

        with (
            existing_cluster(own.scheduler_address, timeout=1.0) as client,
            pytest.raises(Failure, match="the scheduler is gone; finished scenes are stored"),
        ):
            swept(campaign_in(tmp_path, LIGHT), tmp_path, client, Options(go))
    assert int(np.sum(open_sweep(tmp_path).seconds.notnull())) >= 3


@pytest.mark.usefixtures("light_scenes")
def test_second_run_in_the_same_folder_is_refused(sweep, tmp_path):
    with locked(tmp_path), pytest.raises(Failure, match="another femic writes there"):
        sweep()
    done, _ = sweep()
    assert done.finished == 27


def test_results_of_a_scene_whose_file_changes_meanwhile_are_not_stored(sweep, tmp_path, monkeypatch):
    file, points = tmp_path / "gap.txt", "0 0 0\n1 0 0\n0 1 {}\n"
    file.write_text(points.format(0), encoding="utf-8")

    def changing(scene, _means):
        if scene.bodies["lower"].material.E == 5:
            file.write_text(points.format(scene.bodies["upper"].material.nu), encoding="utf-8")
        return xr.Dataset({"y": ((), 1.0)})

    register(monkeypatch, errors=changing)
    _, dataset = sweep(LIGHT + '[set.contact]\nextra_gap = "gap.txt"\n')
    message = "a file that the scene names was changed meanwhile: run again"
    assert set(dataset.failure.sel(E=5).values) == {message}
    assert not dataset.digest.values[dataset.failure.values == message].any()
    assert len(outcomes.keys_in(Store(tmp_path / "store"))) - 1 == int((dataset.failure == "").sum())


def listening():
    """The addresses at which this process and its children take connections."""
    this = psutil.Process()
    for process in (this, *this.children(recursive=True)):
        for connection in process.net_connections("inet"):
            if connection.status == psutil.CONN_LISTEN:
                yield connection.laddr


def answer_to_a_stranger(address, says=b"GET /health HTTP/1.0\r\n\r\n"):
    """What a server says to someone without a certificate."""
    with socket.create_connection((address.ip, address.port), timeout=5) as stranger:
        stranger.sendall(says)
        with suppress(ConnectionResetError):
            return stranger.recv(100)
    return b""


def test_local_cluster_refuses_strangers():
    """Also to their Dask; what is served by HTTP has nothing."""
    before = {*listening()}
    with cluster.local_cluster(cluster.ClusterSize(1, 1000.0)) as client:
        assert client.submit(sum, [1, 2]).result() == 3
        address = client.scheduler.address
        assert address.startswith("tls://127.0.0.1:")
        opened = {*listening()} - before
        assert len(opened) >= 3
        for one in opened:
            assert one.ip == "127.0.0.1"
            answer = answer_to_a_stranger(one)
            assert not answer or b" 404 " in answer
        for scheme in ("tcp", "tls"):
            with pytest.raises(Failure, match="no scheduler answers"):
                require_scheduler(parse_address(address.replace("tls", scheme)), timeout=2.0)
