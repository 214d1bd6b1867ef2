"""Statement 44: whether contact with friction is what closed forms say, on half-spaces.

Carter's rolling cylinders, Kalker's linear coefficients, full slip, Cattaneo's shift under load, and cones
that roll freely on the arc of a rail.

A cone with inclination delta touches the rail where this is inclined alike, on a circle of radius r. Without
a force along x it rolls on that circle: omega r = V, thus xi = R / r - 1. Its rotation has the part omega
sin(delta) about the normal: a spin sin(delta) / r, whose forces are Kalker's where nothing slips.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from approx.pair import Pair, Solid
from compare.report.charts import Panel, make_curves
from compare.validation.statements.frame import Statement, Values, below
from compare.validation.statements.runs import Runs, solved_once
from compare.validation.study import kalker_coefficients
from femic.contact.exact.friction import ShiftedPoint, TractiveRolling
from femic.contact.exact.hertz import LineContact, LoadedPoint, PointContact, combined_modulus
from femic.contact.friction import coulomb
from femic.contact.friction.coulomb import Coulomb, FreeAmplitudes
from femic.contact.friction.law import Strips
from femic.contact.friction.motion import (
    Creepages,
    LeadingEdge,
    RollingKinematics,
    Shift,
    SteadyRolling,
)
from femic.contact.frictional import FrictionalContact, solve
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.operators.approximations import half_space_operator
from femic.contact.operators.convolution import Convolution
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import frictional_problem, rolling_problem
from femic.contact.rolling import RollingContact, RollingProblem
from femic.contact.undeformed import Undeformed
from geometries.arrays import Array
from geometries.contours import arc, plane, through_points
from geometries.materials import Material
from geometries.patches import Grid, S, X
from geometries.surfaces import LOWER, UPPER, Surface

# --- cones ----------------------------------------------------------------------------------------------


STEEL = Material(210e3, 0.28)
CONE_LOAD, STEEP_FRICTION = 200.0, 10.0  # N, friction
RADIUS, RAIL, SHIFT = 460.0, 300.0, 40.0  # mm: of the wheel at its crown, of the rail; of the wheel along y
SLOPES = (1 / 20, -1 / 20)  # of cones, positive where they fall towards +y
REACH = 0.3  # inclination [rad] to which the rail is an arc
ELEMENTS, ROOM = (40, 36), 1.4  # of a grid along x and s; its sides over the axes of the ellipse

# of the free creepage: the rail's inclination varies over a patch, by a b / (RAIL RADIUS xi)
CIRCLE_TOLERANCE = 0.002
SPIN_TOLERANCE = 0.02  # of forces of a spin: elements of a fortieth of the patch


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
        return surfaces.at_load(CONE_LOAD / np.cos(self.delta))

    @property
    def free(self) -> float:
        """Creepage xi without a force along x."""
        return RADIUS / self.circle - 1

    @property
    def forces(self) -> tuple[float, float, float]:
        """F_x, F_s [N], M_n [N mm] of the spin where nothing slips."""
        spin = float(np.sin(self.delta)) / self.circle
        return kalker_coefficients(self.ellipse, STEEL.nu).forces(STEEL.G, 0.0, 0.0, spin)


def grid_over(ellipse: LoadedPoint, s: float = 0.0) -> Grid:
    """Return a grid about an ellipse whose middle has the arc length s [mm]."""
    n_x, n_s = ELEMENTS
    return Grid(n_x, n_s, ROOM * 2 * ellipse.a / n_x, ROOM * 2 * ellipse.b / n_s, s)


def on_grid(cone: Cone) -> PairOnGrid:
    """Return the cone and the rail as half-spaces, on a grid about the ellipse."""
    y, reach = np.linspace(-100.0, 100.0, 5), REACH * RAIL
    wheel = Surface(UPPER, through_points(y, -np.tan(cone.delta) * y), RADIUS)
    rail = Surface(LOWER, arc(RAIL, REACH, REACH))
    undeformed = Undeformed(wheel, rail, (-reach, reach), SHIFT)
    return PairOnGrid(
        Pair(Solid(STEEL, wheel), Solid(STEEL, rail)), undeformed, grid_over(cone.ellipse, cone.s)
    )


@solved_once("cones")
def rolling_cones(_: Runs) -> Mapping[str, tuple[Cone, RollingContact]]:
    """Return cones with their names, and their steady rolling without a force along x."""
    contacts = {}
    for slope in SLOPES:
        cone = Cone(float(np.arctan(slope)))
        pair = on_grid(cone)
        problem = frictional_problem(pair, half_space_operator(pair.pair, pair.grid), STEEP_FRICTION)
        wheel = rolling_problem(pair, problem)
        rolled = wheel.contact(Creepages(), Loading(CONE_LOAD), forces={"longitudinal": 0.0})
        contacts[f"cone {slope:+g}"] = cone, rolled
    return contacts


@below(
    CIRCLE_TOLERANCE,
    "circles",
    "free cones: relative error of the creepage R / r - 1 of the circle that rolls",
)
def _circles(runs: Runs) -> Values:
    return {
        name: float(abs(contact.creepages.longitudinal / cone.free - 1))
        for name, (cone, contact) in rolling_cones(runs).items()
    }


@below(
    SPIN_TOLERANCE,
    "spin of cones",
    "free cones: error of F_s, M_n of their spin sin(δ) / r over the larger one",
)
def _spin_of_cones(runs: Runs) -> Values:
    errors: dict[str, float] = {}
    for name, (cone, contact) in rolling_cones(runs).items():
        pair, p = on_grid(cone), contact.contact.p
        lever_s, lever_x = pair.x[:, None], pair.grid.strips - cone.s
        moment = float(np.sum(lever_s * p[..., S] - lever_x * p[..., X]))
        found = np.array([float(np.sum(p[..., S])), moment]) * pair.grid.area
        size = np.array([1.0, np.sqrt(cone.ellipse.a * cone.ellipse.b)])
        exact = np.array(cone.forces[1:]) / size
        apart = np.abs(found / size - exact) / np.max(np.abs(exact))
        errors |= {f"{name}, {label}": float(e) for label, e in zip(("F_s", "M_n"), apart, strict=True)}
    return errors


# --- Carter's cylinders ---------------------------------------------------------------------------------


CYLINDERS, LINE_LOAD = LineContact(1 / 50, combined_modulus(STEEL, STEEL)), 1000.0  # N/mm
ACROSS = 40  # elements across the contact
CARTERS = (0.2, 0.5, 0.8)  # creepages over that of full slip
FRICTION = 0.3

FORCE_TOLERANCE = 0.02  # forces and coefficients against closed forms: elements of a fortieth of the patch
TRACTION_TOLERANCE = 0.05  # mean difference of tractions over their mean: edges cut elements
EXACTLY = 1e-4  # where the closed form does not depend on elements


# --- Carter ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class CarterContact:
    """Tractions [MPa] of rolling cylinders on elements about x [mm], (n,), and what Carter has."""

    x: Array
    p: Array
    stick: Array
    dx: float
    exact: TractiveRolling

    @property
    def force_error(self) -> float:
        """Relative error of the force."""
        return abs(float(np.sum(self.p)) * self.dx / self.exact.force - 1)

    @property
    def stick_error(self) -> float:
        """Error of the width that sticks, over the width of the contact."""
        width = np.count_nonzero(self.stick) * self.dx
        return abs(width - 2 * self.exact.stick_half_width) / (2 * self.exact.half_width)


def carter(share: float) -> CarterContact:
    """Return rolling cylinders at a share of the creepage of full slip, in two dimensions."""
    creepage = share * TractiveRolling(CYLINDERS, LINE_LOAD, FRICTION, 0.0).largest_creepage
    exact = TractiveRolling(CYLINDERS, LINE_LOAD, FRICTION, creepage)
    n, dx = ACROSS + 8, 2 * exact.half_width / ACROSS
    x = centres(n, dx)
    middles = x[:, None] + dx * (np.arange(20) - 9.5) / 20
    bound = FRICTION * np.mean(CYLINDERS.pressure(LINE_LOAD, middles), axis=1)[:, None]
    rigid = np.zeros((n, 1, 2))
    rigid[..., X] = -creepage
    # ICs of strips of width dx in plane strain, -2 ln|x| / (pi E*), along x and across
    edges = np.asarray(dx * (np.arange(2 * n) - n + 0.5), dtype=float)  # of lags
    integral = edges * np.log(np.abs(edges) / (n * dx)) - edges
    kernel = -2 / (np.pi * CYLINDERS.modulus) * np.diff(integral)
    operator = Convolution((X, S), {"1": np.ones(1)}, {((i, "1"), (i, "1")): kernel[:, None] for i in (X, S)})
    motion, none = SteadyRolling(rigid, dx=dx), np.zeros((0, *bound.shape, 2))
    solved = coulomb.tractions(
        Coulomb(
            lambda p: motion.elastic_slip(operator(p)),
            Strips.on_half_spaces(operator, motion),
            motion.given,
            bound,
            LeadingEdge.find(bound, motion.depth),
            motion,
            FreeAmplitudes(none, none, np.zeros(0)),
        )
    )
    sticks = solved.stick[:, 0] & (bound[:, 0] > 0)
    return CarterContact(x, solved.p[:, 0, X], sticks, dx, exact)


def centres(n: int, step: float) -> Array:
    """Return the centres of n elements about 0."""
    return np.asarray(step * (np.arange(n) - (n - 1) / 2), dtype=float)


@below(FORCE_TOLERANCE, "Carter", "Carter: relative error of the force")
def _carter_force(_: Runs) -> Values:
    return {f"{share:g} of full slip": carter(share).force_error for share in CARTERS}


@below(TRACTION_TOLERANCE, "Carter stick", "Carter: error of the width that sticks over that of the contact")
def _carter_stick(_: Runs) -> Values:
    return {f"{share:g} of full slip": carter(share).stick_error for share in CARTERS}


# --- an ellipse -----------------------------------------------------------------------------------------


LOAD = 4000.0  # N
POINT = PointContact(1 / 60, 1 / 25, combined_modulus(STEEL, STEEL)).at_load(LOAD)
BARELY_SLIPS, LITTLE = 10.0, 1e-5  # friction and creepage of the linear theory
SLIDES = 20.0  # creepages of full slip over that at which Kalker's force is friction times load
SHIFTED = (0.3, 0.6)  # forces over friction times load of a shift


def ellipse(friction: float) -> FrictionalProblem:
    """Return the contact of `POINT` on half-spaces."""
    grid, curved = grid_over(POINT), POINT.surfaces
    x = centres(grid.n_x, grid.dx)[:, None]
    distance = curved.curvature_x * x**2 / 2 + curved.curvature_s * grid.strips**2 / 2
    bodies = Pair(Solid(STEEL, Surface(UPPER, plane())), Solid(STEEL, Surface(LOWER, plane())))
    flat = half_space_operator(bodies, grid)
    return FrictionalProblem(grid, flat, flat, distance, np.zeros(grid.n_s), friction)


def rolls(friction: float, creepages: Creepages) -> tuple[FrictionalContact, RollingProblem]:
    """Return steady rolling on the ellipse, without curvature of the wheel in its kinematics."""
    problem = ellipse(friction)
    x, strips = centres(problem.grid.n_x, problem.grid.dx), problem.grid.strips
    kinematics = RollingKinematics(plane(), np.inf, x, strips, np.zeros_like(strips))
    wheel = RollingProblem(problem, kinematics, order=2)
    return wheel.contact(creepages, Loading(LOAD)).contact, wheel


@below(FORCE_TOLERANCE, "Kalker", "Kalker: error of F_x, F_y, M_z of small creepages over the largest")
def _kalker(_: Runs) -> Values:
    length = np.sqrt(POINT.a * POINT.b)
    coefficients = kalker_coefficients(POINT, STEEL.nu)
    errors: dict[str, float] = {}
    for name, size in (("longitudinal", LITTLE), ("lateral", LITTLE), ("spin", LITTLE / length)):
        contact, wheel = rolls(BARELY_SLIPS, Creepages(**{name: size}))
        sizes = [size * (name == other) for other in ("longitudinal", "lateral", "spin")]
        F_x, F_s, M_n = coefficients.forces(STEEL.G, *sizes)
        exact = np.array([F_x, F_s, M_n / length])
        moment = float(np.sum(contact.p * wheel.weights["spin"])) / length
        apart = np.abs([*contact.force[:2], moment] - exact) / np.max(np.abs(exact))
        labels = zip(("F_x", "F_y", "M_z"), apart, strict=True)
        errors |= {f"{name}, {label}": float(error) for label, error in labels}
    return errors


@below(EXACTLY, "full slip", "full slip: force along its direction over friction load, less 1")
def _full_slip(_: Runs) -> Values:
    C11 = kalker_coefficients(POINT, STEEL.nu).C11
    saturating = float(FRICTION * LOAD / (STEEL.G * POINT.a * POINT.b * C11))  # Kalker's force is the bound
    size, errors = SLIDES * saturating, dict[str, float]()
    directions = {"driven": (1, 0), "braked": (-1, 0), "aside": (0, 1), "driven and aside": (0.6, 0.8)}
    for label, (along, aside) in directions.items():
        contact, _wheel = rolls(FRICTION, Creepages(along * size, aside * size))
        opposite = np.array([along, -aside])  # force on the wheel: along a drive, against lateral slip
        errors[label] = abs(float(contact.force[:2] @ opposite) / (FRICTION * LOAD) - 1)
    return errors


@solved_once("shifts")
def shifts(_: Runs) -> Mapping[str, tuple[FrictionalContact, ShiftedPoint, int]]:
    """Return contacts after a shift, Cattaneo's with the force that goes with it, and its direction."""
    contacts, problem = {}, ellipse(FRICTION)
    for direction, label in ((X, "x"), (S, "s")):
        for share in SHIFTED:
            exact = ShiftedPoint(POINT, STEEL.nu, FRICTION, share * FRICTION * LOAD, direction)
            rigid = np.zeros((*problem.distance.shape, 2))
            rigid[..., direction] = -exact.shift
            contact = solve(problem, Shift(rigid), Loading(LOAD))
            contacts[f"along {label}, {share:g} of friction load"] = contact, exact, direction
    return contacts


