"""Figures: how a section is closed, and which side the pictures of a mesh show."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import trapezoid
from skfem import MeshTri

from compare.pages.scene_pictures import _closing, _mesh, pictures, sections, surface_mesh
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


def curves_of(panel):
    """The curves of a panel by their labels."""
    return {curve.label: curve for curve in panel.curves}


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
    (whole, near) = surface_mesh(chart, off_centre(s, tmp_path), "lower", side=side).cells
    for panel in (whole, near):
        corners = curves_of(panel)["patch"].x
        np.testing.assert_allclose([corners.min(), corners.max()], patch)
        low, high = panel.limits_x
        assert low < patch[0] < patch[1] < high
    np.testing.assert_allclose(near.limits_x, [max(side * s - 2.4, chart.p[1].min()), side * s + 2.4])


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
    whole = sections(scene).cells[0]
    assert len(whole.curves) == 4  # contour and far arc of each body
    reach = scene.bodies["lower"].domain.far_radius
    for curve in whole.curves:
        assert np.max(np.hypot(*np.diff(curve.points))) < 0.1 * reach


def test_a_line_has_the_same_colour_in_the_section_and_on_the_surface_and_marks_are_alike():
    scene = load_scene("geometry1")
    _, near, plan = sections(scene).cells
    names = [f"line {line.name}" for line in scene.lines]
    shown = {name: [curves_of(panel)[name].look for panel in (near, plan)] for name in names}
    assert len({one.colour for one, _ in shown.values()}) == len(scene.lines)
    assert all(one.colour == other.colour for one, other in shown.values())
    marks = [shown[f"line {line.name}"][0] for line in scene.lines if line.along == "x"]
    assert len(marks) == 2
    assert len({(one.marker, one.dash) for one in marks}) == 1
    order = [curve.label for curve in near.curves]
    assert all(order.index("patch") < order.index(name) for name in names)  # the patch does not hide them


def test_a_mesh_has_each_edge_once_and_near_the_patch_only_what_is_seen():
    mesh = MeshTri.init_tensor(np.linspace(0, 4, 5), np.linspace(0, 4, 5))
    whole = _mesh(mesh.p, mesh.t)
    ends = np.reshape(whole.points, (2, -1, 3))
    assert np.isnan(ends[:, :, 2]).all()
    edges = {frozenset(map(tuple, ends[:, k, :2].T)) for k in range(ends.shape[1])}
    assert len(edges) == ends.shape[1] == mesh.facets.shape[1]
    assert edges == {frozenset(map(tuple, mesh.p[:, facet].T)) for facet in mesh.facets.T}
    corner = np.reshape(_mesh(mesh.p, mesh.t, (0.0, 0.5), (0.0, 0.5)).points, (2, -1, 3))[:, :, :2]
    assert corner.max() == 1.0
    assert 0 < corner.shape[1] < ends.shape[1]
