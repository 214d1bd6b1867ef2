"""Compression with some ICs in steps of load, with the estimates of its numbers.

The load grows in steps half as large as between the loads that are given: errors are of the first order in
them, and estimated from steps that are twice as large. Where compressions are compared, elements and steps
are made larger together: both errors are of the first order, and so is their sum.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

from femic.contact.estimates import SAFETY, Measured, Numbers, changes, errors
from femic.contact.frictional import FrictionalContact
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.creep_force import Linearisation
from femic.contact.pairs.pair_with_friction import (
    Change,
    PairWithFriction,
    change_of_tractions,
    differences,
    if_possible,
    on_larger_elements,
    with_perturbed_ics,
)
from femic.contact.pairs.quantities import OF_COMPRESSION, kinds, measured
from femic.contact.rolling import compressed
from geometries.errors import Failure

Steps = Sequence[Measured]  # after each load


@dataclass(frozen=True, eq=False)
class SolvedCompression:
    """Numbers after each load with their estimated errors, and the contact after the last one.

    `larger` are both with elements and steps of load twice as large, None where these have no solution.
    """

    steps: Steps
    errors: Sequence[Numbers]
    last: FrictionalContact
    larger: tuple[Steps, FrictionalContact] | None
    change: Change
    seconds: float  # without C


def solve_compression(pair: PairWithFriction, friction: float, name: str) -> SolvedCompression:
    """Return the compression with the ICs of a name at a coefficient of friction; raises Failure."""
    operator, start = pair.operator(name), perf_counter()  # C has its own seconds
    label, problem = f"friction {friction:g}, {name}", pair.frictional(operator, friction)
    steps, last = in_steps(pair, problem, label)
    seconds = perf_counter() - start
    pair.options.watch.on_stage(f"  {label}: {len(steps)} loads, {seconds:.1f} s")
    perturbed = with_perturbed_ics(pair, friction, name, label, in_steps)
    estimated = estimates_of(
        steps,
        on_larger_elements(pair, problem, label, lambda *coarse: in_steps(*coarse)[0]),
        in_steps(pair, problem, f"{label}, larger steps", halves=False)[0],
        None if perturbed is None else perturbed[0],
        [Linearisation.measure(pair.on_grid, operator, load) for load in pair.loads],
    )
    larger = _with_larger_elements_and_steps(pair, problem, label)
    return SolvedCompression(steps, estimated, last, larger, _change(steps, last, perturbed), seconds)


def _with_larger_elements_and_steps(
    pair: PairWithFriction, problem: FrictionalProblem, label: str
) -> tuple[Steps, FrictionalContact] | None:
    """Return numbers and last contact with elements and steps twice as large; None for no solution."""
    if not problem.has_coarser:
        return None
    label = f"{label}, larger elements and steps"
    return if_possible(
        pair, "not in estimates", lambda: in_steps(pair, problem.coarsened, label, halves=False)
    )


def _change(
    steps: Steps, last: FrictionalContact, perturbed: tuple[Steps, FrictionalContact] | None
) -> Change:
    """Return the change of numbers and tractions by the estimated errors of the ICs."""
    changed_steps, changed_last = perturbed or (steps, last)
    pairs = zip(steps, changed_steps, strict=True)
    return Change(
        [differences(step.numbers, changed.numbers) for step, changed in pairs],
        change_of_tractions(last, changed_last),
    )


def last_load(pair: PairWithFriction, problem: FrictionalProblem, label: str) -> tuple[float, Numbers]:
    """Return the last load [N] and the numbers after it; raises Failure where there is no such contact."""
    return pair.loads[-1], in_steps(pair, problem, label)[0][-1].numbers


def in_halves(loads: Sequence[float]) -> list[float]:
    """Return loads [N] with one more half way before each of them, from 0 on."""
    before = [0.0, *loads[:-1]]
    return [step for low, load in zip(before, loads, strict=True) for step in ((low + load) / 2, load)]


def in_steps(
    pair: PairWithFriction, problem: FrictionalProblem, label: str, *, halves: bool = True
) -> tuple[Steps, FrictionalContact]:
    """Return the numbers after each load, and the last contact; in steps from load to load, or in halves."""
    loads, steps = in_halves(pair.loads) if halves else list(pair.loads), list[Measured]()
    try:
        for contact in compressed(problem, [Loading(load) for load in loads]):
            steps.append(measured(pair.on_grid, contact, OF_COMPRESSION))
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        raise Failure(f"{label}, {loads[len(steps)]:g} N: {failure}") from failure
    return steps[1::2] if halves else steps, contact


def estimates_of(
    steps: Steps,
    on_larger: Sequence[Steps | None],
    larger_steps: Steps,
    perturbed: Steps | None = None,
    linearised: Sequence[Linearisation] = (),
) -> list[dict[str, float]]:
    """Return sums of what larger elements, steps of load, C plus its estimate, and other distances change.

    Steps twice as large have twice the error, with the safety factor of elements.
    """
    of_all, estimated = kinds(OF_COMPRESSION), []
    for number, fine in enumerate(steps):
        by_steps = changes(fine, of_all, larger_steps[number].numbers)
        others = [{name: SAFETY * value for name, value in by_steps.items()}]
        if perturbed is not None:
            others.append(changes(fine, of_all, perturbed[number].numbers))
        others += [each.part(fine, of_all) for each in linearised[number : number + 1]]
        larger = [coarse[number] if coarse else None for coarse in on_larger]
        estimated.append(errors(of_all, fine, larger, others))
    return estimated
