"""The measure of errors on hand-made ICs whose shares are known without a computer."""

from dataclasses import replace

import numpy as np
import pytest

from femic.ic_errors.error_measure import Measure, far_from
from femic.reference.result import EstimatedICs
from geometries.patches import N, Patch, S, X

NEAR, FAR = "near", "far"  # two lines of three points each
LINES = {NEAR: slice(0, 3), FAR: slice(3, 6)}
EVERYWHERE = np.ones(6, dtype=bool)  # far from the load
A_NN = np.array([5.0, 6.0, 5.0, 0.5, 1.0, 0.5])


def of(ic, estimate=None):
    zero = np.zeros_like(ic)
    return EstimatedICs(ic, zero if estimate is None else estimate, zero, zero)


@pytest.fixture
def c():
    """C_nn up to 4 near and 1 far; C_xn up to 0.02, 0.1 of what 5 % of C_nn is; C_sn 0."""
    ic = np.zeros((3, 3, 6))
    ic[N, N] = [3, 4, 3, -0.5, 1, 0.5]
    ic[X, N] = [-0.02, 0, 0.01, 0, 0.005, 0]
    ic[X, X] = [2, 2, 1, 1, 1, 1]
    return ic


def exceeds(component, value, point):
    off = np.zeros((3, 3, 6))
    off[(*component, point)] = value
    return off


def measure(ic, estimate=None):
    return Measure.against(of(ic, estimate), A_NN, LINES, EVERYWHERE)


@pytest.mark.parametrize("unit", [1.0, 1e-9, 1e9])
@pytest.mark.parametrize("sign", [1, -1])
def test_vanishing_and_shares_do_not_depend_on_units_or_on_the_sign_of_c_nn(c, unit, sign):
    c[S, N] = 1e-12
    c[N, N] = sign * np.abs(c[N, N])
    off = exceeds((S, N), 0.01, 4)
    first, other = measure(c), Measure.against(of(unit * c), unit * A_NN, LINES, EVERYWHERE)
    assert first.zero_by_symmetry[S, N]
    assert not first.zero_by_symmetry[X, N]
    np.testing.assert_array_equal(other.zero_by_symmetry, first.zero_by_symmetry)
    np.testing.assert_array_equal(other.vanishing, first.vanishing)
    assert other.shares(unit * off)[FAR][S, N] == pytest.approx(first.shares(off)[FAR][S, N])
    assert first.shares(off)[FAR][S, N] == pytest.approx(0.01 / (0.05 * 4))  # 4: C_nn on the other line
    assert first.vanishing[S, N]  # a component of rounding is tested as a zero
    assert not np.any(first.vanishing[[X, X, N], [X, N, N]])
    assert first.weights(off)[FAR][S, N] == other.weights(unit * off)[FAR][S, N] == pytest.approx(0.01)
    assert first.zero_by_symmetry.shape == (3, 3)


def test_an_error_is_a_share_of_the_component_itself_over_all_lines(c):
    """Unlike the scale of refinement, which has C_nn in it; zero for a nonzero C is an error of 100 %."""
    near, far = (measure(c).shares(exceeds((X, N), *at)) for at in ((-0.01, 1), (0.005, 4)))
    assert near[NEAR][X, N] == pytest.approx(0.5)  # of 0.02, however small beside C_nn
    assert far[FAR][X, N] == pytest.approx(0.25)  # of 0.02 on the other line, not of 0.005
    assert near[FAR][X, N] == far[NEAR][X, N] == 0
    none = measure(c).shares(-c)
    assert none[NEAR][X, N] == none[NEAR][N, N] == 1
    assert none[FAR][N, N] == pytest.approx(1 / 4)
    other, of_one_line = c.copy(), replace(measure(c), lines={NEAR: LINES[NEAR]})
    other[N, N] *= 10
    other[X, N, 5] = 7.0  # on no line
    alone = replace(measure(other), lines=of_one_line.lines).shares(exceeds((X, N), -0.01, 1))
    assert alone[NEAR][X, N] == of_one_line.shares(exceeds((X, N), -0.01, 1))[NEAR][X, N] == near[NEAR][X, N]


@pytest.mark.parametrize(("known", "gone"), [(0.0019, False), (0.0021, True)])
def test_a_component_below_ten_times_its_estimate_vanishes(c, known, gone):
    """C_xn is 0.02; the estimate is largest on the line where C_xn is small."""
    estimate = np.zeros_like(c)
    estimate[X, N, 5] = known
    of_c = measure(c, estimate)
    assert of_c.vanishing[X, N] == gone
    assert of_c.shares(exceeds((X, N), 0.01, 0))[NEAR][X, N] == pytest.approx(0.01 / (0.2 if gone else 0.02))
    assert not of_c.vanishing[N, N]


