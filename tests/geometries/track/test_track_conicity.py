import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geometries.errors import Failure, WrongInput
from geometries.track.conicity import Differences, equivalent_conicity

Y = np.linspace(-9, 9, 181)


@pytest.mark.parametrize("amplitude", [0.3, 3.0, 8.7])
@pytest.mark.parametrize("offset", [0.0, 0.21])
def test_cones_have_the_tangent_of_their_angle(amplitude, offset):
    """Wheels of different radii roll about a shift of their own; the wavelength stays."""
    conicity = equivalent_conicity(
        Y, 2 * 0.05 * Y + offset * 0.1, amplitude if offset == 0 else amplitude / 2
    )
    assert conicity.value == pytest.approx(0.05, rel=1e-11)
    assert conicity.centre == pytest.approx(-offset, abs=1e-12)
    assert np.diff(conicity.ends)[0] == pytest.approx(2 * conicity.amplitude, abs=1e-10)


@pytest.mark.parametrize("amplitude", [0.5, 2.0, 7.3])
def test_a_step_at_the_centre_has_its_closed_form(amplitude):
    """Differences of +-c: parabolas of the time, I = 4 sqrt(A / c), so pi^2 c / (16 A)."""
    c, edge = 0.7, 1e-9
    shifts = np.array([-9, -edge, edge, 9])
    value = equivalent_conicity(shifts, c * np.array([-1, -1, 1, 1]), amplitude).value
    assert value == pytest.approx(np.pi**2 * c / (16 * amplitude), rel=1e-7)  # the step is 2e-9 wide


def curve(y):
    """A stiffening difference, not odd in y."""
    return 0.1 * y + 0.004 * y**2 + 0.003 * y**3 + 0.02


@pytest.mark.parametrize("amplitude", [0.5, 3.0, 6.0])
def test_the_motion_in_time_has_the_same_wavelength(amplitude):
    """Klingel's equation e r_0 y'' + dr(y) = 0 integrated along the track, with the exact differences."""
    y = np.linspace(-9, 9, 3601)
    conicity = equivalent_conicity(y, curve(y), amplitude)
    e_r = 1500.0 * 460.0

    def turns_back(_, state):
        return state[1]

    turns_back.direction = -1  # a largest shift
    path = solve_ivp(
        lambda _, state: [state[1], -curve(state[0]) / e_r],
        (0.0, 3e5),
        [conicity.ends[1], 0.0],
        events=turns_back,
        method="DOP853",
        rtol=1e-11,
        atol=1e-13,
    )
    wavelength = path.t_events[0][path.t_events[0] > 1][0]
    # straight between shifts: 0.005^2 / 8 * curvature 0.1 of differences near 1
    assert conicity.value == pytest.approx(2 * e_r * (np.pi / wavelength) ** 2, rel=2e-6)
    assert np.min(path.y[0]) == pytest.approx(conicity.ends[0], abs=1e-2)


def test_the_error_falls_with_the_square_of_the_step():
    fine = equivalent_conicity(y := np.linspace(-9, 9, 7201), curve(y), 3.0).value
    errors = [
        abs(equivalent_conicity(y := np.linspace(-9, 9, n), curve(y), 3.0).value - fine)
        for n in (37, 73, 145)
    ]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.4)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.4)


def test_small_motions_have_half_the_slope():
    slope = 0.1 + 0.008 * (centre := -0.2019) + 0.009 * centre**2
    y = np.linspace(-1, 1, 4001)
    assert equivalent_conicity(y, curve(y), 0.02).value == pytest.approx(slope / 2, rel=1e-3)


def test_scaled_shifts_and_differences():
    """Twice the differences: twice the conicity; both twice: the same."""
    one = equivalent_conicity(Y, curve(Y), 3.0).value
    assert equivalent_conicity(Y, 2 * curve(Y), 3.0).value == pytest.approx(2 * one, rel=1e-10)
    assert equivalent_conicity(2 * Y, 2 * curve(Y), 6.0).value == pytest.approx(one, rel=1e-10)
    assert equivalent_conicity(-Y[::-1], -curve(Y)[::-1], 3.0).value == pytest.approx(one, rel=1e-10)


def test_what_does_not_return_or_not_reach_is_refused():
    with pytest.raises(Failure, match="without growing through 0"):
        equivalent_conicity(Y, -Y, 3.0)
    with pytest.raises(Failure, match=r"amplitude = 9.5 mm: .* 9 mm at most"):
        equivalent_conicity(Y, Y, 9.5)
    for unequal in (Y[Y > -3.01], Y[Y < 3.01]):
        with pytest.raises(Failure, match=r"amplitude = 4 mm: .* 3 mm at most"):
            equivalent_conicity(unequal, unequal, 4.0)
        assert equivalent_conicity(unequal, unequal, 3.0).value == pytest.approx(0.5, rel=1e-10)
    with pytest.raises(Failure, match="lead back"):  # beyond 5 mm the wheelset runs off
        equivalent_conicity(Y, Y * (1 - (Y / 5) ** 2), 5.5)
    assert equivalent_conicity(Y, Y * (1 - (Y / 5) ** 2), 4.8).value > 0
    with pytest.raises(WrongInput, match="amplitude"):
        equivalent_conicity(Y, Y, 0.0)
    with pytest.raises(WrongInput, match="grow"):
        equivalent_conicity(Y[::-1], Y, 1.0)
    with pytest.raises(WrongInput, match="shapes"):
        equivalent_conicity(Y, Y[:-1], 1.0)


def test_of_several_centres_the_nearest_to_zero_counts():
    differences = Differences(Y, np.sin(Y - 1.0))
    assert differences.centre() == pytest.approx(1.0, abs=1e-3)
    least, largest = differences.reach(1.0)
    assert least == pytest.approx(1 - np.pi, abs=0.2)
    assert largest == pytest.approx(1 + np.pi, abs=0.2)
