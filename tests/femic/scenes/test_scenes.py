"""Scene files: what they mean, and the messages about invalid ones."""

import re
import tomllib

import numpy as np
import pytest

from approx.effective import EffectiveProperties, Transition
from approx.variants import VARIANTS
from femic.reference.engines import HARMONIC, SOLID
from femic.scenes.bodies import CONTOURS
from femic.scenes.errors import BadScene
from femic.scenes.file import SceneFile
from femic.scenes.listing import listing
from femic.scenes.load import builtin_names, load_scene
from tests.compare.conftest import SHORT_LINES, scene_text


def errors_of(path):
    with pytest.raises(BadScene) as caught:
        load_scene(str(path))
    return str(caught.value)


@pytest.mark.parametrize("name", builtin_names())
def test_the_listing_is_the_same_scene_and_names_every_key(name):
    text = listing(name)
    shown, original = SceneFile.model_validate(tomllib.loads(text)), load_scene(name)
    assert shown == SceneFile.model_validate(
        tomllib.loads(original.text) | {"lines": tomllib.loads(text)["lines"]}
    )
    for key in ("bodies", "components", "variants", "reference_length", "tolerance", "far_radius", "solver"):
        assert f"{key} = " in text


def test_geometry1_has_the_inclinations_of_the_source():
    scene = load_scene("geometry1")
    for body in scene.bodies.values():
        assert np.degrees(body.contour.inclination(np.array([-20.0, 20.0]))) == pytest.approx([-25.5, 25.5])
        assert body.contour.inclination(1.0) == pytest.approx(1 / 10)
        assert (body.material.E, body.material.nu) == (210e3, 0.28)
    assert (scene.patch.a, scene.patch.b) == (0.2, 0.2)
    assert scene.reference_length == pytest.approx(10)


EFFECTIVE = """
[effective.combined]
mismatch_k = { far = 0.12, r_inf = 11.0, m = 1.5, n = 2.5 }
[effective.upper]
G = { far = 7e4, r_inf = 9.0, m = 1.0, n = 2.0 }
"""


def test_effective_properties_reach_the_pair_and_the_listing(write_scene):
    path = write_scene('variants = ["Bhat_prime"]', lines=EFFECTIVE + SHORT_LINES)
    pair = load_scene(str(path)).pair
    assert pair.effective == EffectiveProperties(mismatch_k=Transition(0.12, 11.0, 1.5, 2.5))
    assert pair.upper.effective == EffectiveProperties(G=Transition(7e4, 9.0, 1.0, 2.0))
    assert [pair.has_effective(name) for name in ("combined", "upper", "lower")] == [True, True, False]
    shown = SceneFile.model_validate(tomllib.loads(listing(str(path))))
    assert shown.effective == SceneFile.model_validate(tomllib.loads(path.read_text())).effective


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (SHORT_LINES, "variants: Bhat_prime needs effective properties"),
        (EFFECTIVE.replace("7e4", "-1.0") + SHORT_LINES, "effective.upper: effective G far away = -1.0"),
        (EFFECTIVE.replace("r_inf = 9.0", "r_inf = 0") + SHORT_LINES, "effective.upper.G.r_inf = 0"),
        (EFFECTIVE.replace("mismatch_k", "K") + SHORT_LINES, "effective.combined.K: unknown key"),
    ],
)
def test_bad_effective_properties_are_refused(write_scene, lines, message):
    assert message in errors_of(write_scene('variants = ["Bhat_prime"]', lines=lines))


