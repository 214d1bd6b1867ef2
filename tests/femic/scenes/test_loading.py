"""What the keys of a scene file mean, in which units, what follows where they are left out, and listings."""

import re
import tomllib
from copy import deepcopy
from dataclasses import astuple
from functools import partial

import numpy as np
import pytest

from approx.effective import EffectiveProperties, Transition
from approx.variants import VARIANTS
from femic.reference.engines import HARMONIC, SOLID
from femic.scenes.bodies import CONTOURS
from femic.scenes.errors import BadScene
from femic.scenes.file import SceneFile
from femic.scenes.listing import listing
from femic.scenes.load import builtin_names, load_scene, load_solid_scene, scene_from_table
from geometries.surfaces import LOWER, UPPER
from tests.compare.conftest import SHORT_LINES, scene_text
from tests.femic.scenes.changes import PROPERTY, SHORT, arc, both, ellipse, engine, line, patch, straight

INF = float("inf")
flat = partial(load_scene, "flat")


# --- what keys mean -------------------------------------------------------------------------------------


def test_numbers_arrive_in_mm_mpa_and_rad():
    scene = load_scene("geometry2")
    lower, upper = scene.bodies["lower"], scene.bodies["upper"]
    assert (lower.side, upper.side) == (LOWER, UPPER)
    assert astuple(lower.material) == astuple(upper.material) == (210e3, 0.3)
    assert (lower.rolling_radius, upper.rolling_radius) == (INF, 500.0)
    assert upper.depth == pytest.approx(0.8 * 500)
    assert lower.contour.inclination(np.array([-15.0, 15.0])) == pytest.approx(np.radians([-65, 65]))
    assert upper.contour.inclination(np.array([-15.0, 1.0])) == pytest.approx([-np.radians(60), 1 / 10.1])
    assert astuple(scene.patch) == (0.167, 0.158, 0.0)
    assert scene.half_turn == pytest.approx(np.pi * 500.0)
    assert scene.reference_length == pytest.approx(10.0)
    assert flat({"lower": {"E": 70e3}, "upper": {"E": 3.0}}).reference_E == 70e3


def test_geometry1_has_the_inclinations_of_the_source():
    scene = load_scene("geometry1")
    for body in scene.bodies.values():
        assert np.degrees(body.contour.inclination(np.array([-20.0, 20.0]))) == pytest.approx([-25.5, 25.5])
        assert body.contour.inclination(1.0) == pytest.approx(1 / 10)
        assert astuple(body.material) == (210e3, 0.28)
    assert astuple(scene.patch) == (0.2, 0.2, 0.0)
    assert scene.reference_length == pytest.approx(10)


def test_a_negative_radius_is_a_groove_and_flanks_are_left_then_right():
    """A groove is the mirror image in z of the crown of the same radius."""
    groove, crown = (flat(both(arc([20.0, 40.0], radius))) for radius in (-8.0, 8.0))
    s = np.linspace(-20, 20, 41)
    for name in ("lower", "upper"):
        (y, z), (y_crown, z_crown) = (scene.bodies[name].contour.position(s) for scene in (groove, crown))
        np.testing.assert_allclose([y, z], [y_crown, -z_crown], rtol=1e-12, atol=1e-12)
        assert crown.bodies[name].contour.inclination(s[[0, -1]]) == pytest.approx(np.radians([-20, 40]))
    assert groove.reference_length == pytest.approx(8.0)
    with pytest.raises(BadScene, match=r"lower\.contour\.radius = 0\.0: its amount should be 1e-12 \.\.\."):
        flat({"lower": arc(20.0, 0.0)})


def test_ellipse_has_flanks_at_75_degrees_and_the_curvature_of_its_axes():
    scene = flat({"lower": ellipse(9.0, 7.0)})
    contour = scene.bodies["lower"].contour
    assert np.degrees(contour.inclination(np.array([-50.0, 50.0]))) == pytest.approx([-75, 75])
    assert scene.reference_length == pytest.approx(9.0**2 / 7.0, rel=1e-6)  # b^2 / d at the crown


def test_points_are_measured_from_y_centre(tmp_path):
    """A parabola about y = 3: its crown is the contact centre; columns in a file are y and z."""
    y = np.linspace(-5, 11, 65)
    columns = np.column_stack([y, 4 - (y - 3) ** 2 / 30])
    np.savetxt(tmp_path / "rail.txt", columns, header="y z")
    for source in ({"file": str(tmp_path / "rail.txt")}, {"points": columns.tolist()}):
        changes = both({"contour": {"kind": "points", "y_centre": 3.0, **source}})
        scene = flat(changes | {"rotation_reach": 6.0} | SHORT)
        body = scene.bodies["lower"]
        assert body.contour.inclination(0.0) == pytest.approx(0, abs=1e-6)
        assert scene.reference_length == pytest.approx(15, rel=1e-3)


