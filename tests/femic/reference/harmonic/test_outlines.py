"""Bodies with an outline: beams, columns and half-spaces; the far arc as an outline; and the solid engine."""

from dataclasses import replace

import numpy as np
import pytest

from femic.cache.store import Store
from femic.reference.engine import Points, Request
from femic.reference.engines import HARMONIC
from femic.reference.harmonic.engine import build_section, solve
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.harmonic.stored import _index_key, model_key
from femic.reference.harmonic.synthesis import displacements
from femic.reference.job import Job, Settings
from femic.reference.meshing import Cells
from femic.reference.refinement import references
from femic.reference.solid.engine import raw_ics
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.materials import Material
from geometries.outlines import SectionOutline
from geometries.patches import Load, N, Patch, S, X
from geometries.surfaces import LOWER, UPPER
from tests.coarse import coarse_sections

STEEL = Material(210e3, 0.28)
PLANE_STRAIN = STEEL.E / (1 - STEEL.nu**2)
DOMAIN = Domain(60.0, np.inf)
WIDTH = 3.0
ALL = (X, S, N)
FINE = 0.1  # growth of cells with which the corners of the base no longer matter


def column(height, width=WIDTH, contour=None, clamped=(2, 3)):
    """A rectangular block, clamped at its base."""
    w, h = width / 2, height
    outline = SectionOutline(((w, 0.0), (w, -h), (-w, -h), (-w, 0.0)), clamped)
    return Body(LOWER, contour or plane(), STEEL, DOMAIN, outline=outline)


def request(body, patch, x, s, growth=0.4):
    loads = tuple(Load(patch, direction) for direction in ALL)
    cells = Cells(patch.b / 5, growth, growth)
    return HarmonicRequest(body, loads, Points(np.array(x), np.array(s)), cells, 1e-9)


def at_wavenumber(body, patch, s, k, growth=0.4):
    """Amplitudes (load, i, observer) [mm^2/N] at a wavenumber."""
    asked = request(body, patch, np.zeros(len(s)), s, growth)
    responses, _ = SectionSolver(build_section(asked), asked.loads, np.array(s))([k])
    return responses[0, 0]


def solved(body, patch, x, s, growth=0.4):
    """Displacements (load, i, point) [mm/N] of the harmonic engine, and their variations."""
    asked = request(body, patch, x, s, growth)
    return displacements(solve(asked), asked.loads, asked.points)


def test_a_web_in_plane_strain_is_a_column_under_its_weight_and_a_beam_under_a_lateral_load():
    """Under loads on the whole width, beyond what clamped base and top add: Saint-Venant.

    Of the column h / (E' w). Of the beam h^3 / (3 E' I), plus h^2, h and a constant from shear, base and top:
    third differences in h.
    """
    patch, step = Patch(1.0, WIDTH / 2), 4.0
    heights = 12.0 + step * np.arange(4)
    u = np.array([at_wavenumber(column(h), patch, (0.0,), 0.0, FINE)[ALL, ALL, 0] for h in heights])
    np.testing.assert_allclose(np.diff(u[:, N]), step / (PLANE_STRAIN * WIDTH), rtol=1e-5)
    bending = 2 * step**3 / (PLANE_STRAIN * WIDTH**3 / 12)
    assert np.diff(u[:, S], 3)[0] == pytest.approx(bending, rel=1e-5)


def test_a_large_block_is_a_half_space():
    """u = A - c/size + O(x^2/size^3): the level converges with order 1, differences with order 3."""
    x, s = (0.0, 3.0), (0.3, 0.3)
    levels, differences = [], []
    for size in (10.0, 20.0, 40.0):
        u = np.swapaxes(solved(column(size, size, clamped=(1, 4)), Patch(0.4, 0.5), x, s, 0.8).u, 0, 1)
        levels.append(u[N, N, 0])
        differences.append(u[N, N, 0] - u[N, N, 1])
    assert np.diff(levels)[0] / np.diff(levels)[1] == pytest.approx(2.0, rel=0.02)
    assert np.diff(differences)[0] / np.diff(differences)[1] == pytest.approx(8.0, rel=0.1)


def with_polygon(body, pieces):
    """The body with its far arc, and hub if it reaches it, as an outline of straight edges."""
    far, top = body.domain.far_radius, min(body.depth, body.domain.far_radius)
    y, z = body.contour.position(body.s_range[1])
    angle = np.linspace(np.arctan2(-body.side * z, y), -np.arcsin(top / far), pieces)
    right = far * np.stack([np.cos(angle), -body.side * np.sin(angle)])
    points = np.hstack([right, right[:, ::-1] * [[-1], [1]]])
    if np.hypot(*(points[:, pieces - 1] - points[:, pieces])) < 1e-9 * far:
        points = np.delete(points, pieces, axis=1)
    corners = tuple((float(y), float(z)) for y, z in points.T)
    return replace(body, hub_radius=None, outline=SectionOutline(corners, (1, len(corners))))


