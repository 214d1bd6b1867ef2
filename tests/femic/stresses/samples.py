"""Tractions, bodies and points that tests of stresses share."""

import numpy as np

from femic.stresses.points import InnerPoints, SurfaceTractions
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.materials import Material
from geometries.patches import Grid

STEEL = Material(210e3, 0.28)
SIDES = (+1, -1)


def grid_of(n_x, n_s, half_x, half_s, s=0.0):
    return Grid(n_x, n_s, 2 * half_x / n_x, 2 * half_s / n_s, s)


def tractions_of(grid, function):
    """Tractions function(x, s) -> (p_x, p_s, p_n) at the centres of elements."""
    x = grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2)
    parts = [part + np.zeros((grid.n_x, grid.n_s)) for part in function(x[:, None], grid.strips)]
    return SurfaceTractions(grid, np.stack(parts, axis=-1))


def unsymmetric(grid, a, b):
    """A smooth pressure with friction on the ellipse of semi-axes a, b about the middle of a grid."""

    def tractions(x, s):
        p = np.maximum(1 - (x / a) ** 2 - ((s - grid.s) / b) ** 2, 0) ** 1.5
        return 0.3 * p * (1 + 0.5 * x / a), -0.2 * p * (1 - 0.3 * s / b), p

    return tractions_of(grid, tractions)


def flat(side, far_radius=150.0, material=STEEL):
    return Body(side, plane(), material, Domain(far_radius, np.inf))


def curved(side, radius=10.0, far_radius=80.0, **options):
    return Body(side, arc(radius, 1.2, 1.0), STEEL, Domain(far_radius, np.inf), **options)


def section_points(s, depth, x=0.0):
    """Points of the section at x, shape (len(s), len(depth))."""
    return InnerPoints(x, np.asarray(s)[:, None], np.asarray(depth)[None])
