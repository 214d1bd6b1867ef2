"""Contact of scenes: grids that fit, Hertz at small loads, what ICs change, estimates, refusals."""

from dataclasses import replace

import numpy as np
import pytest

from approx.matrix import matrix
from compare.contact.automatic_grid import MOST_STRIPS, Sizing
from compare.contact.compute import (
    ReferenceICs,
    compute_contact,
    grids_of,
    reference_ics,
    require_positive,
    smallest_eigenvalue,
)
from compare.contact.dataset import to_dataset
from compare.contact.page import write_contact
from compare.contact.pair_on_grid import Case, placed_on, undeformed_of
from compare.contact.quantities import numbers
from femic.contact.edges import MARGIN
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.normal import NormalProblem, solve
from femic.contact.operators.approximations import half_space_operator
from femic.contact.operators.dense import GridOperator
from femic.reference.run_options import RunOptions
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene, scene_from_table
from geometries.errors import Failure, WrongInput
from geometries.grids import Grid
from geometries.patches import N

RADIUS, WHEEL, ROLLING = 10.0, 14.0, 400.0
FLANKS = 60.0
SMALL = 2.0  # N: a patch of a degree in all, b / R = 0.006


def scene(upper_radius=WHEEL, inclination=FLANKS, **contact):
    """A wheel of revolution on a rail, arcs, with the keys of [contact]."""
    lower = {"kind": "arc", "radius": RADIUS, "flank_inclination_deg": inclination}
    upper = lower | {"radius": upper_radius}
    return scene_from_table(
        {
            "lower": {"E": 210e3, "nu": 0.3, "contour": lower},
            "upper": {"E": 100e3, "nu": 0.25, "contour": upper, "rolling_radius": ROLLING},
            "patch": {"a": 0.1, "b": 0.1},
            "contact": {"ics": ["A", "Bhat"]} | contact,
        },
        "pair",
    )


def hertz(of=None):
    bodies = (of or scene()).bodies
    modulus = combined_modulus(bodies["upper"].material, bodies["lower"].material)
    return PointContact(1 / ROLLING, 1 / RADIUS - 1 / WHEEL, modulus)


def sizing(of):
    return Sizing(placed_on(of, of.grid), of.contact.elements)


def test_small_contacts_are_those_of_hertz():
    results = to_dataset(compute_contact(scene(loads=[SMALL], elements=40)))
    expected = hertz().at_load(SMALL)
    exact = {
        "a": expected.a,
        "b": expected.b,
        "p_max": expected.p_max,
        "approach": expected.approach,
        "stiffness": expected.stiffness,
        "load": SMALL,
    }
    for name, value in exact.items():
        found, estimate = results[name].sel(ics="Bhat"), results[f"estimate_{name}"].sel(ics="Bhat")
        assert float(found[0]) == pytest.approx(value, abs=float(estimate[0]) + 2e-4 * value), name
        assert float(estimate[0]) < 0.03 * value


def test_estimates_cover_what_twice_as_many_elements_change():
    coarse, fine = (
        to_dataset(compute_contact(scene(10.2, loads=[3e3], elements=n))).isel(case=0) for n in (16, 32)
    )
    for name in ("a", "b", "p_max", "approach", "angle"):
        assert np.all(abs(coarse[name] - fine[name]) <= coarse[f"estimate_{name}"]), name


def test_contacts_at_the_approach_that_a_load_causes_carry_this_load():
    by_load = to_dataset(compute_contact(scene(loads=[2e3])))
    approach = float(by_load.approach.sel(ics="Bhat")[0])
    by_approach = to_dataset(compute_contact(scene(approaches=[approach], ics=["Bhat"])))
    assert float(by_approach["load"][0, 0]) == pytest.approx(2e3, rel=2e-3)  # on another grid


def test_conforming_contact_is_wider_and_softer_than_half_spaces_say():
    """B-hat turns loads away from the normals of distant elements: less displacement there than A has."""
    results = to_dataset(compute_contact(scene(10.2, loads=[2e4]))).isel(case=0)
    a, bhat = results.sel(ics="A"), results.sel(ics="Bhat")
    assert bhat.b > 1.03 * a.b
    assert bhat.p_max < 0.99 * a.p_max
    assert bhat.approach < a.approach


