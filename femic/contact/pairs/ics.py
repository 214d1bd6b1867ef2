"""ICs of both bodies of a contact by name: C, approximations, and others that the caller gives.

C of each body is computed on the grid of the contact, and added without the approach of the pair. The
approach that is subtracted moves the bodies as the approach of a contact does, along z and without a turn:
tractions do not depend on it. (Each body's own would not cancel where contours differ: the bodies' M_zz are
large and of opposite signs, and normals at equal arc lengths are not parallel.)

C_nn must be positive for the pressures that a contact may have: otherwise it has several solutions
(`require_positive`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from types import MappingProxyType
from typing import Protocol, TypeVar

import numpy as np

from femic.contact.operators.approximations import approximate_operator, rolled
from femic.contact.operators.dense import PARITY, Asymmetry, GridOperator
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.specification import ContactProblem
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import MatrixReference, matrices, vertical
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array
from geometries.bodies import Domain
from geometries.errors import Failure, WrongInput
from geometries.patches import COMPONENTS, Grid, N, S, X

# --- jobs of C ---

ASPECTS = (0.01, 100.0)  # least and largest dx / ds of a grid of C


def needed_components(problem: ContactProblem) -> tuple[str, ...]:
    """Return the components of C that a contact needs."""
    return COMPONENTS if problem.specification.friction else ("nn",)


def c_jobs(
    problem: ContactProblem, on_grid: PairOnGrid, components: tuple[str, ...] | None = None
) -> dict[str, MatrixJob]:
    """Return the jobs of C of both bodies on a grid; the upper strips lie opposite, on their own contour.

    By default with the `components` that the contact needs. Raises WrongInput for slender elements.
    """
    grid, (least, largest) = on_grid.grid, ASPECTS
    if not least <= grid.dx / grid.ds <= largest:
        raise WrongInput(
            f"{problem.name}: C on elements of {grid.dx:g} x {grid.ds:g} mm: dx / ds is outside "
            f"{least:g} ... {largest:g}: give a [grid] of other elements, with contact.grid = 'scene'"
        )
    grids = {"lower": grid, "upper": on_grid.upper_grid}
    return {
        name: c_job(problem, name, grids[name], components or needed_components(problem))
        for name in problem.bodies
    }


def c_job(problem: ContactProblem, name: str, grid: Grid, components: tuple[str, ...]) -> MatrixJob:
    """Return the job of C of a body on a grid."""
    body = replace(problem.bodies[name], domain=domain_on(problem, grid))
    settings = replace(problem.settings, cells=None)
    return MatrixJob(body, grid, settings, components, (problem.discount,))


def domain_on(problem: ContactProblem, grid: Grid) -> Domain:
    """Return the domain of both bodies: its far arc is a support, but for the source's discount a far end.

    As a support it depends neither on the grid nor on the tolerance; where it is given it is one in any case.
    """
    given = any(body.domain.radius_given for body in problem.bodies.values())
    if given or problem.discount != "source":
        return Domain(problem.support_radius, np.inf, radius_given=given)
    least = problem.settings.engine.far_radius(problem.settings.tolerance, grid)
    return Domain(max(least, *(body.domain.far_radius for body in problem.bodies.values())), np.inf)


# --- C of each body, and the sum ---

ALL, NORMAL = (X, S, N), (N,)  # directions of tractions with friction, and without


@dataclass(frozen=True, eq=False)
class BodyICs:
    """C of a body on a grid [mm/MPa], shape (n_x, n_s, n_s, m, m) in m directions.

    `approach` [mm/MPa] is subtracted from the approach of the pair per vertical traction.
    """

    ics: Array
    approach: float = 0.0


def c_of_bodies(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions, directions: tuple[int, ...]
) -> tuple[dict[str, BodyICs], Array]:
    """C of each body, and the sum of their estimated errors [mm/MPa], (n_x, n_s, n_s, m, m).

    C of a body goes like 1 / E. Raises NotConverged as `femic.reference.matrix.reference.matrices`.
    """
    components = COMPONENTS if directions == ALL else ("nn",)
    references = matrices(c_jobs(problem, on_grid, components), options, combined=True)
    grid = on_grid.grid
    return body_ics(references, grid, directions), ics_estimate(references, grid, directions)


def ics_estimate(references: Mapping[str, MatrixReference], grid: Grid, directions: tuple[int, ...]) -> Array:
    """Return the sum of the estimated errors of both bodies' C [mm/MPa], (n_x, n_s, n_s, m, m)."""
    estimates = [
        _matrix([reference.column(strip).estimate for strip in range(grid.n_s)], grid, directions)
        for reference in references.values()
    ]
    return np.asarray(sum(estimates))


