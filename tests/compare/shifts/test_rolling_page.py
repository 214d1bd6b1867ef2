"""Rolling wheelsets in the results and on the page of `femic shifts`: labels, mirrored shifts, sentences."""

import json

import numpy as np
import pytest

from compare.pages import shift_figures as figures
from compare.pages import shifts as page
from compare.pages.shift_figures import F_X, F_Y, WORK, difference, reference_names
from femic.cache.store import Store
from femic.reference.run_options import RunOptions, Watch
from femic.results import wheelset as compute
from femic.results import wheelset as rolling
from femic.results import wheelset_contacts as contacts
from femic.shifts.axle import OF_PATCH, OF_WHEEL, OF_WHEELSET, WheelNumbers
from femic.shifts.position import concat_ics, label_wheelset
from femic.shifts.specification import ContactTable, ProfileTable, RollingTable, ShiftsFile, WheelTable
from tests.compare.pages import read_chart, read_texts, read_traces, require_room
from tests.compare.shifts.test_shifts_page import fake

SHIFTS = (-2.0, 0.0, 1.0, 2.0)
FILE = ShiftsFile(
    shifts=SHIFTS,
    conicity_amplitude=0.5,
    rail=ProfileTable(profile="60E1"),
    wheel=WheelTable(profile="cone-1-20"),
    right_wheel=WheelTable(profile="cone-1-20", nu=0.3),
    contact=ContactTable(ics=("A", "Bhat")),
    rolling=RollingTable(friction=0.4, by_angle=((20.0, 1.0), (40.0, 0.3))),
)
UNIT = 0.4 * 9e4


def wheel(shift, side, ics):
    """Numbers of a wheel: A is off by 3 % of friction times load of F_x at 2 mm, left, and less elsewhere."""
    sign = 1 if side == "left" else -1
    off = 0.03 * (shift == 2.0 and side == "left") if ics == "A" else 0.0
    numbers = dict.fromkeys(OF_WHEEL, 1.0) | {
        "F_x": sign * 5000 * shift + off * UNIT,
        "F_y": 3000 - 100.0 * sign * shift,
        "work": 10.0 * (1 + off),
        "resistance": 7.0,
    }
    patch = dict.fromkeys(OF_PATCH, 1.0) | {"F_n": 9e4, "centre": 70.0}
    patches = (patch, patch) if shift == 2.0 else (patch,)
    return WheelNumbers(numbers, dict.fromkeys(("F_x", "F_y", "M_z", "work"), 50.0), patches)


def fake_roll(sides, load, table, ics, _):
    assert load == 9e4
    assert table.friction == 0.4
    shift = sides[0].place.position.given_shift
    if shift == 1.0:
        return label_wheelset("A", {}, reasons={"left": "not today", "right": "not today"})
    solved = []
    for name in [*ics, *(["C"] if any(side.with_c for side in sides) else [])]:
        wheels = {
            side.place.side: wheel(shift, side.place.side, name)
            for side in sides
            if name != "C" or side.with_c
        }
        numbers = dict.fromkeys(OF_WHEELSET, 1.0) | {"steering": 1e6 * shift, "xi_0": -1e-4 * shift**2}
        solved.append(label_wheelset(name, wheels, (numbers, {"xi_0": 1e-6})))
    return concat_ics(solved)


@pytest.fixture
def fakes(monkeypatch):
    monkeypatch.setattr(contacts, "contact_at", fake)
    monkeypatch.setattr(rolling, "roll", fake_roll)


@pytest.fixture
def dataset(fakes):  # noqa: ARG001 (its effect)
    return compute.compute_shifts(FILE, "text of the file")


def test_numbers_are_labelled_and_c_is_that_of_its_own_wheel(dataset):
    assert dataset.F_x.dims == ("shift", "side", "ics")
    assert dataset.xi_0.dims == ("shift", "ics")
    assert dataset.F_x.sel(shift=-2.0, side="right", ics="Bhat").item() == 10_000
    assert dataset.estimate_F_x.sel(shift=-2.0, side="right", ics="A").item() == 50
    assert np.isnan(dataset.estimate_xi.sel(shift=-2.0, side="right", ics="A"))
    with_c = dataset.sel(ics="C", shift=2.0)  # of the left wheel alone
    assert np.isfinite(with_c.F_x.sel(side="left"))
    assert np.isnan(with_c.F_x.sel(side="right"))
    assert reference_names(dataset, "F_x").sel(shift=2.0, side="right").item() == "Bhat"


