from itertools import product

import numpy as np
import pytest
from profile_texts import MM, block_text, columns_text, miniprof_text, old_miniprof_text, rail, wheel

from geometries.errors import WrongInput
from geometries.profiles.axes import Axes, axes_by_shape
from geometries.profiles.files import read_profile, write_profile
from geometries.profiles.noise import noise, profile_figure
from geometries.profiles.preparation import prepare
from geometries.profiles.profile import Profile
from geometries.profiles.text import Rows, drop_zigzags

SECTIONS = {"rail": rail(), "wheel": wheel()}
DOWN = rail() * [[1.0], [-1.0]]  # of the rail, z down
ROUNDING = 1e-12  # [mm]; coordinates of 100 mm, times or divided by a unit


def save(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def disguised(points, unit, *, to_centre, down, backwards, repeated):
    points = points * np.array([[-1.0 if to_centre else 1.0], [-1.0 if down else 1.0]]) / MM[unit]
    points = np.repeat(points, 1 + (np.arange(points.shape[1]) % 7 == 3), axis=1) if repeated else points
    return points[:, ::-1] if backwards else points


@pytest.mark.parametrize("quote", ['"', "'"])
@pytest.mark.parametrize("separator", [",", ";", " , ", "\t"])
def test_quoted_cells_are_numbers(tmp_path, quote, separator):
    rows = [line.split() for line in columns_text(SECTIONS["rail"]).splitlines()]
    text = "\n".join(separator.join(f"{quote}{cell}{quote}" for cell in row) for row in rows)
    plain = read_profile(save(tmp_path, "a.txt", columns_text(SECTIONS["rail"])), kind="rail", axes="field")
    quoted = read_profile(save(tmp_path, "b.csv", f'"rail, worn"\n{text}'), kind="rail", axes="field")
    np.testing.assert_array_equal(quoted.points, plain.points)


# --- one section in many disguises -----------------------------------------------------------------


@pytest.mark.parametrize("unit", MM)
@pytest.mark.parametrize("kind", SECTIONS)
@pytest.mark.parametrize("layout", ["columns", "block", "miniprof", "old miniprof"])
def test_all_disguises_of_a_section_are_one_profile(tmp_path, kind, layout, unit):
    points = SECTIONS[kind]
    ending = {"columns": ".txt", "block": ".prr" if kind == "rail" else ".prw"}.get(
        layout, ".ban" if kind == "rail" else ".whl"
    )
    for flags in product([False, True], repeat=4):
        how = dict(zip(("to_centre", "down", "backwards", "repeated"), flags, strict=True))
        other = disguised(points, unit, **how)
        text = {
            "columns": columns_text,
            "block": lambda p: block_text(p, kind, units_len_f=repr(1000 / MM[unit])),
            "miniprof": miniprof_text,
            "old miniprof": old_miniprof_text,
        }[layout](other)
        side, height = ("centre" if how["to_centre"] else "field"), ("down" if how["down"] else "up")
        asked = {"kind": kind} if layout == "columns" else {}
        # what has to be asked for: a rail's side, the unit of MiniProf that is not mm, what is not as in
        # track coordinates
        asked |= (
            {"axes": f"{side} {height}"} if layout == "block" else {"axes": side} if kind == "rail" else {}
        )
        asked |= {"unit": unit} if "miniprof" in layout else {}
        profile = read_profile(save(tmp_path, "section" + ending, text), **asked)
        assert profile.kind == kind
        np.testing.assert_allclose(profile.points, points, rtol=0, atol=ROUNDING)
        assert any("repeat" in note for note in profile.notes) == how["repeated"]


def test_keys_of_a_block_undo_a_disguise(tmp_path):
    points = SECTIONS["wheel"]
    other = points * 2 + np.array([[30.0], [-4.0]])  # y to the field, z up, by growing y, half millimetres
    keys = {"shift_y": -30, "shift_z": 4, "mirror_z": 1, "inversion": 1, "units_len_f": 2000}
    profile = read_profile(save(tmp_path, "w.prw", block_text(other, "wheel", **keys)))
    np.testing.assert_allclose(profile.points, points, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("key", "unit"), [("units.len.f = 1000\n", None), ("units.len.f = 1000\n", "inch"), ("", "m")]
)
def test_the_unit_of_a_block_is_that_of_its_key_or_metres_and_no_other(tmp_path, key, unit):
    factor = {None: 1000.0, "inch": 1000 / 25.4, "m": 1.0}[unit]
    text = block_text(DOWN * factor / 1000).replace("units.len.f = 1000\n", key.replace("1000", repr(factor)))
    path = save(tmp_path, "r.prr", text)
    np.testing.assert_allclose(read_profile(path).points, SECTIONS["rail"], rtol=0, atol=ROUNDING)
    rounded = save(tmp_path, "q.prr", text.replace(repr(1000 / 25.4), "39.37"))
    assert np.array_equal(read_profile(rounded, unit=unit).points, read_profile(rounded).points)
    if key:
        with pytest.raises(WrongInput, match=r"unit = '\w+': units\.len\.f says otherwise"):
            read_profile(path, unit="m" if unit is None else "mm")


# --- the order of the steps of a spline block ------------------------------------------------------


def steps_by_hand(points, keys):
    """The steps as complex numbers y + iz, one point at a time; None for a deleted one."""
    turn = np.exp(1j * keys["rotate"] / keys["units_ang_f"])
    for y, z in points.T:
        w = (complex(y, z) + complex(keys["shift_y"], keys["shift_z"])) * turn
        if not keys["bound_y_min"] <= w.real <= keys["bound_y_max"]:
            continue
        w = complex(w.real, min(max(w.imag, keys["bound_z_min"]), keys["bound_z_max"]))
        w = -w.conjugate() if keys["mirror_y"] else w
        w = w.conjugate() if keys["mirror_z"] else w
        yield w * 1000 / keys["units_len_f"]


@pytest.mark.parametrize(("mirror_y", "mirror_z", "inversion"), list(product([0, 1], repeat=3)))
def test_steps_of_a_spline_block_are_done_in_their_order(tmp_path, mirror_y, mirror_z, inversion):
    points = SECTIONS["rail"] * [[10.0], [-10.0]]  # tenths of mm, z down
    keys = {
        **{"shift_y": 17.0, "shift_z": -21.0, "rotate": 3.0, "units_ang_f": 180 / np.pi},
        **{"bound_y_min": -300.0, "bound_y_max": 290.0, "bound_z_min": -20.0, "bound_z_max": 130.0},
        **{"mirror_y": mirror_y, "mirror_z": mirror_z, "inversion": inversion, "units_len_f": 1e4},
    }
    axes = f"{'centre' if mirror_y else 'field'} {'up' if mirror_z else 'down'}"
    profile = read_profile(save(tmp_path, "r.prr", block_text(points, **keys)), axes=axes)
    expected = np.array(list(steps_by_hand(points, keys)))
    expected = np.stack([expected.real * (1 - 2 * mirror_y), -expected.imag * (1 - 2 * mirror_z)])
    assert 10 < expected.shape[1] < points.shape[1]  # the bounds delete some
    np.testing.assert_allclose(profile.points, expected, rtol=0, atol=1e-12)
    notes = " ".join(profile.notes)
    steps = ["Shifted by 17 in y and -21 in z", "Rotated by 3 degrees", "were deleted", "were clipped"]
    steps += ["y was mirrored"] * mirror_y + ["z was mirrored"] * mirror_z
    steps += ["order was reversed (inversion)"] * inversion + ["1 unit of the file is 0.1 mm, by units.len.f"]
    places = [notes.index(step) for step in steps]
    assert places == sorted(places)


def test_bounds_without_a_range_have_no_effect(tmp_path):
    keys = {"bound_y_min": 1.0, "bound_y_max": 0.0, "bound_z_min": 2.0, "bound_z_max": 2.0}
    plain, bounded = (
        read_profile(save(tmp_path, "r.prr", block_text(DOWN, **extra))) for extra in ({}, keys)
    )
    assert np.array_equal(plain.points, bounded.points)


def test_points_too_near_and_zigzags_are_left_out(tmp_path):
    near = np.insert(DOWN, 21, DOWN[:, 20] + [0.01, 0.0], axis=1)
    path = save(tmp_path, "r.prr", block_text(near, point_dist_min=0.02))
    assert np.array_equal(read_profile(path).points, SECTIONS["rail"])
    # to and fro between points 30 and 31: the way from 30 over two points back and on to 31
    chord = DOWN[:, 31] - DOWN[:, 30]
    there = DOWN[:, 30:31] + np.outer(chord, [0.8, 0.3])
    zigzag = np.insert(DOWN, [31, 31], there, axis=1)
    for points in (zigzag, zigzag[:, ::-1]):
        profile = read_profile(save(tmp_path, "z.prr", block_text(points)))
        assert np.array_equal(profile.points, SECTIONS["rail"])
        assert any(note.startswith("2 points of zigzags") for note in profile.notes)


def test_a_hairpin_is_no_zigzag():
    """Right, back down, and on to the left; a zigzag goes on to the right."""
    hairpin = np.array([[0, 1, 2, 1.8, 0.8, -0.2], [0, 0, 0, -0.9, -0.6, -0.6]])
    zigzag = np.stack([[0, 1, 2, 1.8, 3.2, 4.2], hairpin[1]])
    for points, lines in ((hairpin, [0, 1, 2, 3, 4, 5]), (zigzag, [0, 1, 4, 5])):
        rows = Rows(points, np.arange(6), np.zeros_like(points))
        assert drop_zigzags(rows)[0].lines.tolist() == lines


# --- writing ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", SECTIONS)
def test_reading_what_was_written_is_the_identity(tmp_path, kind):
    path = tmp_path / ("s.prr" if kind == "rail" else "s.prw")
    rng = np.random.default_rng(3)
    points = SECTIONS[kind] + 1e-3 * rng.standard_normal(SECTIONS[kind].shape)
    write_profile(Profile(kind, points, "s", ("a note\nof 'two' lines",)), path)
    again = read_profile(path)
    assert np.array_equal(again.points, points)
    assert (again.kind, again.name) == (kind, "s")
    write_profile(again, path)
    assert np.array_equal(read_profile(path).points, points)


@pytest.mark.parametrize(
    ("kind", "points", "name", "message"),
    [
        ("rail", rail(), "r.prw", r"must end in \.prr"),
        ("rail", np.repeat(rail(), 2, axis=1), "r.prr", "61 when read back: leave out repeated points"),
        ("rail", rail() * np.nan, "r.prr", "y = nan: not a finite number"),
        ("rail", rail()[:, :3], "r.prr", "3 points are left; a profile needs 4"),
        ("rail", 0 * rail(), "r.prr", "1 points are left; a profile needs 4"),
        ("wheel", (wheel() * [[-1.0], [1.0]])[:, ::-1], "w.prw", "the flange of this wheel shows"),
        ("rail", rail(), "missing/r.prr", "cannot be written"),
    ],
)
def test_what_would_not_be_read_back_is_not_written(tmp_path, kind, points, name, message):
    with pytest.raises(WrongInput, match=message):
        write_profile(Profile(kind, points), tmp_path / name)
    assert not list(tmp_path.iterdir())


# --- what is asked for -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("points", "asked", "words"),
    [
        (rail(), {"axes": "field"}, ["kind", "'rail' or 'wheel'"]),
        (rail(), {"kind": "rail"}, ["axes", "'field'", "'centre'"]),
        (rail() * 0.2, {"kind": "rail", "axes": "field"}, ["unit", "'mm', 'm' or 'inch'"]),
        (np.stack([np.arange(60.0), np.arange(60.0)]), {"kind": "rail"}, ["'centre'", "'up'", "'down'"]),
        (wheel()[:, 20:], {"kind": "wheel"}, ["axes", "'field'", "'up'"]),
        (rail() * 30, {"kind": "rail", "axes": "field"}, ["unit", "'mm', 'm' or 'inch'"]),
        (rail(), {"kind": "rail", "axes": "field", "unit": "m"}, ["unit", "mm"]),
        (wheel(), {"kind": "wheel", "axes": "centre up"}, ["axes", "flange", "field up"]),
        (rail(), {"kind": "train"}, ["kind = 'train'", "'rail' or 'wheel'"]),
        (rail(), {"unit": "ft"}, ["unit = 'ft'", "'inch'"]),
        (rail(), {"axes": "left"}, ["axes = 'left'", "'field'", "'up'"]),
        (rail(), {"axes": "up down"}, ["axes = 'up down'"]),
        (rail(), {"axes": ""}, ["axes = ''"]),
        (rail(), {"kind": "rail", "axes": "field", "surface": 2}, ["surface = 2"]),
    ],
)
def test_refusals_name_the_argument_and_its_choices(tmp_path, points, asked, words):
    with pytest.raises(WrongInput) as error:
        read_profile(save(tmp_path, "s.txt", columns_text(points)), **asked)
    assert all(word in str(error.value) for word in words), str(error.value)


