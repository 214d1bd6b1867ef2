"""Advice, tables and summaries on hand-made C: a small component is no zero, a zero is no small component."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from compare.frontier import advice as advising
from compare.frontier import compute as frontier_compute
from compare.frontier.advice import Question, advise, frontier_for, sentence
from compare.frontier.page import evidence, figure
from compare.frontier.ways import Way
from compare.ics.compute import Results, approximated, ics_of, jobs, reference_of, scene_points
from compare.ics.dataset import errors
from compare.ics.errors import measure_of, refinement_shares_of
from compare.ics.figures import error_against_seconds
from compare.ics.page import _error_table
from compare.ics.summary import summary
from compare.report.errors import error_cell
from femic.reference.estimate import EstimatedICs
from femic.reference.models import Cost
from femic.reference.result import Reference
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.patches import N, S, X

SMALL = 0.001  # C_xn over the largest C_nn: a fiftieth of what 5 % are
ON_S_0 = {"lines": [{"along": "x", "s": 0.0, "reach": 6.0, "points": 25}], "engine": {"check": False}}
BEST = Way("harmonic 0.001", "harmonic", {"kind": "harmonic", "tolerance": 0.001})
COST = Cost(1000, 100, "direct", {"mesh": 1.0, "assembly": 1.0, "solution": 1.0}, (), 1e-12, 100.0)


def hand_made(components, known=1e-5):
    """Geometry 1 on the line s = 0: C is A of each body, but C_xn of both together is SMALL of C_nn.

    A_xn of both is 0. `known`: the estimate of C_xn of each body, over the largest C_nn of both.
    """
    scene = load_scene("geometry1", ON_S_0 | {"components": components, "bodies": ["combined", "lower"]})
    points, lines = scene_points(scene)
    ics, seconds = approximated(scene, points)
    whole, _ = approximated(replace(scene, compared=("lower", "upper")), points)
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
    return Results(scene, points, lines, jobs(scene), references, {}, ics, seconds)


def frontier_of(results):
    """All approximations, and C as the one reference."""
    tried = [*frontier_compute._approximations(results.scene), frontier_compute._way_result(BEST, results)]
    return frontier_compute._dataset(results.scene, tried, (BEST.name, results), {})


@pytest.mark.parametrize("components", [["xn"], ["nn", "xn"]])
def test_a_zero_is_no_good_approximation_of_a_small_component(components):
    """Of 0.05 C_nn, A_xn = 0 would be 2 % wrong; it is 100 % wrong."""
    found = frontier_of(hand_made(components))
    at = found.sel(way="A", body="combined", component="xn")
    assert at.error == pytest.approx(1.0)
    assert at.weight == pytest.approx(SMALL)
    assert not at.vanishes
    advice = advise(found, Question("combined", tuple(components), 0.05))
    assert advice.way == BEST.name
    assert "Use C" in sentence(advice)
    assert "xn" in sentence(advice)
    assert advice.error == pytest.approx(2 * 1e-5 / SMALL)  # the estimates of both bodies
    assert not advice.vanishes


def test_where_it_is_not_asked_for_approximations_do():
    found = frontier_of(hand_made(["nn", "xn"]))
    advice = advise(found, Question("combined", ("nn",), 0.05))
    assert found.kind.sel(way=advice.way) == "approximation"


def test_what_c_does_not_know_is_said_to_vanish():
    """The sum of the estimates is a fifth of C_xn: A is tested as a zero, and that is said."""
    results = hand_made(["xn"], known=SMALL / 10)
    nn = np.abs(ics_of(results, "C", "combined")[N, N])
    nn_away = np.max(nn[np.abs(results.points.x) >= 1.6]) / np.max(nn)  # four elements from the load
    found = frontier_of(results)
    at = found.sel(way="A", body="combined", component="xn")
    assert at.vanishes
    assert not at.by_symmetry
    assert at.error == pytest.approx(SMALL / (0.05 * nn_away))
    advice = advise(found, Question("combined", ("xn",), 0.5))
    assert advice.vanishes
    assert "xn; it vanishes in C, so that is a share of 0.05 C_nn" in sentence(advice)
    table = evidence(found, advice)
    assert "xn †" in [column.header for column in table.columns]
    assert "0.05 C_nn" in table.caption
    assert "vanishes" in figure(found, "combined").axes[0].get_title()


def test_advice_tries_a_tighter_c_before_it_takes_a_small_component_for_a_zero(monkeypatch):
    """The estimate is a hundred times the tolerance of the tightest C, in parts of C_xn's size."""
    tightest = []

    def tried(_, asked, __):
        tightest.append(asked.ways[-1].engine["tolerance"])
        return frontier_of(hand_made(["xn"], known=SMALL * tightest[-1]))

    monkeypatch.setattr(advising, "compute_frontier", tried)
    asked, found = frontier_for("geometry1", Question("combined", ("xn",), 0.9), RunOptions(1))
    assert tightest == [0.1, 0.01]
    assert asked.ways[-1].engine["tolerance"] == 0.01
    assert not found.vanishes.sel(body="combined", component="xn")

    monkeypatch.setattr(
        advising, "compute_frontier", lambda *_, **__: frontier_of(hand_made(["xn"], known=SMALL))
    )
    asked, found = frontier_for("geometry1", Question("combined", ("xn",), 0.9), RunOptions(1))
    assert asked.ways[-1].engine["tolerance"] == 1e-4  # there is none tighter
    assert found.vanishes.sel(body="combined", component="xn")


