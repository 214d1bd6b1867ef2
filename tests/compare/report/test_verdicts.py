"""Yes, no, or not decided: the definition, and what follows for several numbers."""

from itertools import product

import numpy as np
import pytest

from compare.report.verdicts import NO, NOT_DECIDED, YES, decide, verdict

STEPS = np.arange(-8, 9) / 4  # sums and differences of these are exact


def test_it_is_yes_or_no_where_this_holds_for_all_values_within_the_error():
    """The ends of the interval decide, as whether a value is within a limit is monotonic."""
    for value, error, limit in product(STEPS, STEPS[8:], STEPS):
        within = {possible <= limit for possible in (value - error, value, value + error)}
        expected = NOT_DECIDED if len(within) > 1 else YES if within == {True} else NO
        assert decide(value, error, limit) == expected


@pytest.mark.parametrize("value", [0.0, 1.0, 2.0, 100.0])
def test_an_unknown_error_decides_nothing(value):
    assert decide(value, np.nan, 1.0) == NOT_DECIDED


def test_of_several_one_no_decides_and_yes_needs_all():
    errors, limit = 0.1, 1.0
    for values, expected in (
        ([0.5, 0.6], YES),
        ([0.5, 1.5, np.nan, 1.0], NO),
        ([0.5, 1.05], NOT_DECIDED),
        ([0.5, np.nan], NOT_DECIDED),
        ([np.nan], ""),
        ([], ""),
    ):
        assert verdict(values, errors, limit) == expected
