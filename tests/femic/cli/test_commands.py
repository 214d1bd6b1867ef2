"""What commands ask the program for, by default and with options; limits of options; exit codes.

What they ask for is recorded instead of computed.
"""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest
import xarray as xr

from compare.pages.friction_pages import PAGES
from compare.studies.frontier import Advice, Question
from compare.validation.statements.page import STATEMENTS
from femic.cli.main import DONE, FAILED, INTERRUPTED, WRONG_INPUT, exit_code
from femic.contact.pairs.grids import grids_of
from femic.reference.engine import ExpectedCost
from femic.reference.engines import HARMONIC, SOLID
from femic.reference.refinement import ModelPlan
from femic.scenes.load import load_scene
from geometries.errors import Failure, WrongInput
from geometries.patches import COMPONENTS

BHAT = Advice(Question(COMPONENTS, 0.02, "combined"), "Bhat", {}, 0.01, "Use it.")
OF_C = replace(BHAT, ics="C")


@pytest.fixture
def recorded(monkeypatch):
    """Replaces functions by others that record their arguments and return what is given."""

    def record(name, returns=None):
        calls = []
        monkeypatch.setattr(name, lambda *of, **named: calls.append((*of, *named.values())) or returns)
        return calls

    return record


@pytest.fixture
def command(tmp_path):
    """Runs a command whose results go to a folder of the test."""
    return lambda *words: exit_code([*words, "--out", str(tmp_path / "out"), "--workers", "1"])


# --- exit codes -----------------------------------------------------------------------------------------


@pytest.fixture
def plan_fails(monkeypatch):
    """`femic plan` raises an error: its exit code."""

    def plan(error):
        monkeypatch.setattr("femic.cli.plan.load_scene", Mock(side_effect=error))
        return exit_code(["plan", "flat"])

    return plan


@pytest.mark.parametrize(
    ("error", "code", "says"),
    [
        (WrongInput("a = 1: at most `tolerance`"), 2, "femic: a = 1: at most engine.tolerance"),
        (Failure("use fewer (`workers` = 1)"), 1, "femic: use fewer (--workers 1)"),
        (OSError("no space left"), 1, "femic: no space left"),
        (KeyboardInterrupt(), 130, "femic: interrupted. Finished parts are stored"),
    ],
)
def test_each_error_has_its_exit_code_and_its_message(error, code, says, plan_fails, capsys):
    assert plan_fails(error) == code
    assert capsys.readouterr().err.startswith(says)


def test_unknown_commands_are_wrong_input_and_internal_errors_are_not_hidden(plan_fails):
    assert (DONE, FAILED, WRONG_INPUT, INTERRUPTED) == (0, 1, 2, 130)
    assert exit_code(["no-such-command"]) == WRONG_INPUT
    with pytest.raises(ZeroDivisionError):
        plan_fails(ZeroDivisionError)


# --- validate, extremes ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "numbers", "tolerance"),
    [
        ((), tuple(STATEMENTS), 1e-3),
        (("--only", "3", "1", "--tolerance", "1e-4"), (3, 1), 1e-4),
        (("--tolerance", "0.02"), tuple(STATEMENTS), 0.02),
    ],
)
def test_validate_passes_statements_tolerance_and_folder(options, numbers, tolerance, recorded, command):
    calls = recorded("compare.validation.statements.page.validate", Path("there"))
    assert command("validate", *options) == DONE
    ((asked, runs, folder),) = calls
    assert (asked, runs.tolerance, folder.name) == (numbers, tolerance, "out")


@pytest.mark.parametrize("tolerance", ["0.99e-4", "0.0201"])
def test_validate_refuses_tolerances_beyond_the_limits(tolerance, recorded, command, capsys):
    calls = recorded("compare.validation.statements.page.validate")
    assert command("validate", "--tolerance", tolerance) == WRONG_INPUT
    assert f"--tolerance {float(tolerance):g}: 0.0001 ... 0.02" in capsys.readouterr().err
    assert not calls


