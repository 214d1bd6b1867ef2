"""What ICs do to a contact: matrices and operators, errors of ICs, rigid compliances, constants."""

from dataclasses import replace

import numpy as np
import pytest

from approx.pair import Pair, Solid, matrix
from femic.contact.normal import NormalProblem, solve
from femic.contact.operators.dense import GridOperator
from geometries.contours import arc, plane
from geometries.materials import Material
from geometries.patches import Grid, N
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.problems import BRASS, ELLIPSE, STEEL, conformal, half_spaces, hertzian

GROOVE = conformal(Grid(20, 32, 1.2, 0.5, -1.5), shift=0.05)
PRISMATIC = Pair(
    Solid(BRASS, Surface(UPPER, arc(10.1, 1.3, 1.1))), Solid(STEEL, Surface(LOWER, arc(10.0, 1.3, 1.1)))
)
ICS = matrix("Bhat", PRISMATIC, GROOVE.grid)[..., N:, N:]  # of the groove as a dense matrix
TIGHT = 1e-11


def with_ics(ics, problem=GROOVE):
    return replace(problem, operator=GridOperator.from_ics(ics, (N,)))


def test_matrix_of_half_spaces_gives_the_contact_of_a():
    problem = hertzian(ELLIPSE, 36, 26, offset=(0.2, 0.3))
    bodies = Pair(Solid(BRASS, Surface(UPPER, plane())), Solid(STEEL, Surface(LOWER, plane())))
    ics = matrix("A", bodies, problem.grid)[..., N:, N:]
    here, there = solve(problem, load=2000.0), solve(with_ics(ics, problem), load=2000.0)
    np.testing.assert_allclose(there.p, here.p, atol=1e-6 * here.p.max())
    assert there.approach == pytest.approx(here.approach, rel=1e-9)
    assert there.coarser.approach == pytest.approx(here.coarser.approach, rel=1e-9)


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
def test_matrix_of_rotated_ics_gives_the_contact_of_their_operator(variant):
    """Not the coarser one: the factors of operators are averaged."""
    problem = conformal(GROOVE.grid, variant, shift=0.05)
    here = solve(problem, load=2000.0)
    there = solve(with_ics(matrix(variant, PRISMATIC, GROOVE.grid)[..., N:, N:], problem), load=2000.0)
    np.testing.assert_allclose(there.p, here.p, atol=1e-6 * here.p.max())
    assert there.coarser.approach == pytest.approx(here.coarser.approach, rel=1e-3)


def damage_of():
    """A symmetric change of the ICs that varies with lag and strips, of 0.1 of them."""
    grid = GROOVE.grid
    s = grid.strips / 10
    wave = np.cos(grid.lags[:, None, None] / 5) * (
        1 + np.sin(3 * s[:, None]) * np.sin(3 * s) + s[:, None] + s
    )
    return 0.1 * ICS * wave[..., None, None]


def dense(ics, elements):
    """The matrix between elements in contact."""
    operator, n = GridOperator.from_ics(ics, (N,)), np.count_nonzero(elements)
    columns = []
    for at in np.argwhere(elements):
        unit = np.zeros((*elements.shape, 1))
        unit[tuple(at)] = 1
        columns.append(operator(unit)[..., 0][elements])
    return np.reshape(columns, (n, n)).T


