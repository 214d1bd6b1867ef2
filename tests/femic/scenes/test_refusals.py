"""What is said of scenes whose keys do not go together: the field, the value, and a remedy.

Ranges of single keys are in test_keys.py, limits of what goes together in test_limits.py.
"""

import re

import pytest

from femic.contact.specification import ContactSpecification, FrictionSpecification
from femic.results.contact import require_solvable
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene, read_scene, scene_path
from geometries.errors import WrongInput
from tests.femic.scenes.changes import PROPERTY, arc, engine, line

ARC = arc(60.0, 15.0)
WHEEL = {"rolling_radius": 100.0}
PRISMATIC = {"rolling_radius": float("inf")}
OUTLINE = {"points": [[40.0, -30.0], [40.0, -90.0], [-30.0, -90.0], [-30.0, -30.0]], "clamped": [2, 3]}
CROSSING = OUTLINE | {"points": OUTLINE["points"][::-1]}
OUTLINED = {"lower": ARC | {"outline": OUTLINE}}
NU = PROPERTY["effective"]["lower"]["nu"]
HARMONIC, ONLY = r"use engine\.kind = 'harmonic'", "is only of motion = 'rolling' or 'transient'"
NAMES = "one of A, .*, or one with exchanges such as Bhat\\+sn:B"
SPEED = {"speed": 20.0}


def table(name):
    """Changes of a table by its keys."""
    return lambda **keys: {name: keys}


lower, contact, stresses, damage = map(table, ("lower", "contact", "stresses", "damage"))


def points(*y, **keys):
    return lower(contour={"kind": "points", "points": [[each, 0.0] for each in y], **keys})


def profile(**keys):
    return lower(contour={"kind": "profile", **keys})


def law(name, **keys):
    return {"damage": {name: keys}}


