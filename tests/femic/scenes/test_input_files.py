"""Files that scene files name: found from anywhere, and what is written of a scene can be run anywhere."""

import tomllib
from copy import deepcopy
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


@pytest.mark.parametrize("kind", [kind for kind, table in CONTOURS.items() if "file" in table.model_fields])
def test_all_declared_keys_are_found_from_the_whole_scene(kind):
    """Contours of all kinds, outlines, the extra gap and maps of C; other ICs and other texts stay."""

    def table(contour, outline, gap, c_map):
        body = {"contour": {"kind": kind, "file": contour}, "outline": {"file": outline}}
        contact = {"extra_gap": gap, "ics": ["C", f"map:{c_map}", "Bhat"]}
        return {"title": "t", "lower": body, "upper": deepcopy(body), "contact": contact}

    found = table(*"cogm")
    replace_files(found, SceneFile, str.upper)
    assert found == table(*"COGM")


@pytest.mark.parametrize("value", [3, None, ["a", 3], {"file": {"x": 1}}, "text"])
def test_what_is_of_another_type_stays(value):
    table = {"lower": value, "contact": {"extra_gap": 5, "ics": 7}, "patch": value}
    before = str(table)
    make_files_absolute(table, SceneFile)
    assert str(table) == before


@pytest.mark.parametrize("written", [listing, lambda path: load_scene(path).text])
def test_the_text_and_the_listing_of_a_scene_can_be_run_from_another_folder(
    written, folder, tmp_path, monkeypatch
):
    text = written(str(folder / "mine.toml"))
    assert COMMENT in load_scene(folder / "mine.toml").text
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


def test_outlines_and_maps_are_found_from_another_folder(tmp_path, monkeypatch):
    """A rail's own section, given as a file."""
    corners = RAIL_SECTIONS["60E1"].outline.corners
    np.savetxt(tmp_path / "section.txt", corners.T)
    outline, contact = {"file": "section.txt", "clamped": [1, 2]}, {"ics": ["Bhat", "map:sweeps/c.toml"]}
    for table, kind in ((outline, OutlineTable), (contact, ContactTable)):
        make_files_absolute(table, kind, tmp_path)
    monkeypatch.chdir("/")
    found = OutlineTable.model_validate(outline, strict=False).outline(PlaneTable(kind="plane"))
    np.testing.assert_allclose(found.corners, corners)
    assert contact["ics"] == ["Bhat", f"map:{tmp_path / 'sweeps/c.toml'}"]


def test_what_run_writes_can_be_run_again_from_another_folder(folder, tmp_path, monkeypatch):
    b_hat_as_c(monkeypatch)
    monkeypatch.setattr("compare.pages.ics_results.write_page", lambda *_: tmp_path / "report.html")
    monkeypatch.setattr("compare.pages.ics_results.pictures", lambda *_: ())
    few = {"bodies": ["lower"], "components": ["nn"], "variants": ["A"]}
    (folder / "mine.toml").write_text(tomlkit.dumps(few | with_files()), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert exit_code(["run", "home/mine.toml", "--out", "first"]) == 0
    text = (tmp_path / "first/scene.toml").read_text(encoding="utf-8")
    assert_same(from_elsewhere(text, tmp_path, monkeypatch), load_scene(folder / "mine.toml"))
