"""A contour and an approximation that are registered once: scenes, listings and commands know them."""

from typing import Literal

import numpy as np
import pytest
import xarray as xr
from pydantic import Field

from femic.cli.main import DONE, exit_code
from femic.key_types import Length
from femic.scenes.bodies import CONTOURS
from femic.scenes.errors import BadScene
from femic.scenes.listing import listing
from femic.scenes.load import load_scene
from femic.scenes.scene_table import SceneTable
from geometries import contours
from tests.compare.conftest import scene_text
from tests.femic.reference.stand_ins import b_hat_as_c

ARC = 'kind = "arc", radius = 10.0, flank_inclination_deg = 25.0'
PARABOLA = 'kind = "parabola", crown_radius = 10.0, width = 8.0'
LINE = '[[lines]]\nalong = "x"\ns = 0.5\nreach = 2.0\npoints = 5\n'
ENGINE = "[engine]\ntolerance = 0.5\nfar_radius = 60.0\n"


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
    bodies = scene_text('bodies = ["lower"]\ncomponents = ["nn"]', lines=LINE, engine=ENGINE)
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
