"""`femic show` and `fields = true`: files, messages, exit codes, pictures."""

import io
import sys
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.image import imread

from compare.pages.body_fields import show
from compare.report import views
from femic.cli.main import DONE, FAILED, WRONG_INPUT, exit_code
from femic.scenes.listing import listing
from femic.scenes.load import load_scene
from tests.compare.conftest import FINER_ENGINE, scene_text
from tests.compare.pages import without_pictures

ONE = 'bodies = ["upper"]\ncomponents = ["nn"]\nvariants = ["A"]'
FILES = Path("out/mine/show")


@pytest.fixture(autouse=True)
def no_screen(monkeypatch, tmp_path):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def renders():
    if not views.can_render():
        pytest.skip(views.NO_RENDERING)


@pytest.fixture
def drawn(monkeypatch):
    """What would be drawn: (PNG, title, in a window) each."""
    pictures = []
    monkeypatch.setattr(
        views, "draw_fields", lambda _, png, title, window: pictures.append((png, title, window))
    )
    monkeypatch.setattr(views, "can_render", lambda: True)
    return pictures


def quarters(png):
    """The four panels of a picture as (height, width, 3) in 0 ... 1."""
    pixels = imread(png)[..., :3]
    assert pixels.shape == (1200, 1600, 3)
    return [half for row in np.split(pixels, 2) for half in np.split(row, 2, axis=1)]


@pytest.fixture(scope="module")
def picture(tmp_path_factory):
    """The folder of a scene whose body is solved under a load along s and drawn once, and what is said."""

    @cache
    def of(body):
        folder = tmp_path_factory.mktemp("drawn")
        (folder / "mine.toml").write_text(scene_text(), encoding="utf-8")
        with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as printed:
            patch.chdir(folder)
            command = ["show", "mine.toml", "--body", body, "--load", "s", "--out", "elsewhere/first.png"]
            assert exit_code(command) == DONE
        return folder, printed.getvalue()

    return of


@pytest.mark.usefixtures("renders")
@pytest.mark.parametrize("body", ["lower", pytest.param("upper", marks=pytest.mark.slow)])
def test_a_scene_is_solved_and_drawn(body, picture):
    folder, printed = picture(body)
    assert (folder / FILES / f"{body}_s.vtu").is_file()
    assert "elsewhere/first.png" in printed
    panels = quarters(folder / "elsewhere/first.png")
    for panel in panels:
        assert 0.1 < np.mean(panel.min(axis=2) < 0.95) < 0.9  # something on white
        assert np.any(panel[10:50, 20:300].max(axis=2) < 0.3)  # a caption
    red, green, blue = np.moveaxis(panels[2] - panels[2].min(axis=2, keepdims=True), 2, 0)
    assert np.mean(blue > red + 0.2) > 0.005  # large displacements are blue
    red, green, blue = np.moveaxis(panels[3] - panels[3].min(axis=2, keepdims=True), 2, 0)
    assert np.mean(red > np.maximum(green, blue) + 0.3) > 0.005  # large stresses red


@pytest.mark.usefixtures("renders")
def test_picture_of_a_file_is_written_beside_it(picture, capsys):
    folder, _ = picture("lower")
    first, again = folder / "elsewhere/first.png", folder / FILES / "lower_s.png"
    assert not again.exists()
    assert exit_code(["show", str(folder / FILES / "lower_s.vtu")]) == DONE
    assert str(again) in capsys.readouterr().out.replace("\n", "")
    assert {path.name for path in (folder / FILES).iterdir()} == {"lower_s.vtu", "lower_s.png"}
    for one, other in list(zip(quarters(first), quarters(again), strict=True))[1:]:
        np.testing.assert_allclose(one, other, atol=0.01)  # all but the title


def test_the_first_solved_body_and_the_normal_load_are_the_default(write_scene, drawn):
    """Another body is drawn also where the scene does not compare it."""
    scene = str(write_scene(ONE))
    assert exit_code(["show", scene]) == DONE
    assert drawn == [(FILES / "upper_n.png", "mine, upper body, 1 N along +n", False)]
    assert (FILES / "upper_n.vtu").is_file()
    assert exit_code(["show", scene, "--body", "lower", "--load", "x"]) == DONE
    assert drawn[1][0] == FILES / "lower_x.png"


