"""What a stored result depends on besides its inputs: this code and the libraries it ran with."""

import hashlib
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path

LIBRARIES = ("gmsh", "numpy", "pyamg", "scikit-fem", "scipy")
PACKAGES = ("geometries", "approx", "femic")


def versions() -> dict[str, str]:
    """Versions of Python, femic and the libraries that determine a result."""
    return {"python": platform.python_version()} | {name: version(name) for name in ("femic", *LIBRARIES)}


@cache
def code_digest() -> str:
    """Short digest of the sources and versions: results of other code are not mistaken for ours."""
    digest = hashlib.sha256(repr(versions()).encode())
    root = Path(__file__).parent.parent
    for package in PACKAGES:
        for source in sorted((root / package).rglob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:12]
