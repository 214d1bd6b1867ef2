"""The address of a Dask scheduler: its form, and whether a scheduler answers there."""

import asyncio
import re
import socket
from dataclasses import dataclass
from urllib.parse import urlsplit

from distributed import Security
from distributed.core import rpc

from geometries.errors import Failure, WrongInput

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
