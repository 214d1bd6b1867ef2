"""`femic profiles`: the list, pages of files, what is refused, and what is written back."""

import re

import numpy as np
import pytest
import xarray as xr

from femic.cli.main import DONE, WRONG_INPUT, exit_code
from geometries.profiles.files import read_profile
from geometries.profiles.standards import STANDARDS
from tests.samples import ERROR, write_head


@pytest.fixture
def head(tmp_path, monkeypatch):
    """A folder with a file of an arc of 30 mm, its crown at (2, 1), with errors of alternating sign."""
    monkeypatch.chdir(tmp_path)
    write_head(tmp_path / "mine.txt")
    return tmp_path


def test_list_has_every_standard_with_its_kind(capsys):
    assert exit_code(["profiles"]) == DONE
    text = capsys.readouterr().out
    for name, entry in STANDARDS.items():
        assert re.search(rf"^{name} +{entry.kind} ", text, re.MULTILINE)


def test_page_of_a_file_says_how_it_was_understood(head, capsys):
    arguments = ["profiles", "mine.txt", "--kind", "rail", "--axes", "field", "--tolerance", "0.02"]
    assert exit_code(arguments) == DONE
    said = capsys.readouterr().out
    for part in (
        "1 unit of the file is 1 mm",
        "y grows to the field side, as given",
        "z points up, as its head",
    ):
        assert part in said
    text = (head / "out/profiles/mine/profile.html").read_text(encoding="utf-8")
    assert "Rail mine: how it was understood" in text
    assert said.splitlines()[0] in text
    with xr.open_dataset(head / "out/profiles/mine/profile.nc") as dataset:
        np.testing.assert_allclose(dataset.point_y[0], 2 + (30 + ERROR) * np.sin(-1.4), atol=1e-9)
        rms = float(np.sqrt(np.mean(dataset.residual**2)))
        assert rms == pytest.approx(ERROR, rel=1e-3)
        assert dataset.curvature.sel(s=40, method="nearest") == pytest.approx(1 / 30, rel=0.02)
    assert "profiles/mine" in (head / "out/index.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("head")
def test_profile_is_written_back_as_read_or_smoothed():
    given = ["profiles", "mine.txt", "--kind", "rail", "--axes", "field"]
    assert exit_code([*given, "--write", "as_read.prr"]) == DONE
    points = read_profile("mine.txt", "rail", axes="field").points
    np.testing.assert_allclose(read_profile("as_read.prr").points, points, atol=1e-12)
    assert exit_code([*given, "--tolerance", "0.02", "--write", "smooth.prr"]) == DONE
    y, z = read_profile("smooth.prr").points
    np.testing.assert_allclose(np.hypot(y - 2, z + 29), 30, atol=2e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["60E1", "61E1"], r"no such file and no standard profile; did you mean 60E1"),
        (["mine.txt"], r"mine\.txt: kind: .*give --kind 'rail'"),
        (["mine.txt", "--kind", "rail"], r"mine\.txt: axes: .*give --axes 'field'"),
        (["mine.txt", "--kind", "rail", "--axes", "left"], r"--axes 'left'"),
        (["bad.txt", "--kind", "rail"], r"bad\.txt, line 2: "),
        (["S1002", "--axes", "up"], r"S1002: a standard profile: leave out"),
        (["S1002", "S1002"], r"two have the same name"),
        (["S1002", "--write", "a.prr"], r"--write a\.prr: .*must end in \.prw"),
        (["S1002", "60E1", "--write", "a.prw"], r"--write a\.prw: 2 profiles; give one"),
    ],
)
def test_what_is_missing_or_wrong_is_refused_before_anything_is_written(arguments, message, head, capsys):
    (head / "bad.txt").write_text("0 1\n1 x\n", encoding="utf-8")
    assert exit_code(["profiles", *arguments]) == WRONG_INPUT
    assert re.search(message, capsys.readouterr().err)
    assert not (head / "out").exists()
