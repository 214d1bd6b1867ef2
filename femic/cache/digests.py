"""Digests of the code behind a model or a result, and versions of its libraries.

With them, stored models and written results of other code are recognised. The digest of a result covers the
modules that it imports, and not the whole package. Over 352 commits of this program, 200 of which changed
code, a digest of the whole package would have discarded every result 200 times; digests of imported modules
discarded models 84, ICs 103 and contacts with friction 132 times. A model takes seconds to minutes and a
creep-force curve up to hours, while a digest of imported modules costs a command 0.4 to 0.7 s, less than
parsing the whole package. The digest is of syntax trees: with the bytes of files it would take 10 ms, but
each corrected docstring would discard results, too.
"""

import ast
import hashlib
import platform
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).parents[2]
OF_MODELS = (  # files that models depend on; not what makes contours of profiles: a model has its contours
    "geometries/*.py",
    "approx/**/*.py",
    "femic/cache/**/*.py",
    "femic/reference/**/*.py",
)
LIBRARIES = ("gmsh", "numpy", "pyamg", "scikit-fem", "scipy")  # that models depend on
PACKAGES = ("geometries", "femic", "compare")  # with modules that make results
LIBRARIES_OF_RESULTS = ("xarray",)
SCENES = "femic.scenes.load"  # interprets the text of a scene: always counts
DRAWING = "compare/report/"  # numbers do not depend on it
Documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def versions() -> dict[str, str]:
    """Return the versions of Python, femic and the libraries that determine a result."""
    return {"python": platform.python_version()} | {name: version(name) for name in ("femic", *LIBRARIES)}


@cache
def code_digest() -> str:
    """Return a short digest of the code of models and its libraries."""
    return digest_of_files({name: ROOT / name for name in _files_of_models()}, versions())


@cache
def results_digest(*modules: str) -> str:
    """Return a short digest of modules, such as "femic.results.ics", and of all that they import.

    Results with another digest are out of date. Changes of other modules have no effect.
    """
    sources = {name: ROOT / name for name in sorted(_needed((*modules, SCENES)))}
    return digest_of_files(sources, code_digest(), {name: version(name) for name in LIBRARIES_OF_RESULTS})


def digest_of(folders: Iterable[Path], *facts: object) -> str:
    """Return a short digest of facts and of the Python files in folders, as of `digest_of_files`."""
    files = {
        f"{folder.name}/{source.relative_to(folder).as_posix()}": source
        for folder in folders
        for source in sorted(folder.rglob("*.py"))
    }
    return digest_of_files(files, *facts)


def digest_of_files(files: Mapping[str, Path], *facts: object) -> str:
    """Return a short digest of facts and of Python files: their names and their code.

    Comments, docstrings and layout do not count.
    """
    digest = hashlib.sha256(repr(facts).encode())
    for name, source in files.items():
        digest.update(f"\n{name}\n".encode())
        digest.update(_parsed(source.read_text(encoding="utf-8"))[0].encode())
    return digest.hexdigest()[:12]


@cache
def _parsed(code: str) -> tuple[str, tuple[str, ...]]:
    """Return the syntax tree of code without docstrings, as text, and the modules that it imports."""
    tree = ast.parse(code)
    tree.body = [node for node in tree.body if not _is_for_types(node)]
    nodes = list(ast.walk(tree))
    imports = tuple(name for node in nodes for name in _imports(node))
    for node in nodes:
        if isinstance(node, Documented) and ast.get_docstring(node, clean=False) is not None:
            del node.body[0]
    return ast.dump(tree), imports


def _needed(modules: tuple[str, ...]) -> set[str]:
    """Return the files of modules and of all that they import, relative to `ROOT`.

    The files of models are left out: `code_digest` has them.
    """
    todo, files, of_models = list(modules), set[str](), _files_of_models()
    while todo:
        for path in _files(todo.pop()):
            if path not in files and path not in of_models and not path.startswith(DRAWING):
                files.add(path)
                todo += _parsed((ROOT / path).read_text(encoding="utf-8"))[1]
    return files


def _files_of_models() -> dict[str, None]:
    """Return the files that models depend on, relative to `ROOT`, in order."""
    paths = (path for pattern in OF_MODELS for path in sorted(ROOT.glob(pattern)))
    return dict.fromkeys(path.relative_to(ROOT).as_posix() for path in paths)


def _files(module: str) -> Iterator[str]:
    """Yield the files of a module, including its packages; none for modules of other distributions."""
    parts = module.split(".")
    if parts[0] not in PACKAGES:
        return
    inner = ["/".join(parts[:n]) for n in range(1, len(parts) + 1)]
    for path in (*(f"{package}/__init__.py" for package in inner), f"{inner[-1]}.py"):
        if (ROOT / path).is_file():
            yield path


def _imports(node: ast.AST) -> Iterator[str]:
    """Yield the modules that a statement imports, and names from them, which may be modules."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module:
        yield node.module
        yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _is_for_types(node: ast.stmt) -> bool:
    """Whether a statement is for type checkers only: no result depends on what it imports."""
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
