"""What `femic fe-contact` writes: deviations of ICs from finite elements, and where they become too large."""

import numpy as np
import pytest
import xarray as xr

from compare.pages.contact_numbers import answer_table
from compare.pages.finite_elements import (
    answer_chart,
    approach_note,
    cost,
    details,
    deviations,
    doubts,
    exceeds,
    summary,
    write_fe_contact,
)
from compare.report.verdicts import verdict
from tests.compare.pages import read_chart, read_number, read_texts, read_traces, require_room

ANGLES, LOADS = [20.0, 60.0, 100.0], [1e3, 1e4, 1e5]
OFF = {"A": [0.015, 0.06, 0.2], "C": [0.0, 0.004, -0.004], "FE": [0.0, 0.0, 0.0]}
KNOWN = 0.005


@pytest.fixture(scope="module")
def dataset():
    """ICs that are off by known shares, all numbers alike."""
    off = 1 + np.array([OFF[name] for name in OFF]).T
    dims = ("case", "ics")
    numbers = dict.fromkeys(("a", "b", "p_max", "approach"), (dims, 10 * off))
    sideways = np.outer(LOADS, [-0.6, -0.2, -0.25])
    numbers |= {"F_y": (dims, sideways), "M_x": (dims, 9 * sideways)}
    numbers["s_centre"] = (dims, [[-2.0, -0.8, -0.9]] * 3)
    estimates = {f"estimate_{name}": (dims, np.full((3, 3), 10 * KNOWN)) for name in (*numbers, "angle")}
    angle = {"angle": (dims, np.array(ANGLES)[:, None] * np.ones(3))}
    checks = {
        "load": ("case", LOADS),
        "rigid_compliance": ((), 1e-7),
        "seconds": (dims, np.full((3, 3), 0.1)),
        "fe_load_of_pressures": ("case", [1e3, 1.002e4, 1e5]),
        "fe_reaction": (("case", "body"), np.outer(LOADS, [1, -1])),
        "fe_seconds": (("case", "stage"), np.ones((3, 2))),
        "fe_unknowns": (("case", "body"), np.full((3, 2), 1000)),
        "fe_memory": ("case", [1e3] * 3),
        "fe_tension": ("case", [0.0] * 3),
        "fe_penetration": ("case", [1e-6] * 3),
    }
    s = np.linspace(-2, 2, 9)
    lines = {
        "p": (
            ("case", "ics", "s"),
            [[[0.0, 1, 2, 3, 4, 3, 2, 1, 0, np.nan]] * 2 + [[np.nan] * 10]] * 3,
        ),
        "p_fe": (("case", "s_fe"), [[4.0, 3, 2, 1, 0]] * 3),
    }
    places = {"s": (("case", "s"), [[*s, np.nan]] * 3), "s_fe": (("case", "s_fe"), [s[4:]] * 3)}
    return xr.Dataset(
        numbers | estimates | angle | checks | lines,
        coords={"ics": list(OFF), "case": ("case", LOADS, {"units": "N"}), **places},
        attrs={"title": "a title", "scene": "a scene", "left_out": "", "ics_tolerance": 0.02},
    )


@pytest.fixture(scope="module")
def path(dataset, tmp_path_factory):
    """The page of the dataset."""
    return write_fe_contact(dataset, tmp_path_factory.mktemp("fe"))


def test_deviations_are_ratios_to_finite_elements_minus_1(dataset):
    for name in ("p_max", "b", "approach"):
        np.testing.assert_allclose(deviations(dataset, name).sel(ics="A"), OFF["A"], rtol=1e-9)
    assert "FE" not in deviations(dataset, "b").ics


def test_only_deviations_beyond_the_estimate_exceed_a_share(dataset):
    for share, beyond in ((0.0099, 3), (0.0101, 2), (0.05, 2), (0.056, 1)):
        assert list(exceeds(dataset, "A", share).values) == [False] * (3 - beyond) + [True] * beyond
    assert not exceeds(dataset, "C", 0.0).any()


def test_summary_states_pressure_by_finite_elements_and_deviations(dataset):
    assert summary(dataset) == (
        "p_max by finite elements (FE) at 100 kN: 10.000 ± 0.050 MPa. "
        "Largest differences of p_max from finite elements (± is the estimated error of FE): "
        "A +20.00 ± 0.50 %; C +0.4 ± 0.5 %."
    )


def test_details_state_deviations_and_their_onset(dataset):
    note, table = details(dataset)
    rows = read_texts(table)
    assert "That error is at most 0.5%." in note
    assert rows["A"] == ["+20.0%"] * 4 + ["above a limit between 20 and 60 degrees"] * 3
    assert rows["C"] == ["+0.4%"] * 4 + ["nowhere"] * 3