# --- frontier, advise -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("options", "budget"), [((), 600.0), (("--budget", "7.5"), 7.5)])
def test_frontier_budget_defaults_to_ten_minutes(options, budget, recorded, command):
    calls = recorded("compare.studies.frontier.compute_frontier")
    recorded("compare.pages.frontier.summary", "")
    recorded("compare.pages.frontier.write_frontier", Path("there"))
    assert command("frontier", "flat", *options) == DONE
    assert (calls[0][0], calls[0][1].budget) == ("flat", budget)


@pytest.mark.parametrize(
    ("options", "question"),
    [
        ((), Question(("nn", "ss", "xx", "xs", "xn", "sn"), 0.02, "combined")),
        (
            ("--body", "upper", "--components", "nn,sn", "--tolerance", "0.3"),
            Question(("nn", "sn"), 0.3, "upper"),
        ),
    ],
)
def test_advise_defaults_to_what_the_scene_compares(options, question, recorded, command):
    tried = recorded("compare.studies.frontier.frontier_for", ("request", "frontier"))
    advised = recorded("compare.studies.frontier.advise", BHAT)
    recorded("compare.pages.frontier.evidence", "")
    assert command("advise", "geometry1", *options) == DONE
    assert tried[0][1] == question
    assert advised == [("frontier", question)]


def test_advice_is_about_a_contact_or_about_a_body(command, capsys):
    assert command("advise", "tall", "--want", "p_max", "--body", "upper") == WRONG_INPUT
    assert "--want, --body" in capsys.readouterr().err


# --- matrix, export, calibrate ---------------------------------------------------------------------------


@pytest.fixture
def exported(monkeypatch):
    calls = []
    formats = {"contact": lambda *arguments: calls.append(arguments[:3])}
    monkeypatch.setattr("femic.results.export.FORMATS", formats)
    return calls


@pytest.mark.parametrize(
    ("options", "ics", "discount"),
    [((), "C", None), (("--ics", "Bhat"), "Bhat", None), (("--discount", "none"), "C", "none")],
)
def test_export_defaults_to_the_ics_of_the_scene(options, ics, discount, exported, command):
    assert command("export", "flat", *options) == DONE
    ((scene, *given),) = exported
    assert [scene.ics, *given] == [ics, ics, discount]


@pytest.mark.parametrize(
    ("choice", "tolerance"), [(BHAT, 0.01), (replace(OF_C, changes={"engine": {"tolerance": 0.05}}), 0.05)]
)
def test_export_auto_uses_the_chosen_ics_and_engine(choice, tolerance, exported, recorded, command):
    """Judged on all nine components of both bodies, at the tolerance of the scene."""
    questions = recorded("compare.studies.frontier.choose", choice)
    assert command("export", "flat", "--ics", "auto") == DONE
    assert questions[0][1] == Question(COMPONENTS, 0.02, "combined")
    ((scene, ics, _),) = exported
    assert (ics, scene.settings.tolerance) == (choice.ics, tolerance)


@pytest.mark.parametrize("n", [1, 5, 6])
def test_one_to_five_scenes_are_calibrated_into_folders_of_their_own(n, recorded, command, tmp_path, capsys):
    paths = [tmp_path / f"s{k}.toml" for k in range(n)]
    for path in paths:
        path.write_text(load_scene("geometry1").text, encoding="utf-8")
    recorded("femic.results.calibration.calibrate", "fit")
    written = recorded("compare.pages.calibration.write_fit", Path("there"))
    reports = recorded("compare.pages.calibration.write_report", Path("there"))
    code, out = command("calibrate", *map(str, paths)), tmp_path / "out"
    if n > 5:
        assert "scenes: 6 given; give 1 to 5" in capsys.readouterr().err
        assert (code, written) == (WRONG_INPUT, [])
    else:
        assert (code, reports) == (DONE, [(["fit"] * n, out)])
        assert [folder for _, folder in written] == ([out] if n == 1 else [out / path.stem for path in paths])


