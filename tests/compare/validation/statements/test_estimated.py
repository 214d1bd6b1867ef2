"""Numbers of statements with their estimated errors, and verdicts on what they leave open."""

import numpy as np
import pytest

from compare.validation.statements.frame import (
    DEPENDS,
    NOT_DECIDED,
    NOT_REPRODUCED,
    REPRODUCED,
    Criterion,
    Estimated,
    Statement,
    estimated_error,
    find_verdict,
    ratio,
)
from compare.validation.statements.page import as_entry
from femic.contact.datasets import OF_UNKNOWN_EDGE
from tests.compare.validation.statements import friction_makers
from tests.compare.validation.statements.friction_makers import CURVE, SLIDING, TRACTION
from tests.compare.validation.statements.mutations import CRITERIA
from tests.compare.validation.statements.normal_makers import EXACT, KNOWN

SMALL = Criterion("small", "", "<", 0.1, dict)
LARGE = Criterion("large", "", ">", 1.0, dict)
BOTH = Statement(0, "", (SMALL, LARGE), lambda _: [])
OPEN_SMALL, OPEN_LARGE = Estimated(0.12, 0.03), Estimated(0.9, 0.2)


@pytest.mark.parametrize(
    ("small", "large", "verdict"),
    [
        ({"a": 0.05}, {"a": 1.5}, REPRODUCED),
        ({"a": 0.15}, {"a": 0.5}, NOT_REPRODUCED),
        ({"a": 0.05, "b": 0.15}, {"a": 1.5}, DEPENDS),
        ({"a": np.nan}, {"a": np.nan}, NOT_REPRODUCED),
        ({"a": 0.05, "b": OPEN_SMALL}, {"a": 2.0}, REPRODUCED),  # what is open does not count,
        ({"a": 0.15, "b": Estimated(0.09, 0.03)}, {"a": 0.5}, NOT_REPRODUCED),  # on either side
        ({"a": 0.05, "b": Estimated(0.12, 0.01)}, {"a": 2.0}, DEPENDS),
        ({"a": OPEN_SMALL}, {"a": 2.0}, NOT_DECIDED),  # nothing is known of one criterion
        ({"a": OPEN_SMALL}, {"a": 2.0, "b": 0.5}, DEPENDS),  # but it depends whatever that is
        ({"a": OPEN_SMALL}, {"a": OPEN_LARGE}, NOT_DECIDED),
        ({"a": 0.05, "b": OPEN_SMALL, "c": OPEN_SMALL}, {"a": 2.0}, NOT_DECIDED),  # nor of most of its cases
    ],
)
def test_a_verdict_follows_from_the_criteria_and_what_numbers_are_known_to(small, large, verdict):
    assert find_verdict(BOTH, {"small": small, "large": large}) == verdict


def test_thresholds_themselves_are_not_met():
    """Nor is what is no number, on either side."""
    for criterion in (SMALL, LARGE):
        assert not criterion.met(criterion.threshold)
        assert not criterion.met(np.nan)
    assert SMALL.met(np.nextafter(0.1, 0))
    assert LARGE.met(np.nextafter(1.0, 2))


@pytest.mark.parametrize(
    ("threshold", "value", "is_close"),
    [
        *((0.0, value, close) for value, close in ((0.0019, True), (0.0021, False))),  # 0.002 of 1
        *((0.5, value, True) for value in (0.4991, 0.5009)),  # 0.002 of the threshold
        *((0.5, value, False) for value in (0.4989, 0.5011)),
        (1e-12, 1e-15, False),
        (0.1, Estimated(0.12, 0.0201), True),  # up to its estimate, which has no sign
        (0.1, Estimated(0.12, 0.0199), False),
        (0.1, Estimated(0.08, -0.0201), True),
        (0.1, Estimated(np.inf, 1.0), False),
        (0.1, Estimated(np.nan, 1.0), False),
    ],
)
def test_a_case_close_to_its_threshold_is_open(threshold, value, is_close):
    assert Criterion("", "", "<", threshold, dict).close(value) is is_close


