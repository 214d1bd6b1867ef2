"""Contacts on small grids by compiled loops: the equations of `normal` and `coupled`, for quick contacts.

On some hundreds of elements the time of the other solvers is that of Python between small products. Here the
same methods run as machine code, which Numba compiles once for each computer: conjugate gradients for
pressures (`femic.contact.normal`), and Newton's method for all tractions (`femic.contact.coupled`, where the
equations and their preconditioner are explained), or, to begin with, for the tangential ones at given
pressures. Contacts satisfy the same equations to the same tolerance; `femic.contact.small` prepares them.

Products go wave by wave along x: an IC matrix is real between waves (`GridOperator`), and even and odd parts
about the middle of the grid halve the transforms. Rows and strips that are not in question are left out.

All numbers of a contact stand in the arrays of `Work`, so that nothing is allocated on the way, and compiling
takes a minute and not ten. All compiled functions are in this file, with their constants, because Numba
compiles them anew when the file changes, not when another one does.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from geometries.arrays import Array
from geometries.patches import N, X

MOST_ITERATIONS = 200  # of conjugate gradients
MOST_STEPS = 25  # of Newton's method
MOST_IDLE_STEPS = 6  # in which the error does not fall below the least one before
SHARPER = 0.1  # tolerance of errors and of the linear equations over that of the contact
DECREASE, LEAST_STEP = 0.1, 0.05  # of the defect as a share of a step, and of a full step
LEAST_PRESSURE = 1e-12  # of elements that join a contact, as a share of the largest
LOOSEST = 0.3  # relative residual of the linear equations
MOST_VECTORS = 80  # of GMRES
SINGULAR = 1e-8  # share of the largest entry below which pivots of amplitudes are zero
LEAST_PER_DEPTH = 6  # elements of a row for each that follows at its leading edge
LARGEST_SLIP = 1e8  # in units of tractions, over the largest pressure: beyond it amplitudes run away
TINY = 1e-150

Function = TypeVar("Function", bound=Callable[..., Any])
Floats = NDArray[np.floating[Any]]  # of single or double precision
Whole = int | np.int64
Pair = tuple[Whole, Whole]
Triple = tuple[Whole, Whole, Whole]


def compiled(function: Function) -> Function:
    """Compile a function when it is first called, and keep the machine code for later processes if possible.

    Sums may be reordered; infinite distances stay infinite.
    """
    reordered = {"reassoc", "contract", "arcp", "nsz"}
    options = {"nogil": True, "error_model": "numpy", "fastmath": reordered}
    machine: Function
    try:
        machine = njit(cache=True, **options)(function)
    except RuntimeError:  # no folder can be written
        machine = njit(**options)(function)
    return machine


@compiled
def add_between_strips(kernel: Array, lags: Array, by_load: Array, at_observer: Array) -> None:
    """Add to a kernel (waves, loaded strip, observed strip) a sum of products for all pairs of strips.

    `lags` (terms, waves, 2 n_s - 1) are values at lags from -(n_s - 1) to n_s - 1 of the observed strip from
    the loaded one; `by_load` and `at_observer` (terms, n_s) are factors of both.
    """
    n_s = kernel.shape[1]
    for wave in range(kernel.shape[0]):
        for loaded in range(n_s):
            row = kernel[wave, loaded]
            for term in range(len(lags)):
                from_here, factor = lags[term, wave, n_s - 1 - loaded :], by_load[term, loaded]
                for observed in range(n_s):
                    row[observed] += factor * at_observer[term, observed] * from_here[observed]


# --- names of places ---

# fields (n_x, n_s), some of which have 2 or 3 directions; those of `press` in places that it does not need
P, U, BOUND, RATIO, SHARES, GAP, SLIP, FIELDS = 0, 3, 6, 7, 8, 10, 11, 13
STEP, BY_STEP, LEFT, LAST_LEFT, INVERTED, BY_COSINE, NOW, BEFORE = 3, 4, 6, 7, 8, 9, 11, 12
# changes (n_x, n_s) of fields in a step, and what the approximate inverse takes and gives
DP, DU, DSLIP, ONE, MOVED, CHANGES = 0, 3, 6, 8, 11, 14
# given fields: distance, cosine, friction, slip, slip per approach, then 5 of each mode: slip and weights
H, COSINE, FRICTION, GIVEN, PER_APPROACH, MODES = 0, 1, 2, 3, 5, 7
# numbers of free elements: the derivative of slip at the centre; the direction of tractions, and the law
REST, HALF, TOWARDS, BY_SLIP, BY_BEHIND, DIRECTION, SHARE, STICK, NUMBERS = 0, 1, 2, 4, 6, 8, 10, 11, 12
# whole numbers (n_x, n_s): the row that each element's tractions follow; whether pressures may change
FOLLOWED, ACTIVE, WAS_ACTIVE = 0, 1, 2
# lists: elements in contact and free ones by x and s, and where strips begin among the latter; of one strip,
# rows that follow, and which of its free elements they follow
CONTACT_X, CONTACT_S, FREE_X, FREE_S, BEGINS, FOLLOWER, LEADER = 0, 1, 2, 3, 4, 5, 6
# vectors: residuals, approximate solution, residuals of the law, solution; then columns, basis, steps
RESIDUAL, INVERSE, LAW, SOLUTION, COLUMNS = 0, 1, 2, 3, 4
# settings: whole numbers, then sizes; and real ones
K, BY_LOAD, STEADY, CENTRED, DEPTH, OPERATOR, STRIDE, RING = 0, 1, 2, 3, 4, 5, 6, 7
FIXED, A, M, FIRST, LAST, LOW, BEGIN, K_GIVEN = 8, 9, 10, 11, 12, 13, 14, 15
COMPLIANCE, SCALE, BY_LENGTH, PEAK, LIMIT = 0, 1, 2, 3, 4
# small arrays (rows, k): amplitudes with the approach [mm] last, forces, targets; then matrices
C, UNIT_FORCES, TARGETS, CAUSED, MATRICES = 0, 1, 2, 3, 4
# Numba compiles a function anew for each whole number or bool that is written in a call, but not for those of
# NumPy: places of kernels, directions of products, and whether `invert` has forces
NONE, YES, NO = np.int64(0), np.bool_(True), np.bool_(False)
TWO, THREE = np.int64(2), np.int64(3)
ALONE, ALL, TANGENTIAL, NORMAL = (np.int64(10), NONE), (NONE, THREE), (NONE, TWO), (TWO, THREE)


class Products(NamedTuple):
    """Kernels of one precision, with room for products.

    `kernels` (12, waves, loaded strip, observed strip) are ICs xx, xs, ... nn between waves along x, which
    are real (`GridOperator`), then the inverse of half-spaces for pressures, and two that leave each strip
    alone. For pressures alone there are nn and the inverse. `there` says which kernels do not vanish; `waves`
    (2, waves, half of n_x) are cosines and sines about the middle, and `back` those of the inverse transform.
    """

    kernels: Floats
    there: NDArray[np.int64]
    waves: Floats
    back: Floats
    halves: Floats  # (12, half of n_x, n_s)
    spectra: Floats  # (8, n_s)


class Work(NamedTuple):
    """A contact, and room to compute it in; the names above say what is where.

    Tractions, displacements and residuals are those of double precision; the linear equations of a step have
    single precision, as a step need not be exact.
    """

    exact: Products
    rough: Products
    strips: NDArray[np.float32]  # (4, n_x, n_x), slip by a strip's own tractions, and behind elements
    given: Array
    settings: NDArray[np.int64]
    numbers: Array
    fields: Array
    changes: NDArray[np.float32]
    whole: NDArray[np.int64]
    lists: NDArray[np.int64]
    elements: NDArray[np.float32]
    factors: NDArray[np.float32]  # (2, n_s, n_x, n_x)
    pivots: NDArray[np.int64]  # (2, n_s, n_x)
    strip: NDArray[np.float32]  # (n_x,)
    vectors: NDArray[np.float32]
    small: Array
    krylov: Array  # Hessenberg matrix, then cosines, sines, right-hand side


# --- products ---


@compiled
def multiply(
    w: Products,
    source: Floats,
    target: Floats,
    kernels: Pair,
    loads: Pair,
    observed: Pair,
    within: Triple,
    to: Triple,
) -> None:
    """Write displacements (directions, n_x, n_s) due to tractions (directions, n_x, n_s).

    Tractions have directions `loads` and count in rows and strips `within`; displacements have directions
    `observed` and are written in rows and strips `to`: the number of rows left out at both ends, the first
    strip, and the end of strips. The kernel from j to i is at kernels[0] + i * kernels[1] + j.
    """
    waves, half, n_x = w.waves.shape[1], w.waves.shape[2], source.shape[1]
    low, first_strip, end_strip = within
    out_low, first_observed, end_observed = to
    n_loaded, n_observed = end_strip - first_strip, end_observed - first_observed
    for j in range(loads[0], loads[1]):
        for x in range(low, half):
            y = n_x - 1 - x
            here, beyond = source[j - loads[0], x], source[j - loads[0], y]
            here, beyond = here[first_strip:end_strip], beyond[first_strip:end_strip]
            even, odd = w.halves[j, x], w.halves[3 + j, x]
            for b in range(n_loaded):
                even[b] = here[b] + beyond[b]
                odd[b] = here[b] - beyond[b]
            if x == y:
                for b in range(n_loaded):
                    even[b] = here[b]
    for i in range(observed[0], observed[1]):
        for x in range(out_low, half):
            w.halves[6 + i, x] = 0.0
            w.halves[9 + i, x] = 0.0
    moved_re, moved_im = w.spectra[6], w.spectra[7]
    for wave in range(waves):
        for j in range(loads[0], loads[1]):
            w.spectra[j] = 0.0
            w.spectra[3 + j] = 0.0
            for x in range(low, half):
                cosine, sine = w.waves[0, wave, x], w.waves[1, wave, x]
                even, odd, by_cosine, by_sine = (
                    w.halves[j, x],
                    w.halves[3 + j, x],
                    w.spectra[j],
                    w.spectra[3 + j],
                )
                for b in range(n_loaded):
                    by_cosine[b] += cosine * even[b]
                    by_sine[b] -= sine * odd[b]
        for i in range(observed[0], observed[1]):
            moved_re[:] = 0.0
            moved_im[:] = 0.0
            for j in range(loads[0], loads[1]):
                kernel = kernels[0] + i * kernels[1] + j
                if not w.there[kernel]:
                    continue
                for b in range(n_loaded):
                    row = w.kernels[kernel, wave, first_strip + b]
                    row = row[first_observed:end_observed]
                    re, im = w.spectra[j, b], w.spectra[3 + j, b]
                    if i == X != j:  # times i, as loads along x are to be taken times -i
                        re, im = -im, re
                    elif j == X != i:
                        re, im = im, -re
                    for a in range(n_observed):
                        moved_re[a] += row[a] * re
                        moved_im[a] += row[a] * im
            for x in range(out_low, half):
                even, odd = w.halves[6 + i, x], w.halves[9 + i, x]
                cosine, sine = w.back[0, wave, x], w.back[1, wave, x]
                for a in range(n_observed):
                    even[a] += cosine * moved_re[a]
                    odd[a] -= sine * moved_im[a]
    for i in range(observed[0], observed[1]):
        for x in range(out_low, half):
            even, odd = w.halves[6 + i, x], w.halves[9 + i, x]
            here, beyond = target[i - observed[0], x], target[i - observed[0], n_x - 1 - x]
            here, beyond = here[first_observed:end_observed], beyond[first_observed:end_observed]
            for a in range(n_observed):
                beyond[a] = even[a] - odd[a]
            for a in range(n_observed):
                here[a] = even[a] + odd[a]


# --- pressures ---


@compiled
def press(w: Work, load: float, approach: float, tolerance: float) -> tuple[float, int, int, float]:
    """Find pressures, the field P + N, under a load, the sum of c p, or at an approach where the load is NaN.

    The method and its steps are those of `femic.contact.normal.pressures`. The pressures to begin with are
    those in the field. Returns approach, iterations, products, and the error, NaN where there is none.
    """
    fields, h, cosine = w.fields, w.given[H], w.given[COSINE]
    p, u, gap, step, moved = fields[P + N], fields[U + N], fields[GAP], fields[STEP], fields[BY_STEP]
    residual, last_residual, z, last_z = fields[LEFT], fields[LAST_LEFT], fields[NOW], fields[BEFORE]
    inverse, by_cosine = fields[INVERTED], fields[BY_COSINE]
    pressures, displacements = fields[P + N : P + N + 1], fields[U + N : U + N + 1]
    lefts, inverses = fields[LEFT : LEFT + 1], fields[INVERTED : INVERTED + 1]
    steps, by_steps = fields[STEP : STEP + 1], fields[BY_STEP : BY_STEP + 1]
    active, was_active = w.whole[ACTIVE], w.whole[WAS_ACTIVE]
    n_x, n_s = h.shape
    by_load, total, everywhere = not np.isnan(load), 0.0, (NONE, NONE, n_s)
    operator, ring = (w.settings[OPERATOR], w.settings[STRIDE]), (w.settings[RING] - N, NONE)
    for x in range(n_x):
        for s in range(n_s):
            p[x, s] = max(p[x, s], 0.0) if h[x, s] < np.inf else 0.0
            total += p[x, s]
            residual[x, s] = max(approach * cosine[x, s] - h[x, s], 0.0)
            was_active[x, s] = 0
            step[x, s] = 0.0
    if total == 0.0:
        if not by_load:
            multiply(w.exact, lefts, inverses, ring, NORMAL, NORMAL, everywhere, everywhere)
        for x in range(n_x):
            for s in range(n_s):
                pressure = 1.0 if by_load else max(inverse[x, s], 0.0)
                p[x, s] = pressure if h[x, s] < np.inf else 0.0
    if by_load:
        scale(w, load)
    multiply(w.exact, pressures, displacements, operator, NORMAL, NORMAL, everywhere, everywhere)
    products, zeta = 1, approach
    for iteration in range(MOST_ITERATIONS + 1):
        if by_load:
            above, below = 0.0, 0.0
            for x in range(n_x):
                for s in range(n_s):
                    if p[x, s] > 0:
                        above += cosine[x, s] * (u[x, s] + h[x, s])
                        below += cosine[x, s] * cosine[x, s]
            zeta = above / below
        same, peak, largest = True, 0.0, 0.0
        for x in range(n_x):
            for s in range(n_s):
                gap[x, s] = u[x, s] + h[x, s] - zeta * cosine[x, s]
                is_active = 1 if h[x, s] < np.inf and (p[x, s] > 0 or gap[x, s] < 0) else 0
                same = same and is_active == was_active[x, s]
                active[x, s] = is_active
                peak = max(peak, p[x, s])
        share = 0.0
        if by_load:  # directions do not change it
            for x in range(n_x):
                for s in range(n_s):
                    residual[x, s] = cosine[x, s] if active[x, s] else 0.0
            multiply(w.exact, lefts, inverses, ring, NORMAL, NORMAL, everywhere, everywhere)
            below = 0.0
            for x in range(n_x):
                for s in range(n_s):
                    by_cosine[x, s] = inverse[x, s] if active[x, s] else 0.0
                    below += residual[x, s] * by_cosine[x, s]
            share = 1 / below
        for x in range(n_x):
            for s in range(n_s):
                residual[x, s] = gap[x, s] if active[x, s] else 0.0
        multiply(w.exact, lefts, inverses, ring, NORMAL, NORMAL, everywhere, everywhere)
        if by_load:
            above = 0.0
            for x in range(n_x):
                for s in range(n_s):
                    if active[x, s]:
                        above += cosine[x, s] * inverse[x, s]
            share *= above
        above, below = 0.0, 0.0
        for x in range(n_x):
            for s in range(n_s):
                value = 0.0
                if active[x, s]:
                    value = inverse[x, s] - (share * by_cosine[x, s] if by_load else 0.0)
                above += value * (residual[x, s] - last_residual[x, s])
                below += last_z[x, s] * last_residual[x, s]
                largest = max(largest, abs(value))
                z[x, s] = value
        error = largest / peak if peak > 0 else (np.inf if largest > 0 else 0.0)
        if error <= tolerance:
            return zeta, iteration, products, error
        beta = max(0.0, above / below) if same and iteration else 0.0
        for x in range(n_x):
            for s in range(n_s):
                step[x, s] = z[x, s] + beta * step[x, s]
                last_z[x, s] = z[x, s]
                last_residual[x, s] = residual[x, s]
                was_active[x, s] = active[x, s]
        multiply(w.exact, steps, by_steps, operator, NORMAL, NORMAL, everywhere, everywhere)
        products += 1
        along, curvature = 0.0, 0.0
        for x in range(n_x):
            for s in range(n_s):
                along += residual[x, s] * step[x, s]
                curvature += step[x, s] * moved[x, s]
        if not curvature > 0:
            return zeta, iteration, products, np.nan
        is_negative = False
        for x in range(n_x):
            for s in range(n_s):
                p[x, s] -= along / curvature * step[x, s]
                u[x, s] -= along / curvature * moved[x, s]
                is_negative = is_negative or p[x, s] < 0
        if is_negative:
            for x in range(n_x):
                for s in range(n_s):
                    p[x, s] = max(p[x, s], 0.0)
            if by_load:
                scale(w, load)
            multiply(w.exact, pressures, displacements, operator, NORMAL, NORMAL, everywhere, everywhere)
            products += 1
    return zeta, MOST_ITERATIONS, products, np.nan


@compiled
def scale(w: Work, load: float) -> None:
    """Give the pressures a load."""
    p, cosine, total = w.fields[P + N], w.given[COSINE], 0.0
    for x in range(p.shape[0]):
        for s in range(p.shape[1]):
            total += cosine[x, s] * p[x, s]
    for x in range(p.shape[0]):
        for s in range(p.shape[1]):
            p[x, s] *= load / total


# --- all tractions: the state ---


@compiled
def settle(w: Work, fixed: bool) -> None:
    """Leave no negative pressures; list elements in contact and free ones; let followers follow."""
    fields, bounds, ratios, lists, settings = w.fields, w.fields[BOUND], w.fields[RATIO], w.lists, w.settings
    n_x, n_s = bounds.shape
    a = m = 0
    settings[FIRST], settings[LAST], settings[LOW], w.numbers[PEAK], limit = n_s, 0, n_x, 0.0, 0.0
    for s in range(n_s):
        lists[BEGINS, s] = m
        for x in range(n_x):
            pressure = max(fields[P + N, x, s], 0.0) if w.given[H, x, s] < np.inf else 0.0
            fields[P + N, x, s] = pressure
            bounds[x, s] = w.given[FRICTION, x, s] * pressure
            w.numbers[PEAK], limit = max(w.numbers[PEAK], pressure), max(limit, bounds[x, s])
            if pressure > 0:
                lists[CONTACT_X, a], lists[CONTACT_S, a] = x, s
                a += 1
                settings[FIRST], settings[LAST] = min(s, settings[FIRST]), s + 1
                settings[LOW] = min(settings[LOW], max(min(x, n_x - 1 - x) - 1, 0))  # with neighbours
        end = 0
        for x in range(n_x):
            if x >= end:  # of a row in contact
                end = x
                while end < n_x and bounds[end, s] > 0:
                    end += 1
                following = min(settings[DEPTH], (end - x) // LEAST_PER_DEPTH)
            followed, ratio = x, 0.0
            if x < end:
                followed = x - max(following - (end - 1 - x), 0)
                ratio = bounds[x, s] / bounds[followed, s]
                if followed == x:
                    lists[FREE_X, m], lists[FREE_S, m] = x, s
                    m += 1
            w.whole[FOLLOWED, x, s], ratios[x, s] = followed, ratio
            for t in range(2):
                fields[P + t, x, s] = fields[P + t, followed, s] * ratio
                fields[SHARES + t, x, s] = fields[P + t, x, s] / bounds[x, s] if ratio > 0 else 0.0
    lists[BEGINS, n_s] = m
    w.numbers[LIMIT] = max(min(limit, w.numbers[PEAK]), TINY)
    settings[FIXED], settings[A], settings[M], settings[BEGIN] = fixed, a, m, 0 if fixed else a
    settings[K] = settings[K_GIVEN] - (1 if fixed and settings[BY_LOAD] else 0)


@compiled
def join(w: Work) -> bool:
    """Let elements with overlap join the contact with little pressure; return whether there are any."""
    n_x, n_s = w.given.shape[1], w.given.shape[2]
    approach, joins = w.small[C, w.small.shape[1] - 1], False
    for x in range(n_x):
        for s in range(n_s):
            gap = w.fields[U + N, x, s] + w.given[H, x, s] - approach * w.given[COSINE, x, s]
            if gap < 0 and w.fields[P + N, x, s] <= 0:
                w.fields[P + N, x, s], joins = LEAST_PRESSURE * w.numbers[PEAK], True
    return joins


@compiled
def evaluate(w: Work) -> float:
    """Compute slip, law, and residuals; return the norm of defects of law and forces, inf if too large."""
    fields, given, elements, settings, small = w.fields, w.given, w.elements, w.settings, w.small
    n_x = given.shape[1]
    a, m, k, begin = settings[A], settings[M], settings[K], settings[BEGIN]
    first, last = settings[FIRST], settings[LAST]
    residual, slips, approach = w.vectors[RESIDUAL], fields[SLIP : SLIP + 2], small[C, small.shape[1] - 1]
    modes = settings[K_GIVEN] - settings[BY_LOAD]
    for t in range(2):
        for x in range(n_x):
            ahead = min(x + 1, n_x - 1)
            for s in range(first, last):
                slip = fields[U + t, x, s] - (fields[U + t, ahead, s] if settings[STEADY] else 0.0)
                slip = slip * w.numbers[BY_LENGTH] + given[GIVEN + t, x, s]
                slip += approach * given[PER_APPROACH + t, x, s]
                for mode in range(modes):
                    slip += small[C, mode] * given[MODES + 5 * mode + t, x, s]
                slips[t, x, s] = slip
    if begin:
        for e in range(a):
            x, s = w.lists[CONTACT_X, e], w.lists[CONTACT_S, e]
            gap = fields[U + N, x, s] + given[H, x, s] - approach * given[COSINE, x, s]
            residual[e] = gap / w.numbers[COMPLIANCE]
    squares = 0.0
    for e in range(m):
        x, s = w.lists[FREE_X, e], w.lists[FREE_S, e]
        elements[REST, e], weight, by_sizes, by_product = 1.0, 0.0, 0.0, 0.0
        behind, length, length_behind, product = max(x - 1, 0), 0.0, 0.0, 0.0
        for t in range(2):
            length += slips[t, x, s] * slips[t, x, s]
            length_behind += slips[t, behind, s] * slips[t, behind, s]
            product += slips[t, x, s] * slips[t, behind, s]
        length, length_behind = max(np.sqrt(length), TINY), max(np.sqrt(length_behind), TINY)
        both = length + length_behind
        if settings[CENTRED] and product > 0:
            weight, by_product = 4 * product / (both * both), 4 / (both * both)
            by_sizes = 2 * weight / both
        elements[REST, e], elements[HALF, e] = 1 - weight / 2, weight / 2
        bound, square = fields[BOUND, x, s], 0.0
        for t in range(2):
            here, there = slips[t, x, s], slips[t, behind, s]
            elements[TOWARDS + t, e] = (there - here) / 2
            elements[BY_SLIP + t, e] = by_product * there - by_sizes * here / length
            elements[BY_BEHIND + t, e] = by_product * here - by_sizes * there / length_behind
            trial = fields[P + t, x, s] - w.numbers[SCALE] * (here + weight * (there - here) / 2)
            square += trial * trial
        size = max(np.sqrt(square), TINY)
        if not size < LARGEST_SLIP * w.numbers[PEAK]:
            return np.inf
        sticks, share = size <= bound, min(bound / size, 1.0)
        elements[STICK, e], elements[SHARE, e] = 1.0 if sticks else 0.0, share
        for t in range(2):
            q, here, there = fields[P + t, x, s], slips[t, x, s], slips[t, behind, s]
            trial = q - w.numbers[SCALE] * (here + weight * (there - here) / 2)
            defect, direction = q - share * trial, trial / size
            squares += defect * defect
            elements[DIRECTION + t, e] = direction
            slides = q - bound * direction
            residual[begin + 2 * e + t] = w.numbers[SCALE] * here if sticks else slides
    for other in range(k):
        unit, force = 0.0, 0.0
        for e in range(a):
            x, s = w.lists[CONTACT_X, e], w.lists[CONTACT_S, e]
            for i in range(3):
                weight = given[MODES + 5 * other + 2 + i, x, s]
                unit += abs(weight)
                force += weight * fields[P + i, x, s]
        small[UNIT_FORCES, other] = unit
        missing = (force - small[TARGETS, other]) / unit
        residual[begin + 2 * m + other] = missing
        squares += missing * missing
    return np.sqrt(squares)


# --- the linear equations ---


@compiled
def spread(w: Work, v: Floats) -> None:
    """Write changes of all tractions, the fields DP, due to a vector of unknowns, and those of forces."""
    fields, changes, lists, settings = w.fields, w.changes, w.lists, w.settings
    a, m, begin = settings[A], settings[M], settings[BEGIN]
    for e in range(a):
        x, s = lists[CONTACT_X, e], lists[CONTACT_S, e]
        changes[DP, x, s] = changes[DP + 1, x, s] = 0.0
        changes[DP + N, x, s] = v[e] if begin else 0.0
    for e in range(m):
        x, s = lists[FREE_X, e], lists[FREE_S, e]
        changes[DP, x, s], changes[DP + 1, x, s] = v[begin + 2 * e], v[begin + 2 * e + 1]
    for e in range(a):
        x, s = lists[CONTACT_X, e], lists[CONTACT_S, e]
        followed, ratio = w.whole[FOLLOWED, x, s], fields[RATIO, x, s]
        if followed != x and ratio > 0:
            pressure = changes[DP + N, x, s] - ratio * changes[DP + N, followed, s]
            bound = w.given[FRICTION, x, s] * pressure
            for t in range(2):
                own = fields[SHARES + t, x, s] * bound
                changes[DP + t, x, s] = changes[DP + t, followed, s] * ratio + own
    for other in range(settings[K]):
        total = 0.0
        for e in range(a):
            x, s = lists[CONTACT_X, e], lists[CONTACT_S, e]
            for i in range(3):
                total += w.given[MODES + 5 * other + 2 + i, x, s] * changes[DP + i, x, s]
        w.small[CAUSED, other] = total / w.small[UNIT_FORCES, other]


@compiled
def change_law(w: Work, source: int, v: Floats, result: Floats) -> None:
    """Write changes of the law due to those of tractions in a vector, slip in two fields, pressures DP."""
    changes, elements, settings, size = w.changes, w.elements, w.settings, np.float32(w.numbers[SCALE])
    begin = settings[BEGIN]
    for e in range(settings[M]):
        x, s = w.lists[FREE_X, e], w.lists[FREE_S, e]
        slip0, slip1 = changes[source, x, s], changes[source + 1, x, s]
        place = begin + 2 * e
        if elements[STICK, e] > 0:
            result[place], result[place + 1] = size * slip0, size * slip1
            continue
        centre0, centre1 = elements[REST, e] * slip0, elements[REST, e] * slip1
        if settings[CENTRED]:
            behind = max(x - 1, 0)
            behind0, behind1 = changes[source, behind, s], changes[source + 1, behind, s]
            weight = elements[BY_SLIP, e] * slip0 + elements[BY_SLIP + 1, e] * slip1
            weight += elements[BY_BEHIND, e] * behind0 + elements[BY_BEHIND + 1, e] * behind1
            centre0 += elements[HALF, e] * behind0 + weight * elements[TOWARDS, e]
            centre1 += elements[HALF, e] * behind1 + weight * elements[TOWARDS + 1, e]
        trial0, trial1 = v[place] - size * centre0, v[place + 1] - size * centre1
        d0, d1, share = elements[DIRECTION, e], elements[DIRECTION + 1, e], elements[SHARE, e]
        along = d0 * trial0 + d1 * trial1
        bound = w.given[FRICTION, x, s] * changes[DP + N, x, s] if begin else 0.0
        result[place] = v[place] - share * (trial0 - along * d0) - bound * d0
        result[place + 1] = v[place + 1] - share * (trial1 - along * d1) - bound * d1


@compiled
def derive(w: Work, v: Floats, result: Floats) -> None:
    """Write the change of residuals due to unknowns."""
    changes, given, settings = w.changes, w.given, w.settings
    a, m, k, begin = settings[A], settings[M], settings[K], settings[BEGIN]
    first, last, low = settings[FIRST], settings[LAST], settings[LOW]
    spread(w, v)
    part, operator = (low, first, last), (settings[OPERATOR], settings[STRIDE])
    which = ALL if begin else TANGENTIAL
    multiply(w.rough, changes[DP : DP + 3], changes[DU : DU + 3], operator, which, which, part, part)
    n_x, others, approach = given.shape[1], begin + 2 * m, 0.0
    by_length, behind = np.float32(w.numbers[BY_LENGTH]), np.float32(1.0 if settings[STEADY] else 0.0)
    if begin and settings[BY_LOAD]:
        approach = v[others + k - 1] * w.numbers[COMPLIANCE]
    for t in range(2):
        for x in range(n_x):
            ahead = min(x + 1, n_x - 1)
            here, beyond, slip = changes[DU + t, x], changes[DU + t, ahead], changes[DSLIP + t, x]
            for s in range(first, last):
                slip[s] = by_length * (here[s] - behind * beyond[s])
            for mode in range(k):
                for s in range(first, last):
                    slip[s] += v[others + mode] * given[MODES + 5 * mode + t, x, s]
    if begin:
        for e in range(a):
            x, s = w.lists[CONTACT_X, e], w.lists[CONTACT_S, e]
            change = changes[DU + N, x, s] - approach * given[COSINE, x, s]
            result[e] = change / w.numbers[COMPLIANCE]
    change_law(w, DSLIP, v, result)
    for other in range(k):
        result[others + other] = w.small[CAUSED, other]


# --- their approximate inverse ---


@compiled
def factorize(w: Work) -> None:
    """Factorize the equations of each strip along x and s, those of half-spaces without other strips."""
    n_x, n_s = w.given.shape[1], w.given.shape[2]
    elements, lists, size = w.elements, w.lists, np.float32(w.numbers[SCALE])
    for s in range(n_s):
        start, n, followers = lists[BEGINS, s], lists[BEGINS, s + 1] - lists[BEGINS, s], 0
        for loaded in range(n_x if n else 0):
            if w.whole[FOLLOWED, loaded, s] != loaded and w.fields[RATIO, loaded, s] > 0:
                lists[FOLLOWER, followers] = loaded
                column = 0
                while lists[FREE_X, start + column] != w.whole[FOLLOWED, loaded, s]:
                    column += 1
                lists[LEADER, followers] = column
                followers += 1
        for t in range(2):
            matrix, slip, behind = w.factors[t, s], w.strips[t], w.strips[2 + t]
            for row in range(n):
                e = start + row
                x, by_traction, by_slip, by_behind = lists[FREE_X, e], 0.0, 1.0, 0.0
                if elements[STICK, e] == 0:
                    along, own, own_along, back, back_along = elements[DIRECTION + t, e], 0.0, 0.0, 0.0, 0.0
                    for i in range(2):
                        by_own = elements[BY_SLIP + t, e] * elements[TOWARDS + i, e]
                        by_back = elements[BY_BEHIND + t, e] * elements[TOWARDS + i, e]
                        if i == t:
                            by_own, by_back = by_own + elements[REST, e], by_back + elements[HALF, e]
                            own, back = by_own, by_back
                        own_along += elements[DIRECTION + i, e] * by_own
                        back_along += elements[DIRECTION + i, e] * by_back
                    own, back = own - along * own_along, back - along * back_along
                    if x == 0:  # the element behind it is itself
                        own, back = own + back, 0.0
                    share = elements[SHARE, e]
                    by_traction, by_slip, by_behind = (
                        1 - share * (1 - along * along),
                        share * own,
                        share * back,
                    )
                own_factor, back_factor = size * np.float32(by_slip), size * np.float32(by_behind)
                for column in range(n):
                    loaded = lists[FREE_X, start + column]
                    matrix[row, column] = own_factor * slip[x, loaded] + back_factor * behind[x, loaded]
                matrix[row, row] += np.float32(by_traction)
                for follower in range(followers):
                    loaded = lists[FOLLOWER, follower]
                    more = own_factor * slip[x, loaded] + back_factor * behind[x, loaded]
                    matrix[row, lists[LEADER, follower]] += np.float32(w.fields[RATIO, loaded, s]) * more
            for j in range(n):
                pivot = j
                for i in range(j + 1, n):
                    if abs(matrix[i, j]) > abs(matrix[pivot, j]):
                        pivot = i
                w.pivots[t, s, j] = pivot
                if pivot != j:
                    for column in range(n):
                        matrix[j, column], matrix[pivot, column] = matrix[pivot, column], matrix[j, column]
                inverse = np.float32(1) / matrix[j, j] if matrix[j, j] != 0 else np.float32(0)
                matrix[j, j] = inverse
                for i in range(j + 1, n):
                    factor = matrix[i, j] * inverse
                    matrix[i, j] = factor
                    for column in range(j + 1, n):
                        matrix[i, column] -= factor * matrix[j, column]


@compiled
def invert(w: Work, v: Floats, result: Floats, with_others: bool | np.bool_) -> None:
    """Write approximately pressures and tractions that cause residuals of gaps and of the law.

    Pressures follow from gaps, then tractions from the law at their bounds. Slip where elements stick is that
    by all strips: it is changed to that by each strip alone.
    """
    changes, elements, lists, settings = w.changes, w.elements, w.lists, w.settings
    a, m, begin, first, last = settings[A], settings[M], settings[BEGIN], settings[FIRST], settings[LAST]
    part = settings[LOW], first, last
    if begin:
        for e in range(a):
            changes[ONE + N, lists[CONTACT_X, e], lists[CONTACT_S, e]] = v[e] * w.numbers[COMPLIANCE]
        residuals, pressures = changes[ONE + N : ONE + 3], changes[MOVED + N : MOVED + 3]
        ring = settings[RING] - N, NONE
        multiply(w.rough, residuals, pressures, ring, NORMAL, NORMAL, part, part)
        for e in range(a):
            result[e] = changes[MOVED + N, lists[CONTACT_X, e], lists[CONTACT_S, e]]
    any_sticks = False
    for e in range(m):
        x, s, sticks = lists[FREE_X, e], lists[FREE_S, e], elements[STICK, e] > 0
        any_sticks = any_sticks or sticks
        for t in range(2):
            changes[ONE + t, x, s] = v[begin + 2 * e + t] if sticks else 0.0
    if any_sticks:
        for t in range(2):
            slip, alone, one = changes[ONE + t : ONE + t + 1], changes[MOVED + t : MOVED + t + 1], (t, t + 1)
            multiply(w.rough, slip, alone, ALONE, one, one, part, part)
    for e in range(m):
        x, s = lists[FREE_X, e], lists[FREE_S, e]
        bound = w.given[FRICTION, x, s] * changes[MOVED + N, x, s] if begin else 0.0
        for t in range(2):
            place = begin + 2 * e + t
            slides = v[place] + bound * elements[DIRECTION + t, e]
            result[place] = changes[MOVED + t, x, s] if elements[STICK, e] > 0 else slides
    q = w.strip
    for s in range(first, last):
        n, start = lists[BEGINS, s + 1] - lists[BEGINS, s], begin + 2 * lists[BEGINS, s]
        for t in range(2):
            matrix = w.factors[t, s]
            for i in range(n):
                q[i] = result[start + 2 * i + t]
            for j in range(n):
                pivot = w.pivots[t, s, j]
                q[j], q[pivot] = q[pivot], q[j]
            for i in range(1, n):
                row, total = matrix[i], np.float32(0.0)
                for j in range(i):
                    total += row[j] * q[j]
                q[i] -= total
            for i in range(n - 1, -1, -1):
                row, total = matrix[i], np.float32(0.0)
                for j in range(i + 1, n):
                    total += row[j] * q[j]
                q[i] = (q[i] - total) * row[i]
            for i in range(n):
                result[start + 2 * i + t] = q[i]
    if not with_others:
        return
    spread(w, result)
    k, others = settings[K], begin + 2 * m
    for i in range(k):
        other = 0.0
        for j in range(k):
            other += w.small[MATRICES + k + i, j] * (v[others + j] - w.small[CAUSED, j])
        result[others + i] = other
        for e in range(others):
            result[e] -= other * w.vectors[COLUMNS + i, e]


@compiled
def prepare(w: Work) -> None:
    """Prepare the approximate inverse: factors of strips, and what amplitudes and approach do to forces."""
    lists, settings, small = w.lists, w.settings, w.small
    m, k, begin = settings[M], settings[K], settings[BEGIN]
    factorize(w)
    none, residual = w.vectors[INVERSE], w.vectors[LAW]
    matrix, inverse = small[MATRICES : MATRICES + k], small[MATRICES + k : MATRICES + 2 * k]
    for mode in range(k):
        for e in range(begin + 2 * m):
            none[e] = residual[e] = 0.0
        if mode == k - 1 and settings[BY_LOAD]:
            for e in range(begin):
                residual[e] = -w.given[COSINE, lists[CONTACT_X, e], lists[CONTACT_S, e]]
        spread(w, none)
        for e in range(m):
            x, s = lists[FREE_X, e], lists[FREE_S, e]
            for y in (x, max(x - 1, 0)):
                for t in range(2):
                    w.changes[DSLIP + t, y, s] = w.given[MODES + 5 * mode + t, y, s]
        change_law(w, DSLIP, none, residual)
        invert(w, residual, w.vectors[COLUMNS + mode], NO)
        spread(w, w.vectors[COLUMNS + mode])
        for other in range(k):
            matrix[other, mode] = -small[CAUSED, other]
    for i in range(k):
        for j in range(k):
            inverse[i, j] = 1.0 if i == j else 0.0
    largest = 0.0
    for i in range(k):
        for j in range(k):
            largest = max(largest, abs(matrix[i, j]))
    for j in range(k):  # Gauss and Jordan, without unknowns that change nothing
        pivot = j
        for i in range(j + 1, k):
            if abs(matrix[i, j]) > abs(matrix[pivot, j]):
                pivot = i
        for column in range(k):
            matrix[j, column], matrix[pivot, column] = matrix[pivot, column], matrix[j, column]
            inverse[j, column], inverse[pivot, column] = inverse[pivot, column], inverse[j, column]
        factor = 1 / matrix[j, j] if abs(matrix[j, j]) > SINGULAR * largest else 0.0
        for column in range(k):
            matrix[j, column] *= factor
            inverse[j, column] *= factor
        for i in range(k):
            if i != j:
                factor = matrix[i, j]
                for column in range(k):
                    matrix[i, column] -= factor * matrix[j, column]
                    inverse[i, column] -= factor * inverse[j, column]


# --- Newton's method ---


@compiled
def newton(w: Work, tolerance: float, fixed: bool) -> bool:
    """Seek a contact from the tractions of the fields P; return whether it was found.

    `fixed`: pressures and the approach stay. Then steps are halved until the defects of law and forces fall.
    """
    fields, changes, settings, small = w.fields, w.changes, w.settings, w.small
    p, u, dp, du = fields[P : P + 3], fields[U : U + 3], changes[DP : DP + 3], changes[DU : DU + 3]
    n_x, n_s = w.given.shape[1], w.given.shape[2]
    operator, solution = (settings[OPERATOR], settings[STRIDE]), w.vectors[SOLUTION]
    least, idle = np.inf, 0
    settle(w, fixed)
    for turn in range(MOST_STEPS + 1):
        first, last, low = settings[FIRST], settings[LAST], settings[LOW]
        if not fixed or turn == 0:
            multiply(w.exact, p, u, operator, ALL, ALL, (low, first, last), (NONE, NONE, n_s))
            if not fixed and join(w):
                settle(w, fixed)
        a, m, k, begin = settings[A], settings[M], settings[K], settings[BEGIN]
        if a == 0:
            return False
        first, last, low = settings[FIRST], settings[LAST], settings[LOW]
        for f in range(CHANGES):
            for x in range(n_x):
                for s in range(first, last):
                    changes[f, x, s] = 0.0
        others = begin + 2 * m
        n = others + k
        defect = evaluate(w)
        if not defect < np.inf:
            return False
        prepare(w)
        v = w.vectors[INVERSE]
        invert(w, w.vectors[RESIDUAL], v, YES)
        modes = others + settings[K_GIVEN] - settings[BY_LOAD]
        largest = largest_tangential = 0.0
        for e in range(n):
            size = abs(v[e] if e < others else w.vectors[RESIDUAL, e])
            if begin <= e < modes:
                largest_tangential = max(largest_tangential, size)
            else:
                largest = max(largest, size)
        error = max(largest / w.numbers[PEAK], largest_tangential / w.numbers[LIMIT])
        if error <= SHARPER * tolerance:
            return True
        if not error < np.inf:
            return False
        idle = 0 if error < least else idle + 1
        least = min(least, error)
        if idle >= MOST_IDLE_STEPS:
            return False
        correct(w, n, min(LOOSEST, max(SHARPER * tolerance / error, error)))
        spread(w, solution)
        if fixed:
            part = low, first, last
            multiply(w.rough, dp, du, operator, TANGENTIAL, TANGENTIAL, part, part)
        share, change = 1.0, 1.0
        while True:
            for f in range(2 if fixed else 3):
                for x in range(n_x):
                    for s in range(first, last):
                        p[f, x, s] += change * dp[f, x, s]
                        if fixed:
                            u[f, x, s] += change * du[f, x, s]
            for other in range(k):
                step = change * solution[others + other]
                if settings[BY_LOAD] and not fixed and other == k - 1:
                    small[C, small.shape[1] - 1] += step * w.numbers[COMPLIANCE]
                else:
                    small[C, other] += step
            if not fixed or share <= LEAST_STEP or evaluate(w) <= (1 - DECREASE * share) * defect:
                break
            share, change = share / 2, -share / 2
        if not fixed:
            settle(w, fixed)
    return False


@compiled
def correct(w: Work, n: int, rtol: float) -> None:
    """Write the change of n unknowns that takes residuals away, by GMRES, preconditioned from the right.

    The vector INVERSE is what `invert` makes of the residuals.
    """
    residual, solution, h = w.vectors[RESIDUAL], w.vectors[SOLUTION], w.krylov
    basis = w.vectors[COLUMNS + w.small.shape[1] :]
    steps = basis[MOST_VECTORS + 1 :]
    norm, square = 0.0, np.float32(0.0)
    for e in range(n):
        norm += np.float64(residual[e]) * np.float64(residual[e])
        solution[e] = 0.0
    norm = np.sqrt(norm)
    if norm == 0.0:
        return
    for e in range(n):
        basis[0, e] = -residual[e] / norm
    cosines, sines, right = h[MOST_VECTORS + 1], h[MOST_VECTORS + 2], h[MOST_VECTORS + 3]
    right[0] = norm
    size = 0
    for j in range(min(MOST_VECTORS, n)):
        if j == 0:
            for e in range(n):
                steps[0, e] = -w.vectors[INVERSE, e] / norm
        else:
            invert(w, basis[j], steps[j], YES)
        derive(w, steps[j], basis[j + 1])
        for i in range(j + 2):  # the last turn is the length of what is left
            dot = np.float32(0.0)
            for e in range(n):
                dot += basis[min(i, j + 1), e] * basis[j + 1, e]
            if i == j + 1:
                square = dot
                break
            h[i, j] = dot
            for e in range(n):
                basis[j + 1, e] -= dot * basis[i, e]
        last = np.sqrt(square)
        if not last < np.inf:
            break
        for e in range(n):
            basis[j + 1, e] /= max(last, TINY)
        for i in range(j):
            above, below = h[i, j], h[i + 1, j]
            h[i, j] = cosines[i] * above + sines[i] * below
            h[i + 1, j] = cosines[i] * below - sines[i] * above
        length = max(np.sqrt(h[j, j] * h[j, j] + square), TINY)
        cosines[j], sines[j], h[j, j] = h[j, j] / length, last / length, length
        right[j + 1] = -sines[j] * right[j]
        right[j] *= cosines[j]
        size = j + 1
        if abs(right[size]) <= rtol * norm:
            break
    for i in range(size - 1, -1, -1):
        total = right[i]
        for j in range(i + 1, size):
            total -= h[i, j] * right[j]
        right[i] = total / h[i, i]
        for e in range(n):
            solution[e] += right[i] * steps[i, e]
