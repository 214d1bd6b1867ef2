"""Rolling wheelsets in the results and on the page of `femic shifts`: labels, mirrored shifts, sentences."""

import numpy as np
import pytest

from compare.pages import shift_figures as figures
from compare.pages import shifts as page
from compare.pages.shift_figures import F_X, F_Y, WORK, difference, reference_names
from tests.compare.pages import read_chart, read_texts, read_traces, require_room
from tests.femic.shifts.fakes import ROLLING, known_dataset


@pytest.fixture(scope="module")
def dataset():
    return known_dataset(ROLLING)


@pytest.fixture(scope="module")
def shown(dataset):
    """The dataset as the page has it: differences and their estimates are found once."""
    return figures.with_differences(dataset)


def test_differences_of_forces_are_shares_of_friction_times_load(dataset):
    for quantity, share in ((F_X, 0.03), (F_Y, 0.0), (WORK, 0.03)):
        found = difference(dataset, "A", quantity).sel(shift=2.0, side="left").item()
        assert found == pytest.approx(share)
    assert reference_names(dataset, "F_x").sel(shift=2.0, side="right").item() == "Bhat"


def test_the_answer_table_has_a_row_per_quantity(shown):
    rows = read_texts(page.answer_table(shown))
    limits = ["yes: −2 to 0 mm", "yes: −2 to 0 mm and 2 mm", "yes: −2 to 0 mm and 2 mm"]
    assert rows["A: F_x"] == [*limits, "+3.00 ± 0.29 % of friction × load"]  # 50 N of 36 kN, and 3 % / 20
    assert {"A: p_max", "A: F_y", "A: work of friction", "B̂, against C: F_x"} <= set(rows)


def test_the_charts_have_forces_in_kilonewtons(shown):
    content = read_chart(figures.forces(shown))
    assert len(content["steps"]) == 3
    traces = read_traces(content["steps"][0][0])
    np.testing.assert_allclose(
        np.array(traces["A"]["y"], float), shown.F_x.sel(side="left", ics="A") / 1000, rtol=1e-5
    )
    own = read_chart(figures.rolling(shown))["steps"][0]
    traces = read_traces(own[1])
    np.testing.assert_allclose(np.array(traces["A"]["y"], float), [-2, 0, np.nan, 2], rtol=1e-5)


def test_the_page_says_how_it_rolls_and_what_does_not(dataset, tmp_path):
    text = page.write_shifts(dataset, tmp_path).read_text()
    assert "coefficient of friction of 0.4 times a factor that depends on the contact angle: " in text
    assert "1 at 20 degrees, 0.3 at" in text
    assert "Not solved with friction at 1 mm (left wheel): A: not today." in text
    assert "36 kN" in text


@pytest.mark.slow
def test_nothing_is_wider_than_the_window(browser, dataset, tmp_path):
    require_room(browser, page.write_shifts(dataset, tmp_path), {1280: np.inf, 800: np.inf, 400: np.inf})