def sum_of_bodies(on_grid: PairOnGrid, bodies: Mapping[str, BodyICs], *, wheel_rolls: bool = False) -> Array:
    """Return the sum of the ICs of both bodies (n_x, n_s, n_s, m, m) [mm/MPa], less their approach."""
    lower, upper = bodies["lower"].ics, bodies["upper"].ics
    if wheel_rolls:
        upper = rolled(upper, on_grid.undeformed.upper, on_grid.upper_grid)
    moved = vertical(on_grid.undeformed.lower.contour, on_grid.grid.strips)[:, -lower.shape[-1] :]
    approach = sum(body.approach for body in bodies.values())
    return np.asarray(lower + upper - approach * np.einsum("ai,bj->abij", moved, moved))


def reciprocal(ics: Array) -> Array:
    """Return the mean of C(I, J) and C(J, I)^T, of ICs (n_x, n_s, n_s, m, m) in all directions or along n."""
    m = ics.shape[-1]
    return np.asarray((ics + PARITY[-m:, -m:] * np.swapaxes(np.swapaxes(ics, 1, 2), 3, 4)) / 2)


def body_ics(
    references: Mapping[str, MatrixReference], grid: Grid, directions: tuple[int, ...], variation: str = ""
) -> dict[str, BodyICs]:
    """Return C of bodies before their approach is subtracted, and this approach."""
    return {
        name: BodyICs(
            _matrix(
                [reference.paired_column(strip, variation) for strip in range(grid.n_s)], grid, directions
            ),
            grid.area * reference.approach(variation),
        )
        for name, reference in references.items()
    }


def _matrix(columns: list[Array], grid: Grid, directions: tuple[int, ...]) -> Array:
    """ICs [mm/MPa] (lag, observed, loaded, i, j) of columns (i, j, lag, observed) [mm/N]."""
    selected = [column[np.ix_(directions, directions)].astype(float) for column in columns]
    return np.asarray(grid.area * np.stack(selected, axis=-1).transpose(2, 3, 4, 0, 1))


# --- whether C_nn is positive ---

SAME = 1e-6  # difference of mirrored ICs over the largest, to which they are the same


def require_positive(problem: ContactProblem, on_grid: PairOnGrid, ic: Array) -> float:
    """Return the smallest eigenvalue of C_nn (n_x, n_s, n_s) for the pressures that a contact may have.

    It is divided by the least IC of an element on itself. Where loads are given these pressures are all those
    without vertical load, by which solutions may differ; where all is symmetric they are symmetric. Raises
    Failure where the eigenvalue is not positive: then no solution is the only one, nor stable.
    """
    freed = on_grid.cosine[None] if problem.specification.loads else np.zeros((0, on_grid.grid.n_s))
    symmetric = on_grid.symmetric and np.allclose(
        ic, ic[:, ::-1, ::-1], rtol=0, atol=SAME * np.max(np.abs(ic))
    )
    eigenvalue = smallest_eigenvalue(ic, freed, symmetric=symmetric)
    if eigenvalue > 0:
        return eigenvalue
    remedy = "Give a smaller engine.tolerance, or larger elements"
    if problem.discount == "source":
        remedy = (
            "This discount removes the bending of the sections from C, and at long distances it removes "
            "too much; use discount = 'approach'"
        )
    elif not problem.specification.loads:
        remedy += "; or loads instead of approaches"
    raise Failure(
        f"C_nn on {on_grid.grid.n_x} x {on_grid.grid.n_s} elements, discount = {problem.discount!r}: its "
        f"smallest eigenvalue is {eigenvalue:.2g} of the least IC of an element on itself: some pressures"
        f"{' without vertical load' if len(freed) else ''} would do negative work. {remedy}"
    )


