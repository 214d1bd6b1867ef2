"""Bodies: the solids behind contact surfaces, their materials, and the part of them that is modelled."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import ArrayLike

from geometries.arrays import Array, Mask
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.outlines import SectionOutline, check_outline
from geometries.surfaces import Surface

HUB_SHARE = 0.2  # default hub radius, and the smallest one, as a share of the rolling radius
ON_SUPPORT = (
    1e-6  # share of the far radius, or of the depth, by which a point on the far arc or hub may miss it
)
END_SAMPLES = 4001  # arc lengths among which the end of a section is sought


@dataclass(frozen=True)
class Domain:
    """The part of a body that is modelled: clamped at the far arc, both ends and the hub, free elsewhere.

    far_radius [mm] is the radius of the far arc about the contact centre. half_length [mm] is the extent
    along +x and along -x, on a body of revolution along the rolling circle of s = 0; it is infinite where the
    body has no ends: an infinitely long prismatic body, or a complete body of revolution.

    A boundary that is given (`radius_given`, `length_given`) is a support of the body and stays where it is.
    Another one stands for a body without end, and is moved away until it does not matter.
    """

    far_radius: float
    half_length: float
    radius_given: bool = False
    length_given: bool = False

    def __post_init__(self) -> None:
        if not (self.far_radius > 0 and self.half_length > 0):
            raise WrongInput(
                f"far_radius = {self.far_radius!r}, half_length = {self.half_length!r}: must be positive [mm]"
            )

    def scaled(self, factor: float) -> "Domain":
        """Return the domain with boundaries that are not given moved away, `factor` times as far."""
        return replace(
            self,
            far_radius=self.far_radius * (1 if self.radius_given else factor),
            half_length=self.half_length * (1 if self.length_given else factor),
        )


@dataclass(frozen=True)
class Body:
    """A prismatic body, or one of revolution about the line x = 0, z = side * rolling_radius.

    The side is +1 for the upper body, which fills n > 0, and -1 for the lower one. rolling_radius [mm] is
    the radius of the circle through the contact centre, infinite on a prismatic body. The section ends at
    hub_radius [mm], where it is clamped; None stands for the default.

    With an `outline` the section has the shape and the supports of the outline, and neither far arc nor hub:
    its size takes the place of the far radius, whatever the domain says.
    """

    side: int
    contour: Contour
    material: Material
    domain: Domain
    rolling_radius: float = np.inf
    hub_radius: float | None = None
    outline: SectionOutline | None = None

    def __post_init__(self) -> None:
        surface = self.surface  # checks the rolling radius
        if self.outline is not None:
            self._check(self.outline)
            object.__setattr__(self, "domain", replace(self.domain, far_radius=self.outline.size))
        if self.hub_radius is not None and np.isinf(surface.rolling_radius):
            raise WrongInput(
                f"hub_radius = {self.hub_radius!r}: a prismatic body has no hub; give rolling_radius"
            )
        if self.hub_radius is not None and not HUB_SHARE * self.rolling_radius <= self.hub_radius:
            raise WrongInput(
                f"hub_radius = {self.hub_radius!r}: at least {HUB_SHARE:g} rolling_radius "
                f"({HUB_SHARE * self.rolling_radius:g} mm)"
            )
        if not self.depth > 0:
            raise WrongInput(f"hub_radius = {self.hub_radius!r}: must be smaller than rolling_radius")

    def _check(self, outline: SectionOutline) -> None:
        """Raise WrongInput for an outline that does not fit the body."""
        if self.hub_radius is not None:
            raise WrongInput(
                f"hub_radius = {self.hub_radius!r}: the outline defines where the body is clamped; leave "
                "hub_radius out"
            )
        check_outline(outline, self.contour, self.side)
        highest = float(np.max(self.side * outline.corners[1]))
        if highest > (1 - HUB_SHARE) * self.rolling_radius:
            raise WrongInput(
                f"outline.points: go to {self.rolling_radius - highest:g} mm from the axis; keep at least "
                f"{HUB_SHARE:g} rolling_radius ({HUB_SHARE * self.rolling_radius:g} mm) away from it"
            )

    @property
    def surface(self) -> Surface:
        """The contact surface."""
        return Surface(self.side, self.contour, self.rolling_radius)

    @property
    def depth(self) -> float:
        """Height [mm] between contact centre and hub; infinite on a prismatic body."""
        if np.isinf(self.rolling_radius):
            return np.inf
        if self.outline is not None:
            return float(np.max(self.side * self.outline.corners[1]))
        return self.rolling_radius - (self.hub_radius or HUB_SHARE * self.rolling_radius)

    @property
    def truncated(self) -> bool:
        """Whether a boundary of the model stands for a body without end, and is no support of its own."""
        domain = self.domain
        ends = np.isfinite(domain.half_length) and not domain.length_given
        return self.outline is None and bool(ends or not domain.radius_given)

    @property
    def reaches_hub(self) -> bool:
        """Whether the modelled section reaches the hub."""
        return self.depth < self.domain.far_radius

    @property
    def extent(self) -> tuple[float, float]:
        """Arc lengths [mm] between which loads and lines may lie."""
        return self.contour.extent if self.outline is None else self.s_range

    @property
    def symmetric(self) -> bool:
        """Whether the section is its own mirror image in y -> -y, supports included."""
        return self.contour.symmetric and (self.outline is None or self.outline.symmetric)

    def on_supports(self, y: Array, z: Array) -> tuple[Mask, ...]:
        """For each support, whether points (y, z) [mm] of the section lie on it, shape of y each."""
        if self.outline is not None:
            return self.outline.on_clamped_edges(y, z)
        on_far_arc = np.hypot(y, z) > (1 - ON_SUPPORT) * self.domain.far_radius
        return on_far_arc, self.side * z > (1 - ON_SUPPORT) * self.depth

    @property
    def closed(self) -> bool:
        """Whether the model is a complete body of revolution."""
        return bool(
            np.isfinite(self.rolling_radius) and self.domain.half_length >= np.pi * self.rolling_radius
        )

    @property
    def xi_end(self) -> float:
        """Chart coordinate [mm] at which the model ends."""
        return min(self.domain.half_length, np.pi * self.rolling_radius)

    def enlarged(self, factor: float) -> "Body":
        """Return the body in a domain `factor` times as large, but for boundaries that are given."""
        return replace(self, domain=self.domain.scaled(factor))

    @property
    def s_range(self) -> tuple[float, float]:
        """Arc lengths [mm] at which the contour meets far arc, hub or outline, on the left and right."""
        if self.outline is not None:
            return self.outline.contour_ends(self.contour)
        return section_end(self, -1), section_end(self, +1)


@lru_cache(maxsize=64)
def section_end(body: Body, direction: int) -> float:
    """Arc length [mm] at which the contour meets the far arc or the hub, for direction +1 at s > 0."""
    far, contour = body.domain.far_radius, body.contour
    limit = contour.limits[1 if direction > 0 else 0]

    def beyond(s: ArrayLike) -> Array:
        y, z = contour.position(s)
        return np.asarray(np.maximum(np.hypot(y, z) - far, body.side * z - body.depth))

    samples = np.linspace(0, limit + direction * 2 * far, END_SAMPLES)
    outside = int(np.argmax(beyond(samples) > 0))
    return float(
        scipy.optimize.brentq(lambda s: float(beyond(s)), samples[outside - 1], samples[outside], xtol=1e-12)
    )


def common_extent(bodies: Mapping[str, Body]) -> tuple[float, float]:
    """Return the range of arc lengths [mm] that the contours of all bodies cover."""
    starts, ends = zip(*(body.extent for body in bodies.values()), strict=True)
    return max(starts), min(ends)
