"""Profiles as contours of scenes: against exact contours, in disguises, and what is refused."""

import pickle
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from worn_profiles import TRACK, WHEELSET

from approx.effective import EffectiveProperties, Transition
from compare.campaigns.load import load_campaign
from compare.campaigns.tasks import campaign_tasks
from compare.pages.ics_results import scene_from_text
from femic.cache.store import Store
from femic.cli.main import WRONG_INPUT, exit_code
from femic.reference.run_options import RunOptions
from femic.results.calibration import with_properties
from femic.results.ics import compute
from femic.results.ics_dataset import approximations_dataset
from femic.scenes.errors import BadScene
from femic.scenes.listing import as_toml
from femic.scenes.load import load_scene, scene_from_table
from femic.scenes.receipts import key_of
from geometries.errors import WrongInput
from geometries.profiles.files import read_profile, write_profile
from geometries.profiles.placement import arc_length_at, contour_at, spline_contour
from geometries.profiles.preparation import prepare
from geometries.profiles.profile import Profile
from geometries.profiles.standards import NAMED, STANDARDS, standard, standard_profile
from geometries.track.layout import lay_out
from geometries.track.wheelset import settle

R = 15.0  # mm
STEEL = {"E": 210e3, "nu": 0.28}
ARC = {"kind": "arc", "radius": R, "flank_inclination_deg": 70.0}
WHEEL = STEEL | {"contour": ARC | {"radius": 15.6}, "rolling_radius": 500.0}
LINES = [{"along": "s", "x": 1.6, "reach": 9.0, "points": 31}]
FIT = {"combined": EffectiveProperties(mismatch_k=Transition(0.1, 12.0, 1.0, 2.0))}
OF_ARC = {"axes": "field up", "unit": "mm", "y_centre": 0.0, "steepest_deg": 70.0}


def arc_points(n):
    """Points of a circular arc, its crown at the origin (y, z) [mm]."""
    angle = np.linspace(-1.5, 1.5, n)
    return R * np.stack([np.sin(angle), np.cos(angle) - 1])


def head(n=301):
    """A head that is its own mirror image nowhere, undercut on both sides, off the origin (y, z) [mm]."""
    t = np.linspace(-1.75, 1.68, n)
    return np.stack([36 * np.sin(t) + 1.5 * np.cos(2 * t), 22 * np.cos(t) + 0.8 * np.sin(t) - 22])


def write(path, points, header=""):
    path.write_text(header + "".join(f"{y!r} {z!r}\n" for y, z in points.T.tolist()), encoding="utf-8")
    return {"file": str(path)}


def scene_with(contour, **keys):
    """A scene whose lower body has a profile, or another contour that says its kind."""
    lower = STEEL | {"contour": {"kind": "profile"} | contour}
    table = {"lower": lower, "upper": WHEEL, "patch": {"a": 0.3, "b": 0.2}, "lines": LINES, **keys}
    return scene_from_table({"reference_length": 10.0, "rotation_reach": 8.0} | table, "mine")


def approximations(scene):
    return approximations_dataset(scene).ic.sel(variant=["A", "Bhat"]).values


def difference(ours, theirs):
    """Largest difference as a share of the largest of each component."""
    scale = np.abs(theirs).max(axis=-1, keepdims=True)
    return np.nanmax(np.abs(ours - theirs) / np.where(scale > 1e-9 * scale.max(), scale, scale.max()))


def test_sampled_arc_has_the_ics_of_the_exact_one_to_the_sampling_error(tmp_path):
    """The error falls with the third power of the spacing, as that of a cubic spline's inclination does."""
    exact = approximations(scene_with(ARC))
    errors = []
    for n in (41, 81, 161):
        scene = scene_with(write(tmp_path / "arc.ban.txt", arc_points(n)) | OF_ARC | {"profile_kind": "rail"})
        errors.append(difference(approximations(scene), exact))
    orders = -np.diff(np.log2(errors))
    assert errors[0] < 1e-4
    assert np.all(orders > 2.5)


@pytest.mark.slow
def test_sampled_arc_has_c_of_the_exact_one(tmp_path):
    """Within a hundredth of the estimate of C."""
    engine = {"tolerance": 0.2, "check": False, "far_radius": 100.0}
    keys = {"engine": engine, "bodies": ["lower"], "components": ["nn", "sn"], "variants": ["A"]}
    file = write(tmp_path / "arc.txt", arc_points(161)) | OF_ARC | {"profile_kind": "rail"}
    ours, theirs = (
        compute(scene_with(contour, **keys), RunOptions(1)).references["lower"].c for contour in (file, ARC)
    )
    largest, known = np.nanmax(np.abs(theirs.ic)), np.nanmax(np.abs(theirs.estimate))
    assert np.nanmax(np.abs(ours.ic - theirs.ic)) < 0.01 * known + 1e-5 * largest


