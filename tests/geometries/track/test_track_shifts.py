import numpy as np
import pytest
from track_sections import BACKS, TRACK, Circles, Cone, arc, flanged, symmetric, wheel_through

from geometries.errors import WrongInput
from geometries.track.conicity import equivalent_conicity
from geometries.track.layout import WheelsetDimensions, lay_out
from geometries.track.wheelset import JUMP_WIDTH, over_shifts, settle


def test_jumps_to_the_flange_are_found_and_are_two_points_of_contact():
    layout = symmetric()
    shifts = over_shifts(layout, [-8.0, -7.5, 0.4, 7.6, 7.9])
    assert [jump.side for jump in shifts.jumps] == ["right", "left"]
    right, left = shifts.jumps
    assert left.shift == pytest.approx(-right.shift, abs=2 * JUMP_WIDTH)
    assert 7.5 < left.shift < 8.0
    tread, flange = left.touches
    assert tread.angle < 0.1
    assert flange.angle > 0.9
    # both touch there: within the width times the slope of the flange
    both = settle(layout, left.shift).left
    assert len(both) == 2
    assert both[1].gap < 5 * JUMP_WIDTH
    assert left.before.height == pytest.approx(left.after.height, abs=1e-5)
    assert left.before.roll == pytest.approx(left.after.roll, abs=1e-8)
    at, _ = shifts.rolling_radius_differences()
    assert len(at) == 5 + 2 * 2  # both sides of each jump
    difference = left.after.rolling_radius_difference - left.before.rolling_radius_difference
    assert difference > 5  # mm: the radius jumps


@pytest.mark.slow
def test_a_jump_is_found_wherever_the_shifts_are():
    layout = symmetric()
    coarse, fine = (over_shifts(layout, np.linspace(7.3, 8.1, n)).jumps for n in (2, 4))
    assert coarse[0].shift == pytest.approx(fine[0].shift, abs=2 * JUMP_WIDTH)


def test_smooth_motion_of_a_point_is_no_jump():
    """Nearly conformal arcs: the point moves by 10 mm between shifts, without a jump."""
    layout = Circles(R_w=305.0, R_r=295.0, gamma=0.02).layout()
    shifts = over_shifts(layout, [-0.6, 0.0, 0.7])
    moves = np.diff([position.left[0].s_rail for position in shifts.positions])
    assert np.min(np.abs(moves)) > 5
    assert shifts.jumps == ()


@pytest.mark.parametrize(
    ("largest", "jumps"), [(7.4, 0), pytest.param(8.2, 2, marks=pytest.mark.slow)], ids=["tread", "flange"]
)
def test_curves_of_symmetric_pairs_are_odd_and_angles_swap(largest, jumps):
    y = np.array([-largest, -3.0, 3.0, largest])
    shifts = over_shifts(symmetric(), y)
    at, differences = shifts.rolling_radius_differences()
    assert len(at) == len(y) + 2 * jumps
    np.testing.assert_allclose(differences, -differences[::-1], rtol=0, atol=1e-5)  # slope over the width
    left, right = ([getattr(p, side)[0].angle for p in shifts.positions] for side in ("left", "right"))
    np.testing.assert_allclose(left, right[::-1], rtol=0, atol=1e-10)


def test_the_equivalent_conicity_of_cones_on_arcs():
    """Per shift of the axle tan(gamma) m / (m - tan(gamma) (height + R_r)); without roll tan(gamma)."""
    cone = Cone()
    t = np.tan(cone.gamma)
    with_roll, without = (
        over_shifts(cone.layout(), np.linspace(-4, 4, 5), **how) for how in ({}, {"roll": 0.0})
    )
    z = with_roll.positions[2].height + cone.R_r
    value = equivalent_conicity(*with_roll.rolling_radius_differences(), 3.0).value
    # the terms left out are roll^2 = 2e-8
    assert value == pytest.approx(t * cone.m / (cone.m - t * z), rel=1e-6)
    value = equivalent_conicity(*without.rolling_radius_differences(), 3.0).value
    assert value == pytest.approx(t, rel=1e-9)


def test_wheels_of_two_radii_roll_beside_the_middle():
    """Cones without roll: dr = 2 tan(gamma) y + 0.2 mm, zero at -0.1 / tan(gamma)."""
    y = np.linspace(-71.0, 60.0, 9)
    wheel, rail = wheel_through(np.stack([y, 0.05 * y])), arc(300.0)
    radii = WheelsetDimensions(BACKS, (460.1, 459.9), -70.0)
    shifts = over_shifts(lay_out((rail, rail), (wheel, wheel), TRACK, radii), [-6.0, -1.0, 4.0], roll=0.0)
    conicity = equivalent_conicity(*shifts.rolling_radius_differences(), 3.0)
    assert conicity.centre == pytest.approx(-2.0, abs=1e-9)
    assert conicity.value == pytest.approx(0.05, rel=1e-9)


def test_the_equivalent_conicity_of_arcs_on_arcs():
    """Wickens' formula, with the contact angle gamma and half-distance b: small amplitudes."""
    c = Circles()
    t, s = np.tan(c.gamma), np.sin(c.gamma)
    expected = c.R_w * t / (c.R_w - c.R_r) * (c.b + c.R_r * s) / (c.b - c.r_0 * t)
    shifts = over_shifts(c.layout(), np.linspace(-0.1, 0.1, 9))
    value = equivalent_conicity(*shifts.rolling_radius_differences(), 0.08).value
    assert value == pytest.approx(expected, rel=1e-6)
    apart = over_shifts(c.layout(), np.linspace(-0.1, 0.1, 9), roll=0.0)
    value = equivalent_conicity(*apart.rolling_radius_differences(), 0.08).value
    assert value == pytest.approx(c.R_w * t / (c.R_w - c.R_r), rel=1e-6)


def test_shifts_have_to_grow():
    for wrong in ([], [1.0, 1.0], [2.0, 1.0]):
        with pytest.raises(WrongInput, match="grow"):
            over_shifts(flanged(), wrong)
