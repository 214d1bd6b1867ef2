"""Workers that Dask has paused: it is said, fewer tasks are begun, and a campaign does not wait forever."""

import time

import pytest
from distributed import Client
from distributed.core import Status

from compare.campaigns import cluster
from compare.campaigns import crew as paused
from compare.campaigns.crew import GIVE_UP_AFTER, REPORTED_AFTER, SCENES_PER_WORKER, Crew, Pauses
from compare.campaigns.integrity import open_sweep
from compare.campaigns.run import Options
from geometries.errors import Failure
from tests.compare.campaigns.campaigns import LIGHT, campaign_in, in_this_process, swept, threads


def worker(status, executing=0):
    metrics = {"task_counts": {"executing": executing}, "memory": 900 * 2**20}
    return {"status": status, "memory_limit": 1000 * 2**20, "metrics": metrics}


def messages_after(*states):
    """The messages where workers have some states one after the other, for some seconds each."""
    messages, now = [], [0.0]
    pauses = Pauses(messages.append, lambda: now[0])
    for seconds, *workers in states:
        for _ in range(seconds):
            pauses.update({str(k): one for k, one in enumerate(workers)})
            now[0] += 1.0
    return messages


PAUSED, RUNNING, AT_WORK = worker("paused"), worker("running"), worker("paused", executing=1)


def test_pause_is_reported_once_within_half_a_minute():
    assert REPORTED_AFTER < GIVE_UP_AFTER < 30
    (messages,) = messages_after((300, PAUSED, RUNNING), (5, RUNNING, RUNNING), (300, PAUSED, RUNNING))
    assert messages.startswith(
        "1 of 2 workers are paused by Dask for their memory (900 of 1000 MB): the campaign goes"
    )
    assert "--memory-limit" in messages


def test_short_pauses_are_not_reported():
    assert messages_after((8, PAUSED), (1, RUNNING), (8, PAUSED), (1, RUNNING)) == []


def test_campaign_whose_workers_all_stay_paused_ends_with_advice():
    with pytest.raises(Failure, match=r"2 of 2 workers are paused .* none has a task at work: give workers"):
        messages_after((29, PAUSED, PAUSED))


def test_paused_workers_with_a_task_do_not_end_the_campaign():
    assert len(messages_after((500, PAUSED, AT_WORK), (20, PAUSED, PAUSED), (9, AT_WORK, PAUSED))) == 1


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
    monkeypatch.setattr(paused, "GIVE_UP_AFTER", 1.5)
    monkeypatch.setattr(paused, "REPORTED_AFTER", 0.5)
    pause(own, 2)
    messages = []
    with pytest.raises(Failure, match="2 of 2 workers are paused by Dask"):
        swept(campaign_in(tmp_path, LIGHT), tmp_path, own, Options(on_message=messages.append))
    assert len(messages) == 1


def test_paused_workers_count_as_workers(monkeypatch):
    """To wait for workers would be to wait for the end of the pause."""
    monkeypatch.setattr(cluster, "WORKS_WITHIN", 1.0)
    with threads(memory_limit=0, protocol="tcp") as served:
        with Client(served, set_as_default=False) as client:
            pause(client, 1)
        with cluster.existing_cluster(served.scheduler_address) as client:
            assert paused.running(client.scheduler_info(n_workers=-1)["workers"]) == 0
    with (
        threads(n_workers=0, protocol="tcp") as served,
        pytest.raises(Failure, match="has no workers: start some"),
        cluster.existing_cluster(served.scheduler_address),
    ):
        pass


@pytest.mark.usefixtures("light_scenes")
def test_campaign_continues_with_the_remaining_workers(own, tmp_path, monkeypatch):
    monkeypatch.setattr(paused, "REPORTED_AFTER", 0.0)
    crew = Crew(own, lambda _: None)
    assert crew.window == 2 * SCENES_PER_WORKER
    pause(own, 1)
    crew.count()
    crew.count()
    assert crew.window == 1
    done, _ = swept(campaign_in(tmp_path, LIGHT), tmp_path, own)
    assert done.finished == open_sweep(tmp_path).attrs["scenes"] == 27
