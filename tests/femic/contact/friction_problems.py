"""Contacts with friction to solve in tests, and Coulomb's law as a reader would check it, without the solver.

Slip is computed here from the operator and the definitions of docs/theory/friction.md, element by element.
"""

from dataclasses import dataclass, replace

import numpy as np

from approx.pair import Pair, Solid, matrix
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.friction.motion import DEPTH, LeadingEdge, RollingKinematics
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.operators.approximations import approximate_operator, half_space_operator
from femic.contact.operators.dense import GridOperator
from femic.contact.rolling import RollingProblem
from femic.contact.undeformed import Undeformed
from geometries.contours import arc, plane
from geometries.patches import Grid, N, S, X
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.problems import BRASS, STEEL, level, x_of

STEELS, MIXED = (STEEL, STEEL), (BRASS, STEEL)
POINT = PointContact(1 / 60, 1 / 25, combined_modulus(*STEELS)).at_load(4000.0)
WHEEL = 500.0  # mm, rolling radius of the groove


def paraboloids(n_x=20, n_s=18, *, friction=0.3, materials=STEELS, room=(1.7, 1.8), offset=(0.0, 0.0)):
    """The contact of `POINT`, of semi-axes a and b; its centre is `offset` elements away from the grid's."""
    grid = Grid(n_x, n_s, room[0] * 2 * POINT.a / n_x, room[1] * 2 * POINT.b / n_s)
    x, s = x_of(grid)[:, None] - offset[0] * grid.dx, grid.strips - offset[1] * grid.ds
    h = POINT.surfaces.curvature_x * x**2 / 2 + POINT.surfaces.curvature_s * s**2 / 2
    return on_half_spaces(grid, h, friction=friction, materials=materials)


def on_half_spaces(grid, distance, *, friction=0.3, materials=STEELS):
    """Half-spaces with any distance."""
    flat = half_space_operator(level(materials), grid)
    return FrictionalProblem(grid, flat, flat, distance, np.zeros(grid.n_s), friction)


def groove(n_x=20, n_s=24, *, friction=0.3, materials=STEELS, radius=WHEEL, mirrored=False, shift=-0.07):
    """A groove of radius 10.2 mm on a rail's arc of 10 mm, touching at one side of the crown.

    Contours and grid are not symmetric; `mirrored` in y.
    """
    sign = -1.0 if mirrored else 1.0
    ends = (1.3, 1.1)[:: int(sign)]
    rail = Surface(LOWER, arc(10.0, *ends))
    wheel = Surface(UPPER, arc(10.2, *ends), radius)
    grid = Grid(n_x, n_s, 11.0 / n_x, 9.6 / n_s, sign * 3.5)
    reach = sorted((sign * -8.0, sign * 10.0))
    undeformed = Undeformed(wheel, rail, tuple(reach), sign * shift)
    distance = undeformed.distance(x_of(grid)[:, None], grid.strips)
    pair = Pair(Solid(materials[0], wheel), Solid(materials[1], rail))
    inclination = rail.contour.inclination(grid.strips)
    flat = half_space_operator(level(materials), grid)
    return FrictionalProblem(
        grid, approximate_operator("Bhat", pair, grid), flat, distance, inclination, friction
    )


def wheel_on(problem, *, order=2, mirrored=False):
    """The rolling problem of `groove`, or of half-spaces."""
    inclined = np.any(problem.inclination)
    contour = arc(10.0, *(1.3, 1.1)[:: -1 if mirrored else 1]) if inclined else plane()
    strips = problem.grid.strips
    height = contour.position(strips)[1]
    rolling = RollingKinematics(contour, WHEEL if inclined else np.inf, x_of(problem.grid), strips, height)
    return RollingProblem(problem, rolling, order)


def slip_between(u, rigid, dx, order):
    """Slip of steady rolling between each element and the next one ahead, by plain loops; (n_x - 1, n_s, 2).

    Of order 1 with the rigid slip at the element, else with that half way.
    """
    result = np.zeros((len(u) - 1, *u.shape[1:2], 2))
    for i, j in np.ndindex(*result.shape[:2]):
        w = rigid[i, j] if order == 1 else (rigid[i, j] + rigid[i + 1, j]) / 2
        result[i, j] = w + (u[i, j, :2] - u[i + 1, j, :2]) / dx
    return result


