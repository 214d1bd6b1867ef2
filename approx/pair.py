"""Two bodies in contact: approximations of one of them, or of the displacement difference of both."""

from collections.abc import Sequence
from dataclasses import dataclass

from numpy.typing import ArrayLike

from approx.effective import EffectiveProperties
from approx.halfspace import HalfSpace
from approx.variants import OF_EFFECTIVE, approximate, approximations, assembled, needed
from geometries.arrays import Array
from geometries.materials import ElasticConstants, Material, both_bodies, one_body
from geometries.patches import Patch
from geometries.surfaces import Surface

Points = tuple[ArrayLike, ArrayLike]


@dataclass(frozen=True)
class Solid:
    """A body for approximations; `effective` are the properties of its B-hat-prime."""

    material: Material
    surface: Surface
    effective: EffectiveProperties | None = None

    @property
    def constants(self) -> ElasticConstants:
        """Elastic constants of this body alone."""
        return one_body(self.material, self.surface.side)

    def approximate(self, variant: str, patch: Patch, points: Points) -> Array:
        """ICs of this body per unit pressure [mm/MPa], shape (3, 3, ...): `approx.variants.approximate`."""
        return self.approximations([variant], patch, points)[variant]

    def approximations(self, variants: Sequence[str], patch: Patch, points: Points) -> dict[str, Array]:
        """ICs by several variants, each as of `approximate`; what they have in common is computed once."""
        half_space = HalfSpace(self.constants, effective=self.effective)
        return approximations(variants, half_space, self.surface, patch, points)

    def curvature(self, patch: Patch, points: Points) -> Array:
        """Part of B-hat [mm/MPa] by the curvature of the body along x, shape (3, 3, ...); 0 if prismatic."""
        prismatic = Solid(self.material, self.surface.prismatic)
        return self.approximate("Bhat", patch, points) - prismatic.approximate("Bhat", patch, points)


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

    def approximate(self, variant: str, patch: Patch, points: Points) -> Array:
        """ICs per unit pressure [mm/MPa], shape (3, 3, ...): the sum over both bodies, each with its turns.

        Where combined effective properties are given, B-hat-prime, and components that a variant has from
        it, are those of the combined constants on the contour of the lower body. The properties stand for
        everything else, also for the curvature of wheels along x; with `curvature_apart` the effect of this
        curvature on B-hat of each body is added instead. Source: [BVSV] section 4; docs/theory/ics.md.
        """
        return self.approximations([variant], patch, points)[variant]

    def approximations(self, variants: Sequence[str], patch: Patch, points: Points) -> dict[str, Array]:
        """ICs by several variants, each as of `approximate`; what they have in common is computed once."""
        forms = needed(variants)
        of_pair = [form for form in forms if self.effective and form in OF_EFFECTIVE]
        summed = [form for form in forms if form not in of_pair]
        upper, lower = (body.approximations(summed, patch, points) for body in (self.upper, self.lower))
        by_form = {form: upper[form] + lower[form] for form in summed}
        if of_pair:
            by_form |= dict.fromkeys(of_pair, self._effective(patch, points))
        return {variant: assembled(variant, by_form) for variant in variants}

    def _effective(self, patch: Patch, points: Points) -> Array:
        """B-hat-prime by the combined effective properties [mm/MPa]."""
        half_space = HalfSpace(self.constants, effective=self.effective)
        prismatic = approximate("Bhat_prime", half_space, self.lower.surface.prismatic, patch, points)
        return prismatic + self.curvature(patch, points) if self.curvature_apart else prismatic

    def curvature(self, patch: Patch, points: Points) -> Array:
        """Part of B-hat [mm/MPa] by the curvature of both bodies along x, shape (3, 3, ...)."""
        return self.upper.curvature(patch, points) + self.lower.curvature(patch, points)

    def has_effective(self, body: str) -> bool:
        """Whether B-hat-prime of "upper", "lower" or "combined" can be computed."""
        of_bodies = {"upper": bool(self.upper.effective), "lower": bool(self.lower.effective)}
        return of_bodies[body] if body in of_bodies else bool(self.effective) or all(of_bodies.values())
