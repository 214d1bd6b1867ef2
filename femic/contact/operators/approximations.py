"""Approximations as operators: convolutions in x and s between factors of the inclinations.

On prismatic bodies the rotation between two elements is R_x(alpha), alpha the difference of their
inclinations, and R_x(p alpha) = Q_0 + Q_1 exp(i p alpha) + Q_-1 exp(-i p alpha) with constant matrices Q. So
T^p A T^q is a sum of kernels of the lag times cosines and sines of (m p + n q) alpha, m, n = -1, 0, 1; and
these, of a difference, are sums of products. Forms of ICs that are no such product become an operator that is
dense between strips. Source: [BVSV] sections 3 and 4; docs/theory/contact.md.

In rolling, displacements of a wheel along x are taken as the rail sees them (`rolled`). The local directions
of a wheel rotate with its surface. A particle that is raised by u_z is nearer to the axle and passes the
contact more slowly, by u_z over the radius R of its rolling circle: in local directions the slip along x is
w_x - du_x/dx + u_z / R. So u_x less the integral of u_z / R along x takes the place of u_x. Then a rigid
vertical motion of the wheel, for which u_x = u_z x / R, does not change the slip; otherwise the slip would
depend on the rigid-body discount, by M_zz times load over R.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from approx.forms import FORMS, Form, Shares, rotation_about_x
from approx.halfspace import HalfSpace
from approx.pair import Pair
from approx.variants import Forms, forms_of
from femic.contact.operators.convolution import Convolution, Place
from femic.contact.operators.dense import GridOperator, strip_lags
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import Grid, N, S, X, mirror_signs
from geometries.surfaces import Surface

Complex = NDArray[np.complex128]

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
    """Return the operator of an approximation of the combined ICs of two bodies.

    The grid lies on the lower contour; arc lengths [mm] of the upper one are `upper_offset` larger where both
    meet, so that each body rotates with its own inclinations. The operator is a convolution where all forms
    of the variant have fixed `Shares` of the rotation.

    Both bodies count as prismatic: with theta the angle between two elements about the axle, the curvature of
    a wheel along x changes nn by a share of less than theta ((1 - 2 nu) / (2 - 2 nu) + |alpha| + theta), with
    the wheel's nu, and xn and nx by theta / 2 times xx and nn. Raises WrongInput for an unknown variant,
    for B-hat-prime without effective properties, and for ICs that are not symmetric in x. Source: as
    `approx.pair.Pair`.
    """
    forms = forms_of(variant)
    parts = _parts(forms, pair, grid, upper_offset)
    if all(form.has_shares for form in forms.values()):
        return _convolution(parts, directions)
    if not all(part.symmetric_in_x for part in parts):
        raise WrongInput(
            f"variant = {variant!r}: its ICs at -x are not those at x with the signs of xs, sx, xn and nx "
            "changed, which operators of contact need"
        )
    return GridOperator.from_ics(_matrix(parts)[..., directions, :][..., directions], directions)


def approximate_matrix(variant: str, pair: Pair, grid: Grid, *, upper_offset: float = 0.0) -> Array:
    """Return the ICs of `approximate_operator` [mm/MPa] at lags >= 0, (n_x, n_s, n_s, 3, 3)."""
    return _matrix(_parts(forms_of(variant), pair, grid, upper_offset))


def half_space_operator(pair: Pair, grid: Grid, directions: tuple[int, ...] = (X, S, N)) -> Convolution:
    """Return the operator of A of both bodies, whose inverse is a preconditioner of contact with any ICs."""
    return _convolution(_parts(forms_of("A"), pair, grid, 0.0), directions)


@dataclass(frozen=True, eq=False)
class _Part:
    """Components of the ICs of a half-space; its directions rotate with the inclinations `delta`, (n_s,)."""

    forms: Forms
    half_space: HalfSpace
    grid: Grid
    delta: Array

    def between_strips(self, lags_x: slice) -> Array:
        """ICs [mm/MPa] at some lags along x between all strips, shape (3, 3, lags, n_s, n_s)."""
        rotation = rotation_about_x(np.subtract.outer(self.delta, self.delta))
        lags_s = strip_lags(self.grid.n_s)
        chosen = {form: self.half_space_ics(form)[:, :, lags_x, lags_s] for form in self.components}
        total = np.zeros_like(next(iter(chosen.values())))
        for form, components in self.components.items():
            ics = form.rotate(chosen[form], rotation)
            for component in components:
                total[component] = ics[component]
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
    def components(self) -> dict[Form, list[tuple[int, int]]]:
        """The components that have each form."""
        by_form: dict[Form, list[tuple[int, int]]] = {}
        for component, form in self.forms.items():
            by_form.setdefault(form.on(self.half_space), []).append(component)
        return by_form

    def half_space_ics(self, form: Form) -> Array:
        """Return A or A' [mm/MPa] at all lags, shape (3, 3, 2 n_x - 1, 2 n_s - 1)."""
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
    """Return the sum of parts at lags >= 0 [mm/MPa], shape (n_x, n_s, n_s, 3, 3)."""
    ics = np.sum([part.between_strips(slice(part.grid.n_x - 1, None)) for part in parts], axis=0)
    return np.moveaxis(ics, (0, 1), (3, 4))


