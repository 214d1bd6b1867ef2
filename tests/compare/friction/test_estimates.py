"""Estimates of what scenes with friction give: parts are all there, curves are apart by what is said."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from compare.friction.compute import compute_with_friction
from compare.friction.rolling import _distances
from femic.contact.estimates import Measured
from femic.contact.pairs.quantities import OF_COMPRESSION, OF_CURVE, OF_ROLLING
from femic.contact.pairs.solved_curve import between, deciding
from tests.compare.friction.scenes import REFERENCE_ICS, bhat_as_c, scene

XI = [-1e-3, 0.0, 2e-3]


@pytest.fixture(scope="module")
def solved():
    """Datasets by motion and the estimate of what stands for C."""
    datasets, patch = {}, pytest.MonkeyPatch()
    common = {"loads": [1e4], "friction": [0.3], "ics": ["C"], "elements": 8, "shift": 0.05}
    motions = {"rolling": {"longitudinal": XI, "equal_force": 0.3}, "compression": {}}
    for share in (0.0, 0.04):
        patch.setattr(REFERENCE_ICS, bhat_as_c(share))
        for motion, keys in motions.items():
            of = scene(10.3, motion=motion, **common, **keys)
            datasets[motion, share] = compute_with_friction(of).isel(friction=0, ics=0)
    patch.undo()
    return datasets


def test_the_estimate_of_c_is_added_at_all_creepages_and_loads(solved):
    """ICs larger by 4 % change the approach by 2.4 % or more; the other parts stay as they are."""
    for motion in ("rolling", "compression"):
        with_it, without = solved[motion, 0.04], solved[motion, 0.0]
        added = with_it.estimate_approach - without.estimate_approach
        assert np.all(added > 0.02 * with_it.approach), motion
        assert np.all(added < 0.05 * with_it.approach), motion
        for name in OF_COMPRESSION:
            assert np.all(with_it[f"estimate_{name}"] >= without[f"estimate_{name}"]), name


def test_estimates_of_creepages_and_slopes_include_the_change_by_c(solved):
    """Softer bodies have flatter curves: by about as much as ICs are larger."""
    with_it, without = (solved["rolling", share] for share in (0.04, 0.0))
    for name in OF_CURVE:
        assert float(without[f"estimate_{name}"]) > 0
        assert float(with_it[f"estimate_{name}"]) > float(without[f"estimate_{name}"]), name
    added = float(with_it.estimate_slope - without.estimate_slope)
    assert 0.01 * abs(float(with_it.slope)) < added < 0.08 * abs(float(with_it.slope))


def test_all_estimates_are_positive(solved):
    for (motion, _), dataset in solved.items():
        names = OF_ROLLING if motion == "rolling" else OF_COMPRESSION
        for name in names:
            assert np.all(dataset[f"estimate_{name}"] > 0), (motion, name)


def test_changes_are_solved_at_the_creepage_nearest_0_and_at_the_largest_forces():
    forces = {-3e-3: -80.0, -1e-3: -90.0, 2e-4: 5.0, 1e-3: 60.0, 4e-3: 59.0}
    points = {xi: Measured({"F_x": force}, {}, {}) for xi, force in forces.items()}
    assert deciding(SimpleNamespace(points=points)) == [-1e-3, 2e-4, 1e-3]


def test_changes_are_linear_between_creepages_and_constant_beyond():
    rows = {xi: dict.fromkeys(OF_ROLLING, value) for xi, value in ((0.0, 1.0), (2.0, 4.0))}
    assert [between(rows, xi)["F_y"] for xi in (-1.0, 0.0, 1.0, 2.0, 3.0)] == [1.0, 1.0, 2.5, 4.0, 4.0]
    assert np.isnan(between({}, 0.0)["F_x"])


# --- distances of curves --------------------------------------------------------------------------------


def curves(force, known, ics=("A", "C")):
    """A dataset of creep-force curves (friction, ics, xi)."""
    coords = {"friction": [0.2, 0.5], "ics": list(ics), "xi": np.arange(force.shape[-1])}
    dims = ("friction", "ics", "xi")
    return xr.Dataset({"F_x": (dims, force), "estimate_F_x": (dims, known)}, coords, {"load": 1e3})


def test_estimates_of_distances_bound_them_and_are_nearly_reached():
    """Whatever errors both curves have within their estimates; and some of them change it that much."""
    random = np.random.default_rng(3)
    force, known = random.normal(size=(2, 2, 7)) * 100, random.random((2, 2, 7)) * 20
    of = _distances(curves(force, known))
    away = force[:, 0] - force[:, 1]
    ways = [random.uniform(-1, 1, (2, 2, 7)) for _ in range(10)]
    ways.append(np.sign(away)[:, None] * np.array([1, -1])[:, None])
    moved = [_distances(curves(force + known * way, known)) for way in ways]
    for name in ("rms", "largest"):
        allowed = of[f"estimate_{name}"].sel(ics="A") + 1e-12
        changes = [abs(one[name] - of[name]).sel(ics="A") for one in moved]
        assert all(np.all(change <= allowed) for change in changes)
        assert np.all(changes[-1] > 0.3 * allowed)
        assert np.all(of[name].sel(ics="C") == 0)
        assert np.all(of[f"estimate_{name}"].sel(ics="C") == 0)
    scale = np.array([[0.2], [0.5]]) * 1e3
    np.testing.assert_allclose(of["largest"].sel(ics="A"), np.max(np.abs(away) / scale, axis=1))
    np.testing.assert_allclose(of["rms"].sel(ics="A"), np.sqrt(np.mean((away / scale) ** 2, axis=1)))
    assert of["largest"].attrs["long_name"] == (
        "largest distance to the reference's curve over friction times load"
    )


def test_creepages_without_contact_do_not_count_in_distances():
    force, known = np.ones((2, 2, 3)) * [[[1.0], [3.0]]], np.ones((2, 2, 3))
    force[:, 0, 1] = known[:, 0, 1] = np.nan
    of = _distances(curves(force, known))
    np.testing.assert_allclose(of["rms"].sel(ics="A"), 2 / np.array([200, 500]))
    np.testing.assert_allclose(of["estimate_rms"].sel(ics="A"), 2 / np.array([200, 500]))


def test_curves_without_estimates_have_distances_without_estimates():
    of = _distances(curves(np.ones((2, 2, 3)), np.full((2, 2, 3), np.nan)))
    assert np.all(np.isnan(of["estimate_rms"].sel(ics="A")))
    assert np.all(np.isnan(of["estimate_largest"].sel(ics="A")))
