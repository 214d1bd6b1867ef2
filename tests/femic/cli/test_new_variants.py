"""Variants that a user registers, on the command line."""

import numpy as np
import pytest
import xarray as xr

from femic.cli.main import DONE, WRONG_INPUT, exit_code
from femic.scenes.listing import listing
from femic.scenes.load import load_scene
from tests.approx.new_forms import register
from tests.compare.conftest import scene_text
from tests.femic.reference.stand_ins import b_hat_as_c

NEW = "Btilde", "Bfaded"
HARMONIC = "[engine]\nfar_radius = 60.0\ntolerance = 0.5\n"
CONTACT = """
[contact]
motion = "{motion}"
loads = [2e3]
elements = 8
ics = ["Btilde", "Bfaded", "Bhat+nn:Btilde"]
"""
FEW = 'bodies = ["lower"]\ncomponents = ["nn", "sn"]\nvariants = ["B", "Btilde", "Bfaded"]'


@pytest.fixture
def scene(tmp_path):
    """Write a scene with a wheel that is a little wider than the rail; returns its path."""

    def written(motion):
        lower, upper = scene_text(FEW, engine=HARMONIC).split("[upper]\n")
        wheel = f"[upper]\nrolling_radius = 300.0\n{upper}".replace("radius = 10.0", "radius = 11.0")
        path = tmp_path / "mine.toml"
        path.write_text(lower + wheel + CONTACT.format(motion=motion), encoding="utf-8")
        return str(path)

    return written


def test_run_compares_new_variants_with_c(scene, tmp_path, monkeypatch):
    register(monkeypatch)
    b_hat_as_c(monkeypatch)
    assert exit_code(["run", scene("none"), "--out", str(tmp_path / "out"), "--workers", "1"]) == DONE
    loaded = load_scene(str(tmp_path / "mine.toml"))
    with xr.open_dataset(tmp_path / "out/ics.nc", engine="h5netcdf") as dataset:
        ics = dataset.ic.sel(body="lower", j="n", i=["s", "n"])
        assert list(ics.variant.values) == ["B", "Btilde", "Bfaded", "C"]
        points = dataset.x.values, dataset.s.values
    for variant in NEW:
        expected = loaded.pair.lower.approximate(variant, loaded.patch, points)[1:, 2] / loaded.patch.area
        np.testing.assert_allclose(ics.sel(variant=variant), expected, rtol=1e-12)
    assert "symbol of Btilde" in (tmp_path / "out/report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "motion",
    ["none", *(pytest.param(motion, marks=pytest.mark.slow) for motion in ("compression", "transient"))],
)
def test_contact_is_solved_with_new_variants(motion, scene, tmp_path, monkeypatch):
    """Without friction nn alone counts."""
    register(monkeypatch)
    assert exit_code(["contact", scene(motion), "--out", str(tmp_path / "out"), "--workers", "1"]) == DONE
    with xr.open_dataset(tmp_path / "out/contact.nc", engine="h5netcdf") as dataset:
        approach = {
            name: float(dataset.approach.sel(ics=name).values.ravel()[-1]) for name in dataset.ics.values
        }
    same_nn = pytest.approx(approach["Btilde"], rel=1e-8) == approach["Bhat+nn:Btilde"]
    assert same_nn == (motion == "none")
    assert approach["Bfaded"] != pytest.approx(approach["Btilde"], rel=1e-5)


def test_new_variants_are_listed_and_unknown_names_refused(scene, tmp_path, monkeypatch, capsys):
    for command, message in (
        (["run", scene("none")], "variants.1 = 'Btilde': Input should be 'A', 'B', 'Bbar'"),
        (["contact", "flat", "--ics", "Bfaded"], "variant = 'Bfaded': one of A, B"),
    ):
        assert exit_code([*command, "--out", str(tmp_path / "out")]) == WRONG_INPUT
        assert message in " ".join(capsys.readouterr().err.split())
    register(monkeypatch)
    assert '"Btilde", "Btilde_prime", "Bfaded"' in listing("flat")
