"""Figures: how a section is closed, and which side the pictures of a mesh show."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import trapezoid
from skfem import MeshTri

from compare.pages.scene_pictures import _closing, pictures, sections, surface_mesh
from compare.report import views
from femic.reference.run_options import Level
from femic.results.ics import jobs
from femic.scenes.load import load_scene
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER
from tests.compare.conftest import scene_text

STEEL = Material(210e3, 0.28)
FAR = Domain(300.0, 300.0)
BALL = Body(UPPER, arc(-50.0, 1.4, 1.4), STEEL, FAR, rolling_radius=50.0)
BODIES = {
    "far arc only": Body(LOWER, arc(300.0, 0.5, 0.3), STEEL, FAR),
    "far arc only, steep groove": Body(UPPER, arc(300.0, 0.7, 0.7), STEEL, FAR),
    "far arc cut by the hub": Body(UPPER, arc(300.0, 0.1, 0.2), STEEL, FAR, rolling_radius=200.0),
    "hub at both ends": BALL,
    "hub at both ends, below": Body(LOWER, arc(50.0, 1.4, 1.4), STEEL, FAR, rolling_radius=50.0),
    "hub at the left end": Body(UPPER, arc(-50.0, 1.4, 0.0), STEEL, FAR, rolling_radius=50.0),
    "hub at the right end": Body(LOWER, arc(50.0, 0.0, 1.4), STEEL, FAR, rolling_radius=50.0),
}


def closing(body):
    """The ends of the contour, and the closing from the right one to the left one."""
    ends = body.contour.position(np.array(body.s_range))
    return ends, _closing(body, ends[:, 1], ends[:, 0])


@pytest.mark.parametrize("name", BODIES)
def test_section_is_closed_along_far_arc_and_hub_and_enclosed(name):
    body = BODIES[name]
    far = body.domain.far_radius
    ends, (y, z) = closing(body)
    np.testing.assert_allclose([y[[-1, 0]], z[[-1, 0]]], ends, rtol=0, atol=1e-9 * far)
    below_far_arc, below_hub = far - np.hypot(y, z), body.depth - body.side * z
    nearest = np.minimum(below_far_arc, below_hub)
    assert np.all(np.abs(nearest) < 1e-9 * far)
    assert np.all(np.diff(y[below_hub < 1e-9 * far]) < 1e-9 * far)  # runs along the hub only once
    contour = body.contour.position(np.linspace(*body.s_range, 4001))
    y, z = np.hstack([contour, [y, z]])
    enclosed = abs(np.sum(y * np.roll(z, -1) - np.roll(y, -1) * z)) / 2
    across, height = body.contour.position(np.linspace(-2 * far, 2 * far, 100_001))
    within = np.sqrt(np.maximum(far**2 - across**2, 0))
    bottom = np.maximum(body.side * height, -within)
    area = trapezoid(np.maximum(np.minimum(within, body.depth) - bottom, 0), across)
    assert enclosed == pytest.approx(area, rel=1e-3)


def test_clamped_line_of_ball_ends_with_hub():
    ends, (y, z) = closing(BALL)
    assert np.abs(y).max() <= np.abs(ends[0]).max() < 60
    np.testing.assert_allclose(z, 40.0, rtol=1e-9)


def off_centre(s, folder, flanks="25.0"):
    line = f'\n[[lines]]\nalong = "x"\ns = {s}\nreach = 3.0\n'
    text = scene_text('bodies = ["lower"]\ncomponents = ["nn"]', flanks=flanks, lines=line)
    path = folder / "off_centre.toml"
    path.write_text(text.replace("b = 0.2", f"b = 0.2\ns = {s}"), encoding="utf-8")
    return load_scene(str(path))


@pytest.mark.parametrize(("s", "side"), [(2.0, 1), (-2.0, 1), (-2.0, -1)])
def test_surface_mesh_is_shown_on_modelled_side_of_patch(s, side, tmp_path):
    chart = MeshTri.init_tensor(np.linspace(0, 10, 5), np.linspace(0 if side * s > 0 else -10, 10, 5))
    patch = [side * s - 0.2, side * s + 0.2]
    whole, near = surface_mesh(chart, off_centre(s, tmp_path), "lower", side=side).axes
    for axes in (whole, near):
        corners = axes.patches[0].get_xy()[:, 0]
        np.testing.assert_allclose([corners.min(), corners.max()], patch)
        low, high = axes.get_xlim()
        assert low < patch[0] < patch[1] < high
    np.testing.assert_allclose(near.get_xlim(), [max(side * s - 2.4, chart.p[1].min()), side * s + 2.4])


@pytest.mark.parametrize(
    ("s", "flanks", "shown"), [(2.0, "25.0", 2.0), (-2.0, "25.0", 2.0), (-2.0, "[25.0, 30.0]", -2.0)]
)
def test_close_up_is_centred_on_modelled_side(s, flanks, shown, tmp_path, monkeypatch):
    scene = off_centre(s, tmp_path, flanks)
    reference = SimpleNamespace(level=Level(cells=-1), drawn=None)
    results = SimpleNamespace(scene=scene, jobs=jobs(scene), references={"lower": reference})
    drawn = []
    monkeypatch.setattr(views, "can_render", lambda: True)
    monkeypatch.setattr(views, "draw_mesh", lambda *given, **_: drawn.append(given[2]))
    names = [picture.name for picture in pictures(results, tmp_path)]
    assert names == ["sections", "mesh_lower", "mesh_surface"]
    np.testing.assert_allclose(drawn, [scene.bodies["lower"].surface.position(0.0, shown)])


def test_no_line_crosses_a_body_from_one_end_of_its_contour_to_the_other():
    scene = load_scene("geometry1")
    whole = sections(scene).axes[0]
    assert len(whole.get_lines()) == 4  # contour and far arc of each body
    reach = scene.bodies["lower"].domain.far_radius
    for line in whole.get_lines():
        lengths = np.hypot(*np.diff(line.get_xydata(), axis=0).T)
        assert np.max(lengths) < 0.1 * reach


def test_a_line_has_the_same_colour_in_the_section_and_on_the_surface_and_marks_are_alike():
    scene = load_scene("geometry1")
    _, near, plan = sections(scene).axes
    shown = {
        line.name: [
            next(one for one in axes.get_lines() if one.get_label() == f"line {line.name}")
            for axes in (near, plan)
        ]
        for line in scene.lines
    }
    assert len({one.get_color() for one, _ in shown.values()}) == len(scene.lines)
    assert all(one.get_color() == other.get_color() for one, other in shown.values())
    marks = [shown[line.name][0] for line in scene.lines if line.along == "x"]
    assert len(marks) == 2
    assert len({(one.get_marker(), one.get_markersize(), one.get_markeredgewidth()) for one in marks}) == 1
    assert all(one.get_zorder() > max(patch.get_zorder() for patch in near.patches) for one in marks)
