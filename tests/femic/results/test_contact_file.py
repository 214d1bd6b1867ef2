"""CONTACT's files of numerical ICs, against files made by hand and against its reader's rules."""

from itertools import count

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from approx.pair import column, matrix
from femic.cli.main import WRONG_INPUT, exit_code
from femic.contact.operators.dense import PARITY
from femic.results.contact_file import ContactFile, common_by_offsets, read, write
from femic.results.export import (
    approximate_file,
    depends_on_offset_only,
    to_contact,
)
from femic.scenes.load import load_scene, scene_from_table
from geometries.errors import WrongInput
from geometries.materials import both_bodies


def by_hand(strips):
    """A file made by hand, numbers going on from 1: a matrix for all strips, or one for each of three."""
    number, head = count(1), ["1 2"] if strips == 1 else ["3 1"]
    lines = [*head, "0 312", "1 0", "2 3 0.4 0.6"]
    for strip in range(strips):
        if strips > 1:
            lines += [f"strip {strip}", "", "skipped", "% skipped"]
        for offset in range(-2, 3):
            lines += [f" iy = {offset}", " columns"]
            lines += [f"{k} {0.4 * k:.1f} " + " ".join(str(next(number)) for _ in range(9)) for k in (0, 1)]
    return "\n".join(lines) + "\n"


BY_HAND_ONE = by_hand(1)


def test_handmade_files_are_read(tmp_path):
    """With one matrix and with one per strip."""
    for strips in (1, 3):
        (tmp_path / f"{strips}.txt").write_text(by_hand(strips))
    file, each = (read(tmp_path / f"{strips}.txt") for strips in (1, 3))
    assert (file.values.shape, file.n_x, file.n_s) == ((1, 5, 2, 3, 3), 2, 3)
    assert (file.dx, file.ds, file.convex, file.one_for_all) == (0.4, 0.6, 2, True)
    x, s, n = range(3)
    at = file.values[0, 3, 1]  # one strip further, one element on: 64 ... 72
    assert [at[n, n], at[n, x], at[n, s], at[x, n], at[x, x]] == [64, 65, 66, 67, 68]
    assert [at[x, s], at[s, n], at[s, x], at[s, s]] == [69, 70, 71, 72]
    assert (each.values.shape, each.convex) == ((3, 5, 2, 3, 3), 1)
    assert each.values[1, 0, 0, 2, 2] == 91
    assert each.values[2, 4, 1, 1, 1] == 270


@pytest.mark.parametrize("text", [by_hand(1), by_hand(3)])
def test_file_that_was_read_is_written_unchanged(text, tmp_path):
    (tmp_path / "hand.txt").write_text(text)
    write(read(tmp_path / "hand.txt"), tmp_path / "again.txt")

    def content(name):
        lines = (tmp_path / name).read_text().splitlines()
        numbers = [[float(word) for word in line.split()] for line in lines if line[:1].isdigit()]
        return len(lines), numbers

    assert content("hand.txt") == content("again.txt")


def test_written_values_are_read_back_exactly(tmp_path):
    decades = 10.0 ** np.arange(-18, 0, 2).reshape(3, 3)
    values = np.random.default_rng(1).normal(size=(3, 5, 2, 3, 3)) * decades
    write(ContactFile(values, 0.1 + 0.2, 1 / 3, 2), tmp_path / "all.txt")
    again = read(tmp_path / "all.txt")
    np.testing.assert_array_equal(again.values, values)
    assert (again.dx, again.ds) == (0.1 + 0.2, 1 / 3)


SIGNS = np.array([[1, -1, -1], [-1, 1, 1], [-1, 1, 1]])  # order x, s, n: xs, xn, sx, nx change


def as_contact_reads(file):
    """The ICs as CONTACT has them: (n_matrix, iy, ix, i, j), ix from -(n_x - 1) by the sign rule."""
    return np.concatenate([SIGNS * file.values[:, :, :0:-1], file.values], axis=2)


PLANE = {"kind": "plane"}
UNLIKE = {
    "patch": {"a": 0.2, "b": 0.3},
    "grid": {"n_x": 5, "n_s": 4},
    "upper": {"E": 70e3, "nu": 0.33, "contour": PLANE},
    "lower": {"E": 210e3, "nu": 0.28, "contour": PLANE},
}


def test_exported_a_of_plane_equals_closed_form_in_every_entry(tmp_path, capsys):
    """One matrix for all strips: one lag and one strip more than the grid."""
    scene = scene_from_table(UNLIKE, "plane")
    out = tmp_path / "out"
    (tmp_path / "plane.toml").write_text(scene.text)
    assert exit_code(["export", str(tmp_path / "plane.toml"), "--ics", "A", "--out", str(out)]) == 0
    assert "MX = 5 or less, MY = 4 or less," in capsys.readouterr().out
    file = read(out / "contact_A.txt")
    assert (file.values.shape, file.convex, file.dx, file.ds) == ((1, 9, 6, 3, 3), 2, 0.4, 0.6)
    constants = both_bodies(scene.bodies["upper"].material, scene.bodies["lower"].material)
    assert abs(constants.mismatch_k) > 0.01
    x, s = 0.4 * np.arange(-5, 6)[None, :], 0.6 * np.arange(-4, 5)[:, None]
    closed = np.moveaxis(HalfSpace(constants).ics(scene.patch, x, s), (0, 1), (2, 3)) * constants.G
    np.testing.assert_allclose(as_contact_reads(file)[0], closed, rtol=2e-14, atol=1e-18)
    # the two signs that are easily lost: upper softer, K > 0; a push moves the surface towards the load
    assert file.values[0, 4, 1, 0, 2] < 0 < file.values[0, 4, 1, 2, 0]
    assert file.values[0, 5, 0, 1, 2] < 0 < file.values[0, 5, 0, 2, 1]


