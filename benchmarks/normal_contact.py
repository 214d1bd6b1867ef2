"""Benchmark of frictionless contact: seconds (docs/evidence/performance.md, other-programs.md).

    python benchmarks/normal_contact.py [--record]

A wheel on a rail, arcs of 10.5 and 10 mm, a patch of about n_x by n_s elements: seconds to make the operator
and to find the pressures. The operator of C (dense between strips) is filled with B-hat:
its cost does not depend on the values. Where the package tamaas is installed, a Hertz problem on the same
number of elements by both: half-spaces, pressures to 1e-7.
"""

from importlib.util import find_spec
from time import perf_counter

import numpy as np
from tables import Record, arguments, print_table

from approx.pair import Pair, Solid, matrix
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.normal import NormalProblem, solve
from femic.contact.operators.approximations import approximate_operator, half_space_operator
from femic.contact.operators.dense import GridOperator
from femic.contact.undeformed import Undeformed
from geometries.contours import arc, plane
from geometries.materials import Material
from geometries.patches import Grid, N
from geometries.surfaces import LOWER, UPPER, Surface

STEEL = Material(210e3, 0.3)
FLANKS = np.radians([60.0, 60.0])
WHEEL, RAIL = Surface(UPPER, arc(10.5, *FLANKS), 500.0), Surface(LOWER, arc(10.0, *FLANKS))
PAIR = Pair(Solid(STEEL, WHEEL), Solid(STEEL, RAIL))
PATCHES = ((50, 40), (100, 80), (200, 160))  # elements across the patch
LOAD, HALF_LENGTH, HALF_WIDTH = 20e3, 4.5, 2.6  # N; of the patch by B-hat [mm]
ROOM = 1.28  # length of the grid over that of the patch
REPEATED = 3
ICS = ("A", "B", "Bhat", "C")
OF_FEMIC = Record(
    "normal_contact.femic",
    "Frictionless contact",
    "A wheel on a rail, arcs of 10.5 and 10 mm: seconds to make the operator plus seconds to find the "
    "pressures to 1e-7 of the largest. The operator of C is dense between strips and filled with B̂; C "
    "itself comes on top.",
    "python benchmarks/normal_contact.py",
)
OF_TAMAAS = Record(
    "normal_contact.tamaas",
    "Tamaas: frictionless contact of half-spaces",
    "A circular contact against Hertz, no period, pressures to 1e-7, one process each.",
    "python benchmarks/normal_contact.py",
)


def operator(name: str, grid: Grid):
    if name == "C":
        return GridOperator.from_ics(np.ascontiguousarray(matrix("Bhat", PAIR, grid)[..., 2:, 2:]), (N,))
    return approximate_operator(name, PAIR, grid, (N,))


def figure_grid(n_x: int, n_s: int) -> Grid:
    on_grid = (4 * int(np.ceil(ROOM * n / 4)) for n in (n_x, n_s))
    return Grid(*on_grid, 2 * HALF_LENGTH / n_x, 2 * HALF_WIDTH / n_s)


def femic_row(n_x: int, n_s: int) -> list[str]:
    """Return the seconds of all ICs on a grid: of the operator, and of the pressures."""
    found = [solved(name, n_x, n_s) for name in ICS]
    return [found[0][0], *(seconds for _, seconds in found)]


def solved(name: str, n_x: int, n_s: int) -> tuple[str, str]:
    """Return the elements in contact and the seconds of one kind of ICs."""
    grid = figure_grid(n_x, n_s)
    x = grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2)
    distance = Undeformed(WHEEL, RAIL, (-10.0, 10.0)).distance(x[:, None], grid.strips)
    cosine = np.cos(RAIL.contour.inclination(grid.strips))
    start = perf_counter()
    made = operator(name, grid)
    set_up = perf_counter() - start
    seconds = []
    for _ in range(REPEATED):
        problem = NormalProblem(grid, made, half_space_operator(PAIR, grid, (N,)), distance, cosine)
        start = perf_counter()
        result = solve(problem, load=LOAD)
        seconds.append(perf_counter() - start)
    along_x, along_s = (int(np.ptp(np.flatnonzero(result.in_contact.any(axis=k)))) + 1 for k in (1, 0))
    return f"{along_x} × {along_s}", f"{set_up:.3f} + {min(seconds):.3f}"


def tamaas_row(n: int) -> list[str]:
    """Solve a circular Hertz contact on n by n elements, with a grid as long as 2.5 radii."""
    import tamaas  # noqa: PLC0415 (where it is installed)

    radius, load = 20.0, 1000.0
    modulus = combined_modulus(STEEL, STEEL)
    hertz = PointContact(1 / radius, 1 / radius, modulus).at_load(load)
    length = 2.5 * hertz.a
    grid = Grid(n, n, length / n, length / n)
    distance = (grid.strips[:, None] ** 2 + grid.strips**2) / (2 * radius)
    half_spaces = Pair(Solid(STEEL, Surface(UPPER, plane())), Solid(STEEL, Surface(LOWER, plane())))
    start = perf_counter()
    flat = half_space_operator(half_spaces, grid, (N,))
    own = solve(NormalProblem(grid, flat, flat, distance, np.ones(n)), load=load)
    of_femic = perf_counter() - start
    start = perf_counter()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [length, length], [n, n])
    model.E, model.nu = modulus, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tamaas.PolonskyKeerRey(model, -distance, 1e-7)
    solver.setIntegralOperator("dcfft")
    solver.solve(load / length**2)
    of_tamaas = perf_counter() - start
    error, error_of_tamaas = own.p.max() / hertz.p_max - 1, np.max(model.traction) / hertz.p_max - 1
    return [
        f"{n} × {n}",
        f"{of_femic:.3f}",
        f"{error:+.1e}",
        f"{of_tamaas:.3f}",
        f"{error_of_tamaas:+.1e}",
    ]


if __name__ == "__main__":
    arguments()
    head = ("elements in contact", *(f"{name} [s]" for name in ICS))
    print_table(head, (femic_row(*size) for size in PATCHES), record=OF_FEMIC)
    if find_spec("tamaas"):
        head = (
            "grid",
            "femic [s]",
            "femic: p_max over Hertz's − 1",
            "Tamaas [s]",
            "Tamaas: p_max over Hertz's − 1",
        )
        print_table(head, map(tamaas_row, (64, 128, 256)), record=OF_TAMAAS)
    else:
        print("\nTamaas is not installed: no comparison")
