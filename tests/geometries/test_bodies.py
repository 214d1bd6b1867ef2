import numpy as np
import pytest

from geometries.bodies import Body, Domain
from geometries.contours import arc, ellipse, plane, through_points
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER

DOMAIN = Domain(far_radius=60.0, half_length=130.0)
Y = np.linspace(-7.0, 9.0, 15)
STEEL = Material(210e3, 0.28)
CONTOURS = {
    "plane": plane(),
    "arc": arc(10.0, 0.45, 1.1),
    "groove": arc(-7.0, 0.9, 0.4),
    "ellipse": ellipse(5.0, 11.0, 1.3, 0.8),
    "spline": through_points(Y, -(Y**2) / 25 + 0.1 * Y, 1.7),
}


@pytest.mark.parametrize("contour", CONTOURS.values(), ids=CONTOURS)
def test_far_ends_lie_on_the_far_arc_on_their_own_flanks(contour):
    body = Body(LOWER, contour, STEEL, DOMAIN)
    for end, joint, direction in zip(body.s_range, contour.limits, (-1, +1), strict=True):
        assert np.hypot(*contour.position(end)) == pytest.approx(60.0, rel=1e-13)
        assert direction * (end - joint) > 0
        assert np.hypot(*contour.position(end + direction)) > 60.0  # a millimetre on is outside


@pytest.mark.parametrize("radius", [10.0, -10.0])
def test_far_end_of_an_arc_solves_its_quadratic_equation(radius):
    left, right = 0.45, 1.1
    ends = []
    for flank in (left, right):
        along, height = 10 * np.sin(flank), 10 * (1 - np.cos(flank))  # where the flank begins
        inward = along * np.cos(flank) + height * np.sin(flank)  # on the flank's direction
        ends.append(10 * flank - inward + np.sqrt(inward**2 - along**2 - height**2 + 60.0**2))
    body = Body(LOWER, arc(radius, left, right), STEEL, DOMAIN)
    assert body.s_range == pytest.approx((-ends[0], ends[1]), rel=1e-13)


@pytest.mark.parametrize("half_length", [130.0, np.inf])
@pytest.mark.parametrize(
    ("given", "larger"),
    [((False, False), (2, 2)), ((True, False), (1, 2)), ((False, True), (2, 1)), ((True, True), (1, 1))],
)
def test_boundaries_that_are_given_stay_and_are_supports(given, larger, half_length):
    """A body without ends is truncated by its far arc alone."""
    body = Body(LOWER, plane(), STEEL, Domain(60.0, half_length, *given))
    assert body.truncated == (not given[0] or (not given[1] and half_length < np.inf))
    assert body.enlarged(2.0).domain == Domain(60.0 * larger[0], half_length * larger[1], *given)


def test_far_arc_may_cut_the_curved_part_on_one_side_or_both():
    """The joints lie 4.46 and 10.5 mm from the centre; chords of the arc."""
    contour = arc(10.0, 0.45, 1.1)
    for far_radius in (9.0, 4.0):
        left, right = Body(LOWER, contour, STEEL, Domain(far_radius, 100.0)).s_range
        assert right == pytest.approx(20 * np.arcsin(far_radius / 20))
        assert np.hypot(*contour.position(left)) == pytest.approx(far_radius, rel=1e-13)
        assert (left < -4.5) == (far_radius > 4.46)


def test_the_prismatic_section_is_the_limit_of_a_large_rolling_radius():
    wheel, prism = (Body(UPPER, CONTOURS["arc"], STEEL, DOMAIN, radius) for radius in (1e9, np.inf))
    assert wheel.s_range == pytest.approx(prism.s_range)


@pytest.mark.parametrize("side", [LOWER, UPPER])
def test_a_section_ends_at_its_hub(side):
    ball = Body(side, arc(-side * 50.0, 1.4, 1.4), STEEL, Domain(100.0, 100.0), 50.0, hub_radius=20.0)
    assert ball.s_range == pytest.approx((-50 * np.arccos(0.4), 50 * np.arccos(0.4)))
    assert ball.depth == 30.0
    assert ball.reaches_hub
    default = Body(UPPER, plane(), STEEL, Domain(60.0, 100.0), 100.0)
    assert default.depth == pytest.approx(80.0)
    assert not default.reaches_hub


def test_a_model_goes_at_most_once_round():
    wheel = Body(UPPER, plane(), STEEL, Domain(60.0, 200.0), 50.0)
    assert wheel.closed
    assert wheel.xi_end == pytest.approx(50 * np.pi)
    assert not Body(UPPER, plane(), STEEL, Domain(60.0, 150.0), 50.0).closed


@pytest.mark.parametrize(
    ("radius", "hub", "message"),
    [
        (-5.0, None, "rolling_radius = -5"),
        (100.0, 10.0, "hub_radius = 10.0: at least 0.2"),
        (100.0, 100.0, "smaller than rolling_radius"),
    ],
)
def test_impossible_wheels_are_refused(radius, hub, message):
    with pytest.raises(ValueError, match=message):
        Body(UPPER, plane(), STEEL, DOMAIN, radius, hub)
