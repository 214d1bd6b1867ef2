"""Outlines in scenes: their axes, files and standards, and what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import femic
from compare.campaigns.maps import _inputs_of_c
from femic.cache.store import Store
from femic.contact.supports import flatter_problem
from femic.results.finite_elements import require_suitable, stored_fe_contact
from femic.scenes.errors import BadScene
from femic.scenes.load import scene_from_table
from femic.scenes.plausibility import warnings
from femic.scenes.receipts import key_of
from geometries.outlines import RAIL_SECTIONS, SectionOutline
from geometries.profiles.placement import arc_length_at
from geometries.profiles.standards import standard

STEEL = {"E": 210e3, "nu": 0.28}
ARC = {"kind": "arc", "radius": 15.0, "flank_inclination_deg": 60.0}
RAIL = {"kind": "profile", "standard": "60E1", "y_centre": -20.0}
POINTS = [[40.0, -30.0], [40.0, -90.0], [-30.0, -90.0], [-30.0, -30.0]]
GIVEN = {"points": POINTS, "clamped": [2, 3]}


def scene_with(outline, contour=ARC, **keys):
    lower = STEEL | {"contour": contour} | ({"outline": outline} if outline else {})
    return scene_from_table(
        {"lower": lower, "upper": STEEL | {"contour": {"kind": "plane"}}} | keys, "outline"
    )


def outline_of(scene):
    return scene.bodies["lower"].outline


def test_points_are_in_the_axes_of_a_contour(tmp_path):
    (tmp_path / "points.txt").write_text("".join(f"{y} {z}\n" for y, z in POINTS), encoding="utf-8")
    of_file = scene_with({"file": str(tmp_path / "points.txt"), "clamped": [2, 3]})
    expected = SectionOutline(tuple(map(tuple, POINTS)), (2, 3))
    assert outline_of(scene_with(GIVEN)) == outline_of(of_file) == expected


@pytest.mark.parametrize("turn", [0.0, 0.025])
def test_a_section_of_a_profile_turns_with_it(turn):
    """Distances from the contact centre stay; the base inclines by the turn, its field side upwards."""
    scene = scene_with({"standard": "60E1"}, RAIL | {"rail_inclination": turn})
    drawn = RAIL_SECTIONS["60E1"].outline.corners
    head = standard("60E1").outline
    origin = head.position(np.array(arc_length_at(head, RAIL["y_centre"])))
    corners = outline_of(scene).corners
    np.testing.assert_allclose(np.hypot(*corners), np.hypot(*(drawn - origin[:, None])))
    first, last = outline_of(scene).clamped
    dy, dz = corners[:, first - 1] - corners[:, last - 1]
    assert (dz / dy, np.sign(dy)) == (pytest.approx(turn), 1)


def test_loads_and_lines_stay_on_the_contour():
    assert scene_with(None).extent == (-np.inf, np.inf)
    assert scene_with(GIVEN).extent == scene_with(GIVEN).bodies["lower"].contour.limits


def test_a_body_with_an_outline_has_no_convention_to_warn_of():
    steep = ARC | {"flank_inclination_deg": 84.0}
    assert any("slender" in text for text in warnings(scene_with(None, steep)))
    assert not any("slender" in text for text in warnings(scene_with(GIVEN, steep)))
    problem = scene_with(GIVEN).contact_problem
    assert flatter_problem(problem).bodies["lower"] == problem.bodies["lower"]


def test_results_and_maps_of_other_outlines_have_other_keys():
    scenes = [scene_with(outline) for outline in (GIVEN, GIVEN, GIVEN | {"clamped": [1, 4]}, None)]
    for key in (
        lambda scene: json.dumps(_inputs_of_c(scene, "lower")),
        lambda scene: Store().key("body", outline_of(scene)),
        lambda scene: key_of(replace(scene, text="")),
    ):
        same, again, *others = map(key, scenes)
        assert same == again
        assert len({same, *others}) == 3


def test_bodies_of_python_have_the_same_outlines():
    contour, steel = femic.arc(15.0, 60.0), femic.Material(210e3, 0.28)
    body = femic.Body(contour, steel, outline=GIVEN)
    assert body.table.outline.model_dump(mode="json", exclude_unset=True) == GIVEN
    assert hash(body) == hash(femic.Body(contour, steel, outline=GIVEN))
    with pytest.raises(femic.WrongInput, match=r"outline.*clamped"):
        femic.Body(contour, steel, outline={"points": POINTS})


def test_contact_by_finite_elements_refuses_an_outline_and_its_store_has_none():
    """A page of contact looks for stored contacts by finite elements, also where there can be none."""
    wheel = STEEL | {"contour": {"kind": "plane"}, "rolling_radius": 500.0}
    scene = scene_with(GIVEN, upper=wheel, contact={"loads": [1e3], "ics": ["C"]})
    with pytest.raises(BadScene, match="outline of a body: not supported in contact by finite elements"):
        require_suitable(scene)
    assert stored_fe_contact(scene, xr.Dataset(), Store()) is None
