"""An engine that is only registered: every command that takes a scene works with it or says why not."""

from unittest.mock import Mock

import numpy as np
import pytest
import xarray as xr

from femic.cli.main import DONE, FAILED, WRONG_INPUT, exit_code
from femic.reference.engines import ENGINES
from geometries.errors import Failure
from tests.compare.conftest import scene_text
from tests.femic.reference.closed_engine import CLOSED

LINES = '[[lines]]\nalong = "x"\ns = 1.6\nreach = 6.0\npoints = 9\n'
OTHERS = "[grid]\nn_x = 4\nn_s = 3\n[contact]\nloads = [100.0]\nelements = 8\n"
NO_MATRICES = "engine.kind = 'closed': has no C on a grid, as matrices and contact need it: use engine.kind"


@pytest.fixture
def femic(tmp_path, monkeypatch, capsys):
    """Run a command on a small scene with the engine: its exit code, and all that it has printed."""
    monkeypatch.setitem(ENGINES, "closed", CLOSED)
    monkeypatch.chdir(tmp_path)
    text = scene_text('components = ["nn", "xn"]', lines=LINES, engine=f'[engine]\nkind = "closed"\n{OTHERS}')
    lower, upper = text.replace("b = 0.2", "b = 0.5").split("[upper]\n")
    scene = tmp_path / "mine.toml"
    wheel = f"[upper]\nrolling_radius = 500.0\n{upper}".replace("radius = 10.0", "radius = 11.0", 1)
    scene.write_text(lower + wheel, encoding="utf-8")

    def run(command, *options):
        code = exit_code([command, str(scene), *options])
        printed = capsys.readouterr()
        return code, " ".join((printed.out + printed.err).split())

    return run


def test_run_has_the_c_of_the_registered_engine(femic, tmp_path):
    code, output = femic("run")
    assert (code, "Report:" in output) == (DONE, True)
    with xr.open_dataset(tmp_path / "out" / "mine" / "ics.nc", engine="h5netcdf") as ics:
        assert CLOSED.description in str(ics.attrs)
        c, a = (ics.ic.sel(variant=variant, body="lower", i="n", j="n").values for variant in ("C", "A"))
    np.testing.assert_allclose(c, a, rtol=0.02)  # half-spaces, whatever the bodies are


@pytest.mark.parametrize("command", ["matrix", "contact", "fe-contact", "export"])
def test_commands_that_need_matrices_refuse_the_engine_before_any_work(command, femic, tmp_path):
    code, output = femic(command)
    assert (code, NO_MATRICES in output) == (WRONG_INPUT, True)
    assert "engine.kind = 'harmonic'" in output
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["contact", "export"])
def test_commands_without_c_accept_the_engine(command, femic):
    code, output = femic(command, "--ics", "A")
    assert (code, "engine" in output) == (DONE, False), output


def test_frontier_has_the_default_tolerances_of_the_engine(femic, tmp_path, monkeypatch):
    # to plan takes none of the budget
    monkeypatch.setattr("compare.studies.frontier.perf_counter", lambda: 0.0)
    code, _ = femic("frontier", "--components", "nn,xn", "--budget", "1")
    assert code == DONE
    with xr.open_dataset(tmp_path / "out" / "mine" / "frontier.nc", engine="h5netcdf") as frontier:
        ways = [str(way) for way in frontier.way.values if str(frontier.kind.sel(way=way).item()) == "closed"]
        assert sorted(ways) == ["closed 0.01", "closed 0.1"]
        assert "harmonic 0.0001" in frontier.attrs["skipped"]


def test_advice_measures_against_c_of_the_engine(femic):
    code, output = femic("advise", "--components", "nn", "--body", "lower", "--tolerance", "0.5")
    assert (code, "Use " in output) == (DONE, True)
    assert "closed" in output
    assert "harmonic" not in output


def test_plan_shows_models_and_refuses_matrices(femic):
    code, output = femic("plan")
    assert (code, "closed" in output) == (DONE, True)
    assert output.count(NO_MATRICES) == 2  # of `femic matrix` and `femic contact`


def test_show_draws_with_the_solid_engine(femic, monkeypatch):
    monkeypatch.setattr("compare.pages.body_fields._write_solved", Mock(side_effect=Failure("solved")))
    code, output = femic("show")
    assert (code, "(solid engine)" in output) == (FAILED, True)


def test_calibrate_accepts_or_refuses_the_engine_with_a_message(femic):
    code, output = femic("calibrate")
    assert code in (DONE, FAILED, WRONG_INPUT)
    assert output


def test_unregistered_engine_is_refused_with_the_known_names(femic, monkeypatch):
    monkeypatch.delitem(ENGINES, "closed")
    code, output = femic("run")
    assert code == WRONG_INPUT
    assert "engine.kind = 'closed': Input should be 'harmonic' or 'solid'" in output
