"""Code that is imported when it is used: what checks a scene does not load what solves it."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from operator import attrgetter
from threading import RLock
from types import ModuleType
from typing import Any

ITS_PLACE = ("__class__", "__dict__", "__name__", "__path__", "__spec__")  # attributes that imports look at


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
    importer = _LazyImporter()
    sys.meta_path.insert(0, importer)
    try:
        yield
    finally:
        sys.meta_path.remove(importer)


class _LazyImporter(Loader):
    """Finds modules as all other finders do, and makes them such that they run later.

    Modules by the standard library's LazyLoader run as soon as they are imported again.
    """

    running = 0  # modules that run at the moment: what they import is not deferred

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the specification of a module, None where there is none."""
        if self.running:
            return None
        others = (finder for finder in sys.meta_path if finder is not self)
        spec = next(filter(None, (finder.find_spec(name, path, target) for finder in others)), None)
        if spec is not None and spec.loader is not None:
            spec.loader_state = {"loader": spec.loader, "lock": RLock(), "begun": False}
            spec.loader = self
        return spec

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Return the module, None for an ordinary one."""
        module: ModuleType | None = spec.loader_state["loader"].create_module(spec)
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Prepare a module to run."""
        assert module.__spec__ is not None
        module.__spec__.loader = module.__loader__ = module.__spec__.loader_state["loader"]
        module.__class__ = _LazyModule


class _LazyModule(ModuleType):
    """A module that runs when an attribute of it is first used, by one thread."""

    def __getattribute__(self, name: str) -> Any:
        get = super().__getattribute__
        if name in ITS_PLACE or (state := get("__spec__").loader_state) is None:
            return get(name)
        with state["lock"]:
            if not state["begun"]:
                state["begun"] = True
                _LazyImporter.running += 1
                try:
                    get("__spec__").loader.exec_module(self)
                except BaseException:
                    state["begun"] = False
                    raise
                finally:
                    _LazyImporter.running -= 1
                get("__spec__").loader_state = None
                object.__setattr__(self, "__class__", ModuleType)
        return object.__getattribute__(self, name)