def test_lines_have_the_specified_points():
    lines = [
        {"along": "x", "s": -0.7, "reach": 4, "points": 5},
        {"along": "s", "x": 1.5, "reach": 6, "points": 3},
    ]
    along_x, along_s = flat({"lines": lines}).lines
    assert (along_x.name, along_s.name) == ("s = -0.7 mm", "x = 1.5 mm")
    np.testing.assert_array_equal([along_x.x, along_x.s], [[-4, -2, 0, 2, 4], 5 * [-0.7]])
    np.testing.assert_array_equal([along_s.s, along_s.x], [[-6, 0, 6], 3 * [1.5]])


def test_a_line_along_s_ends_with_the_shorter_contour():
    measured = {"lower": straight(-8.0, 5.0), "upper": straight(-6.0, 9.0), "rotation_reach": 4.0}
    (across,) = flat(measured | line("s", 1.6, 7.0)).lines
    assert (across.s[0], across.s[-1]) == pytest.approx((-6, 5))
    (short,) = flat(measured | line("s", 1.6, 3.0)).lines
    assert (short.s[0], short.s[-1]) == (-3, 3)


EFFECTIVE = """
[effective.combined]
mismatch_k = { far = 0.12, r_inf = 11.0, m = 1.5, n = 2.5 }
[effective.upper]
G = { far = 7e4, r_inf = 9.0, m = 1.0, n = 2.0 }
"""
K = {"mismatch_k": {"far": 0.1, "r_inf": 9.0, "m": 1.0, "n": 2.0}}


def test_effective_properties_reach_the_pair_and_the_listing(write_scene):
    path = write_scene('variants = ["Bhat_prime"]', lines=EFFECTIVE + SHORT_LINES)
    pair = load_scene(str(path)).pair
    assert pair.effective == EffectiveProperties(mismatch_k=Transition(0.12, 11.0, 1.5, 2.5))
    assert pair.upper.effective == EffectiveProperties(G=Transition(7e4, 9.0, 1.0, 2.0))
    assert [pair.has_effective(name) for name in ("combined", "upper", "lower")] == [True, True, False]
    shown = SceneFile.model_validate(tomllib.loads(listing(str(path))))
    assert shown.effective == SceneFile.model_validate(tomllib.loads(path.read_text())).effective


def test_bhat_prime_needs_effective_properties_of_a_compared_body():
    assert flat({"bodies": ["lower", "combined"], "effective": {"lower": K}}).fitted == ("lower",)
    for given in ({}, {"bodies": ["combined"], "effective": {"lower": K}}):
        with pytest.raises(BadScene, match="variants: Bhat_prime needs effective properties of the compared"):
            flat({"variants": ["Bhat_prime"]} | given)


def test_curvature_is_apart_only_where_the_combined_properties_say_so():
    for given, apart in (({"curvature": "apart"}, True), ({"curvature": "contained"}, False), ({}, False)):
        scene = flat({"effective": {"combined": K | given}})
        assert scene.curvature_apart == apart == scene.pair.curvature_apart
        assert scene.pair.effective == EffectiveProperties(mismatch_k=Transition(0.1, 9.0, 1.0, 2.0))
    assert not flat(PROPERTY).curvature_apart


def test_only_compared_bodies_are_solved(write_scene):
    assert load_scene(str(write_scene('bodies = ["upper"]'))).solved == ("upper",)
    assert load_scene(str(write_scene('bodies = ["combined"]'))).solved == ("lower", "upper")


# --- defaults -------------------------------------------------------------------------------------------


def test_models_of_stresses_have_neither_finer_nor_coarser_cells_by_default():
    assert flat().stresses.fineness == 1.0


def test_default_lines_lie_beside_through_and_in_front_of_the_patch():
    lines = flat(patch(0.2, 0.3, 2.0)).lines
    assert [line.name for line in lines] == ["s = 3.6 mm", "s = 2 mm", "x = 1.6 mm"]
    assert {len(line.x) for line in lines} == {401}
    assert [float(np.max(line.running)) for line in lines] == [25.0] * 3
    assert [float(np.min(line.running)) for line in lines] == [-25.0] * 3


