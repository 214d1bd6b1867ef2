"""Types of the keys of input files, with their limits: lengths, amounts, lists, names of registries.

Pydantic checks values by them; they serve dataclasses and tables alike.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field, Strict

LEAST_LENGTH, LARGEST_LENGTH = 1e-12, 1e12  # mm
LARGEST = 1e15  # of moduli [MPa] and forces [N]
DISTINCT_DIGITS = 12  # significant digits in which loads and approaches have to differ


def _whole(value: Any) -> Any:
    """Return a whole number as an integer: multiples in campaigns are floats."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def each_once(names: tuple[object, ...]) -> tuple[object, ...]:
    """Return the names; raise ValueError where one is repeated."""
    repeated = sorted({str(name) for name in names if names.count(name) > 1})
    if repeated:
        raise ValueError(f"{', '.join(repeated)} given twice: name each once")
    return names


def each_distinct(values: tuple[float, ...]) -> tuple[float, ...]:
    """Return the numbers; raise ValueError where two of them hardly differ."""
    each_once(tuple(f"{value:.{DISTINCT_DIGITS}g}" for value in values))
    return values


@dataclass(frozen=True)
class NameOf:
    """A check that a name is known; each check calls `names`, so names may be registered later."""

    names: Callable[[], Iterable[str]]

    def __call__(self, name: str) -> str:
        """Return the name; raise ValueError for an unknown one."""
        names = tuple(self.names())
        if name not in names:
            *others, last = map(repr, names)
            raise ValueError(f"Input should be {' or '.join(filter(None, [', '.join(others), last]))}")
        return name


Entry = TypeVar("Entry")
Several = Annotated[tuple[Entry, ...], Strict(False)]  # lists in TOML
TwoOf = Annotated[tuple[Entry, Entry], Strict(False)]
Whole = Annotated[int, BeforeValidator(_whole)]
Length = Annotated[float, Field(ge=LEAST_LENGTH, le=LARGEST_LENGTH)]  # mm
Place = Annotated[float, Field(ge=-LARGEST_LENGTH, le=LARGEST_LENGTH)]  # mm
Amount = Annotated[float, Field(ge=1 / LARGEST, le=LARGEST)]  # of a modulus or a force
Signed = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]  # likewise
Finite = Annotated[float, Field(allow_inf_nan=False)]
EachOnce = AfterValidator(each_once)
EachDistinct = AfterValidator(each_distinct)
