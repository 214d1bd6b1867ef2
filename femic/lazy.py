"""Code that is imported when it is used: what checks a scene does not load what solves it."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from threading import get_ident, local
from types import ModuleType
from typing import Any

_LOCAL = local()  # `at_once`: whether this thread imports nothing lazily for now


@contextmanager
def _at_once(at_once: bool = True) -> Iterator[None]:
    """Let this thread import modules at once, or not, within this context."""
    before = getattr(_LOCAL, "at_once", False)
    _LOCAL.at_once = at_once
    try:
        yield
    finally:
        _LOCAL.at_once = before


@contextmanager
def lazy_imports() -> Iterator[None]:
    """Let modules that are imported within this context be stand-ins, which import them when they are used.

    Packages of this program, which have no code, are imported at once. A stand-in is known only to who
    imported it: in `sys.modules` are real ones, so that threads may use them for the first time together.
    """
    importer = _LazyImporter()
    sys.meta_path.insert(0, importer)
    try:
        with _at_once(False):  # also in a module that is imported at once
            yield
    finally:
        sys.meta_path.remove(importer)
        for name, module in list(sys.modules.items()):
            if isinstance(module, _StandIn):
                del sys.modules[name]
                parent, _, child = name.rpartition(".")
                if parent in sys.modules:
                    vars(sys.modules[parent]).pop(child, None)


class _StandIn(ModuleType):
    """Imports the module of its name when an attribute is asked for."""

    def __getattr__(self, name: str) -> Any:
        if name in {"__path__", "__file__", "__cached__"}:  # imports ask for them
            raise AttributeError(name)
        if sys.modules.get(self.__name__) is self:  # used while this or another thread imports lazily
            del sys.modules[self.__name__]
        with _at_once():
            return getattr(import_module(self.__name__), name)


class _LazyImporter(Loader):
    """Finds modules as all other finders do, and makes stand-ins of them for one thread."""

    def __init__(self) -> None:
        self.thread = get_ident()

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the specification of a module, None where there is none."""
        if getattr(_LOCAL, "at_once", False) or get_ident() != self.thread:
            return None
        others = (finder for finder in sys.meta_path if finder is not self)
        with _at_once():  # other finders may import, too
            spec = next(filter(None, (finder.find_spec(name, path, target) for finder in others)), None)
        own = ("femic", "compare")
        is_package = spec is not None and spec.submodule_search_locations is not None
        if spec is not None and not (is_package and name.partition(".")[0] in own):
            spec.loader = self
        return spec

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Return a stand-in."""
        return _StandIn(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Run nothing."""
