"""How often estimates of contact results hold: random contacts against elements a few times smaller.

    python benchmarks/contact_estimates.py rolling frictionless "differences in rolling" compression --seed 2

Prints for each number and each regime (one patch or several; sticking, mixed, sliding) how often its error is
within its estimate, the worst ratio of error and estimate, and the median of the opposite ratio, which says
how much too large estimates are. Differences are those with A to those with B-hat on the same
elements. Numbers that are prescribed do not count. The shares in `femic.contact.estimates` were found with
other random contacts than those of any seed here. On arcs and ellipses, unsymmetric and often off the crown,
with 8 to 20 elements across the smallest patch. Statement 25 of `femic validate` is about the first three.
"""

import argparse
import sys
from dataclasses import replace
from itertools import chain, islice
from types import SimpleNamespace

import numpy as np
from tables import Record, arguments, print_table

from compare.validation.statements.random_contacts import (
    FINER,
    ICS,
    STUDIES,
    GridComparison,
    RandomContact,
    Study,
    by_regime,
    comparisons,
    coverage,
    regime,
    without_exact,
)
from femic.contact.estimates import Measured, errors
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.motions.compression import OF_COMPRESSION, in_halves
from femic.contact.motions.compression import sum_estimates as estimates_of_steps
from femic.contact.motions.rolling import OF_CURVE, Continuation
from femic.contact.pairs.quantities import kinds, measured
from femic.contact.rolling import compressed

STEPS = 2  # of load in compressions, each in halves


def curve(case: RandomContact) -> GridComparison:
    """Return creepage without force, slope, creepage at half of friction times load."""

    def solved(contact: RandomContact, problem: FrictionalProblem) -> Measured:
        return continuation(contact, problem).curve().free

    fine, *larger = (solved(case, problem) for problem in case.problems)
    finer = solved(case.finer, case.finer.problem).numbers
    return GridComparison(
        fine.numbers, finer, larger[0].numbers, errors(kinds(OF_CURVE), fine, larger), "curve"
    )


def continuation(case: RandomContact, problem: FrictionalProblem) -> Continuation:
    """Return the continuation along a creep-force curve, with as much of a pair as it reads."""
    size = float(np.hypot(case.creepages.longitudinal, case.creepages.lateral))
    most = 3 * size + 2 * case.friction * case.load / 1e6
    specification = SimpleNamespace(
        longitudinal=(-most, 0.0, most), lateral=case.creepages.lateral / 3, spin=0.0, equal_force=0.5
    )
    pair = SimpleNamespace(
        specification=specification,
        on_grid=case.on_grid,
        loads=[case.load],
        options=SimpleNamespace(watch=SimpleNamespace(on_stage=lambda _: None)),
    )
    return Continuation(pair, case.rolling(problem), "random")


def compression(case: RandomContact) -> GridComparison:
    """Press the bodies on each other in steps; the reference has four times as many of these, too."""
    regimes = list[str]()

    def steps(random: RandomContact, problem: FrictionalProblem, loads: list[float]) -> list[Measured]:
        contacts = list(compressed(problem, [Loading(load) for load in loads]))
        regimes.append(regime(contacts[-1]))
        return [measured(random.on_grid, contact, OF_COMPRESSION) for contact in contacts]

    loads = [case.load * (number + 1) / STEPS for number in range(STEPS)]
    halves, quarters = in_halves(loads), in_halves(in_halves(in_halves(loads)))
    fine, *larger = (steps(case, problem, halves)[1::2] for problem in case.problems)
    once = steps(case, case.problem, loads)
    finer = steps(case.finer, case.finer.problem, quarters)[-1].numbers
    estimates = without_exact(estimates_of_steps(fine, larger, once)[-1], fine[-1])
    return GridComparison(fine[-1].numbers, finer, larger[0][-1].numbers, estimates, regimes[0])


ALL = {**STUDIES, "curve": curve, "compression": compression}


def print_coverage(study: str, contacts: list[GridComparison]) -> None:
    """Print the coverage of all numbers: share held, worst error over estimate, median of the opposite."""
    regimes = dict(sorted(by_regime(contacts).items())) | {"all": contacts}
    heads = [f"{name}, {len(those)}: held" for name, those in regimes.items()]
    rows = []
    for name in contacts[0].numbers:
        shares = [coverage(those, name) for those in regimes.values()]
        if np.isfinite(shares[-1].median):  # others are prescribed
            cells = ((f"{share.held:.0%}", f"{share.worst:.1f}", f"{share.median:.1f}") for share in shares)
            rows.append([name, *chain(*cells)])
    record = Record(
        f"contact_estimates.{study}",
        f"Estimates of contacts: {study}",
        "Share of random contacts whose error is within its estimate, largest error over its estimate, "
        "median of the estimate over its error.",
        f"python benchmarks/contact_estimates.py {' '.join(sys.argv[1:])}",
    )
    print_table([study, *chain(*((head, "worst", "median") for head in heads))], rows, record=record)


def main() -> None:
    """Print the tables of studies."""
    arguments()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("studies", nargs="+", choices=list(ALL))
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument(
        "--finer", type=int, default=FINER, help="by which elements of the reference are smaller"
    )
    parser.add_argument("--ics", nargs="+", default=ICS)
    options = parser.parse_args()
    for study in options.studies:
        solve, times = ALL[study], options.finer

        def against(case: RandomContact, solve: Study = solve, times: int = times) -> GridComparison:
            return solve(replace(case, times=times))

        contacts = islice(comparisons(against, options.seed, options.ics), options.count)
        print_coverage(study, list(contacts))


if __name__ == "__main__":
    main()