def test_the_exact_distance_agrees_where_the_approach_is_small_beside_the_radii():
    def difference(load):
        results = to_dataset(compute_contact(scene(10.2, loads=[load]))).isel(case=0).sel(ics="Bhat")
        return abs(float(results.displaced_p_max / results.p_max) - 1)

    assert difference(20.0) < 2e-3 < difference(2e4)


def test_loads_that_hardly_differ_are_cases_of_their_own(tmp_path):
    """One that is given twice is refused: cases are known by their names."""
    results = compute_contact(scene(10.2, loads=[1e4, 2000.0001, 2e3], elements=8, ics=["A"]))
    assert list(to_dataset(results).case.values) == ["10000 N", "2000.0001 N", "2000 N"]
    assert write_contact(results, tmp_path).is_file()
    for key, same in (("loads", [5.0, 5.0]), ("approaches", [0.1, 0.1 * (1 + 1e-14)])):
        with pytest.raises(BadScene, match=rf"contact\.{key} = .*: .* given twice: name each once"):
            scene(**{key: same})


def test_curvatures_are_those_where_bodies_touch_however_far_they_reach():
    """Also beyond the wheel, as with a unit of length of a kilometre."""
    ellipse = sizing(replace(scene(), reference_length=1e6)).hertz(Case(SMALL, None))
    expected = hertz().at_load(SMALL)
    assert (ellipse.a, ellipse.b) == pytest.approx((expected.a, expected.b), rel=1e-2)


def test_scenes_with_the_exact_distance_solve_with_it():
    linear, exact = (compute_contact(scene(10.2, loads=[2e4], gap=gap)) for gap in ("linear", "exact"))
    (case,) = linear.cases
    displaced = linear.contacts[case, "Bhat"].displaced
    assert exact.contacts[case, "Bhat"].normal.approach == pytest.approx(displaced.normal.approach, rel=1e-4)


def test_the_estimate_of_c_is_added_to_what_elements_change(monkeypatch):
    """Not the larger of both: ICs larger by 4 % change the approach by 2.4 % or more, and p_max."""

    def known(of, placed, _):
        nn = matrix("Bhat", of.pair, placed.grid)[..., 2:, 2:]
        return ReferenceICs(*[GridOperator.of(f * nn, (N,)) for f in (1.0, 1.04)], 0.0, 0.0, 1.0, 0.0)

    monkeypatch.setattr("compare.contact.compute.reference_ics", known)
    results = compute_contact(scene(10.2, loads=[3e3], ics=["C"], elements=12))
    (contact,) = results.contacts.values()
    assert contact.perturbed.normal.approach > 1.02 * contact.normal.approach
    exact = replace(results, contacts={at: replace(c, perturbed=None) for at, c in results.contacts.items()})
    both, of_elements = (to_dataset(one).isel(case=0, ics=0) for one in (results, exact))
    changed = numbers(contact.placed, contact.perturbed.normal)
    for name, value in changed.items():
        added = float(both[f"estimate_{name}"] - of_elements[f"estimate_{name}"])
        assert added >= 0.999 * abs(value - float(both[name])), name
        assert float(of_elements[f"estimate_{name}"]) > 0, name
    assert float(both.estimate_approach - of_elements.estimate_approach) < 0.05 * float(both.approach)


# --- grids ----------------------------------------------------------------------------------------------


def test_grids_fit_the_contact_on_them():
    of = scene(10.2, loads=[5e2, 5e3])
    ((grid, cases),) = sizing(of).grids([Case(load, None) for load in of.contact.loads])
    assert [case.load for case in cases] == [5e2, 5e3]
    placed = placed_on(of, grid)
    small, large = (placed.contact(placed.operator("Bhat"), case) for case in cases)
    across = np.count_nonzero(small.in_contact.any(axis=0)), np.count_nonzero(small.in_contact.any(axis=1))
    assert min(across) >= 0.85 * of.contact.elements
    room = grid.n_s - np.count_nonzero(large.in_contact.any(axis=0))
    assert 2 * MARGIN <= room < 0.7 * grid.n_s


def test_loads_that_are_decades_apart_have_grids_of_their_own():
    grids = sizing(scene()).grids([Case(load, None) for load in (1e-3, 1e3)])
    assert [[case.load for case in cases] for _, cases in grids] == [[1e-3], [1e3]]
    assert max(grid.n_s for grid, _ in grids) <= MOST_STRIPS