def _convolution(parts: Sequence[_Part], directions: tuple[int, ...]) -> Convolution:
    """Return the sum of parts, all of them with fixed shares of the rotation, as a sum of convolutions."""
    factors: dict[str, Array] = {}
    kernels: dict[tuple[Place, Place], Array] = {}
    for (number, part), i, j in product(enumerate(parts), directions, directions):
        if (i, j) not in part.forms:
            continue
        form = part.forms[i, j].on(part.half_space)
        assert isinstance(form.rotate, Shares)
        for w, weights in _weights(form.rotate).items():
            ics = part.half_space_ics(form)
            cosine, sine = (
                np.tensordot(share, ics, 2) for share in (weights[i, j].real, -weights[i, j].imag)
            )
            products = [("cos", "cos", cosine)]  # of cos and sin of w (delta_I - delta_J)
            if w:
                products += [("sin", "sin", cosine), ("sin", "cos", sine), ("cos", "sin", -sine)]
            for observer_function, load_function, kernel in products:
                if not np.any(kernel):
                    continue
                observer, load = (
                    f"{name}({w!r} delta_{number})" for name in (observer_function, load_function)
                )
                factors[observer] = FUNCTIONS[observer_function](w * part.delta)
                factors[load] = FUNCTIONS[load_function](w * part.delta)
                places = (i, observer), (j, load)
                kernels[places] = kernels.get(places, 0.0) + kernel
    return Convolution(directions, factors, kernels)


def _weights(shares: Shares) -> dict[float, Complex]:
    """Return W of T^p A T^q = Re(sum of exp(i w alpha) W A) by w >= 0: of A_kl in ij, (3, 3, 3, 3)."""
    observers, loads = (  # R_x(share alpha) as matrices times exp(i w alpha): pairs of w and matrix
        [(0.0, Q_0), (share, Q_1), (-share, np.conj(Q_1))] if share else [(0.0, np.eye(3))]
        for share in (shares.observer, shares.load)
    )
    total: dict[float, Complex] = {}
    for (p, left), (q, right) in product(observers, loads):
        w, weights = round(p + q, 12), np.einsum("ik,lj->ijkl", left, right).astype(complex)
        total[abs(w)] = total.get(abs(w), 0) + (weights if w >= 0 else np.conj(weights))
    return total


def _parts(forms: Forms, pair: Pair, grid: Grid, upper_offset: float) -> list[_Part]:
    """Return the parts whose sum are the combined ICs.

    Components of combined effective properties are of both bodies on the lower contour. So are others with
    shares where both bodies rotate alike and have no properties of their own; else each body has its part.
    """
    lower, upper = pair.lower, pair.upper
    deltas = [
        body.surface.contour.inclination(strips)
        for body, strips in ((lower, grid.strips), (upper, grid.strips + upper_offset))
    ]
    effective = {at: form for at, form in forms.items() if form.effective}
    own_properties = effective and not pair.effective and (lower.effective or upper.effective)
    alike = np.array_equal(deltas[0], deltas[1]) or set(forms.values()) == {FORMS["A"]}
    if alike and not own_properties and all(form.has_shares for form in forms.values()):
        return [_Part(forms, pair.half_space, grid, deltas[0])]
    combined = effective if pair.effective else {}
    separate = {at: form for at, form in forms.items() if at not in combined}
    parts = (
        _Part(separate, lower.half_space, grid, deltas[0]),
        _Part(separate, upper.half_space, grid, deltas[1]),
        _Part(combined, pair.half_space, grid, deltas[0]),
    )
    return [part for part in parts if part.forms]


def _at_all_lags(ics: Array) -> Array:
    """ICs at lags from -(n - 1) to n - 1 along x and s, from those at lags >= 0, by their parities."""
    sign_x, sign_s = (mirror_signs(direction)[:, :, None, None] for direction in (X, S))
    along_x = np.concatenate([sign_x * ics[:, :, :0:-1], ics], axis=2)
    return np.concatenate([sign_s * along_x[..., :0:-1], along_x], axis=3)


# --- a wheel as the rail sees it ---


def rolled(ics: Array, surface: Surface, grid: Grid) -> Array:
    """Return ICs (n_x, n_s, n_s, 3, 3) at lags >= 0 as the slip needs them; prismatic bodies keep theirs.

    `surface` belongs to the wheel; the strips of `grid` are its own arc lengths. The integral along x is
    computed by the trapezoidal rule.
    """
    if np.isinf(surface.rolling_radius):
        return ics
    sin, cos = surface.contour.normal(grid.strips)
    radius = surface.circle_radius(grid.strips)
    raised = cos[:, None, None] * ics[..., N, :] - sin[:, None, None] * ics[..., S, :]
    along_x = cumulative_trapezoid(raised / radius[:, None, None], dx=grid.dx, axis=0, initial=0)
    seen = ics.copy()
    seen[..., X, :] -= along_x
    return seen