@below(FORCE_TOLERANCE, "Cattaneo", "Cattaneo: relative error of the force")
def _cattaneo_force(runs: Runs) -> Values:
    return {
        case: abs(float(contact.force[direction]) / exact.force - 1)
        for case, (contact, exact, direction) in shifts(runs).items()
    }


@below(TRACTION_TOLERANCE, "Cattaneo tractions", "Cattaneo: mean difference of tractions over their mean")
def _cattaneo_tractions(runs: Runs) -> Values:
    errors: dict[str, float] = {}
    for case, (contact, exact, direction) in shifts(runs).items():
        grid = contact.problem.grid
        traction = exact.traction(centres(grid.n_x, grid.dx)[:, None], grid.strips)
        apart = np.abs(contact.p[..., direction] - traction)
        errors[case] = float(np.mean(apart) / np.mean(np.abs(traction)))
    return errors


# --- the statement --------------------------------------------------------------------------------------


def _panels(runs: Runs) -> Iterator[Panel]:
    p_max = FRICTION * CYLINDERS.p_max(LINE_LOAD)
    for share in CARTERS:
        solved = carter(share)
        fine = np.linspace(-1.05, 1.05, 421) * solved.exact.half_width
        exact = np.interp(solved.x, fine, solved.exact.traction(fine))
        curves = make_curves(solved.x, {"closed form": exact / p_max, "femic": solved.p / p_max})
        yield Panel(f"Carter, {share:g} of full slip", "x [mm]", "p_x over friction p_max [-]", curves)
    for case, (contact, shifted, direction) in shifts(runs).items():
        grid, row = contact.problem.grid, contact.problem.grid.n_x // 2
        traction = shifted.traction(centres(grid.n_x, grid.dx)[row], grid.strips)
        both = {"closed form": traction, "femic": contact.p[row, :, direction]}
        yield Panel(f"Cattaneo {case}", "s [mm]", "traction [MPa]", make_curves(grid.strips, both))


STATEMENTS = (
    Statement(
        44,
        "Rolling and shifts agree with closed-form solutions.",
        (
            *(_carter_force, _carter_stick, _kalker, _full_slip),
            *(_cattaneo_force, _cattaneo_tractions, _circles, _spin_of_cones),
        ),
        _panels,
        columns=3,
    ),
)