def test_no_tighter_c_is_asked_for_what_vanishes_by_symmetry(monkeypatch):
    tried = []
    monkeypatch.setattr(
        advising, "compute_frontier", lambda *_, **__: tried.append(1) or frontier_of(hand_made(["sn"]))
    )
    _, found = frontier_for("geometry1", Question("combined", ("sn",), 0.9), RunOptions(1))
    assert found.vanishes.sel(body="combined", component="sn")
    assert len(tried) == 1


def test_shares_of_both_scales_and_weights_of_results():
    results = hand_made(["nn", "xn", "sn"])
    off = results.approximations["A", "combined"] - sum(r.c.ic for r in results.references.values())
    (line,) = results.lines
    measure = measure_of(results, "combined")
    assert measure.shares(off)[line][X, N] == pytest.approx(1)
    assert measure.weights(off)[line][X, N] == pytest.approx(SMALL)
    assert refinement_shares_of(results, "combined", off)[line][X, N] == pytest.approx(SMALL / 0.05)
    gone = measure.vanishing
    assert gone[S, N]  # on s = 0
    assert not gone[X, N]
    assert not gone[N, N]


def test_errors_of_a_run_and_its_tables():
    results = hand_made(["nn", "xn", "sn"])
    found = errors(results, to_dataset_of(results))
    (line,) = results.lines
    at = found.sel(body="combined", line=line)
    assert at.error.sel(variant="A", i="x", j="n") == pytest.approx(1)
    assert at.error.sel(variant="C", i="x", j="n") == pytest.approx(2e-5 / SMALL)
    assert at.estimate_refinement.sel(i="x", j="n") == pytest.approx(2e-5 / 0.05)
    rows = {row.name: row.cells for row in _error_table(results, found, "combined").rows}
    shown = {symbol: [(cell.text, cell.below) for cell in cells] for symbol, (_, *cells) in rows.items()}
    assert {cells[0] for cells in rows.values()} == {line}
    assert shown["A"] == [("0", ""), ("100.0 %", "0.10 %"), ("0", "")]
    assert shown["C"] == [("0", ""), ("2.00 %", "< 0.01 %"), ("vanishes", "")]
    rms_errors = found.assign(error=found.rms, weight=np.nan)
    rms = {row.name: row.cells for row in _error_table(results, rms_errors, "combined").rows}
    of_a_sine = np.sqrt(0.48)  # 12 of its 25 points are squares
    assert rms["A"][2].text == f"{100 * of_a_sine:.1f} %"


def test_the_summary_says_what_vanishes_and_how_well_c_is_known_on_both_scales():
    results = hand_made(["nn", "xn", "sn"])
    text = summary(results, errors(results, to_dataset_of(results)))
    assert "A 100.0 % (xn on s = 0 mm)" in text
    assert "sn of C vanishes, and so do the variants" in text
    assert "sn:" not in text
    assert "The estimated error of C is at most 2.00% of a component (xn on s = 0 mm)" in text
    assert "On the scale of refinement it is at most 0.04% (xn on s = 0 mm)" in text


def test_a_scene_of_nothing_but_zeros_has_a_summary():
    results = hand_made(["sn"])
    text = summary(results, errors(results, to_dataset_of(results)))
    assert text.startswith("sn of C vanishes")
    assert "Closest" not in text


def test_marks_of_what_vanishes_are_hollow():
    results = hand_made(["nn", "xn", "sn"])
    drawn = error_against_seconds(results, errors(results, to_dataset_of(results)))
    marks = {line.get_label(): line for line in drawn.axes[0].get_lines()}
    assert len(marks["A"].get_ydata()) == 2
    assert marks["A"].get_markerfacecolor() != "none"
    hollow = [line for line in drawn.axes[0].get_lines() if line.get_markerfacecolor() == "none"]
    assert all(len(line.get_ydata()) == 1 for line in hollow)
    assert len(hollow) == len(results.variants)


def test_c_that_vanishes_has_a_weight_but_no_share_of_itself():
    assert error_cell(0.7, 0.002, vanishes=True, is_estimate=True).text == "vanishes"
    assert error_cell(0.7, 0.002, vanishes=True, is_estimate=True).below == "0.20 %"
    assert error_cell(0.007, 0.002, is_estimate=True).text == "0.70 %"


def to_dataset_of(results):
    """What `errors` reads of `to_dataset`, which also describes models that are not there."""
    bodies, variants = list(results.scene.compared), list(results.variants)
    ic = [[ics_of(results, variant, body) for body in bodies] for variant in variants]
    estimate = [reference_of(results, body).estimate for body in bodies]
    dims = ("body", "i", "j", "point")
    return xr.Dataset(
        {"ic": (("variant", *dims), np.array(ic)), "estimate": (dims, np.array(estimate))},
        coords={"variant": variants, "body": bodies, "i": list("xsn"), "j": list("xsn")},
    )
