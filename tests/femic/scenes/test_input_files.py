"""Files that scene files name: found from anywhere, and what is written of a scene can be run anywhere."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
import tomlkit

from compare.campaigns.keys import CampaignFile
from compare.campaigns.load import load_campaign
from femic.cli.main import exit_code
from femic.scenes import receipts
from femic.scenes.bodies import CONTOURS, OutlineTable, PlaneTable
from femic.scenes.contact import ContactTable
from femic.scenes.file import SceneFile
from femic.scenes.input_files import make_files_absolute, replace_files
from femic.scenes.listing import listing
from femic.scenes.load import load_scene, scene_from_table
from femic.scenes.scene_table import tables
from geometries.outlines import RAIL_SECTIONS
from tests.compare.conftest import scene_text
from tests.femic.reference.stand_ins import b_hat_as_c

KEYS = {  # that name files, and what is in these
    "lower.contour": {"kind": "points", "file": "rail.txt"},
    "upper.contour": {"kind": "points", "file": "wheel.txt"},
    "contact.extra_gap": "gap.txt",
}
COMMENT = "# a comment that stays"


@pytest.fixture
def folder(tmp_path):
    """A folder with a scene that names files beside it, in each key that does."""
    home = tmp_path / "home"
    home.mkdir()
    y = np.linspace(-12, 12, 97)
    np.savetxt(home / "rail.txt", np.column_stack([y, -(y**2) / 25]))
    np.savetxt(home / "wheel.txt", np.column_stack([y, -(y**2) / 26]))
    np.savetxt(home / "gap.txt", np.column_stack([y / 4, (y / 4) ** 2 / 1000]))
    (home / "mine.toml").write_text(f"{COMMENT}\n{tomlkit.dumps(with_files())}", encoding="utf-8")
    return home


def with_files():
    table = tomllib.loads(scene_text())
    table["contact"] = table.get("contact", {}) | {"loads": [1e3], "extra_gap": KEYS["contact.extra_gap"]}
    for body in ("lower", "upper"):
        table[body]["contour"] = KEYS[f"{body}.contour"]
    return table


def meaning(scene):
    """What a scene computes with: contours and the gap."""
    s = np.linspace(-5, 5, 11)
    contours = [scene.bodies[body].contour.position(s) for body in ("lower", "upper")]
    gap = scene.contact.extra_gap.at(np.zeros(1), s / 4)
    return [*contours, gap]


def assert_same(one, other):
    for ours, theirs in zip(meaning(one), meaning(other), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def from_elsewhere(text, tmp_path, monkeypatch):
    """The scene of a text that is written into a folder without the files."""
    away = tmp_path / "away"
    away.mkdir()
    (away / "copy.toml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(away)
    return load_scene("copy.toml")


def test_every_key_of_a_path_declares_that_it_names_a_file():
    for table in {*tables()} - {CampaignFile}:  # whose points may be "all"
        for key, field in table.model_fields.items():
            if Path.__name__ in str(field.annotation):
                named = {key: "a.txt"}
                replace_files(named, table, lambda _: "found")
                assert named == {key: "found"}, (table, key)


def test_all_declared_keys_are_found_from_the_whole_scene():
    """Contours of all kinds, outlines, the extra gap and maps of C; other ICs and other texts stay."""
    bodies = ("lower", "upper")
    kinds = [kind for kind, table in CONTOURS.items() if "file" in table.model_fields]
    assert kinds == ["points", "profile"]
    for kind in kinds:
        table = {body: {"contour": {"kind": kind, "file": "c"}, "outline": {"file": "o"}} for body in bodies}
        table |= {"title": "t", "contact": {"extra_gap": "g", "ics": ["C", "map:m", "Bhat"]}}
        replace_files(table, SceneFile, str.upper)
        for body in bodies:
            assert table[body] == {"contour": {"kind": kind, "file": "C"}, "outline": {"file": "O"}}
        assert table["title"] == "t"
        assert table["contact"] == {"extra_gap": "G", "ics": ["C", "map:M", "Bhat"]}


@pytest.mark.parametrize("value", [3, None, ["a", 3], {"file": {"x": 1}}, "text"])
def test_what_is_of_another_type_stays(value):
    table = {"lower": value, "contact": {"extra_gap": 5, "ics": 7}, "patch": value}
    before = str(table)
    make_files_absolute(table, SceneFile)
    assert str(table) == before


def test_a_scene_is_found_and_its_text_can_be_run_from_another_folder(folder, tmp_path, monkeypatch):
    scene = load_scene(str(folder / "mine.toml"))
    assert COMMENT in scene.text
    assert_same(from_elsewhere(scene.text, tmp_path, monkeypatch), scene)


def test_the_listing_of_a_scene_can_be_run_from_another_folder(folder, tmp_path, monkeypatch):
    text = listing(str(folder / "mine.toml"))
    assert_same(from_elsewhere(text, tmp_path, monkeypatch), load_scene(str(folder / "mine.toml")))


@pytest.mark.parametrize("name", ["rail.txt", "wheel.txt"])  # ICs do not depend on gaps
def test_results_are_out_of_date_where_the_file_of_a_contour_has_changed(folder, name):
    before = receipts.key_of(load_scene(folder / "mine.toml"))
    assert receipts.key_of(load_scene(folder / "mine.toml")) == before
    points = np.loadtxt(folder / name)
    points[:, 1] *= 1.001
    np.savetxt(folder / name, points)
    assert receipts.key_of(load_scene(folder / "mine.toml")) != before


def test_files_of_changes_and_of_tables_are_relative_to_the_working_directory(folder, monkeypatch):
    whole = load_scene(str(folder / "mine.toml"))
    monkeypatch.chdir(folder)
    changed = load_scene(str(folder / "mine.toml"), {"lower": {"contour": {"file": "wheel.txt"}}})
    np.testing.assert_array_equal(meaning(changed)[0], meaning(whole)[1])
    assert tomllib.loads(changed.text)["lower"]["contour"]["file"] == str(folder / "wheel.txt")
    assert_same(scene_from_table(with_files(), "mine"), whole)


def test_a_campaign_reads_files_beside_it_and_those_of_its_scene_beside_that(folder, tmp_path, monkeypatch):
    whole = load_scene(str(folder / "mine.toml"))
    (tmp_path / "wheel.txt").write_bytes((folder / "rail.txt").read_bytes())
    campaign = 'scene = "home/mine.toml"\n[set.upper.contour]\nfile = "wheel.txt"\n[sweep.nu]\n'
    campaign += 'keys = ["lower.nu"]\nvalues = [0.2, 0.3]\n'
    (tmp_path / "both.toml").write_text(campaign, encoding="utf-8")
    monkeypatch.chdir(folder.parent)
    loaded = load_campaign(Path("both.toml"))
    monkeypatch.chdir(folder)
    assert loaded.table["upper"]["contour"]["file"] == str(tmp_path / "wheel.txt")  # maps read it elsewhere
    lower, upper, gap = meaning(loaded.scene((0.3,)))
    np.testing.assert_array_equal(lower, upper)
    np.testing.assert_array_equal(gap, meaning(whole)[2])


def test_outlines_are_found_from_another_folder(tmp_path, monkeypatch):
    """A rail's own section, given as a file."""
    section = RAIL_SECTIONS["60E1"].outline
    np.savetxt(tmp_path / "section.txt", section.corners.T)
    table = {"outline": {"file": "section.txt", "clamped": [1, 2]}}
    make_files_absolute(table["outline"], OutlineTable, tmp_path)
    monkeypatch.chdir("/")
    outline = OutlineTable.model_validate(table["outline"], strict=False)
    corners = outline.outline(PlaneTable(kind="plane")).corners
    np.testing.assert_allclose(corners, section.corners)


def test_maps_are_found_from_another_folder(tmp_path):
    table = {"ics": ["Bhat", "map:sweeps/c.toml"]}
    make_files_absolute(table, ContactTable, tmp_path)
    assert table["ics"] == ["Bhat", f"map:{tmp_path / 'sweeps/c.toml'}"]


@pytest.mark.usefixtures("folder")
def test_what_run_writes_can_be_run_again_and_compared(tmp_path, monkeypatch):
    """`femic run`, its scene from another folder, and `femic compare` of both folders."""
    options = ["--store", str(tmp_path / "store")]
    b_hat_as_c(monkeypatch)
    few = {"bodies": ["lower"], "components": ["nn"], "variants": ["A"]}
    (tmp_path / "home/mine.toml").write_text(tomlkit.dumps(few | with_files()), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert exit_code(["run", "home/mine.toml", "--out", "first", *options]) == 0
    away = tmp_path / "away"
    away.mkdir()
    monkeypatch.chdir(away)
    assert exit_code(["run", str(tmp_path / "first/scene.toml"), "--out", "second", *options]) == 0
    assert exit_code(["compare", str(tmp_path / "first"), "second", "--out", "both"]) == 0
