"""The numbers and panels beside the statements on friction, on contacts made by hand."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from compare.report.charts import simple_chart
from compare.validation.statements import components_and_moduli, friction_contacts, rolling_and_compression
from compare.validation.statements.page import STATEMENTS
from compare.validation.statements.rolling_and_compression import LINE_ICS
from femic.contact.pairs.ics import C
from tests.compare.pages import read_chart
from tests.compare.validation.statements import friction_makers as make

LINES = {
    ("F_x = 0 friction load", name): np.array([[2.0, 0.0, 10.0], [2.0 + 0.5 * (name != C), 0.0, 10.0]])
    for name in LINE_ICS
}


@pytest.fixture(scope="module")
def runs():
    """Rolling and compression in which all ICs miss a tenth, and B two tenths of p_x at friction 0.4."""

    @cache
    def made(motion, names):
        if motion == "compression":
            return make.compression(names, p_s=make.of((), 0, 0.1), sliding=make.of((), 0, 0.05))
        sizes = {"zero": make.of((), 0, 0.1), "rms": make.of((), 0, 0.1), "p_max": make.scaled(names, 0.1)}
        return make.rolling(names, **sizes, p_x=lambda f, n: 1 + make.of(("B",), f / 2, 0.1)(f, n))

    def friction(motion, changes, *_):
        return made(motion, tuple(changes["contact"]["ics"]))

    return SimpleNamespace(friction=friction, once=lambda *_: LINES)


@pytest.fixture(scope="module")
def details(runs):
    """The numbers beside a statement, which are measured once, most of them at two frictions."""

    @cache
    def of(number):
        with pytest.MonkeyPatch.context() as patch, make.without_estimates():
            patch.setattr(friction_contacts, "FRICTIONS", friction_contacts.FRICTIONS[:2])
            return STATEMENTS[number].details(runs)

    return of


@pytest.mark.parametrize("number", range(34, 42))
def test_each_statement_has_finite_numbers_beside_it_and_panels_with_a_legend(number, runs, details):
    statement = STATEMENTS[number]
    assert all(np.isfinite(value) for value in details(number).values())
    with make.without_estimates():
        panels = list(statement.panels(runs))
    assert panels
    legend = read_chart(simple_chart("", panels, statement.columns))["legend"]
    assert len({str(dict(entry, label="")) for entry in legend}) == len(legend)


def test_shares_of_p_x_and_of_its_bound(runs):
    """p_x of B is a fifth more than C's; the line at s = 0 has pressures 2.5, and p_x 2.5, friction 0.4."""
    contacts = runs.friction("rolling", {"contact": {"ics": ["B", "C"]}})
    assert friction_contacts.line_distance(contacts, 0.4, "B") == pytest.approx(0.2)
    assert friction_contacts.line_distance_over_bound(contacts, 0.4, "B") == pytest.approx(0.2 / 0.4)
    with make.without_estimates():
        details = rolling_and_compression.shrinking_details(
            SimpleNamespace(friction=lambda *_: make.rolling(rms=make.growing(0.5)))
        )
    assert details["of friction load: B, friction 0.4 over 0.2"] == pytest.approx(0.5)
    assert details["in N: B, friction 0.4 over 0.2"] == pytest.approx(1.0)
    assert details["in N: B, friction 0.6 over 0.4"] == pytest.approx(0.75)


def test_lines_elsewhere_are_measured_like_those_of_the_curve(details):
    own = details(35)
    at = "F_x = 0 friction load, friction 0.2, B"
    assert own[f"over p_x, {at}"] == pytest.approx(0.25 / np.sqrt(2))
    assert own[f"over friction times pressure, {at}"] == pytest.approx(0.5 / np.sqrt(2) / 2.0)
    assert not any(name.endswith(", C") for name in own)


def test_directions_count_alone_or_together():
    """Only p_s is off."""
    contacts = make.compression(p_s=make.of((), 0, 0.1))
    assert friction_contacts.traction_distance(contacts, 0.2, "B") == pytest.approx(0.1)
    assert friction_contacts.traction_distance_along("s")(contacts, 0.2, "B") == pytest.approx(0.1)
    assert friction_contacts.traction_distance_along("x")(contacts, 0.2, "B") == 0.0


def test_a_curve_that_is_only_moved_leaves_nothing():

    def force(f, name, xi):
        return make.SLOPE * (xi - make.ZERO) / (f * make.LOAD) - 0.3 * (name != "C")

    contacts = make.rolling(zero=make.of((), 0, 0.3), force=force)
    assert friction_contacts.shift(contacts, 0.2, "B") == pytest.approx(0.3)
    assert friction_contacts.left_after_shift(contacts, 0.2, "B") == pytest.approx(0.0, abs=1e-9)
    assert friction_contacts.left_after_shift(make.rolling(), 0.2, "B") == 0.0


def test_moduli_keep_the_compliance_of_both():
    for one in components_and_moduli.RATIOS:
        both = components_and_moduli.moduli(one)
        assert both["upper"] / both["lower"] == pytest.approx(one)
        assert 1 / both["upper"] + 1 / both["lower"] == pytest.approx(2 / 210e3)
    convex = components_and_moduli.moduli(components_and_moduli.CONVEX)
    assert convex["lower"] < 210e3  # the convex body is the lower one


def test_estimates_of_distances_stand_beside_those_of_the_mix():
    details = components_and_moduli.mix_details(make.runs()())
    assert details["estimate of curve: friction 0.2, mix"] == pytest.approx(0.02)
    assert details["estimate of pressure: friction 0.2, mix"] == pytest.approx(make.PRESSURE, rel=0.01)
