"""The response of a section at wavenumbers: displacements of observers under unit line loads on strips.

Where half of the section is modelled, each load is the sum of an even and an odd part; a load at s = 0 has
only one of them. Even and odd parts, and far arcs at several radii, differ in their supports only: one
elimination serves them all, unless they differ at too many nodes.

Only the amplitudes G K^-1 F at the observers are needed, not all amplitudes K^-1 F under forces F. Those that
some supports hold and others leave free are retained: all others are eliminated once
(`femic.reference.harmonic.elimination`), and for each support the free retained ones from what is left, which
leaves G K^-1 F. One system per support is solved for its amplitudes, to verify factors, what is left, and the
responses: its residual proves them.

Where observers are many and loads few, observers are not carried along: the amplitudes under all loads are
computed. A field takes as long as `ROWS_PER_FIELD` observers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, diags_array, hstack, kron, spmatrix
from scipy.sparse.linalg import norm

from femic.reference.harmonic.elimination import Eliminated, Elimination, Equations
from femic.reference.harmonic.section import SectionMesh
from femic.reference.harmonic.section_model import SectionModel, assemble
from femic.reference.job import NotConverged
from femic.reference.symmetry import Parity, Y, parities
from geometries.arrays import Array, Mask
from geometries.patches import Load, S, X
from geometries.quadrature import on_panels

# --- residuals ---

# A tenth of the tightest tolerance. The relative error of the displacements is a quarter of the residual or
# less (measured by a step of iterative refinement). Rounding leaves residuals of 1e-14 at large k, and of
# 5e-12 at k = 0 and nu = 0.28. They grow in proportion to 1 / (1 - 2 nu): 3e-9 at nu = 0.4999, and there 1e-7
# under a patch of aspect 0.01 (144 000 unknowns).
LARGEST_RESIDUAL = 1e-5


def column_weights(forces: spmatrix) -> Array:
    """Weights of the columns of forces (unknowns, n) in a sum that proves all their solutions, shape (n,).

    Each column is divided by its norm, which keeps large columns from hiding small ones, and multiplied by a
    repeatable random number of size 1 to 2 and either sign, which keeps two columns from cancelling.
    """
    generator = np.random.default_rng(0)
    n = forces.shape[1]
    factors = generator.uniform(1.0, 2.0, n) * generator.choice([-1.0, 1.0], n)
    return np.asarray(factors / norm(forces, axis=0))


def require_small(residual: float, k: float, unknowns: int) -> None:
    """Raise NotConverged where the residual at a wavenumber [1/mm] is too large, or no number."""
    if not residual <= LARGEST_RESIDUAL:
        raise not_solved(
            k, unknowns, f"the residual is {residual:.1e} of the forces, {LARGEST_RESIDUAL:.0e} allowed"
        )


def not_solved(k: float, unknowns: int, reason: str) -> NotConverged:
    """The error at a wavenumber [1/mm]."""
    return NotConverged(
        f"section at the wavenumber k = {k:.4g} 1/mm, {unknowns:,} unknowns: not solved: {reason}. Likely "
        "cause: a Poisson's ratio too close to 0.5, cells that are strongly distorted or of very different "
        "sizes, or moduli or lengths beyond what numbers can hold. Try a smaller nu, a smaller "
        "`growth`, or lengths and moduli of usual size"
    )


# --- responses with several supports ---

ROWS_PER_FIELD = 10  # observers that take as long as one field


@dataclass(frozen=True, eq=False)
class Condensation:
    """The equations of a section with loads and observers, at any wavenumbers."""

    elimination: Elimination
    forces: csr_matrix  # F (amplitudes, n), in the order of elimination
    observers: csr_matrix  # G (m, amplitudes)
    by_fields: bool  # responses are read from the amplitudes under all loads

    @classmethod
    def prepare(cls, equations: Equations, supports: int) -> "Condensation":
        """Prepare the responses of a section with a number of `supports`."""
        forces, observers = equations.forces, equations.observers
        by_fields = ROWS_PER_FIELD * supports * forces.shape[1] < observers.shape[0]
        carried = observers[:0] if by_fields else observers
        elimination = Elimination.prepare(replace(equations, observers=carried))
        seen = csr_matrix(observers[:, elimination.amplitudes])
        return cls(elimination, elimination.forces, seen, by_fields)

    @property
    def retained(self) -> int:
        """Number of retained amplitudes."""
        return self.elimination.retained

    def at(self, k: Sequence[float]) -> "Condensed":
        """The condensed equations at wavenumbers [1/mm]; raises NotConverged where a pivot is 0."""
        try:
            return Condensed(self, self.elimination.at(k))
        except np.linalg.LinAlgError as error:
            raise not_solved(max(k), len(self.elimination.amplitudes), str(error)) from error


@dataclass(frozen=True, eq=False)
class Condensed:
    """The equations of retained amplitudes, loads and observers at some wavenumbers."""

    condensation: Condensation
    eliminated: Eliminated

    def responses(self, supports: Sequence[Mask]) -> tuple[list[Array], Array]:
        """Responses (k, m, n) [mm^2/N] with each support, and the largest residual (k,) that proves them.

        A support marks which of the retained amplitudes it leaves free. Raises NotConverged where a residual
        is too large.
        """
        prepared = self.condensation
        moved = [self._retained(free) for free in supports]
        weights = column_weights(prepared.forces)
        combined = np.eye(len(weights)) if prepared.by_fields else weights[:, None]
        fields = np.split(
            self.eliminated.fields(
                np.concatenate([retained @ combined for retained in moved], axis=2),
                np.tile(combined, len(moved)),
            ),
            len(moved),
            axis=2,
        )
        if prepared.by_fields:
            found = [_seen(prepared.observers, field) for field in fields]
            fields, seen = [field @ weights[:, None] for field in fields], None
        else:
            found = [self._seen_when(retained) for retained in moved]
            seen = [response @ weights[:, None] for response in found]
        residuals = self._residuals(supports, np.concatenate(fields, axis=2), seen, weights)
        for k, residual in zip(self.eliminated.k, residuals, strict=True):
            require_small(float(residual), float(k), len(prepared.elimination.amplitudes))
        return found, residuals

    def _retained(self, free: Mask) -> Array:
        """Retained amplitudes (k, retained, n) under the loads."""
        left, n = self.eliminated.left[:, : len(free)][:, free], len(free)
        moved = np.zeros((len(left), n, self.eliminated.left.shape[2] - n))
        try:
            moved[:, free] = np.linalg.solve(left[:, :, :n][:, :, free], left[:, :, n:])
        except np.linalg.LinAlgError as error:
            size = len(self.condensation.elimination.amplitudes)
            raise not_solved(float(np.max(self.eliminated.k)), size, str(error)) from error
        return moved

    def _seen_when(self, moved: Array) -> Array:
        """What observers see (k, m, n) where retained amplitudes are `moved` by the loads."""
        observer_rows, n = self.eliminated.left[:, moved.shape[1] :], moved.shape[1]
        return np.asarray(observer_rows[:, :, :n] @ moved - observer_rows[:, :, n:])

    def _residuals(
        self, supports: Sequence[Mask], fields: Array, seen: Sequence[Array] | None, weights: Array
    ) -> Array:
        """The largest residual at each k of fields (k, amplitudes, support) under the weighted loads.

        That of the equations of free amplitudes, or, where observers were carried along, of the observed
        amplitudes: a share of the amplitudes at the loads, if they move more than the observers.
        """
        prepared = self.condensation
        unbalanced = self.eliminated.forces(fields) - (prepared.forces @ weights)[:, None]
        at_retained = unbalanced[:, unbalanced.shape[1] - prepared.retained :]
        at_retained[:, ~np.stack(supports, axis=1)] = 0.0
        residuals = np.max(np.linalg.norm(unbalanced, axis=1), axis=1)
        if seen is None:
            return np.asarray(residuals)
        from_fields, at_loads = (_seen(rows, fields) for rows in (prepared.observers, prepared.forces.T))
        by_condensation = np.concatenate(seen, axis=2)
        size = np.max(
            [np.linalg.norm(values, axis=1) for values in (by_condensation, from_fields, at_loads)], axis=0
        )
        apart = np.linalg.norm(by_condensation - from_fields, axis=1) / size
        return np.asarray(np.maximum(residuals, np.max(apart, axis=1)))


def _seen(rows: csr_matrix, fields: Array) -> Array:
    """Products (k, m, c) of rows (m, amplitudes) with fields (k, amplitudes, c)."""
    return np.stack([rows @ field for field in fields])


# --- loads on strips ---

LOAD_POINTS = 4  # Gauss points per edge on a strip
MOST_RETAINED = 1000  # amplitudes up to which a factorisation that serves all cases of support is faster
ON_PLANE = 1e-9  # share of a half-width by which strips may cross the plane of symmetry unnoticed

Column = tuple[Load, int]  # a column of the forces: a load, and the parity in y of its part
Case = tuple[int, float]  # parity in y, and the share of the far radius at which the far arc lies


class SectionSolver:
    """Displacements of observers at arc lengths s [mm] in their local directions, at any wavenumbers.

    A call returns the amplitudes of sin(k x) or cos(k x) [mm^2/N] with the far arc at its radius and at
    further shares of it, shape (k, share, load, 3, len(s)), and the residuals of the solved equations.
    """

    def __init__(
        self, section: SectionMesh, loads: Sequence[Load], s: Array, shares: Sequence[float] = (1.0,)
    ) -> None:
        """Assemble and prepare the equations for some shares of the far radius."""
        ys = sorted({p.y for load in loads for p in parities(load, half_section=section.half_section)})
        columns = list(dict.fromkeys(_column(load, y) for y in ys for load in _with_part(loads, y)))
        places, place_of_observer = np.unique(np.abs(s) if section.half_section else s, return_inverse=True)
        self._shared = _shared_factorisations(
            section,
            {(y, share): _held(section, y, share) for y in ys for share in shares},
            hstack([csc_matrix(strip_force(section, *column)[:, None]) for column in columns], format="csr"),
            observers(section, places),
        )
        observer_signs = {y: np.where((s < 0)[:, None], _mirror(y), 1.0) for y in ys}
        self._parts = {y: _Part.select(loads, y, columns, observer_signs[y]) for y in ys}
        self._n_loads, self._place_of_observer = len(loads), place_of_observer
        self._axes = section.body.surface.axes(np.zeros_like(s), s)  # (direction, component, n)
        along_x = np.array([load.direction == X for load in loads])
        self._signs = np.where(along_x[:, None], [1, -1, -1], [1, 1, 1])[..., None]

    @property
    def batch_size(self) -> int:
        """Number of wavenumbers for which one call takes memory, at most."""
        return min(shared.condensation.elimination.batch_size for shared in self._shared)

    def __call__(self, k: Sequence[float], shares: Sequence[float] = (1.0,)) -> tuple[Array, Array]:
        """Amplitudes [mm^2/N] at wavenumbers [1/mm], and the worst residuals (k,); raises NotConverged."""
        in_global_axes = np.zeros((len(k), len(shares), self._n_loads, 3, self._axes.shape[2]))
        worst = np.zeros(len(k))
        for shared in self._shared:
            cases = [case for case in shared.free if case[1] in shares]
            if not cases:
                continue
            free = [shared.free[case] for case in cases]
            case_responses, residuals = shared.condensation.at(k).responses(free)
            worst = np.maximum(worst, residuals)
            for (y, share), responses in zip(cases, case_responses, strict=True):
                part = self._parts[y]
                at_places = responses.reshape(len(k), -1, 3, responses.shape[2])
                observed = part.observer_signs[..., None] * at_places[:, self._place_of_observer]
                in_global_axes[:, shares.index(share), part.load_numbers] += (
                    part.signs[:, None, None] * np.transpose(observed, (0, 3, 2, 1))[:, part.columns]
                )
        in_local_axes = np.einsum("icn,kalcn->kalin", self._axes, in_global_axes)
        return np.asarray(self._signs * in_local_axes), worst


@dataclass(frozen=True, eq=False)
class _SharedFactorisation:
    """Cases of support, by parity in y and share of the far radius, with a common factorisation.

    `free` marks which of the retained amplitudes each leaves free.
    """

    condensation: Condensation
    free: Mapping[Case, Mask]

    @classmethod
    def prepare(
        cls,
        model: SectionModel,
        held: Mapping[Case, Mask],
        last: Mask,
        forces: csr_matrix,
        seen: csr_matrix,
    ) -> "_SharedFactorisation":
        """Prepare cases by what they hold, (n_nodes, 3); they differ at the `last` nodes (n_nodes,) alone."""
        free = ~np.all(list(held.values()), axis=0)
        condensation = Condensation.prepare(Equations(model, free, last, forces, seen), len(held))
        amplitudes = condensation.elimination.amplitudes
        retained = amplitudes[len(amplitudes) - condensation.retained :]
        return cls(condensation, {case: ~mask.ravel()[retained] for case, mask in held.items()})


def _shared_factorisations(
    section: SectionMesh, held: Mapping[Case, Mask], forces: csr_matrix, seen: csr_matrix
) -> list[_SharedFactorisation]:
    """All cases together, or each apart where more than `MOST_RETAINED` amplitudes would be retained."""
    model, differing = assemble(section), _differing(held)
    if 3 * np.sum(differing) <= MOST_RETAINED:
        return [_SharedFactorisation.prepare(model, held, differing, forces, seen)]
    none = np.zeros_like(differing)
    return [
        _SharedFactorisation.prepare(model, {case: mask}, none, forces, seen) for case, mask in held.items()
    ]


def _differing(held: Mapping[Case, Mask]) -> Mask:
    """Nodes that some cases hold in another way than others do, (n_nodes,)."""
    masks = np.stack(list(held.values()))
    return np.asarray(np.any(np.any(masks, axis=0) & ~np.all(masks, axis=0), axis=1))


def _held(section: SectionMesh, y: int, share: float) -> Mask:
    """Amplitudes that are held for a parity in y, with the far arc at a share of its radius, (n_nodes, 3).

    It takes only the first nodes beyond the arc, those of the cells that it crosses, to hold what is inside.
    """
    nodes, far_radius = section.mesh.doflocs, section.body.domain.far_radius
    cells = section.mesh.dofs.element_dofs.T  # (n_cells, 15)
    on_plane = np.abs(nodes[0]) < 1e-9 * far_radius
    beyond = (np.hypot(*nodes) > share * far_radius) & (share < 1)
    crossed = cells[~np.all(beyond[cells], axis=1)]
    on_arc = np.zeros_like(beyond)
    on_arc[crossed] = beyond[crossed]
    return np.asarray(section.supported | (on_plane[:, None] & (_mirror(y) < 0)) | on_arc[:, None])


def _with_part(loads: Sequence[Load], y: int) -> list[Load]:
    """The loads that have a part of a parity in y; y = 0 stands for all of them on a whole section."""
    return [load for load in loads if any(p.y == y for p in parities(load, half_section=y != 0))]


def _column(load: Load, y: int) -> Column:
    """The column with the part of a load: the load at |s|, or its part of a parity where it crosses y = 0.

    Elsewhere even and odd part are the same on the half of the section that is modelled. On a whole section
    y = 0.
    """
    if y == 0:
        return load, 0
    patch = replace(load.patch, s=abs(load.patch.s))
    crosses = patch.s - patch.b < -ON_PLANE * patch.b
    return replace(load, patch=patch), y if crosses else 1


@dataclass(frozen=True, eq=False)
class _Part:
    """The even or the odd part of the loads, or all of them on a whole section.

    Loads at s and -s have parts that are equal or opposite: they share a column of the forces. So do
    observers share a place.
    """

    load_numbers: list[int]  # numbers of the loads that have this part
    columns: list[int]  # the column of the forces that each of these loads uses
    signs: Array  # the factor of each of these loads on its column
    observer_signs: Array  # the factors of each observer on the components at its place, (n, 3)

    @classmethod
    def select(
        cls, loads: Sequence[Load], y: int, columns: Sequence[Column], observer_signs: Array
    ) -> "_Part":
        """Select the part of a parity in y, or all of the loads (0)."""
        with_part = set(_with_part(loads, y))
        load_numbers = [number for number, load in enumerate(loads) if load in with_part]
        column_number = {column: number for number, column in enumerate(columns)}
        return cls(
            load_numbers,
            [column_number[_column(loads[number], y)] for number in load_numbers],
            np.array([_sign(loads[number], y) for number in load_numbers]),
            observer_signs,
        )


def _sign(load: Load, y: int) -> float:
    """The factor of the part of a load on that of the load at |s|."""
    if y == 0 or load.patch.s >= 0:
        return 1.0
    return float(-y if load.direction == S else y)


def _mirror(y: int) -> Array:
    """Signs (3,) by which the components differ on the other side of y = 0; 1 on a whole section."""
    return Parity(1, y).signs(Y) if y else np.ones(3)


def observers(section: SectionMesh, s: Array, y: int = 0) -> csr_matrix:
    """Matrix (3 len(s), unknowns) from amplitudes to u_x, u_y, u_z on the contour at arc lengths s [mm].

    With a parity in y, amplitudes belong to the half section.
    """
    signs = np.where((s < 0)[:, None], _mirror(y), 1.0).ravel()
    trace = section.interpolation(np.abs(s) if y else s)
    return csr_matrix(diags_array(signs) @ kron(trace, np.eye(3), format="csr"))


def strip_force(section: SectionMesh, load: Load, y: int = 0) -> Array:
    """Consistent forces (unknowns,) of the part of a unit line load that has a parity in y.

    The line load is uniform over the strip of the load; y = 0 stands for a whole section.
    """
    low, high = load.patch.s - load.patch.b, load.patch.s + load.patch.b
    knots = np.concatenate([-section.knots, section.knots]) if y else section.knots
    edges = np.unique([low, *knots[(knots > low) & (knots < high)], high])
    nodes, weights = on_panels(edges[:-1], edges[1:], LOAD_POINTS)
    s, density = nodes.ravel(), weights.ravel() / (high - low)
    direction = section.body.surface.axes(0.0, s)[load.direction]  # (3, n)
    modelled_share = 0.5 if y else 1.0  # half of the section carries half of the even and of the odd part
    return np.asarray(modelled_share * (observers(section, s, y).T @ (density * direction).T.ravel()))
