"""The command line: exit codes, files, messages."""

import json
from contextlib import redirect_stdout
from io import StringIO

import pytest
import xarray as xr

from compare.report.interactive import plotly_js
from femic.cli.main import DONE, FAILED, INTERRUPTED, WRONG_INPUT, exit_code
from femic.reference.solid import engine as solid
from tests.compare.conftest import COARSE_ENGINE, scene_text

ONE = 'bodies = ["lower"]\ncomponents = ["nn"]\nvariants = ["A", "Bhat"]'


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A run: its folder, what it says, and directions of loads and sides of bodies in 3D that it solves."""
    folder, directions, sides = tmp_path_factory.mktemp("cli"), [], []
    scene, out = folder / "mine.toml", folder / "results"
    scene.write_text(scene_text(ONE), encoding="utf-8")
    load, assemble = solid.patch_load, solid.assemble
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()) as printed:
        patch.setattr(solid, "patch_load", lambda *a: directions.append(a[1].direction) or load(*a))
        patch.setattr(solid, "assemble", lambda s: sides.append(s.body.side) or assemble(s))
        assert exit_code(["run", str(scene), "--out", str(out), "--workers", "1"]) == DONE
    return out, printed.getvalue(), directions, sides


def test_a_run_writes_data_figures_and_report(ran):
    out, printed, *_ = ran
    assert str(out / "report.html") in printed.replace("\n", "")
    names = {path.name for path in out.iterdir()}
    assert {"ics.nc", "errors.nc", "report.html", "scene.toml", "figures", "curves_s1.6mm.csv"} <= names
    with xr.open_dataset(out / "ics.nc", engine="h5netcdf") as dataset:
        assert list(dataset.variant.values) == ["A", "Bhat", "C"]
        assert dataset.ic.sel(j="s", variant="C").isnull().all()  # not computed: not a number
        assert dataset.ic.sel(i="n", j="n").notnull().all()
        assert json.loads(dataset.attrs["domain"])["lower"]["far_radius"] == 60
    html = (out / "report.html").read_text(encoding="utf-8").replace(plotly_js(), "")
    for kind, ending in (("png", "png"), ("svg+xml", "svg")):
        files = list((out / "figures").glob(f"*.{ending}"))
        assert html.count(f"data:image/{kind};base64,") == len(files) > 0
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
    assert (out / "figures/mesh_lower.png").is_file()


@pytest.mark.parametrize("bad", ["[lower", 'variants = ["D"]', "unknown = 1"])
def test_wrong_input_exits_with_2_and_writes_nothing(bad, write_scene, tmp_path, capsys):
    out = tmp_path / "results"
    assert exit_code(["run", str(write_scene(bad)), "--out", str(out)]) == WRONG_INPUT
    assert not out.exists()
    assert "mine.toml" in capsys.readouterr().err


def test_missing_scene_and_unknown_option_exit_with_2(capsys):
    assert exit_code(["run", "nowhere.toml"]) == WRONG_INPUT
    assert exit_code(["run", "flat", "--sped", "3"]) == WRONG_INPUT
    assert "no such file" in capsys.readouterr().err


@pytest.mark.parametrize("bodies", ["combined", "lower"])
def test_not_converged_exits_with_1_and_says_what_to_try(bodies, write_scene, tmp_path, capsys):
    strict = COARSE_ENGINE.replace("tolerance = 0.5", "tolerance = 1e-4\nmost_unknowns = 20_000")
    path = write_scene(ONE.replace("lower", bodies), engine=strict)
    out = tmp_path / "results"
    assert exit_code(["run", str(path), "--out", str(out), "--workers", "1"]) == FAILED
    assert "Try a larger engine.tolerance" in capsys.readouterr().err
    assert not (out / "report.html").exists()


def test_an_interruption_exits_with_130(write_scene, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("compare.pages.ics_results.run_scene", interrupted)
    assert exit_code(["run", str(write_scene(ONE)), "--out", str(tmp_path / "o")]) == INTERRUPTED


def test_scenes_are_listed_and_shown(capsys):
    assert exit_code(["scenes"]) == DONE
    assert "geometry1" in capsys.readouterr().out
    assert exit_code(["scenes", "--show", "flat"]) == DONE
    assert 'kind = "plane"' in capsys.readouterr().out


def test_specifications_of_wheelsets_are_shown_by_name(capsys):
    assert exit_code(["shifts", "--show", "s1002-on-60e1-worn"]) == DONE
    assert 'profile = "60E1-worn"' in capsys.readouterr().out
    assert exit_code(["shifts", "--show"]) == DONE
    assert 'profile = "60E1"' in capsys.readouterr().out
    assert exit_code(["shifts", "mine.toml", "--show"]) == WRONG_INPUT
    assert "s1002-on-60e1-worn" in capsys.readouterr().err
