"""Scene files: what they mean, and the messages about invalid ones."""

import tomllib

import numpy as np
import pytest

from approx.effective import EffectiveProperties, Transition
from approx.variants import VARIANTS
from femic.reference.engines import HARMONIC, SOLID
from femic.scenes.bodies import CONTOURS
from femic.scenes.file import SceneFile
from femic.scenes.listing import listing
from femic.scenes.load import builtin_names, load_scene
from tests.compare.conftest import SHORT_LINES


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


def test_moment_arm_of_a_central_load_is_not_limited():
    changes = {"rotation_reach": 60.0, "moment_arm": 40.0, "engine": {"far_radius": 160.0}}
    assert load_scene("geometry1", changes).settings.moment_arm == 40


def test_listings_name_every_registered_contour_and_approximation():
    listed = listing("flat")
    assert all(f'kind = "{kind}"' in listed for kind in CONTOURS)
    names = ", ".join(f'"{variant}"' for variant in VARIANTS)
    assert f"#   one or more of: {names}" in listed
    assert f'#   one of: "auto", "C", {names}' in listed
