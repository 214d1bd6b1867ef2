"""Compression of scenes: frictionless and sticking limits, steps, estimates, what C changes."""

import numpy as np
import pytest

from femic.contact.loading import Loading
from femic.contact.motions import compression, pair_in_motion
from femic.contact.motions.compression import in_halves
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.rolling import compressed
from femic.results.contact import compute_contact
from femic.results.friction import compute_with_friction
from geometries.errors import Failure
from geometries.patches import Grid, N, S, X
from tests.femic.contact.wheel_on_rail import scene

LOADS = [2e3, 5e3, 1e4]


def pressed(**contact):
    return scene(10.3, **{"motion": "compression", "loads": LOADS} | contact)


@pytest.fixture(scope="module")
def dataset():
    return compute_with_friction(pressed(friction=[1e-4, 0.3, 100.0], ics=["Bhat"]))


def test_without_friction_all_slides_with_frictionless_pressures_and_with_much_nothing_does(dataset):
    least = dataset.sel(friction=1e-4)
    np.testing.assert_allclose(least.sliding_share, 1.0)
    frictionless = compute_contact(scene(10.3, loads=LOADS, ics=["Bhat"]))
    for name in ("approach", "p_max"):
        np.testing.assert_allclose(least[name].values.T, frictionless[name], rtol=0.03)
    np.testing.assert_allclose(dataset.sliding_share.sel(friction=100.0), 0.0)


def test_more_friction_leaves_less_sliding_and_less_approach(dataset):
    assert np.all(np.diff(dataset.sliding_share, axis=0) <= 0)
    approach = dataset.approach.values
    assert np.all(np.diff(approach, axis=0) < 1e-6 * approach.max())  # none where all sticks
    assert np.all(approach[0] > approach[-1])


def test_contact_is_symmetric_carries_the_load_and_grows_with_it(dataset):
    p, delta = dataset.p, dataset.inclination
    vertical = p.sel(direction="n") * np.cos(delta) - p.sel(direction="s") * np.sin(delta)
    area = float(np.diff(dataset.x)[0] * np.diff(dataset.s)[0])
    np.testing.assert_allclose(vertical.sum(["x", "s"]) * area, LOADS[-1], rtol=1e-4)
    np.testing.assert_allclose(p.sel(direction="n"), p.sel(direction="n")[:, :, ::-1, ::-1], atol=1e-3)
    for size in ("angle", "area"):
        assert np.all(dataset[size].diff("load") > 0)


def test_steps_of_load_are_halved_from_zero_on():
    assert in_halves([2.0, 5.0]) == [1.0, 2.0, 3.5, 5.0]


@pytest.mark.parametrize("friction", [0.1, pytest.param(0.2, marks=pytest.mark.slow)])
def test_estimates_bound_the_effect_of_steps_of_load(friction, monkeypatch):
    """Against eight steps in the place of two, on the same elements: sliding is most sensitive to them.

    At half of the load half a step changes it, and this part of the estimate alone bounds what more steps do;
    at the load itself it is the same by luck on these few elements, whose own part is the bound.
    """

    def in_equal_steps(n):
        of = pressed(loads=list(np.linspace(0, 1e4, 1 + n)[1:]), friction=[friction], ics=["Bhat"])
        return compute_with_friction(of).isel(load=[n // 2 - 1, -1], friction=0, ics=0)

    few, many = in_equal_steps(2), in_equal_steps(8)
    by_steps = np.abs(few.sliding_share.values - many.sliding_share.values)
    assert np.all(by_steps > 0.01)
    assert np.all(by_steps < few.estimate_sliding_share)
    monkeypatch.setattr(compression, "changes", lambda _, kinds, __: dict.fromkeys(kinds, 0.0))
    by_elements = in_equal_steps(2).estimate_sliding_share
    assert float((few.estimate_sliding_share - by_elements)[0]) > by_steps[0]


def test_failures_name_friction_ics_and_load(monkeypatch):
    def failing(*_):
        raise Failure("no solution")
        yield

    monkeypatch.setattr("femic.contact.rolling.compressed", failing)
    with pytest.raises(Failure, match=r"friction 0\.2, A, 1000 N: no solution"):
        compute_with_friction(pressed())


def test_ns_matters_in_compression_and_nx_does_not():
    """Tractions along s, by which conforming surfaces resist the approach, cause displacements along n.

    Without them largest pressures are 4 % too large, on both grids; tractions along x hardly arise.
    """
    of = pressed(loads=[8e4], friction=[0.4], ics=["Bhat"])
    on_grid = pair_on_grid(of.contact_problem, Grid(16, 18, 1.3, 1.2))
    p_max = {}
    for left_out in ("nothing", "ns", "nx"):
        ics = approximate_matrix("Bhat", on_grid.pair, on_grid.grid)
        if left_out != "nothing":
            ics[..., N, {"ns": S, "nx": X}[left_out]] = 0.0
        problem = pair_in_motion(of.contact_problem, on_grid).frictional(GridOperator.from_ics(ics), 0.4)
        *_, last = compressed(problem, [Loading(load) for load in (2e4, 4e4, 6e4, 8e4)])
        p_max[left_out] = float(np.max(last.p[..., N]))
    assert p_max["ns"] / p_max["nothing"] > 1.03
    assert p_max["nx"] / p_max["nothing"] == pytest.approx(1.0, abs=1e-3)
