"""The contact of two bodies on one pair of meshes, the numbers that follow from it, and its edges.

The bodies of a contact problem have the supports that contact with C gives them: the far arc of the problem,
on which both are clamped. A body without end along x is meshed as far as its far arc screens what lies
beyond.

The edges of a patch are interpolated between the vertices at which gaps are known. Beyond the edge of smooth
bodies the gap grows as distance^(3/2) at first, so gap^(2/3) is smooth, and vanishes at the edge. Near an end
of the patch it is fitted by c0 + c1 x + c2 x^2 + c3 y^2 (+ c4 y where nothing is symmetric), x along, y
across: that is a linear function with its first corrections, for the gap farther out and for the curvature of
the edge. Where the surface ends close beyond the patch there are too few vertices for c2: it is left out, and
no vertices are skipped. (Squared pressures do as well for Hertz's contact, and are worse in conformal ones,
where they rise steeply from the edge.)
"""

from dataclasses import dataclass, replace
from functools import cached_property
from time import perf_counter

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from femic.contact.finite_elements.bodies import Elastic, Expected, mesh_body
from femic.contact.finite_elements.coupling import CoupledBodies, couple, on_upper
from femic.contact.finite_elements.saddle import ActiveSetSolution, solve_active_set
from femic.contact.pairs.ics import c_job
from femic.contact.pairs.pair_on_grid import undeformed_surfaces
from femic.contact.specification import ContactProblem
from femic.contact.undeformed import Undeformed
from femic.reference.discount import FZ
from femic.reference.matrix.reference import matrices
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array
from geometries.bodies import Body, Domain
from geometries.errors import Failure
from geometries.patches import Grid

# --- contact on one pair of meshes ---

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
    def p(self) -> Array:
        """Pressures [MPa] at the vertices of `pair`, (m,); linear between them."""
        return np.where(self.solution.active, self.solution.state.p, 0.0)

    @property
    def gap(self) -> Array:
        """Gaps [mm] along the normals, means about the vertices, (m,); 0 in contact."""
        state = self.solution.state
        gap = self.pair.gap(state.u_lower, state.u_upper, state.approach) / self.pair.area
        return np.where(self.solution.active, 0.0, gap)

    @property
    def spacing(self) -> float:
        """Mean distance [mm] of vertices in contact."""
        return float(np.sqrt(np.mean(self.pair.area[self.solution.active])))

    @property
    def a(self) -> float:
        """Half-length of the patch along x [mm]."""
        return self._end(self.pair.x, self.pair.s, symmetric=self.bodies.half_section)

    @property
    def s_range(self) -> tuple[float, float]:
        """Arc lengths [mm] of the lower contour at which the patch ends."""
        high = self._end(self.pair.s, self.pair.x, symmetric=True)
        if self.bodies.half_section:
            return -high, high
        return -self._end(-self.pair.s, self.pair.x, symmetric=True), high

    def _end(self, along: Array, across: Array, *, symmetric: bool) -> float:
        """Return where the patch ends, by gaps beyond a joint only if there are no others.

        The curvature jumps at a joint of a contour: gaps beyond it do not tell where the edge before it is.
        """
        undeformed, points = self.bodies.undeformed, np.stack([self.pair.x, self.pair.s])
        t = on_upper(undeformed, points, undeformed.distance(*points))[1]
        piece = np.searchsorted(undeformed.lower.contour.joints, self.pair.s)
        piece = piece + np.searchsorted(undeformed.upper.contour.joints, t)
        smooth, gap = np.isin(piece, piece[self.solution.active]), self.gap
        try:
            return end(along[smooth], across[smooth], gap[smooth], self.spacing, symmetric=symmetric)
        except Failure:
            return end(along, across, gap, self.spacing, symmetric=symmetric)

    @property
    def load_of_pressures(self) -> float:
        """Vertical load [N] that the pressures carry."""
        return self._sum(self.pair.c)

    @property
    def lateral_force(self) -> float:
        """Force [N] of the pressures on the upper body along y; 0 where all is symmetric."""
        return 0.0 if self.bodies.half_section else self._sum(self.pair.sine)

    @property
    def moment(self) -> float:
        """Moment [N mm] of the pressures on the upper body about the x axis through the contact centre."""
        return 0.0 if self.bodies.half_section else self._sum(self.pair.arm)

    @property
    def centre_of_pressure(self) -> float:
        """Mean arc length [mm] of the pressures; 0 where all is symmetric."""
        if self.bodies.half_section:
            return 0.0
        return self._sum(self.pair.s_moment) / self._sum(self.pair.area)

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
        state, share = self.solution.state, self.bodies.share
        lower, upper = self.pair.lower.reaction(state.u_lower), self.pair.upper.reaction(state.u_upper)
        return lower / share, upper / share

    @property
    def patch(self) -> Expected:
        """The patch found, for which finer meshes are made: half a spacing beyond the outermost vertices."""
        x, s = (along[self.solution.active] for along in (self.pair.x, self.pair.s))
        half = self.spacing / 2
        low = -s.max() if self.bodies.half_section else s.min()
        return Expected(float(x.max()) + half, (float(low) - half, float(s.max()) + half))