def smallest_eigenvalue(ic: Array, freed: Array, *, symmetric: bool = False) -> float:
    """Return the smallest eigenvalue of nn ICs (n_x, n_s, n_s) over the least IC of an element on itself.

    It is that of pressures without resultant along the motions `freed` (n, n_s): a give in these is added, as
    large as the largest IC. `symmetric`: of pressures that are symmetric about the middle of the grid.
    """
    own = float(np.min(np.diagonal(ic[0])))
    give = float(np.max(np.abs(ic))) * freed.T @ freed
    constrained = ic + give
    if symmetric:  # of the strips of one half, and of the middle one
        n_s = ic.shape[1]
        half = (n_s + 1) // 2
        constrained = constrained[:, :half, :half] + constrained[:, :half, ::-1][..., :half]
        if n_s % 2:  # the middle strip is its own mirror image; its pressures count once
            constrained[..., -1] /= np.sqrt(2)
            constrained[:, -1] /= np.sqrt(2)
    whole = (constrained + np.swapaxes(constrained, 1, 2))[..., None, None] / 2
    return GridOperator.from_ics(whole, (N,)).smallest_eigenvalue() / own


# --- operators of contact ---


@dataclass(frozen=True, eq=False)
class ReferenceICs:
    """C of both bodies on a grid as an operator, the same with its estimated error added, and its quality."""

    operator: GridOperator
    perturbed: GridOperator
    estimate: float  # largest estimated error over the largest C_nn
    asymmetry: Asymmetry  # before the mean of C(I, J) and C(J, I)^T was taken
    eigenvalue: float  # smallest of C_nn over the least IC of an element on itself (`require_positive`)
    seconds: float


def approximation(on_grid: PairOnGrid, variant: str) -> FullOperator:
    """Return an approximation of the ICs of both bodies on their grid."""
    return approximate_operator(variant, on_grid.pair, on_grid.grid, upper_offset=on_grid.offset)


def normal_reference_ics(problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions) -> ReferenceICs:
    """C_nn of both bodies on a grid; raises Failure as `require_positive`."""
    start = perf_counter()
    ics, estimate = normal_ics(problem, on_grid, options)
    largest = float(np.max(np.abs(ics)))
    return ReferenceICs(
        normal_operator(ics),
        normal_operator(ics + estimate),
        float(np.max(estimate)) / largest,
        Asymmetry(float(np.max(np.abs(ics - np.swapaxes(ics, 1, 2)))) / largest, "nn"),
        require_positive(problem, on_grid, ics),
        perf_counter() - start,
    )


def full_reference_ics(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions, *, wheel_rolls: bool
) -> ReferenceICs:
    """C of both bodies in all directions; raises Failure as `require_positive`.

    `wheel_rolls`: with the displacements of the upper body as the rail sees them in rolling.
    """
    start = perf_counter()
    bodies, estimate = c_of_bodies(problem, on_grid, options, ALL)
    ics = sum_of_bodies(on_grid, _each_reciprocal(bodies), wheel_rolls=wheel_rolls)
    eigenvalue = require_positive(problem, on_grid, ics[..., N, N])
    return ReferenceICs(
        GridOperator.from_ics(ics),
        GridOperator.from_ics(ics + estimate),
        float(np.max(estimate)) / float(np.max(np.abs(ics[..., N, N]))),
        max((Asymmetry.find(body.ics) for body in bodies.values()), key=lambda asymmetry: asymmetry.share),
        eigenvalue,
        perf_counter() - start,
    )


def normal_ics(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions = DEFAULT
) -> tuple[Array, Array]:
    """C_nn of both bodies on a grid and its estimated error [mm/MPa], (n_x, n_s, n_s) each."""
    bodies, estimate = c_of_bodies(problem, on_grid, options, NORMAL)
    return sum_of_bodies(on_grid, bodies)[..., 0, 0], estimate[..., 0, 0]


