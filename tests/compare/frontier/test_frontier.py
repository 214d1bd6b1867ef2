"""`femic frontier` and `femic advise`: the front, the budget, and that advice keeps what it promises."""

import json

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from compare.pages import frontier as frontier_report
from compare.pages.frontier import ALL, FLOOR_LABEL, chart, error_text, time_text
from compare.report.errors import percent
from compare.studies import frontier
from compare.studies.frontier import (
    AS_CHEAP,
    FrontierRequest,
    Question,
    advise,
    by_number,
    cheapest,
    choose,
    compute_frontier,
    engine_methods,
    front,
    question_of,
    request_for,
    worst,
)
from femic.cache.store import Store
from femic.cli.main import DONE, WRONG_INPUT, exit_code
from femic.reference.engines import ENGINES
from femic.reference.harmonic import engine as harmonic_engine
from femic.reference.run_options import RunOptions
from femic.results.ics import compute
from femic.results.ics_dataset import errors, to_dataset
from femic.scenes.load import load_scene
from geometries.errors import Failure, WrongInput
from tests.compare.conftest import scene_text
from tests.compare.pages import read_chart, read_traces, require_room

HARMONIC = "[engine]\ncheck = true\n"
COMPONENTS = ("nn", "xn", "sn")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A scene of unlike bodies, its frontier by the harmonic engine to 1e-2: path, store, dataset."""
    folder = tmp_path_factory.mktemp("frontier")
    path = folder / "mine.toml"
    top = 'components = ["nn", "xn", "sn"]\nbodies = ["combined", "lower"]\n'
    path.write_text(scene_text(top, engine=HARMONIC, upper_E=70e3), encoding="utf-8")
    store = Store(folder / "store")
    request = FrontierRequest(tuple(engine_methods("harmonic", 1e-2)))
    return path, store, compute_frontier(str(path), request, RunOptions(2, store))


def error_bounds(dataset, body):
    """Upper bounds of a body's errors, (way, component)."""
    return by_number(dataset).bound.sel(case=body).rename(number="component")


points = st.tuples(st.integers(0, 6), st.integers(0, 6))


@given(st.lists(points, min_size=1, max_size=12))
def test_front_contains_exactly_the_ways_that_are_not_dominated(ways):
    seconds, errors = np.array(ways, dtype=float).T
    chosen = front(seconds, errors)
    assert np.any(chosen)
    for k, (s, e) in enumerate(ways):
        beaten = any(a <= s and b <= e and (a, b) != (s, e) for a, b in ways)
        assert chosen[k] == (not beaten)


def test_frontier_contains_all_ways_with_their_costs_and_errors_within_tolerances(made):
    _, _, dataset = made
    assert [*dataset.way.values] == ["A", "B", "Bbar", "Bhat", "mix", "harmonic 0.1", "harmonic 0.01"]
    known = dataset.estimate.max(["body", "component"])
    assert known.sel(way=dataset.attrs["best"]) == known.where(dataset.kind == "harmonic").min()
    assert np.all(dataset.seconds > 0)
    approximations = dataset.kind == "approximation"
    assert dataset.seconds.where(approximations).max() < 0.1 * dataset.seconds.where(~approximations).min()
    np.testing.assert_array_equal(dataset.unknowns > 0, ~approximations)
    seconds = dataset.seconds.sel(way="harmonic 0.1")
    assert seconds.sel(body="combined") > seconds.sel(body="lower")
    # no C deviates from the best C by more than its tolerance
    for way in engine_methods("harmonic", 1e-2):
        assert np.all(dataset.error.sel(way=way.name) <= way.tolerance)
        assert np.all(dataset.estimate.sel(way=way.name) <= way.tolerance)
    assert np.all(dataset.estimate.sel(way=["A", "mix"]) == 0)


def test_errors_agree_with_run_at_tolerance_of_best_c(made):
    """By another route: the report's table of `femic run` at the tolerance of the best."""
    path, store, dataset = made
    engine = {"tolerance": float(dataset.attrs["best"].split()[1]), "check": False}
    results = compute(load_scene(str(path), {"engine": engine}), RunOptions(2, store))
    of_run = errors(results, to_dataset(results)).error.max("line")
    for i, j in COMPONENTS:
        for variant in ("A", "Bhat", "mix"):
            expected = of_run.sel(variant=variant, i=i, j=j, body="combined").item()
            got = dataset.error.sel(way=variant, component=i + j, body="combined").item()
            assert got == pytest.approx(expected, rel=1e-9)
        own = of_run.sel(variant="C", i=i, j=j, body="lower").item()
        best = dataset.sel(way=dataset.attrs["best"], component=i + j, body="lower")
        assert best.error.item() == pytest.approx(own) == best.estimate.item()


