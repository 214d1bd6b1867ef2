"""Contacts with friction that are compared at limits: steady rolling, rolling from rest, compression."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from femic.contact.estimates import Measured, Numbers, errors
from femic.contact.friction.kinematics import Creepages
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.pairs.pair_with_friction import PairWithFriction, solve_with_friction
from femic.contact.pairs.quantities import OF_COMPRESSION, OF_ROLLING, Quantity, kinds
from femic.contact.pairs.rolling_numbers import measured_rolling
from femic.contact.pairs.solved_compression import in_halves, in_steps, solve_compression
from femic.contact.pairs.solved_transient import solve_transient
from femic.contact.pairs.variations import on_larger_elements
from femic.contact.specification import ContactProblem
from femic.reference.run_options import RunOptions
from femic.validation.extremes.contacts import Solved, scales_of
from geometries.grids import Grid


def rolled(problem: ContactProblem, options: RunOptions) -> Solved:
    """Solve steady rolling at the last creepage of a problem, with its only ICs and friction."""
    return solve_with_friction(problem, _rolled_on, options)


def _rolled_on(pair: PairWithFriction) -> Solved:
    fine = _frictional(pair)
    known = _rolled(pair, fine)
    larger = on_larger_elements(pair, fine, pair.problem.name, lambda *of: _rolled(*of[:2]))
    estimates = errors(kinds(OF_ROLLING), known, larger)

    def on(grid: Grid) -> Numbers:
        other = _on(pair, grid)
        return _rolled(other, _frictional(other)).numbers

    return _solved(pair, known, estimates, OF_ROLLING, on)


def _rolled(pair: PairWithFriction, problem: FrictionalProblem) -> Measured:
    """Return the numbers of steady rolling; raises Failure."""
    asked = pair.specification
    creepages = Creepages(asked.longitudinal[-1], asked.lateral, asked.spin)
    rolling = pair.rolling(problem)
    return measured_rolling(pair.on_grid, rolling, rolling.contact(creepages, Loading(pair.loads[0])))


def transient(problem: ContactProblem, options: RunOptions) -> Solved:
    """Solve rolling from rest, and return the numbers at its end; on other grids those of steady rolling."""
    return solve_with_friction(problem, _transient_on, options)


def _transient_on(pair: PairWithFriction) -> Solved:
    solved = solve_transient(pair, *_only(pair))
    asked = pair.specification
    steady = replace(asked, longitudinal=(-1.0, asked.creepage))

    def on(grid: Grid) -> Numbers:
        other = _on(_with(pair, friction=steady), grid)
        return _rolled(other, _frictional(other)).numbers

    return _solved(pair, solved.path.steps[-1], solved.errors[-1], OF_ROLLING, on)


def pressed(problem: ContactProblem, options: RunOptions) -> Solved:
    """Solve a compression, and return the numbers under the last load.

    On other grids the steps of the load are half as large.
    """
    return solve_with_friction(problem, _pressed_on, options)


def _pressed_on(pair: PairWithFriction) -> Solved:
    solved = solve_compression(pair, *_only(pair))

    def on(grid: Grid) -> Numbers:
        other = _on(_with(pair, loads=tuple(in_halves(pair.loads))), grid)
        return in_steps(other, _frictional(other), "finer")[0][-1].numbers

    return _solved(pair, solved.steps[-1], solved.errors[-1], OF_COMPRESSION, on)


def _solved(
    pair: PairWithFriction,
    known: Measured,
    estimates: Numbers,
    quantities: Mapping[str, Quantity],
    on: Callable[[Grid], Numbers],
) -> Solved:
    return Solved(pair.problem, pair.on_grid, known.numbers, estimates, scales_of(known, quantities), on)


def _only(pair: PairWithFriction) -> tuple[float, str]:
    """Return the only coefficient of friction and the name of the only ICs."""
    (friction,), (name,) = pair.specification.coefficients, pair.problem.specification.ics
    return friction, name


def _frictional(pair: PairWithFriction) -> FrictionalProblem:
    friction, name = _only(pair)
    return pair.frictional(pair.operator(name), friction)


def _with(pair: PairWithFriction, **changes: Any) -> PairWithFriction:
    """Return the pair with changes of its specification."""
    specification = replace(pair.problem.specification, **changes)
    return replace(pair, problem=replace(pair.problem, specification=specification))


def _on(pair: PairWithFriction, grid: Grid) -> PairWithFriction:
    return replace(pair, on_grid=replace(pair.on_grid, grid=grid))