def full_ics(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions = DEFAULT, *, wheel_rolls: bool
) -> tuple[Array, Array]:
    """Return C of both bodies in all directions, with its error [mm/MPa], (n_x, n_s, n_s, 3, 3) each.

    `wheel_rolls`: with the displacements of the upper body as the rail sees them in rolling.
    """
    bodies, estimate = c_of_bodies(problem, on_grid, options, ALL)
    return sum_of_bodies(on_grid, _each_reciprocal(bodies), wheel_rolls=wheel_rolls), estimate


def normal_operator(ics: Array) -> GridOperator:
    """Return the operator of nn ICs (n_x, n_s, n_s) [mm/MPa], which are made symmetric."""
    return GridOperator.from_ics(reciprocal(ics[..., None, None]), NORMAL)


def pair_operator(
    references: Mapping[str, MatrixReference],
    on_grid: PairOnGrid,
    directions: tuple[int, ...],
    *,
    variation: str = "",
    wheel_rolls: bool = False,
) -> GridOperator:
    """Return the operator of C of both bodies; `variation` "nearer": with far arcs of half the radius."""
    bodies = body_ics(references, on_grid.grid, directions, variation)
    total = sum_of_bodies(on_grid, _each_reciprocal(bodies), wheel_rolls=wheel_rolls)
    return GridOperator.from_ics(total, directions)


def _each_reciprocal(bodies: Mapping[str, BodyICs]) -> dict[str, BodyICs]:
    return {name: replace(body, ics=reciprocal(body.ics)) for name, body in bodies.items()}


# --- ICs by name ---

C = "C"
Given = TypeVar("Given")


class NormalICs(Protocol):
    """nn ICs of both bodies that are known on one grid, such as those of a map of C."""

    @property
    def grid(self) -> Grid:
        """The grid on which they are known."""
        ...

    def at(self, on_grid: PairOnGrid) -> tuple[Array, Array]:
        """Return the ICs of bodies on this grid and their estimated errors [mm/MPa], (n_x, n_s, n_s) each."""
        ...


@dataclass(frozen=True, eq=False)
class GivenICs:
    """ICs of both bodies on a grid [mm/MPa], at lags >= 0 between strips, and their estimated errors.

    Shape (n_x, n_s, n_s, 3, 3), or (n_x, n_s, n_s) for nn alone, which contact without friction needs. In
    rolling, displacements of the wheel are those that the rail sees.
    """

    grid: Grid
    ics: Array
    estimate: Array | float = 0.0

    def at(self, _: PairOnGrid) -> tuple[Array, Array]:
        """Return the nn ICs and their estimated errors, (n_x, n_s, n_s) each."""
        estimate = np.broadcast_to(self.estimate, self.ics.shape)
        return (self.ics, estimate) if self.ics.ndim == 3 else (self.ics[..., N, N], estimate[..., N, N])

    @property
    def operator(self) -> GridOperator:
        """The ICs in all directions. Raises WrongInput for nn alone."""
        if self.ics.ndim != 5:
            raise WrongInput(
                f"ICs of shape {self.ics.shape}: contact with friction needs (n_x, n_s, n_s, 3, 3)"
            )
        return GridOperator.from_ics(self.ics)

    @property
    def perturbed(self) -> GridOperator | None:
        """The same with their estimated errors added; None where no errors are known."""
        return GridOperator.from_ics(self.ics + self.estimate) if np.any(self.estimate) else None


NONE_GIVEN: Mapping[str, GivenICs] = MappingProxyType({})


def select_given(ics: Sequence[str], given: Mapping[str, Given]) -> dict[str, Given]:
    """Return the given ICs among those named."""
    return {name: given[name] for name in ics if name in given}


def reference_name(ics: Sequence[str], given: Sequence[str] = ()) -> str:
    """Return the ICs that others are compared with: C, or without it given ones, B-hat, or the last."""
    first = (C, *(name for name in ics if name in given), "Bhat")
    return next((name for name in first if name in ics), ics[-1])
