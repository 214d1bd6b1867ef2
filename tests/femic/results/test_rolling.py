"""Rolling of scenes: Kalker's slope and full slip at small loads, prescribed forces, estimates, C in it."""

import numpy as np
import pytest

from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion, solve_with_friction
from femic.contact.motions.rolling import Continuation, scaled_force
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.ics import approximation
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.results.friction import compute_with_friction
from geometries.errors import Failure
from geometries.materials import both_bodies
from geometries.patches import Grid
from tests.femic.contact.wheel_on_rail import REFERENCE_ICS, bhat_as_c, scene

SMALL = 2.0  # N: a patch of a degree in all
XI = [-2e-3, 0.0, 2e-3]


def rolls(upper_radius=14.0, **contact):
    return scene(upper_radius, **{"motion": "rolling", "loads": [SMALL], "longitudinal": XI} | contact)


@pytest.fixture(scope="module")
def small():
    """A small contact, hardly inclined: what half-spaces do."""
    return compute_with_friction(rolls(friction=[0.3], elements=14))


def test_small_contacts_have_the_slope_of_kalker(small):
    """The creep-force slope without force is G a b C11, where nearly all sticks."""
    of_bhat = small.sel(ics="Bhat", friction=0.3)
    at = of_bhat.isel(xi=1)
    G = both_bodies(*[rolls().bodies[name].material for name in ("upper", "lower")]).G
    c11 = creepage_coefficients(float(at.a), float(at.b), 0.3, degree=12).C11
    expected = G * float(at.a * at.b) * c11
    assert float(of_bhat.slope) == pytest.approx(expected, rel=0.05)


def test_small_contacts_slide_fully_at_large_creepages_with_all_ics_alike(small):
    force = scaled_force(small).sel(friction=0.3)
    np.testing.assert_allclose(force.isel(xi=-1), 1.0, atol=2e-3)
    np.testing.assert_allclose(small.sliding_share.isel(xi=-1), 1.0)
    np.testing.assert_allclose(force.isel(xi=0), -force.isel(xi=-1), atol=2e-3)
    assert float(small.rms.max()) < 5e-3
    assert float(small.rms.sel(ics="Bhat").max()) == 0.0


def test_tractions_are_compared_at_the_specified_force(small):
    area = float(np.diff(small.x)[0] * np.diff(small.s)[0])
    force = small.p.sel(direction="x").sum(["x", "s"]) * area
    np.testing.assert_allclose(force / (0.3 * SMALL), 0.5, rtol=1e-3)
    assert np.all(small.equal_creepage > small.zero_creepage)


def test_tractions_obey_coulombs_law(small):
    p_t, p_n = small.p.sel(direction=["x", "s"]).values, small.p.sel(direction="n").values
    size = np.linalg.norm(p_t, axis=-1)
    tolerance = 1e-3 * p_n.max()
    assert np.all(size <= 0.3 * p_n + tolerance)
    slides = (p_n > 0) & ~small.stick.values
    np.testing.assert_allclose(size[slides], 0.3 * p_n[slides], atol=tolerance)
    assert np.all(small.friction_factor == 1.0)
    assert small.attrs["friction_by_angle"] == ""


@pytest.fixture(scope="module")
def conforming():
    """A patch over tens of degrees by A, B-hat, and the matrix of B-hat in the place of C."""
    of = rolls(
        10.3, loads=[1e4], friction=[0.3], elements=8, ics=["A", "Bhat", "C"], longitudinal=[-1e-3, 0.0, 1e-3]
    )
    patch = pytest.MonkeyPatch()
    patch.setattr(REFERENCE_ICS, bhat_as_c())
    yield of, compute_with_friction(of)
    patch.undo()


def test_fast_operators_and_matrices_give_the_same_curve(conforming):
    """A matrix has the curvature of the wheel along x, which fast operators leave out."""
    _, dataset = conforming
    distances = dataset.isel(friction=0)
    assert float(distances.rms.sel(ics="Bhat")) < 0.03
    assert float(distances.rms.sel(ics="Bhat")) < float(distances.rms.sel(ics="A"))
    force = scaled_force(distances)
    for name in ("A", "Bhat", "C"):
        away = np.abs(force.sel(ics=name).values - force.sel(ics="C").values)
        assert float(distances.largest.sel(ics=name)) == pytest.approx(np.max(away))
        assert float(distances.rms.sel(ics=name)) == pytest.approx(np.sqrt(np.mean(away**2)))


