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

BODY = """
[{name}]
E = 210e3
nu = 0.3
contour = {{ kind = "parabola", crown_radius = {radius}, width = 8.0 }}
"""
LOWER, UPPER = BODY.format(name="lower", radius=10.0), BODY.format(name="upper", radius=10.5)
REST = """
[patch]
a = 0.2
b = 0.3
[[lines]]
along = "x"
s = 0.5
reach = 2.0
points = 5
[engine]
tolerance = 0.5
far_radius = 60.0
"""


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
    path.write_text(f'components = ["nn", "sn"]\n{LOWER}{UPPER}{REST}')
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


@pytest.mark.parametrize("kind", ['"parabola"', "3", '["arc"]'])
def test_unregistered_kind_is_refused_with_the_known_kinds(kind, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(LOWER.replace('"parabola"', kind))
    with pytest.raises(BadScene, match=r"lower\.contour\.kind = .*Input should be ('plane'|a valid string)"):
        load_scene(str(path))


def test_commands_take_a_registered_contour(parabola, tmp_path, capsys):
    out = ["--out", str(tmp_path / "out"), "--workers", "1"]
    parabola.write_text('bodies = ["lower"]\n' + parabola.read_text().replace(', "sn"]', "]"))
    assert exit_code(["scenes", "--show", str(parabola)]) == DONE
    assert exit_code(["run", str(parabola), *out]) == DONE, capsys.readouterr()
    results = xr.load_dataset(tmp_path / "out" / "ics.nc")
    nn = results.ic.sel(i="n", j="n", body="lower")
    largest = abs(nn.sel(variant="C")).max()
    assert abs(nn.sel(variant="Bhat") - nn.sel(variant="C")).max() < 0.1 * largest