@pytest.mark.parametrize("tolerance", [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.004])
@pytest.mark.parametrize("components", [("nn",), ("sn",), ("nn", "xn"), COMPONENTS])
@pytest.mark.parametrize("body", ["combined", "lower"])
def test_advice_meets_tolerance_at_least_cost(made, tolerance, components, body):
    _, _, dataset = made
    advice = advise(dataset, Question(components, tolerance, body))
    at_most = error_bounds(dataset, body).sel(component=list(components)).max("component")
    assert float(at_most.sel(way=advice.way)) <= tolerance
    measured = dataset.error.sel(way=advice.way, body=body, component=list(components)).max()
    assert float(measured) <= advice.bound <= tolerance
    seconds = dataset.seconds.sel(body=body)
    far_cheaper = dataset.way.values[(AS_CHEAP * seconds < advice.seconds).values]
    assert np.all(at_most.sel(way=far_cheaper) > tolerance)
    as_cheap = dataset.way.values[(seconds <= advice.seconds).values]
    enough = at_most.sel(way=as_cheap).where(at_most.sel(way=as_cheap) <= tolerance)
    assert advice.bound == float(enough.min())


@pytest.mark.parametrize(
    ("question", "kind", "message"),
    [
        (
            (COMPONENTS, 1e-7, "combined"),
            Failure,
            r"no choice of ICs is within the tolerance of 1e-05 %\. The most accurate, harmonic 0\.0?1, has",
        ),
        ((("ss",), 0.1, "combined"), WrongInput, "component = ss: the scene has nn"),
        ((("nn",), 0.1, "upper"), WrongInput, "body = upper"),
    ],
)
def test_questions_without_an_answer_are_refused(made, question, kind, message):
    _, _, dataset = made
    with pytest.raises(kind, match=message):
        advise(dataset, Question(*question))


def test_request_contains_only_ways_that_advice_needs():
    request = request_for("geometry1", Question(("nn",), 0.02, "lower"))
    assert [method.name for method in request.methods] == ["harmonic 0.1", "harmonic 0.01", "harmonic 0.001"]
    scene = request.scene("geometry1", request.methods[0].changes["engine"])
    assert (scene.components, scene.compared, scene.solved) == (("nn",), ("lower",), ("lower",))
    with pytest.raises(WrongInput, match="--tolerance 0"):
        Question(("nn",), 0.0, "lower")


def test_ways_beyond_budget_are_skipped_and_listed(made, monkeypatch):
    """Ways that are predicted to take longer are not begun; without any C there is no frontier."""
    path, store, _ = made
    options = RunOptions(2, store)
    with pytest.raises(Failure, match="no reference C within the budget of 1e-06 s"):
        compute_frontier(
            str(path), FrontierRequest(tuple(engine_methods("harmonic", 0.1)), budget=1e-6), options
        )
    steps = iter((1.0, 1e5))  # seconds of harmonic 0.1 and 0.01
    monkeypatch.setattr(frontier, "run_plans", lambda *_: [])
    monkeypatch.setattr(frontier, "total_seconds", lambda *_: next(steps))
    request = FrontierRequest(tuple(engine_methods("harmonic", 1e-2)), budget=1000.0)
    dataset = compute_frontier(str(path), request, options)
    assert "harmonic 0.01" not in dataset.way.values
    assert dataset.attrs["best"] == "harmonic 0.1"
    assert "about 100000 s" in json.loads(dataset.attrs["skipped"])["harmonic 0.01"]


def test_b_hat_prime_is_computed_where_effective_properties_are_given(made, tmp_path):
    path, store, dataset = made
    fitted = tmp_path / "fitted.toml"
    properties = "\n[effective.combined]\nmismatch_k = { far = 0.1, r_inf = 9.0, m = 1.0, n = 2.0 }\n"
    fitted.write_text(path.read_text(encoding="utf-8") + properties, encoding="utf-8")
    with_fit = compute_frontier(
        str(fitted), FrontierRequest(tuple(engine_methods("harmonic", 0.1))), RunOptions(2, store)
    )
    b_hat_prime = with_fit.error.sel(way="Bhat_prime")
    assert np.all(b_hat_prime.sel(body="combined") > 0)
    assert np.all(np.isnan(b_hat_prime.sel(body="lower")))
    assert "Bhat_prime" not in dataset.way.values
    advice = advise(with_fit, Question(("nn",), 0.5, "lower"))
    assert advice.way != "Bhat_prime"
    frontier_report.write_frontier(with_fit, tmp_path / "out")


