"""What commands share: where results go, and how they are computed."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from compare.cli import progress
from compare.scenes.scene import Scene
from femic.means import Means, cores
from femic.work.store import Store

WIDE = 130  # columns of a table

Workers = Annotated[int | None, Parameter(help="parallel processes or threads; default: one per core")]
StoreAt = Annotated[
    str | None,
    Parameter(help="folder or URL where solved models are kept, for all scenes; default OUT/store"),
]


@Parameter(name="*")
@dataclass(frozen=True)
class Work:
    """Where the results of a scene go, and how they are computed."""

    out: Annotated[Path | None, Parameter(help="folder for the results; default out/SCENE")] = None
    workers: Workers = None
    store: StoreAt = None

    def folder(self, scene: Scene) -> Path:
        """Where the results of a scene go."""
        return self.out or Path("out") / scene.name

    @property
    def threads(self) -> int:
        """How many work at a time."""
        return self.workers or cores()

    @contextmanager
    def means(self, folder: Path, console: Console) -> Iterator[Means]:
        """Workers, a store, and progress on the console; what is solved is kept in a folder of results."""
        with progress.shown(console) as watch:
            yield Means(self.threads, kept(self.store, folder), watch)


def kept(location: str | None, folder: Path) -> Store:
    """A named store, or that in a folder, without what other code left there."""
    if location is not None:
        return Store(location)
    store = Store(folder / "store")
    store.forget_other_code()
    return store


DEFAULT = Work()
