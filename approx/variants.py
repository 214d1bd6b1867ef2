"""The registry of approximations by name, with their formulas and symbols; `approximate` computes them.

Each component of a variant has one of the `FORMS`: all the same, or some exchanged. "Bhat+sn:B" is B-hat with
sn of B, and with that ns which reciprocity makes of it: ns of B-bar. `forms_of` reads such names.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from approx.halfspace import HalfSpace, observers
from approx.orientation import Turn, both_turned, load_turned, observer_turned, turn_between
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import Patch, indices
from geometries.surfaces import Surface

Forms = Mapping[tuple[int, int], str]  # which form each component (displacement, traction) has

EXCHANGE = re.compile(r"([xsn]{2}):(\w+)")  # the component, and the form that it takes


class Symmetry(Enum):
    """Symmetries of the ICs of exact elasticity, which an approximation may lose."""

    RECIPROCITY = "IC(J, I) = IC(I, J)^T"
    SIGNS = "sx = xs, nx = -xn, ns = -sn at each point of a prismatic surface (Betti on a plane)"
    PARITY = "mirrored in x: the ICs at -x are those at x with the signs of xs, sx, xn, nx changed"
    MIRROR = "mirrored in s: the mirrored surface and load have the mirrored ICs"


ALL = frozenset(Symmetry)
MIRRORS = frozenset({Symmetry.PARITY, Symmetry.MIRROR})


@dataclass(frozen=True, eq=False)
class Ingredients:
    """Ingredients of approximations: ICs of half-spaces at the observers, and turns of the directions."""

    half_space: HalfSpace
    surface: Surface
    patch: Patch
    x: Array
    s: Array

    @cached_property
    def a(self) -> Array:
        """A [mm/MPa], shape (3, 3, ...)."""
        return self.half_space.ics(self.patch, self.x, self.s - self.patch.s)

    @cached_property
    def a_prime(self) -> Array:
        """A' by the effective properties [mm/MPa], shape (3, 3, ...)."""
        return self.half_space.effective_ics(self.patch, self.x, self.s - self.patch.s)

    @cached_property
    def turn(self) -> Turn:
        """T from load to observer."""
        return turn_between(self.surface, (self.x, self.s), self.patch.s)


FORMS: Mapping[str, Callable[[Ingredients], Array]] = MappingProxyType(
    {
        "A": lambda of: of.a,
        "B": lambda of: load_turned(of.a, of.turn),
        "Bbar": lambda of: observer_turned(of.a, of.turn),
        "Bhat": lambda of: both_turned(of.a, of.turn),
        "Bhat_prime": lambda of: both_turned(of.a_prime, of.turn),
        "Bhat_prime_or_A": lambda of: both_turned(of.a_prime, of.turn) if of.half_space.effective else of.a,
    }
)
OF_EFFECTIVE = ("Bhat_prime", "Bhat_prime_or_A")  # forms by effective properties, where there are some
RECIPROCAL: Mapping[str, str] = MappingProxyType({"B": "Bbar", "Bbar": "B"})  # others are so themselves


@dataclass(frozen=True)
class Variant:
    """An approximation; `keeps` are the symmetries that it keeps, `exchanged` what is not its own form."""

    symbol: str
    meaning: str
    keeps: frozenset[Symmetry]
    exchanged: str = ""


VARIANTS: Mapping[str, Variant] = MappingProxyType(
    {
        "A": Variant("A", "flat half-space", ALL),
        "B": Variant("B", "load turned", MIRRORS),
        "Bbar": Variant("B̄", "displacement turned", MIRRORS),
        "Bhat": Variant("B̂", "half of the turn each", ALL),
        "Bhat_prime": Variant("B̂′", "B̂ with effective properties", ALL),
        "mix": Variant("mix", "B̂, but sn from B, xn from B̂′ or A", ALL, "Bhat+sn:B+xn:Bhat_prime_or_A"),
    }
)


def forms_of(variant: str) -> Forms:
    """The form of each component of a variant, or of one with exchanges: "Bhat+sn:B+xn:A", "mix+nn:A".

    An exchange of a component is one of its transpose, too, by reciprocity. Raises WrongInput for others.
    """
    spelled = [VARIANTS[part].exchanged or part if part in VARIANTS else part for part in variant.split("+")]
    base, *exchanges = "+".join(spelled).split("+")
    forms = {(i, j): base for i in range(3) for j in range(3)}
    for exchange in exchanges:
        if not (found := EXCHANGE.fullmatch(exchange)):
            raise _unknown(variant)
        (i, j), form = indices(found[1]), found[2]
        forms[j, i] = RECIPROCAL.get(form, form)
        forms[i, j] = form
    if not FORMS.keys() >= set(forms.values()):
        raise _unknown(variant)
    return forms


def _unknown(variant: str) -> WrongInput:
    known = ", ".join(VARIANTS)
    return WrongInput(f"variant = {variant!r}: one of {known}, or one with exchanges such as Bhat+sn:B")


def exchanged_symbol(variant: str) -> str:
    """The symbol of a variant, such as B̂ or B̂ (sn B, xn A)."""
    symbols = {name: one.symbol for name, one in VARIANTS.items()} | {"Bhat_prime_or_A": "B̂′ or A"}
    base, *exchanges = variant.split("+")
    parts = [exchange.split(":") for exchange in exchanges]
    listed = ", ".join(f"{component} {symbols[form]}" for component, form in parts)
    return f"{symbols[base]} ({listed})" if listed else symbols[base]


def needed(variants: Iterable[str]) -> list[str]:
    """The forms that variants consist of."""
    return list(dict.fromkeys(form for variant in variants for form in forms_of(variant).values()))


def assembled(variant: str, by_form: Mapping[str, Array]) -> Array:
    """The ICs of a variant, (3, 3, ...), from those of its forms."""
    forms = forms_of(variant)
    if len(set(forms.values())) == 1:
        return by_form[forms[0, 0]]
    ics = np.empty_like(by_form[forms[0, 0]])
    for component, form in forms.items():
        ics[component] = by_form[form][component]
    return ics


def approximate(
    variant: str,
    half_space: HalfSpace,
    surface: Surface,
    patch: Patch,
    points: tuple[ArrayLike, ArrayLike],
) -> Array:
    """ICs per unit pressure [mm/MPa] at surface points (x, s) [mm], shape (3, 3, *broadcast(x, s).shape).

    Index order: displacement, traction; local directions x, s, n of observer and load. x counts from the
    load, s from the contact centre. `half_space` is one body or both; `surface` says how the directions turn,
    for both bodies that of the lower one. Errors are those of the half-space, 1e-14 of the largest component;
    the symmetries that a variant keeps hold to rounding. `variant` is one of `VARIANTS`, or one with
    exchanges (`forms_of`). Raises WrongInput for an unknown one, for points that are not finite, and for
    B-hat-prime without effective properties. Source: [BVSV] sections 3 and 4; docs/theory/ics.md.
    """
    return approximations([variant], half_space, surface, patch, points)[variant]


def approximations(
    variants: Sequence[str],
    half_space: HalfSpace,
    surface: Surface,
    patch: Patch,
    points: tuple[ArrayLike, ArrayLike],
) -> dict[str, Array]:
    """ICs by several variants, each as of `approximate`; what they have in common is computed once."""
    forms = needed(variants)
    ingredients = Ingredients(half_space, surface, patch, *observers(*points))
    by_form = {form: FORMS[form](ingredients) for form in forms}
    return {variant: assembled(variant, by_form) for variant in variants}
