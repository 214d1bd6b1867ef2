"""Estimates of random contacts hold against elements a quarter as long: `benchmarks/contact_estimates.py`."""

from itertools import islice

import pytest

from benchmarks.contact_estimates import coverage, outcomes

FLAT = ("A",)  # whose products are fast


def described(found):
    return {name: coverage(found, name) for name in found[0].numbers}


@pytest.mark.parametrize(("study", "count"), [("frictionless", 12), ("rolling", 4)])
def test_estimates_of_some_random_contacts_hold_nearly(study, count):
    """Of so few, one in twenty may exceed its estimate, and none by more than a factor of three."""
    found = list(islice(outcomes(study, 101, FLAT), count))
    for name, one in described(found).items():
        assert one.held >= 0.75, name
        assert one.worst < 3, name
    assert all(value > 0 for outcome in found for value in outcome.estimates.values())


@pytest.mark.slow  # a quarter of an hour each
@pytest.mark.parametrize("study", ["frictionless", "rolling"])
def test_estimates_hold_in_95_percent_of_random_contacts(study):
    """And are not silly: half of them are less than 20 times the error, which may be 0 by luck."""
    found = list(islice(outcomes(study, 4), 200))
    for name, one in described(found).items():
        assert one.held >= 0.95, name
        assert not one.median > 20, name