@pytest.mark.parametrize("kind", SECTIONS)
def test_a_format_that_contradicts_the_shape_is_refused_until_axes_are_given(tmp_path, kind):
    path = save(tmp_path, "s." + {"rail": "prr", "wheel": "prw"}[kind], block_text(SECTIONS[kind], kind))
    with pytest.raises(
        WrongInput, match=r"axes: 'field down' by the format, but the shape looks like '.*up'"
    ):
        read_profile(path)
    np.testing.assert_allclose(read_profile(path, axes="up").points, SECTIONS[kind], rtol=0, atol=ROUNDING)


def both_ways(points):
    """Points as they are, turned about each axis, and backwards, with the axes that they have then."""
    for y, z, step in product([1, -1], [1, -1], [1, -1]):
        yield (
            (points * [[y], [z]])[:, ::step],
            Axes("field" if y > 0 else "centre", "up" if z > 0 else "down"),
        )


CROWN = rail()[:, 20:-20]  # a head without faces
FACES = np.append(wheel(), [[137.0, 137.0], [0.0, 30.0]], axis=1)  # an outer face as high as the flange


@pytest.mark.parametrize(
    ("kind", "shape"), [("rail", rail()), ("rail", CROWN), ("wheel", wheel()), ("wheel", FACES)]
)
def test_shapes_show_their_axes(kind, shape):
    """Of a rail its height alone."""
    for points, axes in both_ways(shape):
        assert axes_by_shape(kind, points) == Axes(axes.y if kind == "wheel" else None, axes.z)


