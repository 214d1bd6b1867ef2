"""Where results go and how they are computed; how wrong scenes are told; how far both contours go."""

import shutil
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from rich.console import Console

from compare.report.charts import Curve, Panel, simple_chart
from compare.report.parts import Folded, Page, Section, write_page
from femic.cache.digests import code_digest
from femic.cache.folders import LOCK, locked
from femic.cli.main import FAILED, WRONG_INPUT, exit_code
from femic.cli.work import Work, announce, store_at
from femic.reference.run_options import cores
from femic.scenes.errors import BadScene, require_none
from femic.scenes.load import load_scene
from geometries.bodies import common_extent
from geometries.errors import WrongInput
from tests.femic.scenes.changes import line


def test_results_go_to_a_folder_of_the_scene_by_one_worker_per_core_unless_others_are_named():
    scene = load_scene("geometry1")
    assert (Work().folder(scene), Work().threads) == (Path("out/geometry1"), cores())
    assert (Work(out=Path("there")).folder(scene), Work(workers=3).threads) == (Path("there"), 3)


# --- stores ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("location", "reason"),
    [
        ("foo://x", "Protocol not known: foo: give a folder, or"),
        ("memory://x", r"cannot write there \(RuntimeError: no credentials\)\. Give a folder"),
        *((place, r"cannot write there \(.*\)\. Give a folder") for place in ("FILE", "FILE/below")),
        ("http://127.0.0.1:9/x", r"cannot write there \(.*\)\. Give a folder"),
    ],
)
def test_a_store_where_nothing_can_be_stored_is_refused_before_the_work(
    location, reason, tmp_path, monkeypatch
):
    no_access = Mock(side_effect=RuntimeError("no credentials"))
    monkeypatch.setattr("fsspec.implementations.memory.MemoryFileSystem.pipe_file", no_access)
    monkeypatch.chdir(tmp_path)
    Path("FILE").touch()
    with pytest.raises(WrongInput, match=rf"--store {location}: {reason}"):
        store_at(location, tmp_path)


def test_models_are_stored_without_a_trace_in_the_folder_of_the_results_unless_a_place_is_named(tmp_path):
    assert store_at(None, tmp_path).location == tmp_path / "store"
    assert store_at("memory://elsewhere", tmp_path).location == "memory://elsewhere"
    own = tmp_path / "new" / "store"
    store_at(str(own), tmp_path)
    assert list((tmp_path / "new").rglob("*")) == [own]


def test_models_of_other_code_are_removed_from_the_own_folder_only(tmp_path):
    folders = [tmp_path / "store" / name for name in ("0123456789ab", code_digest(), "notes")]
    for folder in folders:
        folder.mkdir(parents=True)
    store_at(str(tmp_path / "store"), tmp_path)
    assert all(folder.is_dir() for folder in folders)
    store_at(None, tmp_path)
    assert [folder.is_dir() for folder in folders] == [False, True, True]