def test_results_have_the_estimates():
    made = as_entry(BOTH, {"small": {"a": OPEN_SMALL, "b": 0.05}, "large": {"a": 2.0}})
    assert len(made["unmet"]) == 1
    small, large = made["criteria"]
    assert small["values"] == {"a": 0.12, "b": 0.05}
    assert small["estimates"] == {"a": 0.03, "b": 0.0}
    assert small["close"] == {"a": True, "b": False}
    assert large["estimates"] == {"a": 0.0}


def test_a_ratio_is_known_to_the_worst_that_its_parts_can_make_of_it():
    one, other = Estimated(0.3, 0.01), Estimated(-0.1, 0.02)
    known = ratio(one, other)
    assert known == pytest.approx(-3)
    corners = [(0.3 + a) / (-0.1 + b) for a in (-0.01, 0.01) for b in (-0.02, 0.02)]
    assert estimated_error(known) == pytest.approx(max(abs(corner + 3) for corner in corners))
    assert estimated_error(ratio(0.3, 0.1)) == 0.0
    assert estimated_error(ratio(0.3, Estimated(0.1, 0.1))) == np.inf
    assert ratio(0.3, Estimated(0.0, 0.1)) == np.inf
    assert np.isnan(ratio(0.0, Estimated(0.0, 0.1)))


def of_ratio(one, other, estimate):
    """What a ratio of two differences is known to: elements may miss a part of each difference, too."""
    return (one * (1 + OF_UNKNOWN_EDGE) + estimate) / (other * (1 - OF_UNKNOWN_EDGE) - estimate) - one / other


KNOWN_TO = {  # a value, and its estimate by what the made contacts are known to
    (26, "A"): (0.03, KNOWN),
    (27, "tall minus wide"): (0.02, 2 * KNOWN),
    (28, "B, B̂"): (0.08, KNOWN),
    (29, "better"): (0.9, (0.09 + KNOWN) / (0.1 - KNOWN) - 0.9),
    (30, "angles"): (0.05, KNOWN * 1.05),
    (34, "shift"): (0.2, CURVE + OF_UNKNOWN_EDGE * 0.2),
    (34, "close"): (0.07, CURVE),
    (35, "off"): (0.2, 1.1 * TRACTION + OF_UNKNOWN_EDGE * 0.2),
    (37, "B"): (0.8, of_ratio(0.08, 0.1, TRACTION)),
    (37, "sliding"): (0.8, (0.08 + 2 * SLIDING) / (0.1 - 2 * SLIDING) - 0.8),  # the sum of both
    (39, "curve"): (0.7, (0.07 + CURVE) / (0.1 - CURVE) - 0.7),
    (39, "compression"): (0.7, of_ratio(0.07, 0.1, TRACTION)),
    (40, "curve"): (0.7, (0.07 + CURVE) / (0.1 - CURVE) - 0.7),
}


@pytest.mark.parametrize(("number", "name"), KNOWN_TO)
def test_numbers_on_contact_are_known_to_the_estimates_of_their_contacts(number, name):
    value, estimate = KNOWN_TO[number, name]
    _, made = (EXACT | friction_makers.MADE)[number, name]
    values = CRITERIA[number, name].measure(made(value)())
    assert max(map(estimated_error, values.values())) == pytest.approx(estimate, rel=0.05)


FOR_CERTAIN = {  # values that are missed for certain, and values that nobody can tell
    (27, "tall minus wide"): (-0.04, -0.001),
    (29, "better"): (2.0, 1.001),
    (39, "curve"): (2.0, 1.001),
}


@pytest.mark.parametrize(("number", "name"), FOR_CERTAIN)
def test_a_criterion_on_contact_can_be_missed_for_certain(number, name):
    _, made = (EXACT | friction_makers.MADE)[number, name]
    criterion = CRITERIA[number, name]
    for is_open, value in enumerate(FOR_CERTAIN[number, name]):
        values = criterion.measure(made(value)()).values()
        assert not any(map(criterion.met, values))
        assert set(map(criterion.close, values)) == {bool(is_open)}
