"""Sliding contacts of closed form, to test damage with."""

import numpy as np

from femic.contact.exact.hertz import PointContact
from femic.damage.laws import Sliding
from geometries.patches import Grid

HERTZ = PointContact(1 / 60, 1 / 25, 114e3).at_load(4000.0)
FRICTION, CREEPAGE = 0.3, 0.02


def grid_over(n_x, n_s, hertz=HERTZ):
    """A grid that ends at the axes of the ellipse, not square."""
    return Grid(n_x, n_s, 2 * hertz.a / n_x, 2 * hertz.b / n_s)


def along_x(grid):
    return grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2)


def full_sliding(n_x=40, n_s=30, *, creepage=CREEPAGE, speed=10.0, friction=FRICTION):
    """A driven wheel whose whole Hertz contact slides, bodies rigid but for pressures."""
    grid = grid_over(n_x, n_s)
    p = HERTZ.pressure(along_x(grid)[:, None], grid.strips)
    forwards = np.multiply(np.ones((n_x, n_s, 2)), [1.0, 0.0])
    return Sliding(grid, p, friction * p[..., None] * forwards, -creepage * forwards, speed)
