"""Edges of patches from gaps: of line contacts, of ellipses whose gap is known, and beside a joint."""

from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.exact.hertz import LineContact
from femic.contact.finite_elements.meshed_contact import Bodies, MeshedContact, end
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.errors import Failure
from geometries.surfaces import LOWER, UPPER
from tests.femic.contact.problems import STEEL

LINE = LineContact(0.01, 115e3)


def vertices(spacing, low, high, moved=0.25):
    """A grid of points (x, y), moved by up to a share of their spacing."""
    x, y = np.meshgrid(np.arange(0, high, spacing), np.arange(low, high, spacing), indexing="ij")
    move = np.random.default_rng(0).uniform(-moved, moved, (2, *x.shape)) * spacing
    return x.ravel() + move[0].ravel(), y.ravel() + move[1].ravel()


@pytest.mark.parametrize("spacing", [0.1, 0.05])
def test_edge_of_a_line_contact_is_accurate(spacing):
    """Hertz's gap; the edge is straight. The error falls with the spacing."""
    half_width = LINE.half_width(100.0)
    x, y = vertices(spacing * half_width, 0.0, 2 * half_width)
    result = end(x, y, LINE.gap(100.0, x), spacing * half_width, symmetric=True)
    assert result == pytest.approx(half_width, abs=0.05 * spacing * half_width)


def elliptic_gap(x, y, middle, half_width=0.6):
    """Grows as distance^(3/2) from the ellipse with the semi-axis 1 along x, more so farther out."""
    radius = np.hypot(x, (y - middle) / half_width)
    return np.maximum(radius - 1, 0) ** 1.5 * (1 + 0.2 * radius)


@pytest.mark.parametrize("middle", [0.0, 0.13])
def test_tip_of_an_ellipse_is_accurate(middle):
    x, y = vertices(0.06, -1.2 if middle else 0.0, 1.6)
    result = end(x, y, elliptic_gap(x, y, middle), 0.06, symmetric=middle == 0)
    assert result == pytest.approx(1.0, abs=0.15 * 0.06)


def short_surface(room, between, moved=0.25):
    """Vertices at its end, `room` from the long side of an ellipse, and up to `between` from those touching.

    Both in spacings of vertices; returns the arguments of `end`.
    """
    spacing, half_width = 0.06, 4.0
    x, y = vertices(spacing, 0.0, half_width, moved=moved)
    x = x - spacing / 2
    last = x[elliptic_gap(x, y, 0.0, half_width) <= 0].max()
    inner, along_end = x < last + between * spacing, np.arange(0.0, half_width, spacing)
    x = np.append(x[inner], np.full_like(along_end, 1 + room * spacing))
    y = np.append(y[inner], along_end)
    return x, y, elliptic_gap(x, y, 0.0, half_width), spacing


@pytest.mark.parametrize(
    ("room", "between", "moved"),
    [(1.1, 0.45, 0.25), (1.5, 0.45, 0.25), (2.2, 0.45, 0.25), (2.2, 1.2, 0.0)],
    ids=["1.1", "1.5", "2.2", "two lines"],
)
def test_surface_ending_close_beyond_the_patch_shows_the_edge(room, between, moved):
    result = end(*short_surface(room, between, moved), symmetric=True)
    assert result == pytest.approx(1.0, abs=0.15 * 0.06)


def test_too_few_vertices_and_a_single_line_of_them_are_refused():
    x, y = vertices(0.06, 0.0, 1.02)
    with pytest.raises(Failure, match="more cells"):
        end(x, y, elliptic_gap(x, y, 0.0), 0.06, symmetric=True)
    with pytest.raises(Failure, match="side by side"):
        end(*short_surface(1.5, between=0.0), symmetric=True)


# ---- near a joint of the contours, where gaps begin to grow otherwise

RADIUS, FLANK, EDGE, SPACING = 10.0, 0.9, 7.0, 0.8  # mm, rad, mm, mm


def beside_a_joint(end=15.0, kink=100.0):
    """A patch that ends at `EDGE`, of vertices up to s = `end`; gaps are steep beyond the lower joint."""
    x, s = (
        grid.ravel()
        for grid in np.meshgrid(np.arange(0, 3, SPACING), np.arange(0.1, end, SPACING), indexing="ij")
    )
    gap = np.maximum(s - EDGE + 0.02 * x**2, 0) ** 1.5 + kink * np.maximum(s - RADIUS * FLANK, 0)
    bodies = Bodies(
        Body(LOWER, arc(RADIUS, FLANK, FLANK), STEEL, Domain(100.0, 100.0)),
        Body(UPPER, arc(1.02 * RADIUS, FLANK, FLANK), STEEL, Domain(100.0, 100.0), rolling_radius=400.0),
        (-20.0, 20.0),
    )
    area = np.full(len(x), SPACING**2)
    pair = SimpleNamespace(x=x, s=s, area=area, gap=lambda *_: gap * area)
    state = SimpleNamespace(u_lower=None, u_upper=None, approach=None)
    solution = SimpleNamespace(state=state, active=gap == 0)
    return MeshedContact(bodies, None, 1.0, pair, solution, 0.0)


def test_edge_before_a_joint_is_read_from_gaps_before_the_joint():
    """A tenth of the spacing is what reading an edge is good to."""
    assert beside_a_joint().s_range == pytest.approx((-EDGE, EDGE), abs=0.1 * SPACING)
    assert beside_a_joint().s_range == pytest.approx(beside_a_joint(kink=0.0).s_range, abs=0.03 * SPACING)
