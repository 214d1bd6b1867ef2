"""Code that is imported when it is used: what checks a scene does not load what solves it."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import LazyLoader
from operator import attrgetter
from types import ModuleType
from typing import Any


@dataclass(frozen=True)
class Late:
    """A function or class by its place, such as "compare.pages.ics_results:run_scene", for registries."""

    place: str

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Import the function where this has not happened yet, and call it."""
        return self.resolved(*arguments, **named)

    @property
    def resolved(self) -> Any:
        """The function itself."""
        module, _, name = self.place.partition(":")
        return attrgetter(name)(import_module(module))


@contextmanager
def lazy_imports() -> Iterator[None]:
    """Defer what is imported within this context: a module runs when an attribute of it is first used."""
    finder = _LazyFinder()
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)


class _LazyFinder:
    """Finds modules as all other finders do, and defers that they run."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the specification of a module, None where there is none."""
        others = (finder for finder in sys.meta_path if finder is not self)
        spec = next(filter(None, (finder.find_spec(name, path, target) for finder in others)), None)
        if spec is not None and spec.loader is not None:
            spec.loader = LazyLoader(spec.loader)
        return spec