def test_differences_of_forces_are_shares_of_friction_times_load(dataset):
    assert difference(dataset, "A", F_X).sel(shift=2.0, side="left").item() == pytest.approx(0.03)
    assert difference(dataset, "A", F_Y).sel(shift=2.0, side="left").item() == pytest.approx(0)
    assert difference(dataset, "A", WORK).sel(shift=2.0, side="left").item() == pytest.approx(0.03)


def test_the_answer_table_has_a_row_per_quantity(dataset):
    rows = read_texts(page.answer_table(dataset))
    assert rows["A: F_x [kN]"] == [
        "-2 to 0 mm",
        "all shifts",
        "all shifts",
        "11.08",
        "10.00",
        "+3.00",
    ]
    assert {"A: p_max [MPa]", "A: F_y [kN]", "A: work of friction [J/m]", "B̂: F_x [kN]"} <= set(rows)


def test_the_charts_have_forces_in_kilonewtons(dataset):
    content = read_chart(figures.forces(dataset))
    assert len(content["steps"]) == 3
    traces = read_traces(content["steps"][0][0])
    np.testing.assert_allclose(
        np.array(traces["A"]["y"], float), dataset.F_x.sel(side="left", ics="A") / 1000, rtol=1e-5
    )
    own = read_chart(figures.rolling(dataset))["steps"][0]
    traces = read_traces(own[1])
    np.testing.assert_allclose(np.array(traces["A"]["y"], float), [-2, 0, np.nan, 2], rtol=1e-5)


def test_the_page_says_how_it_rolls_and_what_does_not(dataset, tmp_path):
    text = page.write_shifts(dataset, tmp_path).read_text()
    assert "coefficient of friction 0.4 times a factor by the contact angle, 1 at 20 degrees, 0.3 at" in text
    assert "1, left, rolling" in text
    assert "A: not today" in text
    assert "36 kN" in text


def test_alike_sides_roll_once_and_the_mirrored_wheelset_steers_to_the_other_side(fakes, monkeypatch):  # noqa: ARG001
    positions = []

    def counted(sides, *rest):
        positions.append(sides[0].place.position.given_shift)
        return fake_roll(sides, *rest)

    monkeypatch.setattr(rolling, "roll", counted)
    alike = FILE.model_copy(update={"right_wheel": None, "shifts": (-2.0, 0.0, 2.0)})
    dataset = compute.compute_shifts(alike)
    assert positions == [-2.0, 0.0]
    for name, sign in (("F_x", 1), ("F_y", 1), ("estimate_F_x", 1)):
        here, there = (dataset[name].sel(shift=shift, ics="Bhat") for shift in (2.0, -2.0))
        np.testing.assert_array_equal(here.values, sign * there.values[::-1])
    for name, sign in (("steering", -1), ("xi_0", 1), ("estimate_xi_0", 1)):
        values = dataset[name].sel(ics="Bhat")
        assert values.sel(shift=2.0).item() == sign * values.sel(shift=-2.0).item(), name
    positions.clear()
    moved = alike.model_copy(update={"rolling": RollingTable(friction=0.4, lateral=0.001)})
    compute.compute_shifts(moved)
    assert positions == [-2.0, 0.0, 2.0]


def test_finished_positions_are_kept(fakes, tmp_path, monkeypatch):  # noqa: ARG001
    positions = []

    def interrupted(sides, *rest):
        positions.append(sides[0].place.position.given_shift)
        if len(positions) == 2:
            raise KeyboardInterrupt
        return fake_roll(sides, *rest)

    monkeypatch.setattr(rolling, "roll", interrupted)
    said = []
    options = RunOptions(1, Store(tmp_path), Watch(on_stage=said.append))
    with pytest.raises(KeyboardInterrupt):
        compute.compute_shifts(FILE, "", options)
    result = compute.compute_shifts(FILE, "", options)
    assert positions == [-2.0, 0.0, 0.0, 1.0, 2.0]
    assert any("rolling: stored by an earlier run" in text for text in said)
    assert json.loads(result.attrs["not_rolling"]) == {
        "1, left, rolling": "A: not today",
        "1, right, rolling": "A: not today",
    }
    other = FILE.model_copy(update={"rolling": RollingTable(friction=0.4, lateral=0.001)})
    compute.compute_shifts(other, "", options)
    assert len(positions) == 9


@pytest.mark.slow
def test_nothing_is_wider_than_the_window(browser, dataset, tmp_path):
    require_room(browser, page.write_shifts(dataset, tmp_path), {1280: np.inf, 800: 800, 400: 800})