CURVED = UNLIKE | {
    "upper": {"E": 70e3, "nu": 0.33, "contour": {"kind": "arc", "radius": 10.2, "flank_inclination_deg": 20}},
    "lower": {"E": 210e3, "nu": 0.28, "contour": {"kind": "arc", "radius": 2.0, "flank_inclination_deg": 15}},
    "grid": {"n_x": 5, "n_s": 4, "s": 0.3},
}


def test_file_of_curved_contour_has_observers_at_their_offsets():
    scene = scene_from_table(CURVED, "curved")
    file = approximate_file(scene, "B")
    assert (file.n_x, file.n_s, len(file.values)) == (5, 4, 4)  # no strip and no lag more
    for loaded in range(4):
        of_strip = scene.pair.constants.G * column("B", scene.pair, scene.grid, loaded)
        for offset in range(-3, 4):
            observed = loaded + offset
            got = np.moveaxis(file.values[loaded, offset + 3], 0, -1)
            inside = 0 <= observed < 4
            np.testing.assert_array_equal(got, of_strip[..., observed] if inside else np.zeros((3, 3, 5)))


ARC = {"kind": "arc", "radius": 10.0, "flank_inclination_deg": 30}
ON_ARC = CURVED | {name: CURVED[name] | {"contour": ARC} for name in ("lower", "upper")}


