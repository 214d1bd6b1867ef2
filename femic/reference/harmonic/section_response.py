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

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, diags_array, hstack, kron, spmatrix
from scipy.sparse.linalg import norm

from femic.reference.harmonic.elimination import Elimination
from femic.reference.harmonic.section import SectionMesh, SectionModel, assemble
from femic.reference.job import NotConverged
from femic.reference.symmetry import Parity, Y, parities
from geometries.arrays import Array, Indices, Mask
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
    def prepare(
        cls,
        model: SectionModel,
        held: Sequence[Mask],
        last: Mask,
        forces: csr_matrix,
        observers: csr_matrix,
    ) -> "Condensation":
        """Prepare the responses with supports that hold amplitudes, (n_nodes, 3) each.

        They differ at the `last` nodes (n_nodes,) alone.
        """
        by_fields = ROWS_PER_FIELD * len(held) * forces.shape[1] < observers.shape[0]
        carried = observers[:0] if by_fields else observers
        elimination = Elimination.prepare(model, ~np.all(held, axis=0), last, forces, carried)
        seen = csr_matrix(observers[:, elimination.amplitudes])
        return cls(elimination, elimination.forces, seen, by_fields)

    @property
    def retained(self) -> Indices:
        """Numbers of the retained amplitudes."""
        amplitudes = self.elimination.amplitudes
        return amplitudes[len(amplitudes) - self.elimination.retained :]

    def respond(self, k: Sequence[float], supports: Sequence[Mask]) -> tuple[list[Array], Array]:
        """Responses (k, m, n) [mm^2/N] with each support, and the largest residual (k,) that proves them.

        A support marks which of the retained amplitudes it leaves free. Raises NotConverged where a pivot is
        0, or a residual is too large.
        """
        n, size, free = self.elimination.retained, len(self.elimination.amplitudes), np.stack(supports)
        try:
            eliminated = self.elimination.at(k)
            left = eliminated.left
            moved = np.zeros((len(free), len(k), n, left.shape[2] - n))  # retained amplitudes under the loads
            for support, amplitudes in zip(free, moved, strict=True):
                rows = left[:, :n][:, support]
                amplitudes[:, support] = np.linalg.solve(rows[:, :, :n][:, :, support], rows[:, :, n:])
        except np.linalg.LinAlgError as error:
            raise not_solved(max(k), size, str(error)) from error
        weights = column_weights(self.forces)
        combined = np.eye(len(weights)) if self.by_fields else weights[:, None]
        retained = np.concatenate([amplitudes @ combined for amplitudes in moved], axis=2)
        fields = np.split(eliminated.fields(retained, np.tile(combined, len(moved))), len(moved), axis=2)
        if self.by_fields:
            responses = [_see(self.observers, field) for field in fields]
            fields = [field @ weights[:, None] for field in fields]
        else:
            observer_rows = left[:, n:]
            responses = [observer_rows[:, :, :n] @ one - observer_rows[:, :, n:] for one in moved]
        weighted = np.concatenate(fields, axis=2)  # (k, amplitudes, support)
        unbalanced = eliminated.forces(weighted) - (self.forces @ weights)[:, None]
        unbalanced[:, size - n :][:, ~free.T] = 0.0
        residuals = np.max(np.linalg.norm(unbalanced, axis=1), axis=1)
        if not self.by_fields:
            # The observed amplitudes twice: as shares of the amplitudes at the loads, if these move more.
            by_condensation = np.concatenate([response @ weights[:, None] for response in responses], axis=2)
            by_field, at_loads = (_see(rows, weighted) for rows in (self.observers, self.forces.T))
            norms = [np.linalg.norm(values, axis=1) for values in (by_condensation, by_field, at_loads)]
            apart = np.linalg.norm(by_condensation - by_field, axis=1) / np.max(norms, axis=0)
            residuals = np.maximum(residuals, np.max(apart, axis=1))
        for one, residual in zip(k, residuals.tolist(), strict=True):
            require_small(residual, one, size)
        return responses, residuals


