"""Small contacts: ICs, distance and motion in the arrays of compiled loops, and what these find.

ICs take their form once for an operator, and motions once for a kind of motion, so that a contact that is
solved again and again, or with another load, friction or creepages, costs little more than its solution.
"""

import logging
import pickle
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary, ref

import numpy as np
from numpy.typing import NDArray

from femic.contact import compiled as at
from femic.contact.compiled import Floats, Products, Work, add_between_strips, multiply, newton, press
from femic.contact.friction.law import Strips
from femic.contact.friction.motion import Motion, RollingStep, SteadyRolling
from femic.contact.loading import Loading
from femic.contact.operators.convolution import Convolution, Waves
from femic.contact.operators.dense import GridOperator
from geometries.arrays import Array, Mask
from geometries.patches import N, S, X

MOST_ELEMENTS = 96  # along x of grids that are small
MOST_IN_KERNEL = 2.2e6  # numbers of a kernel between waves along x and strips: 300 MB for all of them
MOST_WITHOUT_FRICTION = 64  # elements along x or s for pressures alone, which FFT finds quicker from there on
VANISHES = 1e-14  # size of a kernel over the largest one up to which it is zero by symmetry
ROUGH = 1e-2  # tolerance of tangential tractions at pressures that they are going to change
TANGENTIAL = (X, S)

log = logging.getLogger(__name__)


def is_small(shape: tuple[int, int]) -> bool:
    """Whether compiled loops take a contact on a grid of some elements along x and s."""
    n_x, n_s = shape
    return n_x <= MOST_ELEMENTS and (n_x + 1) * n_s**2 <= MOST_IN_KERNEL


