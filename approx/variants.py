"""The registry of approximations by name, with their symbols and symmetries; `approximate` computes them.

Each component of a variant has one of the `FORMS`: all the same, or some exchanged. "Bhat+sn:B" is B-hat with
sn of B, and with the ns that reciprocity makes of it: ns of B-bar. `forms_of` reads such names.

To add an approximation, add its form, unless it consists of known ones, and the variant to the mappings:

    FORMS["Btilde"] = Form(Shares(observer=2 / 3, load=1 / 3))
    VARIANTS["Btilde"] = Variant("B̃", "two thirds of the rotation at the observer", MIRRORS)

Scene files, IC matrices and contact then know it; names consist of letters, digits and underscores. A variant
without `composition` consists of the form of its own name.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from approx.forms import FORMS, Form, Ingredients
from approx.halfspace import HalfSpace, observers
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import Patch, indices
from geometries.surfaces import Surface

Forms = Mapping[tuple[int, int], Form]  # the form of each component (displacement, traction)

EXCHANGE = re.compile(r"([xsn]{2}):(\w+)")  # the component, and the form that it takes


class Symmetry(Enum):
    """Symmetries of the ICs of exact elasticity, which an approximation may lose."""

    RECIPROCITY = "IC(J, I) = IC(I, J)^T"
    SIGNS = "sx = xs, nx = -xn, ns = -sn at each point of a prismatic surface (Betti on a plane)"
    PARITY = "mirrored in x: the ICs at -x are those at x with the signs of xs, sx, xn, nx changed"
    MIRROR = "mirrored in s: the mirrored surface and load have the mirrored ICs"


ALL = frozenset(Symmetry)
MIRRORS = frozenset({Symmetry.PARITY, Symmetry.MIRROR})


@dataclass(frozen=True)
class Variant:
    """An approximation: its symbol and meaning, the symmetries that it keeps, and what it is composed of."""

    symbol: str
    meaning: str
    keeps: frozenset[Symmetry]
    composition: str = ""


VARIANTS: dict[str, Variant] = {
    "A": Variant("A", "flat half-space", ALL),
    "B": Variant("B", "load rotated", MIRRORS),
    "Bbar": Variant("B̄", "displacement rotated", MIRRORS),
    "Bhat": Variant("B̂", "load and displacement rotated by half each", ALL),
    "Bhat_prime": Variant("B̂′", "B̂ with effective properties", ALL),
    "mix": Variant("mix", "B̂, but sn from B, xn from B̂′ or A", ALL, "Bhat+sn:B+xn:Bhat_prime_or_A"),
}


def forms_of(variant: str) -> Forms:
    """Return the form of each component of a variant, or of one with exchanges: "Bhat+sn:B+xn:A", "mix+nn:A".

    An exchange of a component is one of its transpose, too, by reciprocity. Raises WrongInput for others.
    """
    spelled = [
        VARIANTS[part].composition or part if part in VARIANTS else part for part in variant.split("+")
    ]
    base, *exchanges = "+".join(spelled).split("+")
    forms = {(i, j): _form(base, variant) for i in range(3) for j in range(3)}
    for exchange in exchanges:
        if not (match := EXCHANGE.fullmatch(exchange)):
            raise _unknown(variant)
        (i, j), form = indices(match[1]), _form(match[2], variant)
        forms[j, i] = form.reciprocal
        forms[i, j] = form
    return forms


def _form(name: str, variant: str) -> Form:
    """The form of this name, which is part of the name of a variant."""
    if name not in FORMS:
        raise _unknown(variant)
    return FORMS[name]


def _unknown(variant: str) -> WrongInput:
    known = ", ".join(VARIANTS)
    return WrongInput(f"variant = {variant!r}: one of {known}, or one with exchanges such as Bhat+sn:B")


def exchanged_symbol(variant: str) -> str:
    """The symbol of a variant, such as B̂ or B̂ (sn B, xn A)."""
    symbols = {name: known.symbol for name, known in VARIANTS.items()} | {"Bhat_prime_or_A": "B̂′ or A"}
    base, *exchanges = variant.split("+")
    parts = [exchange.split(":") for exchange in exchanges]
    listed = ", ".join(f"{component} {symbols.get(form, form)}" for component, form in parts)
    symbol = symbols.get(base, base)
    return f"{symbol} ({listed})" if listed else symbol


def needed_forms(variants: Iterable[str]) -> list[Form]:
    """The forms that variants consist of."""
    return list(dict.fromkeys(form for variant in variants for form in forms_of(variant).values()))


def needs_effective(*variants: str) -> bool:
    """Whether one of the variants cannot be computed without effective properties."""
    return any(form.effective and form.fallback is None for form in needed_forms(variants))


def assemble(variants: Iterable[str], by_form: Mapping[Form, Array]) -> dict[str, Array]:
    """The ICs of variants, (3, 3, ...) each, from the ICs of their forms."""
    return {variant: _assemble(forms_of(variant), by_form) for variant in variants}


def _assemble(forms: Forms, by_form: Mapping[Form, Array]) -> Array:
    """ICs (3, 3, ...) whose components have these forms."""
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
    load, s from the contact centre. `half_space` is one body or both; `surface` says how the directions
    rotate, for both bodies it is the surface of the lower one. Errors are below 1e-14 of the largest
    component; the symmetries that a variant keeps hold to rounding. `variant` is one of `VARIANTS`, or one
    with exchanges (`forms_of`). Raises WrongInput for an unknown one, for points that are not finite, and for
    B-hat-prime without effective properties. Source: [BVSV] sections 3 and 4; docs/theory/ics.md.
    """
    forms = needed_forms([variant])
    by_form = Ingredients(half_space, surface, patch, *observers(*points)).by_form(forms)
    return assemble([variant], by_form)[variant]
