"""Forms of ICs: how ICs of half-spaces and the rotation from load to observer give ICs of curved bodies.

With the local directions of an element in global axes as the columns of Q, T = Q_I^T Q_J takes the directions
of the load into the directions of the observer. On a prismatic surface T = R_x(alpha), alpha = delta(s_I) -
delta(s_J), the same for both bodies. Source: [BVSV] section 3; docs/theory/ics.md.

`FORMS` holds each form once; points, matrices and contact operators follow from it. A form consists of A, or
A' of effective properties, and of a function of these ICs and the rotation T. In the B family this is
`Shares`: T^p A T^q, for which contact has fast operators, whatever p and q are. Any other function that works
point by point and is symmetric in x will do, with a slower operator in contact.

SciPy's class of rotations gives the same numbers as `Rotation`, but takes three to thirteen times as long
(B-hat at 100 000 points: 100 ms against 36 ms, where A takes 37 ms), because its matrices have the points in
front.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from approx.halfspace import HalfSpace
from geometries.arrays import Array
from geometries.patches import Patch
from geometries.surfaces import Surface

# --- rotations ---


@dataclass(frozen=True, eq=False)
class Rotation:
    """Rotations T as unit quaternions, shape (4, ...)."""

    quaternion: Array

    @property
    def matrix(self) -> Array:
        """T, shape (3, 3, ...)."""
        w, i, j, k = self.quaternion
        return np.array(
            [
                [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)],
                [2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)],
                [2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)],
            ]
        )

    @property
    def angle(self) -> Array:
        """Angle [rad] about the axis of the rotation, 0 ... 2 pi, shape (...)."""
        return np.asarray(2 * np.arctan2(np.linalg.norm(self.quaternion[1:], axis=0), self.quaternion[0]))

    @property
    def inverse(self) -> "Rotation":
        """T^-1: the rotation from observer to load."""
        w, *axis = self.quaternion
        return Rotation(np.array([w, *(-component for component in axis)]))

    def power(self, exponent: float) -> "Rotation":
        """T^exponent: this multiple of the angle about the same axis."""
        if exponent == 1:
            return self
        half = self.angle / 2
        ratio = exponent * np.sinc(exponent * half / np.pi) / np.sinc(half / np.pi)
        return Rotation(np.array([np.cos(exponent * half), *(ratio * self.quaternion[1:])]))


def rotation_about_x(alpha: ArrayLike) -> Rotation:
    """R_x(alpha), the rotation by alpha [rad] about the x axis."""
    half = np.asarray(alpha, dtype=float) / 2
    return Rotation(np.array([np.cos(half), np.sin(half), 0 * half, 0 * half]))


def rotation_between(surface: Surface, points: tuple[Array, Array], s_load: float) -> Rotation:
    """T of observers at (x, s) [mm] on a surface and a load at (0, s_load).

    T = R_x(delta_I) R_y(side theta) R_x(-delta_J), theta the angle between the two about the axis.
    """
    x, s = points
    delta_I, delta_J = surface.contour.inclination(s), surface.contour.inclination(s_load)
    half = surface.side * surface.chart_x(x, s, s_load) / surface.rolling_radius / 2
    alpha, mean = (delta_I - delta_J) / 2, (delta_I + delta_J) / 2
    along, about = np.cos(half), np.sin(half)
    return Rotation(
        np.array([along * np.cos(alpha), along * np.sin(alpha), about * np.cos(mean), about * np.sin(mean)])
    )


def matmul(left: Array, right: Array) -> Array:
    """Matrix product over the first two axes, shape (3, 3, ...)."""
    return np.einsum("ik...,kj...->ij...", left, right)


# --- forms ---

# From ICs of a half-space (3, 3, ...) and rotations whose shape broadcasts to ..., to ICs of the same shape.
Rotate = Callable[[Array, Rotation], Array]


@dataclass(frozen=True)
class Shares:
    """T^observer A T^load: the shares of the rotation by which displacement and load are rotated."""

    observer: float
    load: float

    def __call__(self, ics: Array, rotation: Rotation) -> Array:
        """ICs of the shape and unit of `ics`."""
        powers = {share: rotation.power(share).matrix for share in {self.observer, self.load} - {0}}
        if self.observer:
            ics = matmul(powers[self.observer], ics)
        return matmul(ics, powers[self.load]) if self.load else ics


@dataclass(frozen=True)
class Transposed:
    """A function of ICs and rotations with load and observer exchanged."""

    rotate: Rotate

    def __call__(self, ics: Array, rotation: Rotation) -> Array:
        """ICs of the shape and unit of `ics`."""
        return np.swapaxes(self.rotate(np.swapaxes(ics, 0, 1), rotation.inverse), 0, 1)


@dataclass(frozen=True)
class Form:
    """A form of ICs: `rotate` makes them of A or, if `effective`, of A'.

    `fallback` is the form that takes the place of an effective one where there are no effective properties.
    """

    rotate: Rotate
    effective: bool = False
    fallback: "Form | None" = None

    @property
    def reciprocal(self) -> "Form":
        """The form F with F(I, J) = this form(J, I)^T."""
        fallback = self.fallback and self.fallback.reciprocal
        if isinstance(self.rotate, Shares):
            return Form(Shares(self.rotate.load, self.rotate.observer), self.effective, fallback)
        return Form(Transposed(self.rotate), self.effective, fallback)

    @property
    def has_shares(self) -> bool:
        """Whether the form, and its fallback, rotate by fixed shares."""
        return isinstance(self.rotate, Shares) and (self.fallback is None or self.fallback.has_shares)

    def on(self, half_space: HalfSpace) -> "Form":
        """The form itself, or its fallback on a half-space without effective properties."""
        return self if half_space.effective or self.fallback is None else self.fallback


UNROTATED, HALVES = Shares(0, 0), Shares(1 / 2, 1 / 2)
FORMS: dict[str, Form] = {
    "A": Form(UNROTATED),
    "B": Form(Shares(0, 1)),
    "Bbar": Form(Shares(1, 0)),
    "Bhat": Form(HALVES),
    "Bhat_prime": Form(HALVES, effective=True),
    "Bhat_prime_or_A": Form(HALVES, effective=True, fallback=Form(UNROTATED)),
}


# --- ICs of forms ---


@dataclass(frozen=True, eq=False)
class Ingredients:
    """Ingredients of forms at observers (x, s) [mm]: ICs of half-spaces, and rotations of the directions."""

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
        """A' of the effective properties [mm/MPa], shape (3, 3, ...)."""
        return self.half_space.effective_ics(self.patch, self.x, self.s - self.patch.s)

    @cached_property
    def rotation(self) -> Rotation:
        """T from load to observer."""
        return rotation_between(self.surface, (self.x, self.s), self.patch.s)

    def ics(self, form: Form) -> Array:
        """ICs of a form per unit pressure [mm/MPa], shape (3, 3, ...)."""
        form = form.on(self.half_space)
        ics = self.a_prime if form.effective else self.a
        return ics if form.rotate == UNROTATED else form.rotate(ics, self.rotation)

    def by_form(self, forms: Iterable[Form]) -> dict[Form, Array]:
        """ICs of several forms; what they have in common is computed once."""
        return {form: self.ics(form) for form in forms}
