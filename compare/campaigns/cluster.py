"""Dask clusters for campaigns: the cores of this machine, or any cluster with a scheduler.

Workers have one thread each, and one BLAS thread. Workers on this machine end with the program, however it
ends, and their connections are closed to other users. The address of a scheduler is checked first: its form,
and whether a scheduler answers there.
"""

import asyncio
import logging
import re
import signal
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from threading import current_thread, main_thread
from time import perf_counter, sleep
from typing import Any
from urllib.parse import urlsplit
from warnings import catch_warnings, simplefilter

import dask
from distributed import Client, LocalCluster, Security
from distributed.core import rpc
from distributed.system import MEMORY_LIMIT

from femic.reference.engine import BASE_MEMORY
from femic.reference.run_options import cores
from geometries.errors import Failure, WrongInput

# --- the address of a scheduler -------------------------------------------------------------------------


SCHEMES = ("tcp", "tls", "ws", "wss")  # protocols of Dask between machines
HOST = re.compile(r"[\w.:%-]+")
ANSWERS_WITHIN = 5.0  # seconds in which a machine takes a connection


@dataclass(frozen=True)
class Address:
    """An address such as tcp://10.0.0.5:8786."""

    scheme: str
    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.scheme}://{host}:{self.port}"


def address_of(text: str) -> Address:
    """Return the address in a text, tcp where it names no protocol; raise WrongInput."""
    scheme, separator, rest = text.strip().rpartition("://")
    wrong = WrongInput(
        f"--scheduler {text!r}: is not the address of a Dask scheduler: give PROTOCOL://HOST:PORT as "
        f"`dask scheduler` prints it, such as tcp://10.0.0.5:8786; protocols are {', '.join(SCHEMES)}"
    )
    try:
        parts = urlsplit(f"//{rest}")
        host, port = parts.hostname, parts.port
    except ValueError as error:  # a port that is no number, or too large
        raise wrong from error
    scheme = scheme if separator else "tcp"
    plain = not (parts.path or parts.query or parts.fragment or parts.username)
    if scheme not in SCHEMES or not host or not HOST.fullmatch(host) or not port or not plain:
        raise wrong
    return Address(scheme, host, port)


def require_scheduler(address: Address, timeout: float = ANSWERS_WITHIN) -> None:
    """Raise Failure where no scheduler of Dask answers at an address."""
    try:
        socket.create_connection((address.host, address.port), timeout).close()
        kind = asyncio.run(_kind(str(address), timeout))
    except Exception as error:  # whatever another kind of server, or a certificate, causes
        raise no_answer(str(address), timeout, error) from error
    if kind != "Scheduler":
        raise Failure(
            f"{address} is a {kind.lower()}, not a scheduler: give the address that `dask scheduler` prints"
        )


async def _kind(address: str, timeout: float) -> str:
    """The kind of server at an address: Scheduler, Worker, Nanny.

    A client of Dask waits forever for a server that takes a connection and then says nothing.
    """
    certificates = Security().get_connection_args("client")  # those of Dask's configuration
    async with asyncio.timeout(timeout), rpc(address, connection_args=certificates) as server:
        return str((await server.identity())["type"])


def no_answer(address: str, timeout: float, error: Exception) -> Failure:
    """Return the failure that no scheduler answers at an address, with possible causes."""
    return Failure(
        f"no scheduler answers at {address} within {timeout:g} s ({str(error) or type(error).__name__}): is "
        "`dask scheduler` running there, is the address right (tcp://HOST:8786), does a firewall let it "
        "through, has Dask's configuration certificates for tls? Without --scheduler the cores of "
        "this machine are used"
    )


# --- clusters -------------------------------------------------------------------------------------------


CONNECTS_WITHIN = 10.0  # seconds in which a scheduler answers
WORKS_WITHIN = 25.0  # seconds in which a scheduler has a worker
POLL_EVERY = 0.1  # seconds between polls for workers
MEMORY_SHARE = 0.9  # of the machine's memory that workers may have
MOST_DEATHS = 3  # times that the worker of a task may die before the task is given up
QUIET = ("distributed", "tornado", "asyncio")  # logs of workers that come and go

NO_DASHBOARD = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}  # any free port, this machine only

