"""What a written result depends on besides its scene: the code of models, and of what is made of them."""

from functools import cache
from importlib.metadata import version
from pathlib import Path

from femic.work.provenance import code_digest, digest_of

LIBRARIES = ("xarray",)
HERE = Path(__file__).parents[1]


@cache
def results_digest() -> str:
    """Short digest: results that an older `compare` made of the same models are not taken for up to date."""
    return digest_of([HERE], code_digest(), {name: version(name) for name in LIBRARIES})
