"""The command line: exit codes, files, messages, names that lead elsewhere, Ctrl-C."""

import io
import json
import os
import signal
import sys
from contextlib import redirect_stdout
from time import perf_counter, sleep

import pytest
import xarray as xr

from compare.pages import ics_results
from femic.cli import doctor
from femic.cli.doctor import Finding
from femic.cli.main import DONE, FAILED, WRONG_INPUT, delivered_interruptions, exit_code, main
from femic.reference.solid import engine as solid
from femic.shifts.specification import example
from tests.coarse import coarse_sections
from tests.compare.conftest import COARSE_ENGINE, scene_text
from tests.samples import write_head

ONE = 'bodies = ["lower"]\ncomponents = ["nn"]\nvariants = ["A", "Bhat"]'


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A run: its folder, what it says, and directions of loads and sides of bodies in 3D that it solves."""
    folder, directions, sides = tmp_path_factory.mktemp("cli"), [], []
    scene, out = folder / "mine.toml", folder / "results"
    scene.write_text(scene_text(ONE), encoding="utf-8")
    load, assemble = solid.patch_load, solid.assemble
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as printed:
        patch.setattr(solid, "patch_load", lambda *a: directions.append(a[1].direction) or load(*a))
        patch.setattr(solid, "assemble", lambda s: sides.append(s.body.side) or assemble(s))
        assert exit_code(["run", str(scene), "--out", str(out), "--workers", "1"]) == DONE
    return out, printed.getvalue(), directions, sides


def test_a_run_writes_data_and_report(ran):
    out, printed, *_ = ran
    assert str(out / "report.html") in printed.replace("\n", "")
    names = {path.name for path in out.iterdir()}
    assert {"ics.nc", "errors.nc", "report.html", "scene.toml", "curves_s1.6mm.csv"} <= names
    with xr.open_dataset(out / "ics.nc", engine="h5netcdf") as dataset:
        assert list(dataset.variant.values) == ["A", "Bhat", "C"]
        assert dataset.ic.sel(j="s", variant="C").isnull().all()  # not computed: not a number
        assert dataset.ic.sel(i="n", j="n").notnull().all()
        assert json.loads(dataset.attrs["domain"])["lower"]["far_radius"] == 60
    html = (out / "report.html").read_text(encoding="utf-8")
    assert html.count("data:image/png;base64,") > 0
    assert 'id="chart-curves"' in html
    assert "://" not in html  # self-contained


HARMONIC = "[engine]\nfar_radius = 60.0\ntolerance = 0.5\n"


def test_nn_alone_solves_only_the_normal_load(ran):
    *_, directions, sides = ran
    assert directions == [2, 2]  # the normal load on the fine and the coarse model; a far arc is given
    assert sides == [-1, -1]


def test_harmonic_run_solves_no_3d_model_and_reports_wavenumbers(write_scene, tmp_path, monkeypatch):
    monkeypatch.setattr(solid, "assemble", lambda _: pytest.fail("a 3D model"))
    path = write_scene(ONE, engine=HARMONIC)
    out = tmp_path / "results"
    with coarse_sections():
        assert exit_code(["run", str(path), "--out", str(out), "--workers", "1"]) == DONE
    with xr.open_dataset(out / "ics.nc", engine="h5netcdf") as dataset:
        models = json.loads(dataset.attrs["models"])
        assert set(models) == {"lower, fine"}
        nn = {"i": "n", "j": "n"}
        parts = dataset.estimate_mesh + dataset.estimate_truncation + dataset.estimate_wavenumbers
        xr.testing.assert_allclose(parts.sel(nn), dataset.estimate.sel(nn))
        assert dataset.estimate_wavenumbers.sel(nn).max() > 0
        assert json.loads(dataset.attrs["domain"])["lower"]["half_length"] is None
    html = (out / "report.html").read_text(encoding="utf-8")
    assert "infinite along x" in html
    assert "wavenumbers" in html
    assert 'id="chart-mesh_lower"' in html
    assert not (out / "figures").exists()  # nothing was asked for


def test_the_same_run_again_computes_nothing_unless_a_file_or_figures_are_missing(
    write_scene, tmp_path, monkeypatch
):
    path, out, computed = write_scene(ONE, engine=HARMONIC), tmp_path / "results", []
    compute = ics_results.compute
    monkeypatch.setattr(ics_results, "compute", lambda *a: computed.append(a) or compute(*a))

    def run(*options):
        with coarse_sections():
            assert exit_code(["run", str(path), "--out", str(out), "--workers", "1", *options]) == DONE
        return len(computed)

    assert [run(), run()] == [1, 1]
    (out / "curves_s1.6mm.csv").unlink()
    assert [run(), run()] == [2, 2]
    assert (out / "curves_s1.6mm.csv").exists()
    assert run("--figures", "svg") == 3
    assert list((out / "figures").glob("*.svg"))
    path.write_text(path.read_text(encoding="utf-8").replace('"A", "Bhat"', '"A"'), encoding="utf-8")
    assert run() == 4


def test_wrong_input_exits_with_2_and_writes_nothing(write_scene, tmp_path, capsys):
    out = tmp_path / "results"
    for bad in ("[lower", 'variants = ["D"]', "unknown = 1"):
        assert exit_code(["run", str(write_scene(bad)), "--out", str(out)]) == WRONG_INPUT
        assert "mine.toml" in capsys.readouterr().err
    assert exit_code(["run", "nowhere.toml", "--out", str(out)]) == WRONG_INPUT
    assert exit_code(["run", "flat", "--sped", "3", "--out", str(out)]) == WRONG_INPUT
    assert "neither a file nor a built-in scene" in capsys.readouterr().err
    assert not out.exists()


def test_not_converged_exits_with_1_and_says_what_to_try(write_scene, tmp_path, capsys):
    strict = COARSE_ENGINE.replace("tolerance = 0.5", "tolerance = 1e-4\nmost_unknowns = 8_000")
    path = write_scene(ONE.replace("lower", "combined"), engine=strict)
    out = tmp_path / "results"
    assert exit_code(["run", str(path), "--out", str(out), "--workers", "1"]) == FAILED
    assert "Try a larger engine.tolerance" in capsys.readouterr().err
    assert not (out / "report.html").exists()


@pytest.mark.parametrize(
    ("words", "code", "shown"),
    [
        ("scenes", DONE, "geometry1"),
        ("scenes --show flat", DONE, 'kind = "plane"'),
        ("shifts --show s1002-on-60e1-worn", DONE, 'profile = "60E1-worn"'),
        ("shifts --show", DONE, 'profile = "60E1"'),
        ("shifts mine.toml --show", WRONG_INPUT, "s1002-on-60e1-worn"),
    ],
)
def test_scenes_and_wheelsets_are_listed_and_shown(words, code, shown, capsys):
    assert exit_code(words.split()) == code
    printed = capsys.readouterr()
    assert shown in (printed.err if code else printed.out)


# --- names that lead elsewhere, that are no UTF-8, or that terminals cannot write ------------------------

AS_RAIL = ["--kind", "rail", "--axes", "field"]


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The working directory, with a folder of files of results in it."""
    (tmp_path / "work" / "d").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