def test_same_rail_in_four_disguises_gives_one_scene(tmp_path):
    """Columns in mm; in inches, reversed, mirrored, upside down; a spline block; MiniProf, mirrored."""
    y, z = head()
    write_profile(Profile("rail", head()), tmp_path / "block.prr")
    miniprof = write(tmp_path / "new.ban", np.stack([-y, z]), "ProgramName=x\nColumnDef=X,Y\n\n")
    inches = write(tmp_path / "inch.txt", np.stack([-y, -z])[:, ::-1] / 25.4)
    disguises = [
        write(tmp_path / "plain.txt", head()) | {"profile_kind": "rail", "axes": "field"},
        inches | {"profile_kind": "rail", "axes": "centre", "unit": "inch"},
        {"file": str(tmp_path / "block.prr")},
        miniprof | {"axes": "centre"},
    ]
    place = {"y_centre": -20.0, "rail_inclination": 0.05}
    first, *others = (scene_with(disguise | place) for disguise in disguises)
    s = np.linspace(*first.bodies["lower"].contour.limits, 301)
    for other in others:
        ours, theirs = (each.bodies["lower"].contour for each in (other, first))
        np.testing.assert_allclose(ours.position(s), theirs.position(s), rtol=0, atol=1e-9)
        assert difference(approximations(other), approximations(first)) < 1e-9


def test_contact_centre_by_y_and_by_arc_length_is_the_same_place(tmp_path):
    file = write(tmp_path / "rail.prr.txt", head()) | {"profile_kind": "rail", "axes": "field"}
    prepared = prepare(read_profile(file["file"], "rail", axes="field"))
    s = arc_length_at(prepared, -20.0)
    places = {"y_centre": -20.0}, {"s_centre": s}
    by_y, by_s = (scene_with(file | place).bodies["lower"].contour for place in places)
    np.testing.assert_allclose(by_y.position(0.0), 0, atol=1e-12)
    np.testing.assert_allclose(by_s.position([-3, 5]), by_y.position([-3, 5]), atol=1e-9)
    np.testing.assert_allclose(by_y.inclination(2.0), prepared.inclination(s + 2.0), atol=1e-9)


def test_turned_rail_leans_to_the_track_centre():
    """Its field side goes up."""
    place = {"standard": "60E1", "y_centre": 0.0}
    inclined = {"rail_inclination": 0.025}
    level, leaning, further = (
        scene_with(place | keys).bodies["lower"].contour
        for keys in ({}, inclined, inclined | {"turn_deg": 2.0})
    )
    angle = np.arctan(0.025)
    inclinations = [float(contour.inclination(0.0)) for contour in (level, leaning, further)]
    np.testing.assert_allclose(inclinations, [0, -angle, -angle - np.radians(2)], atol=1e-12)
    assert leaning.position(5.0)[1] > level.position(5.0)[1]
    across, up = level.position(5.0)
    expected = np.cos(angle) * across - np.sin(angle) * up, np.sin(angle) * across + np.cos(angle) * up
    np.testing.assert_allclose(leaning.position(5.0), expected, atol=1e-12)


@pytest.mark.parametrize("name", STANDARDS)
def test_standard_as_a_spline_is_its_exact_curve(name):
    """Positions to 0.1 nm beside the gaps of the standard, curvatures to 1e-6 1/mm, jumps at the joints."""
    outline = standard(name).outline
    gap = float(np.max(outline.gaps[0]))
    centre = arc_length_at(outline, 3.0)
    exact, spline = (make(outline, centre, turn=0.1, steepest=1.2) for make in (contour_at, spline_contour))
    assert spline.limits == exact.limits
    assert spline.joints == exact.joints
    s = np.linspace(*exact.limits, 2001)
    s = s[np.min(np.abs(s[:, None] - np.array(exact.joints)), axis=1) > 1e-3]
    np.testing.assert_allclose(spline.position(s), exact.position(s), rtol=0, atol=1e-7 + gap)
    np.testing.assert_allclose(spline.inclination(s), exact.inclination(s), rtol=0, atol=1e-6)
    np.testing.assert_allclose(spline.curvature(s), exact.curvature(s), rtol=0, atol=1e-6)


