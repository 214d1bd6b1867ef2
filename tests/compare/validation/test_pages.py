"""Pages of `femic validate` and `femic extremes`: the answer on top, numbers and charts of the results."""

from dataclasses import replace

import numpy as np
import pytest

from compare.report.charts import Chart, Panel, make_curves
from compare.report.parts import Folded, write_page
from compare.validation.extremes import page as extremes
from compare.validation.extremes.cases import BeyondLimit, Limit, WithinLimit, run_limits
from compare.validation.statements import page as validation
from compare.validation.statements.frame import Criterion, Statement
from femic.reference.run_options import DEFAULT
from geometries.errors import Failure
from tests.compare.pages import read_chart
from tests.pages import widest

X = np.linspace(0.0, 2.5, 7)
BY_RUNS = {"versions": {"femic": "0"}}


def nothing(_):
    return {}


# --- statements -----------------------------------------------------------------------------------------

NEAR = Criterion("near", "error of B̂′_xn", "<", 0.1, nothing)
LARGE = Criterion("large", "rms of C_nn", ">", 1.0, nothing)
VALUES = {
    "near": {"geometry1, lower": 0.05, "geometry1, upper": 0.13, "geometry2, lower": np.nan}
    | {"geometry2, upper": 0.1001, "plane": 0.7},
    "large": {"both": 1.5},
}
PANEL = Panel("geometry1: nn", "s / L  [-]", "IC · E · L  [-]", make_curves(X, {"C": X**2, "A": X}, 0.1 * X))
CLOSE = Statement(1, "B̂′_xn is close to C_xn.", (NEAR, LARGE), nothing)
ENTRIES = [
    validation.as_entry(CLOSE, VALUES, {"C": 2.0}),
    validation.as_entry(
        Statement(2, "A_xx is C_xx.", (NEAR,), nothing), {}, failed="not converged, and what to try"
    ),
    validation.as_entry(Statement(14, "Both engines agree.", (LARGE,), nothing), {"large": {"both": 7.0}}),
]
PANELS = {1: [PANEL], 2: [], 14: []}


@pytest.fixture(scope="module")
def statements():
    content = {"statements": ENTRIES, "runs": {}, "changes": [], "tolerance": 1e-3, "seconds": 1.0}
    return listed(validation.make_page(PANELS, content | BY_RUNS))


def listed(page):
    """A page whose sections can be read twice."""
    return replace(page, sections=list(page.sections))


def section(page, anchor):
    """The blocks of the section of a statement."""
    return next(one.blocks for one in page.sections if getattr(one, "anchor", "") == anchor)


def blocks_of(sections, kind):
    """All blocks of a kind, also within others."""
    for one in sections:
        if isinstance(one, kind):
            yield one
        yield from blocks_of(getattr(one, "blocks", ()), kind)


def texts_of(row):
    return [cell.text for cell in row.filled]


def drawn(chart):
    """The curves of a chart on the page: label, x and y, in the order of drawing."""
    cells = read_chart(chart)["steps"][0]
    return [(one["name"], one["x"], one["y"]) for cell in cells for one in cell["traces"] if "name" in one]


def test_the_page_of_statements_counts_verdicts_and_lists_statements_by_them(statements):
    assert statements.summary == (
        "Statements from the source [BVSV] (2): 1 in some cases only, 1 not decided. "
        "Statements on this program (1): 1 reproduced in every case. "
        "Numbers that meet their criteria: 3 of 7; not decided: 1."
    )
    assert {row.name: texts_of(row) for row in statements.answer.rows} == {
        "reproduced": ["none", "1: 14"],
        "depends": ["1: 1", "none"],
        "not reproduced": ["none", "none"],
        "not decided": ["1: 2", "none"],
    }
    assert section(statements, "s2") == ["A_xx is C_xx.", "not converged, and what to try"]


def test_criteria_have_their_ranges_what_is_not_met_worst_first_and_the_curves_of_their_panels(statements):
    _, table, chart, numbers = section(statements, "s1")
    assert {row.name: texts_of(row) for row in table.rows} == {
        "error of B̂′_xn": [
            "< 0.1",
            "1 of 5",
            "0.05 ... 0.7",
            "geometry2, lower: –; plane: 0.7; geometry1, upper: 0.13; 1 more",
        ],
        "rms of C_nn": ["> 1", "1 of 1", "1.5", ""],
    }
    assert isinstance(numbers, Folded)
    rows = [texts_of(row) for row in numbers.blocks[0].rows]
    assert rows[3] == ["geometry2, upper", "0.1001", "", "< 0.1", "no (not decided)"]
    assert rows[-1][:2] == ["C", "2"]
    for curve, label, values in zip(drawn(chart), "CA", (X**2, X), strict=True):
        assert curve[0] == label
        np.testing.assert_allclose(curve[1:], [X, values], rtol=1e-5)


