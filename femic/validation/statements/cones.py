"""Cones that roll freely on the arc of a rail, for statement 44: circles of a wheel against closed forms.

A cone with inclination delta touches the rail where this is inclined alike, on a circle of radius r. Without
a force along x it rolls on that circle: omega r = V, thus xi = R / r - 1. Its rotation has the part omega
sin(delta) about the normal: a spin sin(delta) / r, whose forces are Kalker's where nothing slips.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from approx.pair import Pair, Solid
from femic.contact.exact.hertz import LoadedPoint, PointContact, combined_modulus
from femic.contact.friction.kinematics import Creepages
from femic.contact.loading import Loading
from femic.contact.operators.approximations import half_space_operator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import frictional_problem, rolling_problem
from femic.contact.rolling import RollingContact
from femic.contact.undeformed import Undeformed
from femic.validation.kalker import coefficients_of
from femic.validation.statements.criteria import Numbers
from femic.validation.statements.runs import Runs
from geometries.arrays import Array
from geometries.contours import arc, through_points
from geometries.grids import Grid
from geometries.materials import Material
from geometries.patches import S, X
from geometries.surfaces import LOWER, UPPER, Surface

STEEL = Material(210e3, 0.28)
LOAD, BARELY_SLIPS = 200.0, 10.0  # N, friction
RADIUS, RAIL, SHIFT = 460.0, 300.0, 40.0  # mm: of the wheel at its crown, of the rail; of the wheel along y
SLOPES = (1 / 20, -1 / 20)  # of cones, positive where they fall towards +y
REACH = 0.3  # inclination [rad] to which the rail is an arc
ELEMENTS, ROOM = (40, 36), 1.4  # of a grid along x and s; its sides over the axes of the ellipse

ON_CIRCLE = 0.002  # of the free creepage: the rail's inclination varies over a patch, a b / (RAIL RADIUS xi)
OF_SPIN = 0.02  # of forces of a spin: elements of a fortieth of the patch


@dataclass(frozen=True)
class Cone:
    """A cone with inclination `delta` [rad] beside the crown of a rail."""

    delta: float

    @property
    def s(self) -> float:
        """Arc length [mm] of the rail where both touch."""
        return RAIL * self.delta

    @property
    def circle(self) -> float:
        """Radius r [mm] of the circle on which the cone touches."""
        return float(RADIUS + np.tan(self.delta) * (RAIL * np.sin(self.delta) - SHIFT))

    @property
    def ellipse(self) -> LoadedPoint:
        """The contact of Hertz, under the load along the normal."""
        surfaces = PointContact(np.cos(self.delta) / self.circle, 1 / RAIL, combined_modulus(STEEL, STEEL))
        return surfaces.at_load(LOAD / np.cos(self.delta))

    @property
    def free(self) -> float:
        """Creepage xi without a force along x."""
        return RADIUS / self.circle - 1

    @property
    def forces(self) -> tuple[float, float, float]:
        """F_x, F_s [N], M_n [N mm] of the spin where nothing slips."""
        spin = float(np.sin(self.delta)) / self.circle
        return coefficients_of(self.ellipse, STEEL.nu).forces(STEEL.G, 0.0, 0.0, spin)


def on_grid(cone: Cone) -> PairOnGrid:
    """Return the cone and the rail as half-spaces, on a grid about the ellipse."""
    y = np.linspace(-100.0, 100.0, 5)
    wheel = Surface(UPPER, through_points(y, -np.tan(cone.delta) * y), RADIUS)
    rail = Surface(LOWER, arc(RAIL, REACH, REACH))
    (n_x, n_s), ellipse = ELEMENTS, cone.ellipse
    grid = Grid(n_x, n_s, ROOM * 2 * ellipse.a / n_x, ROOM * 2 * ellipse.b / n_s, cone.s)
    reach = REACH * RAIL
    undeformed = Undeformed(wheel, rail, (-reach, reach), SHIFT)
    return PairOnGrid(Pair(Solid(STEEL, wheel), Solid(STEEL, rail)), undeformed, grid)


def rolls_freely(cone: Cone) -> RollingContact:
    """Return steady rolling without a force along x."""
    pair = on_grid(cone)
    problem = frictional_problem(pair, half_space_operator(pair.pair, pair.grid), BARELY_SLIPS)
    wheel = rolling_problem(pair, problem)
    return wheel.contact(Creepages(), Loading(LOAD), forces={"longitudinal": 0.0})


def spin_forces(cone: Cone, p: Array) -> Array:
    """Return F_s [N] and M_n [N mm] of tractions on the grid."""
    pair = on_grid(cone)
    along_s = float(np.sum(p[..., S]))
    moment = float(np.sum(pair.x[:, None] * p[..., S] - (pair.grid.strips - cone.s) * p[..., X]))
    return np.array([along_s, moment]) * pair.grid.area


def _rolling(runs: Runs) -> Iterator[tuple[str, Cone, RollingContact]]:
    """Yield cones with their names and contacts, which are solved once."""

    def solved(_: Runs) -> Mapping[float, RollingContact]:
        return {slope: rolls_freely(Cone(float(np.arctan(slope)))) for slope in SLOPES}

    contacts: Mapping[float, RollingContact] = runs.remembered("cones", solved)
    for slope, contact in contacts.items():
        yield f"cone {slope:+g}", Cone(float(np.arctan(slope))), contact


def circle_errors(runs: Runs) -> Mapping[str, float]:
    """Return errors of the free creepage over R / r - 1."""
    return {
        name: float(abs(contact.creepages.longitudinal / cone.free - 1))
        for name, cone, contact in _rolling(runs)
    }


def spin_errors(runs: Runs) -> Mapping[str, float]:
    """Return errors of F_s and M_n of the cone's spin over the larger one of Kalker's."""
    errors: dict[str, float] = {}
    for name, cone, contact in _rolling(runs):
        size = np.array([1.0, np.sqrt(cone.ellipse.a * cone.ellipse.b)])
        exact = np.array(cone.forces[1:]) / size
        apart = np.abs(spin_forces(cone, contact.contact.p) / size - exact) / np.max(np.abs(exact))
        errors |= {f"{name}, {label}": float(e) for label, e in zip(("F_s", "M_n"), apart, strict=True)}
    return errors


CRITERIA = (
    Numbers(circle_errors).below(
        ON_CIRCLE, "circles", "free cones: relative error of the creepage R / r - 1 of the circle that rolls"
    ),
    Numbers(spin_errors).below(
        OF_SPIN, "spin of cones", "free cones: error of F_s, M_n of their spin sin(δ) / r over the larger one"
    ),
)
