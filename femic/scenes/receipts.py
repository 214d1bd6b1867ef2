"""Receipts of finished results: the input of a run and the digests of the files it wrote.

A later run reuses finished results only with their receipt, and only while none of its files has changed.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from hashlib import file_digest
from pathlib import Path

from pydantic import BaseModel

from femic.cache import folders
from femic.cache.digests import results_digest
from femic.cache.files import write_text
from femic.cache.store import Store
from femic.scenes.scene import Scene

NAME = "{}.receipt.json"  # of the file, by the command


class Receipt(BaseModel):
    """The key of finished results, and the digests of their files by name."""

    key: str
    sha256: dict[str, str]


def key_of(scene: Scene, *further: object) -> str:
    """Return the key of everything that results of a scene depend on: code, text, bodies, and `further`.

    Contents of files that the scene names are in its bodies.
    """
    return Store().key("results", results_digest(), scene.text, dict(scene.bodies), *further)


@contextmanager
def renewed(folder: Path, command: str, key: str, files: Iterable[str]) -> Iterator[Path]:
    """Yield a folder, created if missing, into which a command writes files of results.

    An old receipt of these files is removed before; afterwards, if nothing was raised, they have a new one.
    """
    path = folders.make(folder) / NAME.format(command)
    path.unlink(missing_ok=True)
    yield folder
    digests = {name: _digest(folder / name) for name in files}
    write_text(Receipt(key=key, sha256=digests).model_dump_json(indent=1), path)


def holds(folder: Path, command: str, key: str) -> bool:
    """Whether a folder has the results of a key, with unchanged files."""
    receipt = _read(folder, command)
    return receipt is not None and receipt.key == key and not changed(folder, command)


def changed(folder: Path, command: str) -> list[str]:
    """Return the names of files of a receipt that are missing or have changed; none without a receipt."""
    receipt = _read(folder, command)
    digests = receipt.sha256 if receipt else {}
    return [name for name, digest in digests.items() if _digest(folder / name) != digest]


def _read(folder: Path, command: str) -> Receipt | None:
    """Return the receipt of a command, None without a readable one."""
    try:
        return Receipt.model_validate_json((folder / NAME.format(command)).read_bytes())
    except (OSError, ValueError):
        return None


def _digest(path: Path) -> str:
    """Return the digest of a file, "" where it cannot be read."""
    try:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
