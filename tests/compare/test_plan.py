"""What a plan says of the seconds of its models."""

import pytest

from compare.plan import Step, seconds
from femic.plan import Planned


def step(engine, takes):
    planned = Planned(unknowns=1000, wavenumbers=20, fields=3, half_section=True, seconds=takes, memory=100.0)
    return Step("a model", engine, 1.0, 100.0, "endless", planned)


@pytest.mark.parametrize(("workers", "expected"), [(1, 3 + 5 + 8 + 4), (2, 3 + 5 + 6), (4, 3 + 5 + 3)])
def test_models_of_the_solid_engine_share_the_workers_those_of_the_harmonic_follow_each_other(
    workers, expected
):
    """A harmonic model uses all workers by itself: its own seconds already count them."""
    steps = [step("harmonic", 3.0), step("solid", 8.0), step("harmonic", 5.0), step("solid", 4.0)]
    assert seconds(steps, workers) == pytest.approx(expected)


def test_no_models_take_no_time():
    assert seconds([], 2) == 0
