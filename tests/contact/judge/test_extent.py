"""Edges of patches from gaps: those of line contacts, and of ellipses whose gap is known."""

import numpy as np
import pytest

from contact.judge.extent import end
from contact.references.hertz import LineContact
from geometries.errors import Failure

LINE = LineContact(0.01, 115e3)


def vertices(spacing, low, high, seed=0):
    """An irregular triangular grid of points (x, y)."""
    x, y = np.meshgrid(np.arange(0, high, spacing), np.arange(low, high, spacing), indexing="ij")
    move = np.random.default_rng(seed).uniform(-0.25, 0.25, (2, *x.shape)) * spacing
    return x.ravel() + move[0].ravel(), y.ravel() + move[1].ravel()


@pytest.mark.parametrize("spacing", [0.1, 0.05])
def test_the_edge_of_a_line_contact(spacing):
    """Hertz's gap; the edge is straight. The error falls with the spacing."""
    half_width = LINE.half_width(100.0)
    x, y = vertices(spacing * half_width, 0.0, 2 * half_width)
    found = end(x, y, LINE.gap(100.0, x), spacing * half_width, symmetric=True)
    assert found == pytest.approx(half_width, abs=0.05 * spacing * half_width)


def elliptic_gap(x, y, middle):
    """Grows as distance^(3/2) from the ellipse with the semi-axes 1 and 0.6, more so farther out."""
    radius = np.hypot(x, (y - middle) / 0.6)
    return np.maximum(radius - 1, 0) ** 1.5 * (1 + 0.2 * radius)


@pytest.mark.parametrize("middle", [0.0, 0.13])
def test_the_tip_of_an_ellipse(middle):
    x, y = vertices(0.06, -1.2 if middle else 0.0, 1.6)
    found = end(x, y, elliptic_gap(x, y, middle), 0.06, symmetric=middle == 0)
    assert found == pytest.approx(1.0, abs=0.15 * 0.06)


def test_too_few_vertices_are_refused():
    x, y = vertices(0.06, 0.0, 1.02)
    with pytest.raises(Failure, match="more cells"):
        end(x, y, elliptic_gap(x, y, 0.0), 0.06, symmetric=True)
