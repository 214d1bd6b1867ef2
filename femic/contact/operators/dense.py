"""An IC matrix as an operator from tractions to displacements, its smallest eigenvalue, its reciprocity.

The operator is a convolution along x (by FFT), because elements of a strip differ by their lag only, and a
dense matrix between strips. On a part of a grid any operator takes the form whose products are fastest there
(`restrict_to`).
"""

import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy import fft
from scipy.sparse.linalg import LinearOperator, eigsh, lobpcg

from femic.cache.workers import in_threads
from femic.contact.operators.convolution import Convolution, merged
from femic.contact.operators.protocols import FullOperator
from femic.contact.patch import Box
from geometries.arrays import Array, Indices
from geometries.contours import Contour
from geometries.patches import DIRECTIONS, Grid, N, S, X, mirror_signs

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]


# --- matrix as operator ---

PARITY = mirror_signs(X)  # parity in x of the components (i, j): -1 odd
EIGENVALUE_ACCURACY = 0.03  # accuracy of the smallest eigenvalue over the least IC of an element on itself
PRECONDITIONER_SHIFT = 0.1  # smallest eigenvalue of the preconditioner's inverse over that IC
ALL_BELOW, EVERY = 6, 6  # frequencies of the preconditioner: all below a number, then every sixth
VANISHES = 1e-9  # size of a component over the largest one up to which it is zero by symmetry
MOST_ITERATIONS = 100  # of the search for the smallest eigenvalue, from each start
MOST_AT_ONCE = 2  # matrices whose eigenvalues are searched: each takes five times its memory
RESTARTS = 3  # of the search, from where it has ended: then another method goes on