@pytest.mark.parametrize("given", ["approach", "load"])
def test_perturbed_ics_change_pressures_linearly_to_first_order(given):
    """-S^-1 dS p on the elements in contact, and what keeps the load; the rest falls with the square."""
    whole = solve(with_ics(ICS), load=2000.0, tolerance=TIGHT)
    elements, p = whole.in_contact, whole.p[whole.in_contact]
    c = np.broadcast_to(GROOVE.cosine, elements.shape)[elements]
    S, dS = dense(ICS, elements), dense(damage_of(), elements)
    first_order, of_c = -np.linalg.solve(S, dS @ p), np.linalg.solve(S, c)
    if given == "load":
        first_order -= of_c * (c @ first_order) / (c @ of_c)
    remainders = []
    for share in (0.02, 0.01, 0.005):
        damaged = solve(
            with_ics(ICS + share * damage_of()),
            **{given: getattr(whole, given)},
            start=whole.p,
            tolerance=TIGHT,
        )
        np.testing.assert_array_equal(damaged.in_contact, elements)
        remainders.append(np.max(np.abs(damaged.p[elements] - p - share * first_order)))
    assert remainders[0] < 0.02 * np.max(np.abs(0.02 * first_order))
    assert np.divide(remainders[:-1], remainders[1:]) == pytest.approx([4, 4], rel=0.02)


@pytest.mark.parametrize("m", [1e-7, -1e-7])
def test_rigid_compliance_changes_the_approach_alone(m):
    """M_zz of a discount, m cos(delta_I) cos(delta_J) per unit force: the approach changes by m load."""
    cosine, grid = GROOVE.cosine, GROOVE.grid
    rigid = np.broadcast_to(m * grid.area * np.outer(cosine, cosine), ICS.shape[:3])[..., None, None]
    here, there = (solve(with_ics(ics), load=2000.0, tolerance=1e-10) for ics in (ICS, ICS + rigid))
    assert abs(m * 2000.0) > 0.02 * here.approach
    np.testing.assert_allclose(there.p, here.p, atol=1e-7 * here.p.max())
    assert there.approach - here.approach == pytest.approx(m * 2000.0, rel=1e-6)
    assert 1 / there.stiffness - 1 / here.stiffness == pytest.approx(m, rel=1e-4)
    assert there.energy - here.energy == pytest.approx(m * 2000.0**2 / 2, rel=1e-6)


def test_doubled_stiffness_doubles_pressures_at_an_approach():
    """Pressures over the modulus depend on the approach alone."""
    here = solve(GROOVE, approach=0.005)
    stiff = conformal(
        GROOVE.grid, shift=0.05, materials=[Material(2 * each.E, each.nu) for each in (BRASS, STEEL)]
    )
    np.testing.assert_allclose(solve(stiff, approach=0.005).p, 2 * here.p, atol=1e-6 * here.p.max())


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 10.0, 1e6])
def test_materials_without_coupling_matter_by_their_combined_modulus_only(ratio, variant):
    """nu = 0.5, K = 0 of each body, any ratio of the moduli; but for the different turns of the contours."""
    greater = max(ratio, 1 / ratio)
    softer = Material(100.0 * (1 + 1 / greater), 0.5)
    stiffer = Material(softer.E * greater, 0.5)
    materials = (softer, stiffer) if ratio > 1 else (stiffer, softer)
    for width in (1e-2, 1e-3):
        here, there = (
            solve(conformal(GROOVE.grid, variant, ratio=width, materials=each), approach=0.001 + 0.2 * width)
            for each in ((Material(200.0, 0.5), Material(200.0, 0.5)), materials)
        )
        accuracy = 1e-6 + (0.0 if variant == "A" else 0.1 * width)
        np.testing.assert_allclose(there.p, here.p, atol=accuracy * here.p.max())


@pytest.mark.parametrize("ratio", [1e-6, 1e6])
def test_half_spaces_matter_by_their_combined_modulus_only(ratio):
    problem = hertzian(ELLIPSE, 36, 26)
    materials = Material(90e3, 0.3), Material(90e3 * ratio, 0.1)
    operator = half_spaces(problem.grid, *materials)
    modulus = 1 / sum((1 - each.nu**2) / each.E for each in materials)
    contact = solve(
        NormalProblem(problem.grid, operator, operator, problem.distance, problem.cosine),
        approach=ELLIPSE.approach,
    )
    expected = ELLIPSE.load * modulus / ELLIPSE.surfaces.modulus
    assert contact.load == pytest.approx(expected, rel=2e-3)