def _see(rows: csr_matrix, fields: Array) -> Array:
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
        """Assemble and prepare the equations for some shares of the far radius.

        All cases have a common elimination, or each its own where more than `MOST_RETAINED` amplitudes would
        be retained.
        """
        ys = sorted({p.y for load in loads for p in parities(load, half_section=section.half_section)})
        columns = list(dict.fromkeys(_column(load, y) for y in ys for load in _with_part(loads, y)))
        places, self._place_of_observer = np.unique(
            np.abs(s) if section.half_section else s, return_inverse=True
        )
        forces = hstack([csc_matrix(strip_force(section, *column)[:, None]) for column in columns], "csr")
        held = {(y, share): _held(section, y, share) for y in ys for share in shares}
        masks = np.stack(list(held.values()))
        differing = np.any(np.any(masks, axis=0) & ~np.all(masks, axis=0), axis=1)  # (n_nodes,)
        groups = [held]
        if 3 * np.sum(differing) > MOST_RETAINED:
            groups, differing = [{case: mask} for case, mask in held.items()], np.zeros_like(differing)
        model, seen = assemble(section), observers(section, places)
        self._shared: list[tuple[Condensation, dict[Case, Mask]]] = []  # with what each case leaves free
        for group in groups:
            condensation = Condensation.prepare(model, list(group.values()), differing, forces, seen)
            free = {case: ~mask.ravel()[condensation.retained] for case, mask in group.items()}
            self._shared.append((condensation, free))
        # Loads at s and -s have parts that are equal or opposite: they share a column of the forces. So do
        # observers share a place.
        self._parts: dict[int, tuple[list[int], list[int], Array, Array]] = {}
        column_number = {column: number for number, column in enumerate(columns)}
        for y in ys:
            with_part = set(_with_part(loads, y))
            numbers = [number for number, load in enumerate(loads) if load in with_part]
            places_of_columns = [column_number[_column(loads[number], y)] for number in numbers]
            mirrored = np.array([y != 0 and loads[number].patch.s < 0 for number in numbers], dtype=bool)
            on_other_side = np.array([-y if loads[number].direction == S else y for number in numbers])
            observer_signs = np.where((s < 0)[:, None], _mirror(y), 1.0)
            self._parts[y] = numbers, places_of_columns, np.where(mirrored, on_other_side, 1), observer_signs
        self._axes = section.body.surface.axes(np.zeros_like(s), s)  # (direction, component, n)
        along_x = np.array([load.direction == X for load in loads])
        self._signs = np.where(along_x[:, None], [1, -1, -1], [1, 1, 1])[..., None]

    @property
    def batch_size(self) -> int:
        """Number of wavenumbers for which one call takes memory, at most."""
        return min(condensation.elimination.batch_size for condensation, _ in self._shared)

    def __call__(self, k: Sequence[float], shares: Sequence[float] = (1.0,)) -> tuple[Array, Array]:
        """Amplitudes [mm^2/N] at wavenumbers [1/mm], and the worst residuals (k,); raises NotConverged."""
        in_global_axes = np.zeros((len(k), len(shares), len(self._signs), 3, self._axes.shape[2]))
        worst = np.zeros(len(k))
        for condensation, free in self._shared:
            cases = [case for case in free if case[1] in shares]
            if not cases:
                continue
            case_responses, residuals = condensation.respond(k, [free[case] for case in cases])
            worst = np.maximum(worst, residuals)
            for (y, share), responses in zip(cases, case_responses, strict=True):
                load_numbers, columns, signs, observer_signs = self._parts[y]
                at_places = responses.reshape(len(k), -1, 3, responses.shape[2])
                observed = observer_signs[..., None] * at_places[:, self._place_of_observer]
                in_global_axes[:, shares.index(share), load_numbers] += (
                    signs[:, None, None] * np.transpose(observed, (0, 3, 2, 1))[:, columns]
                )
        in_local_axes = np.einsum("icn,kalcn->kalin", self._axes, in_global_axes)
        return np.asarray(self._signs * in_local_axes), worst


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
