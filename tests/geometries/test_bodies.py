import numpy as np
import pytest

from geometries.bodies import LOWER, UPPER, Domain, PrismaticBody, far_end
from geometries.contours import arc, ellipse, plane, through_points
from geometries.materials import Material

DOMAIN = Domain(far_radius=60.0, half_length=130.0)
Y = np.linspace(-7.0, 9.0, 15)
CONTOURS = {
    "plane": plane(),
    "arc": arc(10.0, 0.45, 1.1),
    "groove": arc(-7.0, 0.9, 0.4),
    "ellipse": ellipse(5.0, 11.0, 1.3, 0.8),
    "spline": through_points(Y, -(Y**2) / 25 + 0.1 * Y, 1.7),
}


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
    body = PrismaticBody(LOWER, arc(radius, left, right), Material(210e3, 0.28), DOMAIN)
    assert body.s_range == pytest.approx((-ends[0], ends[1]), rel=1e-13)


def test_plane_ends_at_the_far_radius():
    body = PrismaticBody(UPPER, plane(), Material(210e3, 0.28), DOMAIN)
    assert body.s_range == pytest.approx((-60.0, 60.0), rel=1e-13)


def test_far_end_grows_with_the_domain_and_its_length_does_not_matter():
    contour = CONTOURS["arc"]
    near, far = (far_end(contour, DOMAIN.scaled(k), +1) for k in (1.0, 1e6))
    assert far == pytest.approx(1e6 * 60.0, rel=1e-6)  # crown and joint are small against it
    assert near < 60.0 + 11.0  # at most as far as all of the arc and a straight way
    assert far_end(contour, Domain(60.0, 1.0), +1) == near


@pytest.mark.parametrize(("far_radius", "direction"), [(9.0, +1), (4.0, -1)])
def test_far_arc_inside_the_curved_part_is_refused(far_radius, direction):
    contour = arc(10.0, 0.45, 1.1)  # its joints lie 4.46 and 10.5 mm from the centre
    with pytest.raises(ValueError, match=f"far_radius = {far_radius:g} mm.*enlarge far_radius"):
        far_end(contour, Domain(far_radius, 100.0), direction)


def test_far_arc_is_judged_on_each_side_by_itself():
    contour = arc(10.0, 0.45, 1.1)
    end = far_end(contour, Domain(9.0, 100.0), -1)
    assert np.hypot(*contour.position(end)) == pytest.approx(9.0, rel=1e-13)


def test_scaled_domain_has_both_lengths_multiplied():
    assert Domain(60.0, 130.0).scaled(1.5) == Domain(90.0, 195.0)


def test_sides_are_the_signs_of_the_design():
    assert (UPPER, LOWER) == (+1, -1)
