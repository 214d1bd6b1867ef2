"""Contacts to solve in tests: quadratic gaps on half-spaces, and a groove of revolution on a rail's arc."""

from dataclasses import dataclass, replace

import numpy as np

from approx.pair import Pair, Solid
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.normal import NormalProblem
from femic.contact.operators.approximations import approximate_operator, half_space_operator
from femic.contact.undeformed import Undeformed
from geometries.contours import arc, ellipse, plane
from geometries.materials import Material
from geometries.patches import Grid, N
from geometries.surfaces import LOWER, UPPER, Surface

STEEL, BRASS = Material(210e3, 0.28), Material(100e3, 0.35)
MODULUS = combined_modulus(BRASS, STEEL)
CIRCLE = PointContact(1 / 20, 1 / 20, MODULUS).at_load(2000.0)
ELLIPSE = PointContact(1 / 30, 1 / 8, MODULUS).at_load(2000.0)
ROOM = (1.9, 2.1)  # sides of a grid over the axes of the ellipse


def level(materials=(BRASS, STEEL)):
    """Half-spaces of the upper and the lower material."""
    return Pair(Solid(materials[0], Surface(UPPER, plane())), Solid(materials[1], Surface(LOWER, plane())))


def half_spaces(grid, *materials):
    """nn of A."""
    return half_space_operator(level(materials or (BRASS, STEEL)), grid, (N,))


def x_of(grid):
    return grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2)


def on_half_spaces(grid, distance, *materials):
    """The problem of half-spaces with any distance."""
    operator = half_spaces(grid, *materials)
    return NormalProblem(grid, operator, operator, distance, np.ones(grid.n_s))


def hertzian(hertz, n_x, n_s, *, room=ROOM, offset=(0.0, 0.0)):
    """The problem of a Hertzian contact, whose centre is `offset` elements away from that of the grid."""
    grid = Grid(n_x, n_s, room[0] * 2 * hertz.a / n_x, room[1] * 2 * hertz.b / n_s)
    x, s = x_of(grid)[:, None] - offset[0] * grid.dx, grid.strips - offset[1] * grid.ds
    h = (hertz.surfaces.curvature_x * x**2 + hertz.surfaces.curvature_s * s**2) / 2
    return on_half_spaces(grid, h)


def conformal(grid, variant="Bhat", *, ratio=1e-2, materials=(BRASS, STEEL), shift=0.0):
    """A wheel whose groove is by this ratio wider than the rail's arc of 10 mm; the flanks are not equal."""
    rail = Surface(LOWER, arc(10.0, 1.3, 1.1))
    wheel = Surface(UPPER, arc(10.0 * (1 + ratio), 1.3, 1.1), 500.0)
    return wheel_on_rail(Undeformed(wheel, rail, (-12.0, 10.0), shift), grid, variant, materials)


def wheel_on_rail(surfaces, grid, variant, materials):
    """The problem of a wheel on a rail."""
    rail = surfaces.lower
    bodies = Pair(Solid(materials[0], surfaces.upper), Solid(materials[1], rail))
    return NormalProblem(
        grid,
        approximate_operator(variant, bodies, grid, (N,)),
        half_spaces(grid, *materials),
        surfaces.distance(x_of(grid)[:, None], grid.strips),
        np.cos(rail.contour.inclination(grid.strips)),
    )


ROLLING_RADIUS = 653.7  # mm, of the wheels with elliptic grooves
GROOVES = {"wide": ((13.7, 6.49), (12.97, 6.485)), "tall": ((6.985, 14.7), (6.485, 12.97))}


def elliptic(name, grid, variant="Bhat"):
    """Steel wheels on elliptic rails: semi-axes (lateral, vertical) of the groove and of the rail in mm."""
    wheel, rail = (
        Surface(side, ellipse(*axes, 1.2, 1.2), radius)
        for side, axes, radius in zip((UPPER, LOWER), GROOVES[name], (ROLLING_RADIUS, np.inf), strict=True)
    )
    return wheel_on_rail(Undeformed(wheel, rail, (-20.0, 20.0)), grid, variant, (STEEL, STEEL))


def with_distance(problem, distance):
    return replace(problem, distance=distance)


@dataclass(frozen=True, eq=False)
class Products:
    """ICs of which only products are known, times a factor."""

    operator: object
    factor: float = 1.0

    def __call__(self, p):
        return self.factor * self.operator(p)

    def restricted(self, directions):
        return replace(self, operator=self.operator.restricted(directions))

    def coarsened(self):
        return replace(self, operator=self.operator.coarsened())


def dense(linear, shape):
    """The matrix of a linear function of arrays of a shape, by unit arrays."""
    size = int(np.prod(shape))
    return np.stack([linear(unit).ravel() for unit in np.eye(size).reshape(size, *shape)], axis=1)


def numbers(contact):
    """Approach, energy, largest pressure; stiffness, half-lengths of the only patch."""
    (patch,), grid = contact.patches, contact.problem.grid
    half_x, half_s = np.diff(patch.x)[0] * grid.dx / 2, np.diff(patch.s)[0] * grid.ds / 2
    return np.array([contact.approach, contact.energy, contact.p.max(), contact.stiffness, half_x, half_s])


def of_hertz(hertz):
    """The same of Hertz."""
    return np.array([hertz.approach, hertz.energy, hertz.p_max, hertz.stiffness, hertz.a, hertz.b])


def hertz_errors(contact, hertz):
    """Relative errors of the numbers."""
    return np.abs(numbers(contact) / of_hertz(hertz) - 1)


def differences(contact):
    """Relative differences of the numbers to those of the coarser contact: the largest of three each.

    A number may be the same on both grids by luck, but not three of them. The last three rest on edges, whose
    own accuracy is added.
    """
    fine, grid, (patch,) = numbers(contact), contact.problem.grid, contact.patches
    each = np.abs(numbers(contact.coarser) / fine - 1)
    of_edges = patch.accuracy_x * grid.dx / fine[4] + patch.accuracy_s * grid.ds / fine[5]
    return np.repeat([np.max(each[:3]), np.max(each[3:]) + of_edges], 3)