@pytest.mark.usefixtures("drawn")
def test_contact_surfaces_face_the_camera(write_scene):
    path = str(write_scene())
    for body, from_above in (("lower", True), ("upper", False)):
        assert exit_code(["show", path, "--body", body]) == DONE
        loaded = views.read_loaded_body(FILES / f"{body}_n.vtu")
        assert (loaded.seen_from[2] > 0) == from_above
        np.testing.assert_allclose(loaded.centre, 0, atol=1e-12)
        assert 0.3 < loaded.reach < 5  # the patch has half-sides 0.3 and 0.2 mm


def test_without_rendering_the_file_is_written_all_the_same(write_scene, monkeypatch, capsys):
    monkeypatch.setattr(views, "can_render", lambda: False)
    assert exit_code(["show", str(write_scene(ONE))]) == FAILED
    assert "apt-get install libegl1" in capsys.readouterr().err
    assert [path.name for path in FILES.iterdir()] == ["upper_n.vtu"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--window"], "no screen"),
        (["--out", "picture.jpg"], ".png"),
        (["--load", "q"], "load"),
        (["--body", "combined"], "body"),
    ],
)
def test_wrong_options_exit_with_2_before_any_work(options, message, write_scene, capsys):
    assert exit_code(["show", str(write_scene(ONE)), *options]) == WRONG_INPUT
    assert message in capsys.readouterr().err
    assert not Path("out").exists()


def test_wrong_files_exit_with_2(capsys):
    pyvista = pytest.importorskip("pyvista")
    pyvista.ImageData(dimensions=(2, 2, 2)).cast_to_unstructured_grid().save("other.vtu")
    for command, message in (
        (["nowhere.vtu"], "no such file"),
        (["other.vtu"], "von_mises"),
        (["other.vtu", "--body", "lower"], "--body"),
        (["nowhere"], "Built-in"),
    ):
        assert exit_code(["show", *command]) == WRONG_INPUT
        assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("platform", "display", "is_there"), [("linux", ":0", True), ("darwin", "", True), ("linux", "", False)]
)
def test_a_window_opens_where_there_is_a_screen(monkeypatch, drawn, platform, display, is_there):
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setattr(views, "read_loaded_body", lambda path: path)
    asked = (None, True, False) if is_there else (None, False)
    for window in asked:
        list(show("a.vtu", None, None, None, window))
    assert [window for *_, window in drawn] == [is_there and window is not False for window in asked]


def test_a_run_writes_the_fields_of_the_finest_model_on_request(write_scene, capsys):
    pyvista = pytest.importorskip("pyvista")
    path = write_scene(f"fields = true\n{ONE}", engine=FINER_ENGINE)
    with without_pictures():
        assert exit_code(["run", str(path), "--out", "o", "--workers", "1"]) == DONE
    assert [file.name for file in Path("o/fields").iterdir()] == ["upper_n.vtu"]
    assert "o/fields/upper_n.vtu" in capsys.readouterr().out
    with xr.open_dataset("o/ics.nc", engine="h5netcdf") as dataset:
        raw = dataset.raw.sel(solved="upper", i="n", j="n")
        x, s = raw.x.values, raw.s.values
    body = load_scene(str(path)).bodies["upper"]
    normal = body.surface.axes(x, s)[2]
    inside = body.surface.position(x, s) + 1e-5 * normal
    seen = pyvista.PolyData(inside.T).sample(pyvista.read("o/fields/upper_n.vtu"))
    assert np.all(seen["vtkValidPointMask"])
    u = np.sum(seen["displacement"].T * normal, axis=0)
    # between points in a facet's plane and on its parabola VTK may take the neighbouring cell's side
    defect = np.abs(u - raw) / np.abs(raw).max()
    assert np.median(defect) < 1e-4
    assert np.quantile(defect, 0.95) < 0.003
    assert np.max(defect) < 0.03


def test_fields_are_a_key_of_scenes_that_is_off_by_default(write_scene):
    assert not load_scene("geometry1").fields
    assert "# fields = false  # write displacement" in listing("geometry1")
    path = write_scene(f"fields = true\n{ONE}")
    assert load_scene(str(path)).fields
    assert "\nfields = true  #" in listing(str(path))