def test_files_are_found_relative_to_the_scene(tmp_path, write_scene):
    y = np.linspace(-40, 40, 41)
    np.savetxt(tmp_path / "rail.txt", np.column_stack([y, -(y**2) / 100]))
    text = scene_text().replace(
        'contour = { kind = "arc", radius = 10.0, flank_inclination_deg = 25.0 }',
        'contour = { kind = "points", file = "rail.txt" }',
    )
    path = write_scene()
    path.write_text(text.replace("far_radius = 60", "far_radius = 160"), encoding="utf-8")
    scene = load_scene(str(path))
    assert scene.reference_length == pytest.approx(50, rel=1e-3)  # curvature 2/100 of the parabola's crown
    slope = 40 / 50  # arc length of a parabola of crown radius 50 mm up to y = 40 mm
    length = 25 * (slope * np.hypot(1, slope) + np.arcsinh(slope))
    assert scene.bodies["lower"].contour.extent[1] == pytest.approx(length, rel=1e-6)


BAD = {
    "unknown key": (("nu = 0.3", "nu = 0.3\npoisson = 1"), r"lower\.poisson: unknown key"),
    "misspelt key": (("a = 0.3", "a = 0.3\n[engin]\n"), r"engin: unknown key; did you mean 'engine'"),
    "twice the same line": (('along = "s"\nx = 1.6', 'along = "x"\ns = 1.6'), "two of them are the same"),
    "small hub": (
        ("nu = 0.3", "nu = 0.3\nrolling_radius = 100.0\nhub_radius = 5.0"),
        r"lower\.hub_radius = 5\.0: at least 0\.2 rolling_radius \(20 mm\)",
    ),
    "hub without a wheel": (
        ("nu = 0.3", "nu = 0.3\nhub_radius = 50.0"),
        r"lower\.hub_radius = 50.0: a prismatic body has none",
    ),
    "not TOML": (("[patch]", "[patch"), "not TOML"),
}


@pytest.mark.parametrize("case", BAD)
def test_invalid_scenes_are_refused_with_field_value_and_remedy(case, write_scene):
    (old, new), expected = BAD[case]
    path = write_scene()
    assert old in scene_text()
    path.write_text(scene_text().replace(old, new), encoding="utf-8")
    message = errors_of(path)
    assert re.search(expected, message), message


POINTS = {
    "y does not grow": ([0, 1, 2, 1.5, 3], r"point 4: y = 1\.5 after 2: y must grow"),
    "too few": ([-1, 0, 1], "3 points: at least 4"),
    "centre outside": ([1, 2, 3, 4], r"y_centre = 0 mm: not between"),
    "too steep": ([-3, -0.05, 0.05, 3], r"lower\.contour: inclined up to 8\d\.\d degrees; at most 75"),
}


@pytest.mark.parametrize("case", POINTS)
def test_bad_points_are_refused(case, tmp_path, write_scene):
    y, expected = POINTS[case]
    z = [0, 0, -2, -2] if case == "too steep" else np.zeros(len(y))
    np.savetxt(tmp_path / "rail.txt", np.column_stack([y, z]))
    path, arc = write_scene(), '"arc", radius = 10.0, flank_inclination_deg = 25.0'
    path.write_text(scene_text().replace(arc, '"points", file = "rail.txt"'), encoding="utf-8")
    assert re.search(expected, errors_of(path)), errors_of(path)


def test_names_given_twice_are_refused(write_scene):
    message = errors_of(write_scene('variants = ["A", "A"]\nbodies = ["lower", "lower"]'))
    assert "variants" in message
    assert "lower given twice" in message


def test_all_errors_come_at_once(write_scene):
    path = write_scene('variants = ["A", "D"]')
    path.write_text(path.read_text().replace("nu = 0.3", "nu = 0.7"), encoding="utf-8")
    message = errors_of(path)
    assert "3 error(s)" in message
    assert "variants.1 = 'D'" in message


def test_unknown_scene_suggests_the_nearest():
    with pytest.raises(BadScene, match="did you mean 'geometry1' or 'geometry2'"):
        load_scene("geometry")


def test_only_compared_bodies_are_solved(write_scene):
    assert load_scene(str(write_scene('bodies = ["upper"]'))).solved == ("upper",)
    assert load_scene(str(write_scene('bodies = ["combined"]'))).solved == ("lower", "upper")


