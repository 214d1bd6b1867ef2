"""Grids that fit contacts: sizes, ends of contours, grids that are made longer."""

from dataclasses import replace

import numpy as np
import pytest

from compare.validation.extremes import contacts
from femic.contact.exact.hertz import combined_modulus
from femic.contact.loading import Loading
from femic.contact.motions.none import solve_frictionless
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs import grids as first_touch
from femic.contact.pairs.grids import MOST_STRIPS, contact_size, grids_of, make_sizing
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.patch import MARGIN
from femic.scenes.load import load_scene
from geometries.errors import Failure
from geometries.patches import Grid
from tests.femic.contact.pairs.problems import SMALL, hertz, like_bhat, problem


def test_curvatures_are_taken_at_first_contact_for_any_length_of_contours():
    """Also beyond the wheel, as with a unit of length of a kilometre."""
    ellipse = first_touch.hertz(make_sizing(replace(problem(), reference_length=1e6)).bodies, Loading(SMALL))
    expected = hertz().at_load(SMALL)
    assert (ellipse.a, ellipse.b) == pytest.approx((expected.a, expected.b), rel=1e-2)


def test_grids_fit_their_contacts():
    of = problem(10.2, loads=(5e2, 5e3))
    ((grid, cases),) = make_sizing(of).grids([Loading(load) for load in of.specification.loads])
    assert [case.load for case in cases] == [5e2, 5e3]
    on_grid = pair_on_grid(of, grid)
    small, large = (on_grid.solve_in_place(on_grid.operator("Bhat"), case) for case in cases)
    across = np.count_nonzero(small.in_contact.any(axis=0)), np.count_nonzero(small.in_contact.any(axis=1))
    assert min(across) >= 0.85 * of.specification.elements
    room = grid.n_s - np.count_nonzero(large.in_contact.any(axis=0))
    assert 2 * MARGIN <= room < 0.7 * grid.n_s


def test_loads_that_are_decades_apart_have_grids_of_their_own():
    grids = make_sizing(problem()).grids([Loading(load) for load in (1e-3, 1e3)])
    assert [[case.load for case in cases] for _, cases in grids] == [[1e-3], [1e3]]
    assert max(grid.n_s for grid, _ in grids) <= MOST_STRIPS


def test_sizes_grow_like_hertz_over_ten_decades():
    of = problem()
    for load in (1e-8, 1e-4, 1e0):
        size, expected = contact_size(make_sizing(of).bodies, Loading(load)), hertz(of).at_load(load)
        assert size.x[1] == pytest.approx(expected.a, rel=0.1)
        assert size.s[1] - size.s[0] == pytest.approx(2 * expected.b, rel=0.1)


def test_grids_of_symmetric_pairs_are_symmetric_and_others_lie_about_the_contact():
    ((middle, _),) = make_sizing(problem()).grids([Loading(SMALL)])
    shifted = make_sizing(problem(shift=0.5))
    ((aside, _),) = shifted.grids([Loading(SMALL)])
    assert middle.s == 0.0
    assert aside.s == pytest.approx(shifted.bodies.undeformed.touching[0], abs=2 * aside.ds)


def test_contacts_at_the_end_of_a_contour_are_refused_with_the_end_and_a_remedy():
    of = problem(10.05, 20.0, flanks=False)
    with pytest.raises(
        Failure, match=r"contact at 50000 N: it reaches the end of a contour at s < 0 and s > 0"
    ):
        contact_size(make_sizing(of).bodies, Loading(5e4))


def test_grid_grows_where_c_needs_it(monkeypatch):
    """Of ICs that stand for C and are eight times those of B-hat."""
    of = problem(10.2, loads=(5e3,), ics=("Bhat", "C"))
    ((first, _),) = grids_of(of)
    monkeypatch.setattr("femic.contact.pairs.ics.normal_reference_ics", like_bhat(8.0))
    results = solve_frictionless(of)
    (grid,) = results.references
    assert (grid.dx, grid.ds) == (first.dx, first.ds)
    assert grid.n_x > first.n_x or grid.n_s > first.n_s
    assert {contact.on_grid.grid for contact in results.contacts.values()} == {grid}
    with pytest.raises(Failure, match=r"contact at 5000 N with C: potential contact area"):
        solve_frictionless(problem(10.2, loads=(5e3,), ics=("C",), grid=first))


def test_given_grid_is_used():
    of = problem(loads=(SMALL,), grid=Grid(32, 32, 0.03, 0.01))
    assert {contact.on_grid.grid for contact in solve_frictionless(of).contacts.values()} == {of.grid}


def test_search_for_a_grid_ends_with_a_failure():
    """Of a solver that is never content along x, where no contour ends."""
    sizing = make_sizing(problem(loads=(SMALL,)))

    def short(_):
        raise PotentialAreaTooSmall(("x > 0",), Loading(SMALL))

    with pytest.raises(Failure, match=r"contact at 2 N: no grid found that it fits"):
        sizing.on_long_enough_grid(Grid(16, 16, 0.03, 0.01), short)


def test_an_automatic_grid_has_both_of_two_patches_apart():
    """Each is of Hertz under half of the load, lowered by the other as by a point load on a half-space."""
    scene = load_scene("flat", contacts.bumps(load=200.0, automatic=True))
    apart = replace(scene.contact, extra_gap=contacts.two_bumps())
    on_bumps = replace(scene.contact_problem, specification=apart)
    (solved,) = solve_frictionless(on_bumps).contacts.values()
    hertz = contacts.hertz_bump(on_bumps)
    modulus = combined_modulus(*(body.material for body in on_bumps.bodies.values()))
    assert len(solved.normal.patches) == 2
    assert solved.normal.p.max() == pytest.approx(hertz.p_max, rel=0.01)
    lowered = 100.0 / (np.pi * modulus * contacts.APART)
    assert solved.normal.approach == pytest.approx(hertz.approach + lowered, rel=0.002)
