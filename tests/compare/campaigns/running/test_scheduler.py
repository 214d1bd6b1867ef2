"""Addresses of schedulers: what is none is said at once."""

import socket

import pytest

from compare.campaigns.cluster import parse_address, require_scheduler
from geometries.errors import Failure, WrongInput
from tests.compare.campaigns.campaigns import threads

NONE = (
    "",
    "nonsense",
    "scheduler.json",
    "http://127.0.0.1:8786",
    "inproc://127.0.0.1/1/1",
    "tcp://",
    "tcp://127.0.0.1",
    "tcp://:8786",
    "tcp://127.0.0.1:0",
    "tcp://127.0.0.1:99999",
    "tcp://127.0.0.1:-1",
    "tcp://127.0.0.1:port",
    "tcp://127.0.0.1:8786/status",
    "tcp://me@127.0.0.1:8786",
    "tcp://a b:8786",
    "tcp://[::1:8786",
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


@pytest.fixture
def silent():
    """The address of a server that takes connections, and says nothing."""
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        yield f"127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.parametrize("scheme", ["tcp", "tls"])
def test_server_other_than_dask_is_reported(silent, scheme):
    with pytest.raises(
        Failure, match=rf"no scheduler answers at {scheme}://127.* within 0\.5 s \(.+\): is `dask"
    ):
        require_scheduler(parse_address(f"{scheme}://{silent}"), timeout=0.5)


@pytest.mark.parametrize("host", ["127.0.0.1:9", "nowhere.invalid:8786", f"{'a' * 70}.org:8786"])
def test_address_where_nothing_listens_is_reported(host):
    with pytest.raises(Failure, match="no scheduler answers at tcp://"):
        require_scheduler(parse_address(host), timeout=2.0)


def test_scheduler_is_accepted_and_worker_is_refused():
    with threads(protocol="tcp") as own:
        require_scheduler(parse_address(own.scheduler_address))
        (worker,) = own.workers.values()
        with pytest.raises(Failure, match="is a worker, not a scheduler"):
            require_scheduler(parse_address(worker.address))