def mesh_bodies(bodies: Bodies, expected: Expected, cells: float) -> Meshes:
    """Mesh both bodies for a patch, with `cells` cells along its shorter half-length.

    That of the upper body has the arc lengths opposite; it is only moved where its ends are not opposite it.
    """
    start, undeformed = perf_counter(), bodies.undeformed
    ends = np.stack([np.zeros(2), expected.s])
    distance = undeformed.distance(*ends)
    if np.all(np.isfinite(distance)):
        low, high = on_upper(undeformed, ends, distance)[1]
    else:
        low, high = (s + undeformed.upper_offset for s in expected.s)
    lower, upper = (
        mesh_body(body, patch, cells, half_section=bodies.half_section)
        for body, patch in (
            (bodies.lower, expected),
            (bodies.upper, Expected(expected.a, (float(low), float(high)))),
        )
    )
    return Meshes(expected, cells, lower, upper, perf_counter() - start)


def solved(bodies: Bodies, meshes: Meshes, load: float, before: MeshedContact | None = None) -> MeshedContact:
    """Return the contact under a load [N] on some meshes; `before` is a coarser one to begin with.

    Pressures are sought near the expected patch, where surfaces may touch: on the given arc lengths, opposite
    the upper surface. Raises ZoneTooSmall where the contact is larger than expected, and Failure as `couple`
    and `solve_active_set` do.
    """
    start, expected = perf_counter(), meshes.expected
    x, s = meshes.lower.solid.trace.basis.mesh.p
    reach = ZONE + BEYOND / meshes.cells  # how far contact is sought, in half-lengths of the expected patch
    possible = (s >= bodies.s_range[0]) & (s <= bodies.s_range[1])
    possible[possible] &= np.isfinite(bodies.undeformed.distance(x[possible], s[possible]))
    sought = np.flatnonzero((expected.radius(x, s) < reach) & possible)
    pair = couple(meshes.lower, meshes.upper, bodies.undeformed, sought)
    if before is None:
        guess = expected.radius(pair.x, pair.s) < 1
    else:
        vertices = np.stack([before.pair.x, before.pair.s], 1)
        guess = LinearNDInterpolator(vertices, before.p, 0.0)(pair.x, pair.s) > 0
    solution = solve_active_set(pair, load * bodies.share, guess)
    contact = MeshedContact(bodies, meshes, load, pair, solution, perf_counter() - start + meshes.seconds)
    outermost = float(np.max(expected.radius(pair.x, pair.s)[solution.active]))
    if outermost > reach - MARGIN * contact.spacing / min(expected.a, expected.b):
        raise ZoneTooSmall(
            f"contact under {load:g} N: it reaches the end of the area in which it was sought, "
            f"{reach:g} times a = {expected.a:g}, b = {expected.b:g} mm; give a larger `expected`"
        )
    return contact


# --- bodies of a contact problem ---