def test_default_patch_is_small_beside_rotation_reach(tmp_path):
    """So contact, which has none, needs none; and the listing leaves it out, too."""
    plane = "E = 1e5\nnu = 0.3\ncontour = { kind = 'plane' }\n"
    path, again = tmp_path / "mine.toml", tmp_path / "again.toml"
    path.write_text(f"[lower]\n{plane}[upper]\n{plane}[contact]\nloads = [1.0]\n", encoding="utf-8")
    scene = load_scene(str(path))
    assert astuple(scene.patch) == (0.2, 0.2, 0.0)  # rotation_reach = 2 reference lengths of 10 mm
    again.write_text(listing(str(path)), encoding="utf-8")
    assert load_scene(str(again)).patch == scene.patch
    for radius in (0.2, 5e3):  # reference lengths far from that
        load_scene(str(path), both(arc(30.0, radius)))


def test_default_grid_elements_have_the_size_of_the_patch():
    assert astuple(flat().grid) == (64, 32, 0.4, 0.6, 0.0)
    given = {"n_x": 3, "n_s": 4, "dx": 0.5, "ds": 0.7, "s": 1.0, "check": 2}
    scene = flat({"grid": given})
    assert (astuple(scene.grid), scene.checked_strips) == ((3, 4, 0.5, 0.7, 1.0), 2)


@pytest.mark.parametrize(
    ("changes", "reach", "arm"),
    [
        ({}, 20.0, 5.0),  # 2 and 1/2 reference lengths of 10 mm
        ({"reference_length": 8.0}, 16.0, 4.0),
        (engine(far_radius=120.0), 15.0, 5.0),  # an eighth of the domain
        (engine(far_radius=64.0) | SHORT, 8.0, 4.0),  # the arm: half of that
        (engine(kind="solid", far_radius=160.0, half_length=56.0) | SHORT, 7.0, 3.5),
        ({"upper": {"rolling_radius": 72.0 / np.pi}, "reference_length": 30.0} | SHORT, 24.0, 12.0),
        ({"lower": straight(-9.0, 6.0), **SHORT}, 6.0, 3.0),
        ({"lower": straight(-6.0, 9.0), **SHORT}, 6.0, 3.0),
        ({"rotation_reach": 13.0, "moment_arm": 3.0}, 13.0, 3.0),
    ],
)
def test_default_rotation_reach_and_moment_arm_fit_the_domain(changes, reach, arm):
    settings = flat(changes).settings
    assert (settings.rotation_reach, settings.moment_arm) == pytest.approx((reach, arm))


def test_default_calibration_points():
    """From 2 a, left out, to 2.5 reference lengths, on s of the patch and 1.6 mm beside it."""
    calibration = flat(patch(0.2, 0.3, 1.0)).calibration
    assert (calibration.x_min, calibration.x_max) == pytest.approx((0.4, 25.0))
    assert [line.name for line in calibration.lines] == ["fit s = 1 mm", "fit s = 2.6 mm"]
    for line_of_fit in calibration.lines:
        step = (25 - 0.4) / 200
        np.testing.assert_allclose(line_of_fit.x, 0.4 + step * np.arange(1, 201), rtol=1e-12)
    assert (calibration.bodies, calibration.properties) == (("combined",), ("mismatch_k",))
    assert (calibration.components, calibration.curvature_apart) == (("xn",), False)
    assert not calibration.logarithmic


def test_calibration_line_along_s_ends_with_the_contours():
    table = {"x": [2.0], "s": [0.5], "x_max": 7.0, "points": 9}
    table |= {"weights": "logarithmic", "curvature": "apart"}
    on_plane = flat(patch(0.2, 0.3, 1.0) | {"calibration": table}).calibration
    along_x, along_s = on_plane.lines
    assert (along_s.name, along_s.s[0], along_s.s[-1]) == ("fit x = 2 mm", -6, 8)
    np.testing.assert_array_equal([along_s.x, along_x.s], [9 * [2.0], 9 * [0.5]])
    assert (on_plane.logarithmic, on_plane.curvature_apart) == (True, True)
    measured = {"lower": straight(-5.0, 7.5), **SHORT, "rotation_reach": 4.0}
    table = {"calibration": {"x": [2.0], "s": [], "x_max": 7.0}}
    (ended,) = flat(measured | patch(0.2, 0.3, 1.0) | table).calibration.lines
    assert (ended.s[0], ended.s[-1]) == pytest.approx((-5, 7.5))


def test_moment_arm_of_a_central_load_is_not_limited():
    changes = {"rotation_reach": 60.0, "moment_arm": 40.0, "engine": {"far_radius": 160.0}}
    assert load_scene("geometry1", changes).settings.moment_arm == 40


