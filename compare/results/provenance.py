"""The digest of all code that written results depend on: that of models, `contact` and `compare`."""

from functools import cache
from importlib.metadata import version
from pathlib import Path

from femic.work.provenance import code_digest, digest_of

LIBRARIES = ("xarray",)
FOLDERS = tuple(Path(__file__).parents[2] / name for name in ("contact", "compare"))


@cache
def results_digest() -> str:
    """Short digest of the code; results written with another digest are not up to date."""
    return digest_of(FOLDERS, code_digest(), {name: version(name) for name in LIBRARIES})
