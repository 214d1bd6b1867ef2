"""Workers that Dask has paused, or that are gone: it is said, and a campaign does not wait forever."""

import time

import pytest
from distributed import Client
from distributed.core import Status

from compare.campaigns import cluster, run
from compare.campaigns.dataset import open_sweep
from compare.campaigns.run import Stall
from geometries.errors import Failure
from tests.compare.campaigns.campaigns import LIGHT, campaign_in, in_this_process, swept, threads


def worker(status, executing=0):
    metrics = {"task_counts": {"executing": executing}, "memory": 900 * 2**20}
    return {"status": status, "memory_limit": 1000 * 2**20, "metrics": metrics}


def messages_after(*states):
    """The messages where workers have some states one after the other, for some seconds each."""
    messages, now = [], [0.0]
    stall = Stall(messages.append, lambda: now[0])
    for seconds, *workers in states:
        for _ in range(seconds):
            stall.update({str(k): one for k, one in enumerate(workers)})
            now[0] += 1.0
    return messages


PAUSED, RUNNING, AT_WORK = worker("paused"), worker("running"), worker("paused", executing=1)


def test_campaign_whose_workers_all_stay_paused_ends_with_advice():
    with pytest.raises(
        Failure, match=r"2 of 2 workers are paused .*\(900 of 1000 MB\), and none has a task at work: give w"
    ):
        messages_after((29, PAUSED, PAUSED))


def test_paused_workers_with_others_or_with_a_task_do_not_end_the_campaign():
    states = (300, PAUSED, RUNNING), (24, PAUSED, PAUSED), (300, PAUSED, AT_WORK), (24, PAUSED, PAUSED)
    assert messages_after(*states, (9, AT_WORK, PAUSED)) == []
    assert Stall(print).update({"a": PAUSED, "b": RUNNING, "c": RUNNING}) == 2


def test_missing_workers_are_reported_once():
    (message,) = messages_after((2,), (2, RUNNING), (99,))
    assert message.startswith("there are no workers any more")


@pytest.fixture
def own():
    """A cluster of two workers in this process, without limits of memory."""
    with in_this_process(n_workers=2, memory_limit=0) as client:
        yield client


def pause(client, number):
    """Have Dask pause a number of workers, and wait until the scheduler knows."""

    def pause(dask_worker):
        dask_worker.status = Status.paused

    known = sorted(client.scheduler_info(n_workers=-1)["workers"])
    client.run(pause, workers=known[:number])
    while (
        sum(w["status"] == "paused" for w in client.scheduler_info(n_workers=-1)["workers"].values()) < number
    ):
        time.sleep(0.01)


@pytest.mark.usefixtures("light_scenes")
def test_a_campaign_on_paused_workers_does_not_wait_forever(own, tmp_path, monkeypatch):
    monkeypatch.setattr(run, "GIVE_UP_AFTER", 1.5)
    pause(own, 2)
    with pytest.raises(Failure, match="2 of 2 workers are paused by Dask"):
        swept(campaign_in(tmp_path, LIGHT), tmp_path, own)


@pytest.mark.usefixtures("light_scenes")
def test_campaign_continues_with_the_remaining_workers(own, tmp_path):
    pause(own, 1)
    done, _ = swept(campaign_in(tmp_path, LIGHT), tmp_path, own)
    assert done.finished == open_sweep(tmp_path).attrs["scenes"] == 27


def test_paused_workers_count_as_workers(monkeypatch):
    """To wait for workers would be to wait for the end of the pause."""
    monkeypatch.setattr(cluster, "WORKS_WITHIN", 1.0)
    with threads(memory_limit=0, protocol="tcp") as served:
        with Client(served, set_as_default=False) as client:
            pause(client, 1)
        with cluster.existing_cluster(served.scheduler_address) as client:
            assert Stall(print).update(client.scheduler_info(n_workers=-1)["workers"]) == 0
    with (
        threads(n_workers=0, protocol="tcp") as served,
        pytest.raises(Failure, match="has no workers: start some"),
        cluster.existing_cluster(served.scheduler_address),
    ):
        pass
