"""Advice, tables and summaries on hand-made C: a small component is no zero, a zero is no small component."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from compare.pages.frontier import chart, evidence
from compare.pages.ics import error_table, largest_errors
from compare.pages.ics_details import SceneICs
from compare.report.errors import error_cell
from compare.studies import frontier as advising
from compare.studies.frontier import Method, Question, advise, frontier_for
from femic.reference.engine import Cost
from femic.reference.result import EstimatedICs, Reference
from femic.reference.run_options import RunOptions
from femic.results.ics import (
    Results,
    approximate_all,
    ics_measure,
    reference_ics,
    refinement_shares,
    scene_points,
    select_ics,
)
from femic.results.ics_dataset import errors
from femic.scenes.load import load_scene
from geometries.patches import N, S, X

SMALL = 0.001  # C_xn over the largest C_nn: a fiftieth of what 5 % are
ON_S_0 = {"lines": [{"along": "x", "s": 0.0, "reach": 6.0, "points": 25}], "engine": {"check": False}}
BEST = Method("harmonic 0.001", "C, harmonic 0.001", "harmonic", "C", 0.001)
COST = Cost(1000, 100, "direct", {"mesh": 1.0, "assembly": 1.0, "solution": 1.0}, (), 1e-12, 100.0)


def hand_made(components, known=1e-5):
    """Geometry 1 on the line s = 0: C is A of each body, but C_xn of both together is SMALL of C_nn.

    A_xn of both is 0. `known`: the estimate of C_xn of each body, over the largest C_nn of both.
    """
    scene = load_scene("geometry1", ON_S_0 | {"components": components, "bodies": ["combined", "lower"]})
    points, _ = scene_points(scene)
    ics, seconds = approximate_all(scene, points)
    whole, _ = approximate_all(replace(scene, compared=("lower", "upper")), points)
    nn = np.max(np.abs(ics["A", "combined"][N, N]))
    references = {}
    for body in ("lower", "upper"):
        ic = whole["A", body].copy()
        ic[X, N] += SMALL / 2 * nn * np.sin(np.pi * points.x / 6)
        estimate = np.zeros_like(ic)
        estimate[X, N] = known * nn
        zero = np.zeros_like(ic)
        c = EstimatedICs(ic, estimate, zero, zero)
        references[body] = Reference(c, ic, np.zeros((4, 4)), None, None, scene.bodies[body], {"fine": COST})
    seconds |= dict.fromkeys((("C", "combined"), ("C", "lower")), 10.0)
    return Results(scene, references, {}, ics, seconds)


def frontier_of(results):
    """All approximations, and C as the one reference."""
    return advising.frontier_dataset(results.scene, {BEST: results}, {})


@pytest.mark.parametrize("components", [["xn"], ["nn", "xn"]])
def test_zero_is_poor_approximation_of_small_component(components):
    """Of 0.05 C_nn, A_xn = 0 would be 2 % wrong; it is 100 % wrong. Of nn alone it would do."""
    dataset = frontier_of(hand_made(components))
    at = dataset.sel(way="A", body="combined", component="xn")
    assert (at.error, at.weight) == (pytest.approx(1.0), pytest.approx(SMALL))
    assert not at.vanishes
    advice = advise(dataset, Question(tuple(components), 0.05, "combined"))
    assert advice.way == BEST.name
    assert advice.text.startswith("Use C, harmonic 0.001: the combined ICs have errors up to ")
    assert advice.text.endswith("Largest error: xn.")
    assert advice.bound == pytest.approx(2 * 1e-5 / SMALL)  # the estimates of both bodies
    if "nn" in components:
        advice = advise(dataset, Question(("nn",), 0.05, "combined"))
        assert dataset.kind.sel(way=advice.way) == "approximation"


def test_component_smaller_than_its_estimate_is_reported_as_vanishing():
    """The sum of the estimates is a fifth of C_xn: A is tested as a zero, and that is said."""
    results = hand_made(["xn"], known=SMALL / 10)
    nn = np.abs(select_ics(results, "C", "combined")[N, N])
    nn_away = np.max(nn[np.abs(results.points.x) >= 1.6]) / np.max(nn)  # four elements from the load
    dataset = frontier_of(results)
    at = dataset.sel(way="A", body="combined", component="xn")
    assert at.vanishes
    assert not at.by_symmetry
    assert at.error == pytest.approx(SMALL / (0.05 * nn_away))
    advice = advise(dataset, Question(("xn",), 0.5, "combined"))
    assert "xn; it vanishes in C, so its error is relative to 0.05 C_nn" in advice.text
    table = evidence(dataset, advice)
    assert "xn †" in [column.header for column in table.columns]
    assert "0.05 C_nn" in table.caption
    assert chart(dataset).cells[0].title == "combined: vanishes, relative to 0.05 C_nn"


@pytest.mark.parametrize(
    ("component", "shrinks", "tried", "vanishes"),
    [
        ("xn", True, [0.1, 0.01], False),  # the estimate is a hundred times the tolerance of the tightest C
        ("xn", False, [0.1, 0.01, 0.001, 0.0001], True),  # there is none tighter
        ("sn", True, [0.1], True),  # by symmetry
    ],
)
def test_advice_computes_tighter_c_before_small_component_counts_as_zero(
    monkeypatch, component, shrinks, tried, vanishes
):
    tightest = []

    def compute(_, request, __):
        tightest.append(request.methods[-1].tolerance)
        return frontier_of(hand_made([component], known=SMALL * (tightest[-1] if shrinks else 1.0)))

    monkeypatch.setattr(advising, "compute_frontier", compute)
    request, dataset = frontier_for("geometry1", Question((component,), 0.9, "combined"), RunOptions(1))
    assert list(dict.fromkeys(tightest)) == tried
    assert request.methods[-1].tolerance == tried[-1]
    assert dataset.vanishes.sel(body="combined", component=component) == vanishes


def test_shares_on_both_scales_and_weights():
    results = hand_made(["nn", "xn", "sn"])
    off = results.approximations["A", "combined"] - sum(r.c.ic for r in results.references.values())
    (line,) = results.lines
    measure = ics_measure(results, "combined")
    assert measure.shares(off)[line][X, N] == pytest.approx(1)
    assert measure.weights(off)[line][X, N] == pytest.approx(SMALL)
    assert refinement_shares(results, "combined", off)[line][X, N] == pytest.approx(SMALL / 0.05)
    vanishing = measure.vanishing
    assert vanishing[S, N]  # on s = 0
    assert not vanishing[X, N]
    assert not vanishing[N, N]


def test_errors_of_run_and_their_tables():
    results = hand_made(["nn", "xn", "sn"])
    run_errors = errors(results, to_dataset_of(results))
    (line,) = results.lines
    at = run_errors.sel(body="combined", line=line)
    assert at.error.sel(variant="A", i="x", j="n") == pytest.approx(1)
    assert at.error.sel(variant="C", i="x", j="n") == pytest.approx(2e-5 / SMALL)
    assert at.estimate_refinement.sel(i="x", j="n") == pytest.approx(2e-5 / 0.05)
    rms = at.assign(error=at.rms).drop_vars("weight")
    tables = {}
    for name, shown in {"errors": at, "rms": rms}.items():
        rows = error_table("", {"": shown}, ["nn", "xn", "sn"], results.variants).rows
        tables[name] = {row.name: [(cell.text, cell.below) for cell in row.cells] for row in rows}
    assert tables["errors"]["A"] == [("0", ""), ("100.0 %", "0.10 %"), ("0", "")]
    assert tables["errors"]["C ±"] == [("0", ""), ("2.00 %", "< 0.01 %"), ("vanishes", "")]
    of_a_sine = np.sqrt(0.48)  # 12 of its 25 points are squares
    assert tables["rms"]["A"][1][0] == f"{100 * of_a_sine:.1f} %"


def test_answer_tells_components_that_vanish_and_their_weight():
    results = hand_made(["xn", "sn"])
    attributes = {"components": json.dumps(results.scene.components), "scene": ""}
    ics = to_dataset_of(results).assign_attrs(attributes)
    worst = largest_errors(SceneICs(ics, errors(results, ics)))["cross terms"].sel(variant="A")
    assert worst.component == "xn"
    assert not worst.vanishes
    assert worst.error.item() == pytest.approx(1)
    assert worst.weight.item() == pytest.approx(SMALL)
    assert worst.estimate.item() == pytest.approx(2e-5 / SMALL)
    assert worst.verdict == "no"


def test_cell_of_vanishing_c_has_weight_but_no_share():
    assert error_cell(0.7, 0.002, vanishes=True, is_estimate=True).text == "vanishes"
    assert error_cell(0.7, 0.002, vanishes=True, is_estimate=True).below == "0.20 %"
    assert error_cell(0.007, 0.002, is_estimate=True).text == "0.70 %"


def to_dataset_of(results):
    """What `errors` reads of `to_dataset`, which also describes models that are not there."""
    bodies, variants = list(results.scene.compared), list(results.variants)
    ic = [[select_ics(results, variant, body) for body in bodies] for variant in variants]
    estimate = [reference_ics(results, body).estimate for body in bodies]
    dims = ("body", "i", "j", "point")
    return xr.Dataset(
        {"ic": (("variant", *dims), np.array(ic)), "estimate": (dims, np.array(estimate))},
        coords={"variant": variants, "body": bodies, "i": list("xsn"), "j": list("xsn")},
    )
