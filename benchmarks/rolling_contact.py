"""Benchmark of steady rolling: seconds and errors (docs/evidence/performance.md).

    python benchmarks/rolling_contact.py [--record]

The case of published timings: a Hertz ellipse, a = 5, b = 4 mm, F_n = 80 kN, friction 0.3, G = 82 000 MPa,
nu = 0.28 for both bodies, rigid slip 8e-4, 4e-4, spin 2e-4 / mm. Seconds of pressures and tractions together,
to 1e-5 of the largest pressure, on one thread; the operator of C (dense between strips) is filled with A: its
cost does not depend on the values. Then errors of forces against seconds, first and second order. Then a ball
in a groove that hardly differs from it, and a creep-force curve: all tractions at once beside pressures and
tangential tractions in turns. At last how many of 200 random contacts are found, and how many of these need a
shorter leading edge of second order.
"""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from time import perf_counter

import numpy as np
from tables import Record, arguments, print_table
from threadpoolctl import threadpool_limits

from approx.pair import Pair, Solid, matrix
from compare.validation.statements.random_contacts import RandomContact, random_contact
from femic.contact import coupled, small
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.friction.motion import Creepages, RollingKinematics
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.motions import solve_with_friction
from femic.contact.motions.rolling import Continuation
from femic.contact.operators.approximations import approximate_operator, half_space_operator
from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.rolling import RollingContact, RollingProblem
from femic.contact.undeformed import Undeformed
from femic.scenes.load import load_scene
from geometries.contours import arc, plane
from geometries.errors import Failure
from geometries.materials import Material
from geometries.patches import Grid
from geometries.surfaces import LOWER, UPPER, Surface

G, NU, FRICTION, LOAD = 82e3, 0.28, 0.3, 80e3
STEEL = Material(2 * G * (1 + NU), NU)
PAIR = Pair(Solid(STEEL, Surface(UPPER, plane())), Solid(STEEL, Surface(LOWER, plane())))
HALF_X, HALF_S = 5.0, 4.0  # of the patch [mm]
CREEPAGES = Creepages(-8e-4, 4e-4, 2e-4)
ACROSS = ((50, 40), (100, 80), (200, 160))
STEP, ROOM = 16, 8  # elements: of numbers on a grid; beside the patch
TOLERANCE = 1e-5
REPEATED = 3
RANDOM, SEED = 200, 4  # contacts drawn


def curvatures() -> tuple[float, float]:
    """Return relative curvatures of the surfaces whose patch has these half-lengths."""
    modulus = combined_modulus(STEEL, STEEL)
    along_x = along_s = 0.01
    for _ in range(200):
        patch = PointContact(along_x, along_s, modulus).at_load(LOAD)
        along_x, along_s = along_x * (patch.a / HALF_X) ** 1.5, along_s * (patch.b / HALF_S) ** 1.5
    return along_x, along_s


def problem(across: tuple[int, int], order: int, name: str = "A") -> RollingProblem:
    n_x, n_s = (STEP * int(np.ceil((n + ROOM) / STEP)) for n in across)
    grid = Grid(n_x, n_s, 2 * HALF_X / across[0], 2 * HALF_S / across[1])
    x = grid.dx * (np.arange(n_x) - (n_x - 1) / 2)
    of_x, of_s = CURVATURES
    distance = (of_x * x[:, None] ** 2 + of_s * grid.strips**2) / 2
    flat = half_space_operator(PAIR, grid)
    operator = GridOperator.from_ics(matrix("A", PAIR, grid)) if name == "C" else flat
    contact = FrictionalProblem(grid, operator, flat, distance, np.zeros(n_s), FRICTION)
    return RollingProblem(contact, RollingKinematics(plane(), np.inf, x, grid.strips, np.zeros(n_s)), order)


def solved(rolling: RollingProblem):
    start = perf_counter()
    result = rolling.contact(CREEPAGES, Loading(LOAD), tolerance=TOLERANCE)
    return result.contact, perf_counter() - start


