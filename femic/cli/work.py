"""Options that commands share: the folder of results, workers and store."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console

from femic.cache import folders
from femic.cache.store import Store
from femic.cli import progress
from femic.late import Late
from femic.reference.run_options import RunOptions, cores
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

AT = "@"  # between a campaign and the name of its points
TABLE_WIDTH = 130  # characters

SceneName = Annotated[str, Parameter(help="built-in name (see `femic scenes`) or TOML file")]
Workers = Annotated[int | None, Parameter(help="parallel processes or threads; default: one per core")]
StoreAt = Annotated[
    str | None,
    Parameter(help="folder or URL where solved models are kept, for all scenes; default OUT/store"),
]


url_to_fs = Late("fsspec.core:url_to_fs")


@Parameter(name="*")
@dataclass(frozen=True)
class Work:
    """Where the results of a scene go, and how they are computed."""

    out: Annotated[
        Path | None,
        Parameter(help="folder for the results; default out/SCENE; of several scenes OUT/SCENE each"),
    ] = None
    workers: Workers = None
    store: StoreAt = None

    def folder(self, scene: Scene) -> Path:
        """The folder that the results of a scene are written to."""
        return self.out or Path("out") / scene.name

    def folder_among(self, scene: Scene, scenes: Sequence[Scene]) -> Path:
        """The folder of the results of one of several scenes; of a single one as `folder`."""
        return self.folder(scene) if len(scenes) == 1 else (self.out or Path("out")) / scene.name

    def joint_folder(self, names: Sequence[str]) -> Path:
        """The folder of what is written of several scenes together."""
        return self.out or Path("out") / "_".join(names)

    @property
    def threads(self) -> int:
        """The number of workers."""
        return self.workers or cores()

    @contextmanager
    def options(self, folder: Path, console: Console) -> Iterator[RunOptions]:
        """Workers, a store of solved models in a folder of results unless one is named, and progress.

        No other run writes into the folder meanwhile. Raises as `folders.locked` does.
        """
        with folders.locked(folder), progress.shown(console) as watch:
            yield RunOptions(self.threads, kept(self.store, folder), watch)


def kept(location: str | None, folder: Path) -> Store:
    """The store at a location, or else that in a folder, without models that other code left there.

    Raises WrongInput for a location of a kind that there is no library for, or that cannot be looked at.
    """
    if location is not None:
        try:
            system, path = url_to_fs(location)
            system.exists(path)
        except (ImportError, ValueError) as error:
            raise WrongInput(
                f"--store {location}: {error}: give a folder, or a URL of a kind that fsspec knows; for "
                "object stores install its library into .venv (s3fs, gcsfs, adlfs)"
            ) from error
        except Exception as error:  # each kind has its own
            raise WrongInput(
                f"--store {location}: cannot be looked at ({type(error).__name__}: {error}): is it right, "
                "and are there credentials for it (for S3: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY)?"
            ) from error
        return Store(location)
    store = Store(folder / "store")
    store.remove_other_code()
    return store


DEFAULT_WORK = Work()