class Searching(Continuation):
    """A creep-force curve on which no contact is found with a prescribed force."""

    def solve(self, xi, before, force=None):
        if force is not None:
            raise Failure("not found")
        return super().solve(xi, before)


def searching(pair):
    return Searching(pair, pair.rolling(pair.frictional(approximation(pair.on_grid, "A"), 0.3)), "A")


def test_search_over_creepages_agrees_with_prescribed_forces(conforming):
    of, dataset = conforming
    steps = [float(np.diff(dataset[name])[0]) for name in ("x", "s")]
    on_grid = pair_on_grid(of.contact_problem, Grid(dataset.sizes["x"], dataset.sizes["s"], *steps))
    along = searching(pair_in_motion(of.contact_problem, on_grid))
    searched = along.with_force(0.0, [along.first()])
    expected = float(dataset.zero_creepage.sel(ics="A")[0])
    assert searched.creepages.longitudinal == pytest.approx(expected, abs=1e-6)


def test_numbers_have_no_estimates_where_larger_elements_have_no_solution(monkeypatch):
    labels = []

    def failing(_, __, label):
        labels.append(label)
        raise Failure("no contact")

    monkeypatch.setattr("femic.contact.motions.rolling._curve", failing)
    dataset = compute_with_friction(rolls(friction=[0.3], ics=["A"], longitudinal=[-1e-3, 0.0, 1e-3]))
    assert labels == [f"friction 0.3, A, {words} elements" for words in ("larger", "still larger")]
    assert np.all(np.isnan(dataset.estimate_F_x))
    assert not np.any(np.isnan(dataset.F_x))


def test_forces_beyond_the_curve_are_refused():
    of = rolls(friction=[0.3], ics=["A"], longitudinal=[0.0, 5e-5], equal_force=0.9)
    along = solve_with_friction(of.contact_problem, searching)
    with pytest.raises(Failure, match=r"F_x = .* N lies beyond the curve; give a wider range of creepages"):
        along.with_force(0.9 * along.largest, [along.first()])


def test_short_grids_are_made_longer_unless_the_scene_gives_them():
    tried = []

    def short_at_first(pair):
        tried.append(pair.on_grid.grid)
        if len(tried) == 1 or not pair.problem.specification.automatic:
            raise PotentialAreaTooSmall(("x > 0",), Loading(SMALL))
        return "done"

    assert solve_with_friction(rolls().contact_problem, short_at_first) == "done"
    assert tried[1].n_x > tried[0].n_x
    with pytest.raises(Failure, match=r"contact at 2 N: potential contact area"):
        solve_with_friction(rolls(grid="scene").contact_problem, short_at_first)


def test_files_have_the_factors_of_friction_and_tractions_within_them():
    """Friction of the contact in the middle by far larger than beside it."""
    law = {"friction_by_angle": [[5, 1.0], [15, 0.25]], "equal_force": 0.3, "ics": ["A"]}
    of = rolls(10.3, loads=[1e4], longitudinal=[-4e-3, 0.0, 4e-3], friction=[0.3], **law)
    flanged = compute_with_friction(of)
    angle = np.degrees(np.abs(flanged.inclination))
    np.testing.assert_allclose(flanged.friction_factor, np.interp(angle, [5, 15], [1.0, 0.25]))
    said = "multiplied by a factor that depends on the contact angle: 1 at 5°, 0.25 at 15°, linear"
    assert said in str(flanged.attrs["friction_by_angle"])
    pressure = flanged.p.sel(direction="n")
    tangential = np.hypot(flanged.p.sel(direction="x"), flanged.p.sel(direction="s"))
    share = (tangential / (0.3 * pressure)).where(pressure > 0)
    assert np.all((share <= flanged.friction_factor * (1 + 1e-5)) | np.isnan(share))
    assert float(share.max()) > 0.5