def test_bhat_has_one_matrix_on_arc_and_one_per_strip_beyond_joint():
    scene = scene_from_table(ON_ARC, "arc")
    single = approximate_file(scene, "Bhat")
    assert (len(single.values), single.n_x, single.n_s) == (1, 6, 5)
    each = to_contact(scene, matrix("Bhat", scene.pair, scene.grid))
    assert len(each.values) == 4
    np.testing.assert_allclose(single.values[0, 1:5, :5], each.values[3, :4], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(single.values[0, 4:8, :5], each.values[0, 3:], rtol=1e-9, atol=1e-12)
    beyond = scene_from_table(ON_ARC | {"grid": ON_ARC["grid"] | {"s": 4.5}}, "beyond")
    assert len(approximate_file(beyond, "Bhat").values) == 4


@pytest.mark.parametrize("s", [0.3, 10.0 * np.radians(30) - 1.2])  # in the last the arc ends with the grid
def test_additional_strip_and_lag_equal_values_on_larger_grid(s):
    """Where the grid fills the arc to its end, strips beyond it would lie on the flank."""
    scene = scene_from_table(ON_ARC | {"grid": ON_ARC["grid"] | {"s": float(s)}}, "arc")
    larger = scene_from_table(ON_ARC | {"grid": {"n_x": 6, "n_s": 5, "s": 0.0}}, "larger")
    ics = matrix("Bhat", larger.pair, larger.grid)
    assert depends_on_offset_only(ics)
    expected = common_by_offsets(ics) * scene.pair.constants.G
    np.testing.assert_allclose(approximate_file(scene, "Bhat").values, expected, rtol=1e-9, atol=1e-12)


def preconditioner(values, n_x, n_s, i, j):
    """Eigenvalues of the circulant over 2 n_x by 2 n_s offsets that CONTACT makes of one matrix."""
    middle, ring = values.shape[1] // 2, np.zeros((2 * n_s, 2 * n_x))
    for offset in range(-n_s, n_s):
        if 0 <= middle + offset < values.shape[1]:
            row = values[0, middle + offset, :n_x, i, j]
            ring[offset, :n_x], ring[offset, n_x + 1 :] = row, row[:0:-1]
    return np.fft.fft2(ring).real


def test_preconditioner_is_definite_with_additional_strip():
    """Steel planes, 51 x 39 elements: with zeros at offset -MY twelve eigenvalues of ss are negative."""
    steel = {"E": 210e3, "nu": 0.28, "contour": PLANE}
    table = {"patch": {"a": 0.2, "b": 0.2}, "grid": {"n_x": 51, "n_s": 39}, "upper": steel, "lower": steel}
    values = approximate_file(scene_from_table(table, "steel"), "A").values
    for k in range(3):
        assert np.min(preconditioner(values, 51, 39, k, k)) > 0
    assert np.sum(preconditioner(values[:, 1:-1], 51, 39, 1, 1) < 0) == 12


def test_file_of_single_strip_has_no_additional_strip():
    """CONTACT's solution in 2D wants zeros beside it."""
    scene = scene_from_table(ON_ARC | {"grid": {"n_x": 5, "n_s": 1}}, "strip")
    assert approximate_file(scene, "Bhat").values.shape == (1, 1, 5, 3, 3)


@pytest.mark.parametrize("shape", [(1, 5, 2, 3), (1, 4, 2, 3, 3), (2, 5, 2, 3, 3), (1, 5, 2, 3, 2)])
def test_values_of_wrong_shape_are_refused(shape):
    with pytest.raises(WrongInput, match="is needed"):
        ContactFile(np.zeros(shape), 0.1, 0.1, 2)


def test_ics_of_wheel_have_parity_that_reader_assumes():
    """At negative lags, as the operator on a grid has it."""
    np.testing.assert_array_equal(PARITY, SIGNS)
    scene = load_scene("geometry2", {"grid": {"n_x": 4, "n_s": 3}})
    patch, strips = scene.grid.patch(0), scene.grid.strips
    forward, backward = (scene.pair.approximate("Bhat", patch, (lag, strips)) for lag in (0.9, -0.9))
    np.testing.assert_allclose(backward, SIGNS[..., None] * forward, rtol=1e-12, atol=1e-20)


def test_convex_body_is_identified():
    valley = {"contour": {"kind": "points", "points": [[float(y), 0.02 * y * y] for y in range(-6, 7)]}}
    groove = CURVED | {name: CURVED[name] | valley for name in ("lower", "upper")}
    for table, convex in ((groove, 1), (CURVED, 2)):
        assert to_contact(scene_from_table(table, "scene"), np.ones((5, 4, 4, 3, 3))).convex == convex


def output_of(table, tmp_path, capsys, *arguments):
    """Return the exit code of `femic export` and its output without line breaks."""
    path = tmp_path / "scene.toml"
    path.write_text(scene_from_table(table, "scene").text)
    code = exit_code(["export", str(path), *arguments, "--out", str(tmp_path / "out")])
    return code, " ".join("".join(capsys.readouterr()).split())


def test_settings_for_contact_are_printed(tmp_path, capsys):
    """Edges of the grid, not centres; the upper body first; G in MPa."""
    code, output = output_of(CURVED, tmp_path, capsys, "--ics", "B")
    assert code == 0
    assert "contact_B.txt: 4 matrices, one per loaded strip, 5 lags" in output
    assert "MX = 5 or less, MY = 4, XL = -1, YL = -0.9, DX = 0.4, DY = 0.6 mm" in output
    assert "CHI = 0, DQ = 0.4 if it rolls" in output
    assert "body 1 = upper: POISS = 0.33, 0.28, GG = 26315.789, 82031.25 MPa" in output
    assert "MAXOUT > 1" in output
    assert "contact_distances.txt: h(x, s) - zeta cos(delta(s)) [mm]" in output
    assert "docs/" not in output  # pages that are not installed


@pytest.mark.parametrize("ics", ["Bhat", "auto"])
def test_discount_is_refused_for_approximations(ics, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("compare.studies.frontier.choose", lambda *_, **__: pytest.fail("ICs were chosen"))
    code, output = output_of(CURVED, tmp_path, capsys, "--ics", ics, "--discount", "none")
    assert code == WRONG_INPUT
    assert f"discount = none, ics = {ics}: the discount applies to C only" in output
    assert not (tmp_path / "out").exists()


def test_bhat_prime_is_refused_without_effective_properties(tmp_path, capsys):
    fit = {"mismatch_k": {"far": 0.1, "r_inf": 9.0, "m": 1.0, "n": 2.0}}
    for_one = CURVED | {"bodies": ["lower", "combined"], "effective": {"lower": fit}}
    for table in (CURVED, for_one):
        code, output = output_of(table, tmp_path, capsys, "--ics", "Bhat_prime")
        assert code == WRONG_INPUT
        assert "the scene has no effective properties" in output


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1 2\n", "x 2\n", "the first 4 lines"),
        ("1 2\n", "2 2\n", "n_matrix must be 1 or my"),
        ("1 2\n", "1 3\n", "convex = 3"),
        ("0 312", "0 123", "line 2: [0, 123]; only [0, 312] is read"),
        ("1 0\n", "0 0\n", "line 3"),
        ("2 3 0.4 0.6", "2 3 0.4", "the first 4 lines"),
        ("2 3 0.4 0.6", "0 3 0.4 0.6", "mx = 0"),
        ("1 0.4 28 29", "2 0.4 28 29", "line 12: expected ix = 1"),
        ("35 36", "35 nan", "values: 1 are not finite"),
        ("89 90\n", "89\n", "line 24: expected ix = 1"),
        ("1 0.4 82 83 84 85 86 87 88 89 90\n", "", "line 24: expected ix = 1"),
    ],
)
def test_damaged_files_are_refused(old, new, message, tmp_path):
    assert BY_HAND_ONE.count(old) == 1 or old in ("1 2\n", "1 0\n")
    (tmp_path / "bad.txt").write_text(BY_HAND_ONE.replace(old, new, 1))
    with pytest.raises(WrongInput, match=r"^.*" + message.translate({91: r"\[", 93: r"\]"})):
        read(tmp_path / "bad.txt")