REFUSED = {  # by a built-in scene: changes, and what is said
    "flat": [
        (lower(poisson=1), r"lower\.poisson: unknown key"),
        ({"engin": {}}, r"engin: unknown key; did you mean 'engine'"),
        ({"qqqqqq": {}}, r"qqqqqq: unknown key; see `femic scenes --show flat` for all keys"),
        ({"lines": 2 * line("x", 1.6, 3.0)["lines"]}, "two lines are identical"),
        ({"bodies": ["lower", "lower"]}, "lower given twice"),
        ({"variants": ["Bhut"]}, r"variants\.0 = 'Bhut': Input should be 'A', 'B', .* or 'mix'"),
        ({"ics": "Bhut"}, r"ics = 'Bhut': Input should be 'auto', 'C', 'A', .* or 'mix'"),
        (contact(ics=["Bhut"]), rf"contact\.ics\.0 = 'Bhut': .*{NAMES}"),
        (lower(**WHEEL, hub_radius=5.0), r"lower\.hub_radius = 5\.0: at least 0\.2 .* \(20 mm\)"),
        (lower(hub_radius=50.0), r"lower\.hub_radius = 50.0: a prismatic body has no hub"),
        (points(0, 1, 2, 1.5, 3), r"lower\.contour\.points: point 4: y = 1\.5 after 2: y must increase"),
        (points(-1, 0, 1), "3 points: at least 4"),
        (points(1, 2, 3, 4), r"y_centre = 0 mm: not between"),
        (points(), "contour = .*: give either file or points"),
        (points(0, 1, file=__file__), "contour = .*: give either file or points"),
        ({"effective": {"lower": {"G": NU | {"far": -1.0}}}}, "G at r_inf and beyond = -1.0"),
        ({"effective": {"combined": {"K": {}}}}, r"effective\.combined\.K: unknown key"),
        (lower(nu=0.495) | engine(check=True), r"lower\.nu = 0\.495: use engine\.kind = 'harmonic'"),
        (lower(outline={"clamped": [1, 2]}), "give either points, file or standard"),
        (lower(outline=OUTLINE | {"standard": "60E1"}), "give either points, file or standard"),
        (lower(outline={"points": OUTLINE["points"]}), r"give clamped \(two numbers\)"),
        (lower(outline={"standard": "60E1"}), r"lower\.outline\.standard = '60E1': .*give contour\.kind"),
        (lower(outline={"standard": "61E1"}), r"lower\.outline\.standard.*'60E1'"),
        (lower(**ARC, outline=CROSSING), r"lower\.outline\.points: the outline crosses itself or .* at y = "),
        (
            lower(**ARC, outline=OUTLINE) | engine(kind="solid"),
            r"lower\.outline: use engine\.kind = 'harmonic' \(without check\), or leave it out",
        ),
        (
            lower(**ARC, outline=OUTLINE) | engine(check=True),
            r"lower\.outline: use engine\.kind = 'harmonic'",
        ),
        (profile(), "lower.contour = .*: give either file or standard"),
        (profile(standard="60E1"), "give either y_centre or s_centre: where on the profile"),
        (profile(standard="60E1", y_centre=0.0, s_centre=9.0), "give either y_centre or s_centre"),
        (profile(standard="60E1", y_centre=0.0, tolerance=0.1, axes="up"), "axes, tolerance: only of a file"),
        (profile(standard="61E1", y_centre=0.0), r"contour\.standard = '61E1': .*'S1002'.*'60E1'"),
        (profile(standard="60E1", y_centre=99.0), r"y_centre = 99\.0: .*one point there.*s_centre"),
        (profile(standard="60E1", s_centre=900.0), r"s_centre = 900\.0: must lie between 0 and"),
        (profile(standard="60E1", s_centre=0.5), r"lower\.contour\.s_centre = 0\.5: .*degrees.*turn_deg"),
        (profile(standard="S1002", y_centre=0.0), "profile of a wheel, but this body is the rail"),
        (damage(passages=600.0), r"damage\.passages = 600: only of"),
    ],
    "tall": [
        (stresses(friction=0.3), "stresses.friction = 0.3: only of contact.motion = .*none"),
        (stresses(force=0.3), "stresses.force = 0.3: only of contact.motion = 'rolling'"),
        (damage(**SPEED), "damage.speed = 20: only of contact.motion = 'rolling', not 'none'"),
        (law("energy", mild=1.4), "damage.energy: only of"),
        (law("energy", mild=0.7), "damage.energy: only of"),
        (damage(passages=5.0), "damage.passages = 5: only of contact.motion = 'rolling'"),
    ],
    "compression": [
        (stresses(force=0.3), "stresses.force = 0.3: only of .*not 'compression'"),
        (law("dang_van", compression=0.0), "damage.dang_van: only of"),
    ],
    "rolling": [
        ({"upper": PRISMATIC}, r"upper\.rolling_radius = inf: .* needs a wheel: give upper\.rolling_radius"),
        (contact(loads=[]), r"contact\.loads = \[\]: motion = 'rolling' needs a load"),
        (contact(loads=[1.0, 2.0]), r"contact\.loads = \[1\.0, 2\.0\]: .* takes one load; use a .* scene"),
        (contact(friction=[]), r"contact\.friction = \[\]: .*at least 1 entries"),
        (contact(friction=[0.0]), r"contact\.friction\.0 = 0\.0: .*greater than 0"),
        (contact(friction=[0.3, 0.3]), r"contact\.friction = .*0\.3 given twice"),
        (contact(friction_by_angle=[[20, 1.0], [10, 0.5]]), "angle 10 comes after 20: angles must increase"),
        (contact(friction_by_angle=[[20, 1.0], [20, 0.5]]), "for a step, give two angles .* almost equal"),
        (contact(friction_by_angle=[[0, 1.0], [91, 0.5]]), r"_by_angle\.1\.0 = 91: .* be at most 90"),
        (contact(friction_by_angle=[[0, 11.0]]), r"_by_angle\.0\.1 = 11\.0: Input should be at most 10"),
        (contact(friction_by_angle=[[0, 0.0]]), r"friction_by_angle = .*all factors are 0"),
        (contact(friction_by_angle=[0.0]), r"friction_by_angle\.0 = 0\.0: Input should be a list"),
        (contact(longitudinal=[0.1, 0.0]), r"longitudinal must increase; sort the values and give each once"),
        (contact(equal_force=1.0), r"contact\.equal_force = 1\.0: .*less than 1"),
        (contact(spin=1e18), r"contact\.spin = 1e\+18: .*at most 1"),
        (contact(spin=-1.1), r"contact\.spin = -1\.1: .*at least -1"),
        (contact(gap="exact"), r"gap is only of motion = 'none', not 'rolling': leave it out"),
        (contact(motion="compression", lateral=0.1), rf"lateral {ONLY}, not 'compression': leave it out"),
        (contact(motion="none"), rf"friction {ONLY} or 'compression', not 'none'"),
        (contact(motion="compression", loads=[2.0, 1.0]), "loads must increase; sort .* each once"),
        (contact(ics=["Bhat+sn:C"]), rf"contact\.ics\.0 = 'Bhat\+sn:C': .*{NAMES}"),
        (contact(motion="sliding"), r"contact\.motion = 'sliding': .*'none', 'rolling'"),
        (stresses(friction=0.3), r"stresses.friction = 0.3: this value is not in .* add it there"),
        (stresses(depth=1.5), "stresses.depth: unknown key"),
        ({"stresses": 3}, "stresses = 3: "),
        (damage(hardness=3e3), "damage.hardness = 3000: .* give speed"),
        (law("energy", mid=1.4), "damage.energy.mid: unknown key; .*'mild'"),
        (damage(energy=1.4), "damage.energy = 1.4: "),
        (law("energy", severe=1.4), "damage.energy.severe: .* give damage.speed"),
        (law("energy", transition=4.0), "damage.energy.transition: .* give damage.sp"),
        (damage(steps=5), "damage.steps = 5: there is no wear; give damage.passages"),
        (damage(spread=1.0), "damage.spread = 1: there is no wear; .*, or leave this key out"),
        (law("archard", slow=1e-4), "damage.archard: .* give damage.hardness"),
        (law("archard", hardness=3e3), "damage.archard.hardness: unknown key"),
        (law("twin_disc", transitions=[9.0, 1.0]), r"twin_disc.transitions = \(9.0, 1"),
        (law("twin_disc", transitions=[9.0]), "damage.twin_disc.transitions.1: "),
        (law("twin_disc", mild=True), "damage.twin_disc.mild = True: "),
    ],
}
CASES = [(scene, *case) for scene, cases in REFUSED.items() for case in cases]


