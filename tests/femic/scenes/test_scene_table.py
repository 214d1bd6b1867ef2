"""Tables of scene files that are made from dataclasses: a key is declared once."""

from dataclasses import dataclass
from typing import Annotated

import pytest
from pydantic import Field, ValidationError, create_model

from femic.contact.specification import ContactSpecification
from femic.key_types import Length, Several
from femic.scenes.listing import listing
from femic.scenes.load import load_scene
from femic.scenes.scene_table import SceneTable, declared_keys, shared, tables


@dataclass(frozen=True)
class Wheel:
    radius: Annotated[Length, Field(description="radius [mm]")] = 460.0
    spokes: Annotated[Several[int], Field(min_length=1, description="numbers of spokes")] = (5,)
    name: str = ""


WheelTable = create_model(
    "WheelTable", __base__=SceneTable, **declared_keys(Wheel, {"radius": Length | None})
)


def test_a_table_has_the_defaults_descriptions_and_limits_of_the_dataclass():
    assert Wheel(**shared(WheelTable(), Wheel)) == Wheel()
    assert WheelTable.model_fields["radius"].description == "radius [mm]"
    for wrong in ({"spokes": []}, {"radius": -1.0}, {"radius": "wide"}, {"rim": 1.0}):
        with pytest.raises(ValidationError):
            WheelTable.model_validate(wrong)


def test_type_of_a_key_can_be_replaced():
    assert WheelTable.model_validate({"radius": None, "spokes": [3, 4]}).spokes == (3, 4)
    assert WheelTable in set(tables())


def test_a_key_of_contact_reaches_its_specification_and_the_listing():
    changes = {"shift": 0.03, "elements": 12, "gap": "exact", "grid": "scene", "flanks": False}
    contact = load_scene("flat", {"contact": changes | {"ics": ["A", "Bhat+sn:B"]}}).contact
    assert contact == ContactSpecification(**changes, ics=("A", "Bhat+sn:B"))
    assert contact.exact
    assert not contact.automatic
    assert "# lateral_force = ...  # without friction: lateral force F_y" in listing("flat")


def test_friction_keys_are_in_the_contact_table():
    friction = load_scene("rolling", {"contact": {"friction": [0.1], "lateral": 0.001}}).contact.friction
    assert friction.coefficients == (0.1,)
    assert friction.lateral == 0.001
