"""Keys of contact with friction: what goes together, and what is said of what does not."""

import tomllib

import pytest

from femic.results.contact import require_solvable
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene

PRISMATIC = {"upper": {"rolling_radius": float("inf")}}


def contact(**keys):
    return {"contact": keys}


REFUSED = {  # changes of the scene `rolling`, the message
    "a prismatic wheel": (
        PRISMATIC,
        r"upper\.rolling_radius = inf: .* needs a wheel: give upper\.rolling_radius",
    ),
    "no load": (contact(loads=[]), r"contact\.loads = \[\]: motion = 'rolling' needs a load"),
    "two loads": (contact(loads=[1.0, 2.0]), r"contact\.loads = \[1\.0, 2\.0\]: .* has one load: give one"),
    "no friction": (contact(friction=[]), r"contact\.friction = \[\]: .*at least 1 entries"),
    "smooth": (contact(friction=[0.0]), r"contact\.friction\.0 = 0\.0: .*greater than 0"),
    "friction twice": (contact(friction=[0.3, 0.3]), r"contact\.friction = .*0\.3 given twice"),
    "angles that fall": (
        contact(friction_by_angle=[[20, 1.0], [10, 0.5]]),
        r"contact\.friction_by_angle = .*angle 10 comes after 20: angles must grow",
    ),
    "a jump of friction": (
        contact(friction_by_angle=[[20, 1.0], [20, 0.5]]),
        r"angle 20 comes after 20: .* for a step give two that hardly differ",
    ),
    "an overhang": (
        contact(friction_by_angle=[[0, 1.0], [91, 0.5]]),
        r"contact\.friction_by_angle\.1\.0 = 91: Input should be at most 90",
    ),
    "glue": (
        contact(friction_by_angle=[[0, 11.0]]),
        r"contact\.friction_by_angle\.0\.1 = 11\.0: Input should be at most 10",
    ),
    "ice": (contact(friction_by_angle=[[0, 0.0]]), r"friction_by_angle = .*all factors are 0"),
    "angles alone": (
        contact(friction_by_angle=[0.0, 20.0]),
        r"contact\.friction_by_angle\.0 = 0\.0: Input should be a list",
    ),
    "creepages that fall": (
        contact(longitudinal=[0.1, 0.0]),
        r"longitudinal must grow: sort them, each once",
    ),
    "all of the force": (contact(equal_force=1.0), r"contact\.equal_force = 1\.0: .*less than 1"),
    "a top": (contact(spin=1e18), r"contact\.spin = 1e\+18: .*at most 1"),
    "a top that turns back": (contact(spin=-1.1), r"contact\.spin = -1\.1: .*at least -1"),
    "exact distance": (contact(gap="exact"), r"gap is only of motion = 'none', not 'rolling': leave it out"),
    "creepages pressed on": (
        contact(motion="compression", lateral=0.1),
        r"lateral is only of motion = 'rolling' or 'transient', not 'compression': leave it out",
    ),
    "friction at rest": (
        contact(motion="none"),
        r"friction is only of motion = 'rolling' or 'transient' or 'compression', not 'none': leave it out",
    ),
    "loads that fall": (
        contact(motion="compression", loads=[2.0, 1.0]),
        r"loads must grow: sort them, each once",
    ),
    "an unknown exchange": (
        contact(ics=["Bhat+sn:C"]),
        r"contact\.ics\.0 = 'Bhat\+sn:C': .*one of A, .*, or one with exchanges such as Bhat\+sn:B",
    ),
    "other motions": (contact(motion="sliding"), r"contact\.motion = 'sliding': .*'none', 'rolling'"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_inconsistent_keys_are_refused_with_a_remedy(name):
    changes, message = REFUSED[name]
    with pytest.raises(BadScene, match=message):
        load_scene("rolling", changes)


def test_exchange_with_bhat_prime_needs_effective_properties():
    ics = {"contact": {"motion": "rolling", "loads": [1.0], "ics": ["Bhat+sn:Bhat_prime"]}}
    with pytest.raises(BadScene, match="Bhat_prime needs effective properties of both bodies"):
        require_solvable(load_scene("geometry2", ics))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variants": ["Bhut"]}, r"variants\.0 = 'Bhut': Input should be 'A', 'B', .* or 'mix'"),
        ({"ics": "Bhut"}, r"ics = 'Bhut': Input should be 'auto', 'C', 'A', .* or 'mix'"),
        ({"contact": {"ics": ["Bhut"]}}, r"contact\.ics\.0 = 'Bhut': .*one of A, B, .*Bhat\+sn:B"),
    ],
)
def test_unknown_ics_are_refused_with_the_known_names(changes, message):
    with pytest.raises(BadScene, match=message):
        load_scene("flat", changes)


def test_only_contact_with_c_needs_an_engine_with_matrices():
    solid = {"engine": {"kind": "solid"}, "contact": {"loads": [1.0], "ics": ["A", "Bhat"]}}
    require_solvable(load_scene("tall", solid))
    with pytest.raises(BadScene, match=r"engine\.kind = 'solid': has no C on a grid"):
        require_solvable(load_scene("tall", solid | {"contact": {"loads": [1.0], "ics": ["A", "C"]}}))


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


def test_compression_allows_a_prismatic_body():
    assert load_scene("compression", PRISMATIC).contact.motion == "compression"


def test_pairs_of_angle_and_factor_are_read_and_are_none_by_default():
    pairs = load_scene("rolling", contact(friction_by_angle=[[0, 1], [20, 0.5]])).contact.friction
    assert pairs.friction_by_angle == ((0.0, 1.0), (20.0, 0.5))
    assert load_scene("rolling").contact.friction.friction_by_angle == ()
