"""Provenance of a stored model besides its inputs: this code and the libraries that it ran with."""

import ast
import hashlib
import platform
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path

LIBRARIES = ("gmsh", "numpy", "pyamg", "scikit-fem", "scipy")
PACKAGES = ("geometries", "approx", "femic")
Documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def versions() -> dict[str, str]:
    """Versions of Python, femic and the libraries that determine a result."""
    return {"python": platform.python_version()} | {name: version(name) for name in ("femic", *LIBRARIES)}


@cache
def code_digest() -> str:
    """Short digest of this code and its libraries: models of other code are not mistaken for its own."""
    root = Path(__file__).parents[2]
    return digest_of((root / package for package in PACKAGES), versions())


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