class Bodies:
    """ICs of two bodies on a small grid, in the form of compiled loops, with their preconditioners."""

    def __init__(self, operator: GridOperator | Convolution, flat: Convolution) -> None:
        self.flat, self.directions = ref(flat), operator.directions  # of A, flat is the operator itself
        self.shape, m = flat.shape, len(self.directions)
        n_x, n_s = self.shape
        self.kernels = np.zeros((m * m + 1 + (2 if m > 1 else 0), n_x + 1, n_s, n_s))
        ics, inverse, alone = np.split(self.kernels, [m * m, m * m + 1])
        if isinstance(operator, GridOperator):
            ics[:] = _kernels_of_grid(operator)
        else:
            _add_convolution(ics, operator)
        _add_ring(inverse, flat.restricted((N,)).ring_inverse, [(N, N)])
        if m > 1:
            self.tangential = flat.restricted(TANGENTIAL)
            _add_ring(alone, self.tangential.strips_alone, [(X, X), (S, S)])  # xs and sx gain nothing
        sizes = [[max(np.max(part), -np.min(part)) for part in parts] for parts in (ics, inverse, alone)]
        self.there = np.array([size > VANISHES * max(group) for group in sizes for size in group], np.int64)
        self.rough_kernels = np.zeros(self.kernels.shape, np.float32)
        for part in np.flatnonzero(self.there):
            self.rough_kernels[part] = self.kernels[part]
        phases = np.pi / n_x * np.outer(np.arange(n_x + 1), np.arange((n_x + 1) // 2) - (n_x - 1) / 2)
        waves = np.stack([np.cos(phases), np.sin(phases)])
        back = waves / n_x
        back[:, [0, -1]] /= 2
        kinds = [np.dtype(kind) for kind in (np.float64, np.float32)]
        self.transforms = {kind: (waves.astype(kind), back.astype(kind)) for kind in kinds}
        self.motions: dict[tuple[type[Motion], float], tuple[NDArray[np.float32], float]] = {}
        self.unused: dict[int, list[Work]] = {}  # by the number of modes

    @contextmanager
    def borrowed_work(self, modes: int) -> Iterator[Work]:
        """Yield the arrays of a contact with some free modes, tractions and amplitudes zero.

        They serve contacts one after the other; each thread has its own.
        """
        unused = self.unused.setdefault(modes, [])
        try:
            work = unused.pop()
        except IndexError:
            work = self.work(modes)
        work.fields[:], work.small[:], work.numbers[:] = 0.0, 0.0, 0.0
        yield work
        unused.append(work)

    def work(self, modes: int) -> Work:
        """Return new arrays of a contact with some free modes, without distance and motion."""
        n_x, n_s = self.shape
        n, k = n_x * n_s, modes + 1
        settings = np.zeros(at.K_GIVEN + 1, np.int64)
        m = len(self.directions)
        settings[at.OPERATOR], settings[at.STRIDE], settings[at.RING] = (0, 3, 9) if m > 1 else (-N, 0, 1)
        vectors = at.COLUMNS + k + 2 * at.MOST_VECTORS + 1 if m > 1 else 1
        return Work(
            self.products(self.kernels),
            self.products(self.rough_kernels),
            np.zeros((4, n_x, n_x), np.float32),
            np.zeros((at.MODES + 5 * k, n_x, n_s)),
            settings,
            np.zeros(at.LIMIT + 1),
            np.zeros((at.FIELDS, n_x, n_s)),
            np.zeros((at.CHANGES, n_x, n_s), np.float32),
            np.zeros((at.WAS_ACTIVE + 1, n_x, n_s), np.int64),
            np.zeros((at.LEADER + 1, n + 1), np.int64),
            np.zeros((at.NUMBERS, n), np.float32),
            np.empty((2, n_s, n_x, n_x), np.float32),
            np.zeros((2, n_s, n_x), np.int64),
            np.zeros(n_x, np.float32),
            np.empty((vectors, 3 * n + k), np.float32),
            np.zeros((at.MATRICES + 2 * k, k)),
            np.zeros((at.MOST_VECTORS + 4, at.MOST_VECTORS + 1)),
        )

    def products(self, kernels: Floats) -> Products:
        """Return kernels with room for products of the same precision."""
        kind, n_s, (waves, back) = kernels.dtype, self.shape[1], self.transforms[kernels.dtype]
        halves, spectra = np.zeros((12, waves.shape[2], n_s), kind), np.zeros((8, n_s), kind)
        return Products(kernels, self.there, waves, back, halves, spectra)

    @cached_property
    def by_one(self) -> Array:
        """Displacements (n_x, n_s, 3) due to 1 MPa on the middle element: along x and s, and along n."""
        (n_x, n_s), work, both = self.shape, self.work(0), []
        everywhere = (0, 0, n_s)
        for loads in (slice(at.P, at.P + N), slice(at.P + N, at.P + N + 1)):
            work.fields[at.P : at.P + 3] = 0.0
            work.fields[loads, n_x // 2, n_s // 2] = 1.0
            p, u, all_three = work.fields[at.P : at.P + 3], work.fields[at.U : at.U + 3], (0, 3)
            multiply(work.exact, p, u, all_three, all_three, all_three, everywhere, everywhere)
            both.append(np.moveaxis(u, 0, -1).copy())
        return np.concatenate([both[0][..., :N], both[1][..., N:]], axis=-1)

    def strips(self, motion: Motion) -> tuple[NDArray[np.float32], float]:
        """Return how strips of half-spaces slip in a kind of motion, and slip of an element due to itself."""
        kind = type(motion), getattr(motion, "dx", 1.0)
        if kind not in self.motions:
            own = motion.elastic_slip(self.by_one[..., :N])[tuple(n // 2 for n in self.shape)]
            strips = Strips.on_half_spaces(self.tangential, motion)
            self.motions[kind] = np.concatenate([strips.slip, strips.behind]), float(np.mean(own))
        return self.motions[kind]


def _kernels_of_grid(operator: GridOperator) -> Array:
    """Return the kernels (m m, waves, loaded strip, observed strip) of an operator, m its directions."""
    m, waves = len(operator.directions), len(operator.transformed)
    n_s = operator.transformed.shape[1] // m
    parts = operator.transformed.reshape(waves, n_s, m, n_s, m).transpose(2, 4, 0, 3, 1)
    return np.ascontiguousarray(parts, float).reshape(m * m, waves, n_s, n_s)


def _add_convolution(kernels: Array, convolution: Convolution) -> None:
    """Add those of a convolution: each of its kernels times the factors of both strips."""
    (n_x, _), directions = convolution.shape, convolution.directions
    for place, (i, j) in enumerate(product(directions, repeat=2)):
        terms = [
            (
                _waves_along_x(kernel[n_x - 1 :], kernel[: n_x - 1], (i, j)),
                convolution.factors[load],
                convolution.factors[observer],
            )
            for ((to, observer), (by, load)), kernel in convolution.kernels.items()
            if (to, by) == (i, j)
        ]
        if terms:
            add_between_strips(kernels[place], *(np.array(parts) for parts in zip(*terms, strict=True)))


def _add_ring(kernels: Array, waves: Waves, places: Sequence[tuple[int, int]]) -> None:
    """Add those of a map by waves on a ring, for some pairs of its directions."""
    _, n_waves, n_s, _ = kernels.shape
    n_x, padded, ones = n_waves - 1, waves.padded, np.ones((1, n_s))
    lags = np.fft.irfft2(waves.factors, padded, axes=(0, 1))
    along_s = np.arange(1 - n_s, n_s) % padded[1]
    directions = sorted({direction for pair in places for direction in pair})
    for kernel, (i, j) in zip(kernels, places, strict=True):
        own = lags[..., directions.index(i), directions.index(j)][:, along_s]
        in_waves = _waves_along_x(own[:n_x], own[padded[0] + 1 - n_x :], (i, j))
        add_between_strips(kernel, in_waves[None], ones, ones)


def _waves_along_x(ahead: Array, behind: Array, components: tuple[int, int]) -> Array:
    """Return the transform along x, real as in `GridOperator`, of values at lags >= 0 and at those < 0."""
    spectrum = np.fft.rfft(np.concatenate([ahead, np.zeros_like(ahead[:1]), behind]), axis=0)
    observed_along_x, loaded_along_x = (direction == X for direction in components)
    if observed_along_x == loaded_along_x:
        return np.ascontiguousarray(spectrum.real)
    return np.ascontiguousarray(spectrum.imag if observed_along_x else -spectrum.imag)


_BODIES: WeakKeyDictionary[Any, Bodies] = WeakKeyDictionary()


def _bodies(operator: Any, flat: Convolution) -> Bodies | None:
    """Return the ICs of an operator, made once; None where nothing is known of it."""
    bodies = _BODIES.get(operator)
    if bodies is not None and bodies.flat() is flat:
        return bodies
    if not isinstance(operator, GridOperator | Convolution):
        return None
    if operator.directions not in ((X, S, N), (N,)):
        return None
    _announce_compiling()
    bodies = _BODIES[operator] = Bodies(operator, flat)
    return bodies


@lru_cache(maxsize=1)
def _announce_compiling() -> None:
    """Say that the first contact takes long, if there is no machine code that is newer than its source."""
    source = Path(at.__file__)
    folder = Path(newton.stats.cache_path or source.parent)  # type: ignore[attr-defined]
    remove_damaged(folder, source.stem)
    stored = [path.stat().st_mtime for path in folder.glob(f"{source.stem}.{newton.__name__}-*.nbi")]
    if max(stored, default=0.0) < source.stat().st_mtime:
        log.warning("the solver of small contacts is compiled, once on this computer: one to two minutes")


def remove_damaged(folder: Path, module: str) -> None:
    """Remove stored machine code of a module that cannot be read, such as half a file: it is made again."""
    for path in folder.glob(f"{module}.*.nb[ic]"):
        try:
            with path.open("rb") as file:
                pickle.load(file)
                if path.suffix == ".nbi":  # Numba's version, then the index
                    pickle.load(file)
        except OSError:
            continue
        except Exception:  # whatever half a file may raise
            path.unlink(missing_ok=True)


# --- contacts ---


@dataclass(frozen=True, eq=False)
class SmallContact:
    """Bodies, their undeformed distance (n_x, n_s), how surfaces incline, friction, and the area of elements.

    `cosine` and `sine` of the inclination and the coefficient of `friction` are (n_s,) or one number.
    """

    bodies: Bodies
    distance: Array
    cosine: Array
    area: float
    sine: Array | float = 0.0
    friction: Array | float = 0.0

    @classmethod
    def make(cls, operator: Any, flat: Convolution, distance: Array, *others: Any) -> "SmallContact | None":
        """Return the contact; None if its grid is large, or nothing is known of its operator."""
        is_normal = getattr(operator, "directions", None) == (N,)
        fits = is_small(distance.shape) and (not is_normal or max(distance.shape) <= MOST_WITHOUT_FRICTION)
        bodies = _bodies(operator, flat) if fits else None
        return None if bodies is None else cls(bodies, distance, *others)

    @contextmanager
    def work(self, modes: int) -> Iterator[Work]:
        """Yield the arrays of a contact with some free modes, with its surfaces."""
        with self.bodies.borrowed_work(modes) as work:
            given = work.given
            given[at.H], given[at.COSINE], given[at.FRICTION] = self.distance, self.cosine, self.friction
            yield work

    def set_motion(self, work: Work, motion: Motion, loading: Loading) -> None:
        """Write a motion to the arrays of the contact."""
        free = motion.free
        strips, slip_of_one = self.bodies.strips(motion)
        compliance = float(self.bodies.by_one[(*(n // 2 for n in self.distance.shape), N)])
        by_load, settings, given = loading.load is not None, work.settings, work.given
        work.strips[:] = strips
        work.numbers[: at.PEAK] = compliance, 1 / slip_of_one, 1.0
        settings[at.K_GIVEN], settings[at.BY_LOAD] = len(free) + by_load, by_load
        settings[at.DEPTH] = motion.depth
        settings[at.CENTRED] = settings[at.STEADY] = False
        if isinstance(motion, SteadyRolling):
            work.numbers[at.BY_LENGTH] = 1 / motion.dx
            settings[at.CENTRED] = motion.order > 1
            settings[at.STEADY] = not isinstance(motion, RollingStep)
        slip = motion.given_at(0.0)
        per_approach = (motion.given_at(1.0) - slip).transpose(2, 0, 1)
        given[at.GIVEN : at.GIVEN + 2] = slip.transpose(2, 0, 1)
        given[at.PER_APPROACH : at.PER_APPROACH + 2] = per_approach
        modes = given[at.MODES :].reshape(-1, 5, *self.distance.shape)
        for mode, one, slip in zip(modes, free, motion.free_slips, strict=False):
            mode[:2], mode[2:] = np.moveaxis(slip, -1, 0), np.moveaxis(one.weights, -1, 0)
        work.small[at.TARGETS, : len(free)] = [one.force for one in free]
        if by_load:
            modes[-1, :2] = compliance * per_approach
            modes[-1, 3], modes[-1, 4] = -self.area * self.sine, self.area * self.cosine
            work.small[at.TARGETS, -1] = loading.load


def solve_normal(
    contact: SmallContact, loading: Loading, start: Array | None, tolerance: float
) -> tuple[Array, Array, float, int, int, float] | None:
    """Return pressures, gaps, approach, iterations, products and error; None where the contact is not found.

    `start` are pressures to begin with.
    """
    with contact.work(0) as work:
        if start is not None:
            work.fields[at.P + N] = start
        approach, iterations, products, error = press(work, *_given(contact, loading), tolerance)
        if np.isnan(error):
            return None
        p, gap = work.fields[at.P + N].copy(), work.fields[at.GAP].copy()
    return p, gap, approach, iterations, products, error


def _given(contact: SmallContact, loading: Loading) -> tuple[float, float]:
    """Return the sum of c p [MPa], NaN where the approach is given, and this."""
    load = np.nan if loading.load is None else loading.load / contact.area
    return load, 0.0 if loading.approach is None else loading.approach


@dataclass(frozen=True, eq=False)
class Guess:
    """Tractions (n_x, n_s, 3) [MPa], amplitudes of free slips (k,) and approach [mm]."""

    p: Array
    amplitudes: Array
    approach: float


class Found(NamedTuple):
    """Tractions and displacements (n_x, n_s, 3), slip as the motion has it (n_x, n_s, 2), and what sticks.

    `amplitudes` are those of the free modes of the motion.
    """

    p: Array
    u: Array
    slip: Array
    stick: Mask
    amplitudes: Array
    approach: float


def solve_frictional(
    contact: SmallContact, motion: Motion, loading: Loading, start: Guess | None, tolerance: float
) -> Found | None:
    """Return the contact with friction after a motion, None where it is not found.

    It begins with `start`; without one, or where that does not lead on, with pressures without friction, and
    tangential tractions at these.
    """
    with contact.work(len(motion.free)) as work:
        contact.set_motion(work, motion, loading)
        return _find(contact, work, loading, start, tolerance)


def _find(
    contact: SmallContact, work: Work, loading: Loading, start: Guess | None, tolerance: float
) -> Found | None:
    """Return the contact in arrays that have its surfaces and its motion."""
    load, approach = _given(contact, loading)
    amplitudes = work.small[at.C]
    if start is not None:
        work.fields[at.P : at.P + 3] = start.p.transpose(2, 0, 1)
        amplitudes[:-1] = start.amplitudes
        amplitudes[-1] = start.approach if loading.approach is None else approach
        if newton(work, tolerance, False):
            return _found(work)
        amplitudes[:-1] = start.amplitudes
        work.fields[at.P : at.P + 3] = 0.0
    amplitudes[-1], _, _, error = press(work, load, approach, ROUGH)
    if np.isnan(error):
        return None
    if np.any(contact.friction) and not newton(work, ROUGH, True):
        return None
    return _found(work) if newton(work, tolerance, False) else None


def _found(work: Work) -> Found:
    p, u, slip = (
        work.fields[first : first + size].transpose(1, 2, 0).copy()
        for first, size in ((at.P, 3), (at.U, 3), (at.SLIP, 2))
    )
    m, lists = work.settings[at.M], work.lists
    stick = np.zeros(p.shape[:2], bool)
    stick[lists[at.FREE_X, :m], lists[at.FREE_S, :m]] = work.elements[at.STICK, :m] > 0
    stick = np.take_along_axis(stick, work.whole[at.FOLLOWED], axis=0)
    return Found(p, u, slip, stick, work.small[at.C, :-1].copy(), float(work.small[at.C, -1]))
