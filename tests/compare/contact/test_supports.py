"""What supports do to a contact: flatter flanks, which contacts are solved again, what the file says."""

from dataclasses import replace

import numpy as np
import pytest

from approx.pair import matrix
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
from femic.results.contact import solve_scene, to_dataset, with_supports
from geometries.contours import arc, ellipse, through_points
from geometries.patches import N
from tests.compare.contact.test_contact import scene

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


def stiffer(on_grid, factor):
    """B-hat in the place of C."""
    nn = matrix("Bhat", on_grid.pair, on_grid.grid)[..., 2:, 2:]
    return GridOperator.from_ics(factor * nn, (N,))


@pytest.fixture
def in_place_of_c(monkeypatch):
    """C is B-hat, 10 % more with a nearer far arc, and 20 % more with flatter flanks."""

    def reference(_, on_grid, __):
        return ReferenceICs(*[stiffer(on_grid, 1.0)] * 2, 0.0, Asymmetry(0.0, "nn"), 1.0, 0.0)

    monkeypatch.setattr("femic.contact.pairs.ics.normal_reference_ics", reference)
    monkeypatch.setattr(f"{SUPPORTS}.matrices", lambda *_, **__: {})
    monkeypatch.setattr(
        f"{SUPPORTS}.pair_operator",
        lambda _, on_grid, __, variation, **___: stiffer(on_grid, 1.1 if variation else 1.2),
    )


@pytest.mark.usefixtures("in_place_of_c")
def test_c_with_flatter_flanks_is_solved_where_the_contact_is_not_symmetric():
    for shift, names in ((0.0, [NEARER]), (0.05, [NEARER, FLATTER])):
        given = scene(10.3, loads=[1e3, 5e3], elements=8, ics=["C"], shift=shift)
        solved = solve_scene(given)
        changes = changed_supports(solved)
        assert list(changes) == names
        dataset = with_supports(to_dataset(given, solved), changes)
        assert list(dataset.supports.values) == names
        assert {f"supported_{name}" for name in OF_FRICTIONLESS} <= {*dataset.data_vars}
        largest = dataset.isel(case=int(dataset.attrs["supported_case"])).sel(ics="C")
        assert float(largest["load"]) == pytest.approx(5e3)
        assert np.all(dataset.supported_approach.values > 1.05 * float(largest.approach))


@pytest.mark.usefixtures("in_place_of_c")
def test_other_supports_are_left_out_without_c_or_if_the_scene_excludes_them():
    for keys in ({"ics": ["Bhat"]}, {"ics": ["C"], "supports": False}):
        given = scene(10.3, loads=[1e3], elements=8, **keys)
        solved = solve_scene(given)
        assert changed_supports(solved) == {}
        assert "supports" not in with_supports(to_dataset(given, solved), {}).coords


def test_contours_through_points_have_no_flatter_flanks():
    y = np.linspace(-6, 6, 13)
    contour = through_points(y, -0.03 * y**2, 0.0)
    assert np.all(np.isfinite(contour.extent))
    of = scene(10.3, loads=[1e3])
    bodies = {name: replace(body, contour=contour) for name, body in of.bodies.items()}
    assert flatter_problem(replace(of.contact_problem, bodies=bodies)) is None