def files(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize("name", ["...txt", ". .txt", "..txt", "bell\x07.txt"])
def test_names_of_no_folder_are_refused_and_nothing_is_written(name, place, capsys):
    before = [f"work/d/{name}"]
    for write, command in (
        (write_head, ["profiles", f"d/{name}", *AS_RAIL]),
        (lambda path: path.write_text(example(), encoding="utf-8"), ["shifts", f"d/{name}", "--write", "0"]),
    ):
        write(place / "d" / name)
        assert exit_code(command) == WRONG_INPUT
        said = capsys.readouterr().err
        assert repr(f"d/{name}") in said
        assert "rename it" in said
        assert files(place.parent) == before


@pytest.mark.parametrize("words", [["run", "a\udcff.toml"], ["shifts", "s1002-on-60e1", "--out", "\udcfe"]])
def test_names_that_are_no_utf_8_are_refused_before_any_work(words, place, capsys):
    assert exit_code(words) == WRONG_INPUT
    said = capsys.readouterr().err
    assert "the name is not valid UTF-8; rename the file or folder" in said
    assert "\\udcf" in said
    assert files(place) == []


def test_a_working_directory_that_is_no_utf_8_is_refused(place, monkeypatch, capsys):
    (place / "w\udcff").mkdir()
    monkeypatch.chdir(place / "w\udcff")
    assert exit_code(["scenes"]) == WRONG_INPUT
    assert "w\\udcff" in capsys.readouterr().err


def test_folders_with_brackets_are_printed_as_they_are(place, capsys):
    write_head(place / "mine.txt")
    assert exit_code(["profiles", "mine.txt", *AS_RAIL, "--out", "[/a]"]) == DONE
    assert "Report: [/a]/mine/profile.html" in capsys.readouterr().out


def test_terminals_get_question_marks_for_letters_that_they_do_not_have(monkeypatch):
    finding = Finding("B̂ [/b]", True, "à")
    monkeypatch.setattr(doctor, "findings", lambda: [finding])
    terminal = io.TextIOWrapper(io.BytesIO(), encoding="latin-1")
    monkeypatch.setattr(sys, "stdout", terminal)
    with pytest.raises(SystemExit) as ended:
        main(["doctor"])
    assert ended.value.code == DONE
    terminal.flush()
    said = terminal.buffer.getvalue().decode("latin-1")
    assert "ok  B? [/b]  à" in said
    assert "This installation is in order." in said


# --- Ctrl-C at a moment when Python cannot raise it ------------------------------------------------------


class Interrupted:
    """Something whose destructor is running when Ctrl-C is pressed."""

    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(autouse=True)
def _keyboard():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def work():
    Interrupted()
    sleep(60.0)


def test_interruption_in_a_destructor_ends_the_work():
    start = perf_counter()
    with pytest.raises(KeyboardInterrupt), delivered_interruptions():
        work()
    assert perf_counter() - start < 30.0  # it does not wait for the end of a blocking call


def test_other_errors_in_destructors_reach_the_previous_hook(monkeypatch):
    forwarded = []
    monkeypatch.setattr(sys, "unraisablehook", forwarded.append)

    class Failing:
        def __del__(self):
            raise ValueError

    with delivered_interruptions():
        Failing()
    assert [error.exc_type for error in forwarded] == [ValueError]