def at_centres(ahead, behind):
    """Slips at elements from those half way ahead of and behind them."""
    sizes = np.linalg.norm(ahead, axis=-1) + np.linalg.norm(behind, axis=-1)
    inner = np.maximum(np.sum(ahead * behind, axis=-1), 0.0)
    weight = 4 * inner / np.maximum(sizes, 1e-300) ** 2
    return ahead + weight[..., None] / 2 * (behind - ahead)


def law_errors(contact, rigid, **motion):
    """Largest errors of Coulomb's law in a contact: `coulomb_errors` with its bounds."""
    problem = contact.problem
    bound = problem.coefficients * contact.p[..., N]
    return coulomb_errors(problem.operator, contact.p, bound, contact.stick, rigid, **motion)


def coulomb_errors(operator, p, bound, stick, rigid, *, order=None, dx=1.0, before=0.0):
    """Largest errors of Coulomb's law on elements as shares of the largest bound, by loops over elements.

    `order` is that of steady rolling; None: a shift. Slip is recomputed from the operator, in units of
    tractions. Returned are: tractions beyond bounds, slip where elements stick, tractions that are not
    opposite to slip where they do not; elements of leading edges only count in the first.
    """
    u = operator(p)
    edge = LeadingEdge.find(bound, DEPTH if order == 2 else 0)
    if order is None:
        sides = (rigid + u[..., :2] - before,) * 2
        own = 1.0
    else:
        ahead = slip_between(u, rigid, dx, order)
        behind = ahead if order == 1 else at_centres(ahead[1:], ahead[:-1])
        none = np.zeros_like(ahead[:1])
        sides = np.concatenate([ahead, none]), np.concatenate(([none] if order == 2 else []) + [behind, none])
        own = 1 / dx
    unit = np.zeros_like(u)
    middle = tuple(n // 2 for n in bound.shape)
    unit[(*middle, X)] = 1.0
    own *= operator(unit)[(*middle, X)]
    beyond, sticks, slips = [0.0], [0.0], [0.0]
    for at in zip(*np.nonzero(bound), strict=True):
        q, g = p[at][:2], bound[at]
        beyond.append(float(np.linalg.norm(q)) - g)
        if not edge.free[at]:
            continue
        if stick[at]:
            sticks.append(float(np.linalg.norm(sides[0][at])) / own)
        else:  # tractions are nearest to tractions - slip of what bounds allow
            moved = q - sides[1][at] / own
            slips.append(float(np.linalg.norm(q - g * moved / np.linalg.norm(moved))))
    return np.array([max(beyond), max(sticks), max(slips)]) / np.max(bound, initial=1e-300)


@dataclass(frozen=True, eq=False)
class Movable:
    """ICs, with bodies that a load also moves as rigid ones: by `x` and `z` [mm/N] along x and z."""

    operator: object
    inclination: np.ndarray
    area: float
    x: float = 0.0
    z: float = 0.0
    directions: tuple = (X, S, N)

    def __call__(self, tractions):
        p = np.zeros((*tractions.shape[:2], 3))
        p[..., self.directions] = tractions
        sin, cos = np.sin(self.inclination), np.cos(self.inclination)
        along_x = self.x * self.area * np.sum(p[..., X])
        along_z = self.z * self.area * np.sum(p[..., N] * cos - p[..., S] * sin)
        one = np.ones_like(p[..., 0])
        moved = np.stack([one * along_x, -one * sin * along_z, one * cos * along_z], axis=-1)
        return self.operator(tractions) + moved[..., self.directions]

    def restricted(self, directions):
        return replace(self, operator=self.operator.restricted(directions), directions=directions)

    def coarsened(self):
        inclination = self.inclination.reshape(-1, 2).mean(axis=1)
        return replace(self, operator=self.operator.coarsened(), inclination=inclination, area=4 * self.area)


def movable(problem, *, x=0.0, z=0.0):
    """The problem with bodies that are moved, too."""
    moved = Movable(problem.operator, problem.inclination, problem.grid.area, x, z)
    return replace(problem, operator=moved)


def by_matrix(problem, materials=STEELS):
    """The same problem of `groove` with its ICs as a matrix."""
    wheel, rail = Surface(UPPER, arc(10.2, 1.3, 1.1)), Surface(LOWER, arc(10.0, 1.3, 1.1))
    pair = Pair(Solid(materials[0], wheel), Solid(materials[1], rail))
    return replace(problem, operator=GridOperator.from_ics(matrix("Bhat", pair, problem.grid)))