def test_ways_that_an_engine_cannot_compute_are_listed(made, tmp_path, monkeypatch):
    path, *_ = made
    soft = tmp_path / "soft.toml"
    soft.write_text(path.read_text(encoding="utf-8").replace("nu = 0.3", "nu = 0.4995"), encoding="utf-8")
    request = FrontierRequest((*engine_methods("harmonic", 0.1), *engine_methods("solid")))
    solid_ways = [method.name for method in request.methods if method.kind == "solid"]

    def compute(*_):
        raise Failure("no time")

    monkeypatch.setattr(frontier, "compute", compute)
    with pytest.raises(Failure, match=r"lower\.nu = 0\.4995") as refused:
        compute_frontier(str(soft), request, RunOptions(2))
    assert all(f"{name}: " in str(refused.value) for name in solid_ways)
    assert "harmonic 0.1: no solution: no time" in str(refused.value)


def test_command_writes_report_and_solves_nothing_twice(made, tmp_path, monkeypatch, capsys):
    path, store, _ = made
    monkeypatch.setattr(harmonic_engine, "solve", lambda *_, **__: pytest.fail("a model was solved"))
    monkeypatch.setitem(frontier.LADDERS, "harmonic", (1e-1, 1e-2))
    monkeypatch.setattr(frontier, "ENGINES", {"harmonic": ENGINES["harmonic"]})
    out = tmp_path / "out"
    place = ["--out", str(out), "--store", str(store.location)]
    assert exit_code(["frontier", str(path), *place]) == DONE
    html = (out / "frontier.html").read_text(encoding="utf-8")
    assert "://" not in html
    assert html.count('class="chart"') == html.count('id="chart-ways"') == 1
    with xr.open_dataset(out / "frontier.nc", engine="h5netcdf") as kept:
        assert kept.sizes == {"way": 7, "body": 2, "component": 3}
    capsys.readouterr()


def test_summary_names_the_cheapest_choice_within_the_tolerance_of_the_scene_or_the_most_accurate(made):
    *_, dataset = made
    text = frontier_report.summary(dataset)
    seconds = dataset.seconds.sel(body="combined").values
    for subject, names in (("nn", ["nn"]), ("all components", list(COMPONENTS))):
        errors = worst(dataset, names, "combined")
        number = cheapest(errors.bound.values, seconds, 0.02)
        nearest = number if number >= 0 else int(np.nanargmin(errors.bound.values))
        label, time = dataset.label.values[nearest], time_text(seconds[nearest])
        (part,) = (part for part in text.partition(". ")[0].split("; ") if subject in part)
        assert part.endswith(f", {label} in {time}" if number >= 0 else f" %, {time})")
        assert label in part
    floors = worst(dataset, COMPONENTS, "combined").floor.sel(way=dataset.attrs["best"]).item()
    assert text.endswith(f"whose estimated error is at most {percent(floors)}.")


def test_answer_has_the_cheapest_ways_with_their_errors_and_time(made):
    *_, dataset = made
    answer = frontier_report.answer_table(dataset)
    assert [column.head for column in answer.heads] == ["nn", "all components"]
    seconds = dataset.seconds.sel(body="combined").values
    for row in answer.rows:
        tolerance = float(row.name.removesuffix(" %")) / 100
        for cell, names in zip(row.filled, (["nn"], list(COMPONENTS)), strict=True):
            errors = worst(dataset, names, "combined")
            number = cheapest(errors.bound.values, seconds, tolerance)
            if number < 0:
                assert cell.text == "none"
                number = int(np.nanargmin(errors.bound.values))
                assert cell.below.startswith(f"most accurate: {dataset.label.values[number]}, ")
            else:
                assert cell.text == dataset.label.values[number]
            assert cell.below.endswith(
                f"{error_text(errors.isel(way=number))} %, {time_text(seconds[number])}"
            )


def test_answer_has_a_row_of_the_tolerance_of_the_scene(made):
    *_, dataset = made
    tight = dataset.assign_attrs(scene="ics_tolerance = 0.005")
    assert [row.name for row in frontier_report.answer_table(tight).rows][-1] == "0.5 %"
    assert "within the tolerance of 0.5 %: " in frontier_report.summary(tight)


def test_choices_that_are_left_out_are_doubts(made):
    *_, dataset = made
    skipped = {"C 0.01": "about 9 s, but 3 s of the budget are left", "solid 0.1": "no solution: no fit"}
    budget, unsolved = frontier_report.doubts(dataset.assign_attrs(skipped=json.dumps(skipped)))
    assert "C 0.01" in budget
    assert "solid 0.1" in unsolved
    assert not list(frontier_report.doubts(dataset.assign_attrs(skipped="{}")))


