"""Clusters: addresses, paused and missing workers, strangers, interruptions; what workers must have."""

import os
import signal
import socket
import time
from contextlib import contextmanager, nullcontext, suppress

import dask
import numpy as np
import psutil
import pytest
from distributed import Client
from distributed.core import Status

from approx.forms import FORMS, Form
from compare.campaigns import cluster, run, tasks
from compare.campaigns.cluster import (
    ClusterSize,
    existing_cluster,
    local_cluster,
    parse_address,
    require_scheduler,
    size_for,
)
from compare.campaigns.dataset import CampaignDataset, keys_in, open_sweep
from compare.campaigns.run import Options, Stall, compute_sweep
from compare.campaigns.tasks import PROBE, Unusable, different_registrations, registrations
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.results.ics import compute
from geometries.errors import Failure, WrongInput
from tests.approx.new_forms import faded, register
from tests.compare.campaigns import campaigns

# --- addresses -----------------------------------------------------------------------------------------

NONE = (
    *("", "nonsense", "scheduler.json", "http://127.0.0.1:8786", "inproc://127.0.0.1/1/1"),
    *("tcp://", "tcp://127.0.0.1", "tcp://:8786", "tcp://127.0.0.1:port", "tcp://127.0.0.1:8786/status"),
    *(f"tcp://127.0.0.1:{port}" for port in (0, 99999, -1)),
    *("tcp://me@127.0.0.1:8786", "tcp://a b:8786", "tcp://[::1:8786"),
)


@pytest.mark.parametrize("text", NONE)
def test_malformed_addresses_are_refused(text):
    with pytest.raises(WrongInput, match="is not the address of a Dask scheduler: give PROTOCOL://HOST:PORT"):
        parse_address(text)


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("tcp://10.0.0.5:8786", "tcp://10.0.0.5:8786"),
        (" node-7.cluster.org:8786", "tcp://node-7.cluster.org:8786"),
        ("tls://[fe80::1]:8786", "tls://[fe80::1]:8786"),
        ("ws://localhost:80", "ws://localhost:80"),
    ],
)
def test_an_address_has_protocol_host_and_port(text, address):
    assert str(parse_address(text)) == address