# --- engines --------------------------------------------------------------------------------------------


def test_only_domain_of_the_solid_engine_has_ends_along_x():
    for kind, length, far, default in (("harmonic", INF, 1280.0, INF), ("solid", 90.0, 320.0, 320.0)):
        given = flat(engine(kind=kind, far_radius=200.0, half_length=90.0) | SHORT).bodies["upper"].domain
        assert astuple(given) == (200.0, length, True, True)
        assert astuple(flat(engine(kind=kind)).bodies["lower"].domain) == (far, default, False, False)


def test_boundaries_that_a_scene_gives_are_supports_of_its_bodies():
    far, length = {"far_radius": 200.0}, {"half_length": 200.0}
    for keys, truncated in (
        ({}, True),
        (far, False),
        (far | {"kind": "solid"}, True),
        (length | {"kind": "solid"}, True),
        (far | length | {"kind": "solid"}, False),
    ):
        assert {body.truncated for body in flat(engine(**keys)).bodies.values()} == {truncated}, keys


def test_given_cells_replace_defaults_one_by_one():
    default = flat().first_cells
    for key, name in (("smallest_cell", "smallest"), ("growth", "growth"), ("line_growth", "line_growth")):
        cells = flat(engine(**{key: 0.021})).first_cells
        assert getattr(cells, name) == 0.021
        others = {"smallest", "growth", "line_growth"} - {name}
        assert all(getattr(cells, other) == getattr(default, other) for other in others)


def test_the_first_cells_follow_from_the_tolerance():
    fine, coarse, coarsest = (
        flat({"engine": {"kind": "solid", "tolerance": t}}).first_cells for t in (0.01, 0.08, 1.0)
    )
    assert coarse.growth == pytest.approx(2 * fine.growth)  # eight times the error, cubic convergence
    assert coarse.smallest == pytest.approx(2 * fine.smallest)
    assert coarsest.growth == pytest.approx(3 * fine.growth)
    given = flat({"engine": {"kind": "solid", "tolerance": 0.08, "growth": 0.2}}).first_cells
    assert (given.growth, given.smallest) == (0.2, coarse.smallest)


def test_a_tight_tolerance_has_small_cells_and_a_far_arc_of_the_harmonic_engine():
    loose, tuned, tight = (flat({"engine": {"tolerance": t}}) for t in (0.1, 0.001, 0.000125))
    assert tuned.first_cells.growth == pytest.approx(2 * tight.first_cells.growth)
    assert loose.first_cells.growth == pytest.approx(1.5 * tuned.first_cells.growth)
    radii = [scene.bodies["lower"].domain.far_radius for scene in (loose, tuned, tight)]
    assert radii == pytest.approx([1280.0, 1280.0, 1280.0 * 8**0.5])


def test_the_check_uses_the_solid_engine_with_its_own_cells_in_the_domain_of_the_scene():
    scene = load_scene("geometry2", {"engine": {"tolerance": 0.001, "growth": 0.3}})
    assert (scene.settings.engine, scene.check.settings.engine, scene.check.check) == (HARMONIC, SOLID, None)
    assert (scene.check.patch, scene.check.settings.tolerance) == (scene.patch, 0.01)
    assert scene.check.first_cells == SOLID.first_cells(0.01, scene.patch)
    assert scene.check.bodies["upper"].domain.far_radius == 320.0
    assert flat().check is load_scene("geometry2", engine(kind="solid")).check is None
    keys = {"far_radius": 250.0, "most_unknowns": 12_345, "tolerance": 0.03}
    for given, length, supported in (({}, 320.0, False), ({"half_length": 170.0}, 170.0, True)):
        check = flat(engine(check=True, **keys, **given)).check
        assert astuple(check.bodies["lower"].domain) == (250.0, length, True, supported)
        assert (check.settings.most_unknowns, check.settings.tolerance) == (12_345, 0.03)


def test_fields_need_an_engine_that_has_them(write_scene):
    for kind in ("harmonic", "solid"):
        path = write_scene(engine=f'[engine]\nkind = "{kind}"\nsmallest_cell = 0.03\nfar_radius = 90.0\n')
        scene = load_solid_scene(str(path))
        assert scene.settings.engine is SOLID
        own = scene.settings.first_cells(scene.patch).smallest == 0.03
        assert own == (kind == "solid")  # the cells of the other engine are not those of this one
        assert scene.bodies["lower"].domain.far_radius == 90.0
    with pytest.raises(BadScene, match=r"fields = true: only engine\.kind = 'solid' has fields"):
        flat({"fields": True})
    assert flat({"fields": True} | engine(kind="solid")).fields
    assert flat().settings.engine is HARMONIC


