"""How surfaces slip over each other: the rigid motion, and slip by a shift or in rolling.

Velocities of a rigid wheel are those of the upper surface over the lower one per unit of rolled distance, in
the local directions x, s, n of the latter; those along x and s are the rigid slip w. Rolling is towards +x.
Theory: docs/theory/friction.md. Source: Kalker (1990), Three-dimensional elastic bodies in rolling contact,
section 1.3.

Slip follows from w and the displacement differences u (upper less lower body). Particles run through a
rolling contact from its leading edge at large x to its trailing edge.

    shift           s = w + u - u'                     [mm], u' before the shift
    step of rolling s = w + (u(x) - u'(x + dx)) / dx   per unit of rolled distance, u' a step before
    steady rolling  s = w + (u(x) - u(x + dx)) / dx    the same with u' = u

The last two are right to the second order half way between an element and the next one ahead, where w is
taken, too. Taken as the slip of the element, with its own w (`order` 1), this is the scheme of Kalker and of
CONTACT (Kalker, section 4.3).

**Slip at the centres of elements.** Friction opposes the slip at an element, while s is known ahead of it,
and s' behind it, both to the second order. Their mean is that of the element. But where s vanishes the
element has to stick, and the law must have a solution on any grid: so the slip of an element,

    s + w (s' - s) / 2,   w = 4 max(0, s . s') / (|s| + |s'|)^2,

vanishes only with s, changes continuously, and is the mean up to errors of the second order where slip is
smooth. (With the plain mean the law has no solution on one of ten coarse grids.)

**Leading edge.** A surface that rolls into contact takes up tangential tractions from zero, in proportion to
the pressures at first: their ratio is smooth there, while both rise like the square root of the distance from
the edge. Elements of constant traction follow this rise badly: where slip is made zero on the outermost ones,
forces have errors of the first order, which depend on how the edge cuts elements. So the last `DEPTH`
elements of each row take the same share of their bounds as the one behind them.

In short rows bounds hardly fall between these elements: then their tractions, raised together, would move the
followed one ahead instead of back, and no tractions at all might obey Coulomb's law. So only one element
follows in rows of less than two times `LEAST_PER_DEPTH` elements, and none in rows of less than that.

**Friction by the contact angle**, as on a lubricated flange, is a factor of the coefficient. The contact
angle of an element is the magnitude of the inclination of the lower surface there, in the axes in which this
surface is given. The factor is linear between pairs of angle and factor, and constant beyond them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Self

import numpy as np
from pydantic import AfterValidator, Field, Strict

from femic.contact.patch import Box, block_mean
from femic.key_types import Several
from geometries.arrays import Array, Indices, Mask
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.patches import N, S, X

# --- rigid motion of a wheel ---


@dataclass(frozen=True)
class Creepages:
    """How a wheel moves besides rolling, at zero yaw.

    `longitudinal` is omega R_roll / V - 1, positive where the wheel is driven; `lateral` the lateral velocity
    of the wheel relative to the rail over V; `spin` [1/mm] an angular velocity of the wheel about z over V,
    beside that which its own rotation has about the normals of inclined places.
    """

    longitudinal: float = 0.0
    lateral: float = 0.0
    spin: float = 0.0

    def __post_init__(self) -> None:
        if not np.all(np.isfinite([self.longitudinal, self.lateral, self.spin])):
            raise WrongInput(f"creepages {self}: must be finite")


NAMES = ("longitudinal", "lateral", "spin")


@dataclass(frozen=True, eq=False)
class RollingKinematics:
    """Where a wheel of rolling radius `radius` [mm] rolls on a lower contour.

    `x` [mm], (n_x,), and `s` [mm], (n_s,), are the centres of elements; `height` [mm], (n_s,), is that of the
    wheel's surface there over its crown (`Undeformed.upper_height`): a wheel that is moved aside touches on
    other circles. An infinite radius is that of a prismatic upper body, which only slides.
    """

    contour: Contour
    radius: float
    x: Array
    s: Array
    height: Array

    @cached_property
    def section(self) -> tuple[Array, Array, Array]:
        """Lateral coordinates [mm] of the strips, and sine and cosine of their inclination, (n_s,) each."""
        sin, cos = self.contour.normal(self.s)
        return self.contour.position(self.s)[0], sin, cos

    def rigid_velocity(self, creepages: Creepages) -> Array:
        """Velocity along x, s, n of the rigid wheel over the rail, over V, shape (n_x, n_s, 3).

        Along n the wheel comes down ahead of the contact and rises behind it; its lateral velocity and spin
        move it along the normals of inclined places, too.
        """
        xi, upsilon, phi = creepages.longitudinal, creepages.lateral, creepages.spin
        y, sin, cos = self.section
        x = self.x[:, None]
        along_x = -xi + (1 + xi) * self.height / self.radius - phi * y
        aside, up = upsilon + phi * x, -(1 + xi) * x / self.radius
        velocity = np.empty((len(self.x), len(self.s), 3))
        velocity[..., X] = along_x
        velocity[..., S], velocity[..., N] = aside * cos - up * sin, aside * sin + up * cos
        return velocity

    def rigid_slip(self, creepages: Creepages) -> Array:
        """Rigid slip per unit of rolled distance, shape (n_x, n_s, 2)."""
        return self.rigid_velocity(creepages)[..., :N]

    def per_creepage(self, name: str) -> Array:
        """Return the rigid slip that a creepage of 1 adds, (n_x, n_s, 2): it is linear in each."""
        return self.rigid_slip(Creepages(**{name: 1.0})) - self.rigid_slip(Creepages())


# --- friction by the contact angle ---

Angle = Annotated[float, Field(ge=0, le=90)]  # deg
Factor = Annotated[float, Field(ge=0, le=10)]
Pairs = Sequence[tuple[float, float]]  # of an angle [deg] and the factor there


def growing(pairs: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Return the pairs; raise ValueError unless their angles grow, and where there is no friction at all."""
    for (angle, _), (after, _) in pairwise(pairs):
        if not angle < after:
            raise ValueError(
                f"angle {after:g} comes after {angle:g}: angles must increase; for a step, give two angles "
                "that are almost equal"
            )
    if pairs and not any(factor for _, factor in pairs):
        raise ValueError(
            "all factors are 0; give a positive one, or motion = 'none' for contact without friction"
        )
    return pairs


