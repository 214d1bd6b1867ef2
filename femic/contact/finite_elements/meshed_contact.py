"""The contact of two bodies on one pair of meshes, and the numbers that follow from it."""

from dataclasses import dataclass
from functools import cached_property
from time import perf_counter

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from femic.contact.finite_elements import extent
from femic.contact.finite_elements.active_set import ActiveSetSolution, solve_active_set
from femic.contact.finite_elements.bodies import Elastic, Expected, meshed
from femic.contact.finite_elements.coupling import Zone, couple, on_upper, zone_of
from femic.contact.finite_elements.saddle import CoupledBodies, coupled_bodies
from femic.contact.undeformed import Undeformed
from geometries.arrays import Array, Mask
from geometries.bodies import Body
from geometries.errors import Failure

MARGIN = 1.5  # spacings of vertices without contact that are needed around the patch
ZONE, BEYOND = 1.3, 3.0  # potential contact area: half-lengths of the expected patch, and cells beyond that


class ZoneTooSmall(Failure):
    """A contact that reaches the end of the area in which it was sought."""


@dataclass(frozen=True, eq=False)
class Bodies:
    """What is in contact: a prismatic lower body and an upper one, moved by `shift` [mm] along y.

    `s_range` [mm] are the arc lengths of the lower contour at which they may touch. Raises WrongInput as
    `Undeformed` does.
    """

    lower: Body
    upper: Body
    s_range: tuple[float, float]
    shift: float = 0.0

    def __post_init__(self) -> None:
        _ = self.undeformed

    @cached_property
    def undeformed(self) -> Undeformed:
        """The undeformed distance, which checks the input."""
        return Undeformed(self.upper.surface, self.lower.surface, self.s_range, self.shift)

    @property
    def half_section(self) -> bool:
        """Whether all is symmetric in y, so that y >= 0 is enough."""
        symmetric = self.lower.symmetric and self.upper.symmetric
        return bool(symmetric and self.shift == 0)

    @property
    def share(self) -> float:
        """Share of the bodies that is modelled."""
        return 0.25 if self.half_section else 0.5


@dataclass(frozen=True, eq=False)
class Meshes:
    """Both bodies, meshed for a patch with `cells` cells along its shorter half-length, and prepared."""

    expected: Expected
    cells: float
    lower: Elastic
    upper: Elastic
    seconds: float

    @property
    def reach(self) -> float:
        """How far contact is sought, in half-lengths of the expected patch."""
        return ZONE + BEYOND / self.cells


@dataclass(frozen=True, eq=False)
class MeshedContact:
    """A contact solved on one pair of meshes."""

    bodies: Bodies
    meshes: Meshes
    load: float  # [N], of the whole bodies
    pair: CoupledBodies
    solution: ActiveSetSolution
    seconds: float

    @property
    def zone(self) -> Zone:
        """The vertices at which pressures are known."""
        return self.pair.coupling.zone

    @property
    def p(self) -> Array:
        """Pressures [MPa] at the vertices of the zone, (m,); linear between them."""
        return np.where(self.solution.active, self.solution.state.p, 0.0)

    @property
    def gap(self) -> Array:
        """Gaps [mm] along the normals, means about the vertices, (m,); 0 in contact."""
        gap = self.pair.gap(self.solution.state) / self.pair.coupling.area
        return np.where(self.solution.active, 0.0, gap)

    @property
    def spacing(self) -> float:
        """Mean distance [mm] of vertices in contact."""
        return float(np.sqrt(np.mean(self.pair.coupling.area[self.solution.active])))

    @property
    def a(self) -> float:
        """Half-length of the patch along x [mm]."""
        return self._end(self.zone.x, self.zone.s, symmetric=self.bodies.half_section)

    @property
    def s_range(self) -> tuple[float, float]:
        """Arc lengths [mm] of the lower contour at which the patch ends."""
        high = self._end(self.zone.s, self.zone.x, symmetric=True)
        if self.bodies.half_section:
            return -high, high
        return -self._end(-self.zone.s, self.zone.x, symmetric=True), high

    def _end(self, along: Array, across: Array, *, symmetric: bool) -> float:
        """Return where the patch ends, by gaps beyond a joint only if there are no others."""
        smooth, gap = self._on_smooth_surfaces, self.gap
        try:
            return extent.end(along[smooth], across[smooth], gap[smooth], self.spacing, symmetric=symmetric)
        except Failure:
            return extent.end(along, across, gap, self.spacing, symmetric=symmetric)

    @property
    def _on_smooth_surfaces(self) -> Mask:
        """Which vertices lie between the same joints of both contours as the patch, or parts of it, (m,).

        The curvature jumps at a joint, so gaps beyond it do not tell where the edge before it is.
        """
        undeformed, s = self.bodies.undeformed, self.zone.s
        points = np.stack([self.zone.x, s])
        t = on_upper(undeformed, points, undeformed.distance(*points))[1]
        piece = np.searchsorted(undeformed.lower.contour.joints, s) + np.searchsorted(
            undeformed.upper.contour.joints, t
        )
        return np.asarray(np.isin(piece, piece[self.solution.active]))

    @property
    def load_of_pressures(self) -> float:
        """Vertical load [N] that the pressures carry."""
        return self._sum(self.pair.coupling.c)

    @property
    def lateral_force(self) -> float:
        """Force [N] of the pressures on the upper body along y; 0 where all is symmetric."""
        return 0.0 if self.bodies.half_section else self._sum(self.pair.coupling.sine)

    @property
    def moment(self) -> float:
        """Moment [N mm] of the pressures on the upper body about the x axis through the contact centre."""
        return 0.0 if self.bodies.half_section else self._sum(self.pair.coupling.arm)

    @property
    def centre_of_pressure(self) -> float:
        """Mean arc length [mm] of the pressures; 0 where all is symmetric."""
        if self.bodies.half_section:
            return 0.0
        return self._sum(self.pair.coupling.of_s) / self._sum(self.pair.coupling.area)

    def _sum(self, integrals: Array) -> float:
        """What the pressures on the whole bodies add up to, of integrals of the functions psi, (m,)."""
        return float(integrals @ self.p) / self.bodies.share

    @property
    def reactions(self) -> tuple[float, float]:
        """Vertical forces [N] of the supports of lower and upper body."""
        lower, upper = self.support_forces
        return float(lower[2]), float(upper[2])

    @property
    def support_forces(self) -> tuple[Array, Array]:
        """Forces [N] along x, y, z of the supports of the modelled part, over its share; (3,) by body."""
        state, of = self.solution.state, self.bodies.share
        lower, upper = self.pair.lower.reaction(state.u_lower), self.pair.upper.reaction(state.u_upper)
        return lower / of, upper / of

    @property
    def patch(self) -> Expected:
        """The patch found, for which finer meshes are made: half a spacing beyond the outermost vertices."""
        x, s = (along[self.solution.active] for along in (self.zone.x, self.zone.s))
        half = self.spacing / 2
        low = -s.max() if self.bodies.half_section else s.min()
        return Expected(float(x.max()) + half, (float(low) - half, float(s.max()) + half))

    def pressed_at(self, x: Array, s: Array) -> Mask:
        """Return whether pressures are positive at points (n,), from linear interpolation."""
        return np.asarray(
            LinearNDInterpolator(np.stack([self.zone.x, self.zone.s], 1), self.p, 0.0)(x, s) > 0
        )


