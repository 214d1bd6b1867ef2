"""Functions that are imported when they are called: what checks a scene does not load what solves it."""

from dataclasses import dataclass
from importlib import import_module
from operator import attrgetter
from typing import Any


@dataclass(frozen=True)
class Late:
    """A function or class by its place, such as "compare.ics.run:run_scene"."""

    place: str

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Import the function where this has not happened yet, and call it."""
        return self.resolved(*arguments, **named)

    @property
    def resolved(self) -> Any:
        """The function itself."""
        module, _, name = self.place.partition(":")
        return attrgetter(name)(import_module(module))
