"""How C is computed: the accuracy, the engine, and what is kept of it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from femic.cache.store import Store
from femic.interface.bodies import checked, given
from femic.reference.run_options import RunOptions, Watch, cores
from femic.scenes.engine import EngineTable
from geometries.errors import WrongInput


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
    store: str | None = None
    report: Callable[[str], None] | None = None

    def __post_init__(self) -> None:
        checked(EngineTable, self.table)
        if self.workers < 1:
            raise WrongInput(f"workers = {self.workers!r}: at least 1")

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


DEFAULT = Options()
