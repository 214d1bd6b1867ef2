"""Geometry 1: known accuracy, and the signs that the theory predicts."""

from itertools import product

import numpy as np
import pytest
import xarray as xr

from compare.pages.ics_details import SceneICs, agreement_table
from femic.reference.job import component_of
from femic.reference.run_options import RunOptions
from femic.results.ics import compute, refinement_shares
from femic.results.ics_dataset import errors, to_dataset
from femic.scenes.load import load_scene
from tests.coarse import coarse_sections
from tests.compare.conftest import estimated_errors, on_line

BODIES = ("lower", "upper", "combined")


@pytest.fixture(scope="module")
def coarse():
    """Geometry 1 by larger cells: accurate to percents, which is enough for signs and sizes."""
    with coarse_sections():
        of = load_scene(
            "geometry1", {"variants": ["A", "B", "Bhat"], "engine": {"check": False, "tolerance": 0.2}}
        )
        results = compute(of, RunOptions(1))
    dataset = to_dataset(results)
    return dataset, errors(results, dataset)


@pytest.mark.slow
def test_estimate_of_each_component_is_below_one_thousandth(geometry1):
    results, *_ = geometry1
    estimates = estimated_errors(results)
    assert {body for body, _ in estimates} == {"lower", "upper"}
    for (body, line), known in estimates.items():
        for component in results.scene.components:
            assert component_of(known, component) < 0.001, (body, line, component)


@pytest.mark.slow
@pytest.mark.parametrize("line", ["s = 1.6 mm", "s = 0 mm", "x = 1.6 mm"])
def test_estimate_of_combined_xn_is_below_one_percent_and_two_of_its_maximum(geometry1, line):
    """What is left of it where the bodies' xn, 60 times as large, cancel."""
    _, dataset, errors = geometry1
    known = errors.sel(variant="C", body="combined", line=line, i="x", j="n")
    on = on_line(dataset, line).sel(body="combined", i="x", j="n")
    assert known.estimate_refinement < 0.01
    assert known.error < 0.02
    assert on.estimate.max() < 0.02 * abs(on.ic.sel(variant="C")).max()


@pytest.mark.slow
@pytest.mark.parametrize("body", BODIES)
def test_solid_engine_agrees_within_sum_of_estimates(geometry1_checked, body):
    results, dataset, _ = geometry1_checked
    of_body = dataset.sel(body=body)
    apart = np.abs(of_body.ic.sel(variant="C") - of_body.ic.sel(variant="C_solid")).values
    known = (of_body.estimate + of_body.estimate_solid).values
    off_by_line, known_by_line = (refinement_shares(results, body, values) for values in (apart, known))
    for line, off in off_by_line.items():
        sum_of_estimates = known_by_line[line]
        for component in results.scene.components:
            estimate = component_of(sum_of_estimates, component)
            assert component_of(off, component) <= estimate + 1e-12, (line, component)
            assert body == "combined" or estimate < 0.015, (line, component)


@pytest.mark.slow
def test_agreement_table_tells_whether_engines_agree(geometry1_checked):
    results, dataset, found = geometry1_checked
    rows = agreement_table(SceneICs(dataset, found)).rows
    assert [row.name for row in rows] == list(map(", ".join, product(results.scene.compared, results.lines)))
    assert [row.cells[-1] for row in rows] == ["yes"] * len(rows)
    off = dataset.assign(ic=dataset.ic * xr.where(dataset.variant == "C_solid", 1.05, 1.0))
    shown = agreement_table(SceneICs(off, errors(results, off))).rows
    assert "no" in [row.cells[-1] for row in shown]


@pytest.mark.parametrize("body", BODIES)
def test_sn_has_sign_and_size_of_b(coarse, body):
    dataset, _ = coarse
    line = on_line(dataset, "x = 1.6 mm")
    part = line.isel(point=np.flatnonzero((abs(line.s) >= 4) & (abs(line.s) <= 12))).sel(
        body=body, i="s", j="n"
    )
    c, b, a = (part.ic.sel(variant=v).values for v in ("C", "B", "A"))
    assert len(c) > 100
    assert np.all((c / b > 0.6) & (c / b < 1.7))
    if body == "lower":
        assert np.all(c * a < 0)


def test_c_is_reciprocal_at_crown(coarse):
    """At s = 0 load and observer change places by x -> -x: xn(x) = nx(-x), xs = sx = 0."""
    dataset, _ = coarse
    ic = on_line(dataset, "s = 0 mm").ic.sel(variant="C")
    scale = abs(ic.sel(i="n", j="n")).max("point")
    swapped = ic.sel(i="n", j="x").values[:, ::-1]
    # one element's mean against another's centre: the patch is finite, so near it they differ
    far = np.abs(on_line(dataset, "s = 0 mm").x.values) > 1.5
    difference = np.abs((ic.sel(i="x", j="n").values - swapped)[:, far]).max(axis=1)
    assert np.all(difference < 0.002 * scale.values)
    assert np.all(np.abs(ic.sel(i="x", j="s")).max("point") < 1e-12 * scale)


def test_approximations_have_right_size(coarse):
    """B and its kin follow C_nn laterally better than A does; A_sn of equal materials vanishes."""
    dataset, errors = coarse
    nn = errors.error.sel(body="combined", i="n", j="n", line="x = 1.6 mm")
    assert nn.sel(variant="B") < 0.6 * nn.sel(variant="A")
    assert nn.sel(variant="Bhat") < 0.6 * nn.sel(variant="A")
    assert np.all(dataset.ic.sel(variant="A", body="combined", i="s", j="n") == 0)