# --- files, tables and changes --------------------------------------------------------------------------


def test_a_table_from_python_is_the_scene_of_its_file(tmp_path):
    """And is not changed by it."""
    np.savetxt(tmp_path / "rail.txt", np.column_stack([np.linspace(-9, 9, 20), np.zeros(20)]))
    body, contour = {"E": 210e3, "nu": 0.3}, {"kind": "points", "file": str(tmp_path / "rail.txt")}
    table = {"lower": body | {"contour": contour}, "upper": body | arc(5.0), **patch(0.2, 0.3), **SHORT}
    table |= {"rotation_reach": 4.0, "title": "mine"}
    before = deepcopy(table)
    scene = scene_from_table(table, "named")
    assert table == before
    assert (scene.name, scene.title) == ("named", "mine")
    path = tmp_path / "again.toml"
    path.write_text(scene.text, encoding="utf-8")
    again = load_scene(str(path))
    assert again.bodies["lower"].contour.extent == scene.bodies["lower"].contour.extent
    assert again.patch == scene.patch


def test_a_table_with_a_kind_replaces_the_whole_table():
    """Otherwise the radius of an arc would stay with an ellipse."""
    for lower, length in ((ellipse(9.0, 7.0), 81 / 7), ({"contour": {"radius": 5.0}}, 5.0)):
        scene = load_scene("geometry1", {"lower": lower})
        assert scene.reference_length == pytest.approx(length, rel=1e-6)


def test_a_scene_has_the_name_of_its_file_and_a_title_if_it_gives_one(write_scene):
    scene = load_scene(str(write_scene()))
    assert (scene.name, scene.text) == ("mine", scene_text())
    assert re.fullmatch(r"mine \(arc of \d+(\.\d+)? mm on arc of \d+ mm\)", scene.title)
    assert load_scene("flat", {"title": ""}).title == "flat (plane on plane)"
    assert load_scene("s1002-on-60e1", {"title": ""}).title == "s1002-on-60e1 (S1002 on 60E1)"
    assert load_scene(str(write_scene('title = "A pair"'))).title == "A pair"
    assert flat().title.startswith("Flat")


DEEP = "[" * 40 + "]" * 40


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("title = " + "[" * 5000 + "]" * 5000, "tables and lists within each other more than 30 deep"),
        (f"title = {DEEP}", "more than 30 deep"),
        ("a" + ".a" * 3000 + " = 1", "more than 30 deep"),
        ("title = " + "9" * 5000, "digits"),
        ("title = " + "9" * 4000, "title = 9999"),
    ],
)
def test_unreadable_toml_is_refused_with_a_short_message(text, reason, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    for changes in (None, {"contact": {"ics": ["A"]}}):
        with pytest.raises(BadScene, match=reason) as caught:
            load_scene(str(path), changes)
        assert len(str(caught.value)) < 1000


def test_changes_replace_the_keys_they_name_and_no_others():
    scene = load_scene("geometry1", {"lower": {"nu": 0.4}, "engine": {"tolerance": 0.1}, "bodies": ["lower"]})
    assert astuple(scene.bodies["lower"].material) == (210e3, 0.4)
    assert astuple(scene.bodies["upper"].material) == (210e3, 0.28)
    assert (scene.settings.tolerance, scene.solved) == (0.1, ("lower",))
    again = tomllib.loads(scene.text)  # what is recorded is what was computed
    assert (again["lower"]["nu"], again["patch"]) == (0.4, {"a": 0.2, "b": 0.2})
    assert again["engine"] == {"check": True, "tolerance": 0.1}


# --- listings -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", builtin_names())
def test_the_listing_is_the_same_scene_and_names_every_key(name):
    text = listing(name)
    shown, original = SceneFile.model_validate(tomllib.loads(text)), load_scene(name)
    assert shown == SceneFile.model_validate(
        tomllib.loads(original.text) | {"lines": tomllib.loads(text)["lines"]}
    )
    for key in ("bodies", "components", "variants", "reference_length", "tolerance", "far_radius", "solver"):
        assert f"{key} = " in text


def test_listings_name_every_registered_contour_and_approximation():
    listed = listing("flat")
    assert all(f'kind = "{kind}"' in listed for kind in CONTOURS)
    names = ", ".join(f'"{variant}"' for variant in VARIANTS)
    assert f"#   one or more of: {names}" in listed
    assert f'#   one of: "auto", "C", {names}' in listed
