"""The registry of approximations: one name, one formula, one symbol; and the one function to call."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from numpy.typing import ArrayLike

from approx.halfspace import HalfSpace, observers
from approx.orientation import Turn, both_turned, load_turned, observer_turned, turn_between
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import N, Patch, S, X
from geometries.surfaces import Surface

COUPLING = ((X, N), (N, X))  # index of xn and nx


class Symmetry(Enum):
    """What the ICs of exact elasticity keep, and an approximation may lose."""

    RECIPROCITY = "IC(J, I) = IC(I, J)^T"
    SIGNS = "sx = xs, nx = -xn, ns = -sn at each point of a prismatic surface (Betti on a plane)"
    PARITY = "mirrored in x: the ICs at -x are those at x with the signs of xs, sx, xn, nx changed"
    MIRROR = "mirrored in s: the mirrored surface and load have the mirrored ICs"


ALL = frozenset(Symmetry)
MIRRORS = frozenset({Symmetry.PARITY, Symmetry.MIRROR})


@dataclass(frozen=True, eq=False)
class Ingredients:
    """What approximations are made of: half-spaces at the observers, and turns of the directions."""

    half_space: HalfSpace
    surface: Surface
    patch: Patch
    x: Array
    s: Array

    @property
    def a(self) -> Array:
        """A, (3, 3, ...)."""
        return self.half_space.ics(self.patch, self.x, self.s - self.patch.s)

    @property
    def a_prime(self) -> Array:
        """A', of the effective properties."""
        return self.half_space.effective_ics(self.patch, self.x, self.s - self.patch.s)

    @property
    def turn(self) -> Turn:
        """T from load to observer."""
        return turn_between(self.surface, (self.x, self.s), self.patch.s)


@dataclass(frozen=True)
class Variant:
    """An approximation."""

    symbol: str
    meaning: str
    formula: Callable[[Ingredients], Array]
    keeps: frozenset[Symmetry]


def _mixed(of: Ingredients) -> Array:
    """B-hat; sn from B, ns from B-bar, its reciprocal; xn and nx from B-hat-prime, without it from A."""
    a, turn = of.a, of.turn
    out = both_turned(a, turn)
    coupling = both_turned(of.a_prime, turn) if of.half_space.effective else a
    out[S, N] = load_turned(a, turn)[S, N]
    out[N, S] = observer_turned(a, turn)[N, S]
    out[COUPLING] = coupling[COUPLING]
    return out


VARIANTS: Mapping[str, Variant] = MappingProxyType(
    {
        "A": Variant("A", "flat half-space", lambda of: of.a, ALL),
        "B": Variant("B", "load turned", lambda of: load_turned(of.a, of.turn), MIRRORS),
        "Bbar": Variant("B̄", "displacement turned", lambda of: observer_turned(of.a, of.turn), MIRRORS),
        "Bhat": Variant("B̂", "half of the turn each", lambda of: both_turned(of.a, of.turn), ALL),
        "Bhat_prime": Variant(
            "B̂′", "B̂ with effective properties", lambda of: both_turned(of.a_prime, of.turn), ALL
        ),
        "mix": Variant("mix", "B̂, but sn from B, xn from B̂′ or A", _mixed, ALL),
    }
)


def approximate(
    variant: str,
    half_space: HalfSpace,
    surface: Surface,
    patch: Patch,
    points: tuple[ArrayLike, ArrayLike],
) -> Array:
    """ICs per unit pressure [mm/MPa] at surface points (x, s) [mm], shape (3, 3, *broadcast(x, s).shape).

    Index order: displacement, traction; local directions x, s, n of observer and load. x counts from the
    load, s from the contact centre. `half_space` is one body or both; `surface` says how the directions
    turn, for both bodies that of the lower one. Errors: those of the half-space, 1e-14 of the largest
    component; what a variant keeps, it keeps to rounding. Raises WrongInput for an unknown variant, for
    points that are not finite, and for B-hat-prime without effective properties. Source: [BVSV]
    sections 3 and 4, design section 3.
    """
    if variant not in VARIANTS:
        raise WrongInput(f"variant = {variant!r}: one of {', '.join(VARIANTS)}")
    x, s = observers(*points)
    return VARIANTS[variant].formula(Ingredients(half_space, surface, patch, x, s))
