"""What supports do to a contact: flatter flanks, which contacts are solved again, what the dataset says."""

from dataclasses import replace

import numpy as np
import pytest

from approx.pair import matrix
from femic.contact.motions.compression import OF_COMPRESSION
from femic.contact.motions.rolling import OF_ROLLING
from femic.contact.operators.dense import Asymmetry, GridOperator
from femic.contact.pairs.ics import ReferenceICs
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.contact.supports import (
    FLATTER,
    NEARER,
    changed_supports,
    flatter_problem,
    with_flatter_flanks,
)
from femic.reference.run_options import RunOptions
from femic.results.contact import solve_scene, to_dataset, with_supports
from femic.results.friction import compute_with_friction
from femic.results.friction import with_supports as with_supports_of_motion
from geometries.contours import arc, ellipse, through_points
from geometries.patches import N
from tests.femic.contact.wheel_on_rail import SAME, SOFTER, bhat_in_place_of_c, scene

FIVE = np.radians(5.0)
SUPPORTS = "femic.contact.supports"


@pytest.mark.parametrize("contour", [arc(10.0, 1.1, 0.9), ellipse(8.0, 12.0, 0.7, 1.2)])
def test_flatter_flanks_begin_where_the_core_inclines_by_as_much_less(contour):
    flatter = with_flatter_flanks(contour)
    ends = np.abs([contour.inclination(np.array(s)) for s in contour.limits])
    inclinations = np.abs([flatter.inclination(np.array(s)) for s in flatter.limits])
    np.testing.assert_allclose(inclinations, ends - FIVE, atol=2e-3)
    inner = np.linspace(*flatter.limits, 7)
    np.testing.assert_array_equal(flatter.position(inner), contour.position(inner))


def test_contours_through_points_have_no_flatter_flanks():
    y = np.linspace(-6, 6, 13)
    contour = through_points(y, -0.03 * y**2, 0.0)
    assert np.all(np.isfinite(contour.extent))
    of = scene(10.3, loads=[1e3])
    bodies = {name: replace(body, contour=contour) for name, body in of.bodies.items()}
    assert flatter_problem(replace(of.contact_problem, bodies=bodies)) is None


@pytest.fixture
def normal_in_place_of_c(monkeypatch):
    """C_nn is that of B-hat, 10 % more with a nearer far arc, and 20 % more with flatter flanks."""

    def stiffer(on_grid, factor):
        nn = matrix("Bhat", on_grid.pair, on_grid.grid)[..., 2:, 2:]
        return GridOperator.from_ics(factor * nn, (N,))

    def reference(_, on_grid, __):
        return ReferenceICs(*[stiffer(on_grid, 1.0)] * 2, 0.0, Asymmetry(0.0, "nn"), 1.0, 0.0)

    monkeypatch.setattr("femic.contact.pairs.ics.normal_reference_ics", reference)
    monkeypatch.setattr(f"{SUPPORTS}.matrices", lambda *_, **__: {})
    monkeypatch.setattr(
        f"{SUPPORTS}.pair_operator",
        lambda _, on_grid, __, variation, **___: stiffer(on_grid, 1.1 if variation else 1.2),
    )


@pytest.mark.usefixtures("normal_in_place_of_c")
def test_c_with_flatter_flanks_is_solved_where_the_contact_is_not_symmetric():
    for shift, names in ((0.0, [NEARER]), (0.05, [NEARER, FLATTER])):
        given = scene(10.3, loads=[1e3, 5e3], ics=["C"], shift=shift)
        solved = solve_scene(given)
        changes = changed_supports(solved)
        assert list(changes) == names
        dataset = with_supports(to_dataset(given, solved), changes)
        assert list(dataset.supports.values) == names
        assert {f"supported_{name}" for name in OF_FRICTIONLESS} <= {*dataset.data_vars}
        largest = dataset.isel(case=int(dataset.attrs["supported_case"])).sel(ics="C")
        assert float(largest["load"]) == pytest.approx(5e3)
        assert np.all(dataset.supported_approach.values > 1.05 * float(largest.approach))


# ---- with friction

ROLLING = {"motion": "rolling", "loads": [2e3], "longitudinal": [1e-4, 2e-3], "ics": ["C"], "friction": [0.2]}
COMPRESSION = {"motion": "compression", "loads": [1e3, 2e3], "friction": [0.5, 0.2], "ics": ["A", "C"]}
TRANSIENT = {"motion": "transient", "loads": [2e3], "creepage": 1e-3, "distance": 2.0, "ics": ["A", "C"]}


@pytest.mark.parametrize(
    ("keys", "place", "quantities"),
    [
        pytest.param(ROLLING, {"xi": 1e-4}, OF_ROLLING, id="rolling"),
        pytest.param(COMPRESSION, {"load": 2e3}, OF_COMPRESSION, id="compression"),
        pytest.param(TRANSIENT | {"friction": [0.5]}, None, ["F_x", "approach"], id="transient"),
    ],
)
def test_one_contact_of_a_motion_is_solved_with_other_supports(keys, place, quantities):
    """That of the least friction, at the creepage nearest 0, the last load or distance.

    With the same supports it is the one of the arrays; the patch on softer ones grows, too.
    """
    of = scene(13.0, **{"shift": 0.1} | keys)
    with bhat_in_place_of_c():
        dataset = with_supports_of_motion(of, compute_with_friction(of), RunOptions(1))
    place = place or {"distance": float(dataset.distance[-1])}
    given = {"friction": min(keys["friction"])} | place
    assert {dim: float(dataset[f"supported_{dim}"]) for dim in given} == given
    by_c = dataset.sel({"ics": "C", **given})
    for name in quantities:
        expected = pytest.approx(float(by_c[name]), rel=1e-6)
        assert float(dataset[f"supported_{name}"].sel(supports=SAME)) == expected
    softer = float(dataset.supported_approach.sel(supports=SOFTER) / by_c.approach)
    assert 1.05 < softer < 1.2


@pytest.mark.usefixtures("normal_in_place_of_c")
@pytest.mark.parametrize("keys", [{"ics": ["Bhat"]}, {"ics": ["A", "C"], "supports": False}])
def test_other_supports_are_left_out_without_c_or_if_the_scene_excludes_them(keys):
    given = scene(10.3, loads=[1e3], **keys)
    solved = solve_scene(given)
    assert changed_supports(solved) == {}
    assert "supports" not in with_supports(to_dataset(given, solved), {}).coords
    of = scene(13.0, **COMPRESSION | {"friction": [0.2]} | keys)
    with bhat_in_place_of_c():
        dataset = compute_with_friction(of)
        assert with_supports_of_motion(of, dataset, RunOptions(1)) is dataset
