import numpy as np
import pytest

from geometries.bodies import Body, Domain, section_end
from geometries.contours import arc, ellipse, plane, through_points
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER, Surface

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


def far_end(contour, domain, direction, side=LOWER):
    return section_end(Body(side, contour, STEEL, domain), direction)


@pytest.mark.parametrize("contour", CONTOURS.values(), ids=CONTOURS)
@pytest.mark.parametrize("direction", [-1, +1])
def test_far_end_lies_on_the_far_arc_on_its_own_flank(contour, direction):
    s = far_end(contour, DOMAIN, direction)
    assert np.hypot(*contour.position(s)) == pytest.approx(60.0, rel=1e-13)
    assert direction * (s - contour.limits[(1 + direction) // 2]) > 0
    assert np.hypot(*contour.position(s + direction)) > 60.0  # a millimetre on is outside


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


@pytest.mark.parametrize(
    ("given", "truncated", "larger"),
    [
        ((False, False), True, (120.0, 260.0)),
        ((True, False), True, (60.0, 260.0)),
        ((False, True), True, (120.0, 130.0)),
        ((True, True), False, (60.0, 130.0)),
    ],
)
def test_boundaries_that_are_given_stay_and_are_supports(given, truncated, larger):
    body = Body(LOWER, plane(), STEEL, Domain(60.0, 130.0, *given))
    assert body.truncated == truncated
    assert body.enlarged(2.0).domain == Domain(*larger, *given)


def test_a_body_without_ends_is_truncated_by_a_far_arc_that_is_not_given():
    assert Body(LOWER, plane(), STEEL, Domain(60.0, np.inf)).truncated
    assert not Body(LOWER, plane(), STEEL, Domain(60.0, np.inf, radius_given=True)).truncated


def test_plane_ends_at_the_far_radius():
    body = Body(UPPER, plane(), STEEL, DOMAIN)
    assert body.s_range == pytest.approx((-60.0, 60.0), rel=1e-13)


def test_far_end_grows_with_the_domain_and_its_length_does_not_matter():
    contour = CONTOURS["arc"]
    near, far = (far_end(contour, DOMAIN.scaled(k), +1) for k in (1.0, 1e6))
    assert far == pytest.approx(1e6 * 60.0, rel=1e-6)  # crown and joint are small against it
    assert near < 60.0 + 11.0  # at most as far as all of the arc and a straight way
    assert far_end(contour, Domain(60.0, 1.0), +1) == near


@pytest.mark.parametrize(("far_radius", "direction"), [(9.0, +1), (4.0, -1)])
def test_far_arc_may_cut_the_curved_part(far_radius, direction):
    contour = arc(10.0, 0.45, 1.1)  # its joints lie 4.46 and 10.5 mm from the centre
    end = far_end(contour, Domain(far_radius, 100.0), direction)
    assert abs(end) == pytest.approx(20 * np.arcsin(far_radius / 20))  # chord of the arc


def test_far_arc_is_judged_on_each_side_by_itself():
    contour = arc(10.0, 0.45, 1.1)
    end = far_end(contour, Domain(9.0, 100.0), -1)
    assert np.hypot(*contour.position(end)) == pytest.approx(9.0, rel=1e-13)


def test_scaled_domain_has_both_lengths_multiplied():
    assert Domain(60.0, 130.0).scaled(1.5) == Domain(90.0, 195.0)


def test_sides_are_signs():
    assert (UPPER, LOWER) == (+1, -1)


def test_the_surface_is_that_of_the_contour_at_the_rolling_radius():
    wheel = Body(UPPER, CONTOURS["arc"], STEEL, DOMAIN, rolling_radius=120.0)
    assert wheel.surface == Surface(UPPER, CONTOURS["arc"], 120.0)
    assert Body(LOWER, CONTOURS["arc"], STEEL, DOMAIN).surface == Surface(LOWER, CONTOURS["arc"])


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