ByAngle = Annotated[Several[Annotated[tuple[Angle, Factor], Strict(False)]], AfterValidator(growing)]
FactorsByAngle = Annotated[
    ByAngle,
    Field(
        description="friction that depends on the contact angle: pairs [angle in degrees, factor from 0 "
        "to 10] with increasing angles. Each coefficient is multiplied by the factor at the absolute "
        "inclination of the lower surface, linear between the angles and constant beyond them; default: "
        "factor 1"
    ),
]


def friction_factors(pairs: Pairs, inclination: Array) -> Array:
    """Return the factors of friction at inclinations [rad], of the same shape; 1 without pairs."""
    if not pairs:
        return np.ones_like(inclination)
    angles, factors = zip(*pairs, strict=True)
    return np.interp(np.degrees(np.abs(inclination)), angles, factors)


def in_words(pairs: Pairs) -> str:
    """Return the factors with their angles in words; empty without pairs."""
    if not pairs:
        return ""
    values = ", ".join(f"{factor:g} at {angle:g}°" for angle, factor in pairs)
    return (
        f"The friction coefficient is multiplied by a factor that depends on the contact angle: {values}, "
        "linear between, constant beyond."
    )


def largest_factor(pairs: Pairs) -> float:
    """Return the largest factor at any angle; 1 without pairs."""
    return max((factor for _, factor in pairs), default=1.0)


# --- slip at the centres of elements ---

Linear = Callable[[Array], Array]

TINY = 1e-150


def centred(slip: Array) -> Array:
    """Slip at the centres of elements, shape (n_x, n_s, 2)."""
    behind = _behind(slip)
    weight = _sizes_and_weight(slip, behind)[-1]
    return np.asarray(slip + weight / 2 * (behind - slip))


def centred_derivative(slip: Array) -> Linear:
    """Return the derivative of it at a slip: a linear function of changes of this, shape (n_x, n_s, 2)."""
    step = (_behind(slip) - slip) / 2
    weight, by_slip, by_slip_behind = _weights(slip)
    half, rest = weight / 2, 1 - weight / 2

    def derivative(change: Array) -> Array:
        behind = _behind(change)
        change_of_weight = np.sum(by_slip * change + by_slip_behind * behind, axis=-1, keepdims=True)
        return np.asarray(rest * change + half * behind + change_of_weight * step)

    return derivative


def _behind(values: Array) -> Array:
    """Return the values of the elements behind; the first ones have their own."""
    return np.concatenate([values[:1], values[:-1]])


def _weights(slip: Array) -> tuple[Array, Array, Array]:
    """Return the weight w (n_x, n_s, 1), and its derivatives by s and s', (n_x, n_s, 2) each."""
    behind = _behind(slip)
    a, b, product, weight = _sizes_and_weight(slip, behind)
    by_sizes = 2 * weight / (a + b)
    by_product = np.where(product > 0, 4 / (a + b) ** 2, 0.0)
    return weight, by_product * behind - by_sizes * slip / a, by_product * slip - by_sizes * behind / b


