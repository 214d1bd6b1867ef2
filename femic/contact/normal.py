"""Contact without friction on a curvilinear grid, with any ICs: conjugate gradients for pressures.

The gap along the normals of the lower surface is g = S p + h - zeta c with c = cos(delta), h the undeformed
distance and zeta the vertical approach. Pressures only push the surfaces apart: p >= 0, g >= 0, p g = 0.
Where the load is given, the sum of c p, this is the minimum of p S p / 2 + h p, and zeta is the multiplier of
the load; where the approach is given, it is that of p S p / 2 + (h - zeta c) p. Source: [BVSV] section 6;
docs/theory/contact.md.

The method is that of Polonsky and Keer (1999), Wear 231, 206-219, preconditioned as by Vollebregt (2014),
Journal of Computational Physics 257, 333-351. Elements with overlap join at once, with the next direction,
and where the load is given, directions do not change it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from femic.contact.estimates import SlipState
from femic.contact.loading import Loading
from femic.contact.operators.convolution import Convolution
from femic.contact.operators.protocols import Operator
from femic.contact.patch import MARGIN, Extent, block_mean, extents, near_ends
from femic.contact.small import SmallContact, solve_normal
from geometries.arrays import Array, Mask
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid

# --- pressures of least energy ---

TOLERANCE = 1e-7  # of pressures, as a share of the largest
MOST_ITERATIONS = 500

Linear = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Bounded:
    """The problem: S and its approximate inverse on the whole grid, h and c, shape (n_x, n_s) each.

    h is infinite where no contact is possible.
    """

    compliance: Linear
    inverse: Linear
    h: Array
    c: Array


@dataclass(frozen=True, eq=False)
class PressureSolution:
    """Pressures and gaps, shape (n_x, n_s), the approach, and how they were found.

    `error` is the largest estimated error of a pressure as a share of the largest pressure.
    """

    p: Array
    gap: Array
    approach: float
    iterations: int
    products: int
    error: float


def pressures(
    problem: Bounded,
    *,
    load: float | None = None,
    approach: float | None = None,
    start: Array | None = None,
    tolerance: float = TOLERANCE,
) -> PressureSolution:
    """Solve for a given load, the sum of c p [MPa], or for a given approach [mm].

    `start` are pressures to begin with. Raises Failure where S is not positive for the pressures in question,
    and where `MOST_ITERATIONS` do not suffice. A load must be positive, and h finite somewhere.
    """
    if (load is None) == (approach is None):
        raise ValueError("give either load or approach")
    h, c, possible = problem.h, problem.c, np.isfinite(problem.h)

    def scaled(p: Array) -> Array:
        """Return pressures with the load, if it is given."""
        return p if load is None else p * (load / np.vdot(c, p))

    p = np.zeros(h.shape) if start is None else np.where(possible, np.maximum(start, 0), 0.0)
    if not np.any(p) and approach is not None:
        overlap = np.where(possible, np.maximum(approach * c - h, 0), 0.0)
        p = np.where(possible, np.maximum(problem.inverse(overlap), 0), 0.0)
    elif not np.any(p):
        p = np.where(possible, 1.0, 0.0)
    p = scaled(p)
    u, products = problem.compliance(p), 1
    direction = last_z = last_residual = np.zeros_like(h)
    last_active, active_c, inverse_c = np.zeros(h.shape, bool), np.zeros_like(h), np.zeros_like(h)
    for iteration in range(MOST_ITERATIONS + 1):
        zeta = approach
        if zeta is None:  # with which the gaps in contact have no component along c
            pressed_c = np.where(p > 0, c, 0.0)
            zeta = float(np.vdot(pressed_c, u + np.where(p > 0, h, 0.0)) / np.vdot(pressed_c, pressed_c))
        gap = u + h - zeta * c
        active = possible & ((p > 0) | (gap < 0))
        residual = np.where(active, gap, 0.0)
        z = np.where(active, problem.inverse(residual), 0.0)
        if load is not None:  # directions do not change it
            if not np.array_equal(active, last_active):
                active_c = np.where(active, c, 0.0)
                inverse_c = np.where(active, problem.inverse(active_c), 0.0)
            z = z - inverse_c * (np.vdot(active_c, z) / np.vdot(active_c, inverse_c))
        largest, peak = float(np.max(np.abs(z))), float(np.max(p))
        error = largest / peak if peak > 0 else np.inf if largest else 0.0  # inf: pressures are to come
        if error <= tolerance:
            return PressureSolution(p, gap, zeta, iteration, products, error)
        beta = 0.0
        if np.array_equal(active, last_active):
            beta = max(0.0, float(np.vdot(z, residual - last_residual) / np.vdot(last_z, last_residual)))
        direction = z + beta * direction
        last_z, last_residual, last_active = z, residual, active
        v = problem.compliance(direction)
        curvature = float(np.vdot(direction, v))
        if not curvature > 0:
            raise Failure(
                "pressures: the ICs are not positive for pressures that the contact needs "
                f"(p S p = {curvature:.2e} mm MPa); check their eigenvalues"
            )
        length = float(np.vdot(residual, direction)) / curvature  # to the least energy
        p, u, products = p - length * direction, u - length * v, products + 1
        if np.any(p < 0):
            p = scaled(np.maximum(p, 0))
            u, products = problem.compliance(p), products + 1
    raise Failure(
        f"pressures: after {MOST_ITERATIONS} iterations their error is estimated at {error:.1e} of the "
        f"largest, not {tolerance:.1e}; use smaller elements or a smaller potential contact area"
    )


# --- contact on a grid ---

COARSEST = 4  # elements along x or s below which pressures are not sought on a coarser grid first


class PotentialAreaTooSmall(Failure):
    """A contact under `loading` that comes too near to some ends of its grid: `ends`, of `ENDS`.

    `ics` is the name of its ICs, where it is known.
    """

    def __init__(self, ends: tuple[str, ...], loading: Loading, ics: str = "") -> None:
        super().__init__(
            f"potential contact area: the contact comes closer than {MARGIN} elements to the edge of the "
            f"grid at {' and '.join(ends)}; make the grid longer there, or the load smaller"
        )
        self.ends, self.loading, self.ics = ends, loading, ics

    @property
    def contact(self) -> str:
        """The contact in words."""
        return f"contact at {self.loading}" + (f" with {self.ics}" if self.ics else "")


@dataclass(frozen=True, eq=False)
class NormalProblem:
    """Two bodies on a grid: their nn ICs, undeformed distance, and how they come together.

    `distance` [mm], (n_x, n_s), is infinite where no contact is possible; `cosine` (n_s,) is cos(delta);
    `flat` are nn ICs of half-spaces, whose inverse is a preconditioner. Raises WrongInput for shapes that do
    not fit, and for distances that are not numbers or infinite everywhere.
    """

    grid: Grid
    operator: Operator
    flat: Convolution
    distance: Array
    cosine: Array

    def __post_init__(self) -> None:
        n_x, n_s = self.grid.n_x, self.grid.n_s
        if np.shape(self.distance) != (n_x, n_s) or np.shape(self.cosine) != (n_s,):
            raise WrongInput(
                f"distance of shape {np.shape(self.distance)}, cosine of shape {np.shape(self.cosine)}: "
                f"{(n_x, n_s)} and {(n_s,)} are needed"
            )
        if np.any(np.isnan(self.distance)):
            raise WrongInput("distance: some are not numbers")
        if not np.any(np.isfinite(self.distance)):
            raise WrongInput("distance: infinite everywhere, so that no contact is possible")

    @cached_property
    def coarsened(self) -> "NormalProblem":
        """The problem on elements twice as large, the same pressure on four at a time."""
        grid = self.grid
        return NormalProblem(
            Grid(grid.n_x // 2, grid.n_s // 2, 2 * grid.dx, 2 * grid.ds, grid.s),
            self.operator.coarsened(),
            self.flat.coarsened(),
            block_mean(self.distance),
            self.cosine.reshape(-1, 2).mean(axis=1),
        )

    @property
    def small(self) -> SmallContact | None:
        """The contact for compiled loops, None if the grid is large."""
        return SmallContact.make(self.operator, self.flat, self.distance, self.cosine, self.grid.area)

    @property
    def bounded(self) -> Bounded:
        """The problem in terms of pressures alone."""

        def compliance(p: Array) -> Array:
            return self.operator(p[..., None])[..., 0]

        def inverse(u: Array) -> Array:
            return self.flat.ring_inverse(u[..., None])[..., 0]

        c = np.broadcast_to(self.cosine, self.distance.shape)
        return Bounded(compliance, inverse, self.distance, c)

    @property
    def has_coarser(self) -> bool:
        """Whether the grid can be made of elements twice as large, with contact possible on some."""
        sizes = self.grid.n_x, self.grid.n_s
        even = all(n % 2 == 0 and n >= 2 * COARSEST for n in sizes)
        return even and bool(np.any(np.isfinite(block_mean(self.distance))))


@dataclass(frozen=True, eq=False)
class NormalContact:
    """Pressures [MPa] and gaps [mm] of a contact, (n_x, n_s), and what follows from them.

    `begun_on` is the same contact on elements twice as large if the solution began there; otherwise `loading`
    and `tolerance` say how it is found when it is asked for (`coarser`).
    """

    problem: NormalProblem
    solution: PressureSolution
    begun_on: "NormalContact | None"
    loading: Loading | None = None
    tolerance: float = TOLERANCE

    @cached_property
    def coarser(self) -> "NormalContact | None":
        """The same contact on elements twice as large, None where the grid is too small for that."""
        if self.begun_on is not None or self.loading is None or not self.problem.has_coarser:
            return self.begun_on
        start = block_mean(self.p)
        return _solve_from_coarser(self.problem.coarsened, self.loading, start, self.tolerance)

    @property
    def p(self) -> Array:
        """Pressures [MPa], shape (n_x, n_s)."""
        return self.solution.p

    @property
    def pressures(self) -> Array:
        """Pressures [MPa], shape (n_x, n_s)."""
        return self.p

    @property
    def tractions(self) -> Array:
        """Tractions on the upper body [MPa], shape (n_x, n_s, 3): pressures alone."""
        return self.p[..., None] * [0.0, 0.0, 1.0]

    @property
    def gap(self) -> Array:
        """Gaps [mm] of the deformed bodies, shape (n_x, n_s); 0 in contact."""
        return np.where(self.in_contact, 0.0, self.solution.gap)

    @property
    def in_contact(self) -> Mask:
        """The elements in contact, shape (n_x, n_s)."""
        return self.p > 0

    @property
    def approach(self) -> float:
        """Vertical approach [mm]."""
        return self.solution.approach

    @property
    def load(self) -> float:
        """Vertical load [N]."""
        return float(np.sum(self.problem.cosine * self.p) * self.problem.grid.area)

    @property
    def area(self) -> float:
        """Contact area [mm^2]."""
        return float(np.count_nonzero(self.in_contact) * self.problem.grid.area)

    @cached_property
    def patches(self) -> list[Extent]:
        """The contact patches, from the left to the right."""
        return extents(self.p, self.gap)

    @property
    def slip_state(self) -> SlipState:
        """Pressures alone: where they act, all slides without friction."""
        none = np.zeros((*self.p.shape, 2))
        return SlipState(self.tractions, none[..., 0] > 0, none, 0.0)

    @property
    def largest_work(self) -> float:
        """Work of friction: none."""
        return 0.0

    @property
    def energy(self) -> float:
        """Elastic energy [N mm]: half of the work of the pressures on displacements."""
        u = self.problem.bounded.compliance(self.p)
        return float(np.sum(self.p * u) * self.problem.grid.area / 2)

    @cached_property
    def stiffness(self) -> float:
        """Derivative of the load by the approach [N/mm], with the contact area as it is."""
        bounded, mask = self.problem.bounded, self.in_contact
        shape, size = mask.shape, mask.size

        def masked(linear: Linear) -> LinearOperator:
            def applied(v: Array) -> Array:
                inner = v.reshape(shape)
                return np.where(mask, linear(np.where(mask, inner, 0.0)), inner).ravel()

            return LinearOperator((size, size), matvec=applied, dtype=float)

        c = np.where(mask, bounded.c, 0.0)
        q, failed = cg(
            masked(bounded.compliance), c.ravel(), rtol=TOLERANCE, M=masked(bounded.inverse), maxiter=1000
        )
        if failed:
            raise Failure("derivative of the load by the approach: no convergence; are the ICs positive?")
        return float(c.ravel() @ q * self.problem.grid.area)


def solve(
    problem: NormalProblem,
    *,
    load: float | None = None,
    approach: float | None = None,
    start: Array | None = None,
    tolerance: float = TOLERANCE,
) -> NormalContact:
    """Return the contact at a vertical load [N] or approach [mm]; `start` are pressures to begin with.

    Raises WrongInput as `Loading`, and Failure as `pressures` does and where the contact
    comes closer than `MARGIN` elements to an end of the grid, with the ends named.
    """
    loading = Loading(load, approach)
    contact = _solve_from_coarser(problem, loading, start, tolerance)
    if ends := near_ends(contact.in_contact):
        raise PotentialAreaTooSmall(ends, loading)
    return contact


def _solve_from_coarser(
    problem: NormalProblem, loading: Loading, start: Array | None, tolerance: float
) -> NormalContact:
    coarser, load = None, loading.load
    if (small := problem.small) and (found := solve_normal(small, loading, start, tolerance)):
        return NormalContact(problem, PressureSolution(*found), None, loading, tolerance)
    if problem.has_coarser:
        coarse_start = None if start is None else block_mean(start)
        coarser = _solve_from_coarser(problem.coarsened, loading, coarse_start, tolerance)
        if start is None:
            start = coarser.p.repeat(2, axis=0).repeat(2, axis=1)
    load = None if load is None else load / problem.grid.area
    solution = pressures(
        problem.bounded, load=load, approach=loading.approach, start=start, tolerance=tolerance
    )
    return NormalContact(problem, solution, coarser)
