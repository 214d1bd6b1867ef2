"""The digest of the code that written results depend on: models, and the modules that make results."""

import ast
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path

from femic.work.provenance import code_digest, digest_of_files

LIBRARIES = ("xarray",)
ROOT = Path(__file__).parents[2]
FOLDERS = ("contact", "compare")  # those of models are part of `code_digest`
SCENES = "compare.scenes.load"  # says what the text of a scene means: always counts
DRAWING = "compare/pages/"  # which numbers do not depend on


@cache
def results_digest(*modules: str) -> str:
    """Short digest of the code of modules, such as "compare.results.compute": theirs, and what they import.

    Results written with another digest are not up to date. Modules that a result does not need may change.
    """
    sources = {name: ROOT / name for name in sorted(_needed((*modules, SCENES)))}
    return digest_of_files(sources, code_digest(), {name: version(name) for name in LIBRARIES})


def _needed(modules: tuple[str, ...]) -> set[str]:
    """The files of `FOLDERS`, relative to `ROOT`, that some modules consist of, with all that they import."""
    todo, found = list(modules), set[str]()
    while todo:
        for path in _files(todo.pop()):
            if path not in found and not path.startswith(DRAWING):
                found.add(path)
                todo += _imports((ROOT / path).read_text(encoding="utf-8"))
    return found


def _files(module: str) -> Iterator[str]:
    """The files of a module, those of the packages that it is in among them; none for modules of others."""
    parts = module.split(".")
    if parts[0] not in FOLDERS:
        return
    inner = ["/".join(parts[:n]) for n in range(1, len(parts) + 1)]
    for path in (*(f"{package}/__init__.py" for package in inner), f"{inner[-1]}.py"):
        if (ROOT / path).is_file():
            yield path


def _imports(code: str) -> Iterator[str]:
    """The modules that code imports, and names from them, which may be modules."""
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