def test_vanishing_numbers_are_compared_in_their_unit_and_shown_as_0_if_symmetric(dataset, path, tmp_path):
    """At the least load M_x of C is -1800 N mm, and -2250 by finite elements."""
    page = path.read_text(encoding="utf-8")
    for text in ("−1800.000 ± 0.050<br><small>+450</small>", "−0.800 ± 0.050<br><small>+0.1</small>"):
        assert text in page
    symmetric = dataset.assign({name: 1e-9 * dataset[name] for name in ("F_y", "M_x", "s_centre")})
    page = write_fe_contact(symmetric, tmp_path).read_text(encoding="utf-8")
    assert '<th class="name" scope="row">s_c [mm]</th><td>0</td><td>0</td><td>0</td>' in page


def test_the_answer_has_loads_as_rows_and_deviations_beside(dataset):
    table = answer_table(dataset, "FE", ["A", "C"])
    assert [head.title for head in table.heads][2:] == ["A within 2 %?", "C within 2 %?"]
    for k, row in enumerate(table.rows):
        for cell, name in zip(row.filled[2:], ("A", "C"), strict=True):
            off, known = read_number(cell.below)
            assert off == pytest.approx(100 * OFF[name][k], abs=known / 2)
            assert cell.text == verdict(abs(100 * OFF[name][k]), known, 2.0)
    assert {row.filled[1].text for row in table.rows} == {"10.000 ± 0.050"}


def drawn(dataset, cell, step=0):
    cells = read_chart(answer_chart(dataset))["steps"][step]
    return read_traces(cells[cell])


def test_charts_have_pressures_at_the_nodes_of_finite_elements_and_deviations_over_the_angle(dataset):
    above, below = drawn(dataset, 0), drawn(dataset, 3)
    assert above["FE"]["y"] == [4.0, 3.0, 2.0, 1.0, 0.0]
    assert above["FE"]["mode"] == "markers"
    shifted = dataset.assign(p=dataset.p + 0.5)
    assert below["A"]["y"] == [0.0] * 5
    assert drawn(shifted, 3)["A"]["y"] == [0.5] * 5
    assert "FE" not in below
    for name in ("A", "C"):
        np.testing.assert_allclose(drawn(dataset, 4)[name]["y"], 100 * np.array(OFF[name]), atol=1e-5)
        np.testing.assert_allclose(drawn(dataset, 4)[name]["x"], ANGLES)


def test_page_has_figures_the_balance_of_forces_and_which_compliance_approaches_contain(dataset, path):
    page = path.read_text(encoding="utf-8")
    assert page.count('id="chart-') == 2  # pressures of each load, further numbers
    for text in ("+20.00%", "exclude the rigid part M_zz", "M_zz = 1e-07 mm/N"):
        assert text in page
    assert xr.open_dataset(path.with_suffix(".nc")).attrs["title"] == "a title"
    assert "include the compliance of the whole bodies" in approach_note(dataset.assign(rigid_compliance=0.0))
    assert "Pressures and reactions carry the load to 0.002" in cost(dataset)


def test_load_without_solution_by_finite_elements_is_reported_and_drawn_without_it(dataset, tmp_path):
    some = dataset.assign(p_fe=dataset.p_fe.where(dataset.case != LOADS[2]))
    unsolved = (dataset.ics == "FE") & (dataset.case == LOADS[2])
    for name in ("a", "b", "p_max", "approach", "angle"):
        some[name] = dataset[name].where(~unsolved)
    for name in ("fe_unknowns", "fe_seconds", "fe_reaction", "fe_load_of_pressures"):
        some[name] = dataset[name].where(dataset.case != LOADS[2])
    assert "Finite elements: 2,000 unknowns in the modelled part of the bodies, 2 s per load" in cost(some)
    assert "carry the load to 0.002" in cost(some)
    unsolved = some.assign_attrs(left_out="100000 N: too much")
    assert doubts(unsolved) == ["Finite elements found no solution for 100000 N: too much"]
    assert doubts(some) == []
    assert "at 10 kN: 10.000 ± 0.050 MPa" in summary(unsolved)
    _, table = details(some)
    assert read_texts(table)["A"][0] == "+6.0%"
    assert answer_chart(some).first == 1
    assert drawn(some, 1)["A"]["x"] == ANGLES[:2]
    page = write_fe_contact(some.assign_attrs(left_out="100000 N: too much"), tmp_path)
    assert page.read_text(encoding="utf-8").count('id="chart-') == 2


@pytest.mark.slow
def test_nothing_is_wider_than_the_window(path, browser):
    require_room(browser, path)
