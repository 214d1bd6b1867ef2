"""`femic profiles`: the list, pages of files, what is refused, and what is written back."""

import re

import numpy as np
import pytest
import xarray as xr

from femic.cli.main import DONE, WRONG_INPUT, exit_code
from geometries.profiles.files import read_profile, write_profile
from geometries.profiles.standards import NAMED, standard_profile
from tests.samples import ERROR, write_head

GIVEN = ["--kind", "rail", "--axes", "field"]


@pytest.fixture
def head(tmp_path, monkeypatch):
    """A folder with a file of an arc of 30 mm, its crown at (2, 1), with errors of alternating sign."""
    monkeypatch.chdir(tmp_path)
    write_head(tmp_path / "mine.txt")
    return tmp_path


def write_list(folder):
    """Write a list of the sections 60E1 at 0 and 54E1 at 5."""
    for name, standard in (("a.prr", "60E1"), ("b.prr", "54E1")):
        write_profile(standard_profile(standard, 1.0), folder / name)
    text = "0 1\n2\n0 0 0\n1\n0 'a.prr'\n5 'b.prr'\n"
    (folder / "list.slcs").write_text(text, encoding="utf-8")


def test_list_has_every_profile_of_the_package_with_its_kind(capsys):
    assert exit_code(["profiles"]) == DONE
    text = capsys.readouterr().out
    for name, entry in NAMED.items():
        assert re.search(rf"^{name} +{entry.kind} ", text, re.MULTILINE)


def test_page_of_a_file_says_how_it_was_understood(head, capsys):
    assert exit_code(["profiles", "mine.txt", *GIVEN, "--tolerance", "0.02"]) == DONE
    said = capsys.readouterr().out
    assert "1 unit of the file is 1 mm" in said
    assert "y points to the field side, as given" in said
    assert "z points up, as its head" in said
    text = (head / "out/profiles/mine/profile.html").read_text(encoding="utf-8")
    assert "Rail mine as femic reads it" in text
    assert said.splitlines()[0] in text
    with xr.open_dataset(head / "out/profiles/mine/profile.nc") as dataset:
        np.testing.assert_allclose(dataset.point_y[0], 2 + (30 + ERROR) * np.sin(-1.4), atol=1e-9)
        assert float(np.sqrt(np.mean(dataset.residual**2))) == pytest.approx(ERROR, rel=1e-3)
        assert dataset.curvature.sel(s=40, method="nearest") == pytest.approx(1 / 30, rel=0.02)
    assert "profiles/mine" in (head / "out/index.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("head")
def test_profile_is_written_back_as_read_or_smoothed():
    assert exit_code(["profiles", "mine.txt", *GIVEN, "--write", "as_read.prr"]) == DONE
    points = read_profile("mine.txt", "rail", axes="field").points
    np.testing.assert_allclose(read_profile("as_read.prr").points, points, atol=1e-12)
    smoothed = ["--tolerance", "0.02", "--write", "smooth.prr"]
    assert exit_code(["profiles", "mine.txt", *GIVEN, *smoothed]) == DONE
    y, z = read_profile("smooth.prr").points
    np.testing.assert_allclose(np.hypot(y - 2, z + 29), 30, atol=2e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            "60E1 61E1",
            r"no such file and no built-in profile; did you mean 60E1.*\? The package has S1002, 60E1",
        ),
        ("nothere.ban", r"no built-in profile\. The package has S1002"),
        ("mine.txt", r"mine\.txt: kind: .*give --kind 'rail'"),
        ("mine.txt --kind rail", r"mine\.txt: axes: .*give --axes 'field'"),
        ("mine.txt --kind rail --axes left", r"--axes 'left'"),
        ("bad.txt --kind rail", r"bad\.txt, line 2: "),
        ("S1002 --axes up", r"S1002: a built-in profile; leave out"),
        ("S1002 S1002", r"S1002: given twice"),
        ("mine.txt mine.txt --kind rail --axes field", r"mine\.txt: given twice"),
        ("mine.txt --kind rail --section 1", r"section and section_at are of lists"),
        ("list.slcs", r"list\.slcs: .*give section or section_at; .* has 1: at 0, a\.prr; 2: at 5, b\.prr"),
        ("list.slcs --section 3", r"--section 3: must be 1 \.\.\. 2"),
        ("list.slcs --section-at 2", r"--section-at 2: lies between sections"),
        ("list.slcs --section 1 --kind wheel", r"--kind 'wheel': it is a list of rails"),
        ("S1002 --write a.prr", r"--write a\.prr: .*must end in \.prw"),
        ("S1002 60E1 --write a.prw", r"--write a\.prw: 2 profiles given; give one"),
        *(
            (
                f"mine.txt --kind rail --axes field --write {name}",
                f"--write {name}: cannot be written: name a file",
            )
            for name in ("nowhere/x.prr", "folder.prr")
        ),
    ],
)
def test_what_is_missing_or_wrong_is_refused_before_anything_is_written(arguments, message, head, capsys):
    (head / "bad.txt").write_text("0 1\n1 x\n", encoding="utf-8")
    (head / "folder.prr").mkdir()
    write_list(head)
    assert exit_code(["profiles", *arguments.split()]) == WRONG_INPUT
    assert re.search(message, capsys.readouterr().err)
    assert not (head / "out").exists()


def files_of_pages(folder):
    """The files of all pages, by the names of their folders."""
    result = {}
    for path in folder.glob("out/profiles/*/profile.nc"):
        with xr.open_dataset(path) as dataset:
            result[path.parent.name] = dataset.attrs["file"]
    return result


def test_no_page_is_written_over_that_of_another_file(head):
    """A folder has the name of the file, else its ending, too, else its folders; files stay in theirs."""
    for folder in ("one", "two"):
        (head / folder).mkdir()
        write_head(head / folder / "mine.txt")
    (head / "mine.dat").write_bytes((head / "mine.txt").read_bytes())
    assert exit_code(["profiles", "mine.txt", "mine.dat", *GIVEN]) == DONE
    assert exit_code(["profiles", "one/mine.txt", "two/mine.txt", *GIVEN]) == DONE
    expected = {
        "mine": str(head / "mine.txt"),
        "mine-dat": str(head / "mine.dat"),
        "mine-txt": str(head / "one/mine.txt"),
        "two-mine-txt": str(head / "two/mine.txt"),
    }
    assert files_of_pages(head) == expected
    assert exit_code(["profiles", "two/mine.txt", "mine.txt", *GIVEN]) == DONE
    assert files_of_pages(head) == expected


def test_page_of_a_worn_profile_says_where_it_comes_from(head, capsys):
    assert exit_code(["profiles", "S1002-worn"]) == DONE
    assert "worn from S1002 by the law in docs/theory/wheel-on-rail.md" in capsys.readouterr().out
    assert files_of_pages(head) == {"S1002-worn": "S1002-worn"}


def test_page_of_a_section_has_its_number(head):
    write_list(head)
    for number, position, width in ((1, 0, 72.0), (2, 5, 70.0)):  # widths of the heads near 60E1 and 54E1
        assert exit_code(["profiles", "list.slcs", "--section-at", f"{position}"]) == DONE
        with xr.open_dataset(head / f"out/profiles/list-{number}/profile.nc") as dataset:
            assert float(np.ptp(dataset.y.values)) == pytest.approx(width, abs=2.5)
            assert dataset.attrs["notes"].startswith(f"Section {number} of 2 of list.slcs, at {position}.")
