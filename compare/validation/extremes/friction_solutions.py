"""Contacts with friction at limits: steady rolling, rolling from rest, compression, and their closed forms.

Closed forms are those of Kalker and Carter, Coulomb's law, full stick, and no friction. Each returns the
numbers that it has of a contact of rollers; similar bodies unless it says otherwise.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import wraps
from typing import Any

import numpy as np

from compare.validation.extremes.contacts import (
    ContactSolution,
    Solver,
    Truth,
    error_scales,
    hertz_bump,
    hertz_contact,
)
from compare.validation.study import kalker_coefficients
from femic.contact.estimates import Measured, Numbers, errors
from femic.contact.exact.friction import StickingPoint, TractiveRolling
from femic.contact.exact.hertz import LineContact, LoadedPoint
from femic.contact.friction.motion import Creepages
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.motions import solve_with_friction
from femic.contact.motions.compression import OF_COMPRESSION, estimate_steps, in_halves, solve_steps
from femic.contact.motions.rolling import OF_ROLLING, measured_rolling
from femic.contact.motions.transient import estimate_path, solve_path
from femic.contact.pairs.pair_with_friction import PairWithFriction, on_larger_elements
from femic.contact.pairs.quantities import Quantity, kinds
from femic.contact.specification import ContactProblem, FrictionSpecification

# --- closed forms ---------------------------------------------------------------------------------------


STRIPS = 4001  # of an ellipse


def kalker(solved: ContactSolution) -> dict[str, float]:
    """Return forces and moment of elastically similar bodies where nothing slips, and Hertz."""
    hertz = hertz_contact(solved.problem)
    F_x, F_y, M_z = _sticking(solved.problem, hertz, friction_specification(solved))
    return {"F_x": F_x, "F_y": F_y, "M_z": M_z, "p_max": hertz.p_max}


def _sticking(
    problem: ContactProblem, patch: LoadedPoint, asked: FrictionSpecification
) -> tuple[float, float, float]:
    """Return F_x, F_s [N] and M_n [N mm] of a patch where nothing slips."""
    constants = problem.pair.constants
    coefficients = kalker_coefficients(patch, float(constants.nu))
    return coefficients.forces(float(constants.G), asked.longitudinal[-1], asked.lateral, asked.spin)


def sliding(solved: ContactSolution) -> dict[str, float]:
    """Return the numbers where all slides in one direction: Coulomb's law, and Hertz."""
    asked, hertz = friction_specification(solved), hertz_contact(solved.problem)
    xi, upsilon = asked.longitudinal[-1], asked.lateral
    size, largest = float(np.hypot(xi, upsilon)), asked.coefficients[0] * hertz.load
    return {
        "F_x": largest * xi / size,
        "F_y": -largest * upsilon / size,
        "dissipation": largest * size,
        "sliding_share": 1.0,
        "p_max": hertz.p_max,
    }


def turning(solved: ContactSolution) -> dict[str, float]:
    """Return the numbers of a circle that slides about its middle: M = 3 pi / 16 friction load a."""
    asked, hertz = friction_specification(solved), hertz_contact(solved.problem)
    moment = 3 * np.pi / 16 * asked.coefficients[0] * hertz.load * hertz.a
    return {
        "M_z": -moment * np.sign(asked.spin),
        "dissipation": moment * abs(asked.spin),
        "sliding_share": 1.0,
    }


def carter(solved: ContactSolution) -> dict[str, float]:
    """Return the force of strips along x, each a contact of cylinders: of patches much longer along s."""
    asked, hertz = friction_specification(solved), hertz_contact(solved.problem)
    s = (np.arange(STRIPS) + 0.5) / STRIPS * 2 - 1  # over b
    surfaces = LineContact(hertz.surfaces.curvature_x, hertz.surfaces.modulus)
    loads = np.pi / 2 * hertz.a * hertz.p_max * (1 - s**2)  # N/mm
    friction, xi = asked.coefficients[0], asked.longitudinal[-1]
    forces = [TractiveRolling(surfaces, load, friction, xi).force for load in loads.tolist()]
    return {"F_x": float(np.mean(forces)) * 2 * hertz.b}


def without_friction(solved: ContactSolution) -> dict[str, float]:
    """Return the numbers without friction on the same grid."""
    on_grid, load = solved.on_grid, solved.problem.specification.loads[-1]
    (name,) = solved.problem.specification.ics
    contact = on_grid.solve_in_place(on_grid.operator(name), Loading(load))
    return {"approach": contact.approach, "p_max": float(np.max(contact.p)), "area": contact.area}


def full_stick(solved: ContactSolution) -> dict[str, float]:
    """Return the numbers of unlike bodies with equal curvatures that stick wherever they touch."""
    hertz, constants = hertz_contact(solved.problem), solved.problem.pair.constants
    beta = float(constants.mismatch_k / (1 - constants.nu))
    exact = StickingPoint(hertz.surfaces.curvature_x, hertz.surfaces.modulus, abs(beta))
    radius = exact.radius(hertz.load)
    return {"approach": exact.approach(hertz.load), "a": radius, "b": radius}


