"""What the decision page says of crossings, and that its numbers are crossings of the errors beside them."""

import copy
import json
from pathlib import Path

import decision_page
import numpy as np
import pytest
import write_docs

NUMBERS = json.loads((Path(__file__).parents[1] / "docs/numbers/decisions.json").read_text(encoding="utf-8"))
WANTED = decision_page.Wanted("p_max to 5 %", "p_max", 0.05)


def deviation(angle, error=0.05):
    return {"load": 1e4, "angle": angle, "angle_estimate": 1.0, "error": error, "estimate": 0.001}


def pair(short, angle=None, end=90.0, **facts):
    """A pair whose error passes 5 % at an angle, or nowhere up to its end."""
    found = {
        "at": None if angle is None else deviation(angle),
        "estimate": None if angle is None else 2.2,
        "before": False,
        "stays": True,
        "largest": deviation(end, 0.03),
        "end": deviation(end, 0.03),
    }
    return {"short": short, "crossings": {"A": {"p_max": {"0.05": found | facts}}}}


@pytest.mark.parametrize(
    ("of", "ics", "text"),
    [
        ((("middle", 60.0), ("worst", 41.0), ("best", 75.0)), "A", "41 ± 3° … 75 ± 3°"),
        ((("first", 50.0), ("other", 60.0), ("none", None, 90.0)), "A", "50 ± 3° … > 90°"),
        ((("first", 50.0), ("other", 60.0), ("none", None, 30.0)), "A", "50 ± 3° … 60 ± 3°"),
        ((("x",), ("y", None, 80.0)), "A", "met up to 90°"),
        ((("x",),), "mix", ""),
    ],
)
def test_the_reach_is_that_of_the_worst_and_of_the_best_pair(of, ics, text):
    """A pair that never fails is the best where it goes further; those not solved are left out."""
    assert decision_page.reach([pair(*each) for each in of], ics, WANTED) == text.replace(" ", "\u00a0")


def test_crossings_say_if_they_were_before_and_if_the_error_comes_back():
    of = pair("x", 40.0)["crossings"]["A"]["p_max"]["0.05"]
    assert decision_page.crossing_text(of) == "40\u00a0±\u00a03"
    assert decision_page.crossing_text(of | {"stays": False}) == "40\u00a0±\u00a03 †"
    assert decision_page.crossing_text(of | {"before": True}) == "<\u00a040"
    assert decision_page.crossing_text(of | {"at": None}) == "–"


def solved_numbers():
    """Errors and crossings of all pairs, and of rolling by friction."""
    rolling = [of for pair in NUMBERS["rolling"].values() for of in pair["frictions"].values()]
    for solved in (*NUMBERS["pairs"].values(), *rolling):
        for ics, numbers in solved["crossings"].items():
            for number, by_tolerance in numbers.items():
                for tolerance, found in by_tolerance.items():
                    yield (
                        solved["loads"],
                        np.abs(solved["errors"][ics][number])[:, 0],
                        float(tolerance),
                        found,
                    )


def test_each_crossing_of_the_page_is_between_errors_within_and_beyond_its_tolerance():
    for loads, errors, tolerance, found in solved_numbers():
        if found["at"] is None:
            assert np.all(errors <= tolerance)
        elif not found["before"]:
            beyond = errors >= 0.999 * tolerance
            number = int(np.argmax(beyond))
            assert beyond[number]
            assert loads[number - 1] <= found["at"]["load"] <= loads[number]
            # loads are solved for to 8 % with friction, and edges move by elements
            assert abs(found["at"]["error"]) == pytest.approx(tolerance, rel=0.15)


def test_errors_of_the_readme_are_those_of_the_page_and_forces_are_shares_of_friction_times_load():
    rows = [row.split(" | ") for row in decision_page.readme_table(NUMBERS).splitlines()[2:]]
    at = decision_page.nearest(NUMBERS, "rolling 0.4", "angles", 180.0)["errors"]["A"]
    half, free = (row for row in rows if row[0].startswith("| F_x, `rolling`, "))
    assert half[2] == f"{100 * at['half']['error']:+.1f} %".replace("-", "−")
    assert free[2] == f"{100 * at['free']['error']:+.1f} %".replace("-", "−")
    largest = decision_page.nearest(NUMBERS, "tall", "loads", 310e3)["errors"]["Bhat"]["p_max"]["error"]
    assert any(row[3] == f"{100 * largest:+.1f} %" for row in rows)


def test_the_figure_marks_each_crossing_of_five_percent():
    panels = [axes for part in decision_page.draw(NUMBERS).subfigs for axes in part.axes]
    assert len(panels) == 4
    (shown,) = (axes for axes in panels if axes.get_title() == "p_max with A, without friction")
    marks = sum(len(line.get_xdata()) for line in shown.lines if line.get_linestyle() == "None")
    of_pairs = [of["crossings"]["A"]["p_max"]["0.05"] for of in NUMBERS["pairs"].values()]
    assert marks == sum(bool(of["at"]) and not of["before"] for of in of_pairs)


@pytest.fixture
def two_rolling_pairs():
    """The stored numbers with a second pair that rolls with friction 0.4 alone: half the errors of forces."""
    of = copy.deepcopy(NUMBERS["rolling"]["rolling"]["frictions"]["0.4"])
    for numbers in of["errors"].values():
        numbers["half"] = [[error / 2, estimate] for error, estimate in numbers["half"]]
    second = {"title": "Another pair", "short": "another", "frictions": {"0.4": of}}
    return NUMBERS | {"rolling": {"rolling": NUMBERS["rolling"]["rolling"], "another": second}}


def test_rows_of_forces_name_their_pair_and_its_own_errors(two_rolling_pairs):
    template = write_docs.environment().get_template("evidence/limits.md.j2")
    text = template.render(**write_docs.stored_numbers() | {"decisions": two_rolling_pairs})
    rows = [line for line in text.splitlines() if line.startswith(("| another, ", "| `rolling`, "))]
    assert sum(row.startswith("| another, ") for row in rows) == 3  # tables
    assert sum(row.startswith("| `rolling`, ") for row in rows) == 3 * 3
    pairs = [f"{name} 0.4" for name in ("rolling", "another")]
    solved = [decision_page.nearest(two_rolling_pairs, pair, "angles", 180.0)["errors"] for pair in pairs]
    rolling, another = (errors["A"]["half"]["error"] for errors in solved)
    assert another == pytest.approx(rolling / 2)
    (row,) = (row for row in rows if row.startswith("| another, ") and "°, 0.4 |" in row)
    assert row.split(" | ")[1] == f"{100 * another:+.1f}".replace("-", "−")  # % of friction times load
    assert "cover 2 wheels on one rail" in text


def test_the_reach_of_forces_is_over_all_pairs_that_roll(two_rolling_pairs):
    """A second pair whose error passes 5 % at 12 degrees is the worst."""
    of = two_rolling_pairs["rolling"]["another"]["frictions"]["0.4"]["crossings"]["A"]["free"]["0.05"]
    of |= {"at": deviation(12.0), "estimate": 0.9, "before": False, "stays": True}
    rows = decision_page.decision_rows(two_rolling_pairs)
    row = next(row for row in rows if "free rolling" in row["wanted"])
    assert row["A"].startswith("12\u00a0±\u00a01°")