@pytest.mark.parametrize(("scene", "changes", "message"), CASES)
def test_what_does_not_go_together_is_one_error_with_its_key(scene, changes, message):
    with pytest.raises(BadScene, match=re.compile(message, re.DOTALL)) as caught:
        load_scene(scene, changes)
    assert len(str(caught.value).splitlines()) <= 2


def test_all_errors_come_at_once():
    with pytest.raises(BadScene, match=r"3 error\(s\)[^$]*variants\.1 = 'D'"):
        load_scene("flat", {"variants": ["A", "D"], "lower": {"nu": 0.7}, "upper": {"nu": 0.7}})


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("geometry", "did you mean 'geometry1' or 'geometry2'"),
        ("zzz", "'zzz': neither a file nor a built-in scene; Built-in: compression, flat"),
    ],
)
def test_a_misspelt_scene_is_refused_with_the_nearest_or_with_all(name, message):
    with pytest.raises(BadScene, match=message):
        scene_path(name)


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadScene, match=r"mine\.toml: not valid TOML: .* with `femic scenes --show flat`"):
        read_scene(path)


@pytest.mark.parametrize("keys", [{"motion": "rolling"}, {"friction": FrictionSpecification()}])
def test_friction_is_specified_for_motions_that_have_it_alone(keys):
    with pytest.raises(WrongInput, match="give `friction`"):
        ContactSpecification(**keys)


def test_contact_asks_for_what_its_ics_need():
    """Effective properties for B-hat-prime, and an engine with matrices for C alone."""
    exchanged = contact(motion="rolling", loads=[1.0], ics=["Bhat+sn:Bhat_prime"])
    with pytest.raises(BadScene, match="Bhat_prime needs effective properties of both bodies"):
        require_solvable(load_scene("geometry2", exchanged))
    approximate, with_c = (
        load_scene("tall", engine(kind="solid") | contact(loads=[1.0], ics=["A", ics]))
        for ics in ("Bhat", "C")
    )
    require_solvable(approximate)
    with pytest.raises(BadScene, match=r"engine\.kind = 'solid': this engine cannot compute C on a grid"):
        require_solvable(with_c)
