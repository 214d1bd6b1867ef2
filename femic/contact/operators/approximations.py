"""A and the B family as operators: convolutions in x and s between factors of the inclinations.

On prismatic bodies the turn alpha between two elements is the difference of their inclinations: with
constant matrices P it is R_x(alpha) = P_1 + P_c cos(alpha) + P_s sin(alpha). So an approximation is a sum of
kernels of the lag times functions of alpha or, where both elements are turned by half and one direction is x,
of alpha/2; and functions of a difference are sums of products. Source: [BVSV] sections 3 and 4;
docs/theory/contact.md.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from types import MappingProxyType

import numpy as np

from approx.halfspace import HalfSpace
from approx.pair import Pair
from approx.variants import OF_EFFECTIVE, Forms, forms_of
from femic.contact.operators.convolution import Convolution, Place
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.patches import N, Patch, S, X, mirror_signs

Wave = tuple[str, float]  # "1", "cos" or "sin", and the share of alpha that is its argument
Waves = dict[Wave, Array]  # coefficients of these functions [mm/MPa], (3, 3, lags along x, along s)

ONE, COS, SIN, COS_HALF, SIN_HALF = ("1", 1.0), ("cos", 1.0), ("sin", 1.0), ("cos", 0.5), ("sin", 0.5)
P_1, P_C = np.diag([1.0, 0.0, 0.0]), np.diag([0.0, 1.0, 1.0])
P_S = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
FUNCTIONS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"1": np.ones_like, "cos": np.cos, "sin": np.sin}
)
DIFFERENCES: Mapping[str, tuple[tuple[str, str, float], ...]] = MappingProxyType(
    {  # functions of delta_I - delta_J: those of delta_I and of delta_J, and the sign of their product
        "1": (("1", "1", 1.0),),
        "cos": (("cos", "cos", 1.0), ("sin", "sin", 1.0)),
        "sin": (("sin", "cos", 1.0), ("cos", "sin", -1.0)),
    }
)


def turned(
    variant: str,
    pair: Pair,
    grid: Grid,
    directions: tuple[int, ...] = (X, S, N),
    *,
    upper_offset: float = 0.0,
) -> Convolution:
    """The operator of an approximation of the combined ICs of two bodies.

    The grid lies on the lower contour; arc lengths [mm] of the upper one are `upper_offset` larger where both
    meet, so that each body turns with its own inclinations.

    Both bodies count as prismatic: with theta the angle between two elements about the axle, the curvature of
    a wheel along x changes nn by a share of less than theta ((1 - 2 nu) / (2 - 2 nu) + |alpha| + theta), nu
    that of the wheel, and xn and nx by theta / 2 times xx and nn. Raises WrongInput for an unknown variant,
    and for B-hat-prime without effective properties. Source: as `approx.pair.Pair`.
    """
    factors: dict[str, Array] = {}
    kernels: dict[tuple[Place, Place], Array] = {}
    for number, part in enumerate(_parts(variant, pair, grid, upper_offset)):
        for (function, share), coefficients in part.waves.items():
            for of_observer, of_load, sign in DIFFERENCES[function]:
                observer, load = (f"{name}({share:g} delta_{number})" for name in (of_observer, of_load))
                factors[observer] = FUNCTIONS[of_observer](share * part.delta)
                factors[load] = FUNCTIONS[of_load](share * part.delta)
                for i, j in product(directions, repeat=2):
                    if np.any(coefficients[i, j]):
                        places = (i, observer), (j, load)
                        kernels[places] = kernels.get(places, 0.0) + sign * coefficients[i, j]
    return Convolution(directions, factors, kernels)


def require_operator(variant: str) -> None:
    """Raise WrongInput for an unknown variant, and for one that has no operator."""
    if missing := sorted(set(forms_of(variant).values()) - FORMS.keys()):
        raise WrongInput(
            f"variant = {variant!r}: {', '.join(missing)} has no fast operator: use {', '.join(FORMS)}"
        )


@dataclass(frozen=True, eq=False)
class _Part:
    """Components of the ICs of a half-space; its directions turn with the inclinations `delta`, (n_s,)."""

    forms: Forms
    half_space: HalfSpace
    grid: Grid
    delta: Array

    @property
    def waves(self) -> Waves:
        """The functions of the turn that the components consist of, with their coefficients."""
        total: Waves = {}
        for form in dict.fromkeys(self.forms.values()):
            kept = np.zeros((3, 3, 1, 1))
            kept[tuple(zip(*(at for at in self.forms if self.forms[at] == form), strict=True))] = 1
            for wave, coefficients in FORMS[form](self).items():
                total[wave] = total.get(wave, 0.0) + kept * coefficients
        return total

    @cached_property
    def a(self) -> Array:
        """A at all lags [mm/MPa], shape (3, 3, 2 n_x - 1, 2 n_s - 1)."""
        return _at_all_lags(self.half_space.lags(self._element, self.grid.n_x, self.grid.n_s))

    @cached_property
    def a_prime(self) -> Array:
        """A' at all lags [mm/MPa], likewise."""
        lags_s = self.grid.ds * np.arange(self.grid.n_s)
        return _at_all_lags(self.half_space.effective_ics(self._element, self.grid.lags[:, None], lags_s))

    @property
    def _element(self) -> Patch:
        return Patch(self.grid.dx / 2, self.grid.ds / 2)