def test_sizes_grow_as_hertz_says_over_ten_decades():
    of = scene()
    for load in (1e-8, 1e-4, 1e0):
        size, expected = sizing(of).size(Case(load, None)), hertz(of).at_load(load)
        assert size.x[1] == pytest.approx(expected.a, rel=0.1)
        assert size.s[1] - size.s[0] == pytest.approx(2 * expected.b, rel=0.1)


def test_grids_of_symmetric_pairs_are_symmetric_and_others_lie_about_the_contact():
    ((middle, _),) = sizing(scene()).grids([Case(SMALL, None)])
    shifted = sizing(scene(shift=0.5))
    ((aside, _),) = shifted.grids([Case(SMALL, None)])
    assert middle.s == 0.0
    assert aside.s == pytest.approx(shifted.bodies.undeformed.touching[0], abs=2 * aside.ds)


def test_contacts_at_the_end_of_a_contour_are_refused_with_the_end_and_a_remedy():
    of = scene(10.05, 20.0, flanks=False)
    with pytest.raises(
        Failure, match=r"contact at 50000 N: it reaches the end of a contour at s < 0 and s > 0"
    ):
        sizing(of).size(Case(5e4, None))


def test_the_scene_may_give_the_grid():
    of = scene(loads=[SMALL], grid="scene")
    assert {contact.placed.grid for contact in compute_contact(of).contacts.values()} == {of.grid}


def test_scenes_without_loads_and_with_ics_that_cannot_be_made_are_refused():
    with pytest.raises(BadScene, match=r"\[contact\]: give loads = .* in N, or approaches = .* in mm"):
        compute_contact(scene())
    with pytest.raises(BadScene, match=r"contact\.ics: Bhat_prime needs effective properties of both bodies"):
        compute_contact(scene(loads=[1.0], ics=["Bhat_prime"]))
    with pytest.raises(BadScene, match="give either loads or approaches"):
        scene(loads=[1.0], approaches=[1.0])


# --- C --------------------------------------------------------------------------------------------------


@pytest.mark.slow  # two models by finite elements
def test_c_of_planes_gives_the_contact_of_half_spaces():
    """Within the estimate of C, and with eigenvalues as positive as those of A."""
    of = load_scene("flat", {"engine": {"tolerance": 0.01}})
    grid = Grid(24, 16, 0.4, 0.3)
    placed = placed_on(of, grid)
    c = reference_ics(of, placed, RunOptions())
    assert c.eigenvalue > 0
    assert c.asymmetry < c.estimate < 1e-2
    distance = placed.x[:, None] ** 2 / 40 + grid.strips**2 / 20
    by_c, by_c_and_estimate, by_a = (
        solve(NormalProblem(grid, operator, placed.flat, distance, placed.cosine), load=500.0)
        for operator in (c.operator, c.perturbed, half_space_operator(of.pair, grid, (N,)))
    )
    known = abs(by_c_and_estimate.p.max() / by_c.p.max() - 1) + c.estimate
    assert by_c.p.max() == pytest.approx(by_a.p.max(), rel=known)
    assert by_c.patches[0].s == pytest.approx(by_a.patches[0].s, abs=0.1)


def test_a_rigid_give_along_z_changes_the_approach_alone():
    """As the discount's M_zz does: by itself times the load; also where ICs are not positive with it."""
    of = scene(10.2, loads=[2e3])
    ((grid, (case,)),) = sizing(of).grids([Case(2e3, None)])
    placed = placed_on(of, grid)
    nn = matrix("Bhat", of.pair, grid)[..., N, N]
    give = -3e-7 * grid.area  # mm/MPa: more than B-hat has over the grid
    moved = nn + give * np.outer(placed.cosine, placed.cosine)
    plain, given = (placed.contact(GridOperator.of(ics[..., None, None], (N,)), case) for ics in (nn, moved))
    np.testing.assert_allclose(given.p, plain.p, atol=1e-5 * plain.p.max())
    assert given.approach - plain.approach == pytest.approx(give / grid.area * 2e3, rel=1e-6)
    of_load = placed.cosine[None]
    assert smallest_eigenvalue(nn, of_load) == pytest.approx(smallest_eigenvalue(moved, of_load), rel=0.1)


def without_a_turn(placed, nn):
    """ICs from which a turn is taken: antisymmetric pressures do negative work."""
    turn = np.sin(placed.undeformed.lower.contour.inclination(placed.grid.strips))
    return nn - 5e-5 * placed.grid.area * np.outer(turn, turn)


