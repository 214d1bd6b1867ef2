"""Estimates of what scenes with friction give: parts are all there, curves are apart by what is said."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from femic.contact.datasets import OF_UNKNOWN_EDGE
from femic.contact.estimates import SAFETY, Measured
from femic.contact.motions.compression import OF_COMPRESSION
from femic.contact.motions.rolling import OF_CURVE, OF_ROLLING, between, curve_distances, deciding_creepages
from femic.results.friction import compute_with_friction
from tests.femic.contact.wheel_on_rail import REFERENCE_ICS, bhat_as_c, scene

XI = [-1e-3, 0.0, 2e-3]
LOAD_OF_SCENE, FRICTION_OF_SCENE, EQUAL = 1e4, 0.3, 0.3


@pytest.fixture(scope="module")
def solved():
    """Datasets by motion and the estimate of what stands for C."""
    datasets, patch = {}, pytest.MonkeyPatch()
    common = {"loads": [LOAD_OF_SCENE], "friction": [FRICTION_OF_SCENE], "ics": ["C"], "elements": 8}
    common["shift"] = 0.05
    motions = {"rolling": {"longitudinal": XI, "equal_force": EQUAL}, "compression": {}}
    for share in (0.0, 0.04):
        patch.setattr(REFERENCE_ICS, bhat_as_c(share))
        for motion, keys in motions.items():
            of = scene(10.3, motion=motion, **common, **keys)
            datasets[motion, share] = compute_with_friction(of).isel(friction=0, ics=0)
    patch.undo()
    return datasets


@pytest.mark.parametrize(("motion", "names"), [("rolling", OF_ROLLING), ("compression", OF_COMPRESSION)])
def test_the_estimate_of_c_is_added_at_all_creepages_and_loads(solved, motion, names):
    """ICs larger by 4 % change the approach by 2.4 % or more; the other parts stay as they are."""
    with_it, without = solved[motion, 0.04], solved[motion, 0.0]
    added = with_it.estimate_approach - without.estimate_approach
    assert np.all((added > 0.02 * with_it.approach) & (added < 0.05 * with_it.approach))
    for name in names:
        assert np.all(without[f"estimate_{name}"] > 0), name
        assert np.all(with_it[f"estimate_{name}"] > 0), name
    for name in OF_COMPRESSION:
        assert np.all(with_it[f"estimate_{name}"] >= without[f"estimate_{name}"]), name


def test_estimates_of_creepages_and_slopes_include_the_change_by_c(solved):
    """Softer bodies have flatter curves: by about as much as ICs are larger."""
    with_it, without = (solved["rolling", share] for share in (0.04, 0.0))
    for name in OF_CURVE:
        assert 0 < float(without[f"estimate_{name}"]) < float(with_it[f"estimate_{name}"]), name
    added = float(with_it.estimate_slope - without.estimate_slope)
    assert 0.01 * abs(float(with_it.slope)) < added < 0.08 * abs(float(with_it.slope))
    assert -0.08 < float(with_it.change_slope / with_it.slope) < -0.01


def test_changes_are_solved_at_the_creepage_nearest_0_and_at_the_largest_forces():
    forces = {-3e-3: -80.0, -1e-3: -90.0, 2e-4: 5.0, 1e-3: 60.0, 4e-3: 59.0}
    points = {xi: Measured({"F_x": force}, {}, {}) for xi, force in forces.items()}
    assert deciding_creepages(SimpleNamespace(points=points)) == [-1e-3, 2e-4, 1e-3]


def test_changes_are_linear_between_creepages_and_constant_beyond():
    rows = {xi: dict.fromkeys(OF_ROLLING, value) for xi, value in ((0.0, 1.0), (2.0, 4.0))}
    assert [between(rows, xi)["F_y"] for xi in (-1.0, 0.0, 1.0, 2.0, 3.0)] == [1.0, 1.0, 2.5, 4.0, 4.0]
    assert np.isnan(between({}, 0.0)["F_x"])


def vertical(p, inclination):
    """The vertical component of tractions [MPa]."""
    return p.sel(direction="n") * np.cos(inclination) - p.sel(direction="s") * np.sin(inclination)


@pytest.mark.parametrize("motion", ["rolling", "compression"])
@pytest.mark.parametrize("share", [0.0, 0.04])
def test_tractions_on_larger_elements_carry_the_same_forces(solved, motion, share):
    """Solutions are accurate to 1e-6 of the largest pressure; those with coarse starts to less.

    The first order alone: what is estimated is more than the change from one grid to the next.
    """
    of = solved[motion, share]
    p, area = of.larger_p, float(np.diff(of.larger_x)[0] * np.diff(of.larger_s)[0])
    inclination = of.inclination.coarsen(s=2).mean().rename(s="larger_s")
    assert p.sizes["larger_x"] == of.sizes["x"] / 2
    assert float(vertical(p, inclination).sum()) * area == pytest.approx(LOAD_OF_SCENE, rel=1e-4)
    if motion == "rolling":
        force = EQUAL * FRICTION_OF_SCENE * LOAD_OF_SCENE
        assert float(p.sel(direction="x").sum()) * area == pytest.approx(force, rel=1e-3)
    if share == 0.0:
        for name in ("F_x", "approach") if motion == "rolling" else ("approach",):
            apart = abs(of[name] - of[f"larger_{name}"])
            assert np.all((apart > 0) & (apart < 2 * of[f"estimate_{name}"])), name


@pytest.mark.parametrize("motion", ["rolling", "compression"])
def test_softer_bodies_have_a_larger_approach_and_the_same_forces(solved, motion):
    """ICs larger by 4 % in both: the approach grows by 2.4 % or more, and pressures spread."""
    of = solved[motion, 0.04]
    assert np.all((of.change_approach > 0.02 * of.approach) & (of.change_approach < 0.05 * of.approach))
    assert np.all(of.change_p_max < 0)
    carried, changed = (float(vertical(p, of.inclination).sum()) for p in (of.p, of.change_p))
    assert abs(changed) < 1e-4 * carried
    assert float(abs(of.change_p).max()) > 1e-3 * float(of.p.max())
    if motion == "rolling":
        change, given = (float(of[name].sel(direction="x").sum()) for name in ("change_p", "p"))
        assert abs(change) < 1e-3 * abs(given)


# --- distances of curves --------------------------------------------------------------------------------

FRICTION, LOAD = [0.2, 0.5], 1e3
SCALE = np.array(FRICTION)[:, None] * LOAD


def curves(force, larger=None, change=None):
    """A dataset of creep-force curves (friction, ics, xi); no errors where none are given."""
    coords = {"friction": FRICTION, "ics": ["A", "C"], "xi": np.arange(force.shape[-1])}
    larger, change = force if larger is None else larger, 0 * force if change is None else change
    of = {"F_x": force, "larger_F_x": larger, "change_F_x": change}
    return xr.Dataset({n: (("friction", "ics", "xi"), v) for n, v in of.items()}, coords, {"load": LOAD})


def beside_itself(of, name):
    """The estimate of a distance without the share of itself that elements may miss."""
    return of[f"estimate_{name}"] - OF_UNKNOWN_EDGE * of[name]


def sizes(away):
    """Root mean square and largest distance by friction of differences (friction, xi) in N."""
    return {
        "rms": np.sqrt(np.mean((away / SCALE) ** 2, axis=-1)),
        "largest": np.max(np.abs(away / SCALE), axis=-1),
    }


def random_errors(seed):
    """Exact curves (friction, ics, xi), and errors per size of elements, comparable with distances."""
    random = np.random.default_rng(seed)
    return random.normal(size=(2, 2, 7)) * 100, random.normal(size=(2, 2, 7)) * 60


@pytest.mark.parametrize("common", [0.0, 1.0])
def test_distances_of_curves_are_root_mean_squares_and_maxima_whatever_error_all_have_in_common(common):
    """F(h) = F + c h with the same c of both, h = 1 and 2."""
    force, c = random_errors(3)
    alike = common * c[:, :1]
    of = curve_distances(curves(force + alike, larger=force + 2 * alike))
    for name, size in sizes(force[:, 0] - force[:, 1]).items():
        np.testing.assert_allclose(of[name].sel(ics="A"), size)
        assert np.all(of[name].sel(ics="C") == 0)
        np.testing.assert_allclose(beside_itself(of, name), 0.0, atol=1e-12)
    assert of["largest"].attrs["long_name"] == (
        "largest difference from the reference curve, relative to friction times load"
    )


@pytest.mark.parametrize("seed", range(20))
def test_estimates_bound_errors_of_the_first_order_also_where_differences_change_their_sign(seed):
    """F(h) = F + c h, h = 1 and 2: the differences of curves are off by the difference of c at most."""
    force, c = random_errors(seed)
    of, true = curve_distances(curves(force + c, larger=force + 2 * c)), sizes(force[:, 0] - force[:, 1])
    for name, size in sizes(c[:, 0] - c[:, 1]).items():
        estimate = of[f"estimate_{name}"]
        assert np.all(abs(of[name].sel(ics="A") - true[name]) <= estimate.sel(ics="A"))
        np.testing.assert_allclose(beside_itself(of, name).sel(ics="A"), SAFETY * size)
        assert np.all(estimate.sel(ics="C") == 0)


def test_a_change_of_c_alone_counts_as_much_as_it_changes_distances_beside_elements():
    (force, change), (_, c) = random_errors(5), random_errors(8)
    change[:, 0] = 0.0
    of = curve_distances(curves(force, change=change))
    for name, size in sizes(change[:, 1]).items():
        np.testing.assert_allclose(beside_itself(of, name).sel(ics="A"), size)
        assert np.all(of[f"estimate_{name}"].sel(ics="C") == 0)
        for sign in (1, -1):
            moved = curve_distances(curves(force + sign * change))[name]
            assert np.all(abs(moved - of[name]) <= of[f"estimate_{name}"] + 1e-12)
    both, by_elements = (curve_distances(curves(force, c, one)) for one in (change, None))
    parts = [beside_itself(one, "rms") for one in (by_elements, of)]
    np.testing.assert_allclose(beside_itself(both, "rms"), sum(parts))


def test_creepages_without_contact_do_not_count_in_distances():
    force = np.ones((2, 2, 3)) * [[[1.0], [3.0]]]
    larger = force + np.array([[[0.0], [1.0]]])
    force[:, 0, 1] = larger[:, 0, 1] = larger[:, 1, 2] = np.nan
    of = curve_distances(curves(force, larger))
    np.testing.assert_allclose(of["rms"].sel(ics="A"), 2 / np.array([200, 500]))
    np.testing.assert_allclose(beside_itself(of, "rms").sel(ics="A"), SAFETY / np.array([200, 500]))


@pytest.mark.parametrize("unknown", ["larger", "change"])
def test_curves_of_unknown_errors_have_distances_without_estimates(unknown):
    """Except the reference, which is no distance from itself."""
    force = np.ones((2, 2, 3))
    of = curve_distances(curves(force, **{unknown: np.full_like(force, np.nan)}))
    for name in ("rms", "largest"):
        assert np.all(of[name] == 0)
        assert np.all(np.isnan(of[f"estimate_{name}"].sel(ics="A")))
        assert np.all(of[f"estimate_{name}"].sel(ics="C") == 0)