def _parts(variant: str, pair: Pair, grid: Grid, upper_offset: float) -> list[_Part]:
    """The parts whose sum are the combined ICs.

    Components by combined effective properties are of both bodies on the lower contour. So are others where
    both bodies turn alike and have no properties of their own; else each body has its part.
    """
    forms, lower = forms_of(variant), pair.lower
    fitted = {at: form for at, form in forms.items() if form in OF_EFFECTIVE}
    places = (lower, grid.strips), (pair.upper, grid.strips + upper_offset)
    deltas = [body.surface.contour.inclination(strips) for body, strips in places]
    combined = HalfSpace(pair.constants, effective=pair.effective)
    own_properties = fitted and not pair.effective and (lower.effective or pair.upper.effective)
    if not own_properties and (np.array_equal(deltas[0], deltas[1]) or set(forms.values()) == {"A"}):
        return [_Part(forms, combined, grid, deltas[0])]
    of_pair = fitted if pair.effective else {}
    of_bodies = {at: form for at, form in forms.items() if at not in of_pair}
    own = [
        _Part(of_bodies, HalfSpace(body.constants, effective=body.effective), grid, delta)
        for body, delta in zip((lower, pair.upper), deltas, strict=True)
    ]
    return [*own, _Part(of_pair, combined, grid, deltas[0])]


def _at_all_lags(a: Array) -> Array:
    """ICs at lags from -(n - 1) to n - 1 along x and s, from those at lags >= 0, by their parities."""
    sign_x, sign_s = (mirror_signs(direction)[:, :, None, None] for direction in (X, S))
    along_x = np.concatenate([sign_x * a[:, :, :0:-1], a], axis=2)
    return np.concatenate([sign_s * along_x[..., :0:-1], along_x], axis=3)


def _by(left: Array, kernels: Array, right: Array) -> Array:
    """Products of matrices (3, 3) with kernels (3, 3, lags, lags) between them."""
    return np.einsum("ik,klxs,lj->ijxs", left, kernels, right)


def _load_turned(a: Array) -> Waves:
    """B = A R_x(alpha)."""
    return {wave: _by(np.eye(3), a, p) for wave, p in ((ONE, P_1), (COS, P_C), (SIN, P_S))}


def _observer_turned(a: Array) -> Waves:
    """B-bar = R_x(alpha) A."""
    return {wave: _by(p, a, np.eye(3)) for wave, p in ((ONE, P_1), (COS, P_C), (SIN, P_S))}


def _both_turned(a: Array) -> Waves:
    """B-hat = R_x(alpha/2) A R_x(alpha/2); products of functions of alpha/2 are functions of alpha."""
    cos_cos, sin_sin = _by(P_C, a, P_C) / 2, _by(P_S, a, P_S) / 2
    return {
        ONE: _by(P_1, a, P_1) + cos_cos + sin_sin,
        COS: cos_cos - sin_sin,
        SIN: (_by(P_C, a, P_S) + _by(P_S, a, P_C)) / 2,
        COS_HALF: _by(P_1, a, P_C) + _by(P_C, a, P_1),
        SIN_HALF: _by(P_1, a, P_S) + _by(P_S, a, P_1),
    }


FORMS: Mapping[str, Callable[[_Part], Waves]] = MappingProxyType(
    {
        "A": lambda part: {ONE: part.a},
        "B": lambda part: _load_turned(part.a),
        "Bbar": lambda part: _observer_turned(part.a),
        "Bhat": lambda part: _both_turned(part.a),
        "Bhat_prime": lambda part: _both_turned(part.a_prime),
        "Bhat_prime_or_A": lambda part: (
            _both_turned(part.a_prime) if part.half_space.effective else {ONE: part.a}
        ),
    }
)