HALF_FLANGE = wheel(401)[:, np.argmin(wheel(401)[1]) :]  # from the tip on
BOTTOM = np.array([[-70.0, -60.0, -50.0, -40.0], [-50.0] * 4])
# a rail beside a guard rail: turned over, it could be a head with a foot
GUARDED = np.concatenate([rail()[:, 20:] - [[110.0], [0.0]], BOTTOM, rail()[:, :-20]], axis=1)
WAVES = np.stack([np.arange(60.0), np.sin(np.arange(60.0) / 5)])


@pytest.mark.parametrize(
    ("kind", "shape"),
    [("wheel", HALF_FLANGE), ("rail", GUARDED), ("rail", WAVES)],
    ids=["wheel", "rail", "waves"],
)
def test_shapes_that_show_no_axes_are_not_guessed(kind, shape):
    for points, _ in both_ways(shape):
        assert axes_by_shape(kind, points) == Axes()


def test_a_whole_rail_is_not_turned_over():
    """Its axes are known or not, but not the others."""
    foot = np.stack([[-75, -60, -20, -10, -36, -36, 36, 36, 10, 20, 60, 75.0], [0, 11, 20, 35, 135, 172] * 2])
    foot[1, 6:] = foot[1, 5::-1]
    for points, axes in both_ways(foot):
        assert not axes_by_shape("rail", points).contradicts(axes)


