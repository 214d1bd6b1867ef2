"""Grids that fit contacts: sizes, ends of contours, longer grids, and patches beyond the first one."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from compare.validation.extremes.contacts import BUMP_RADIUS, bumps
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.motions.none import solve_frictionless
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs import grids
from femic.contact.pairs.areas import touching_beyond
from femic.contact.pairs.grids import COUNTS, FEWEST, MOST_STRIPS, contact_size, grids_of, make_sizing
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.patch import MARGIN
from femic.contact.specification import Profile
from femic.scenes.load import load_scene
from geometries.errors import Failure
from geometries.patches import Grid
from tests.femic.contact.pairs.problems import RADIUS, SMALL, hertz, like_bhat, problem


def test_curvatures_are_taken_at_first_contact_for_any_length_of_contours():
    """Also beyond the wheel, as with a unit of length of a kilometre."""
    ellipse = grids.hertz(make_sizing(replace(problem(), reference_length=1e6)).bodies, Loading(SMALL))
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
    message = r"contact at 50000 N: it reaches the end of a contour at s < 0 and s > 0"
    with pytest.raises(Failure, match=message):
        contact_size(make_sizing(of).bodies, Loading(5e4))
    with pytest.raises(Failure, match=r"it reaches the end of a contour at s > 0"):  # a second patch
        _ = Bumps(first=0.0, apart=9.95).size


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


def test_search_for_a_grid_ends_with_a_failure():
    """Of a solver that is never content along x, where no contour ends."""
    sizing = make_sizing(problem(loads=(SMALL,)))

    def short(_):
        raise PotentialAreaTooSmall(("x > 0",), Loading(SMALL))

    with pytest.raises(Failure, match=r"contact at 2 N: no grid found that it fits"):
        sizing.on_long_enough_grid(Grid(16, 16, 0.03, 0.01), short)


# ---- patches beyond the first one: bumps of two shapes on a plane, under a roller
# They are so far apart that the load of one lowers the other as a point load on a half-space does.

LOAD = 200.0  # N


@dataclass(frozen=True)
class Bumps:
    """Two bumps: radii along s, distance, and by how much the second is lower [mm]."""

    radii: tuple[float, float] = (40.0, 15.0)
    apart: float = 3.0
    lower_by: float = 0.0
    first: float = -7.0

    @property
    def problem(self):
        """The contact of the roller with both."""
        s = np.linspace(-12.0, 12.0, 12001)
        ends = self.first, self.first + self.apart
        one, other = ((s - end) ** 2 / (2 * radius) for end, radius in zip(ends, self.radii, strict=True))
        scene = load_scene("flat", bumps(load=LOAD, automatic=True))
        gap = Profile(s, np.minimum(one, other + self.lower_by))
        return replace(scene.contact_problem, specification=replace(scene.contact, extra_gap=gap))

    @property
    def modulus(self):
        return combined_modulus(*(body.material for body in self.problem.bodies.values()))

    def alone(self, index, load=LOAD):
        """Hertz of one bump."""
        return PointContact(1 / BUMP_RADIUS, 1 / self.radii[index], self.modulus).at_load(load)

    def lowered(self, load=LOAD):
        """How much the load of one bump lowers the other."""
        return load / (np.pi * self.modulus * self.apart)

    @property
    def just_touching(self):
        """How much lower the second bump may be so that it is just touched by the roller on the first."""
        return self.alone(0).approach - self.lowered()

    @property
    def together(self):
        """Hertz of both bumps, under loads with which the approach of both is the same."""

        def excess(load):
            one = self.alone(0, LOAD - load).approach + self.lowered(load)
            return one - self.alone(1, load).approach - self.lowered(LOAD - load) - self.lower_by

        load = brentq(excess, 1e-6 * LOAD, (1 - 1e-6) * LOAD)
        return self.alone(0, LOAD - load), self.alone(1, load)

    @property
    def size(self):
        return contact_size(make_sizing(self.problem).bodies, Loading(LOAD))

    @property
    def beyond(self):
        """What is touched beyond a grid about the first bump, under the load on it alone."""
        first, bodies = self.alone(0), make_sizing(self.problem).bodies
        grid = Grid(48, 48, 3 * first.a / 48, 3 * first.b / 48, self.first)
        on_grid = replace(bodies, grid=grid)
        return touching_beyond(on_grid, on_grid.solve(on_grid.operator("A"), Loading(LOAD)).normal)


def test_loads_of_two_unlike_patches_are_those_of_equal_approach():
    two = Bumps(lower_by=3e-4)
    (solved,) = solve_frictionless(two.problem).contacts.values()
    contact, (first, second) = solved.normal, two.together
    assert len(contact.patches) == 2
    area = solved.on_grid.grid.area
    loads = sorted(float(np.sum(contact.p[patch.elements])) * area for patch in contact.patches)
    assert loads == pytest.approx([second.load, first.load], rel=0.01)
    assert second.load < 0.65 * first.load
    assert contact.p.max() == pytest.approx(max(first.p_max, second.p_max), rel=0.02)
    assert contact.approach == pytest.approx(first.approach + two.lowered(second.load), rel=0.005)


def test_size_covers_both_patches_and_knows_the_smaller_one():
    two = Bumps(lower_by=3e-4)
    first, second = two.together
    size, strip = two.size, 2 * second.b / FEWEST
    assert size.s == pytest.approx((two.first - first.b, two.first + two.apart + second.b), abs=strip)
    assert size.x[1] == pytest.approx(max(first.a, second.a), rel=0.1)
    smaller = 2 * min(first.a, second.a), 2 * min(first.b, second.b)
    assert size.patch == pytest.approx(smaller, rel=0.15)
    assert smaller[1] < 0.7 * 2 * max(first.b, second.b)


@pytest.mark.parametrize("lower_by", [0.0, -1e-3])
def test_second_patch_may_be_longer_and_far_narrower(lower_by):
    """The first is wide, the second a ridge, a fourteenth to an eleventh as wide, which may be higher."""
    two = Bumps(radii=(400.0, 4.0), apart=6.0, lower_by=lower_by)
    first, second = two.together
    assert second.a > 1.25 * two.alone(0).a
    assert second.b < 0.1 * first.b
    size = two.size
    assert size.x[1] == pytest.approx(second.a, rel=0.1)
    assert size.patch == pytest.approx((2 * first.a, 2 * second.b), rel=0.2)


@pytest.mark.parametrize(("share", "touched"), [(1.02, False), (0.98, True)])
def test_bump_that_is_almost_touched_is_not_included(share, touched):
    """By 2 % of its depth; without what the first load lowers it, it would seem to be touched until 1.06."""
    two = Bumps()
    two = replace(two, lower_by=share * two.just_touching)
    assert two.lowered() > 0.05 * two.just_touching
    assert bool(two.beyond.size) == touched
    assert (two.size.s[1] > two.first + two.apart - 0.1) == touched


def test_what_is_touched_beyond_is_a_parabola_cut_off():
    two = Bumps()
    two = replace(two, lower_by=0.9 * two.just_touching)
    beyond = two.beyond
    half = np.sqrt(2 * two.radii[1] * 0.1 * two.just_touching)
    assert (beyond[0] + beyond[-1]) / 2 == pytest.approx(two.first + two.apart, abs=0.2 * half)
    assert np.ptp(beyond) / 2 == pytest.approx(half, rel=0.1)


def test_small_patches_do_not_make_elements_smaller():
    """The second carries too little: elements are those for the first."""
    two = Bumps()
    two = replace(two, lower_by=0.85 * two.just_touching)
    first, second = two.together
    assert second.load < 0.5 * COUNTS * LOAD
    size = two.size
    assert size.s[1] > two.first + two.apart
    assert size.patch == pytest.approx((2 * first.a, 2 * first.b), rel=0.1)


@pytest.mark.parametrize("shift", [0.0, 0.1])
def test_contact_with_one_patch_has_the_size_that_it_has_alone(shift, monkeypatch):
    """Neither does a place without a patch change it."""
    bodies = make_sizing(problem(10.4, shift=shift)).bodies
    for load in (SMALL, 3e3):
        assert contact_size(bodies, Loading(load)) == contact_size(bodies, Loading(load), all_patches=False)
    monkeypatch.setattr(grids, "touching_beyond", lambda *_: np.array([-4.0, 4.0]))
    assert contact_size(bodies, Loading(5.0)) == contact_size(bodies, Loading(5.0), all_patches=False)


@pytest.mark.parametrize("approach", [0.03, 0.05])
def test_without_a_load_what_is_touched_is_where_two_circles_overlap(approach):
    """A groove that is lowered onto an arc, to first order of the approach over the radius."""
    groove = 10.1
    bodies = make_sizing(problem(groove)).bodies
    on_grid = replace(bodies, grid=Grid(8, 8, 0.1, 0.1))
    nearly_none = SimpleNamespace(p=np.full((8, 8), 1e-12), approach=approach)
    beyond = touching_beyond(on_grid, nearly_none)
    apart = groove - RADIUS + approach
    angle = np.arccos((groove**2 - RADIUS**2 - apart**2) / (2 * RADIUS * apart))
    assert (beyond[0], beyond[-1]) == pytest.approx((-RADIUS * angle, RADIUS * angle), rel=0.01)
    assert np.min(np.abs(beyond)) == pytest.approx(0.4, abs=0.05)
    assert angle > np.radians(30)


@pytest.mark.parametrize(("load", "alone"), [(50.0, True), (2000.0, False)])
def test_patches_on_the_other_side_are_found_alike(load, alone):
    """Of a symmetric pair with a bump on one flank, and on the other; the bump may bear all of the load."""
    s = np.linspace(-12.0, 12.0, 2401)

    def size(place, load):
        gap = Profile(s, np.minimum((s - place) ** 2 / 4 - 0.06, 0.0))
        return contact_size(make_sizing(problem(10.4, extra_gap=gap)).bodies, Loading(load))

    left, right = (size(place, load) for place in (-5.0, 5.0))
    assert right.s[1] > 5.0
    assert (right.s[0] > 4.0) == alone
    assert left.s == pytest.approx((-right.s[1], -right.s[0]), abs=0.02)
    assert left.patch == pytest.approx(right.patch, rel=0.05)
