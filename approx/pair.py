"""Approximations of the ICs of a body, and of the displacement difference of two bodies in contact.

They are given at points, and on a grid for all pairs of elements, sorted by lag along x and by strips.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from approx.effective import EffectiveProperties
from approx.forms import FORMS, Form, Ingredients
from approx.halfspace import HalfSpace, observers
from approx.variants import assemble, needed_forms
from geometries.arrays import Array
from geometries.materials import ElasticConstants, Material, both_bodies, one_body
from geometries.patches import Grid, Patch
from geometries.surfaces import Surface

Points = tuple[ArrayLike, ArrayLike]


# --- at points ---


@dataclass(frozen=True)
class Solid:
    """What approximations need of a body; `effective` are the properties of its B-hat-prime."""

    material: Material
    surface: Surface
    effective: EffectiveProperties | None = None

    @property
    def constants(self) -> ElasticConstants:
        """Elastic constants of this body alone."""
        return one_body(self.material, self.surface.side)

    @property
    def half_space(self) -> HalfSpace:
        """The half-space of the same material."""
        return HalfSpace(self.constants, effective=self.effective)

    def approximate(self, variant: str, patch: Patch, points: Points) -> Array:
        """ICs of this body per unit pressure [mm/MPa], shape (3, 3, ...): `approx.variants.approximate`."""
        return self.approximations([variant], patch, points)[variant]

    def approximations(self, variants: Sequence[str], patch: Patch, points: Points) -> dict[str, Array]:
        """ICs of several variants, each as of `approximate`; what they have in common is computed once."""
        return assemble(variants, self.by_form(needed_forms(variants), patch, points))

    def by_form(self, forms: Iterable[Form], patch: Patch, points: Points) -> dict[Form, Array]:
        """ICs of several forms per unit pressure [mm/MPa], shape (3, 3, ...) each."""
        return Ingredients(self.half_space, self.surface, patch, *observers(*points)).by_form(forms)

    def curvature(self, patch: Patch, points: Points, form: Form = FORMS["Bhat"]) -> Array:
        """Part of the ICs [mm/MPa] due to the curvature of the body along x, (3, 3, ...); 0 if prismatic."""
        prismatic = replace(self, surface=self.surface.prismatic)
        curved, straight = (body.by_form([form], patch, points)[form] for body in (self, prismatic))
        return curved - straight


@dataclass(frozen=True)
class Pair:
    """Upper and lower body; `effective` are the properties of their combined B-hat-prime."""

    upper: Solid
    lower: Solid
    effective: EffectiveProperties | None = None
    curvature_apart: bool = False

    @property
    def constants(self) -> ElasticConstants:
        """Combined elastic constants."""
        return both_bodies(self.upper.material, self.lower.material)

    @property
    def half_space(self) -> HalfSpace:
        """Both bodies as half-spaces of the combined constants."""
        return HalfSpace(self.constants, effective=self.effective)

    def approximate(self, variant: str, patch: Patch, points: Points) -> Array:
        """ICs per unit pressure [mm/MPa], shape (3, 3, ...): the sum over both bodies, each with its T.

        Where combined effective properties are given, B-hat-prime, and components that a variant takes from
        it, are computed from the combined constants on the contour of the lower body. The properties then
        represent everything else, also the curvature of wheels along x; with `curvature_apart` the effect of
        this curvature on B-hat of each body is added instead. Source: [BVSV] section 4; docs/theory/ics.md.
        """
        return self.approximations([variant], patch, points)[variant]

    def approximations(self, variants: Sequence[str], patch: Patch, points: Points) -> dict[str, Array]:
        """ICs of several variants, each as of `approximate`; what they have in common is computed once."""
        return assemble(variants, self.by_form(needed_forms(variants), patch, points))

    def by_form(self, forms: Iterable[Form], patch: Patch, points: Points) -> dict[Form, Array]:
        """ICs of several forms per unit pressure [mm/MPa], shape (3, 3, ...) each."""
        forms = list(forms)
        combined = [form for form in forms if self.effective and form.effective]
        summed = [form for form in forms if form not in combined]
        upper, lower = (body.by_form(summed, patch, points) for body in (self.upper, self.lower))
        surface = self.lower.surface.prismatic
        ics = Ingredients(self.half_space, surface, patch, *observers(*points)).by_form(combined)
        if self.curvature_apart:
            ics = {form: ics[form] + self.curvature(patch, points, Form(form.rotate)) for form in combined}
        return ics | {form: upper[form] + lower[form] for form in summed}

    def curvature(self, patch: Patch, points: Points, form: Form = FORMS["Bhat"]) -> Array:
        """Part of the ICs [mm/MPa] due to the curvature of both bodies along x, shape (3, 3, ...)."""
        return self.upper.curvature(patch, points, form) + self.lower.curvature(patch, points, form)

    def has_effective(self, body: str) -> bool:
        """Whether B-hat-prime of "upper", "lower" or "combined" can be computed."""
        by_body = {"upper": bool(self.upper.effective), "lower": bool(self.lower.effective)}
        return by_body[body] if body in by_body else bool(self.effective) or all(by_body.values())


# --- on a grid ---


def column(variant: str, solid: Solid | Pair, grid: Grid, strip: int) -> Array:
    """ICs per unit traction on one strip [mm/MPa] at all lags and strips, shape (3, 3, n_x, n_s)."""
    return columns([variant], solid, grid, strip)[variant]


def columns(variants: Sequence[str], solid: Solid | Pair, grid: Grid, strip: int) -> dict[str, Array]:
    """Return the columns of several variants; what they have in common is computed once."""
    return solid.approximations(variants, grid.patch(strip), (grid.lags[:, None], grid.strips))


def matrix(variant: str, solid: Solid | Pair, grid: Grid) -> Array:
    """Return the IC matrix [mm/MPa], (n_x, n_s, n_s, 3, 3): lag, observing and loaded strip, directions."""
    by_strip = [column(variant, solid, grid, strip) for strip in range(grid.n_s)]
    return np.moveaxis(np.stack(by_strip), (0, 1, 2, 3, 4), (2, 3, 4, 0, 1))
