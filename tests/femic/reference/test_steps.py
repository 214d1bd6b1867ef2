"""How far is refined, and what is refused: arithmetic on estimates made by hand."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from femic.reference.engine import Cost
from femic.reference.engines import ENGINES, HARMONIC
from femic.reference.job import NotConverged, Settings, Shares
from femic.reference.refinement import Assessment, _steps, next_level, next_levels
from femic.reference.run_options import Level

START = Level()
LARGE = Settings(HARMONIC, most_unknowns=10**9)


@dataclass(frozen=True)
class FakeJob:
    """What a job may take."""

    settings: Settings = LARGE


@dataclass(frozen=True)
class FakeResult:
    """How far a body has been refined, and how large it is."""

    level: Level = START
    models: dict = field(default_factory=lambda: {"fine": Cost(1000, 1, "", (), 0.0, {}, 0.0)})


GOOD = Shares(0.0, 0.0, 0.0, 0.001, "nn", "x")


def parts(mesh=0.0, truncation=0.0, waves=0.0):
    return Shares(mesh, truncation, waves, mesh + truncation + waves, "sn", "y")


def test_half_of_the_tolerance_is_enough_for_a_part():
    assert _steps(0.005, 0.01, 4.0) == 0
    assert _steps(0.0050001, 0.01, 4.0) == 1


@pytest.mark.parametrize("gain", [1.5**3, 4.0, 8.0])
@pytest.mark.parametrize("steps", [1, 2, 3])
def test_as_many_steps_as_bring_a_part_to_half_of_the_tolerance(gain, steps):
    assert _steps(0.005 * gain**steps * 0.999, 0.01, gain) == steps
    assert _steps(0.005 * gain**steps * 1.001, 0.01, gain) == min(steps + 1, 3)


def test_at_most_three_steps_at_once():
    assert _steps(1e9, 0.01, 4.0) == _steps(np.inf, 0.01, 4.0) == 3


@pytest.mark.parametrize(
    ("part", "gain", "name"), [("mesh", 1.5**3, "cells"), ("truncation", 4, "domain"), ("waves", 8, "waves")]
)
def test_each_part_refines_what_causes_it_by_its_own_gain(part, gain, name):
    for steps in (1, 2):
        error = 0.005 * gain**steps
        for factor, expected in ((0.99, steps), (1.01, steps + 1)):
            level = next_level("lower", FakeJob(), FakeResult(), parts(**{part: factor * error}))
            assert level == replace(Level(), **{name: expected})


def test_cells_are_refined_where_only_the_sum_of_the_parts_is_too_large():
    """Three parts of 0.4 of the tolerance each: cells are refined, or refinement would go on for ever."""
    assert next_level("lower", FakeJob(), FakeResult(), parts(0.004, 0.004, 0.004)) == Level(1)


def test_refinement_goes_on_from_where_it_is():
    result = FakeResult(Level(1, -1, 2))
    assert next_level("lower", FakeJob(), result, parts(mesh=0.01)) == Level(2, -1, 2)


def test_of_the_sum_a_body_may_take_its_share():
    assert next_level("lower", FakeJob(), FakeResult(), parts(truncation=0.019), 0.5) == Level(0, 2)
    assert next_level("lower", FakeJob(), FakeResult(), parts(truncation=0.019)) == Level(0, 1)
    both = parts(truncation=0.004, mesh=0.004)
    assert next_level("lower", FakeJob(), FakeResult(), both, 0.5) == Level(1, 1)


@pytest.mark.parametrize(("engine", "growth"), [("solid", 2.7), ("harmonic", 2.0)])
def test_a_model_that_would_be_too_large_is_refused_with_its_size(engine, growth):
    """Two steps of cells: 1.5^(2 growth) times the unknowns."""
    expected = round(1000 * 1.5 ** (2 * growth))
    estimated = parts(mesh=0.03)
    allowed = Settings(ENGINES[engine], most_unknowns=expected)
    assert next_level("lower", FakeJob(allowed), FakeResult(), estimated) == Level(2)
    with pytest.raises(NotConverged, match=f"about {expected:,} unknowns"):
        next_level("lower", FakeJob(replace(allowed, most_unknowns=expected - 1)), FakeResult(), estimated)


@pytest.mark.parametrize(("part", "name"), [("mesh", "cells"), ("truncation", "domain"), ("waves", "waves")])
def test_four_steps_from_the_start_are_the_furthest(part, name):
    estimated = parts(**{part: 0.006})
    near, far = (FakeResult(replace(Level(), **{name: done})) for done in (3, 4))
    assert getattr(next_level("lower", FakeJob(), near, estimated), name) == 4
    with pytest.raises(NotConverged):
        next_level("lower", FakeJob(), far, estimated)


def test_the_refusal_says_what_was_reached():
    result = FakeResult(Level(1, 2))
    estimated = Shares(0.3, 0.2, 0.1, 0.6, "sn", "y")
    says = (
        r"lower body: the estimated error of C_sn on the line y is 60\.00% with 1,000 unknowns, "
        r"cells x 0\.667, domain x 4 \(at worst 30\.00% from the mesh, 20\.00% from the domain, 10\.00% from "
        r"the wavenumbers\); the tolerance 1\.00% .* more than 16 times the first"
    )
    with pytest.raises(NotConverged, match=says):
        next_level("lower", FakeJob(Settings(HARMONIC, most_unknowns=10)), result, estimated)


JOBS = {"lower": FakeJob(), "upper": FakeJob()}
RESULTS = {"lower": FakeResult(), "upper": FakeResult()}


def test_body_within_its_tolerance_is_not_refined():
    just = replace(GOOD, total=0.01)
    assert next_levels(JOBS, RESULTS, Assessment({"lower": just, "upper": GOOD})) == {}
    bad = parts(truncation=0.0101)
    assert next_levels(JOBS, RESULTS, Assessment({"lower": just, "upper": bad})) == {"upper": Level(0, 1)}


def test_what_is_no_number_does_not_meet_it():
    nothing = replace(parts(truncation=0.02), total=np.nan)
    assert set(next_levels(JOBS, RESULTS, Assessment({"lower": nothing, "upper": GOOD}))) == {"lower"}


def test_sum_is_assessed_after_each_body_and_refines_the_worse_one():
    bad, worse = parts(truncation=0.006), parts(truncation=0.007)
    own = {"lower": GOOD, "upper": GOOD}
    together = Assessment(own, parts(truncation=0.013), {"lower": worse, "upper": bad})
    assert next_levels(JOBS, RESULTS, together) == {"lower": Level(0, 1)}
    assert next_levels(JOBS, RESULTS, replace(together, combined=replace(GOOD, total=0.01))) == {}
    short = replace(together, own={"lower": GOOD, "upper": parts(mesh=0.02)})
    assert next_levels(JOBS, RESULTS, short) == {"upper": Level(2)}


def test_each_body_may_take_half_of_the_tolerance_of_the_sum():
    mine = parts(truncation=0.0199)  # a quarter of it is below a quarter of 0.02, a sixteenth below 0.0025
    together = Assessment(
        {"lower": GOOD, "upper": GOOD}, parts(truncation=0.02), {"lower": mine, "upper": GOOD}
    )
    assert next_levels(JOBS, RESULTS, together) == {"lower": Level(0, 2)}