# --- options and scenes ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "number"),
    [*(("run", number) for number in ("-1", "0", "1.5", "1e2", "1" + 400 * "0"))]
    + [(command, "0") for command in ("contact", "sweep", "shifts", "compare", "plan")],
)
def test_impossible_numbers_of_workers_are_refused(command, number, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert exit_code([command, "flat", "--workers", number]) == WRONG_INPUT
    assert "--workers" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_run_options_have_workers_store_and_watch(tmp_path):
    with Work(workers=3).options(tmp_path, Console(quiet=True)) as options:
        assert options.workers == 3
        assert options.store.location == tmp_path / "store"
        options.watch.on_stage("heard")


def test_all_misfits_are_reported_at_once():
    require_none("mine", iter(()))
    with pytest.raises(BadScene, match=r"mine: 2 error\(s\)\n  a = 1: too small\n  b = 2: too large"):
        require_none("mine", iter(["a = 1: too small", "b = 2: too large"]))


def test_contours_go_as_far_as_the_shorter_one():
    points = np.array([[y, y**2 / 40] for y in np.linspace(-9.0, 6.0, 16)])
    lower = {"contour": {"kind": "points", "points": points.tolist()}}
    scene = load_scene("flat", {"lower": lower, "rotation_reach": 4.0} | line("x", 0.0, 5.0))
    low, high = scene.extent
    assert -9.6 < low < -9.0
    assert 6.0 < high < 6.4
    assert common_extent({"upper": scene.bodies["upper"]}) == (-np.inf, np.inf)


# --- folders of results ---------------------------------------------------------------------------------

COMMANDS = {  # by name: arguments, and the folders in results/ that each writes to
    "run": (["flat", "--out", "one"], ["one"]),
    "matrix": (["geometry2", "--out", "one"], ["one"]),
    "contact": (["wide", "tall"], ["out/wide", "out/tall", "out/wide_tall"]),
    "fe-contact": (["tall", "--out", "one"], ["one"]),
    "calibrate": (["geometry1", "geometry2", "--out", "."], ["geometry1", "geometry2", "."]),
    "export": (["geometry2", "--out", "one"], ["one"]),
    "frontier": (["flat", "--out", "one"], ["one"]),
    "advise": (["flat", "--out", "one"], ["one"]),
    "validate": (["--only", "1", "--out", "one"], ["one"]),
    "extremes": (["--of", "analytic", "--out", "one"], ["one"]),
    "compare": (["geometry1", "geometry2", "--results", "."], ["geometry1", "geometry1_geometry2"]),
}
USED = [(name, folder) for name, (_, folders) in COMMANDS.items() for folder in folders]


@pytest.fixture
def nothing_begins(tmp_path, monkeypatch):
    """In an empty folder, where work would be shown as begun."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("femic.cli.progress.show_progress", lambda _: pytest.fail("work began"))


@pytest.mark.usefixtures("nothing_begins")
@pytest.mark.parametrize(("name", "folder"), USED)
def test_commands_refuse_a_folder_in_use_or_in_which_nothing_can_be_written(name, folder, capsys):
    with locked(Path(folder)):
        assert exit_code([name, *COMMANDS[name][0]]) == FAILED
        assert [path.name for path in Path(folder).iterdir() if path.is_file()] == [LOCK]
    assert "another femic run writes there" in capsys.readouterr().err
    if folder == ".":
        Path("figures").touch()
    else:
        shutil.rmtree(folder)
        Path(folder).touch()
    assert exit_code([name, *COMMANDS[name][0]]) == WRONG_INPUT
    assert "--out" in capsys.readouterr().err


def written_page(folder, *blocks):
    """A page with one chart, and further blocks, in the folder of a scene."""
    chart = simple_chart("one", [Panel("", "s [mm]", "p [MPa]", [Curve("A", [0.0, 1.0], [1.0, 2.0])])])
    return write_page(Page("Contact", "", [Section("", [chart, *blocks])]), folder / "contact.html")


@pytest.mark.parametrize(
    ("formats", "names"),
    [
        ((), set()),
        (("svg", "pdf"), {"one.svg", "one.pdf", "two.svg", "two.pdf"}),
    ],
)
def test_figures_are_written_in_the_formats_named_and_none_without(tmp_path, formats, names):
    with Work(figures=formats).options(tmp_path, Console(quiet=True)):
        written_page(
            tmp_path,
            Folded("more", [simple_chart("two", [Panel("", "x", "y", [Curve("A", [0, 1], [0, 1])])])]),
        )
    assert {path.name for path in tmp_path.glob("figures/*")} == names


def test_pages_in_the_folder_of_all_results_are_listed_there(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    elsewhere = written_page(tmp_path / "elsewhere" / "mine")
    announce(elsewhere, Console())
    assert not list(tmp_path.rglob("index.html"))
    announce(written_page(Path("out/mine")), Console())
    assert 'href="mine/contact.html"' in Path("out/index.html").read_text(encoding="utf-8")
    assert "Report: out/mine/contact.html" in capsys.readouterr().out