def test_rms_is_a_share_of_the_same_and_the_weight_one_of_nn_on_the_line(c):
    off = np.zeros_like(c)
    off[X, N] = [0.01, -0.01, 0.02, 0, 0, 0]
    off[S, N] = 0.3
    rms = measure(c).rms(off)
    assert rms[NEAR][X, N] == pytest.approx(np.sqrt((1 + 1 + 4) / 3) / 2)
    assert rms[FAR][X, N] == 0
    assert rms[FAR][S, N] == pytest.approx(0.3 / 0.2)
    weights = measure(c).weights(exceeds((X, N), -0.01, 1) + exceeds((X, N), 0.02, 3))
    assert (weights[NEAR][X, N], weights[FAR][X, N]) == pytest.approx((0.01 / 4, 0.02 / 1))


def test_a_nn_takes_the_place_of_an_nn_that_was_not_computed(c):
    c[:, X] = np.nan
    c[N, N] = np.nan
    of_c = measure(c)
    off = exceeds((X, N), 0.01, 1)
    assert of_c.weights(off)[NEAR][X, N] == pytest.approx(0.01 / 6)
    assert of_c.shares(off)[NEAR][X, N] == pytest.approx(0.5)
    assert of_c.shares(exceeds((S, N), 0.1, 4))[FAR][S, N] == pytest.approx(0.1 / (0.05 * 6))
    assert np.isnan(of_c.shares(off)[NEAR][X, X])
    assert not of_c.vanishing[X, X]
    assert not of_c.vanishing[N, N]


def test_a_line_more_changes_shares_only_where_its_c_is_larger(c):
    """The far line by itself: its C_nn is a quarter, its C_xn too, its C_xx half of the near line's."""
    both = measure(c)
    alone = replace(both, lines={FAR: LINES[FAR]})
    off = np.full_like(c, 0.001)
    ratios = alone.shares(off)[FAR] / both.shares(off)[FAR]
    assert ratios[X, X] == pytest.approx(2)
    assert ratios[N, N] == pytest.approx(4)
    assert ratios[X, N] == pytest.approx(4)
    assert ratios[S, N] == pytest.approx(4)  # a share of 0.05 C_nn, which is a quarter
    np.testing.assert_array_equal(alone.weights(off)[FAR], both.weights(off)[FAR])


def test_the_peak_under_the_load_does_not_hide_errors_away_from_it(c):
    """A line more, through the load: errors elsewhere stay; at the load they are shares of the peak."""
    peak = np.concatenate([c, 20 * c[..., 1:2]], axis=-1)
    lines = LINES | {"through the load": slice(6, 7)}
    far = np.append(EVERYWHERE, False)
    with_peak = Measure.against(of(peak), np.append(A_NN, 90.0), lines, far)
    off = np.zeros_like(peak)
    off[N, N] = 0.4
    off[S, N] = 0.1
    assert with_peak.shares(off)[NEAR][N, N] == measure(c).shares(off[..., :6])[NEAR][N, N] == 0.1
    assert with_peak.shares(off)["through the load"][N, N] == pytest.approx(0.4 / 80)
    assert with_peak.shares(off)[FAR][S, N] == pytest.approx(0.1 / (0.05 * 4))
    assert with_peak.shares(off)["through the load"][S, N] == pytest.approx(0.1 / (0.05 * 80))
    only_near = replace(with_peak, far=np.zeros(7, dtype=bool))
    assert only_near.shares(off)[NEAR][N, N] == pytest.approx(0.4 / 80)


def test_component_with_a_large_estimate_only_at_the_load_does_not_vanish(c):
    estimate = np.zeros_like(c)
    estimate[X, N, 1] = 0.01
    far = EVERYWHERE.copy()
    assert measure(c, estimate).vanishing[X, N]
    far[1] = False
    assert not Measure.against(of(c, estimate), A_NN, LINES, far).vanishing[X, N]


def test_far_is_four_elements_away():
    patch = Patch(0.2, 0.3, 1.0)
    x, s = np.array([0.0, 1.6, 1.59, 0.0, 0.0, 1.2]), np.array([1.0, 1.0, 1.0, -1.4, 3.39, 2.8])
    np.testing.assert_array_equal(far_from(patch, x, s), [False, True, False, True, False, True])