LOCAL_SETTINGS: dict[str, Any] = {
    "distributed.worker.preload": ["compare.campaigns.local_worker"],
    "distributed.scheduler.http.routes": [],  # every user of this machine can reach what is served by HTTP
    "distributed.worker.http.routes": [],
    "distributed.worker.profile.enabled": False,  # a hundred samples a second without a reader
    "distributed.worker.memory.target": False,  # results are in the store: there is nothing to spill
    "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False,  # nothing would free memory meanwhile
    "distributed.scheduler.worker-ttl": None,  # a factorisation may hold the interpreter for long
    "distributed.scheduler.allowed-failures": MOST_DEATHS,
    "distributed.admin.system-monitor.gil.enabled": False,
}


@dataclass(frozen=True)
class ClusterSize:
    """The number of local workers, the memory that each may have [MB], and a note on it."""

    workers: int
    memory: float
    note: str = ""


def size_for(requested: int | None, scenes: int, largest: float, memory: float | None = None) -> ClusterSize:
    """Return the size of a local cluster for models that take up to `largest` MB.

    By default there is a worker per core, and not more than scenes; fewer where their models would not fit
    into `memory` [MB], by default that of the machine.
    """
    available = MEMORY_SHARE * (MEMORY_LIMIT / 2**20 if memory is None else memory)
    useful = max(1, min(requested or cores(), scenes))
    fitting = max(1, int(available // max(largest, BASE_MEMORY)))
    note = (
        f"{fitting} instead of {useful} workers: models take up to {largest:.0f} MB, and there are "
        f"{available:.0f} MB for all"
    )
    workers = min(useful, fitting)
    return ClusterSize(workers, available / workers, note if fitting < useful else "")


@contextmanager
def local_cluster(size: ClusterSize) -> Iterator[Client]:
    """Yield the client of a cluster of processes on this machine, which end with the context.

    Nobody else can use it: connections need a certificate that is made for this run, in memory only.
    """
    with _quiet(), dask.config.set(LOCAL_SETTINGS), ExitStack() as started:
        with _interrupts_delayed():
            cluster = started.enter_context(
                LocalCluster(
                    n_workers=size.workers,
                    threads_per_worker=1,
                    processes=True,
                    memory_limit=int(size.memory * 2**20),
                    scheduler_kwargs=NO_DASHBOARD,
                    security=Security.temporary(),
                    silence_logs=logging.CRITICAL,
                )
            )
            client = started.enter_context(Client(cluster, set_as_default=False))
        try:
            yield client
        except BaseException:
            _kill(cluster)
            raise


@contextmanager
def _interrupts_delayed() -> Iterator[None]:
    """Delay Ctrl-C until the context ends: Dask cannot shut down a cluster that is half started.

    A second Ctrl-C takes effect at once.
    """
    if current_thread() is not main_thread():  # others are not interrupted
        yield
        return
    signals: list[int] = []

    def handler(number: int, _: object) -> None:
        if signals:
            raise KeyboardInterrupt
        signals.append(number)

    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if signals:
        raise KeyboardInterrupt


@contextmanager
def existing_cluster(address: str, timeout: float = CONNECTS_WITHIN) -> Iterator[Client]:
    """Yield a client of the scheduler at an address; raise Failure if none answers, or it has no workers."""
    with _quiet(), _connected(address, timeout) as client:
        _require_workers(client, address)
        yield client


def _require_workers(client: Client, address: str) -> None:
    """Wait for workers, paused ones included; raise Failure if there are none in time."""
    start = perf_counter()
    while not client.scheduler_info(n_workers=-1).get("workers"):
        if perf_counter() - start > WORKS_WITHIN:
            raise Failure(
                f"the scheduler at {address} has no workers: start some, such as `dask worker {address} "
                "--nthreads 1 --nworkers 8`"
            )
        sleep(POLL_EVERY)


def _connected(address: str, timeout: float) -> Client:
    """Return a client of the scheduler at an address; raise Failure where none answers."""
    with catch_warnings():
        simplefilter("ignore")  # of other versions of Dask: the digest of the code decides
        try:
            return Client(address, timeout=timeout, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise no_answer(address, timeout, error) from error


def _kill(cluster: LocalCluster) -> None:
    """Kill the workers of a local cluster at once; the next run repeats their work."""
    for nanny in cluster.workers.values():
        nanny.auto_restart = False
        process = getattr(nanny.process, "process", None)
        if process is not None and process.pid is not None:
            process._process.kill()


@contextmanager
def _quiet() -> Iterator[None]:
    """Let Dask log critical errors only, within the context."""
    known = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in QUIET]
    loggers = [logging.getLogger(name) for name in {*QUIET, *known}]  # some have levels of their own
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)
