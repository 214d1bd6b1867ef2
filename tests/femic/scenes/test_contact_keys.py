"""Tables [contact], [stresses] and [damage]: each key is declared once, by the field that it fills."""

import tomllib
from dataclasses import dataclass, fields, replace
from typing import Annotated

import pytest
from pydantic import Field, ValidationError, create_model

from femic.contact.specification import ContactSpecification
from femic.damage.dang_van import DangVan
from femic.damage.laws import ArchardMap, EnergyLaw, TwinDiscLaw
from femic.damage.specification import DamageSpecification
from femic.key_types import Length, Several
from femic.scenes.contact import DamageTable, StressTable
from femic.scenes.file import SceneFile
from femic.scenes.listing import listing
from femic.scenes.load import load_scene, scene_from_table
from femic.scenes.scene import StressSpecification
from femic.scenes.scene_table import SceneTable, declared_keys, shared, tables


@dataclass(frozen=True)
class Wheel:
    radius: Annotated[Length, Field(description="radius [mm]")] = 460.0
    spokes: Annotated[Several[int], Field(min_length=1, description="numbers of spokes")] = (5,)
    name: str = ""


WheelTable = create_model(
    "WheelTable", __base__=SceneTable, **declared_keys(Wheel, {"radius": Length | None})
)


def test_a_table_has_the_defaults_descriptions_and_limits_of_its_dataclass():
    """Types of keys can be replaced."""
    assert Wheel(**shared(WheelTable(), Wheel)) == Wheel()
    assert WheelTable.model_fields["radius"].description == "radius [mm]"
    for wrong in ({"spokes": []}, {"radius": -1.0}, {"radius": "wide"}, {"rim": 1.0}):
        with pytest.raises(ValidationError):
            WheelTable.model_validate(wrong)
    assert WheelTable.model_validate({"radius": None, "spokes": [3, 4]}).spokes == (3, 4)
    assert WheelTable in set(tables())


# --- contact --------------------------------------------------------------------------------------------


def test_keys_of_contact_reach_its_specification_and_the_listing():
    changes = {"shift": 0.03, "elements": 12, "gap": "exact", "grid": "scene", "flanks": False}
    contact = load_scene("flat", {"contact": changes | {"ics": ["A", "Bhat+sn:B"]}}).contact
    assert contact == ContactSpecification(**changes, ics=("A", "Bhat+sn:B"))
    assert contact.exact
    assert not contact.automatic
    key = "# lateral_force = ...  # lateral force F_y on the upper body [N], without friction only"
    assert key in listing("flat")


def test_keys_of_friction_are_in_the_table_of_contact():
    by_angle = [[0, 1], [20, 0.5]]
    keys = {"friction": [0.1], "lateral": 0.001, "friction_by_angle": by_angle}
    friction = load_scene("rolling", {"contact": keys}).contact.friction
    assert (friction.coefficients, friction.lateral) == ((0.1,), 0.001)
    assert friction.friction_by_angle == ((0.0, 1.0), (20.0, 0.5))
    assert load_scene("rolling").contact.friction.friction_by_angle == ()


def test_builtin_rolling_and_compression_have_the_same_bodies():
    scenes = [load_scene(name) for name in ("rolling", "compression")]
    rolling, compression = (scene.contact for scene in scenes)
    assert (rolling.motion, compression.motion) == ("rolling", "compression")
    tables = [tomllib.loads(scene.text) for scene in scenes]
    for key in ("lower", "upper", "effective"):
        assert tables[0][key] == tables[1][key]
    assert set(rolling.ics) | {"B"} == set(compression.ics)  # those of figure 25 of [BVSV]
    creepages = rolling.friction.longitudinal
    assert len(creepages) == 19
    assert creepages == tuple(-xi for xi in reversed(creepages))
    assert rolling.friction.coefficients == (0.2, 0.4, 0.6)


# --- stresses and damage --------------------------------------------------------------------------------

LAWS = {  # the law, and a coefficient that is given
    "energy": (EnergyLaw, {"mild": 1.4}),
    "twin_disc": (TwinDiscLaw, {"transitions": (5.0, 50.0)}),
    "archard": (ArchardMap, {"slow": 1e-4}),
    "dang_van": (DangVan, {"compression": 0.0}),
}
SPEED = {"speed": 20.0}


@pytest.mark.parametrize("name", LAWS)
def test_keys_of_a_law_are_the_fields_of_its_class_with_their_defaults(name):
    """But for the hardness, which is a key of [damage]; what is given replaces these alone."""
    law, given = LAWS[name]
    table = type(getattr(DamageTable(), name))
    assert set(table.model_fields) == {field.name for field in fields(law)} - {"hardness"}
    assert dict(table()) == {key: getattr(law(), key) for key in table.model_fields}
    assert all(field.description for field in table.model_fields.values())
    damage = load_scene("rolling", {"damage": {"hardness": 2500.0} | SPEED | {name: given}}).damage
    assert damage == replace(DamageSpecification(hardness=2500.0, **SPEED), **{name: law(**given)})


def test_other_keys_are_the_fields_of_their_specifications():
    for table, specification in ((DamageTable, DamageSpecification), (StressTable, StressSpecification)):
        assert set(table.model_fields) == {field.name for field in fields(specification)}


def test_without_keys_all_is_as_declared():
    empty = {"stresses": {}, "damage": {"energy": {}, "archard": {}}}
    for name, changes in (("flat", None), ("rolling", None), ("compression", None), ("tall", empty)):
        scene = load_scene(name, changes)
        assert (scene.stresses, scene.damage) == (StressSpecification(), DamageSpecification())


def test_keys_of_stresses_reach_the_scene():
    for keys in ({"friction": 0.4, "force": -0.3, "fineness": 0.5, "estimated": False}, {"force": 0.0}):
        assert load_scene("rolling", {"stresses": keys}).stresses == StressSpecification(**keys)


def test_fatigue_below_the_surface_needs_no_friction():
    fatigue = {"dang_van": {"compression": 0.5}}
    assert load_scene("tall", {"damage": fatigue}).damage.dang_van.compression == 0.5


def test_listing_has_given_tables_and_the_others_as_comments(tmp_path):
    scene = load_scene("rolling", {"damage": SPEED | {"energy": {"severe": 3.0}}, "stresses": {"force": 0.2}})
    path = tmp_path / "mine.toml"
    path.write_text(scene.text, encoding="utf-8")
    text = listing(str(path))
    for start in (
        "[damage.energy]  # wear law by work of friction",
        "# [damage.archard]  # Archard's wear law",
        "# slow = 0.0005  # Archard's k",
    ):
        assert f"\n{start}" in text
    again = tomllib.loads(text)
    assert again["damage"] == SPEED | {"energy": {"severe": 3.0}}
    assert scene_from_table(again, "again").damage == scene.damage
    assert SceneFile.model_validate(again).stresses == StressTable(force=0.2)