def test_c_that_is_not_positive_for_the_pressures_of_a_contact_is_refused_before_it_is_solved():
    """Symmetric contact has no antisymmetric pressures, which alone do negative work here."""
    of = scene(10.2, loads=[2e3])
    ((grid, _),) = sizing(of).grids([Case(2e3, None)])
    placed = placed_on(of, grid)
    nn = without_a_turn(placed, matrix("Bhat", of.pair, grid)[..., N, N])
    assert smallest_eigenvalue(nn, placed.cosine[None]) < 0
    assert placed.symmetric
    assert require_positive(of, placed, nn) > 0.1
    moved = replace(placed, undeformed=replace(placed.undeformed, shift=0.05))
    assert not moved.symmetric
    with pytest.raises(Failure, match=r"'approach'.* without vertical load would do negative work"):
        require_positive(of, moved, nn)
    with pytest.raises(Failure, match="use discount = 'approach'"):
        require_positive(replace(of, discount="source"), moved, nn)


@pytest.mark.parametrize("n_s", [6, 7])
def test_symmetric_pressures_have_the_eigenvalues_of_symmetric_eigenvectors(n_s):
    """Against all eigenvectors of a dense matrix of random symmetric ICs of one element along x."""
    rng = np.random.default_rng(n_s)
    half = rng.standard_normal((n_s, n_s))
    whole = half @ half.T + (half @ half.T)[::-1, ::-1]
    values, vectors = np.linalg.eigh(whole)
    even = [v for v, w in zip(values, vectors.T, strict=True) if np.allclose(w, w[::-1], atol=1e-8)]
    found = smallest_eigenvalue(whole[None], np.zeros((0, n_s)), symmetric=True)
    assert found == pytest.approx(min(even) / whole.diagonal().min(), rel=1e-2, abs=0.04)


# --- what a scene may add -------------------------------------------------------------------------------


def with_gap(folder, points, **contact):
    """The scene with an extra gap at points (x, s, gap)."""
    file = folder / "gap.txt"
    np.savetxt(file, points)
    return scene(extra_gap=str(file), **contact)


CORNERS = [(x, s) for x in (-50.0, 50.0) for s in (-9.0, 9.0)]


def test_a_constant_extra_gap_is_closed_by_the_approach(tmp_path):
    """Along the normals, that is: the relative curvature changes by 0.01 mm / R^2, 0.4 % of it."""
    plain, raised = (
        compute_contact(of)
        for of in (
            scene(loads=[SMALL], ics=["Bhat"]),
            with_gap(tmp_path, [(*at, 0.01) for at in CORNERS], loads=[SMALL], ics=["Bhat"]),
        )
    )
    (case,) = plain.cases
    before, after = (results.contacts[case, "Bhat"].normal for results in (plain, raised))
    assert after.approach - before.approach == pytest.approx(0.01, rel=1e-4)
    np.testing.assert_allclose(after.p, before.p, atol=4e-3 * before.p.max())


@pytest.mark.parametrize(("slopes", "along"), [((0.0, 4e-4), 1), ((1e-4, 0.0), 0), ((-5e-5, 3e-4), None)])
def test_a_gap_that_rises_along_one_way_moves_the_contact_the_other_way(tmp_path, slopes, along):
    """Of parabolas of curvature c the least of c t^2 / 2 + g t is at -g / c."""
    rising = [(x, s, slopes[0] * x + slopes[1] * s) for x, s in CORNERS]
    of = with_gap(tmp_path, rising, loads=[SMALL], ics=["Bhat"])
    (contact,) = compute_contact(of).contacts.values()
    p, placed = contact.normal.p, contact.placed
    middle = np.sum(p * placed.x[:, None]) / p.sum(), np.sum(p * placed.grid.strips) / p.sum()
    expected = -slopes[0] * ROLLING, -slopes[1] / (1 / RADIUS - 1 / WHEEL)
    step = placed.grid.dx, placed.grid.ds
    for k in (0, 1) if along is None else (along, 1 - along):
        assert middle[k] == pytest.approx(expected[k], rel=0.02, abs=0.02 * step[k])
        assert expected[k] == 0 or abs(expected[k]) > step[k] / 2