LENGTH = 3.0  # of the meshed half of a body along x, in radii of its far arc


def supported_bodies(problem: ContactProblem) -> Bodies:
    """Return the bodies in their places, with the supports that C has, and ends that do not matter."""
    undeformed, radius = undeformed_surfaces(problem), problem.support_radius
    lower, upper = (
        replace(problem.bodies[name], domain=Domain(radius, LENGTH * radius)) for name in ("lower", "upper")
    )
    return Bodies(lower, upper, undeformed.s_range, undeformed.shift)


def rigid_compliance(problem: ContactProblem, options: RunOptions = DEFAULT) -> float:
    """M_zz [mm/N] of both bodies on their supports, which is subtracted from the approach of contact with C.

    It needs a model of each section with a single strip, the load under which it is matched. 0 where nothing
    is subtracted.
    """
    if problem.discount == "none":
        return 0.0
    side = 2 * problem.settings.approach_side
    jobs = {name: c_job(problem, name, Grid(1, 1, side, side), ("nn",)) for name in problem.bodies}
    references = matrices(jobs, options, combined=True)
    return sum(float(reference.discount[FZ, FZ]) for reference in references.values())


# --- edges of a patch ---

# The region of the fit, in spacings of vertices, from the outermost one in contact
DEPTH, WIDTH = 5.0, 2.5
LEAST_WIDTH = 0.2  # of the same region, as a share of the half-width of the patch
SKIPPED = 0.5  # spacings that are left out: weighted gaps of vertices there belong in part to the patch
SHORT = 2.5  # spacings to the end of the surface, within which the fit is linear in x, of all vertices
FEWEST, LEAST_DEPTH = 5, 0.4  # vertices of a fit; spacings between the first and the last of them
FARTHEST = 2.0  # spacings between the edge and the outermost vertex in contact


def end(along: Array, across: Array, gap: Array, spacing: float, *, symmetric: bool) -> float:
    """Return the largest coordinate `along` [mm] of the patch, from gaps [mm] at vertices, (n,) each.

    Gaps are 0 in contact; `spacing` [mm] is that of the vertices. `symmetric`: about across = 0. Raises
    Failure where vertices are too few or gaps tell no edge.
    """
    touching = gap <= 0
    last = float(along[touching].max())
    middle = 0.0 if symmetric else float(across[touching][np.argmax(along[touching])])
    width = max(WIDTH * spacing, LEAST_WIDTH * float(np.ptp(across[touching])))
    x, y = (along - last) / spacing, (across - middle) / spacing
    beyond = ~touching & (x > 0) & (x < DEPTH) & (np.abs(y) <= width / spacing)
    short = float(x[beyond].max(initial=0)) < SHORT
    near = beyond & (x > (0.0 if short else SKIPPED))
    if np.count_nonzero(near) < FEWEST or np.ptp(x[near]) < LEAST_DEPTH:
        raise Failure(
            f"edge of the patch: {np.count_nonzero(near)} vertices near it, side by side or less than "
            f"{FEWEST}; more cells, or a smaller load where the patch reaches the end of a contour"
        )
    x, y = x[near], y[near]
    squares = np.zeros_like(x) if short else x**2
    terms = np.stack([np.ones_like(x), x, squares, y**2, *([] if symmetric else [y])], axis=1)
    fit = np.asarray(np.linalg.lstsq(terms, gap[near] ** (2 / 3))[0], dtype=float)
    farthest, linear = 0.0, 0.0 if symmetric else fit[4]
    if not symmetric:  # the y at which the edge is farthest
        farthest = np.clip(-linear / (2 * fit[3]), -width / spacing, width / spacing)
    roots = np.roots([fit[2], fit[1], fit[0] + fit[3] * farthest**2 + linear * farthest])
    edges = [float(root.real) for root in roots if root.imag == 0 and abs(root) < FARTHEST]
    if not edges:
        raise Failure("edge of the patch: gaps do not fall to 0 there; more cells, or a smaller load")
    return last + spacing * min(edges, key=abs)