def test_smoothing_brings_noise_near_the_exact_arc(tmp_path):
    noise = np.random.default_rng(3).normal(0, 0.005, 401)
    file = write(tmp_path / "arc.txt", arc_points(401) * (1 + noise / R) + [[0], [1]] * noise)
    s, worst = np.linspace(-10, 10, 201), {}
    for tolerance in (0.0, 0.005, "cross-validation"):
        profile = file | OF_ARC | {"profile_kind": "rail", "tolerance": tolerance}
        curvature = scene_with(profile).bodies["lower"].contour.curvature(s)
        worst[tolerance] = np.max(np.abs(curvature - 1 / R))
    assert worst[0.0] > 1
    assert max(worst[0.005], worst["cross-validation"]) < 0.01


# --- the built-in scenes --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "worn", "shift", "keys", "accuracy"),
    [("s1002-on-60e1", "", 6.0, {}, 1.0), ("s1002-on-60e1-worn", "-worn", 6.4, {"roll": "about rails"}, 2.0)],
)
def test_builtin_profiles_touch_where_the_wheelset_touches(name, worn, shift, keys, accuracy):
    """Contact centres, turn and rolling radius are those of a wheelset, to one or two micrometres."""
    rail, wheel = (NAMED[f"{profile}{worn}"].outline for profile in ("60E1", "S1002"))
    wheelset = replace(WHEELSET, nominal_radius=500.0)
    position = settle(lay_out((rail,) * 2, (wheel,) * 2, TRACK, wheelset), shift, **keys)
    touch, scene = position.left[0], load_scene(name)
    file = scene_from_text(scene.text, Path())
    lower, upper = file.lower, file.upper
    assert lower.contour.y_centre == pytest.approx(touch.on_rail[0], abs=accuracy * 1e-3)
    assert upper.contour.y_centre == pytest.approx(touch.on_wheel[0], abs=accuracy * 1e-3)
    assert lower.contour.turn == pytest.approx(np.arctan(1 / 40) - position.roll, abs=accuracy * 1e-6)
    assert upper.rolling_radius == pytest.approx(touch.radius, abs=1e-3)
    angles = [float(body.contour.inclination(0.0)) for body in scene.bodies.values()]
    assert angles[0] == pytest.approx(angles[1], abs=accuracy * 1e-4)
    assert angles[0] == pytest.approx(-(touch.angle - position.roll), abs=accuracy * 1e-4)


# --- files -----------------------------------------------------------------------------------------------


def text_of(contour):
    wheel = 'contour = { kind = "arc", radius = 15.6, flank_inclination_deg = 70.0 }\nrolling_radius = 500.0'
    bodies = f"[lower]\nE = 210e3\nnu = 0.28\n{contour}\n[upper]\nE = 210e3\nnu = 0.28\n{wheel}\n"
    return f"rotation_reach = 8.0\n{bodies}[patch]\na = 0.3\nb = 0.2\n"


KEYS = {"kind": "profile", "file": "rail.txt", "profile_kind": "rail", "axes": "field", "y_centre": 1.0}
PROFILE = f"contour = {as_toml(KEYS)}"


def test_key_of_results_depends_on_the_content_of_the_file_alone(tmp_path):
    """Not on when it was written, and not on notes about it."""
    path, y = tmp_path / "my.toml", head()
    higher = y + np.array([[0], [1e-4]])
    path.write_text(text_of(PROFILE), encoding="utf-8")
    keys = []
    for points, header in ((y, ""), (y, "# seen today\n"), (higher, ""), (y, "")):
        write(tmp_path / "rail.txt", points, header)
        keys.append(key_of(load_scene(str(path))))
    assert keys[0] == keys[1] == keys[3]
    assert keys[0] != keys[2]


def test_file_is_found_beside_the_scene_and_from_a_calibrated_copy(tmp_path):
    write(tmp_path / "rail.txt", head())
    (tmp_path / "my.toml").write_text(text_of(PROFILE), encoding="utf-8")
    scene = load_scene(str(tmp_path / "my.toml"))
    (tmp_path / "out").mkdir()
    (tmp_path / "out/again.toml").write_text(with_properties(scene, FIT), encoding="utf-8")
    again = load_scene(str(tmp_path / "out/again.toml"))
    s = np.linspace(-8, 8, 9)
    first, second = (each.bodies["lower"].contour.position(s) for each in (scene, again))
    np.testing.assert_array_equal(first, second)
    (tmp_path / "rail.txt").unlink()
    assert scene_from_text(scene.text, tmp_path).lower.contour.y_centre == 1.0