def test_a_hollow_in_the_middle_leaves_two_patches(tmp_path):
    hollow = [(*at, 0.0) for at in [*CORNERS, (-50.0, -0.2), (50.0, -0.2), (-50.0, 0.2), (50.0, 0.2)]]
    of = with_gap(tmp_path, [*hollow, (-50.0, 0.0, 0.01), (50.0, 0.0, 0.01)], loads=[20.0], ics=["Bhat"])
    results = compute_contact(of)
    (contact,) = results.contacts.values()
    left, right = contact.normal.patches
    assert left.s[1] < right.s[0]
    assert contact.normal.load == pytest.approx(20.0)


@pytest.mark.parametrize("columns", [2, 3])
def test_a_gap_across_is_one_at_all_x(columns, tmp_path):
    """A profile that was measured at one x, the natural case: as if it were given far away on both sides."""
    s = np.linspace(-9.0, 9.0, 7)
    profile, far = np.column_stack([s, 1e-4 * s**2]), 50.0
    both = np.concatenate([np.column_stack([np.full(7, x), profile]) for x in (-far, far)])
    given = profile if columns == 2 else np.column_stack([np.zeros(7), profile])
    solved = [
        compute_contact(with_gap(tmp_path, points, loads=[SMALL], ics=["Bhat"])) for points in (given, both)
    ]
    alone, between = (next(iter(results.contacts.values())).normal for results in solved)
    np.testing.assert_allclose(alone.p, between.p, atol=1e-6 * between.p.max())


@pytest.mark.parametrize(
    ("points", "says"),
    [
        ([(0.0,)] * 3, r"line 1: 1 columns; give s, gap or x, s, gap"),
        ([(0.0, 0.0, 0.0)] * 3, r"points 1 and 2 are at the same place"),
        ([(x, 0.0, 0.0) for x in range(3)], r"3 points on one line, not at one x"),
    ],
)
def test_files_of_an_extra_gap_are_checked(points, says, tmp_path):
    with pytest.raises(BadScene, match=rf"contact\.extra_gap = .*gap\.txt: {says}"):
        with_gap(tmp_path, points, loads=[SMALL])


def test_gaps_that_raise_a_surface_far_are_refused(tmp_path):
    """Far beside reference_length, here 10 mm: the surface would have another shape."""
    with_gap(tmp_path, [(*at, -1.0) for at in CORNERS], loads=[SMALL])
    with pytest.raises(
        BadScene, match=r"contact\.extra_gap: -1\.1 mm raises .* 10% of reference_length, 1 mm"
    ):
        with_gap(tmp_path, [(*at, -1.1) for at in CORNERS], loads=[SMALL])


def test_where_c_needs_a_longer_grid_it_is_made_longer(monkeypatch):
    """Of ICs that stand for C and are eight times those of B-hat."""

    def much_softer(of, placed, _):
        nn = 8 * matrix("Bhat", of.pair, placed.grid)[..., 2:, 2:]
        return ReferenceICs(*[GridOperator.of(nn, (N,))] * 2, 0.0, 0.0, 1.0, 0.0)

    of = scene(10.2, loads=[5e3], ics=["Bhat", "C"])
    ((first, _),) = grids_of(of)
    monkeypatch.setattr("compare.contact.compute.reference_ics", much_softer)
    results = compute_contact(of)
    (grid,) = results.references
    assert (grid.dx, grid.ds) == (first.dx, first.ds)
    assert grid.n_x > first.n_x or grid.n_s > first.n_s
    assert {contact.placed.grid for contact in results.contacts.values()} == {grid}
    with pytest.raises(Failure, match=r"contact at 5000 N with C: potential contact area"):
        compute_contact(scene(10.2, loads=[5e3], ics=["C"], grid="scene"))


def test_bodies_that_are_not_opposite_on_the_grid_are_refused():
    of = scene(loads=[1.0], ics=["A"])
    beside_the_wheel = replace(placed_on(of, Grid(8, 8, 0.1, 0.1)), grid=Grid(2, 8, 5 * ROLLING, 0.1))
    with pytest.raises(
        WrongInput, match=r"contact at 1 N: at a shift of 0 mm no part .* on s = -0\.4 \.\.\. 0\.4"
    ):
        beside_the_wheel.contact(beside_the_wheel.operator("A"), Case(1.0, None))


def test_bodies_that_do_not_touch_on_the_grid_are_refused():
    of = scene(approaches=[1e-5], ics=["A"], grid="scene", shift=3.0)
    with pytest.raises(WrongInput, match=r"contact at 1e-05 mm: the bodies do not touch on s = "):
        compute_contact(of)


