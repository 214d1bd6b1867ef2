"""How far approximations of a matrix are from C, on hand-made columns of two strips and five lags."""

import numpy as np
import pytest

from femic.ic_errors.matrix_deviation import ReferenceColumn
from femic.reference.matrix.reference import NEAR_ELEMENTS, is_far
from femic.reference.result import EstimatedICs
from geometries.patches import Grid, N, S, X

N_X, N_S = 5, 2
GRID = Grid(N_X, N_S, 0.4, 0.3, 0.0)


def of(**entries):
    """(3, 3, n_x, n_s): each component at (lag, observer)."""
    values = np.zeros((3, 3, N_X, N_S))
    for component, places in entries.items():
        i, j = ("xsn".index(letter) for letter in component)
        for at, value in places.items():
            values[(i, j, *at)] = value
    return values


def collected(columns, estimate=None):
    """Of (difference, C) of each loaded strip; A_nn is 2 everywhere."""
    result = None
    for strip, (difference, c) in enumerate(columns):
        zero = np.zeros_like(c)
        known = EstimatedICs(c, zero if estimate is None else estimate, zero, zero)
        column = ReferenceColumn(known, is_far(strip, GRID), np.full((N_X, N_S), 2.0))
        deviation = column.deviation(difference)
        result = deviation if result is None else result.merge(deviation)
    return result


C = of(nn={(0, 0): 10.0, (1, 1): 3.0, (4, 0): 1.0}, xn={(1, 0): 0.5, (4, 1): 0.02})
NOTHING = np.zeros_like(C)


def test_lags_of_both_signs_count_but_zero_only_once():
    """On strip 0: 10 at lag 0, 1 at lags 4 and -4; on strip 1: 3 at lags 1 and -1."""
    result = collected([(of(nn={(0, 0): 1.2, (4, 0): -0.3}), C)])
    assert result.displacement_error[N, N] == pytest.approx((1.2 + 2 * 0.3) / (10 + 2 * 1))
    assert result.own_displacement_error[N, N] == result.displacement_error[N, N]


def test_loaded_strips_add_up_at_each_observing_strip():
    """Each strip observes both loads: 1.2 + 0.6 on strip 0, 1.5 on strip 1."""
    first, second = of(ss={(0, 0): 1.2, (0, 1): 1.5}), of(ss={(0, 0): -0.6})
    result = collected([(first, C), (second, C)])
    assert result.displacement_error[S, S] == pytest.approx(1.8 / 24)


def test_displacement_error_of_a_component_is_a_share_of_its_own_displacements():
    """xn: 2 x 0.5 on strip 0, 2 x 0.02 on strip 1."""
    result = collected([(of(xn={(1, 0): 0.25}), C)])
    assert result.own_displacement_error[X, N] == pytest.approx(0.5)
    assert result.displacement_error[X, N] == pytest.approx(0.5 / 12)
    everything = collected([(-C, C)])
    assert everything.own_displacement_error[X, N] == 1
    assert everything.displacement_error[X, N] == pytest.approx(1 / 12)


def test_the_worst_entry_far_from_the_load_is_a_share_of_the_largest_there():
    assert is_far(0, GRID)[4].all()
    assert not is_far(0, GRID)[NEAR_ELEMENTS - 1, 0]
    result = collected([(of(xn={(4, 0): 0.01, (1, 1): 5.0}, nn={(4, 1): 7.0}), C)])
    assert result.worst[X, N] == pytest.approx(0.5)  # of 0.02, not of the 0.5 that is near
    assert result.near[X, N] == pytest.approx(2.5)  # of A_nn
    assert result.worst[N, N] == pytest.approx(7)
    assert result.near[N, N] == 0


def test_the_largest_of_the_whole_matrix_counts():
    """The second loaded strip has a C_xn five times as large, and no error."""
    larger = of(nn={(4, 0): 1.0}, xn={(4, 0): 0.1})
    result = collected([(of(xn={(4, 0): 0.01}), C), (NOTHING, larger)])
    assert result.worst[X, N] == pytest.approx(0.1)


@pytest.mark.parametrize(("known", "gone"), [(0.0019, False), (0.0021, True)])
def test_entries_below_ten_times_their_estimate_vanish(known, gone):
    estimate = of(xn={(4, 0): known})
    result = collected([(of(xn={(4, 1): 0.01}), C)], estimate)
    assert result.vanishing[X, N] == gone
    assert result.worst[X, N] == pytest.approx(0.01 / (0.05 if gone else 0.02))
    assert not result.negligible[X, N]  # 1 near the load, known to 0.004


@pytest.mark.parametrize(("known", "gone"), [(0.049, False), (0.051, True)])
def test_displacements_below_ten_times_their_estimate_vanish(known, gone):
    """C_xn causes 2 x 0.5 on strip 0; the estimate of an element counts on both sides."""
    result = collected([(of(xn={(1, 0): 0.3}), C)], of(xn={(2, 0): known}))
    assert result.negligible[X, N] == gone
    assert result.own_displacement_error[X, N] == pytest.approx(0.6 / (0.05 * 12 if gone else 1))
    assert not result.negligible[N, N]


def test_what_is_zero_is_tested_as_a_zero():
    result = collected([(of(sn={(0, 0): 0.3, (4, 0): 0.01}), C)])
    assert result.vanishing[S, N]
    assert result.negligible[S, N]
    assert result.worst[S, N] == pytest.approx(0.01 / 0.05)
    assert result.own_displacement_error[S, N] == pytest.approx(0.32 / (0.05 * 12))
    assert result.displacement_error[S, N] == pytest.approx(0.32 / 12)


def test_a_grid_with_nothing_far_from_the_load_has_no_worst_entry_there():
    small = ReferenceColumn(
        EstimatedICs(C, *[NOTHING] * 3), np.zeros((N_X, N_S), dtype=bool), np.ones((N_X, N_S))
    )
    result = small.deviation(of(nn={(4, 0): 1.0}))
    assert np.all(np.isnan(result.worst))
    assert result.near[N, N] == 1
