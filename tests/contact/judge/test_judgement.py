"""The whole way: patch, meshes for it, contact, estimates."""

from dataclasses import replace

import numpy as np
import pytest

from contact.judge.judgement import hertz_patch, judge
from contact.judge.levels import Bodies
from geometries.errors import WrongInput
from tests.contact.judge.ellipse import HERTZ, LOAD, bodies


def test_the_first_guess_is_hertz_s_patch():
    guess = hertz_patch(bodies(), LOAD)
    assert [guess.a, guess.b, sum(guess.s)] == pytest.approx([HERTZ.a, HERTZ.b, 0.0], rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("load", [0.0, -1.0, np.inf, np.nan])
def test_a_load_must_be_positive(load):
    with pytest.raises(WrongInput, match="load = "):
        judge(bodies(), load)


@pytest.mark.parametrize("cells", [0.0, 7.9, np.nan])
def test_cells_must_be_enough(cells):
    with pytest.raises(WrongInput, match="cells = "):
        judge(bodies(), LOAD, cells=cells)


@pytest.mark.slow
def test_estimates_bound_errors():
    judged = judge(bodies(), LOAD, cells=9.0)
    truth = {"a": HERTZ.a, "b": HERTZ.b, "p_max": HERTZ.p_max}
    for name, value in truth.items():
        error, estimate = abs(vars(judged.numbers)[name] - value), vars(judged.estimate)[name]
        assert error <= estimate
        assert estimate < 0.06 * value
    assert judged.reactions == pytest.approx((LOAD, -LOAD), rel=1e-5)
    assert judged.load_of_pressures == pytest.approx(LOAD, rel=1e-5)
    assert judged.tension <= 1e-5
    assert judged.penetration <= 1e-5
    assert judged.p.max() == judged.numbers.p_max
    assert judged.seconds["fine"] > 0
    assert judged.memory > 0


def test_the_lower_body_must_be_prismatic():
    pair = bodies()
    with pytest.raises(WrongInput, match="prismatic"):
        Bodies(replace(pair.lower, rolling_radius=500.0), pair.upper, pair.s_range)
