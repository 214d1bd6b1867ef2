"""Positions as measured on vehicles: given rolls; what is unusual about a position is said."""

import json
from dataclasses import replace

import numpy as np
import pytest

from compare.pages import shifts as page
from femic.results import wheelset as compute
from femic.results import wheelset_contacts as contacts
from femic.shifts.specification import ContactTable, ProfileTable, ShiftsFile, WheelTable, parse_specification
from geometries.errors import WrongInput
from tests.compare.shifts.test_shifts_page import fake

FILE = ShiftsFile(
    shifts=(-2.0, 2.0),
    rail=ProfileTable(profile="60E1"),
    wheel=WheelTable(profile="S1002"),
    contact=ContactTable(ics=("A",)),
)


def computed(file, monkeypatch, solve=fake):
    monkeypatch.setattr(contacts, "contact_at", solve)
    return compute.compute_shifts(file)


def test_given_rolls_are_those_of_the_positions(monkeypatch):
    """Each wheel touches at a height of its own; both shifts are solved, though sides are alike."""
    solved = []

    def counted(where, *rest):
        solved.append((where.position.given_shift, where.side, where.position.roll))
        return fake(where, *rest)

    given = computed(FILE.model_copy(update={"rolls": (1.5, 1.5)}), monkeypatch, counted)
    np.testing.assert_allclose(given["roll"], 1.5)
    assert len({(shift, side) for shift, side, _ in solved}) == 4
    assert {roll for *_, roll in solved} == {0.0015}
    solved.clear()
    mirrored = FILE.model_copy(update={"rolls": (-1.5, 1.5)})
    computed(mirrored, monkeypatch, counted)
    assert len(solved) == 2  # the other two are mirror images


def test_a_roll_for_each_shift_or_none(tmp_path):
    table = {
        "shifts": [0.0, 1.0],
        "rolls": [1.0],
        "rail": {"profile": "60E1"},
        "wheel": {"profile": "S1002"},
    }
    with pytest.raises(WrongInput, match="rolls: 1 of them, and 2 shifts: give one for each shift"):
        parse_specification(table, tmp_path / "mine.toml")
    for roll in (150.0, "much"):
        with pytest.raises(WrongInput, match="rolls"):
            parse_specification(table | {"shifts": [0.0], "rolls": [roll]}, tmp_path / "mine.toml")


def test_what_is_unusual_stands_on_the_page(monkeypatch, tmp_path):
    settle = compute.settle

    def noted(*arguments, **keys):
        return replace(settle(*arguments, **keys), notes=("the left wheel touches 0.4 mm beyond",))

    monkeypatch.setattr(compute, "settle", noted)
    dataset = computed(FILE, monkeypatch)
    assert json.loads(dataset.attrs["unusual"])["2"] == "the left wheel touches 0.4 mm beyond"
    text = page.write_shifts(dataset, tmp_path).read_text()
    assert "Unusual contacts" in text
    assert "2 mm: the left wheel touches 0.4 mm beyond" in text
    assert "finite ones may change p_max by" in text


def test_finite_strain_is_said_of_the_largest_pressure(monkeypatch):
    """1.3 p_max / E of p_max, E the least of all bodies."""
    soft = FILE.model_copy(update={"wheel": WheelTable(profile="S1002", E=100e3)})
    dataset = computed(soft, monkeypatch)
    assert dataset.attrs["E"] == 100e3
    largest = float(dataset.p_max.max())
    strain = 1.3 * largest**2 / 100e3
    assert f"may change p_max by {strain:.0f} MPa where it is largest" in page._load_note(dataset)
