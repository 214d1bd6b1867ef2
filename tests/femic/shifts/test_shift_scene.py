"""The scene of a wheel at a shift: its contact is that of the shift, also of profiles from files."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from femic.cache.store import Store
from femic.cli.main import DONE, WRONG_INPUT, exit_code
from femic.reference.run_options import RunOptions
from femic.results.contact import solve_scene
from femic.results.wheelset import SECOND
from femic.results.wheelset_contacts import ABOUT
from femic.results.wheelset_scene import write_scene
from femic.scenes.load import load_scene, scene_from_table
from femic.shifts.contact import C_FLANK, contact_at
from femic.shifts.sides import Place, bodies_at, lay_out_wheelset
from femic.shifts.specification import parse_specification
from geometries.errors import WrongInput
from geometries.profiles.standards import standard
from geometries.track.wheelset import settle

ELEMENTS, LOAD = 8, 80e3
NAMES = ["p_max", "estimate_p_max", "approach", "lateral"]
TABLE = {
    "shifts": [5.5],
    "rail": {"profile": "60E1", "E": 205e3},
    "wheel": {"profile": "S1002"},
    "track": {"gauge": 1435.0, "rail_inclination": 0.025},
    "wheelset": {"flange_back_distance": 1360.0, "nominal_radius": 460.0},
    "contact": {"load": LOAD, "ics": ["A", "Bhat"], "elements": ELEMENTS},
}


def at_the_shift(file, shift, side):
    """The numbers of a contact of a wheelset by ICs."""
    layout = lay_out_wheelset(file)
    place = Place(layout, settle(layout, shift, roll=ABOUT, within=SECOND), side)
    contact = file.contact.model_copy(update={"planar": False})
    return contact_at(place, file.rail, file.wheel, contact)


def contours(bodies, s):
    """Points and inclinations of rail and wheel."""
    both = [bodies[name].contour for name in ("lower", "upper")]
    return np.array([[*contour.position(s), contour.inclination(s)] for contour in both])


def of_scene(path, folder):
    """The contacts of a scene by ICs."""
    solved = solve_scene(load_scene(str(path)), RunOptions(1, Store(folder / "store")))
    return {ics: contact for (_, ics), contact in solved.contacts.items()}


@pytest.mark.parametrize(("shift", "side"), [(5.5, "left"), (-5.5, "right")])
def test_the_contact_of_the_scene_is_that_of_the_shift(shift, side, tmp_path):
    file = parse_specification(TABLE, tmp_path / "mine.toml")
    path = write_scene(file, shift, tmp_path, "mine")
    assert path.name == f"mine_{side}_{shift:g}.toml"
    layout = lay_out_wheelset(file)
    place = Place(layout, settle(layout, shift, roll=ABOUT, within=SECOND), side)
    s, bodies = np.linspace(-15, 15, 61), load_scene(str(path)).bodies
    expected = bodies_at(place, file.rail, file.wheel, C_FLANK)
    np.testing.assert_allclose(contours(bodies, s), contours(expected, s), rtol=0, atol=1e-6)
    for name in ("lower", "upper"):
        assert bodies[name].material == expected[name].material
        assert bodies[name].rolling_radius == pytest.approx(expected[name].rolling_radius, abs=1e-7)
    theirs = of_scene(path, tmp_path)
    found = at_the_shift(file, shift, side)
    for ics in ("A", "Bhat"):
        contact, own = (
            theirs[ics],
            {name: values.item() for name, values in found.sel(ics=ics)[NAMES].items()},
        )
        p_max, estimate = contact.normal.p.max(), contact.estimated_errors()["p_max"]
        assert abs(p_max - own["p_max"]) < estimate + own["estimate_p_max"]
        assert p_max == pytest.approx(own["p_max"], rel=0.01)
        assert contact.normal.approach == pytest.approx(own["approach"], rel=5e-3)
        assert -contact.contact.lateral_force == pytest.approx(own["lateral"], rel=0.01)


def test_profiles_from_files_are_found_from_any_folder_and_read_as_before(tmp_path, monkeypatch):
    """Points of the standards in other axes: the same contours to the spacing of the points."""
    for name, key in (("60E1", "rail"), ("S1002", "wheel")):
        outline = standard(name).outline
        y, z = outline.position(np.linspace(0, outline.length, 800))
        np.savetxt(tmp_path / f"{key}.txt", np.stack([-y, z]).T, fmt="%.9f")
    of_file = {"axes": "centre up", "unit": "mm"}
    measured = TABLE | {
        "rail": {"profile": "rail.txt", **of_file},
        "wheel": {"profile": "wheel.txt", "flange_back": -70.0, **of_file},
    }
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    file = parse_specification(measured, Path("mine.toml"))  # paths relative to this folder
    write_scene(file, 5.5, tmp_path / "out", "measured")
    write_scene(parse_specification(TABLE, tmp_path / "mine.toml"), 5.5, tmp_path / "out", "own")
    monkeypatch.chdir("/")
    pair = [load_scene(str(tmp_path / "out" / f"{name}_left_5.5.toml")) for name in ("measured", "own")]
    s = np.linspace(-5, 5, 21)
    for name in ("lower", "upper"):
        ours, theirs = (scene.bodies[name].contour.position(s) for scene in pair)
        np.testing.assert_allclose(ours, theirs, atol=5e-3)
    assert pair[0].bodies["upper"].rolling_radius == pytest.approx(
        pair[1].bodies["upper"].rolling_radius, abs=5e-3
    )


def keys_of_rolling(text):
    """The keys that the comments of a scene name."""
    lines = [line.removeprefix("#") for line in text.splitlines() if line.startswith("#     ")]
    return tomllib.loads("\n".join(lines))


def test_scenes_of_shifts_are_written_by_the_command(tmp_path, capsys):
    out = str(tmp_path / "out")
    assert exit_code(["shifts", "s1002-on-60e1", "--write", "6", "--out", out]) == DONE
    assert "Scene: " in capsys.readouterr().out
    text = (tmp_path / "out" / "s1002-on-60e1_left_6.toml").read_text()
    assert "# Assumed values that the specification does not give: rail.E = 210000 MPa, " in text
    assert keys_of_rolling(text) == {"motion": "rolling", "friction": [0.3]}
    assert exit_code(["shifts", "s1002-on-60e1", "--wheel", "right", "--out", out]) == WRONG_INPUT
    assert "--wheel right: only with --write SHIFT" in capsys.readouterr().err
    assert not (tmp_path / "out" / "shifts.nc").exists()


@pytest.mark.parametrize(("side", "sign"), [("left", 1), ("right", -1)])
def test_the_keys_of_rolling_are_those_of_the_wheel(side, sign, tmp_path):
    """As `RollingWheel` has them; friction by the angle to the track, along which the scene's axes lie."""
    rolling = {"friction": 0.4, "lateral": 0.002, "spin": 3e-6, "by_angle": [[20, 1], [40, 0.5]]}
    file = parse_specification(TABLE | {"rolling": rolling}, tmp_path / "mine.toml")
    text = write_scene(file, 5.5, tmp_path, "mine", side).read_text()
    keys, table = keys_of_rolling(text), tomllib.loads(text)
    of_wheel = {"lateral": sign * 0.002, "spin": sign * 3e-6, "friction_by_angle": [[20, 1], [40, 0.5]]}
    assert keys == {"motion": "rolling", "friction": [0.4], **of_wheel}
    del table["contact"]["gap"]
    scene = scene_from_table(table | {"contact": table["contact"] | keys}, "rolls")
    assert scene.contact.friction.spin == sign * 3e-6


def test_a_shift_without_its_roll_is_refused(tmp_path):
    file = parse_specification(TABLE | {"rolls": [1.0]}, tmp_path / "mine.toml")
    with pytest.raises(WrongInput, match=r"--write 4: rolls are only given at the shifts 5\.5 mm"):
        write_scene(file, 4.0, tmp_path, "mine")