# --- extremes -------------------------------------------------------------------------------------------


def known(result):
    """A case that is not run."""
    return lambda _: result


def failing(_):
    raise Failure("not converged")


def limit(part, name, reached, beyond=()):
    return Limit(part, name, "0 … 1", [known(case) for case in reached], [known(case) for case in beyond])


BOTH = [
    limit(
        "analytic",
        "ν",
        [WithinLimit("2 corners", 6e-16, None, None, "300 digits", 0.01)],
        [BeyondLimit("ν = 0.51", "must lie in 0 ... 0.5")],
    ),
    limit(
        "harmonic",
        "ν",
        [
            WithinLimit("ν = 0", 2e-4, 4e-4, 0.5, "A", 2.0),
            WithinLimit("ν = 0.4999", 1e-4, 9e-4, 1.25, "A", 3.0),
        ],
    ),
    Limit(
        "solid",
        "R_roll [mm]",
        "50 … ∞",
        [known(WithinLimit("50 mm", 0.03, 0.08, 0.75, "a finer C", 4.0)), failing],
        [known(BeyondLimit("49 mm", "")), known(BeyondLimit("48 mm", "not converged", failed=True))],
    ),
]


def page_of(limits):
    content = extremes.as_content(list(run_limits(limits, DEFAULT)))
    return listed(extremes.make_page(content | BY_RUNS))


@pytest.fixture(scope="module")
def limits():
    return page_of(BOTH)


def test_the_page_of_extremes_counts_cases_and_has_the_worst_of_each_part(limits):
    assert limits.summary == (
        "5 cases within the limits, 1 failed; estimates bound every error in 2 of the 3 cases that have "
        "them. 3 cases beyond the limits: 1 refused with a message, 0 computed all the same, 1 without a "
        "message, 1 failed."
    )
    assert {row.name: texts_of(row) for row in limits.answer.rows} == {
        "analytic": ["–", "6e-16", "–", "–"],
        "harmonic": ["0.01", "0.0002", "0.0009", "1.25"],
        "solid": ["0.1", "0.03", "0.08", "0.75"],
    }
    assert [bool(row.filled[-1].colour) for row in limits.answer.rows] == [False, True, False]


def test_errors_are_drawn_over_their_estimates(limits):
    (chart,) = blocks_of(limits.sections, Chart)
    assert drawn(chart) == [("ν", [0.5, 1.25], [2e-4, 1e-4]), ("R_roll [mm]", [0.75], [0.03])]
    assert chart.cells[0].marks == (1.0,)
    assert not list(blocks_of(page_of(BOTH[:1]).sections, Chart))  # of analytic ICs alone


def test_contacts_have_a_panel_of_their_own_and_are_named_with_their_parameter():
    """Filled for contact without friction, open for that with friction."""
    contacts = [
        limit(part, "R_roll", [WithinLimit("20 mm", 0.01, 0.02, used, "Hertz", 0.5, "p_max 9; worst: p_max")])
        for part, used in (("contact", 0.5), ("friction", 1.75))
    ]
    page = page_of([*BOTH[:2], *contacts])
    (chart,) = blocks_of(page.sections, Chart)
    of_c, of_contacts = chart.cells
    assert [curve.label for curve in of_c.curves] == ["ν"]
    assert [list(curve.x) for curve in of_contacts.curves] == [[0.5], [1.75]]
    assert [curve.look.marker.endswith("-open") for curve in of_contacts.curves] == [False, True]
    assert of_contacts.title.startswith("filled: contact, open: friction")
    assert [row.name for row in page.answer.rows] == ["analytic", "harmonic", "contact", "friction"]


def test_cases_beyond_that_are_not_refused_are_coloured(limits):
    (blocks,) = (one.blocks for one in limits.sections if getattr(one, "heading", "") == "Beyond the limits")
    messages = [row.filled[-1] for row in blocks[0].rows]
    assert [cell.text for cell in messages] == ["must lie in 0 ... 0.5", "nothing", "failed: not converged"]
    assert [bool(cell.colour) for cell in messages] == [False, True, True]


# --- in a browser ---------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("made", ["statements", "limits"])
def test_pages_fit_and_run_without_errors(made, request, browser, tmp_path):
    path = write_page(request.getfixturevalue(made), tmp_path / f"{made}.html")
    tab, said = browser.new_page(), []
    tab.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.goto(path.as_uri())
    tab.wait_for_selector(".chart .main-svg")
    tab.close()
    assert not said
    assert max(widest(browser, path, 1280)) <= 1280
    assert max(widest(browser, path, 800)) <= 800
    assert widest(browser, path, 400)[0] <= 400
