"""Digests of the code that made a model or a result, and versions of the libraries that it ran with.

Kept models and written results of other code are not mistaken for those of this code.
"""

import ast
import hashlib
import platform
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).parents[2]
OF_MODELS = ("geometries", "approx", "femic/cache", "femic/reference")  # folders that models depend on
LIBRARIES = ("gmsh", "numpy", "pyamg", "scikit-fem", "scipy")  # that models depend on
PACKAGES = ("femic", "compare")  # with modules that make results
LIBRARIES_OF_RESULTS = ("xarray",)
SCENES = "femic.scenes.load"  # says what the text of a scene means: always counts
DRAWING = "compare/report/"  # which numbers do not depend on
Documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def versions() -> dict[str, str]:
    """Versions of Python, femic and the libraries that determine a result."""
    return {"python": platform.python_version()} | {name: version(name) for name in ("femic", *LIBRARIES)}


@cache
def code_digest() -> str:
    """Short digest of the code of models and its libraries."""
    return digest_of((ROOT / folder for folder in OF_MODELS), versions())


@cache
def results_digest(*modules: str) -> str:
    """Short digest of the code of modules, such as "compare.ics.compute": theirs, and what they import.

    Results written with another digest are not up to date. Modules that a result does not need may change.
    """
    sources = {name: ROOT / name for name in sorted(_needed((*modules, SCENES)))}
    return digest_of_files(sources, code_digest(), {name: version(name) for name in LIBRARIES_OF_RESULTS})


def digest_of(folders: Iterable[Path], *facts: object) -> str:
    """Short digest of facts and of the Python files in folders, as of `digest_of_files`."""
    files = {
        f"{folder.name}/{source.relative_to(folder).as_posix()}": source
        for folder in folders
        for source in sorted(folder.rglob("*.py"))
    }
    return digest_of_files(files, *facts)


def digest_of_files(files: Mapping[str, Path], *facts: object) -> str:
    """Short digest of facts and of Python files: their names and their code.

    Comments, docstrings and layout do not count.
    """
    digest = hashlib.sha256(repr(facts).encode())
    for name, source in files.items():
        digest.update(f"\n{name}\n".encode())
        digest.update(_meaning(source.read_text(encoding="utf-8")).encode())
    return digest.hexdigest()[:12]


def _meaning(code: str) -> str:
    """The syntax tree of code without docstrings, as text."""
    tree = ast.parse(code)
    for node in ast.walk(tree):
        if isinstance(node, Documented) and ast.get_docstring(node, clean=False) is not None:
            del node.body[0]
    return ast.dump(tree)


def _needed(modules: tuple[str, ...]) -> set[str]:
    """The files, relative to `ROOT`, that some modules consist of, with all that they import.

    Those of models are part of `code_digest`.
    """
    todo, found = list(modules), set[str]()
    while todo:
        for path in _files(todo.pop()):
            if path not in found and not path.startswith((DRAWING, *OF_MODELS)):
                found.add(path)
                todo += _imports((ROOT / path).read_text(encoding="utf-8"))
    return found


def _files(module: str) -> Iterator[str]:
    """The files of a module, those of the packages that it is in among them; none for modules of others."""
    parts = module.split(".")
    if parts[0] not in PACKAGES:
        return
    inner = ["/".join(parts[:n]) for n in range(1, len(parts) + 1)]
    for path in (*(f"{package}/__init__.py" for package in inner), f"{inner[-1]}.py"):
        if (ROOT / path).is_file():
            yield path


def _imports(code: str) -> Iterator[str]:
    """The modules that code imports, and names from them, which may be modules."""
    for node in ast.walk(_WithoutTypes().visit(ast.parse(code))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


class _WithoutTypes(ast.NodeTransformer):
    """Removes what is imported for type checkers only: no result depends on it."""

    def visit_If(self, node: ast.If) -> ast.AST | list[ast.stmt]:
        """The statement, or what runs instead of one that no interpreter enters."""
        of_types = isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        return node.orelse if of_types else node
