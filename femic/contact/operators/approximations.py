"""Approximations as operators: convolutions in x and s between factors of the inclinations.

On prismatic bodies the rotation between two elements is R_x(alpha), alpha the difference of their
inclinations, and R_x(p alpha) = Q_0 + Q_1 exp(i p alpha) + Q_-1 exp(-i p alpha) with constant matrices Q. So
T^p A T^q is a sum of kernels of the lag times cosines and sines of (m p + n q) alpha, m, n = -1, 0, 1; and
these, of a difference, are sums of products. Forms of ICs that are no such product become an operator that is
dense between strips. Source: [BVSV] sections 3 and 4.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from approx.forms import FORMS, Form, Shares
from approx.halfspace import HalfSpace
from approx.pair import Pair
from approx.rotation import rotation_about_x
from approx.variants import Forms, forms_of
from femic.contact.operators.convolution import Convolution, Place
from femic.contact.operators.dense import GridOperator, strip_lags
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.patches import N, S, X, mirror_signs

Complex = NDArray[np.complex128]
Waves = dict[float, Complex]  # coefficients of exp(i w alpha) by w >= 0, (3, 3, lags along x, along s)

Q_0 = np.diag([1.0, 0.0, 0.0])
Q_1 = np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.5j], [0.0, -0.5j, 0.5]])
FUNCTIONS: Mapping[str, Callable[[Array], Array]] = MappingProxyType({"cos": np.cos, "sin": np.sin})
ROUNDING = 1e-10  # of ICs, as a share of the largest


def approximate_operator(
    variant: str,
    pair: Pair,
    grid: Grid,
    directions: tuple[int, ...] = (X, S, N),
    *,
    upper_offset: float = 0.0,
) -> Convolution | GridOperator:
    """The operator of an approximation of the combined ICs of two bodies.

    The grid lies on the lower contour; arc lengths [mm] of the upper one are `upper_offset` larger where both
    meet, so that each body rotates with its own inclinations. The operator is a convolution where all forms
    of the variant have fixed `Shares` of the rotation.

    Both bodies count as prismatic: with theta the angle between two elements about the axle, the curvature of
    a wheel along x changes nn by a share of less than theta ((1 - 2 nu) / (2 - 2 nu) + |alpha| + theta), nu
    that of the wheel, and xn and nx by theta / 2 times xx and nn. Raises WrongInput for an unknown variant,
    for B-hat-prime without effective properties, and for ICs that are not symmetric in x. Source: as
    `approx.pair.Pair`.
    """
    forms = forms_of(variant)
    parts = _parts(forms, pair, grid, upper_offset)
    if all(isinstance(form.rotate, Shares) for form in forms.values()):
        return _convolution(parts, directions)
    if not all(part.symmetric_in_x for part in parts):
        raise WrongInput(
            f"variant = {variant!r}: its ICs at -x are not those at x with the signs of xs, sx, xn and nx "
            "changed, which operators of contact need"
        )
    return GridOperator.of(_matrix(parts)[..., directions, :][..., directions], directions)


def approximate_matrix(variant: str, pair: Pair, grid: Grid, *, upper_offset: float = 0.0) -> Array:
    """The ICs of `approximate_operator` [mm/MPa] at lags >= 0 between strips, (n_x, n_s, n_s, 3, 3)."""
    return _matrix(_parts(forms_of(variant), pair, grid, upper_offset))


def half_space_operator(pair: Pair, grid: Grid, directions: tuple[int, ...] = (X, S, N)) -> Convolution:
    """The operator of A of both bodies, whose inverse is a preconditioner of contact with any ICs."""
    return _convolution(_parts(forms_of("A"), pair, grid, 0.0), directions)


@dataclass(frozen=True, eq=False)
class _Part:
    """Components of the ICs of a half-space; its directions rotate with the inclinations `delta`, (n_s,)."""

    forms: Forms
    half_space: HalfSpace
    grid: Grid
    delta: Array

    @property
    def waves(self) -> Waves:
        """The coefficients of the waves of all components; the forms have fixed shares of the rotation."""
        total: Waves = {}
        for form, mask in self._masks.items():
            assert isinstance(form.rotate, Shares)
            terms = product(_terms(form.rotate.observer), _terms(form.rotate.load))
            for (w_observer, left), (w_load, right) in terms:
                coefficients = mask * np.einsum("ik,klxs,lj->ijxs", left, self._half_space_ics(form), right)
                w = round(w_observer + w_load, 12)
                total[abs(w)] = total.get(abs(w), 0) + (coefficients if w >= 0 else np.conj(coefficients))
        return total

    def between_strips(self, lags_x: slice) -> Array:
        """ICs [mm/MPa] at some lags along x between all strips, shape (3, 3, lags, n_s, n_s)."""
        rotation = rotation_about_x(np.subtract.outer(self.delta, self.delta))
        lags_s = strip_lags(self.grid.n_s)
        total = np.zeros(())
        for form, mask in self._masks.items():
            ics = form.rotate(self._half_space_ics(form)[:, :, lags_x, lags_s], rotation)
            total = total + mask[..., None] * ics
        return total

    @property
    def symmetric_in_x(self) -> bool:
        """Whether the ICs at lags -1 and +1 along x differ by the signs of components only."""
        n_x = self.grid.n_x
        if n_x == 1:
            return True
        behind, ahead = (self.between_strips(slice(place, place + 1)) for place in (n_x - 2, n_x))
        defect = ahead - mirror_signs(X)[:, :, None, None, None] * behind
        return bool(np.max(np.abs(defect)) <= ROUNDING * np.max(np.abs(ahead)))

    @cached_property
    def _masks(self) -> dict[Form, Array]:
        """1 at the components of each form, else 0, shape (3, 3, 1, 1)."""
        masks: dict[Form, Array] = {}
        for component, form in self.forms.items():
            masks.setdefault(form.on(self.half_space), np.zeros((3, 3, 1, 1)))[component] = 1
        return masks

    def _half_space_ics(self, form: Form) -> Array:
        """A or A' [mm/MPa] at all lags, shape (3, 3, 2 n_x - 1, 2 n_s - 1)."""
        return self._a_prime if form.effective else self._a

    @cached_property
    def _a(self) -> Array:
        return _at_all_lags(self.half_space.lags(self.grid.element, self.grid.n_x, self.grid.n_s))

    @cached_property
    def _a_prime(self) -> Array:
        lags_s = self.grid.ds * np.arange(self.grid.n_s)
        ics = self.half_space.effective_ics(self.grid.element, self.grid.lags[:, None], lags_s)
        return _at_all_lags(ics)