def test_changes_replace_the_keys_they_name_and_no_others():
    scene = load_scene("geometry1", {"lower": {"nu": 0.4}, "engine": {"tolerance": 0.1}, "bodies": ["lower"]})
    original = load_scene("geometry1")
    assert scene.bodies["lower"].material.nu == 0.4
    assert scene.bodies["lower"].material.E == original.bodies["lower"].material.E
    assert scene.bodies["upper"].material.nu == original.bodies["upper"].material.nu
    assert (scene.settings.tolerance, scene.solved) == (0.1, ("lower",))
    again = tomllib.loads(scene.text)  # what is recorded is what was computed
    assert (again["lower"]["nu"], again["engine"], again["patch"]) == (
        0.4,
        {"check": True, "tolerance": 0.1},
        {"a": 0.2, "b": 0.2},
    )


def test_the_first_cells_follow_from_the_tolerance():
    fine, coarse, coarsest = (
        load_scene("flat", {"engine": {"kind": "solid", "tolerance": t}}).first_cells
        for t in (0.01, 0.08, 1.0)
    )
    assert coarse.growth == pytest.approx(2 * fine.growth)  # eight times the error, cubic convergence
    assert coarse.smallest == pytest.approx(2 * fine.smallest)
    assert coarsest.growth == pytest.approx(3 * fine.growth)
    given = load_scene("flat", {"engine": {"kind": "solid", "tolerance": 0.08, "growth": 0.2}}).first_cells
    assert (given.growth, given.smallest) == (0.2, coarse.smallest)


def test_a_tight_tolerance_has_small_cells_and_a_far_arc_of_the_harmonic_engine():
    loose, tuned, tight = (load_scene("flat", {"engine": {"tolerance": t}}) for t in (0.1, 0.001, 0.000125))
    assert tuned.first_cells.growth == pytest.approx(2 * tight.first_cells.growth)
    assert loose.first_cells.growth == pytest.approx(1.5 * tuned.first_cells.growth)
    radii = [scene.bodies["lower"].domain.far_radius for scene in (loose, tuned, tight)]
    assert radii == pytest.approx([1280.0, 1280.0, 1280.0 * 8**0.5])


def test_check_uses_the_solid_engine_with_its_own_cells():
    scene = load_scene("geometry2", {"engine": {"tolerance": 0.001, "growth": 0.3}})
    assert (scene.settings.engine, scene.check.settings.engine, scene.check.check) == (HARMONIC, SOLID, None)
    assert scene.check.settings.tolerance == 0.01
    assert scene.check.first_cells == SOLID.first_cells(0.01, scene.patch)
    assert scene.check.bodies["upper"].domain.far_radius == 320.0
    assert load_scene("flat").check is None
    assert load_scene("geometry2", {"engine": {"kind": "solid"}}).check is None


def test_check_refuses_what_only_the_harmonic_engine_can_do():
    beyond = {"lower": {"nu": 0.495}}
    assert load_scene("flat", beyond).settings.engine is HARMONIC
    with pytest.raises(BadScene, match=r"lower\.nu = 0\.495: use engine\.kind = 'harmonic'"):
        load_scene("flat", beyond | {"engine": {"check": True}})


def test_contour_points_may_be_given_in_the_scene():
    y = np.linspace(-40, 40, 41)
    points = np.column_stack([y, -(y**2) / 100]).tolist()
    scene = load_scene("geometry1", {"lower": {"contour": {"kind": "points", "points": points}}})
    assert scene.bodies["lower"].contour.position(0.0) == pytest.approx([0, 0])


@pytest.mark.parametrize("contour", [{}, {"file": "a.txt", "points": [[0, 0]]}])
def test_contour_points_have_exactly_one_source(contour):
    with pytest.raises(BadScene, match="contour"):
        load_scene("geometry1", {"lower": {"contour": {"kind": "points"} | contour}})