def meshes_of(bodies: Bodies, expected: Expected, cells: float) -> Meshes:
    """Mesh both bodies for a patch, with `cells` cells along its shorter half-length."""
    start, half_section = perf_counter(), bodies.half_section
    patches = expected, opposite(bodies.undeformed, expected)
    lower, upper = (
        meshed(body, patch, cells, half_section=half_section)
        for body, patch in zip((bodies.lower, bodies.upper), patches, strict=True)
    )
    return Meshes(expected, cells, lower, upper, perf_counter() - start)


def opposite(undeformed: Undeformed, patch: Expected) -> Expected:
    """Return the patch in arc lengths of the upper contour; only moved where its ends are not opposite it."""
    ends = np.stack([np.zeros(2), patch.s])
    distance = undeformed.distance(*ends)
    if not np.all(np.isfinite(distance)):
        offset = undeformed.upper_offset
        return Expected(patch.a, (patch.s[0] + offset, patch.s[1] + offset))
    low, high = on_upper(undeformed, ends, distance)[1]
    return Expected(patch.a, (float(low), float(high)))


def solved(bodies: Bodies, meshes: Meshes, load: float, before: MeshedContact | None = None) -> MeshedContact:
    """Return the contact under a load [N] on some meshes; `before` is a coarser one to begin with.

    Raises ZoneTooSmall where the contact is larger than expected, and Failure as `couple` and
    `solve_active_set` do.
    """
    start, expected = perf_counter(), meshes.expected
    x, s = meshes.lower.solid.trace.basis.mesh.p
    zone = zone_of(meshes.lower.solid.trace, (expected.radius(x, s) < meshes.reach) & _possible(bodies, x, s))
    pair = coupled_bodies(
        meshes.lower, meshes.upper, couple(meshes.lower, meshes.upper, bodies.undeformed, zone)
    )
    guess = before.pressed_at(zone.x, zone.s) if before else expected.radius(zone.x, zone.s) < 1
    solution = solve_active_set(pair, load * bodies.share, guess, pair.at_rest())
    contact = MeshedContact(bodies, meshes, load, pair, solution, perf_counter() - start + meshes.seconds)
    outermost = float(np.max(expected.radius(zone.x, zone.s)[solution.active]))
    if outermost > meshes.reach - MARGIN * contact.spacing / min(expected.a, expected.b):
        raise ZoneTooSmall(
            f"contact under {load:g} N: it reaches the end of the area in which it was sought, "
            f"{meshes.reach:g} times a = {expected.a:g}, b = {expected.b:g} mm; give a larger `expected`"
        )
    return contact


def _possible(bodies: Bodies, x: Array, s: Array) -> Mask:
    """Return where surfaces may touch: on the given arc lengths, opposite the upper surface."""
    low, high = bodies.s_range
    within = (s >= low) & (s <= high)
    within[within] &= np.isfinite(bodies.undeformed.distance(x[within], s[within]))
    return np.asarray(within)
