"""How C is computed: the accuracy, the engine, and what is kept of it.

Calls that compute wait for each other where a program has several threads: Gmsh has one model per process,
which the sections and solids of C are meshed in, and ends the process where two threads change it. Processes
compute side by side.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import wraps
from pathlib import Path
from threading import RLock
from typing import Any, ParamSpec, TypeVar

from fsspec.core import url_to_fs

from femic.cache.store import Store
from femic.interface.arguments import check_fields
from femic.interface.bodies import Pair, checked, given, plain
from femic.reference.run_options import RunOptions, Watch, cores
from femic.scenes.engine import EngineTable
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

LOCK = RLock()  # a report may call the function again


def in_turn(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Return a public function that one thread at a time runs."""

    @wraps(function)
    def call(*arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
        with LOCK:
            return function(*arguments, **named)

    return call


NAME = "pair"  # of scenes that Python describes, in messages


@dataclass(frozen=True)
class Options:
    """How C is computed.

    `tolerance` is the estimated error of C that is good enough, a share of the largest value on the line.
    `engine` is "harmonic", which takes seconds, or "solid", 3D finite elements, which takes minutes. Sections
    are clamped at a far arc of `far_radius` [mm]: a given one is a support of the bodies, which stays there
    and is part of the answer; by default it is as far away as a body without end needs, to the tolerance.
    No model has more than `most_unknowns`. Solved models are stored in the folder or at the URL `store`,
    where one is given, and not solved again. `report`, such as `print`, is called with a line of text about
    each step. Raises WrongInput.
    """

    tolerance: float = 0.01
    engine: str = "harmonic"
    far_radius: float | None = None
    most_unknowns: int = 1_000_000
    workers: int = field(default_factory=cores)
    store: str | Path | None = None
    report: Callable[[str], None] | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        checked(EngineTable, self.table, {("kind",): "engine"})
        if self.workers < 1:
            raise WrongInput(f"workers = {self.workers!r}: at least 1")
        if self.store is not None:
            _require_place(str(self.store))

    @property
    def table(self) -> dict[str, Any]:
        """The table [engine] of a scene file."""
        of_engine = {"tolerance": self.tolerance, "far_radius": self.far_radius}
        return given({"kind": self.engine, "most_unknowns": self.most_unknowns} | of_engine)

    @property
    def run(self) -> RunOptions:
        """The workers, the store, and the reports of a run."""
        watch = Watch(on_stage=self.report) if self.report else Watch()
        return RunOptions(self.workers, Store(self.store), watch)


def _require_place(store: str) -> None:
    """Raise WrongInput for a store that is a file, or of a kind of places that fsspec does not know."""
    try:
        files, path = url_to_fs(store)
    except (ImportError, ValueError) as error:
        raise WrongInput(f"store = {store!r}: {error}: give a folder, or a URL that fsspec knows") from error
    if "file" in files.protocol and files.isfile(path):
        raise WrongInput(f"store = {store!r}: is a file: give a folder")


DEFAULT = Options()


def scene_of(pair: Pair, options: Options, tables: Mapping[str, Any]) -> Scene:
    """Return the scene of a pair with further tables; raise WrongInput for what does not fit together."""
    return scene_from_table(plain(pair.tables | {"engine": options.table} | dict(tables)), NAME)