def test_a_rail_upside_down_is_refused(tmp_path):
    """A whole head, a crown, and two rails with a groove between, which turned over are a ridge."""
    ways = np.array([[1.0], [-1.0]])
    y = np.linspace(-60, 60, 241)
    ridge = np.stack([y, 48 * np.exp(-((y / 20) ** 8))])
    for points, words in (
        (rail() * ways, "axes = 'field up': the head of this rail shows 'down'"),
        (rail()[:, 12:-12] * ways, "axes = 'field up': the head of this rail shows 'down'"),
        (ridge, "axes: with z up it is a ridge 48 mm high between level parts"),
    ):
        path = save(tmp_path, "s.txt", columns_text(points))
        for surface in (None, 1):
            with pytest.raises(WrongInput, match=words):
                read_profile(path, "rail", axes="field up", unit="mm", surface=surface)
    turned_over = save(tmp_path, "s.txt", columns_text(ridge * ways))
    assert read_profile(turned_over, "rail", axes="field up", unit="mm", surface=1).points[1].max() <= 0
    foot = np.array([[-75.0, -60, -60, -8, -8], [-172.0, -172, -160, -140, -36]])
    whole = np.concatenate([foot, rail(201), foot[:, ::-1] * -ways], axis=1)  # a head on its web and foot
    whole = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in zip(whole.T, whole.T[1:], strict=False)]).T
    read_profile(save(tmp_path, "s.txt", columns_text(whole)), "rail", axes="field up", unit="mm")


