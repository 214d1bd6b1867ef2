"""Dask clusters for campaigns: the cores of this machine, or any cluster with a scheduler.

Workers have one thread each, and one BLAS thread. Dask ends workers on this machine with the program, however
it ends; their connections are closed to other users. The address of a scheduler is checked first: its form,
and whether a scheduler answers there.
"""

import asyncio
import logging
import re
import signal
import socket
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from threading import current_thread, main_thread
from typing import Any, TypeVar
from urllib.parse import urlsplit
from warnings import catch_warnings, simplefilter

import dask
from distributed import Client, KilledWorker, LocalCluster, Security
from distributed.core import rpc
from distributed.system import MEMORY_LIMIT
from distributed.utils import silence_logging_cmgr

from femic.reference.engine import BASE_MEMORY
from femic.reference.run_options import cores
from geometries.errors import Failure, WrongInput

Argument = TypeVar("Argument")
Result = TypeVar("Result")

# --- the address of a scheduler -------------------------------------------------------------------------


SCHEMES = ("tcp", "tls", "ws", "wss")  # protocols of Dask between machines
HOST = re.compile(r"[\w.:%-]+")
ANSWERS_WITHIN = 5.0  # seconds in which a machine takes a connection


def parse_address(text: str) -> str:
    """Return an address such as tcp://10.0.0.5:8786; tcp is the default protocol. Raise WrongInput."""
    scheme, separator, rest = text.strip().rpartition("://")
    scheme = scheme if separator else "tcp"
    host, port = _host_and_port(rest)
    if scheme not in SCHEMES or not HOST.fullmatch(host) or not port:
        raise WrongInput(
            f"--scheduler {text!r}: is not the address of a Dask scheduler: give PROTOCOL://HOST:PORT as "
            f"`dask scheduler` prints it, such as tcp://10.0.0.5:8786; protocols are {', '.join(SCHEMES)}"
        )
    return f"{scheme}://[{host}]:{port}" if ":" in host else f"{scheme}://{host}:{port}"


def _host_and_port(address: str) -> tuple[str, int]:
    """Return host and port of HOST:PORT, "" and 0 where there are none, or other parts."""
    try:
        parts = urlsplit(f"//{address}")
        is_plain = not (parts.path or parts.query or parts.fragment or parts.username)
        return (parts.hostname or "", parts.port or 0) if is_plain else ("", 0)
    except ValueError:  # a port that is no number, or too large
        return "", 0


def require_scheduler(address: str, timeout: float = ANSWERS_WITHIN) -> None:
    """Raise Failure where no scheduler of Dask answers at an address."""
    try:
        socket.create_connection(_host_and_port(address.partition("://")[2]), timeout).close()
        kind = asyncio.run(_server_kind(address, timeout))
    except Exception as error:  # whatever another kind of server, or a certificate, causes
        raise no_answer(address, timeout, error) from error
    if kind != "Scheduler":
        raise Failure(
            f"{address} is a {kind.lower()}, not a scheduler: give the address that `dask scheduler` prints"
        )


async def _server_kind(address: str, timeout: float) -> str:
    """The kind of server at an address: Scheduler, Worker, Nanny.

    A client of Dask waits forever for a server that takes a connection and then says nothing.
    """
    certificates = Security().get_connection_args("client")  # those of Dask's configuration
    async with asyncio.timeout(timeout), rpc(address, connection_args=certificates) as server:
        return str((await server.identity())["type"])


def no_answer(address: str, timeout: float, error: Exception) -> Failure:
    """Return the failure that no scheduler answers at an address, with possible causes."""
    return Failure(
        f"no scheduler answers at {address} within {timeout:g} s ({str(error) or type(error).__name__}): "
        "check that `dask scheduler` runs there, that the address is right (tcp://HOST:8786), that no "
        "firewall blocks it, and that Dask has certificates for tls. Without --scheduler femic uses the "
        "cores of this machine"
    )


# --- clusters -------------------------------------------------------------------------------------------


CONNECTS_WITHIN = 10.0  # seconds in which a scheduler answers
WORKS_WITHIN = 25.0  # seconds in which a scheduler has a worker
MEMORY_SHARE = 0.9  # of the machine's memory that workers may have
MOST_DEATHS = 3  # times that the worker of a task may die before the task is given up

NO_DASHBOARD = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}  # any free port, this machine only

LOCAL_SETTINGS: dict[str, Any] = {
    "distributed.worker.preload": ["compare.campaigns.cluster"],
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


def dask_setup(_worker: object) -> None:
    """Prepare the process of a worker of this machine: its parent handles Ctrl-C, and says what is wrong."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("distributed").setLevel(logging.CRITICAL)


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
        f"{fitting} instead of {useful} workers, because models take up to {largest:.0f} MB, and there are "
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
        except BaseException:  # Dask would wait for tasks, 4 s and longer on a busy machine
            for nanny in cluster.workers.values():
                nanny.auto_restart = False
                process = getattr(nanny.process, "process", None)
                if process is not None and process.pid is not None:
                    process._process.kill()
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
    """Yield a client of the scheduler at an address; raise Failure if none answers, or it has no workers.

    Workers that Dask has paused count: a run says what it waits for.
    """
    with ExitStack() as started:
        started.enter_context(_quiet())
        try:
            with catch_warnings():
                simplefilter("ignore")  # of other versions of Dask: the digest of the code decides
                client = started.enter_context(Client(address, timeout=timeout, set_as_default=False))
        except (OSError, TimeoutError, ValueError) as error:
            raise no_answer(address, timeout, error) from error
        try:
            client.wait_for_workers(1, timeout=WORKS_WITHIN)
        except TimeoutError as error:
            if not client.scheduler_info(n_workers=-1)["workers"]:
                raise Failure(
                    f"the scheduler at {address} has no workers: start some, such as `dask worker {address} "
                    "--nthreads 1 --nworkers 8`"
                ) from error
        yield client


def in_order(
    client: Client, function: Callable[[Argument], Result], arguments: Iterable[Argument]
) -> Iterator[Result]:
    """Yield the results of a function for arguments, which the workers of a cluster compute, in their order.

    Raises Failure where workers die.
    """
    futures = client.map(function, list(arguments), pure=False)
    try:
        for future in futures:
            yield future.result()
    except KilledWorker as error:
        raise Failure(
            "the workers of the cluster died, most likely because memory ran out. Give them more memory, or "
            "start fewer on each machine. Finished parts are stored: repeat the command to continue"
        ) from error
    finally:
        client.cancel(futures)


@contextmanager
def _quiet() -> Iterator[None]:
    """Let Dask, whose workers come and go, log critical errors only within the context."""
    loggers = {name: logging.getLogger(name) for name in ("asyncio", "distributed")}
    before = {name: logger.level for name, logger in loggers.items()}
    for logger in loggers.values():
        logger.setLevel(logging.CRITICAL)
    try:
        with silence_logging_cmgr(logging.CRITICAL):
            yield
    finally:
        for name, logger in loggers.items():
            logger.setLevel(before[name])
