"""Profiles of the package by their names: standard ones, exact, and worn ones, from files of the package.

To add a worn one, put its file (`.prr`, `.prw`) into `worn` and register it:

    WORN["name"] = Worn("rail", "title", "source", "name.prr")
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

from geometries.errors import WrongInput
from geometries.profiles.files import read_profile
from geometries.profiles.preparation import Prepared, prepare
from geometries.profiles.profile import Kind
from geometries.profiles.standards import STANDARDS, Standard

FOLDER = Path(__file__).parent / "worn"
LAW = "the law in docs/theory/wheel-on-rail.md"


@dataclass(frozen=True)
class Worn:
    """A worn profile: what it is, where it comes from, and its file in the package.

    Its origin is that of the standard profile that was worn.
    """

    kind: Kind
    title: str
    source: str
    file: str

    @property
    def path(self) -> Path:
        """Path of the file."""
        return FOLDER / self.file

    @cached_property
    def outline(self) -> Prepared:
        """The curve through the points of the file."""
        return prepare(read_profile(self.path))

    @property
    def origin(self) -> str:
        """A sentence about what the curve is."""
        return f"{self.title}; {self.source}; a spline through points 0.2 mm apart."


WORN: Mapping[str, Worn] = MappingProxyType(
    {
        "S1002-worn": Worn(
            "wheel", "wheel S1002, worn by rail 60E1", f"worn from S1002 by {LAW}", "S1002-worn.prw"
        ),
        "60E1-worn": Worn(
            "rail", "rail 60E1, worn by wheel S1002", f"worn from 60E1 by {LAW}", "60E1-worn.prr"
        ),
    }
)
NAMED: Mapping[str, Standard | Worn] = MappingProxyType({**STANDARDS, **WORN})


def named(name: str) -> Standard | Worn:
    """Return a profile of the package by its name in `NAMED`; raise WrongInput."""
    if name not in NAMED:
        raise WrongInput(f"profile {name!r}: not among those of the package, {', '.join(NAMED)}")
    return NAMED[name]