def test_moment_arm_of_a_central_load_is_not_limited():
    changes = {"rotation_reach": 60.0, "moment_arm": 40.0, "engine": {"far_radius": 160.0}}
    assert load_scene("geometry1", changes).settings.moment_arm == 40


SMALL = {"patch": {"a": 0.004, "b": 0.0025}, "rotation_reach": 20.0, "moment_arm": 5.0}
WIDE_GRID = {"grid": {"n_x": 4, "n_s": 3, "dx": 0.005, "ds": 0.008}}


def along_x(reach, s=0.0):
    return {"lines": [{"along": "x", "s": s, "reach": reach, "points": 11}]}


RATIOS = {  # changes at the limit, beyond it, what is said
    "a line along x": (
        SMALL | along_x(25.0),
        along_x(25.3),
        r"lines\.0 \(s = 0 mm\): reaches 25\.3 mm, 1\.01e\+04 times patch\.b = 0\.0025, .*at most 10000 "
        r"times by engine\.kind = 'harmonic': shorten it to 25 mm",
    ),
    "a line beside the load": (
        SMALL | along_x(15.0, 20.0),
        along_x(15.4, 20.0),
        r"lines\.0 .* reaches 25\.\d+ mm",
    ),
    "what M is fitted to": (
        SMALL | along_x(1.0) | {"rotation_reach": 25.0},
        {"rotation_reach": 25.3},
        r"rotation_reach: reaches 25\.3 mm, 1\.01e\+04 times patch\.b",
    ),
    "the far arc": (
        SMALL | along_x(1.0) | {"engine": {"far_radius": 12500.0}},
        {"engine": {"far_radius": 12500.5}},
        r"engine\.far_radius = 12500\.5: 5e\+06 times patch\.b = 0\.0025, .*at most 5e\+06 times",
    ),
    "the elements of a grid": (
        SMALL | along_x(1.0) | WIDE_GRID | {"rotation_reach": 25.0, "patch": {"a": 0.3, "b": 0.3}},
        {"rotation_reach": 25.3},
        r"rotation_reach: reaches 25\.3 mm, 1\.01e\+04 times grid\.dx / 2 = 0\.0025",
    ),
    "a line of the calibration": (
        SMALL | along_x(1.0) | {"calibration": {"x_max": 25.0, "s": [0.0]}},
        {"calibration": {"x_max": 25.3, "s": [0.0]}},
        r"calibration \(fit s = 0 mm\): reaches 25\.3 mm",
    ),
    "a line of the solid engine": (
        {"patch": {"a": 0.025, "b": 0.05}, "engine": {"kind": "solid"}} | along_x(25.0),
        along_x(25.3),
        r"lines\.0 .* 1\.01e\+03 times patch\.a = 0\.025, .*at most 1000 times by engine\.kind = 'solid'",
    ),
}


@pytest.mark.parametrize("case", RATIOS)
def test_distances_too_large_for_the_loaded_element_are_refused(case):
    at_the_limit, beyond, expected = RATIOS[case]
    load_scene("flat", at_the_limit)
    with pytest.raises(BadScene, match=expected):
        load_scene("flat", at_the_limit | beyond)


def test_scene_in_tiny_lengths_is_valid():
    """All lengths a millionth: no length is too small, ratios are."""
    micro = {name: 1e-6 * length for name, length in (("rotation_reach", 20.0), ("moment_arm", 5.0))}
    tiny = {"patch": {"a": 2e-7, "b": 3e-7}, "engine": {"far_radius": 1.28e-3}, **micro}
    assert load_scene("flat", tiny | along_x(25e-6)).patch.a == 2e-7


def test_listings_name_every_registered_contour_and_approximation():
    listed = listing("flat")
    assert all(f'kind = "{kind}"' in listed for kind in CONTOURS)
    names = ", ".join(f'"{variant}"' for variant in VARIANTS)
    assert f"#   one or more of: {names}" in listed
    assert f'#   one of: "auto", "C", {names}' in listed