ARCS = {
    "rail": Body(LOWER, arc(13.0, 0.6, 0.6), STEEL, DOMAIN),
    "wheel": Body(UPPER, plane(), STEEL, DOMAIN, 70.0, hub_radius=30.0),
}


@pytest.mark.parametrize(
    "body", [ARCS["rail"], pytest.param(ARCS["wheel"], marks=pytest.mark.slow)], ids=ARCS
)
def test_a_fine_polygon_is_the_far_arc(body):
    """The gap between arc and chords falls with the square of their number, and so does the difference.

    The far arc itself is round, however large its cells are.
    """
    patch, s, k = Patch(0.4, 0.5), (0.0, 1.0), 1 / 70.0
    far_arc, with_small_cells = (at_wavenumber(body, patch, s, k, *growth) for growth in ((), (0.15,)))
    u = [at_wavenumber(with_polygon(body, n + 1), patch, s, k) for n in (12, 24, 48)]
    first, second = np.diff(u, axis=0)[:, N, N]
    np.testing.assert_allclose(first / second, 4.0, rtol=0.05)
    limit = u[-1] + second / 3
    assert np.max(np.abs(limit - with_small_cells)) < 1e-5 * np.max(limit)
    assert np.max(np.abs(limit - far_arc)) < 5e-5 * np.max(limit)


def test_a_given_far_arc_is_a_support_where_it_was_put():
    """The outline is this arc in 48 chords (1e-3). Moved away until 1 % is met, C_ss changes by up to 8 %."""
    given = Body(LOWER, arc(10.0, 0.445, 0.445), STEEL, Domain(60.0, np.inf, radius_given=True))
    x = np.linspace(0.0, 25.0, 26)
    points, settings = Points(x, np.full_like(x, 1.6)), Settings(HARMONIC, 0.01, rotation_reach=7.5)
    with coarse_sections():
        on_arc, in_outline = (
            references({"lower": Job(body, Patch(0.2, 0.2), ("ss",), points, {"x": slice(None)}, settings)})
            for body in (given, with_polygon(given, 48))
        )
    c, expected = on_arc["lower"], in_outline["lower"].raw[S, S]
    assert c.body.domain == given.domain
    np.testing.assert_allclose(c.raw[S, S], expected, atol=2e-3 * np.max(expected))
    assert np.nanmax(c.c.truncation_error) == 0
    assert np.nanmax(c.c.mesh_error) > 0


def test_half_a_symmetric_section_serves_as_the_whole_one():
    """With the mirror image's support, and without: moved by 1e-5 mm the section is no longer symmetric."""
    patch, s = Patch(0.4, 0.5, 0.6), (-1.0, 0.0, 0.8)
    body = column(12.0, contour=arc(40.0, 0.03, 0.03))
    corners = list(body.outline.points)
    corners[1] = corners[1][0] + 1e-4, corners[1][1]
    whole = replace(body, outline=SectionOutline(tuple(corners), (2, 3)))
    assert (body.symmetric, whole.symmetric) == (True, False)
    half_response, whole_response = (at_wavenumber(b, patch, s, 0.1) for b in (body, whole))
    np.testing.assert_allclose(half_response, whole_response, atol=1e-4 * np.max(np.abs(whole_response)))


def test_the_solid_engine_agrees():
    """A squat column, whose clamped ends at 60 mm do not matter: no approximation of a larger body."""
    body = replace(column(14.0, 16.0), domain=Domain(60.0, 60.0))
    patch, x, s = Patch(0.8, 1.0, 2.0), (0.0, 2.5, 6.0), (2.0, 1.0, 3.0)
    loads = tuple(Load(patch, direction) for direction in ALL)
    cells = Cells(0.35, 0.35, 0.2)
    solid = raw_ics(Request(body, loads, Points(np.array(x), np.array(s)), cells)).u
    found = solved(body, patch, x, s)
    assert np.max(np.abs(solid - found.u)) < 0.01 * np.max(np.abs(found.u))
    np.testing.assert_array_equal(found.perturbed["nearer"], found.u)
    assert np.any(found.perturbed["coarser"] != found.u)


OTHERS = {
    "shape": column(12.0, clamped=(2, 3)),
    "support": column(12.5, clamped=(1, 3)),
    "far arc": Body(LOWER, plane(), STEEL, column(12.5).domain),
}


@pytest.mark.parametrize("other", OTHERS.values(), ids=OTHERS)
def test_bodies_of_other_outlines_share_no_model(other):
    store, body = Store(), column(12.5)
    same, own, others = (request(b, Patch(0.4, 0.5), (1.0,), (0.3,)) for b in (column(12.5), body, other))
    for key in (model_key, _index_key):
        assert key(own, store) == key(same, store) != key(others, store)
