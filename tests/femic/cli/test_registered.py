"""A contour, approximations and an engine that are registered once: scenes, listings, commands know them."""

from typing import Literal
from unittest.mock import Mock

import numpy as np
import pytest
import xarray as xr
from pydantic import Field

from femic.cli.main import DONE, FAILED, WRONG_INPUT, exit_code
from femic.key_types import Length
from femic.reference.engines import ENGINES
from femic.scenes.bodies import CONTOURS
from femic.scenes.errors import BadScene
from femic.scenes.listing import listing
from femic.scenes.load import load_scene
from femic.scenes.scene_table import SceneTable
from geometries import contours
from geometries.errors import Failure
from tests.approx.new_forms import register
from tests.compare.conftest import scene_text
from tests.femic.reference.closed_engine import CLOSED
from tests.femic.reference.stand_ins import b_hat_as_c

ARC = 'kind = "arc", radius = 10.0, flank_inclination_deg = 25.0'
PARABOLA = 'kind = "parabola", crown_radius = 10.0, width = 8.0'
LINE = '[[lines]]\nalong = "x"\ns = 0.5\nreach = 2.0\npoints = 5\n'
COARSE = "[engine]\ntolerance = 0.5\nfar_radius = 60.0\n"


class Parabola(SceneTable):
    """z = -y^2 / (2 R) between y = -w and w."""

    kind: Literal["parabola"] = Field(description="parabola + straight flanks")
    crown_radius: Length = Field(description="radius of curvature of its crown [mm]")
    width: Length = Field(description="half of its width along y [mm]")

    def contour(self):
        """Return the spline through its points."""
        y = np.linspace(-self.width, self.width, 41)
        return contours.through_points(y, -(y**2) / (2 * self.crown_radius))


@pytest.fixture
def parabola(monkeypatch, tmp_path):
    """A scene of two parabolas: the file."""
    monkeypatch.setitem(CONTOURS, "parabola", Parabola)
    path = tmp_path / "mine.toml"
    bodies = scene_text('bodies = ["lower"]\ncomponents = ["nn"]', lines=LINE, engine=COARSE)
    path.write_text(bodies.replace(ARC, PARABOLA).replace("reach = 10.0", "reach = 5.0"), encoding="utf-8")
    return path


def test_registered_contour_shapes_a_body(parabola):
    contour = load_scene(str(parabola)).bodies["lower"].contour
    y, z = contour.position(np.array([-3.0, 0.0, 2.0]))
    np.testing.assert_allclose(z, -(y**2) / 20, atol=1e-5)


def test_keys_of_a_registered_contour_are_listed_and_checked(parabola):
    assert 'kind = "parabola": parabola + straight flanks' in listing("flat")
    assert "#     crown_radius: radius of curvature of its crown [mm]" in listing(str(parabola))
    parabola.write_text(parabola.read_text().replace("width = 8.0", "witdh = 8.0"))
    with pytest.raises(BadScene, match=r"lower\.contour\.witdh: unknown key; did you mean 'width'\?"):
        load_scene(str(parabola))


@pytest.mark.parametrize("kind", ["parabola", 3, ["arc"]])
def test_unregistered_kind_is_refused_with_the_known_kinds(kind):
    with pytest.raises(BadScene, match=r"lower\.contour\.kind = .*Input should be ('plane'|a valid string)"):
        load_scene("flat", {"lower": {"contour": {"kind": kind, "width": 8.0}}})


def test_commands_take_a_registered_contour(parabola, tmp_path, monkeypatch):
    b_hat_as_c(monkeypatch)
    assert exit_code(["scenes", "--show", str(parabola)]) == DONE
    assert exit_code(["run", str(parabola), "--out", str(tmp_path / "out"), "--workers", "1"]) == DONE
    nn = xr.load_dataset(tmp_path / "out" / "ics.nc").ic.sel(i="n", j="n", body="lower")
    np.testing.assert_allclose(nn.sel(variant="C"), nn.sel(variant="Bhat"), rtol=1e-9)


# --- approximations ------------------------------------------------------------------------------------


NEW = "Btilde", "Bfaded"
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
        lower, upper = scene_text(FEW, engine=COARSE).split("[upper]\n")
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


# --- an engine: each command works with it or says why not ---------------------------------------------


LINES = '[[lines]]\nalong = "x"\ns = 1.6\nreach = 6.0\npoints = 9\n'
OTHERS = "[grid]\nn_x = 4\nn_s = 3\n[contact]\nloads = [100.0]\nelements = 8\n"
NO_MATRICES = (
    "engine.kind = 'closed': this engine cannot compute C on a grid, which matrices and contact need; "
    "use engine.kind"
)


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
