"""Digests of the code behind a model or a result, and versions of its libraries.

With them, stored models and written results of other code are recognised. A model depends on the folders of
`MODEL_FOLDERS`, a result on all that computes, and a study or a page on folders of `compare`, too. Comments,
docstrings and blank lines do not count: a corrected sentence discards nothing.
"""

import hashlib
import platform
import re
from collections.abc import Iterable
from functools import cache
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).parents[2]
MODEL_FOLDERS = ("geometries/*.py", "approx", "femic/cache", "femic/reference")  # a model has its contours
RESULT_FOLDERS = ("geometries", "approx", "femic")
ADAPTERS = ("femic/cli/", "femic/interface/")  # hand over what others compute
STUDY_FOLDERS = ("compare/studies", "compare/campaigns", "compare/validation")
PAGE_FOLDERS = ("compare",)
LIBRARIES = ("gmsh", "numpy", "pyamg", "scikit-fem", "scipy")  # that models depend on
LIBRARIES_OF_RESULTS = ("xarray",)
TOKEN = re.compile(
    r'''(?P<block>[rR]?"""(?:\\.|(?!""").)*"""|[rR]?\'\'\'(?:\\.|(?!\'\'\').)*\'\'\')'''
    r"""|(?P<text>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')"""
    r"|(?P<comment>[ \t]*#[^\n]*)|(?P<opening>[(\[{])|(?P<closing>[)\]}])",
    re.DOTALL,
)


def versions() -> dict[str, str]:
    """Return the versions of Python, femic and the libraries that determine a result."""
    return {"python": platform.python_version()} | {name: version(name) for name in ("femic", *LIBRARIES)}


@cache
def code_digest() -> str:
    """Return a short digest of the code of models and its libraries."""
    return folders_digest(MODEL_FOLDERS, versions())


@cache
def results_digest(*folders: str) -> str:
    """Return a short digest of all code that computes results, and of folders such as `STUDY_FOLDERS`.

    Results with another digest are out of date.
    """
    return folders_digest((*RESULT_FOLDERS, *folders), versions(), *map(version, LIBRARIES_OF_RESULTS))


def folders_digest(folders: Iterable[str], *facts: object) -> str:
    """Return a short digest of facts and of the Python files in folders of `ROOT`, or of a pattern."""
    digest = hashlib.sha256(repr(facts).encode())
    for folder in folders:
        for source in sorted(ROOT.glob(folder) if "*" in folder else (ROOT / folder).rglob("*.py")):
            name = source.relative_to(ROOT).as_posix()
            if not name.startswith(ADAPTERS):
                digest.update(f"\n{name}\n{_code(source.read_text(encoding='utf-8'))}".encode())
    return digest.hexdigest()[:12]


@cache
def _code(text: str) -> str:
    """Return the code of a file, without comments, docstrings and blank lines."""
    parts, last, depth = list[str](), 0, 0
    for token in TOKEN.finditer(text):
        kind, start = token.lastgroup, token.start()
        depth += (kind == "opening") - (kind == "closing")
        end = text.rfind("\n", 0, start)  # of the line before
        alone = not text[end + 1 : start].strip() and text[max(end - 1, 0)] != "\\"
        if kind == "comment" or (kind == "block" and alone and depth == 0):
            parts.append(text[last:start])
            last = token.end()
    lines = "".join([*parts, text[last:]]).splitlines()
    return "\n".join(line.rstrip() for line in lines if line.strip())
