"""Options that commands share: folder of results, workers, store."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal
from uuid import uuid4

from cyclopts import Parameter, Token
from cyclopts.validators import Number
from rich.console import Console

from femic.cache import folders
from femic.cache.store import Store
from femic.cli import progress
from femic.lazy import lazy_imports
from femic.reference.run_options import RunOptions, cores
from femic.scenes import plausibility
from femic.scenes.ic_names import is_map
from femic.scenes.scene import Scene
from femic.scenes.values import WHOLE
from geometries.errors import WrongInput

with lazy_imports():
    import fsspec

    from compare.campaigns import maps as c_map
    from compare.report import files, parts

OUT = Path("out")  # the folder of all results, unless another is given
AT = "@"  # between a campaign and the name of its points
TABLE_WIDTH = 130  # characters

SceneName = Annotated[str, Parameter(help="built-in name (see `femic scenes`) or TOML file")]
MOST_WORKERS = 1024


def whole_numbers(_: Any, tokens: Sequence[Token]) -> tuple[int, ...]:
    """Return the whole numbers that stand after an option; raise ValueError for others, such as 1.5."""
    wrong = [token.value for token in tokens if not WHOLE.fullmatch(token.value)]
    if wrong:
        raise ValueError(f"{wrong[0]!r} is not a whole number")
    return tuple(int(token.value) for token in tokens)


def whole_number(kind: Any, tokens: Sequence[Token]) -> int:
    """Return the whole number that stands after an option; raise ValueError as `whole_numbers` does."""
    return whole_numbers(kind, tokens)[0]


Workers = Annotated[
    int | None,
    Parameter(
        help="parallel processes or threads; default: one per core",
        converter=whole_number,
        validator=Number(gte=1, lte=MOST_WORKERS),
    ),
]
StoreAt = Annotated[
    str | None,
    Parameter(help="folder or URL for storing solved models, shared by all scenes; default OUT/store"),
]


@Parameter(name="*")
@dataclass(frozen=True)
class Work:
    """The folder of results, and the workers and the store of a computation."""

    out: Annotated[
        Path | None,
        Parameter(help="folder for the results; default out/SCENE; with several scenes, OUT/SCENE for each"),
    ] = None
    workers: Workers = None
    store: StoreAt = None
    figures: Annotated[
        tuple[Literal["svg", "pdf", "png"], ...],
        Parameter(
            help="also write each figure of the report as a file, in these formats",
            consume_multiple=True,
            show_default=False,
        ),
    ] = ()

    def folder(self, scene: Scene) -> Path:
        """Return the folder of the results of a scene."""
        return self.out or OUT / scene.name

    def scene_folders(self, scenes: Sequence[Scene], others: Sequence[Path] = ()) -> list[Path]:
        """Return the folders of the results of scenes, OUT/SCENE each where there are several.

        Raises WrongInput for scenes of the same name, or where one of these or `others` cannot be used.
        """
        names = [scene.name for scene in scenes]
        if len(set(names)) < len(names):
            raise WrongInput(f"SCENE: {', '.join(names)}: two have the same name; rename a file")
        several = [(self.out or OUT) / name for name in names]
        scene_folders = several if len(names) > 1 else [self.folder(scenes[0])]
        for folder in (*scene_folders, *others):
            folders.require_usable(folder)
        return scene_folders

    def joint_folder(self, names: Sequence[str]) -> Path:
        """Return the folder of the results that several scenes have in common."""
        return self.out or OUT / "_".join(names)

    @property
    def threads(self) -> int:
        """Number of workers."""
        return self.workers or cores()

    @contextmanager
    def options(self, folder: Path, console: Console) -> Iterator[RunOptions]:
        """Yield run options with a store and progress, while no other run writes into the folder of results.

        The store is in this folder unless another is named. Raises as `folders.locked` does.
        """
        with folders.locked(folder), files.figures_as(self.figures), progress.show_progress(console) as watch:
            yield RunOptions(self.threads, store_at(self.store, folder), watch)


def announce(report: Path, console: Console) -> None:
    """Print where a page is, and list it in `out/index.html`, if it is in there."""
    console.print(f"Report: {report}", soft_wrap=True)
    if OUT.resolve() in report.resolve().parents[1:3]:
        parts.write_index(OUT)


def print_warnings(scene: Scene, console: Console, *, of_contact: bool = True) -> None:
    """Print what is implausible in the contact of a scene, or in its ICs on lines."""
    found = plausibility.pair_warnings if of_contact else plausibility.warnings
    for text in found(scene):
        console.print(f"note: {text}", soft_wrap=True)


def maps_of(scene: Scene) -> dict[str, Any]:
    """Open the maps of C among the ICs of a scene, by name; raise as `open_map`."""
    return c_map.maps_of_scene(scene) if any(map(is_map, scene.contact.ics)) else {}


def store_at(location: str | None, folder: Path) -> Store:
    """Return the store at a location; without one, the store in a folder, less models of other code.

    Raises WrongInput for a location that no installed library can open, or where nothing can be stored.
    """
    if location is not None:
        try:
            system, path = fsspec.url_to_fs(location)
            if "file" not in system.protocol or not system.isdir(path):  # one that is read-only has models
                probe = f"{path}/probe.{uuid4().hex}"
                system.makedirs(path, exist_ok=True)
                system.pipe_file(probe, b"")
                system.rm(probe)
        except (ImportError, ValueError) as error:
            raise WrongInput(
                f"--store {location}: {error}: give a folder, or a URL of a kind that fsspec knows; for "
                "object stores install its library into .venv (s3fs, gcsfs, adlfs)"
            ) from error
        except Exception as error:  # each kind has its own
            raise WrongInput(
                f"--store {location}: cannot write there ({type(error).__name__}: {error}). Give a folder "
                "or a URL, and check its credentials (for S3: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY)"
            ) from error
        return Store(location)
    store = Store(folder / "store")
    store.remove_other_code()
    return store


DEFAULT_WORK = Work()