def timing_rows() -> Iterator[list[object]]:
    for across in ACROSS:
        for name, order in (("A", 1), ("A", 2), ("C", 2)):
            rolling = problem(across, order, name)
            runs = [solved(rolling) for _ in range(REPEATED)]
            force = runs[0][0].force / (FRICTION * LOAD)
            seconds = f"{min(run[1] for run in runs):.2f}"
            yield [f"{across[0]} × {across[1]}", name, order, seconds, f"{force[0]:.5f}", f"{force[1]:.5f}"]


def errors() -> None:
    """Print errors against forces extrapolated from the two finest grids of the second order."""
    sizes = [(n, n * 4 // 5) for n in (15, 25, 50, 100, 200)]
    result = {(order, n): solved(problem(n, order)) for order in (1, 2) for n in sizes}
    force = {key: contact.force[:2] / (FRICTION * LOAD) for key, (contact, _) in result.items()}
    limit = force[2, sizes[-1]] + (force[2, sizes[-1]] - force[2, sizes[-2]]) / 3
    print(f"\nforces over friction times load: {limit[0]:.5f}, {limit[1]:.5f}")
    rows = []
    for n in sizes:
        error = {order: np.linalg.norm(force[order, n] - limit) / np.linalg.norm(limit) for order in (1, 2)}
        cells = [(f"{error[order]:.1e}", f"{result[order, n][1]:.2f}") for order in (1, 2)]
        rows.append([f"{n[0]} × {n[1]}", *cells[0], *cells[1]])
    head = ["elements in the patch", "first order: error", "first order [s]", "second order: error"]
    print_table([*head, "second order [s]"], rows, record=OF_ERRORS)


def ball_in_groove() -> RollingProblem:
    """A ball of 10 mm in a groove of 10.02 mm with B-bar on 96 x 96 elements, friction 0.3."""
    ball, groove = Surface(UPPER, arc(-10.0, 1.45, 1.45), 10.0), Surface(LOWER, arc(-10.02, 1.45, 1.45))
    pair, grid = Pair(Solid(STEEL, ball), Solid(STEEL, groove)), Grid(96, 96, 1.1 / 96, 14.5 / 96)
    x = grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2)
    undeformed = Undeformed(ball, groove, (-14.5, 14.5), 0.0)
    contact = FrictionalProblem(
        grid,
        approximate_operator("Bbar", pair, grid),
        half_space_operator(PAIR, grid),
        undeformed.distance(x[:, None], grid.strips),
        groove.contour.inclination(grid.strips),
        FRICTION,
    )
    height = undeformed.upper_height(grid.strips)
    return RollingProblem(contact, RollingKinematics(groove.contour, 10.0, x, grid.strips, height))


@contextmanager
def in_turns() -> Iterator[None]:
    """Contacts are solved in turns only, small ones, too."""
    solve, most = coupled.solve, small.MOST_ELEMENTS
    coupled.solve, small.MOST_ELEMENTS = lambda *_: None, 0
    try:
        yield
    finally:
        coupled.solve, small.MOST_ELEMENTS = solve, most


def ball_rows() -> Iterator[list[object]]:
    for creepages in (Creepages(-2e-4, 1e-4), Creepages(0, 3e-4, 2e-3), Creepages(-1e-3, 5e-4)):
        each = []
        for way in (in_turns, nullcontext):
            with way():
                seconds = []
                for _ in range(REPEATED):
                    rolling, start = ball_in_groove(), perf_counter()
                    contact = rolling.contact(creepages, Loading(1000.0)).contact
                    seconds.append(perf_counter() - start)
            each.append((min(seconds), contact))
        (turns, there), (at_once, here) = each
        difference = np.max(np.abs(here.p - there.p)) / np.max(there.pressures)
        cells = f"{turns:.2f}", f"{at_once:.2f}", f"{turns / at_once:.1f}", f"{difference:.0e}"
        yield [f"{creepages.longitudinal:g}, {creepages.lateral:g}, {creepages.spin:g}", *cells]


def curve_rows() -> Iterator[list[object]]:
    """The curve of scene `rolling`, 19 creepages and four forces on 64 x 64 elements, friction 0.4."""
    rows: list[list[object]] = []

    def solve(pair: PairWithFriction) -> None:
        for name in ("A", "Bhat"):
            seconds = []
            for way in (in_turns, nullcontext):
                start = perf_counter()
                with way():
                    problem = pair.frictional(pair.operator(name), 0.4)
                    Continuation(pair, pair.rolling(problem), name).curve()
                seconds.append(perf_counter() - start)
            turns, at_once = seconds
            rows.append([name, f"{turns:.1f}", f"{at_once:.1f}", f"{turns / at_once:.1f}"])

    solve_with_friction(load_scene("rolling").contact_problem, solve)
    yield from rows


def edge_rows() -> Iterator[list[object]]:
    """Random contacts on their grids, and on elements four times smaller: solved, with a shorter edge."""
    drawn = [random_contact(SEED, number) for number in range(RANDOM)]
    for name, cases in (("8 to 20", drawn), ("32 to 80", [case.finer for case in drawn])):
        solved = [rolled for case in cases if (rolled := _rolled(case)) is not None]
        yield [name, len(cases), len(solved), sum(rolled.simplified for rolled in solved)]


def _rolled(case: RandomContact) -> RollingContact | None:
    """Return a random contact in steady rolling; None where it is not found."""
    forces = {"longitudinal": 0.0} if case.free else {}
    try:
        return case.rolling(case.problem).contact(case.creepages, Loading(case.load), forces=forces)
    except Failure:
        return None


CURVATURES = curvatures()
TIMINGS = ("elements in the patch", "ICs", "order", "time [s]", "F_x / (friction N)", "F_y / (friction N)")


def _record(table: str, title: str, shows: str) -> Record:
    return Record(f"rolling_contact.{table}", title, shows, "python benchmarks/rolling_contact.py")


OF_TIMINGS = _record(
    "timings",
    "Steady rolling: seconds",
    "A Hertz ellipse of half-lengths 5 and 4 mm, 80 kN, friction 0.3, creepages −8e-4 and 4e-4, spin "
    "2e-4 /mm, pressures and tractions to 1e-5, on one thread.",
)
OF_ERRORS = _record(
    "errors",
    "Steady rolling: error against seconds",
    "A Hertz ellipse of half-lengths 5 and 4 mm, 80 kN, friction 0.3, creepages −8e-4 and 4e-4, spin "
    "2e-4 /mm, with A, on one thread. The error is the distance of (F_x, F_y) from its limit for small "
    "elements, over that limit.",
)
OF_BALL = _record(
    "ball",
    "A ball in a groove of nearly its radius",
    "Ball of 10 mm, groove of 10.02 mm, 1 kN, friction 0.3, B̄ on 96 × 96 elements, one thread. "
    "Pressures and tractions at once, and in turns.",
)
OF_CURVE = _record(
    "curve",
    "Creep-force curve",
    "Scene `rolling`, 19 creepages and four forces on 64 × 64 elements, one thread.",
)
OF_RANDOM = _record(
    "random",
    "Random contacts",
    "Steady rolling of contacts drawn at random: how many are solved, and how many of these need a shorter "
    "leading edge of second order.",
)

if __name__ == "__main__":
    arguments()
    with threadpool_limits(1):
        print_table(TIMINGS, timing_rows(), record=OF_TIMINGS)
        errors()
        head = ("creepages", "in turns [s]", "at once [s]", "ratio", "tractions differ by")
        print_table(head, ball_rows(), record=OF_BALL)
        print_table(("ICs", "in turns [s]", "at once [s]", "ratio"), curve_rows(), record=OF_CURVE)
        head = ("elements across the patch", "contacts", "found", "with a shorter edge")
        print_table(head, edge_rows(), record=OF_RANDOM)