def two_of_kalker(solved: ContactSolution) -> dict[str, float]:
    """Return the force of two bumps far apart where nothing slips: each bears half of the load."""
    patch = hertz_bump(solved.problem)
    F_x, _, _ = _sticking(solved.problem, patch, friction_specification(solved))
    return {"F_x": 2 * F_x, "p_max": patch.p_max}


def friction_specification(solved: ContactSolution) -> FrictionSpecification:
    """Return the specification of friction and motion of a contact."""
    asked = solved.problem.specification.friction
    assert asked is not None
    return asked


KALKER, SLIDING, CARTER = Truth("Kalker", kalker), Truth("Coulomb", sliding), Truth("Carter", carter)
TURNING, TWO_OF_KALKER = Truth("turning circle", turning), Truth("two of Kalker", two_of_kalker)
NO_FRICTION, FULL_STICK = Truth("no friction", without_friction), Truth("full stick", full_stick)


# --- solutions ------------------------------------------------------------------------------------------


Solution = tuple[Measured, Numbers, Callable[[PairWithFriction], Numbers]]
"""The numbers of a contact, their estimates, and what solves the same contact on another grid."""


def with_friction(
    quantities: Mapping[str, Quantity],
) -> Callable[[Callable[[PairWithFriction, FrictionalProblem], Solution]], Solver]:
    """Make what solves a pair with its only ICs and friction solve a problem."""

    def decorate(find: Callable[[PairWithFriction, FrictionalProblem], Solution]) -> Solver:
        def solve(pair: PairWithFriction) -> ContactSolution:
            known, estimates, numbers = find(pair, _frictional(pair))
            return ContactSolution(
                pair.problem,
                pair.on_grid,
                known.numbers,
                estimates,
                error_scales(known, quantities),
                lambda grid: numbers(replace(pair, on_grid=replace(pair.on_grid, grid=grid))),
                pair.options,
            )

        return wraps(find)(lambda problem, options: solve_with_friction(problem, solve, options))

    return decorate


@with_friction(OF_ROLLING)
def roll(pair: PairWithFriction, contact: FrictionalProblem) -> Solution:
    """Solve steady rolling at the last creepage."""
    known = _roll_steadily(pair, contact)
    larger = on_larger_elements(
        pair, contact, pair.problem.name, lambda pair, problem, *_: _roll_steadily(pair, problem)
    )
    return known, errors(kinds(OF_ROLLING), known, larger), _steady_numbers


@with_friction(OF_ROLLING)
def roll_from_rest(pair: PairWithFriction, contact: FrictionalProblem) -> Solution:
    """Solve rolling from rest, and return the numbers at its end; on other grids those of steady rolling."""
    path = solve_path(pair, contact, pair.problem.name)
    estimates, _ = estimate_path(pair, contact, pair.problem.name, path)
    steady = replace(pair.specification, longitudinal=(-1.0, pair.specification.creepage))
    return path.steps[-1], estimates[-1], lambda other: _steady_numbers(_with(other, friction=steady))


@with_friction(OF_COMPRESSION)
def compress(pair: PairWithFriction, contact: FrictionalProblem) -> Solution:
    """Solve a compression, and return the numbers under the last load.

    On other grids the steps of the load are half as large.
    """

    def numbers(pair: PairWithFriction) -> Numbers:
        slower = _with(pair, loads=tuple(in_halves(pair.loads)))
        return solve_steps(slower, _frictional(slower), "finer")[0][-1].numbers

    steps, _ = solve_steps(pair, contact, pair.problem.name)
    return steps[-1], estimate_steps(pair, contact, pair.problem.name, steps)[-1], numbers


def _roll_steadily(pair: PairWithFriction, problem: FrictionalProblem) -> Measured:
    """Return the numbers of steady rolling; raises Failure."""
    asked = pair.specification
    creepages = Creepages(asked.longitudinal[-1], asked.lateral, asked.spin)
    rolling = pair.rolling(problem)
    return measured_rolling(pair.on_grid, rolling, rolling.contact(creepages, Loading(pair.loads[0])))


def _steady_numbers(pair: PairWithFriction) -> Numbers:
    return _roll_steadily(pair, _frictional(pair)).numbers


def _frictional(pair: PairWithFriction) -> FrictionalProblem:
    """Return the problem with the only coefficient of friction and the only ICs."""
    (friction,), (name,) = pair.specification.coefficients, pair.problem.specification.ics
    return pair.frictional(pair.operator(name), friction)


def _with(pair: PairWithFriction, **changes: Any) -> PairWithFriction:
    """Return the pair with changes of its specification."""
    specification = replace(pair.problem.specification, **changes)
    return replace(pair, problem=replace(pair.problem, specification=specification))