def _sizes_and_weight(slip: Array, behind: Array) -> tuple[Array, Array, Array, Array]:
    """Return sizes of both slips, their product, 0 where it is negative, and w, (n_x, n_s, 1) each."""
    a = np.maximum(np.hypot(slip[..., :1], slip[..., 1:]), TINY)
    b, product = _behind(a), slip * behind
    product = np.maximum(product[..., :1] + product[..., 1:], 0.0)
    return a, b, product, 4 * product / (a + b) ** 2


# --- leading edge ---

DEPTH = 2  # elements of each row that follow
LEAST_PER_DEPTH = 6  # elements of a row for each that follows


@dataclass(frozen=True, eq=False)
class LeadingEdge:
    """The row of the element that each one's tractions follow, and the ratio of both bounds, (n_x, n_s)."""

    followed: Indices
    ratio: Array

    @classmethod
    def find(cls, bound: Array, depth: int = DEPTH) -> "LeadingEdge":
        """Return the leading edge of where bounds are positive; rolling is towards +x."""
        places = np.arange(len(bound))[:, None]
        ahead, behind = _neighbours(bound[::-1] > 0)[::-1], _neighbours(bound > 0)
        following = np.minimum(depth, (ahead + 1 + behind) // LEAST_PER_DEPTH)
        steps = np.maximum(following - ahead, 0)
        followed = places - np.where(bound > 0, steps, 0)
        followed_bound = np.take_along_axis(bound, followed, axis=0)
        ratio = np.divide(bound, followed_bound, out=np.zeros_like(bound), where=followed_bound > 0)
        return cls(followed, ratio)

    @property
    def behind(self) -> Indices:
        """How many elements behind each one that is which it follows, shape (n_x, n_s); 0 of a free one."""
        return np.arange(len(self.followed))[:, None] - self.followed

    @property
    def free(self) -> Mask:
        """Elements with bounds that follow no other, shape (n_x, n_s)."""
        return np.asarray((self.behind == 0) & (self.ratio > 0))

    def with_followers(self, free_mask: Mask) -> Mask:
        """Return which elements have what some free ones (m,) have, with those that follow, (n_x, n_s)."""
        everywhere = np.zeros(self.followed.shape, bool)
        everywhere[self.free] = free_mask
        return np.take_along_axis(everywhere, self.followed, axis=0)

    def spread(self, p: Array) -> Array:
        """Return tractions of all elements from those of the free ones, shape (n_x, n_s, 2)."""
        return np.asarray(np.take_along_axis(p, self.followed[..., None], axis=0) * self.ratio[..., None])


def _neighbours(mask: Mask) -> Indices:
    """Return how many elements before each one, without a gap, are in a mask, shape (n_x, n_s)."""
    counts = np.zeros(mask.shape, dtype=int)
    for row in range(1, len(mask)):
        counts[row] = np.where(mask[row - 1], counts[row - 1] + 1, 0)
    return counts


# --- motions ---


@dataclass(frozen=True, eq=False)
class FreeSlip:
    """A slip (n_x, n_s, 2) of unknown amplitude, that which brings about a force.

    The force is the sum of `weights` (n_x, n_s, 3) [mm^2] times tractions.
    """

    slip: Array
    weights: Array
    force: float


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion with `rigid` slip (n_x, n_s, 2), besides that of unknown amplitude."""

    rigid: Array
    free: tuple[FreeSlip, ...] = ()

    depth = 0  # elements of a leading edge that follow others
    has_coarser = True

    def elastic_slip(self, u: Array) -> Array:
        """Return the part of slip that is linear in displacements, shape (n_x, n_s, 2)."""
        return u

    def at_elements(self, slip: Array) -> Array:
        """Return the slip at the centres of elements; it vanishes with `slip`, which may be beside these."""
        return slip

    def derivative_at_elements(self, slip: Array) -> Linear:  # noqa: ARG002 (linear here)
        """Return the derivative of it at a slip: a linear function of changes of this."""
        return lambda change: change

    @property
    def simpler(self) -> Self | None:
        """The same in a form that is less accurate and more robust, None where there is none."""
        return None

    def half_way(self, rigid: Array) -> Array:
        """Return a rigid slip where that by displacements is known, shape (n_x, n_s, 2)."""
        return rigid

    @property
    def given(self) -> Array:
        """The slip without displacements, shape (n_x, n_s, 2)."""
        return self.half_way(self.rigid)

    def given_at(self, approach: float) -> Array:  # noqa: ARG002 (a shift depends on it)
        """Return the slip without displacements at a vertical approach [mm], shape (n_x, n_s, 2)."""
        return self.given

    @property
    def free_slips(self) -> Array:
        """The free slips, shape (k, n_x, n_s, 2)."""
        return np.reshape([self.half_way(free.slip) for free in self.free], (-1, *self.rigid.shape))

    def coarsened(self) -> Self:
        """Return the motion on elements twice as large."""
        return self._on_elements(block_mean, 2)

    def within(self, box: Box) -> Self:
        """Return the motion of the elements in a box."""
        return self._on_elements(box.crop, 1)

    def _on_elements(self, take: Callable[[Array], Array], size: int) -> Self:
        """Return the motion on elements `size` times as large, whose values (n_x, n_s, ...) `take` gives."""
        free = tuple(
            FreeSlip(take(free.slip), size**2 * take(free.weights), free.force) for free in self.free
        )
        return replace(self, rigid=take(self.rigid), free=free)


@dataclass(frozen=True, eq=False)
class Shift(Motion):
    """A shift by `rigid` [mm], from displacements `before` (n_x, n_s, 2) [mm]; None: from none.

    A vertical approach beyond `approach_before` [mm] also shifts surfaces along s, by `per_approach` (n_s,)
    times as much: the sine of the inclination.
    """

    before: Array | None = None
    per_approach: Array | None = None
    approach_before: float = 0.0

    @property
    def given(self) -> Array:
        """The slip without displacements [mm], shape (n_x, n_s, 2)."""
        return self.rigid if self.before is None else self.rigid - self.before

    def given_at(self, approach: float) -> Array:
        """Return the slip without displacements at a vertical approach [mm], shape (n_x, n_s, 2)."""
        if self.per_approach is None:
            return self.given
        along_s = (approach - self.approach_before) * self.per_approach
        return self.given + along_s[:, None] * [0.0, 1.0]

    def _on_elements(self, take: Callable[[Array], Array], size: int) -> Self:
        moved, sines = super()._on_elements(take, size), self.per_approach
        if sines is not None:
            sines = take(np.broadcast_to(sines, self.rigid.shape[:2]))[0]
        return replace(moved, before=None if self.before is None else take(self.before), per_approach=sines)


@dataclass(frozen=True, eq=False)
class SteadyRolling(Motion):
    """Steady rolling on elements of length `dx` [mm], with an error of order 1 or 2 in it.

    Of order 2, `followers` elements at the leading edge of each row follow the one behind them.
    """

    dx: float = field(kw_only=True)
    order: int = 2
    followers: int = DEPTH

    def __post_init__(self) -> None:
        if self.order not in (1, 2):
            raise WrongInput(f"order = {self.order!r}: 1 or 2")

    @property
    def depth(self) -> int:  # type: ignore[override]
        """Elements of a leading edge that follow others."""
        return self.followers if self.order > 1 else 0

    @property
    def simpler(self) -> Self | None:
        """The same with fewer elements of a leading edge that follow others, None if there are none."""
        return replace(self, followers=self.depth - 1) if self.depth else None

    def elastic_slip(self, u: Array) -> Array:
        """Return the part of slip that is linear in displacements, shape (n_x, n_s, 2)."""
        return (u - ahead(u)) / self.dx

    def at_elements(self, slip: Array) -> Array:
        """Return the slip at the centres of elements, from that ahead and that behind them."""
        return slip if self.order == 1 else centred(slip)

    def derivative_at_elements(self, slip: Array) -> Linear:
        """Return the derivative of it at a slip: a linear function of changes of this."""
        return super().derivative_at_elements(slip) if self.order == 1 else centred_derivative(slip)

    def half_way(self, rigid: Array) -> Array:
        """Return the rigid slip half way to the next elements; of order 1 at the elements."""
        return rigid if self.order == 1 else (rigid + ahead(rigid)) / 2

    def _on_elements(self, take: Callable[[Array], Array], size: int) -> Self:
        return replace(super()._on_elements(take, size), dx=size * self.dx)


@dataclass(frozen=True, eq=False)
class RollingStep(SteadyRolling):
    """A step of rolling by the length of an element, from displacements `before` (n_x, n_s, 2) [mm]."""

    before: Array | None = None
    has_coarser = False  # the step is as long as an element

    def elastic_slip(self, u: Array) -> Array:
        """Return the part of slip that is linear in displacements, shape (n_x, n_s, 2)."""
        return u / self.dx

    @property
    def given(self) -> Array:
        """The slip without displacements, shape (n_x, n_s, 2)."""
        before = 0.0 if self.before is None else ahead(self.before) / self.dx
        return super().given - before

    def _on_elements(self, take: Callable[[Array], Array], size: int) -> Self:
        before = None if self.before is None else take(self.before)
        return replace(super()._on_elements(take, size), before=before)


def ahead(values: Array) -> Array:
    """Return the values of the next elements along x; the last ones have their own."""
    return np.concatenate([values[1:], values[-1:]])