def _matrix(parts: Sequence[_Part]) -> Array:
    """The sum of parts at lags >= 0 [mm/MPa], shape (n_x, n_s, n_s, 3, 3)."""
    ics = np.sum([part.between_strips(slice(part.grid.n_x - 1, None)) for part in parts], axis=0)
    return np.moveaxis(ics, (0, 1), (3, 4))


def _terms(share: float) -> list[tuple[float, Array | Complex]]:
    """R_x(share alpha) as matrices times exp(i w alpha): pairs of w and matrix."""
    return [(0.0, Q_0), (share, Q_1), (-share, np.conj(Q_1))] if share else [(0.0, np.eye(3))]


def _convolution(parts: Sequence[_Part], directions: tuple[int, ...]) -> Convolution:
    """The sum of parts, all of them with fixed shares of the rotation, as a sum of convolutions."""
    factors: dict[str, Array] = {}
    kernels: dict[tuple[Place, Place], Array] = {}
    for number, part in enumerate(parts):
        for w, coefficients in part.waves.items():
            for of_observer, of_load, kernel in _products(w, coefficients):
                observer, load = (f"{name}({w!r} delta_{number})" for name in (of_observer, of_load))
                factors[observer], factors[load] = (
                    FUNCTIONS[name](w * part.delta) for name in (of_observer, of_load)
                )
                for i, j in product(directions, repeat=2):
                    if np.any(kernel[i, j]):
                        places = (i, observer), (j, load)
                        kernels[places] = kernels.get(places, 0.0) + kernel[i, j]
    return Convolution(directions, factors, kernels)


def _products(w: float, coefficients: Complex) -> Iterator[tuple[str, str, Array]]:
    """Re(c exp(i w (delta_I - delta_J))) as functions of delta_I and of delta_J with their kernels."""
    yield "cos", "cos", coefficients.real
    if w:
        yield "sin", "sin", coefficients.real
        yield "sin", "cos", -coefficients.imag
        yield "cos", "sin", coefficients.imag


def _parts(forms: Forms, pair: Pair, grid: Grid, upper_offset: float) -> list[_Part]:
    """The parts whose sum are the combined ICs.

    Components of combined effective properties are of both bodies on the lower contour. So are others where
    both bodies rotate alike and have no properties of their own; else each body has its part.
    """
    lower, upper = pair.lower, pair.upper
    deltas = [
        body.surface.contour.inclination(strips)
        for body, strips in ((lower, grid.strips), (upper, grid.strips + upper_offset))
    ]
    effective = {at: form for at, form in forms.items() if form.effective}
    own_properties = effective and not pair.effective and (lower.effective or upper.effective)
    if not own_properties and (np.array_equal(deltas[0], deltas[1]) or set(forms.values()) == {FORMS["A"]}):
        return [_Part(forms, pair.half_space, grid, deltas[0])]
    of_pair = effective if pair.effective else {}
    of_bodies = {at: form for at, form in forms.items() if at not in of_pair}
    own = [
        _Part(of_bodies, body.half_space, grid, delta)
        for body, delta in zip((lower, upper), deltas, strict=True)
    ]
    return [*own, _Part(of_pair, pair.half_space, grid, deltas[0])] if of_pair else own


def _at_all_lags(ics: Array) -> Array:
    """ICs at lags from -(n - 1) to n - 1 along x and s, from those at lags >= 0, by their parities."""
    sign_x, sign_s = (mirror_signs(direction)[:, :, None, None] for direction in (X, S))
    along_x = np.concatenate([sign_x * ics[:, :, :0:-1], ics], axis=2)
    return np.concatenate([sign_s * along_x[..., :0:-1], along_x], axis=3)
