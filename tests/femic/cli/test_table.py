"""The command `table`: its files and page, the plan, Dask, what is refused."""

import re
import tomllib
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import femic
from femic.cli.main import DONE, FAILED, WRONG_INPUT, exit_code
from femic.results import tables
from femic.scenes.load import scene_from_table
from femic.tables import refinement
from tests.compare.campaigns.campaigns import in_this_process

SCENE = """
title = "A wheel on a rail"
[lower]
E = 210e3
nu = 0.3
contour = { kind = "arc", radius = 300.0, flank_inclination_deg = 30.0 }
[upper]
E = 210e3
nu = 0.3
contour = { kind = "arc", radius = 330.0, flank_inclination_deg = 25.0 }
rolling_radius = 460.0
[contact]
flanks = false
[table]
shifts = [0.0, 0.5]
loads = [40e3]
spin = 0.0
tolerance = 0.1
elements = 8
"""


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    """A function that makes a table which few contacts judge: the exit code, what was printed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(refinement, "HELD_OUT", 3)

    def table(text, *options):
        Path("mine.toml").write_text(text, encoding="utf-8")
        code = exit_code(["table", "mine.toml", *options])
        printed = capsys.readouterr()
        return code, " ".join((printed.out + printed.err).split())

    return table


def test_a_table_is_one_command_and_dask_gives_the_same(command, monkeypatch):
    code, printed = command(SCENE, "--workers", "1")
    assert code == DONE
    assert re.search(
        r"95 % of other contacts differ by at most \d+\.\d % of friction times normal force", printed
    )
    folder = Path("out/mine")
    files = {"table.nc", "table.txt", "table.html", "creep_table.py", "creep_table.h", "store"}
    assert {path.name for path in folder.iterdir() if path.name[0] != "."} == files
    page = (folder / "table.html").read_text()
    assert "Table of creep forces: A wheel on a rail" in page
    assert "Contacts are solved with B̂. How much contacts with C differ is in no number here" in page
    assert "does not use" not in page
    at = 0.25, 40e3, 0.3, 1e-3, 2e-4, 0.0
    expected = femic.read_table(folder / "table.nc").forces(*at)
    assert expected["F_x"] > 0 > expected["F_y"]

    @contextmanager
    def existing(_):
        with in_this_process() as client:
            yield client

    monkeypatch.setattr("compare.campaigns.cluster.require_scheduler", lambda _: None)
    monkeypatch.setattr("compare.campaigns.cluster.existing_cluster", existing)
    code, _ = command(SCENE, "--scheduler", "tcp://127.0.0.1:8786", "--out", "dask")
    assert code == DONE
    one, other = (xr.load_dataset(Path(name) / "table.nc") for name in ("out/mine", "dask"))
    for name in one.data_vars:
        np.testing.assert_array_equal(one[name], other[name], name)


def test_the_plan_solves_nothing(command, monkeypatch):
    monkeypatch.setattr("femic.results.tables.compute_table", None)
    code, printed = command(SCENE, "--plan")
    assert code == DONE
    at_zero, beside = 5 * 7 + 1, 8 * 7 + 1
    contacts = at_zero + beside + 3 * refinement.IN_HELD_OUT
    assert f"A wheel on a rail: {contacts} contacts at {2 + 3} positions" in printed
    assert not Path("out").exists()


def test_keys_of_contact_that_a_table_does_not_use_are_named():
    def unused(contact):
        return tables.unused_keys(
            scene_from_table(tomllib.loads(SCENE.replace("[contact]", contact)), "mine")
        )

    assert unused("[contact]") == []
    assert unused("[grid]\nn_x = 8\nn_s = 8\n[contact]\ngrid = 'scene'\napproaches = [0.01]") == [
        "contact.grid",
        "contact.approaches",
    ]


def test_without_a_mirror_the_plan_has_all_creepages(command):
    """Bodies that are their mirror images need half of the creepages where they are not shifted."""
    lopsided = SCENE.replace("flank_inclination_deg = 30.0", "flank_inclination_deg = [28.0, 30.0]")
    assert lopsided != SCENE
    _, printed = command(lopsided, "--plan")
    assert f"{2 * (8 * 7 + 1) + 3 * refinement.IN_HELD_OUT} contacts at {2 + 3} positions" in printed


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (SCENE.replace("loads = [40e3]", ""), (), "table.loads: give loads in N, or contact.loads"),
        (SCENE.replace("rolling_radius = 460.0", ""), (), "upper.rolling_radius = inf"),
        (SCENE.replace("[0.0, 0.5]", "[0.5, 0.0]"), (), "table.shifts = [0.5, 0.0]: 0 comes after 0.5"),
        (SCENE + 'ics = "Bhat_prime"\n', (), "Bhat_prime needs effective properties"),
        (SCENE + 'ics = "map:c.nc"\n', (), "table.ics: map:c.nc: a map of C has one grid"),
        (SCENE, ("--workers", "1", "--scheduler", "tcp://a:1"), "leave out --workers or --scheduler"),
    ],
)
def test_what_cannot_be_made_is_refused_before_any_work(command, text, options, message):
    code, printed = command(text, *options)
    assert (code, message in printed) == (WRONG_INPUT, True), printed
    assert not Path("out").exists()


def test_a_table_that_does_not_reach_its_tolerance_fails_with_numbers(command, monkeypatch):
    monkeypatch.setattr(refinement, "MOST_ROUNDS", 1)
    code, printed = command(SCENE.replace("0.1\n", "0.005\n"), "--workers", "1")
    assert code == FAILED
    assert re.search(r"of 95 % of other contacts is within 0\.\d+, not the tolerance of 0\.005", printed), (
        printed
    )
    assert not Path("out/mine/table.txt").exists()
