"""Frictionless contact: Hertz, by rates and estimates; load, energy and approach; grooves; ICs; extremes."""

from dataclasses import replace

import numpy as np
import pytest

from approx.pair import Pair, Solid, matrix
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.normal import NormalProblem, PotentialAreaTooSmall, pressures, solve
from femic.contact.operators.dense import GridOperator
from femic.contact.patch import MARGIN
from geometries.contours import arc
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.patches import Grid, N
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.problems import (
    BRASS,
    CIRCLE,
    ELLIPSE,
    GROOVES,
    MODULUS,
    ROLLING_RADIUS,
    ROOM,
    STEEL,
    conformal,
    dense,
    differences,
    elliptic,
    hertz_errors,
    hertzian,
    numbers,
    of_hertz,
    on_half_spaces,
    with_distance,
    x_of,
)

SOLVED = hertzian(ELLIPSE, 36, 26, offset=(0.2, 0.3))
GROOVE = conformal(Grid(20, 32, 1.2, 0.5, -1.5), shift=0.05)
each_hertz = pytest.mark.parametrize("hertz", [CIRCLE, ELLIPSE], ids=["circle", "ellipse"])


def over_offsets(hertz, n):
    """Root mean squares of the relative errors over 8 places of the grid."""
    offsets = np.random.default_rng(0).random((8, 2)) - 0.5
    solved = [solve(hertzian(hertz, n, n * 3 // 4, offset=offset), load=hertz.load) for offset in offsets]
    return np.sqrt(np.mean([hertz_errors(contact, hertz) ** 2 for contact in solved], axis=0))


@each_hertz
def test_approach_energy_and_largest_pressure_converge_to_hertz_with_order_two(hertz):
    """And half-lengths to an eighth of an element: edges are read from gaps, not counted in elements."""
    sizes, errors = np.array([24, 48, 96]), []
    for n in sizes:
        errors.append(over_offsets(hertz, n))
        elements = np.array([n / ROOM[0], n * 3 // 4 / ROOM[1]]) / 2  # in a half-length
        assert np.all(errors[-1][4:] * elements < 0.125)
    assert np.all(errors[-1][:3] < [2e-4, 1e-4, 5e-4])
    assert np.all(np.log2(errors[0] / errors[-1])[:3] / 2 > 1.6)
    assert np.log2(errors[0] / errors[-1])[3] / 2 > 0.9  # stiffness: that of whole elements in contact
    assert errors[-1][3] < 2e-3


@each_hertz
def test_the_difference_to_the_coarser_contact_covers_the_error(hertz):
    """Of 30 grids that lie differently: 9 in 10 of the errors are below it, all below twice it."""
    random, ratios = np.random.default_rng(0), []
    for n in [36, 48] * 15:
        room, offset = (1.9, 2.1) + 0.1 * random.random(2), random.random(2) - 0.5
        contact = solve(hertzian(hertz, n, n - 12, room=room, offset=offset), load=hertz.load)
        ratios.append(hertz_errors(contact, hertz) / differences(contact))
        assert np.mean(contact.patches[0].x) - (n - 1) / 2 == pytest.approx(offset[0], abs=0.1)
    assert np.all(np.quantile(ratios, 0.9, axis=0) < 1)
    assert np.max(ratios) < 2


@pytest.mark.parametrize("problem", [SOLVED, GROOVE], ids=["Hertz", "groove"])
def test_load_is_the_derivative_of_energy_and_stiffness_that_of_load(problem):
    """By the vertical approach; exactly, because pressures do no work on their own change."""
    middle = solve(problem, load=2000.0, tolerance=1e-10)
    step = 1e-5 * middle.approach
    low, high = (
        solve(problem, approach=middle.approach + sign * step, start=middle.p, tolerance=1e-11)
        for sign in (-1, 1)
    )
    assert (high.energy - low.energy) / (2 * step) == pytest.approx(middle.load, rel=1e-6)
    assert (high.load - low.load) / (2 * step) == pytest.approx(middle.stiffness, rel=1e-4)
    assert middle.load == pytest.approx(2000.0, rel=1e-12)


def iterations(contact):
    """On all its grids."""
    return 0 if contact is None else contact.solution.iterations + iterations(contact.coarser)


@pytest.mark.usefixtures("for_any_grid")
@pytest.mark.parametrize("problem", [SOLVED, GROOVE], ids=["Hertz", "groove"])
def test_load_and_its_approach_give_the_same_contact_from_any_start(problem):
    here = solve(problem, load=2000.0, tolerance=1e-10)
    there = solve(problem, approach=here.approach, tolerance=1e-10)
    start = np.random.default_rng(0).random(here.p.shape)
    again = solve(problem, load=2000.0, start=start, tolerance=1e-10)
    for other in (there, again):
        np.testing.assert_allclose(other.p, here.p, atol=1e-8 * here.p.max())
    assert here.coarser.p.shape == tuple(n // 2 for n in here.p.shape)
    warm = solve(problem, load=2000.0, start=here.p, tolerance=1e-9)
    direct = pressures(problem.bounded, load=2000.0 / problem.grid.area, tolerance=1e-10)
    assert warm.solution.iterations < here.solution.iterations < direct.iterations  # coarser grids help, too
    assert iterations(warm.coarser) < iterations(here.coarser)


@pytest.mark.parametrize(("problem", "accuracy"), [(SOLVED, 1e-6), (GROOVE, 2e-3)], ids=["Hertz", "groove"])
def test_the_coarser_contact_closes_the_mean_gaps_of_four_elements(problem, accuracy):
    """Of the same load; where directions turn, to second order in the width of strips."""
    coarser = solve(problem, load=2000.0).coarser
    assert coarser.load == pytest.approx(2000.0, rel=1e-3)
    assert coarser.problem.grid.strips == pytest.approx(problem.grid.strips.reshape(-1, 2).mean(axis=1))
    fine = coarser.p.repeat(2, axis=0).repeat(2, axis=1)
    assert np.sum(fine * problem.cosine) * problem.grid.area == pytest.approx(2000.0, rel=1e-3)
    gap = problem.operator(fine[..., None])[..., 0] + problem.distance - coarser.approach * problem.cosine
    mean = gap.reshape(problem.grid.n_x // 2, 2, -1, 2).mean(axis=(1, 3))
    assert np.max(np.abs(mean[coarser.in_contact])) < accuracy * coarser.approach
    assert np.min(mean) > -accuracy * coarser.approach


def test_gaps_and_pressures_are_complementary_and_symmetric_along_x():
    contact = solve(GROOVE, load=2000.0, tolerance=1e-10)
    np.testing.assert_allclose(contact.p, contact.p[::-1], atol=1e-8 * contact.p.max())
    assert np.max(np.abs(contact.p - contact.p[:, ::-1])) > 0.1 * contact.p.max()  # but not along s
    u = GROOVE.operator(contact.p[..., None])[..., 0]
    gap = u + GROOVE.distance - contact.approach * GROOVE.cosine
    assert 0 < np.count_nonzero(contact.in_contact) < gap.size / 2
    assert np.max(np.abs(gap[contact.in_contact])) < 1e-6 * contact.approach
    assert np.all(gap[~contact.in_contact] > 0)
    np.testing.assert_allclose(contact.gap, np.where(contact.in_contact, 0.0, gap), atol=1e-14)
    assert contact.area == pytest.approx(np.count_nonzero(contact.p) * 1.2 * 0.5)
    assert contact.load == pytest.approx(np.sum(contact.p * GROOVE.cosine) * 1.2 * 0.5)


def test_vertical_load_includes_inclined_pressures():
    """All pressures at an inclination of 30 degrees, where the surfaces part by approach cos."""
    inclined = replace(SOLVED, cosine=np.full(SOLVED.grid.n_s, np.cos(np.pi / 6)))
    level, tilted = solve(SOLVED, load=2000.0), solve(inclined, load=2000.0 * np.cos(np.pi / 6))
    np.testing.assert_allclose(tilted.p, level.p, atol=1e-6 * level.p.max())
    assert tilted.approach * np.cos(np.pi / 6) == pytest.approx(level.approach, rel=1e-7)
    assert tilted.stiffness == pytest.approx(level.stiffness * np.cos(np.pi / 6) ** 2, rel=1e-6)


def test_si_units_give_the_same_contact():
    grid, operator = SOLVED.grid, SOLVED.operator
    scaled = Grid(grid.n_x, grid.n_s, 1e-3 * grid.dx, 1e-3 * grid.ds)
    operator = replace(operator, kernels={at: 1e-9 * kernel for at, kernel in operator.kernels.items()})
    problem = NormalProblem(scaled, operator, operator, 1e-3 * SOLVED.distance, SOLVED.cosine)
    here, there = solve(SOLVED, load=2000.0), solve(problem, load=2000.0)
    np.testing.assert_allclose(there.p, 1e6 * here.p, rtol=1e-6, atol=1e-3 * here.p.max())
    assert there.approach == pytest.approx(1e-3 * here.approach, rel=1e-9)
    assert there.stiffness == pytest.approx(1e3 * here.stiffness, rel=1e-6)
    assert there.energy == pytest.approx(1e-3 * here.energy, rel=1e-9)
    assert there.patches[0].x == pytest.approx(here.patches[0].x, abs=1e-6)


def test_distant_bumps_are_two_hertzian_contacts():
    """Each feels the other's load as that of a point: approach = Hertz + load / (pi E* distance)."""
    grid = Grid(24, 240, 2 * CIRCLE.a / 12, 2 * CIRCLE.a / 12)
    apart = 200 * grid.ds
    s = np.abs(grid.strips) - apart / 2
    h = (x_of(grid)[:, None] ** 2 + s**2) / 20 / 2
    contact = solve(on_half_spaces(grid, h), load=2 * CIRCLE.load)
    left, right = contact.patches
    assert np.mean(left.s) + np.mean(right.s) == pytest.approx(239, abs=1e-6)
    assert (right.s[1] - right.s[0]) * grid.ds / 2 == pytest.approx(CIRCLE.b, rel=0.02)
    influence = CIRCLE.load / (np.pi * CIRCLE.surfaces.modulus * apart)
    assert influence > 0.01 * CIRCLE.approach
    assert contact.approach == pytest.approx(CIRCLE.approach + influence, rel=0.003)


@pytest.mark.parametrize(
    "given", [{"load": 2000.0}, {"approach": ELLIPSE.approach}], ids=["load", "approach"]
)
@pytest.mark.parametrize(
    ("moved", "ends"),
    [((0, 8), ("s > 0",)), ((0, -8), ("s < 0",)), ((11, 0), ("x > 0",)), ((-11, 8), ("x < 0", "s > 0"))],
)
def test_contact_near_an_end_is_refused_with_the_end_named(moved, ends, given):
    message = f"{MARGIN} elements.*{' and '.join(ends)};"
    with pytest.raises(PotentialAreaTooSmall, match=message) as error:
        solve(hertzian(ELLIPSE, 36, 26, offset=moved), **given)
    assert error.value.ends == ends


def test_without_contact_there_is_no_load_and_no_error():
    contact = solve(SOLVED, approach=-0.01)
    assert (contact.load, contact.area, contact.energy, contact.stiffness) == (0.0, 0.0, 0.0, 0.0)
    assert contact.patches == []
    np.testing.assert_allclose(contact.gap, SOLVED.distance + 0.01)


def test_shapes_must_fit_and_distances_be_numbers():
    with pytest.raises(WrongInput, match=r"distance of shape \(26, 36\).*\(36, 26\) and \(26,\) are needed"):
        with_distance(SOLVED, SOLVED.distance.T)
    with pytest.raises(WrongInput, match=r"cosine of shape \(36,\)"):
        replace(SOLVED, cosine=np.ones(36))
    with pytest.raises(WrongInput, match="distance: some are not numbers"):
        with_distance(SOLVED, np.where(SOLVED.distance > 0.01, np.nan, SOLVED.distance))
    with pytest.raises(WrongInput, match="distance: infinite everywhere"):
        with_distance(SOLVED, np.full(SOLVED.distance.shape, np.inf))


def test_elements_that_may_touch_one_by_one_give_no_coarser_contact():
    """Elsewhere the distance is infinite: one of four has it, and so have all elements twice as large."""
    lone = np.zeros(SOLVED.distance.shape, dtype=bool)
    lone[8:28:2, 6:20:2] = True
    contact = solve(with_distance(SOLVED, np.where(lone, SOLVED.distance, np.inf)), load=2000.0)
    assert contact.coarser is None
    assert not np.any(contact.in_contact & ~lone)
    assert contact.load == pytest.approx(2000.0)


def test_numbers_of_elements_that_are_odd_or_small_give_no_coarser_contact():
    for n_x, n_s in ((37, 26), (36, 27)):
        assert solve(hertzian(ELLIPSE, n_x, n_s), load=2000.0).coarser is None
    assert not hertzian(ELLIPSE, 6, 26).has_coarser
    assert hertzian(ELLIPSE, 8, 26).has_coarser
    assert solve(hertzian(ELLIPSE, 16, 16), load=500.0).coarser.coarser.coarser is None


# ---- wheels in elliptic grooves: Hertz while the contact is small, estimates where it is not

CONFORMAL = {"wide": (60.0, 30.0, 660e3), "tall": (36.0, 14.0, 58e3)}  # of the grid in mm; load in N


def figure_grid(name, n):
    length, width, _ = CONFORMAL[name]
    return Grid(n, n + 8, length / n, width / (n + 8))


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
@pytest.mark.parametrize("name", GROOVES)
def test_grooves_under_small_loads_agree_with_hertz(name, variant):
    """The radius of an ellipse at its crown is lateral^2 / vertical."""
    wheel, rail = (vertical / lateral**2 for lateral, vertical in GROOVES[name])
    hertz = PointContact(1 / ROLLING_RADIUS, rail - wheel, combined_modulus(STEEL, STEEL)).at_load(10.0)
    contact = solve(elliptic(name, Grid(36, 26, 3.8 * hertz.a / 36, 4.2 * hertz.b / 26), variant), load=10.0)
    assert np.all(hertz_errors(contact, hertz) < [2e-3, 2e-3, 5e-3, 0.02, 0.03, 0.03])


@pytest.mark.parametrize(("name", "variant"), [("wide", "A"), ("tall", "Bhat")])
def test_estimate_under_large_loads_covers_the_difference_to_a_fine_grid(name, variant):
    """Conformal contacts of 34 degrees and more; elements of a quarter of the size stand for the truth."""
    load = CONFORMAL[name][2]
    coarse, fine = (solve(elliptic(name, figure_grid(name, n), variant), load=load) for n in (24, 96))
    inclinations = coarse.problem.cosine[coarse.in_contact.any(axis=0)]
    assert np.arccos(np.min(inclinations)) > np.radians(17)
    assert np.all(np.abs(numbers(coarse) / numbers(fine) - 1) < differences(coarse))
    assert np.all(differences(fine) < differences(coarse) / 3)


# ---- what ICs do to a contact
PRISMATIC = Pair(
    Solid(BRASS, Surface(UPPER, arc(10.1, 1.3, 1.1))), Solid(STEEL, Surface(LOWER, arc(10.0, 1.3, 1.1)))
)
ICS = matrix("Bhat", PRISMATIC, GROOVE.grid)[..., N:, N:]  # of the groove as a dense matrix
TIGHT = 1e-11


def with_ics(ics, problem=GROOVE):
    return replace(problem, operator=GridOperator.from_ics(ics, (N,)))


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
def test_matrix_of_ics_gives_the_contact_of_their_operator(variant):
    """Not the coarser one, but of A: the factors of operators that rotate are averaged."""
    problem = conformal(GROOVE.grid, variant, shift=0.05)
    here = solve(problem, load=2000.0)
    there = solve(with_ics(matrix(variant, PRISMATIC, GROOVE.grid)[..., N:, N:], problem), load=2000.0)
    np.testing.assert_allclose(there.p, here.p, atol=1e-6 * here.p.max())
    assert there.approach == pytest.approx(here.approach, rel=1e-7)
    accuracy = 1e-7 if variant == "A" else 1e-3
    assert there.coarser.approach == pytest.approx(here.coarser.approach, rel=accuracy)


@pytest.mark.parametrize("given", ["approach", "load"])
def test_perturbed_ics_change_pressures_linearly_to_first_order(given):
    """-S^-1 dS p on the elements in contact, and what keeps the load; the rest falls with the square."""
    lags, s = GROOVE.grid.lags[:, None, None], GROOVE.grid.strips / 10
    wave = np.cos(lags / 5) * (1 + np.sin(3 * s[:, None]) * np.sin(3 * s) + s[:, None] + s)
    change = 0.1 * ICS * wave[..., None, None]  # symmetric; it varies with lag and strips
    whole = solve(with_ics(ICS), load=2000.0, tolerance=TIGHT)
    elements, p = whole.in_contact, whole.p[whole.in_contact]
    c = np.broadcast_to(GROOVE.cosine, elements.shape)[elements]
    S, dS = (
        dense(GridOperator.from_ics(ics, (N,)), (*elements.shape, 1))[
            np.ix_(elements.ravel(), elements.ravel())
        ]
        for ics in (ICS, change)
    )
    first_order, of_c = -np.linalg.solve(S, dS @ p), np.linalg.solve(S, c)
    if given == "load":
        first_order -= of_c * (c @ first_order) / (c @ of_c)
    remainders = []
    for share in (0.02, 0.01, 0.005):
        problem, prescribed = with_ics(ICS + share * change), {given: getattr(whole, given)}
        damaged = solve(problem, **prescribed, start=whole.p, tolerance=TIGHT)
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
    modulus = 1 / sum((1 - each.nu**2) / each.E for each in materials)
    other = on_half_spaces(problem.grid, problem.distance, *materials)
    expected = ELLIPSE.load * modulus / ELLIPSE.surfaces.modulus
    assert solve(other, approach=ELLIPSE.approach).load == pytest.approx(expected, rel=2e-3)


# ---- the ends of what users ask for: one element, narrow ones, tight grooves, flat punches


@pytest.mark.parametrize("aspect", [0.05, 0.25, 4.0, 20.0])
def test_elements_may_be_as_narrow_as_one_in_twenty(aspect):
    """A circle, 8 elements across on its coarser side: within what such elements allow."""
    coarse, fine = 16, round(16 * max(aspect, 1 / aspect))
    n_x, n_s = (fine, coarse) if aspect < 1 else (coarse, fine)
    problem = hertzian(CIRCLE, n_x, n_s, room=(2.0, 2.0))
    assert problem.grid.dx / problem.grid.ds == pytest.approx(aspect)
    contact = solve(problem, load=CIRCLE.load)
    assert np.all(hertz_errors(contact, CIRCLE) < [0.003, 0.003, 0.02, 0.07, 0.05, 0.05])


@pytest.mark.parametrize("ratio", [1e-3, 400.0])
def test_patches_may_be_very_slender(ratio):
    """Tips are sharper than elements are long: the longer axis is short by up to half of one."""
    hertz = PointContact(0.05, 0.05 * ratio, MODULUS).at_load(2000.0)
    assert max(hertz.a / hertz.b, hertz.b / hertz.a) > 40
    contact = solve(hertzian(hertz, 36, 26), load=2000.0)
    allowed = [0.003, 0.003, 0.01, 0.05, 0.5 * 1.9 / 18, 0.5 * 2.1 / 13]
    assert np.all(hertz_errors(contact, hertz) < allowed)


def test_a_contact_may_be_one_element():
    """Its pressure is load / area; approach = gap + own IC times pressure."""
    problem = hertzian(ELLIPSE, 37, 27)
    load, area = 1e-3, problem.grid.area
    contact = solve(problem, load=load)
    assert np.argwhere(contact.in_contact).tolist() == [[18, 13]]
    assert contact.p.max() == pytest.approx(load / area)
    unit = np.zeros((37, 27, 1))
    unit[18, 13] = 1
    own = problem.operator(unit)[18, 13, 0]
    assert contact.approach == pytest.approx(own * load / area, rel=1e-9)
    assert contact.stiffness == pytest.approx(area / own, rel=1e-9)
    assert contact.patches[0].x == pytest.approx((17.5, 18.5), abs=0.51)


def test_ten_decades_of_load_follow_hertz_while_the_contact_is_small_against_the_radii():
    """A groove of revolution on an arc, on grids of the size of the contact; conformity begins at the end."""
    surfaces = PointContact(1 / 500, 1 / 10 - 1 / 13, MODULUS)
    loads = 10.0 ** np.arange(-5, 6)
    approaches, relative = [], []
    for load in loads:
        hertz = surfaces.at_load(load)
        grid = Grid(36, 26, 1.9 * 2 * hertz.a / 36, 2.1 * 2 * hertz.b / 26)
        contact = solve(conformal(grid, ratio=0.3), load=load)
        approaches.append(contact.approach)
        relative.append(numbers(contact) / of_hertz(hertz) - 1)
    assert np.all(np.diff(approaches) > 0)
    assert np.max(np.abs(relative[:8])) < 0.04
    assert np.max(np.abs(np.diff(relative[:7], axis=0))) < 1e-4  # the same contact but for its size
    assert np.max(np.abs(relative[-1] - relative[0])) > 0.01


def test_tight_grooves_approach_the_limit_without_clearance():
    """Of 10 mm, by 1 um and less wider, on rails that end at -8 and 7 mm: so does the contact."""
    grid, pressures = Grid(16, 48, 1.5, 0.45, -1.0), []
    for ratio in (1e-4, 1e-5, 1e-6, 0.0):
        problem = conformal(grid, ratio=ratio)
        ends = with_distance(problem, np.where(np.abs(grid.strips + 0.5) < 7.5, problem.distance, np.inf))
        contact = solve(ends, approach=0.008, tolerance=1e-10)
        assert np.ptp(contact.patches[0].s) * grid.ds == pytest.approx(15.0, abs=grid.ds)
        pressures.append(contact.p)
    differences = [np.max(np.abs(p - pressures[-1])) / np.max(p) for p in pressures[:-1]]
    assert differences[0] < 0.1
    assert np.divide(differences[:-1], differences[1:]) == pytest.approx([10, 10], rel=0.1)


def test_flat_punch_agrees_with_boussinesq():
    """No gap on a circle, no contact beside it: approach = load / (2 E* radius), pressures without end."""
    errors = []
    for n in (24, 96):
        grid = Grid(n, 2 * n, 3.0 / n, 1.5 / n)
        radius = np.hypot(x_of(grid)[:, None], grid.strips)
        contact = solve(on_half_spaces(grid, np.where(radius < 1.0, 0.0, np.inf)), load=500.0)
        assert np.all(contact.in_contact == (radius < 1.0))
        errors.append(contact.approach / (500.0 / (2 * MODULUS)) - 1)
        assert contact.stiffness == pytest.approx(500.0 / contact.approach, rel=1e-6)
    assert abs(errors[-1]) < 0.01
    assert abs(errors[-1]) < abs(errors[0])


def test_rough_surfaces_touch_in_many_patches():
    smooth = hertzian(ELLIPSE, 48, 40, room=(2.4, 2.4))
    roughness = 0.3 * ELLIPSE.approach * np.random.default_rng(3).random((48, 40))
    contact = solve(with_distance(smooth, smooth.distance + roughness), load=300.0)
    assert len(contact.patches) > 3
    assert contact.load == pytest.approx(300.0)
    assert contact.area < 0.8 * solve(smooth, load=300.0).area
    assert contact.p.max() > ELLIPSE.surfaces.at_load(300.0).p_max