# --- run, compare, plan ---------------------------------------------------------------------------------


def test_run_chooses_ics_only_for_auto(recorded, command, write_scene):
    recorded("compare.pages.ics_results.run_scene", Path("there"))
    questions = recorded("compare.studies.frontier.choose", OF_C)
    assert command("run", str(write_scene())) == DONE
    assert not questions
    assert command("run", str(write_scene('ics = "auto"\nics_tolerance = 0.07\nbodies = ["upper"]'))) == DONE
    question = questions[0][1]
    assert (question.body, question.tolerance) == ("upper", 0.07)


def test_compare_computes_only_scenes_without_current_results(recorded, monkeypatch, tmp_path):
    ran = recorded("compare.pages.ics_results.run_scene", Path("there"))
    recorded("compare.pages.ics_results.load", "curves")
    written = recorded("compare.pages.ics_results.write_overlay", Path("there"))
    monkeypatch.setattr("compare.pages.ics_results.up_to_date", lambda source: source.name == "flat")
    words = ["compare", "flat", "geometry1", "--results", str(tmp_path), "--workers", "1"]
    assert exit_code(words) == DONE
    assert [(scene.name, folder) for scene, folder, _ in ran] == [("geometry1", tmp_path / "geometry1")]
    assert written == [("curves", tmp_path / "flat_geometry1")]


PLANNED = ExpectedCost(1_234_567, wavenumbers=55, fields=4, half_section=True, seconds=100.4, memory=900.0)


def test_plan_shows_total_seconds_and_largest_memory(monkeypatch, capsys):
    """A solid model is solved by one of four workers, a harmonic one by all."""
    steps = [
        ModelPlan("lower, fine", HARMONIC, 1.5, 1280.0, "infinite", PLANNED),
        ModelPlan(
            "check, lower, fine", SOLID, 1.0, 320.0, "640 mm", replace(PLANNED, seconds=60.0, memory=1500.0)
        ),
    ]
    monkeypatch.setattr("femic.results.ics.run_plans", lambda *_: steps)
    monkeypatch.setattr("femic.results.matrices.matrix_plans", lambda *_: steps[:1])
    monkeypatch.setattr("femic.results.matrices.file_size", lambda _: 12.4e6)
    monkeypatch.setattr("femic.results.matrices.expected_seconds", lambda _: 2.1)
    assert exit_code(["plan", "flat", "--workers", "4"]) == DONE
    output = " ".join(capsys.readouterr().out.split())
    assert "tolerance 0.01, 4 workers" in output
    assert "64 lags of 0.4 mm, 32 strips of 0.6 mm about s = 0 mm; matrix.nc takes 12 MB" in output
    assert "about 115 s, 1500 MB" in output
    assert "about 100 s, 900 MB for the models; 2 s for the matrices" in output
    for shown in ("1,234,567", "1.5", "1280 mm", "640 mm", "infinite", "55"):
        assert shown in output
    assert re.search("lower, fine .* harmonic .* y .* 1.5 ", output)


@pytest.fixture
def plan(monkeypatch, capsys):
    """`femic plan` of a scene with changes, where each job takes one model: the jobs of contact, the text."""
    step, recorded_jobs = ModelPlan("lower, fine", HARMONIC, 1.0, 1280.0, "infinite", PLANNED), []
    for name in ("ics.run_plans", "matrices.matrix_plans"):
        monkeypatch.setattr(f"femic.results.{name}", lambda *_: [step])
    monkeypatch.setattr(
        "femic.reference.refinement.plans", lambda jobs, _: recorded_jobs.append(jobs) or [step]
    )

    def planned(name, changes=None):
        scene = load_scene(name, changes)
        monkeypatch.setattr("femic.cli.plan.load_scene", lambda _: scene)
        assert exit_code(["plan", name]) == DONE
        return scene, recorded_jobs, " ".join(capsys.readouterr().out.split())

    return planned


