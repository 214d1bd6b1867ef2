"""The numbers of contacts: moments, the main patch; their estimated errors in each regime of contact."""

from types import SimpleNamespace

import numpy as np
import pytest

from approx.pair import Pair, Solid
from compare.validation.statements.random_contacts import STEEL, RandomContact, frictionless, rolling
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.motions.compression import OF_COMPRESSION
from femic.contact.pairs.grids import contact_size
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.quantities import main_patch
from femic.contact.patch import extents, resultant, section_at
from femic.contact.specification import Profile
from femic.contact.undeformed import Undeformed
from femic.results.friction import compute_with_friction
from geometries.contours import arc
from geometries.patches import Grid
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.pairs.problems import problem
from tests.femic.contact.wheel_on_rail import scene


def test_moments_are_those_of_all_tractions_on_inclined_elements():
    on_grid = pair_on_grid(problem(10.3, shift=0.1), Grid(4, 5, 0.7, 0.9, 1.3))
    p, contour = np.random.default_rng(2).normal(size=(4, 5, 3)), on_grid.undeformed.lower.contour
    total = resultant(p, section_at(contour, on_grid.grid.strips), on_grid.x, on_grid.grid.area)
    for name, axis in (("M_x", 0), ("M_z", 2)):
        moment = OF_COMPRESSION[name].evaluate(on_grid, SimpleNamespace(tractions=p))
        assert moment == pytest.approx(total.moment[axis])


@pytest.mark.parametrize("strips", [slice(None), slice(None, None, -1)], ids=["on the right", "on the left"])
def test_main_patch_carries_the_largest_load(strips):
    """Not the largest, and not the first."""
    p = np.zeros((12, 20))
    p[4:8, 3:9], p[5:7, 12:15] = 1.0, 50.0
    p = p[:, strips]
    contact = SimpleNamespace(pressures=p, patches=extents(p, np.where(p > 0, 0.0, 1.0)))
    assert len(contact.patches) == 2
    low, high = main_patch(contact).s
    assert low > 10 if strips.step is None else high < 9


# ---- estimated errors against elements a third as long: held, and not too wide

FLANK = np.radians(70.0)
USEFUL = 40.0  # an estimate over an error that is no small one by luck


def case(radii, load, *, shift=0.0, gap=None, elements=14, offset=0.2, **rolls):
    """A wheel on a rail, both arcs of some radii [mm], with A, elements across the smallest patch.

    `offset`: of the middle of the grid from that of the patch, in elements.
    """
    rail = Surface(LOWER, arc(radii[0], FLANK, FLANK))
    wheel = Surface(UPPER, arc(radii[1], FLANK, FLANK), radii[2])
    bodies = Undeformed(wheel, rail, (-0.9 * radii[0], 0.9 * radii[0]), shift)
    on_grid = PairOnGrid(Pair(Solid(STEEL, wheel), Solid(STEEL, rail)), bodies, Grid(16, 16, 0.1, 0.1), gap)
    size = contact_size(on_grid, Loading(load))
    dx, ds = (length / elements for length in size.patch)
    n_x, n_s = (
        4 * int(np.ceil(((high - low) / step + 10) / 4)) for (low, high), step in ((size.x, dx), (size.s, ds))
    )
    grid = Grid(n_x, n_s, dx, ds, sum(size.s) / 2 + offset * ds)
    creepages = Creepages(**{name: value for name, value in rolls.items() if name != "friction"})
    bodies = PairOnGrid(on_grid.pair, on_grid.undeformed, grid, gap)
    return RandomContact(bodies, "A", load, rolls.get("friction", 0.0), creepages, free=False, times=3)


def check(comparison, names):
    """Errors are within estimates, which are of use."""
    for name in names:
        ratio = abs(comparison.numbers[name] - comparison.finer[name]) / comparison.estimates[name]
        assert 1 / USEFUL < ratio <= 1, name


def test_lateral_numbers_beside_the_crown_have_errors_though_grids_agree():
    """Three grids agree to 1e-5 of the load in F_y, which finer ones do not."""
    beside = frictionless(case((34.0, 38.0, 500.0), 4e4, shift=-0.16, offset=0.0))
    assert abs(beside.numbers["F_y"] - beside.larger["F_y"]) < 1e-5 * 4e4
    check(beside, ("F_y", "M_x", "s_centre"))
    unknown = {name for name, value in beside.estimates.items() if np.isnan(value)}
    assert unknown == {"load", "position"}  # prescribed


def test_forces_of_full_sliding_where_its_direction_turns_at_the_leading_edge():
    """Slip vanishes beside the leading edge: its elements follow others whose direction is not theirs."""
    turning = rolling(
        case((9.0, 20.7, 460.0), 850.0, friction=0.26, longitudinal=1.7e-3, lateral=3.5e-3, spin=-1.7e-3)
    )
    assert turning.regime == "sliding"
    check(turning, ("F_x", "F_y", "M_z"))


def test_pressures_and_widths_of_two_patches():
    """A hump parts the contact: pressures are steeper than those of one patch, and gaps do not tell edges."""
    s = np.linspace(-0.6, 1.4, 801)
    hump = Profile(s, 0.02 * np.cos(np.pi * (s - 0.4) / 2) ** 2)
    parted = frictionless(case((10.0, 10.6, 450.0), 6e3, gap=hump, elements=10))
    assert parted.regime == "several patches"
    check(parted, ("p_max", "b", "angle", "area", "F_y"))


def test_estimates_of_a_compression_beside_the_crown_are_of_use():
    """Two thirds of F_y are friction on a third of the elements, which could all slide or stick.

    Elements half as long change it by no more than both estimates.
    """
    keys = {"motion": "compression", "loads": [8e4], "friction": [0.3], "ics": ["A"], "shift": 0.03}
    coarse, fine = (
        compute_with_friction(scene(10.2, 500.0, elements=elements, **keys)).isel(friction=0, ics=0, load=0)
        for elements in (8, 16)
    )
    for name in ("F_y", "M_x", "p_max", "sliding_share"):
        assert abs(coarse[name] - fine[name]) <= coarse[f"estimate_{name}"] + fine[f"estimate_{name}"], name
    assert fine["estimate_F_y"] < 0.25 * abs(fine["F_y"])  # it was 0.4: shares of all friction and pressures
    assert fine["estimate_M_z"] < 1e-4 * 8e4  # it vanishes by symmetry along x
