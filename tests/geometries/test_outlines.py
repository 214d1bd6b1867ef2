"""Outlines of sections: their ends on the contour, symmetry, supports, widths, and what does not fit."""

from dataclasses import replace

import numpy as np
import pytest

from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.outlines import RAIL_SECTIONS, SectionOutline, signed_area, widths
from geometries.profiles.placement import arc_length_at, spline_contour
from geometries.profiles.standards import standard
from geometries.surfaces import LOWER, UPPER

STEEL = Material(210e3, 0.28)
DOMAIN = Domain(60.0, 130.0)
BLOCK = ((5.0, 0.0), (5.0, -8.0), (-5.0, -8.0), (-5.0, 0.0))


def body_of(points, clamped, *, contour=None, side=LOWER, radius=np.inf, hub=None):
    return Body(side, contour or plane(), STEEL, DOMAIN, radius, hub, SectionOutline(tuple(points), clamped))


def test_an_outline_takes_the_place_of_the_far_arc():
    body = body_of(BLOCK, (2, 3))
    assert body.domain == Domain(np.hypot(5, 8), 130.0)
    assert replace(body, domain=Domain(1280.0, 60.0)).domain == Domain(np.hypot(5, 8), 60.0)
    assert body.enlarged(2.0).domain == Domain(np.hypot(5, 8), 260.0)
    assert body.s_range == pytest.approx((-5.0, 5.0))


def test_a_contour_goes_on_to_points_on_its_tangents_and_ends_before_others():
    """On the right the first point lies on the flank, 2 mm beyond the arc; on the left none does."""
    contour = arc(10.0, 0.4, 0.7)
    tangent = contour.position(7.0) + 2.0 * contour.tangent(7.0)
    outline = SectionOutline((tuple(tangent), (12.0, -20.0), (-12.0, -20.0)), (2, 3))
    assert outline.contour_ends(contour) == pytest.approx((-4.0, 9.0))
    assert outline.beyond(contour).shape == (2, 2)
    assert outline.closed(contour)[:, 0] == pytest.approx(contour.position(-4.0))


def test_supports_are_the_edges_between_the_clamped_points():
    body = body_of(BLOCK, (1, 3))
    y, z = np.array([[5.0, 5.0, 0.0, -5.0, -5.0, 0.0], [0.0, -4.0, -8.0, -8.0, -4.0, -4.0]])
    right, base = body.on_supports(y, z)
    assert right.tolist() == [True, True, False, False, False, False]
    assert base.tolist() == [False, False, True, True, False, False]


@pytest.mark.parametrize(
    ("points", "clamped", "symmetric"),
    [
        (BLOCK, (2, 3), True),
        (BLOCK, (1, 4), True),
        (BLOCK, (1, 3), False),
        ((*BLOCK[:2], (0.0, -9.0), *BLOCK[2:]), (2, 4), True),
        ((*BLOCK[:2], (0.1, -9.0), *BLOCK[2:]), (2, 4), False),
    ],
)
def test_a_section_is_symmetric_only_with_its_outline_and_supports(points, clamped, symmetric):
    assert body_of(points, clamped).symmetric == symmetric
    assert not body_of(points, clamped, contour=arc(10.0, 0.4, 0.45)).symmetric


def test_widths_across_a_channel():
    """A block of 10 x 8 with a slot of 4 x 6 in its side: webs of 1 mm above and below it."""
    points = np.array(
        [(10, 0), (10, -1), (6, -1), (6, -7), (10, -7), (10, -8), (0, -8), (0, 0)], dtype=float
    ).T
    places, width = widths(points, 0.5)
    (y, z), on_web = places, (places[0] > 6) & np.isin(places[1], (0.0, -1.0, -7.0, -8.0))
    np.testing.assert_allclose(width[on_web], 1.0)
    np.testing.assert_allclose(width[(y == 0) & (z < -1) & (z > -7)], 6.0)
    np.testing.assert_allclose(width[(z == -8) & (y < 6)], 8.0)


CROSSING = ((5.0, 0.0), (-5.0, -8.0), (5.0, -8.0), (-5.0, 0.0))
MISFITS = {
    "one point": (lambda: body_of(BLOCK[:1], (1, 2)), r"outline\.points: 1 points"),
    "no number": (lambda: body_of(((5.0, np.nan), *BLOCK[1:]), (2, 3)), r"outline\.points: .*finite"),
    "clamped": (lambda: body_of(BLOCK, (3, 2)), r"outline\.clamped = \[3, 2\]: .*two of the 4 points"),
    "repeated": (lambda: body_of((*BLOCK[:2], *BLOCK[1:]), (2, 4)), r"points 2 and 3 are identical"),
    "off the plane": (
        lambda: body_of(((5.0, -1.0), *BLOCK[1:3], (-5.0, -1.0)), (2, 3)),
        "a plane has no ends of its own",
    ),
    "crossing": (lambda: body_of(CROSSING, (2, 3)), r"crosses itself or the contour at y = 0, z = -4 mm"),
    "through the contour": (
        lambda: body_of(((0.0, 3.0), (0.0, -9.0)), (1, 2), contour=arc(10.0, 0.4, 0.4)),
        r"crosses itself or the contour at y = 0, z = ",
    ),
    "other side": (lambda: body_of(BLOCK, (2, 3), side=UPPER), "would not lie above the contour"),
    "hub": (
        lambda: body_of([(y, -z) for y, z in BLOCK], (2, 3), side=UPPER, radius=100.0, hub=30.0),
        r"hub_radius = 30\.0: the outline defines where",
    ),
    "axis": (
        lambda: body_of([(y, -z) for y, z in BLOCK], (2, 3), side=UPPER, radius=9.9),
        r"outline\.points: go to 1\.9 mm from the axis; keep at least 0\.2 rolling_radius \(1\.98 mm\)",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("make", "message"), MISFITS.values(), ids=MISFITS)
def test_what_does_not_fit_is_said(make, message):
    with pytest.raises(WrongInput, match=message):
        make()


def test_the_section_of_60e1_has_the_properties_of_the_standard():
    """Area 76.70 cm^2, centroid 80.92 mm above the base, moments of area 3038.3 and 512.3 cm^4 (EN 13674-1).

    The radius of the fillets, 20 mm, is the round number that comes closest to them; with the straight web
    they are within 1 %.
    """
    head = standard("60E1").outline
    contour = spline_contour(head, arc_length_at(head, 0.0))
    boundary = RAIL_SECTIONS["60E1"].outline.closed(contour)
    (y, z), (next_y, next_z) = boundary, np.roll(boundary, -1, axis=1)
    area, parts = signed_area(boundary), y * next_z - next_y * z
    centroid = np.sum((z + next_z) * parts) / 6 / area
    about_y = np.sum((z**2 + z * next_z + next_z**2) * parts) / 12 - area * centroid**2
    about_z = np.sum((y**2 + y * next_y + next_y**2) * parts) / 12
    assert -area == pytest.approx(76.70e2, rel=0.01)
    assert 172 + centroid == pytest.approx(80.92, abs=0.2)
    assert -about_y == pytest.approx(3038.3e4, rel=0.01)
    assert -about_z == pytest.approx(512.3e4, rel=0.01)
