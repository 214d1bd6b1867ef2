"""How C is computed: the accuracy, the engine, and what is kept of it.

If a program has several threads, calls that compute wait for each other: Gmsh has one model per process and
crashes if two threads change it. Separate processes compute in parallel.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import wraps
from pathlib import Path
from threading import RLock
from typing import Any, ParamSpec, TypeVar

import tomlkit
from fsspec.core import url_to_fs

from femic.cache.store import Store
from femic.contact.specification import ContactSpecification
from femic.interface.arguments import check_fields
from femic.interface.bodies import Pair, checked, given, plain
from femic.reference.run_options import RunOptions, Watch, cores
from femic.scenes.engine import EngineTable
from femic.scenes.lines import LineAlongS, LineAlongX
from femic.scenes.load import build_scene, parse
from femic.scenes.scene import Scene
from geometries.errors import WrongInput
from geometries.patches import OffsetLine

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
Line = LineAlongX | LineAlongS | OffsetLine

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

    `tolerance` is the largest estimated error of C, relative to the largest value on the line. `engine` is
    "harmonic" (seconds) or "solid" (3D finite elements, minutes). Sections are clamped at a far arc of
    `far_radius` [mm]. If you give this radius, the arc is a fixed support of the bodies; by default femic
    places it far enough for a body without end, to the tolerance. `most_unknowns` limits the size of a model.
    If you give a `store` (folder or URL), solved models are kept there and not solved again. `report`, such
    as `print`, is called with a line of text for each step. Raises WrongInput.
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
        _ = self.table  # raises for values that no engine takes
        if self.workers < 1:
            raise WrongInput(f"workers = {self.workers!r}: at least 1")
        if self.store is None:
            return
        place = str(self.store)
        try:
            files, path = url_to_fs(place)
        except (ImportError, ValueError) as error:
            raise WrongInput(
                f"store = {place!r}: {error}: give a folder, or a URL that fsspec knows"
            ) from error
        if "file" in files.protocol and files.isfile(path):
            raise WrongInput(f"store = {place!r}: is a file: give a folder")

    @property
    def table(self) -> EngineTable:
        """The engine as a scene has it."""
        names = "tolerance", "far_radius", "most_unknowns"
        keys = given({"kind": self.engine} | {name: getattr(self, name) for name in names})
        return checked(EngineTable, keys, {("kind",): "engine"})

    @property
    def run(self) -> RunOptions:
        """The workers, the store, and the reports of a run."""
        watch = Watch(on_stage=self.report) if self.report else Watch()
        return RunOptions(self.workers, Store(self.store), watch)


DEFAULT = Options()


def make_scene(
    pair: Pair,
    options: Options,
    keys: Mapping[str, Any] | None = None,
    *,
    lines: Sequence[Line] = (),
    contact: ContactSpecification | None = None,
) -> Scene:
    """Return the scene of a pair with further keys; raise WrongInput for what does not fit together.

    `lines`, and a `contact` with a gap of its own, may be such that no scene file has them.
    """
    in_file = not any(isinstance(line, OffsetLine) for line in lines)
    of_lines = {"lines": tuple(lines)} if lines and in_file else {}
    file = parse(pair.keys | {"engine": options.table} | plain(keys or {}) | of_lines, Path(NAME))
    in_file = in_file and (contact is None or contact.extra_gap is None)
    text = tomlkit.dumps(file.model_dump(mode="json", exclude_unset=True)) if in_file else ""
    return build_scene(NAME, text, file, lines or None, contact)