def test_campaign_has_a_column_of_files_and_its_tasks_their_contents(tmp_path):
    """Files are found beside the campaign; workers get bodies as they are."""
    for radius in (15, 16):
        write(tmp_path / f"r{radius}.txt", arc_points(161) * radius / R)
    contour = {"kind": "profile", "file": "r15.txt", "profile_kind": "rail"} | OF_ARC
    lower = f"contour = {as_toml(contour)}"
    (tmp_path / "my.toml").write_text(text_of(lower), encoding="utf-8")
    sweep = '[sweep.rail]\nkeys = ["lower.contour.file"]\nvalues = ["r15.txt", "r16.txt"]\n'
    (tmp_path / "radii.toml").write_text(f'scene = "my.toml"\n{sweep}', encoding="utf-8")
    campaign = load_campaign(tmp_path / "radii.toml")
    store = Store(tmp_path / "store")
    before = [task.keys for _, task in campaign_tasks(campaign, store)]
    bodies = [campaign.scene((f"r{radius}.txt",)).bodies["lower"] for radius in (15, 16)]
    curvatures = [float(pickle.loads(pickle.dumps(body)).contour.curvature(1.0)) for body in bodies]
    np.testing.assert_allclose(curvatures, [1 / 15, 1 / 16], rtol=1e-4)
    write(tmp_path / "r16.txt", arc_points(161) * 17 / R)
    after = [task.keys for _, task in campaign_tasks(load_campaign(tmp_path / "radii.toml"), store)]
    assert [keys in before for keys in after] == [True, False]


AT, OF_RAIL = {"y_centre": 0.0}, {"profile_kind": "rail"}


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"file": "rail.txt"}, r"rail\.txt: profile_kind: .*profile_kind = 'rail'"),
        ({"file": "rail.txt"} | OF_RAIL, r"rail\.txt: axes: .*give axes = 'field'"),
        ({"file": "bad.txt"} | OF_RAIL, r"bad\.txt, line 3: .*'1\.2x'"),
    ],
)
def test_what_is_missing_or_wrong_is_one_error_with_the_key(keys, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "rail.txt", head())
    (tmp_path / "bad.txt").write_text("0 1\n1 2\n1.2x 3\n", encoding="utf-8")
    with pytest.raises(BadScene) as caught:
        scene_with(keys | AT)
    assert re.search(rf"lower\.contour\.file = \S*{message}", str(caught.value), re.DOTALL), caught.value


def test_body_of_revolution_is_not_turned():
    wheel = {"kind": "profile", "standard": "S1002", "turn_deg": 1.0} | AT
    with pytest.raises(BadScene, match=r"upper\.contour: turned by 1 degrees.*turn the other body"):
        scene_with({"standard": "60E1"} | AT, upper=WHEEL | {"contour": wheel})


def test_wrong_file_is_refused_by_a_command_before_any_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rail.txt").write_text("0 1\n1 2\n3 nan\n", encoding="utf-8")
    (tmp_path / "my.toml").write_text(text_of(PROFILE), encoding="utf-8")
    assert exit_code(["contact", "my.toml"]) == WRONG_INPUT
    message = capsys.readouterr().err
    assert re.search(r"lower\.contour\.file = .*rail\.txt, line 3: ", message)
    assert len(message.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_section_of_a_list_is_the_contour_of_its_profile(tmp_path):
    for name, rail in (("a.prr", "54E1"), ("b.prr", "60E1")):
        write_profile(standard_profile(rail, 0.2), tmp_path / name)
    (tmp_path / "rail.slcs").write_text("0 1\n2\n0 0 0\n1\n0 a.prr\n1 b.prr\n")
    listed, alone = ({"file": str(tmp_path / name), "y_centre": 5.0} for name in ("rail.slcs", "b.prr"))
    s = np.linspace(-10, 10, 50)
    by_number, by_position, expected = (
        scene_with(contour).bodies["lower"].contour.position(s)
        for contour in (listed | {"section": 2}, listed | {"section_at": 1.0}, alone)
    )
    np.testing.assert_array_equal([by_number, by_position], [expected] * 2)
    with pytest.raises(WrongInput, match=r"contour\.file = .*section_at; rail\.slcs has 1: at 0, a\.prr"):
        scene_with(listed)
    with pytest.raises(WrongInput, match=r"section and section_at are of lists"):
        scene_with(alone | {"section": 1})
