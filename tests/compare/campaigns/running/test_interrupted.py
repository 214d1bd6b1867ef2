"""Ctrl-C while a local cluster begins: it ends in order."""

import os
import signal
from contextlib import contextmanager, nullcontext

import pytest

from compare.campaigns import cluster
from compare.campaigns.cluster import ClusterSize, local_cluster


@pytest.fixture
def stand_in(monkeypatch):
    """A cluster that is interrupted a number of times at its start, and a list of events."""
    events, interruptions = [], [1]

    @contextmanager
    def begun(*_, **__):
        for _ in range(interruptions[0]):
            os.kill(os.getpid(), signal.SIGINT)
        events.append("begun")
        try:
            yield
        finally:
            events.append("ended")

    monkeypatch.setattr(cluster, "LocalCluster", begun)
    monkeypatch.setattr(cluster, "Client", lambda *_, **__: nullcontext())
    return events, interruptions


def enter():
    with local_cluster(ClusterSize(1, 1000.0)):
        pytest.fail("it goes on")


def test_cluster_interrupted_at_its_start_is_shut_down(stand_in):
    events, _ = stand_in
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        enter()
    assert events == ["begun", "ended"]
    assert signal.getsignal(signal.SIGINT) is before


def test_second_interruption_takes_effect_at_once(stand_in):
    events, interruptions = stand_in
    interruptions[0] = 2
    with pytest.raises(KeyboardInterrupt):
        enter()
    assert events == []