@pytest.mark.parametrize("scheme", ["tcp", "tls"])
def test_server_other_than_dask_is_reported(scheme):
    """It takes connections, and says nothing."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        address = parse_address(f"{scheme}://127.0.0.1:{server.getsockname()[1]}")
        message = rf"no scheduler answers at {scheme}://127.* within 0\.5 s \(.+\): check that `dask"
        with pytest.raises(Failure, match=message):
            require_scheduler(address, timeout=0.5)


@pytest.mark.parametrize("host", ["127.0.0.1:9", "nowhere.invalid:8786", f"{'a' * 70}.org:8786"])
def test_address_where_nothing_listens_is_reported(host):
    with pytest.raises(Failure, match="no scheduler answers at tcp://"):
        require_scheduler(parse_address(host), timeout=2.0)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nowhere at all"])
def test_scheduler_that_does_not_answer_is_reported(address):
    message = rf"no scheduler answers at {address} within 0\.2 s .* that the address is right"
    with pytest.raises(Failure, match=message), existing_cluster(address, timeout=0.2):
        pass


# --- workers that are paused or gone -------------------------------------------------------------------


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
    message = r"2 of 2 workers are paused .*\(900 of 1000 MB\), and no task is running: give the w"
    with pytest.raises(Failure, match=message):
        messages_after((29, PAUSED, PAUSED))


def test_paused_workers_with_others_or_with_a_task_do_not_end_the_campaign():
    states = (300, PAUSED, RUNNING), (24, PAUSED, PAUSED), (300, PAUSED, AT_WORK), (24, PAUSED, PAUSED)
    assert messages_after(*states, (9, AT_WORK, PAUSED)) == []
    assert Stall(print).update({"a": PAUSED, "b": RUNNING, "c": RUNNING}) == 2


def test_missing_workers_are_reported_once():
    (message,) = messages_after((2,), (2, RUNNING), (99,))
    assert message.startswith("no workers are left")


@pytest.fixture(scope="module")
def served():
    """A cluster of two workers that is reached by its address, without limits of memory."""
    with campaigns.threads(n_workers=2, memory_limit=0, protocol="tcp") as served:
        yield served


@contextmanager
def paused(client, number):
    """Have Dask pause a number of workers, and wait until the scheduler knows; they go on afterwards."""

    def set_status(dask_worker, status):
        dask_worker.status = status

    def statuses():
        return [one["status"] for one in client.scheduler_info(n_workers=-1)["workers"].values()]

    chosen = sorted(client.scheduler_info(n_workers=-1)["workers"])[:number]
    client.run(set_status, status=Status.paused, workers=chosen)
    while statuses().count("paused") < number:
        time.sleep(0.01)
    yield
    client.run(set_status, status=Status.running, workers=chosen)
    while "paused" in statuses():
        time.sleep(0.01)


@pytest.mark.usefixtures("light_scenes")
def test_a_campaign_goes_on_with_the_workers_that_are_left_and_does_not_wait_forever(
    served, tmp_path, monkeypatch
):
    campaign = campaigns.campaign_in(tmp_path, campaigns.LIGHT)
    monkeypatch.setattr(run, "GIVE_UP_AFTER", 1.5)
    with Client(served, set_as_default=False) as client:
        with paused(client, 2), pytest.raises(Failure, match="2 of 2 workers are paused by Dask"):
            campaigns.swept(campaign, tmp_path, client)
        with paused(client, 1):
            done, _ = campaigns.swept(campaign, tmp_path, client)
    assert done.finished == open_sweep(tmp_path).attrs["scenes"] == 15


def test_paused_workers_count_as_workers(served, monkeypatch):
    """To wait for workers would be to wait for the end of the pause."""
    monkeypatch.setattr(cluster, "WORKS_WITHIN", 1.0)
    with (
        Client(served, set_as_default=False) as client,
        paused(client, 2),
        existing_cluster(served.scheduler_address) as other,
    ):
        assert Stall(print).update(other.scheduler_info(n_workers=-1)["workers"]) == 0


def test_scheduler_is_accepted_and_worker_is_refused(served):
    require_scheduler(parse_address(served.scheduler_address))
    with pytest.raises(Failure, match="is a worker, not a scheduler"):
        require_scheduler(parse_address(served.workers[0].address))


@pytest.mark.usefixtures("light_scenes")
def test_lost_workers_and_a_lost_scheduler_are_reported_and_finished_scenes_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "WORKS_WITHIN", 1.0)
    with dask.config.set({"distributed.comm.timeouts.connect": "1s"}), campaigns.threads() as own:

        def go(progress):
            if progress.finished == 3:
                own.sync(own.scheduler.close)

        with (
            existing_cluster(own.scheduler_address, timeout=1.0) as client,
            pytest.raises(Failure, match=r"lost contact with the scheduler\. Finished scenes are stored"),
        ):
            campaigns.swept(campaigns.campaign_in(tmp_path, campaigns.LIGHT), tmp_path, client, Options(go))
    assert int(np.sum(open_sweep(tmp_path).seconds.notnull())) >= 3
    with (
        campaigns.threads(n_workers=0, protocol="tcp") as own,
        pytest.raises(Failure, match="has no workers: start some"),
        existing_cluster(own.scheduler_address),
    ):
        pass


@pytest.mark.slow  # test_failures.py has a model that kills workers without solving any
def test_killed_worker_costs_one_task(tmp_path):
    """With one worker the task at hand is begun again; the results are those of a run by itself."""
    campaign, killed = campaigns.campaign_in(tmp_path, campaigns.OF_UPPER), []
    with local_cluster(size_for(1, 2, 400.0)) as client:

        def kill(_):
            if not killed:
                (pid,) = client.run(os.getpid).values()
                killed.append(pid)
                os.kill(pid, 9)

        collected, store = CampaignDataset(campaign, tmp_path), Store(tmp_path / "store")
        done = compute_sweep(collected, store, campaigns.clusters_of(client), Options(on_progress=kill))
    assert killed
    assert (done.finished, done.failed) == (2, 0)
    assert 3 <= done.models <= 4  # the lower body and two upper ones, one of them perhaps twice
    results = compute(campaign.scene((12.0,)), RunOptions(1, Store(tmp_path / "alone")))
    computed = open_sweep(tmp_path).sel(R=12).error
    np.testing.assert_array_equal(computed, campaigns.errors_of(results).error.transpose(*computed.dims))


# --- a cluster of processes on this machine ------------------------------------------------------------


def test_number_of_workers_fits_into_memory():
    assert size_for(8, 100, 900.0, 10_000.0).workers == 8
    few = size_for(8, 100, 3000.0, 10_000.0)
    assert (few.workers, few.memory) == (3, pytest.approx(3000))
    assert "3 instead of 8 workers, because models take up to 3000 MB" in few.note
    assert size_for(8, 2, 100.0, 10_000.0).workers == 2
    assert size_for(8, 100, 30_000.0, 10_000.0).workers == 1


def listening():
    """The addresses at which this process and its children take connections."""
    this = psutil.Process()
    for process in (this, *this.children(recursive=True)):
        for connection in process.net_connections("inet"):
            if connection.status == psutil.CONN_LISTEN:
                yield connection.laddr


def answer_to_a_stranger(address):
    """What a server says to someone without a certificate."""
    with socket.create_connection((address.ip, address.port), timeout=5) as stranger:
        stranger.sendall(b"GET /health HTTP/1.0\r\n\r\n")
        with suppress(ConnectionResetError):
            return stranger.recv(100)
    return b""


def test_local_cluster_refuses_strangers_and_workers_with_other_forms_of_ics(tmp_path, monkeypatch):
    """Also the Dask of strangers; what is served by HTTP has nothing."""
    before = {*listening()}
    with local_cluster(ClusterSize(1, 1000.0)) as client:
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
        assert list(client.run(different_registrations, registrations()).values()) == [[]]
        register(monkeypatch)
        campaign = campaigns.campaign_in(tmp_path, campaigns.OF_UPPER.replace('"Bhat"', '"Btilde"'))
        with pytest.raises(Unusable, match=r"form 'Btilde', .*variant 'Btilde', .*: not registered in a wor"):
            campaigns.swept(campaign, tmp_path, client)
    assert keys_in(Store(tmp_path / "store")) == {PROBE}


def test_form_with_another_definition_is_different(monkeypatch):
    submitted = registrations()
    monkeypatch.setitem(FORMS, "B", Form(faded))
    assert different_registrations(submitted) == ["form 'B'", "variant 'B'", "variant 'mix'"]
    assert different_registrations(registrations()) == []


def test_worker_without_the_store_is_refused(tmp_path):
    assert "does not see the store" in tasks.worker_problem(tasks.origin(Store(tmp_path)))


@pytest.mark.parametrize(("interruptions", "events"), [(1, ["begun", "ended"]), (2, [])])
def test_cluster_interrupted_at_its_start_is_shut_down_unless_interrupted_again(
    monkeypatch, interruptions, events
):
    """The second Ctrl-C takes effect at once."""
    noted, before = [], signal.getsignal(signal.SIGINT)

    @contextmanager
    def begun(*_, **__):
        for _ in range(interruptions):
            os.kill(os.getpid(), signal.SIGINT)
        noted.append("begun")
        try:
            yield
        finally:
            noted.append("ended")

    monkeypatch.setattr(cluster, "LocalCluster", begun)
    monkeypatch.setattr(cluster, "Client", lambda *_, **__: nullcontext())
    with pytest.raises(KeyboardInterrupt), local_cluster(ClusterSize(1, 1000.0)):
        pytest.fail("it goes on")
    assert noted == events
    assert signal.getsignal(signal.SIGINT) is before
