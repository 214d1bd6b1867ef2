"""Code that is imported when it is used: what checks a scene does not load what solves it."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import LazyLoader, _LazyModule  # type: ignore[attr-defined]
from operator import attrgetter
from types import ModuleType
from typing import Any


@dataclass(frozen=True)
class Late:
    """A function or class by its place, such as "compare.pages.ics:run_scene", for registries."""

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
            spec.loader = _DeferringLoader(spec.loader)
        return spec


class _DeferringLoader(LazyLoader):
    """Makes deferred modules."""

    def exec_module(self, module: ModuleType) -> None:
        """Make the module run later."""
        super().exec_module(module)
        module.__class__ = Deferred


class Deferred(_LazyModule):  # type: ignore[misc]
    """A module that two modules may defer; what it imports itself when it runs is not deferred."""

    def __getattribute__(self, name: str) -> Any:
        if name == "__spec__":  # asked for by the second import
            return object.__getattribute__(self, name)
        finders = list(sys.meta_path)
        sys.meta_path[:] = [finder for finder in finders if not isinstance(finder, _LazyFinder)]
        try:
            return super().__getattribute__(name)
        finally:
            sys.meta_path[:] = finders
