"""Tables [stresses] and [damage]: keys of the laws, which reach the scene or are refused."""

import tomllib
from dataclasses import fields, replace

import pytest

from femic.damage.dang_van import DangVan
from femic.damage.laws import ArchardMap, EnergyLaw, TwinDiscLaw
from femic.damage.specification import DamageSpecification
from femic.scenes.contact import DamageTable, StressTable
from femic.scenes.file import SceneFile
from femic.scenes.listing import listing
from femic.scenes.load import load_scene, scene_from_table
from femic.scenes.scene import StressSpecification

LAWS = {"energy": EnergyLaw, "twin_disc": TwinDiscLaw, "archard": ArchardMap, "dang_van": DangVan}
OF_MATERIAL = {"archard": {"hardness"}}  # the hardness is a key of [damage]
SPEED = {"speed": 20.0}
GIVEN = {
    "energy": {"mild": 1.4},
    "twin_disc": {"transitions": [5.0, 50.0]},
    "archard": {"slow": 1e-4},
    "dang_van": {"compression": 0.0},
}


def fields_of(noun):
    return {field.name for field in fields(noun)}


def table_of(name):
    return type(getattr(DamageTable(), name))


@pytest.mark.parametrize("name", LAWS)
def test_keys_of_a_law_are_the_fields_of_its_class_with_their_defaults(name):
    table, law = table_of(name), LAWS[name]()
    assert set(table.model_fields) == fields_of(law) - OF_MATERIAL.get(name, set())
    assert dict(table()) == {key: getattr(law, key) for key in table.model_fields}
    assert all(field.description for field in table.model_fields.values())


def test_other_keys_are_the_fields_of_the_specifications():
    assert set(DamageTable.model_fields) == fields_of(DamageSpecification)
    assert set(StressTable.model_fields) == fields_of(StressSpecification)


@pytest.mark.parametrize("name", ["flat", "rolling", "compression"])
def test_without_tables_all_is_as_declared(name):
    scene = load_scene(name)
    assert scene.stresses == StressSpecification()
    assert scene.damage == DamageSpecification()


@pytest.mark.parametrize("name", LAWS)
def test_given_coefficients_replace_those_of_their_law_alone(name):
    keys = {"hardness": 2500.0} | SPEED | {name: GIVEN[name]}
    damage = load_scene("rolling", {"damage": keys}).damage
    values = {key: tuple(value) if isinstance(value, list) else value for key, value in GIVEN[name].items()}
    expected = DamageSpecification(hardness=2500.0, **SPEED)
    assert damage == replace(expected, **{name: replace(LAWS[name](), **values)})


def test_keys_of_stresses_reach_the_scene():
    keys = {"friction": 0.4, "force": -0.3, "fineness": 0.5, "estimated": False}
    assert load_scene("rolling", {"stresses": keys}).stresses == StressSpecification(**keys)


def test_force_zero_is_a_force():
    assert load_scene("rolling", {"stresses": {"force": 0.0}}).stresses.force == 0


def test_fatigue_below_the_surface_needs_no_friction():
    assert (
        load_scene("tall", {"damage": {"dang_van": {"compression": 0.5}}}).damage.dang_van.compression == 0.5
    )


def test_empty_tables_change_nothing():
    empty = load_scene("tall", {"stresses": {}, "damage": {"energy": {}, "archard": {}}})
    assert (empty.stresses, empty.damage) == (StressSpecification(), DamageSpecification())


def test_listing_has_given_tables_and_the_others_as_comments(tmp_path):
    scene = load_scene("rolling", {"damage": SPEED | {"energy": {"severe": 3.0}}, "stresses": {"force": 0.2}})
    path = tmp_path / "mine.toml"
    path.write_text(scene.text, encoding="utf-8")
    text = listing(str(path))
    assert "\n[damage.energy]  # wear by the work of friction" in text
    for line in ("# [damage.archard]  # wear by Archard", "# slow = 0.0005  # Archard's k"):
        assert any(found.startswith(line) for found in text.splitlines())
    again = tomllib.loads(text)
    assert again["damage"] == SPEED | {"energy": {"severe": 3.0}}
    assert scene_from_table(again, "again").damage == scene.damage
    assert SceneFile.model_validate(again).stresses == StressTable(force=0.2)
