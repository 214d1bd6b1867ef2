"""Keys of contact with friction: what goes together, and what is said of what does not."""

import tomllib

from femic.scenes.load import load_scene

PRISMATIC = {"upper": {"rolling_radius": float("inf")}}


def contact(**keys):
    return {"contact": keys}


def test_builtin_rolling_and_compression_have_the_same_bodies():
    rolling, compression = (load_scene(name) for name in ("rolling", "compression"))
    assert rolling.contact.motion == "rolling"
    assert compression.contact.motion == "compression"
    tables = [tomllib.loads(scene.text) for scene in (rolling, compression)]
    for key in ("lower", "upper", "effective"):
        assert tables[0][key] == tables[1][key]
    assert set(rolling.contact.ics) | {"B"} == set(compression.contact.ics)  # those of figure 25 of [BVSV]
    creepages = rolling.contact.friction.longitudinal
    assert len(creepages) == 19
    assert creepages == tuple(-xi for xi in reversed(creepages))
    assert rolling.contact.friction.coefficients == (0.2, 0.4, 0.6)


def test_pairs_of_angle_and_factor_are_read_and_are_none_by_default():
    pairs = load_scene("rolling", contact(friction_by_angle=[[0, 1], [20, 0.5]])).contact.friction
    assert pairs.friction_by_angle == ((0.0, 1.0), (20.0, 0.5))
    assert load_scene("rolling").contact.friction.friction_by_angle == ()
