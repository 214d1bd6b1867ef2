"""One run at a time writes the dataset of a campaign."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from geometries.errors import Failure

LOCK = ".sweep.lock"


@contextmanager
def only_run_in(folder: Path) -> Iterator[None]:
    """A context in which no other run writes into a folder; raises Failure where one does."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / LOCK).open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise Failure(
                f"{folder}: another run of this campaign writes there: wait for its end, or give another "
                "folder (--out); both may share a store (--store)"
            ) from error
        yield