def test_a_part_of_a_rail_that_is_no_running_surface_is_refused(tmp_path):
    """A face beyond a groove stands alone; it is 1 mm wide."""
    y = np.linspace(0, 80, 801)
    z = np.where((y > 40) & (y < 79), -30.0, 0.0) - 1e-3 * np.minimum(y, 40) ** 2
    path = save(tmp_path, "s.txt", columns_text(np.stack([y, z])))
    read_profile(path, "rail", axes="field up", unit="mm", surface=1)
    with pytest.raises(WrongInput, match=r"surface = 2: 1 mm wide, too narrow for a running surface"):
        read_profile(path, "rail", axes="field up", unit="mm", surface=2)


@pytest.mark.parametrize(("kind", "points"), [("rail", wheel()), ("wheel", rail())])
def test_wheels_and_rails_are_told_apart(tmp_path, kind, points):
    """Wheels said to be rails, and rails said to be wheels, with their axes in all ways."""
    for turned, axes in both_ways(points):
        path = save(tmp_path, "s.txt", columns_text(turned))
        with pytest.raises(
            WrongInput, match=f"kind = '{kind}': (it has the flange of a wheel|both ends lie)"
        ):
            read_profile(path, kind, axes=str(axes))


def test_points_that_nearly_repeat_each_other_are_one(tmp_path):
    """0.1 um apart at an end, with errors of that size: as they are, a kink of 45 degrees, a burr."""
    points = rail(400)
    end = points[:, -1:] + [[1e-4, 1e-4, 2e-4], [0.0, 1e-4, 1e-4]]
    start = points[:, :1] - [[1e-4], [1e-4]]
    near = np.concatenate([start, points, end], axis=1)
    profile = read_profile(save(tmp_path, "s.txt", columns_text(near)), "rail", axes="field")
    assert profile.points.shape[1] == 400
    np.testing.assert_array_equal(profile.points[:, [0, -1]], near[:, [0, -1]])
    (note,) = (note for note in profile.notes if "nearer than" in note)
    assert note.startswith("4 points")
    assert not noise(profile_figure(prepare(profile)))


def test_gaps_are_noted(tmp_path):
    points = np.delete(rail(400), np.s_[200:215], axis=1)
    profile = read_profile(save(tmp_path, "s.txt", columns_text(points)), "rail", axes="field")
    (note,) = (note for note in profile.notes if "gaps" in note)
    assert "lines 200 and 201" in note
    assert f"{np.hypot(*(points[:, 200] - points[:, 199])):.3g} mm" in note


# --- two surfaces ----------------------------------------------------------------------------------


@pytest.mark.parametrize("fill", [True, False], ids=["groove", "no points between"])
def test_one_of_two_surfaces_has_to_be_named(tmp_path, fill):
    head, guard = rail(201), rail(201) * [[0.8], [1.0]] - [[110.0], [5.0]]
    bottom = np.stack([np.linspace(guard[0, -1], head[0, 0], 40)[1:-1], np.full(38, -40.0)])
    both = np.concatenate([guard, bottom, head] if fill else [guard, head], axis=1)
    path = save(tmp_path, "s.txt", columns_text(both))
    with pytest.raises(WrongInput, match=r"surface: there are 2 \(1: lines 1 to .*; 2: lines") as error:
        read_profile(path, "rail", axes="field up")
    assert f"to {both.shape[1]}, y" in str(error.value)
    for number, part in ((1, guard), (2, head)):
        profile = read_profile(path, "rail", axes="field up", surface=number)
        # the outer face is whole, the inner one ends 20 mm below the lower of both tops
        way = slice(None, None, 1 if number == 1 else -1)  # from the outer face
        inwards = part[:, way]
        end = next(k for k in range(np.argmax(inwards[1]), 201) if inwards[1, k] <= np.max(guard[1]) - 20)
        assert np.array_equal(profile.points[:, way], inwards[:, :end])
    for wrong in (0, 3, True, "1"):
        with pytest.raises(WrongInput, match="surface"):
            read_profile(path, "rail", axes="field up", surface=wrong)


def test_a_wide_step_without_points_separates_surfaces(tmp_path):
    crown = rail(201)[:, 60:-60]  # not as deep as a groove
    for step, count in ((24.0, 1), (26.0, 2)):
        other = crown - [[np.ptp(crown[0]) + step], [0.0]]
        path = save(tmp_path, "s.txt", columns_text(np.concatenate([other, crown], axis=1)))
        if count == 1:
            assert read_profile(path, "rail", axes="field up").points.shape[1] == 2 * crown.shape[1]
            continue
        with pytest.raises(WrongInput, match="surface: there are 2"):
            read_profile(path, "rail", axes="field up")
        profile = read_profile(path, "rail", axes="field up", surface=2)
        assert np.array_equal(profile.points, crown)