@dataclass(frozen=True, eq=False)
class GridOperator:
    """The transform along x of an IC matrix [mm/MPa], shape (frequency, m n_s, m n_s), for m directions.

    Tractions and displacements along x are multiplied by -i, which makes the transform real: components that
    couple x with another direction are odd in x, all others even.
    """

    transformed: Real
    n_x: int
    directions: tuple[int, ...] = (X, S, N)

    @classmethod
    def from_ics(cls, ics: Array, directions: tuple[int, ...] = (X, S, N)) -> "GridOperator":
        """Return the operator of ICs (n_x, n_s, n_s, m, m) [mm/MPa] at lags >= 0 for m directions.

        Negative lags follow by parity. It has the precision of the ICs, single or double.
        """
        n_x, n_s, _, m, _ = ics.shape
        lags = np.zeros((2 * n_x, *ics.shape[1:]), ics.dtype)
        lags[:n_x] = ics
        parity = PARITY[np.ix_(directions, directions)]
        lags[n_x + 1 :] = parity.astype(ics.dtype) * ics[:0:-1]
        spectra = fft.rfft(lags, axis=0)
        phases = _phases(directions, spectra.dtype)
        spectra *= np.conj(phases)[:, None] * phases
        rows = spectra.real.transpose(0, 1, 3, 2, 4).reshape(n_x + 1, m * n_s, m * n_s)
        return cls(np.ascontiguousarray(rows), n_x, directions)

    @classmethod
    def from_convolution(cls, convolution: Convolution) -> "GridOperator":
        """Return the operator of a convolution, whose products are faster in this form on few strips."""
        n_x = convolution.shape[0]
        ics = _between_strips(convolution, lambda kernel: kernel[n_x - 1 :])
        return cls.from_ics(ics, convolution.directions)

    @classmethod
    def from_coarsened(cls, convolution: Convolution) -> "GridOperator":
        """Return the operator of a convolution on elements twice as large: as `coarsened`, with its factors.

        Both numbers of elements must be even.
        """
        n_x = convolution.shape[0] // 2
        ics = _between_strips(convolution, lambda kernel: merged(kernel, 0)[n_x - 1 :])
        pairs = ics.reshape(n_x, ics.shape[1] // 2, 2, ics.shape[2] // 2, 2, *ics.shape[3:])
        return cls.from_ics(pairs.mean(axis=2).sum(axis=3), convolution.directions)

    def __call__(self, tractions: Array) -> Array:
        """Return displacements [mm] due to tractions [MPa], shape (n_x, n_s, m) each.

        They are computed in the precision of the operator.
        """
        real, compl = self.transformed.dtype, np.result_type(self.transformed, np.complex64)
        phases = np.tile(_phases(self.directions, compl), tractions.shape[1])
        spectra = fft.rfft(tractions.reshape(self.n_x, -1).astype(real), 2 * self.n_x, axis=0) / phases
        parts = spectra.view(real).reshape(*spectra.shape, 2)
        moved = np.matmul(self.transformed, parts).view(compl)[..., 0] * phases
        return fft.irfft(moved, axis=0)[: self.n_x].reshape(tractions.shape).astype(float)

    def coarsened(self) -> "GridOperator":
        """Return the operator on elements twice as large: mean displacements due to equal tractions on four.

        Both numbers of elements must be even.
        """
        m, n_x = len(self.directions), self.n_x
        strips = self.transformed.shape[1] // m
        paired = self.transformed.reshape(n_x + 1, strips // 2, 2, m, strips // 2, 2, m)
        unpaired = paired.mean(axis=2).sum(axis=4).reshape(n_x + 1, strips * m // 2, strips * m // 2)
        # waves of pairs are those of elements of two lengths; the shorter ones are the last frequencies
        numbers = np.arange(n_x // 2 + 1)
        longer = (1 + np.cos(np.pi * numbers / n_x)) / 2
        sign = np.tile(PARITY[np.ix_(self.directions, self.directions)], (strips // 2, strips // 2))
        weights = longer.astype(unpaired.dtype)[:, None, None]
        merged_x = (
            weights * unpaired[numbers]
            + (1 - weights) * sign.astype(unpaired.dtype) * unpaired[n_x - numbers]
        )
        return GridOperator(merged_x, n_x // 2, self.directions)

    def part(self, n_x: int, strips: slice) -> "GridOperator":
        """Return the operator on `n_x` elements along x of some strips."""
        m = len(self.directions)
        places = slice(m * strips.start, m * strips.stop)
        phases = np.tile(
            _phases(self.directions, np.result_type(self.transformed, np.complex64)),
            strips.stop - strips.start,
        )
        spectra = phases[:, None] * self.transformed[:, places, places] * np.conj(phases)
        lags = fft.irfft(spectra, axis=0)[:n_x]
        n_s = strips.stop - strips.start
        return GridOperator.from_ics(np.moveaxis(lags.reshape(n_x, n_s, m, n_s, m), 2, 3), self.directions)

    def restricted(self, directions: tuple[int, ...]) -> "GridOperator":
        """Return the operator from tractions in some directions to displacements in these directions."""
        m, chosen = len(self.directions), [self.directions.index(direction) for direction in directions]
        unknowns = self.transformed.shape[1]
        places = (m * np.arange(unknowns // m)[:, None] + chosen).ravel()
        part = self.transformed[:, places[:, None], places]
        return GridOperator(np.ascontiguousarray(part), self.n_x, directions)

    def smallest_eigenvalue(self) -> float:
        """Smallest eigenvalue of the symmetric part [mm/MPa].

        It is accurate to 3 % of the least IC of an element on itself, and positive if all tractions do
        positive work.
        """
        with warnings.catch_warnings(action="ignore"):  # on slow convergence: the residual is checked
            return self._smallest_eigenvalue()

    def _smallest_eigenvalue(self) -> float:
        """Search the smallest eigenvalue in single precision, with warnings where the search is slow.

        On a ring of twice the grid's length the frequencies decouple and the smallest eigenvalue is not
        larger; so with a shift the inverse on that ring is positive and preconditions the search (LOBPCG). It
        changes little between high frequencies: some are chosen, with all low ones.
        """
        halves = (self.transformed + np.swapaxes(self.transformed, 1, 2)) / 2
        symmetric = GridOperator(halves.astype(np.float32), self.n_x, self.directions)
        own_ics = fft.irfft(np.diagonal(symmetric.transformed, axis1=1, axis2=2), axis=0)[0]
        least = float(np.min(np.abs(own_ics)))
        numbers = np.arange(self.n_x + 1)
        chosen = np.flatnonzero((numbers < ALL_BELOW) | (numbers % EVERY == 0) | (numbers == self.n_x))
        nearest = np.argmin(np.abs(numbers[:, None] - chosen), axis=1)
        blocks = symmetric.transformed[chosen]
        shift = np.min(np.linalg.eigvalsh(blocks)) - PRECONDITIONER_SHIFT * least
        unknowns = blocks.shape[1]
        shifted = blocks - (shift * np.eye(unknowns)).astype(blocks.dtype)
        inverse = GridOperator(np.linalg.inv(shifted)[nearest], self.n_x, self.directions)
        vector = np.random.default_rng(0).standard_normal(self.n_x * unknowns)
        for _ in range(RESTARTS):
            _, vectors = lobpcg(
                symmetric.linear,
                vector[:, None],
                M=inverse.linear,
                largest=False,
                tol=EIGENVALUE_ACCURACY * least,
                maxiter=MOST_ITERATIONS,
            )
            vector = vectors[:, 0] / np.linalg.norm(vectors[:, 0])
            moved = symmetric.linear @ vector
            eigenvalue = float(vector @ moved)
            if np.linalg.norm(moved - eigenvalue * vector) <= EIGENVALUE_ACCURACY * least:
                return eigenvalue
        return float(
            eigsh(
                symmetric.linear,
                k=1,
                which="SA",
                tol=EIGENVALUE_ACCURACY,
                v0=vector,
                return_eigenvectors=False,
            )[0]
        )

    @property
    def linear(self) -> LinearOperator:
        """The operator on tractions as one vector."""
        size, m = self.n_x * self.transformed.shape[1], len(self.directions)

        def applied(tractions: Array) -> Array:
            return self(tractions.reshape(self.n_x, -1, m)).ravel()

        return LinearOperator((size, size), dtype=float, matvec=applied)


def smallest_eigenvalues(matrices: Iterable[Array], workers: int) -> list[float]:
    """Smallest eigenvalues of ICs (n_x, n_s, n_s, 3, 3) [mm/MPa], of at most two matrices at once.

    Each is a share of the least IC xx, ss or nn of an element on itself.
    """

    def relative_eigenvalue(ics: Array) -> float:
        own_ic = np.min(np.diagonal(ics[0], axis1=0, axis2=1).diagonal(axis1=0, axis2=1))
        return GridOperator.from_ics(ics)._smallest_eigenvalue() / float(own_ic)

    with warnings.catch_warnings(action="ignore"):  # of all threads, which share their filters
        return list(in_threads(relative_eigenvalue, matrices, min(workers, MOST_AT_ONCE)))


def _between_strips(convolution: Convolution, at_lags: Callable[[Array], Array]) -> Array:
    """ICs (lags, n_s, n_s, m, m) of a convolution whose kernels have lags along x that a function takes."""
    n_s, directions = convolution.shape[1], convolution.directions
    n = len(at_lags(next(iter(convolution.kernels.values()))))
    ics = np.zeros((n, n_s, n_s, len(directions), len(directions)))
    for ((i, observer_factor), (j, load_factor)), kernel in convolution.kernels.items():
        factors = np.outer(convolution.factors[observer_factor], convolution.factors[load_factor])
        between = at_lags(kernel)[:, strip_lags(n_s)]
        ics[..., directions.index(i), directions.index(j)] += factors * between
    return ics


def strip_lags(n_s: int) -> Indices:
    """Places of the lags of all pairs of strips (observing, loaded) among lags from -(n_s - 1) to n_s - 1."""
    return np.asarray(np.subtract.outer(np.arange(n_s), np.arange(n_s)) + n_s - 1)


def _phases(directions: tuple[int, ...], dtype: DTypeLike) -> Complex:
    """Return the factor i for direction x, else 1, shape (m,)."""
    return np.where(np.array(directions) == X, 1j, 1.0).astype(dtype)


# --- reciprocity of a raw matrix ---


def reciprocity_defects(ics: Array) -> Array:
    """Return largest |C(I, J) - C(J, I)^T| per pair of strips and component, shape (n_s, n_s, 3, 3).

    Each is a share of the component's own largest value, because a small part of C_nn may be much of C_sn.
    For components that vanish it is 0. `ics` has the shape (n_x, n_s, n_s, 3, 3). ICs of curved bodies at the
    centres of elements, not averaged over them, are not exactly reciprocal.
    """
    exchanged = PARITY.astype(ics.dtype) * np.swapaxes(np.swapaxes(ics, 1, 2), 3, 4)
    sizes = np.max(np.abs(ics), axis=(0, 1, 2))
    sizes = np.maximum(sizes, sizes.T)  # ij and ji are the same ICs, seen from both ends
    there = sizes > VANISHES * np.max(sizes)
    return np.asarray(np.max(np.abs(ics - exchanged), axis=0) / np.where(there, sizes, np.inf))


@dataclass(frozen=True)
class Asymmetry:
    """The largest of the reciprocity defects, and its component."""

    share: float  # of the component's largest value
    component: str

    @classmethod
    def find(cls, ics: Array) -> "Asymmetry":
        """Return the largest defect of ICs (n_x, n_s, n_s, 3, 3)."""
        worst = np.max(reciprocity_defects(ics), axis=(0, 1))
        i, j = divmod(int(np.argmax(np.triu(worst))), len(DIRECTIONS))
        return cls(float(worst[i, j]), DIRECTIONS[i] + DIRECTIONS[j])


ON_EDGE = 1e-3  # share of a strip: joints closer than that to its edge are on the edge, as in meshes


@dataclass(frozen=True)
class Reciprocity:
    """Largest |C(I, J) - C(J, I)^T|: of all pairs of strips, of those without joints.

    Each is a share of the largest value of its component; `component` is the worst one.

    Displacements are read at centres, loads act on whole elements. The average over an element differs from
    the value at its centre by the curvature of the field across it. At a joint it differs by more: the local
    directions s and n rotate along the arc and are constant along the flank.
    """

    worst: float  # of all pairs of strips
    component: str
    strips: tuple[int, int]  # the pair that has it
    at_joints: tuple[int, ...]  # strips that contain a joint
    elsewhere: float | None  # largest defect of pairs of strips without joints; None if there are none


def reciprocity(ics: Array, contour: Contour, grid: Grid) -> Reciprocity:
    """Return the reciprocity of a raw matrix (n_x, n_s, n_s, 3, 3)."""
    defects = np.max(reciprocity_defects(ics), axis=(2, 3))  # (n_s, n_s)
    first, second = np.unravel_index(np.argmax(defects), defects.shape)
    distances = np.abs(grid.strips[:, None] - np.array(contour.joints))  # (n_s, n_joints)
    has_joint = np.any(distances <= (0.5 + ON_EDGE) * grid.ds, axis=1)
    defects_without_joints = defects[np.ix_(~has_joint, ~has_joint)]
    return Reciprocity(
        float(np.max(defects)),
        Asymmetry.find(ics).component,
        (int(first), int(second)),
        tuple(int(strip) for strip in np.flatnonzero(has_joint)),
        float(np.max(defects_without_joints)) if defects_without_joints.size else None,
    )


# --- parts of a grid ---

FEW_KERNELS = 9  # convolutions with no more are fast on any grid
MOST_DENSE = 96  # strips up to which products of others are 3 to 10 times faster dense between strips


@dataclass(frozen=True, eq=False)
class Part:
    """An operator of which nothing is known, on a part of its grid of some shape."""

    operator: FullOperator
    box: Box
    shape: tuple[int, ...]

    def __call__(self, tractions: Array) -> Array:
        """Return displacements [mm] due to tractions [MPa], shape (n_x, n_s, m) each."""
        return self.box.crop(self.operator(self.box.embed(tractions, self.shape)))

    def restricted(self, directions: tuple[int, ...]) -> "Part":
        """Return the operator from tractions in some directions to displacements in the same."""
        return Part(self.operator.restricted(directions), self.box, self.shape)

    def coarsened(self) -> "Part":
        """Return the operator on elements twice as large; all ends must be even numbers of elements."""
        return Part(self.operator.coarsened(), self.box.coarsened, tuple(n // 2 for n in self.shape))


def restrict_to(operator: FullOperator, box: Box, shape: tuple[int, ...]) -> FullOperator:
    """Return an operator of a grid of some shape on a part of it."""
    if isinstance(operator, GridOperator):
        return operator if box.shape == shape else operator.part(*box.shape[:1], box.strips)
    if not isinstance(operator, Convolution):
        return Part(operator, box, shape)
    part = operator.part(box.shape[0], box.strips)
    return GridOperator.from_convolution(part) if _faster_dense(part) else part


def coarsened(operator: FullOperator) -> FullOperator:
    """Return an operator on elements twice as large, in the form that is fastest there."""
    if isinstance(operator, Convolution) and _faster_dense(operator):
        return GridOperator.from_coarsened(operator)
    return operator.coarsened()


def _faster_dense(operator: Convolution) -> bool:
    return len(operator.kernels) > FEW_KERNELS and operator.shape[1] <= MOST_DENSE