def test_c_of_the_upper_body_lies_opposite_that_of_the_lower(monkeypatch):
    """Where the wheel is moved aside, both strips of a pair have the same y."""
    of = scene(12.0, shift=0.7)
    grid = Grid(8, 6, 0.2, 0.2, undeformed_of(of).touching[0])
    asked = {}

    def recorded(jobs, *_, **__):
        asked.update(jobs)
        raise InterruptedError

    monkeypatch.setattr("compare.contact.compute.matrices", recorded)
    with pytest.raises(InterruptedError):
        reference_ics(of, placed_on(of, grid), RunOptions())
    middle = {name: float(job.body.contour.position(job.grid.s)[0]) for name, job in asked.items()}
    assert middle["upper"] + 0.7 == pytest.approx(middle["lower"], abs=1e-6)
    assert abs(asked["upper"].grid.s - asked["lower"].grid.s) > 0.5
    assert asked["upper"].grid.n_s == asked["lower"].grid.n_s == 6
    assert {job.components for job in asked.values()} == {("nn",)}  # and no loads of other directions


# --- beside the crown -------------------------------------------------------------------------------------


def sideways(upper_radius=10.3, **contact):
    """Numbers of a contact by B-hat."""
    results = compute_contact(scene(upper_radius, loads=[2e4], elements=12, **contact))
    return to_dataset(results).sel(ics="Bhat").isel(case=0)


def test_a_mirrored_contact_has_mirrored_forces_and_the_estimates_cover_what_is_left():
    right, left = sideways(shift=0.04), sideways(shift=-0.04)
    assert float(right.F_y) < -0.03 * float(right["load"])
    for name in ("F_y", "M_x", "s_centre", "position"):
        assert float(left[name]) == pytest.approx(-float(right[name]), rel=1e-4)
    assert float(right.M_x) == pytest.approx(RADIUS * float(right.F_y), rel=1e-9)
    assert float(left.p_max) == pytest.approx(float(right.p_max), rel=1e-4)


def test_the_position_follows_a_lateral_force_wherever_it_is_sought_from():
    """The force that a shift gives puts the body there, to the pairing of strips, from there and from 0."""
    shifted = sideways(shift=0.04)
    for start in (0.0, 0.04):
        found = sideways(shift=start, lateral_force=float(shifted.F_y))
        assert float(found.F_y) == pytest.approx(float(shifted.F_y), rel=1e-6)
        assert float(found.position) == pytest.approx(0.04, rel=2e-2)
        assert float(found.p_max) == pytest.approx(float(shifted.p_max), rel=2e-3)
        assert 0 < float(found.estimate_position) < 0.1 * 0.04


def test_without_a_lateral_force_a_shifted_body_slides_back():
    assert float(sideways(shift=0.04, lateral_force=0.0).position) == pytest.approx(0.0, abs=1e-4)


def test_a_lateral_force_that_the_contours_cannot_bear_is_refused():
    """Nearly all of what the steepest flank would bear if it alone touched; and more, before any work."""
    steepest = 2e4 * np.tan(np.radians(FLANKS))
    with pytest.raises(Failure, match=r"reaches the end of a contour|lateral force: not reached|no grid"):
        sideways(lateral_force=-0.99 * steepest)
    with pytest.raises(BadScene, match=r"contact\.lateral_force = .*: without friction it is at most"):
        sideways(lateral_force=-1.01 * steepest)


@pytest.mark.slow  # two models by finite elements
def test_what_is_taken_for_rigid_changes_the_approach_of_a_wheel_and_no_pressure():
    """By M_zz times the load, where contours differ, and where the upper body is moved aside, too.

    With each body's own M_zz, read along its own normals, p_max changed by 1 % on contours such as these.
    """
    of = scene(11.5, inclination=75, loads=[2e4], shift=0.05, grid="scene", ics=["C"])
    grid = Grid(24, 16, 0.9, 0.8, -0.8)
    found = {}
    for discount in ("approach", "none"):
        on_grid = replace(of, grid=grid, discount=discount, settings=replace(of.settings, tolerance=0.1))
        (contact,) = compute_contact(on_grid, RunOptions(2)).contacts.values()
        found[discount] = contact.normal
    approach, none = found["approach"], found["none"]
    np.testing.assert_allclose(approach.p, none.p, atol=3e-4 * none.p.max())  # models of their own
    assert abs(approach.approach / none.approach - 1) > 1e-3
