"""What a motion is: its keys, its numbers, how it is solved, and what one may want of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from femic.contact.pairs.quantities import Quantity
from femic.lazy import lazy_imports

with lazy_imports():
    import xarray as xr

# --- wanted numbers ---

KNOWN = 10.0  # times its estimate: a number that may vanish is known as a share of itself from there on


@dataclass(frozen=True)
class Scale:
    """What errors are shares of, in words. It never decides silently: F_x and F_x/limit are two wants.

    `vanishing`: the number may vanish. Its errors are then known where it exceeds `KNOWN` estimates only.
    """

    meaning: str
    vanishing: bool = False


@dataclass(frozen=True)
class Want:
    """A number of a contact by its name in files of contacts, and the scale of its errors."""

    name: str
    number: str
    scale: Scale


ITSELF = Scale("relative to the number itself")
ITSELF_WHERE_KNOWN = Scale(
    f"relative to the number itself, where it exceeds {KNOWN:g} times the estimated error of the reference",
    True,
)
LIMIT = Scale("relative to friction times load")
LOAD = Scale("relative to the load")
HALF_WIDTH = Scale("relative to b, the half-width of the patch")
WHOLE = Scale("absolute difference of fractions of the patch")
SATURATION = Scale("relative to the creepage at which the initial slope reaches friction times load")

COMMON = tuple(Want(name, name, ITSELF) for name in ("p_max", "a", "b", "angle", "area", "approach"))
WITH_FRICTION = (
    Want("F_y", "F_y", ITSELF_WHERE_KNOWN),
    Want("F_y/limit", "F_y", LIMIT),
    Want("sliding_share", "sliding_share", WHOLE),
)

# --- motions ---


@dataclass(frozen=True)
class Motion:
    """A motion: the keys of its specification, its numbers along `dimension`, and how it is solved.

    `keys` are the keys of the specification that not all motions have; values of `growing` ones must grow.
    `wants` are the numbers in which ICs are compared; none: they are not.

    With friction, `solve(pair, friction, name)` gives the dataset with a coefficient of friction and the ICs
    of a name, and `complete(dataset, specification)` that of all frictions and ICs. `solve_point(pair,
    problem, label)` gives the place and the numbers of one contact with the ICs of a problem. `pair` is a
    `femic.contact.pairs.pair_with_friction.PairWithFriction`. Contact without friction is solved as a whole:
    `femic.contact.motions.none`. `misfits(problem, sizing)` yields why a contact has no solution with this
    motion, as far as it is known before.
    """

    description: str
    title: str
    keys: tuple[str, ...]
    dimension: str
    quantities: Mapping[str, Quantity]
    wants: tuple[Want, ...] = ()
    growing: tuple[str, ...] = ()
    wheel_rolls: bool = False  # at one load; the rail sees the displacements of the wheel as it rolls
    solve: Callable[..., xr.Dataset] | None = None
    solve_point: Callable[..., tuple[float, Mapping[str, float]]] | None = None
    complete: Callable[[xr.Dataset, Any], xr.Dataset] = lambda dataset, _: dataset
    misfits: Callable[..., Iterable[str]] = lambda *_: ()

    @property
    def has_friction(self) -> bool:
        """Whether there is friction."""
        return "friction" in self.keys
