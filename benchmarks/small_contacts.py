"""Benchmark of small contacts: compiled loops and other solvers (docs/evidence/performance.md).

    python benchmarks/small_contacts.py [--record]

The ellipse of `rolling_contact`, on small grids, to 1e-5, on one thread, milliseconds of the processor: cold,
warm from the contact at creepages that are 5 % different, and by the solvers for any grid. Beside them the
published test of speed of CONTACT, on its own machine. Then many contacts of `femic.ContactSolver`: a loop
over creepages, and one of wear.
"""

from collections.abc import Callable, Iterator
from time import perf_counter, process_time

import numpy as np
import rolling_contact
from rolling_contact import CREEPAGES, LOAD, TOLERANCE
from tables import Record, arguments, print_table
from threadpoolctl import threadpool_limits

import femic
from femic.contact import normal, small
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading

ACROSS = ((12, 10), (25, 20), (50, 40))
PUBLISHED = {
    (12, 10): "1.9 (11 × 11)",
    (25, 20): "11 to 28 (25 × 25)",
    (50, 40): "–",
}  # CONTACT, own test [ms]
NEAR = Creepages(1.05 * CREEPAGES.longitudinal, 0.95 * CREEPAGES.lateral, CREEPAGES.spin)
REPEATED, LOOPS, MANY, WEAR_STEPS, WORN = 25, 5, 200, 100, 1e-6
MADE_BY = "python benchmarks/small_contacts.py"


def milliseconds(solve: Callable[[], object]) -> float:
    """Return the least milliseconds of the processor, without the first solution, which may compile."""
    solve()
    each = []
    for _ in range(REPEATED):
        start = process_time()
        solve()
        each.append(process_time() - start)
    return 1e3 * min(each)


def by_others(solve: Callable[[], object]) -> float:
    """Return the milliseconds of the solvers for any grid."""
    most, small.MOST_ELEMENTS = small.MOST_ELEMENTS, 0
    try:
        return milliseconds(solve)
    finally:
        small.MOST_ELEMENTS = most


def timing_rows() -> Iterator[list[object]]:
    rolling_contact.STEP = 2  # grids that fit
    for across in ACROSS:
        for order in (1, 2):
            rolling = rolling_contact.problem(across, order)

            def cold(rolling=rolling):
                return rolling.contact(CREEPAGES, Loading(LOAD), tolerance=TOLERANCE).contact

            start = cold()

            def warm(rolling=rolling, start=start):
                return rolling.contact(NEAR, Loading(LOAD), start=start, tolerance=TOLERANCE)

            times = milliseconds(cold), milliseconds(warm), by_others(cold)
            cells = [f"{time:.1f}" for time in times]
            yield [
                f"{across[0]} × {across[1]}",
                order,
                *cells,
                f"{times[2] / times[0]:.0f}",
                PUBLISHED[across],
            ]


def frictionless_rows() -> Iterator[list[object]]:
    for across in ((12, 10), (24, 24), (50, 40)):
        problem = rolling_contact.problem(across, 2).problem.normal

        def solve(problem=problem):
            return normal.solve(problem, load=LOAD)

        times = milliseconds(solve), by_others(solve)
        cells = [f"{time:.2f}" for time in times]
        yield [f"{across[0]} × {across[1]}", *cells, f"{times[1] / times[0]:.0f}"]


def most_per_second(contacts: int, solve: Callable[[], object]) -> str:
    """Return the most contacts per second of some loops over them."""
    each = []
    for _ in range(LOOPS):
        start = perf_counter()
        solve()
        each.append(perf_counter() - start)
    return f"{contacts / min(each):.0f}"


def many_rows() -> Iterator[list[object]]:
    pair = femic.load_pair("rolling")
    for name in ("A", "Bhat"):
        grid = femic.Grid(24, 24, 29.0 / 24, 40.0 / 24)
        solver = femic.ContactSolver(pair, 100e3, name, femic.ContactSetup(grid=grid))
        solver.solve(100e3, friction=0.3)

        def creep(solver=solver):
            creepages = np.linspace(-4e-3, 4e-3, MANY)
            solver.solve_many(load=100e3, friction=0.3, longitudinal=creepages, spin=1e-4)

        def wear(solver=solver, grid=grid):
            worn = np.zeros(grid.n_s)
            for _ in range(WEAR_STEPS):
                contact = solver.solve(100e3, friction=0.3, longitudinal=-2e-3, spin=1e-4, extra_gap=worn)
                worn += WORN * contact.work_density.mean(axis=0)

        yield ["creepages", name, MANY, most_per_second(MANY, creep)]
        yield ["steps of wear", name, WEAR_STEPS, most_per_second(WEAR_STEPS, wear)]


OF_TIMINGS = Record(
    "small_contacts.rolling",
    "Small contacts: steady rolling",
    "A Hertz ellipse of half-lengths 5 and 4 mm, 80 kN, friction 0.3, A, tractions to 1e-5, one thread, "
    "milliseconds of the processor. Warm: from the contact at creepages that are 5 % different.",
    MADE_BY,
)
OF_FRICTIONLESS = Record(
    "small_contacts.frictionless",
    "Small contacts: without friction",
    "The same ellipse, pressures to 1e-7 of the largest.",
    MADE_BY,
)
OF_MANY = Record(
    "small_contacts.many",
    "Many contacts",
    "`femic.ContactSolver` with the pair of `rolling`, 100 kN, friction 0.3, 24 × 24 elements, one thread: "
    "creepages from −0.4 to 0.4 %, and a loop of wear; the fastest of five loops.",
    MADE_BY,
)

if __name__ == "__main__":
    arguments()
    with threadpool_limits(1):
        head = (
            "elements in the patch",
            "order",
            "cold [ms]",
            "warm [ms]",
            "other solvers, cold [ms]",
            "ratio",
        )
        print_table((*head, "CONTACT, published [ms]"), timing_rows(), record=OF_TIMINGS)
        head = ("elements in the patch", "time [ms]", "other solvers [ms]", "ratio")
        print_table(head, frictionless_rows(), record=OF_FRICTIONLESS)
        print_table(("loop", "ICs", "contacts", "contacts per second"), many_rows(), record=OF_MANY)