def test_plan_of_contact_counts_nn_on_the_grids_of_contact(plan):
    scene, (jobs,), output = plan("tall", {"contact": {"elements": 8}})
    ((grid, _),) = grids_of(scene.contact_problem)
    assert {(name, job.components, job.grid) for name, job in jobs.items()} == {
        (name, ("nn",), grid) for name in ("lower", "upper")
    }
    assert "310000 N; nn of C:" in output


def test_plan_of_contact_with_friction_counts_all_components(plan):
    _, (jobs,), output = plan("rolling")
    assert {job.components for job in jobs.values()} == {COMPONENTS}
    assert "100000 N; xx, xs, xn" in output


def test_plan_with_the_solid_engine_refuses_matrix_and_contact(plan, monkeypatch):
    small = {"contact": {"loads": [7.4e3], "elements": 8}}
    assert "engine.kind" not in plan("tall", small)[-1]
    monkeypatch.undo()
    step = ModelPlan("lower, fine", SOLID, 1.0, 320.0, "640 mm", PLANNED)
    monkeypatch.setattr("femic.results.ics.run_plans", lambda *_: [step])
    *_, output = plan("tall", small | {"engine": {"kind": "solid"}})
    for name in ("matrix", "contact"):
        assert (
            f"femic {name}: tall: 1 error(s) engine.kind = 'solid': this engine cannot compute C on a grid"
            in output
        )


@pytest.mark.parametrize("motion", ["rolling", "compression"])
def test_contact_with_friction_writes_the_page_of_its_motion(motion, recorded, monkeypatch, tmp_path):
    computed = recorded("femic.results.friction.compute_with_friction", returns="contact")
    supported = recorded("femic.results.friction.with_supports", returns=xr.Dataset(attrs={"given": "yes"}))
    written = []
    page = SimpleNamespace(write=lambda *of: written.append(of) or tmp_path / "contact.html")
    monkeypatch.setitem(PAGES, motion, page)
    assert exit_code(["contact", motion, "--ics", "A,Bhat", "--out", str(tmp_path / "here")]) == DONE
    ((scene, _, maps),) = computed
    assert (scene.name, scene.contact.ics, maps) == (motion, ("A", "Bhat"), {})
    assert [(given.name, dataset) for given, dataset, _ in supported] == [(motion, "contact")]
    ((dataset, folder),) = written
    assert (dataset.attrs, folder) == ({"given": "yes", "choice": ""}, tmp_path / "here")


def test_contact_of_several_scenes_has_a_folder_each_and_one_for_maps(recorded, command, tmp_path):
    recorded("femic.results.contact.solve_scene")
    recorded("femic.contact.supports.changed_supports")
    for step in ("to_dataset", "with_supports"):
        recorded(f"femic.results.contact.{step}", xr.Dataset())
    recorded("compare.pages.finite_elements.stored_solution")
    written = recorded("compare.pages.contact.write_contact", Path("there"))
    maps = recorded("compare.pages.contact.write_sensitivity", Path("there"))
    assert command("contact", "wide", "tall") == DONE
    out = tmp_path / "out"
    assert [folder for *_, folder, _ in written] == [out / "wide", out / "tall"]
    assert [folder for _, folder in maps] == [out]


@pytest.mark.parametrize(
    ("scenes", "message"), [((), "name at least one scene"), (("tall", "tall"), "two have the same name")]
)
def test_contact_of_no_scene_or_of_one_name_twice_is_refused(scenes, message, capsys):
    assert exit_code(["contact", *scenes]) == WRONG_INPUT
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_contact_without_bhat_writes_no_maps(tmp_path):
    assert exit_code(["contact", "wide", "tall", "--ics", "A", "--out", str(tmp_path)]) == DONE
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tall", "wide"]