def test_points_of_the_chart_are_errors_and_seconds_and_its_front_is_not_dominated(made):
    *_, dataset = made
    content = read_chart(chart(dataset))
    assert content["labels"] == [ALL, *COMPONENTS]
    assert content["labels"][content["start"]] == ALL
    body, component = "lower", "sn"
    (cell,) = (
        cell
        for cell in content["steps"][content["labels"].index(component)]
        if cell["title"].split(":")[0] == body
    )
    drawn = read_traces(cell)
    own = worst(dataset, [component], body)
    errors, bounds = 100 * own.error, 100 * own.bound
    seconds = dataset.seconds.sel(body=body)
    for label, ways in (("B̂", ["Bhat"]), ("C, harmonic", ["harmonic 0.1", "harmonic 0.01"])):
        np.testing.assert_allclose(drawn[label]["x"], seconds.sel(way=ways), rtol=1e-5)
        np.testing.assert_allclose(drawn[label]["y"], errors.sel(way=ways), rtol=1e-5)
        top = np.add(drawn[label]["y"], drawn[label]["error_y"]["array"])
        np.testing.assert_allclose(top, bounds.sel(way=ways), rtol=1e-4)
    floor = dataset.estimate.sel(body=body, component=component, way=dataset.attrs["best"]).item()
    assert drawn[FLOOR_LABEL]["y"] == pytest.approx([100 * floor] * 2, rel=1e-5)
    assert f"of {component} in {time_text(seconds.sel(way='Bhat').item())}" in drawn["B̂"]["customdata"][0]
    drawn = read_traces(content["steps"][0][0])  # of all components, of both bodies
    errors = worst(dataset, COMPONENTS, "combined").error.values
    seconds = dataset.seconds.sel(body="combined").values
    order = sorted(np.flatnonzero(front(seconds, errors)), key=lambda k: seconds[k])
    np.testing.assert_allclose(drawn["front"]["x"], seconds[order], rtol=1e-5)
    np.testing.assert_allclose(drawn["front"]["y"], 100 * errors[order], rtol=1e-5)


@pytest.mark.slow
def test_page_is_not_wider_than_the_window(made, tmp_path, browser):
    page = frontier_report.write_frontier(made[-1], tmp_path)
    require_room(browser, page, dict.fromkeys((1280, 800, 400), 770))


def test_advice_from_the_command_line(made, tmp_path, capsys):
    path, store, _ = made
    place = ["--out", str(tmp_path / "out"), "--store", str(store.location)]
    arguments = ["advise", str(path), "--tolerance", "0.04", "--components", "nn", "--body", "lower", *place]
    assert exit_code(arguments) == DONE
    assert "Use B̂: the lower ICs have errors up to" in capsys.readouterr().out
    assert exit_code(["advise", str(path), "--tolerance", "2", *place]) == WRONG_INPUT
    assert exit_code(["advise", str(path), "--components", "nq", *place]) == WRONG_INPUT
    assert exit_code(["frontier", str(path), "--budget", "-1", *place]) == WRONG_INPUT


# --- ics = "auto" ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tolerance", "kind"), [(0.5, "approximation"), pytest.param(0.02, "harmonic", marks=pytest.mark.slow)]
)
def test_auto_chooses_what_advise_names(made, tolerance, kind):
    path, store, dataset = made
    scene = load_scene(str(path), {"ics_tolerance": tolerance})
    chosen = choose(str(path), question_of(scene), RunOptions(2, store))
    way = chosen.way
    if kind == "harmonic":  # approximations take milliseconds, measured anew: any of them may be the fastest
        question = Question(scene.components, tolerance, "combined")
        dataset = compute_frontier(str(path), request_for(str(path), question), RunOptions(2, store))
        assert advise(dataset, question).way == way
    assert chosen.bound <= tolerance == chosen.question.tolerance
    assert dataset.kind.sel(way=way) == kind
    if kind == "approximation":
        assert (chosen.ics, chosen.changes) == (way, {})
    else:
        assert (chosen.ics, chosen.changes["engine"]["tolerance"]) == ("C", float(way.split()[1]))


def test_ways_keep_domain_and_limit_of_scene(made, tmp_path):
    """A far radius is part of the answer; cells follow from the tolerance, other engines have their own."""
    path, *_ = made
    mine = tmp_path / "mine.toml"
    engine = "check = true\nfar_radius = 2000.0\nsmallest_cell = 0.01\nmost_unknowns = 5000\n"
    mine.write_text(path.read_text(encoding="utf-8").replace("check = true", engine), encoding="utf-8")
    request = request_for("geometry1", Question(("nn",), 0.1, "lower"))
    scene = request.scene(str(mine), request.methods[0].changes["engine"])
    assert scene.bodies["lower"].domain.far_radius == 2000.0
    assert (scene.settings.most_unknowns, scene.settings.tolerance, scene.check) == (5000, 0.1, None)
    assert scene.first_cells.smallest != 0.01
    other = request.scene(str(mine), next(engine_methods("solid")).changes["engine"])
    assert (other.bodies["lower"].domain.far_radius, other.settings.most_unknowns) == (320.0, 5000)
