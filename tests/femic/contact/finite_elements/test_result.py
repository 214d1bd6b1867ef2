"""The whole way: patch, meshes for it, contact, estimates."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.finite_elements.bodies import Expected
from femic.contact.finite_elements.meshed_contact import Bodies
from femic.contact.finite_elements.result import READING, estimates, fe_contact, hertz_patch
from geometries.errors import Failure, WrongInput
from tests.femic.contact.finite_elements.ellipse import HERTZ, LOAD, bodies


def test_first_guess_is_the_patch_of_hertz():
    guess = hertz_patch(bodies(), LOAD)
    assert [guess.a, guess.b, sum(guess.s)] == pytest.approx([HERTZ.a, HERTZ.b, 0.0], rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("load", [0.0, -1.0, np.inf, np.nan])
def test_a_load_must_be_positive(load):
    with pytest.raises(WrongInput, match="load = "):
        fe_contact(bodies(), load)


@pytest.mark.parametrize("cells", [0.0, 7.9, np.nan])
def test_too_few_cells_are_refused(cells):
    with pytest.raises(WrongInput, match="cells = "):
        fe_contact(bodies(), LOAD, cells=cells)


@pytest.mark.slow
def test_estimates_bound_errors():
    contact = fe_contact(bodies(), LOAD, cells=9.0)
    truth = {"a": HERTZ.a, "b": HERTZ.b, "p_max": HERTZ.p_max}
    for name, value in truth.items():
        error, estimate = abs(vars(contact.numbers)[name] - value), vars(contact.estimate)[name]
        assert error <= estimate
        assert estimate < 0.06 * value
    assert contact.reactions == pytest.approx((LOAD, -LOAD), rel=1e-5)
    assert contact.load_of_pressures == pytest.approx(LOAD, rel=1e-5)
    assert contact.tension <= 1e-5
    assert contact.penetration <= 1e-5
    assert contact.p.max() == contact.numbers.p_max
    assert contact.seconds["fine"] > 0
    assert contact.memory > 0


def test_the_lower_body_must_be_prismatic():
    pair = bodies()
    with pytest.raises(WrongInput, match="prismatic"):
        Bodies(replace(pair.lower, rolling_radius=500.0), pair.upper, pair.s_range)


def made_contact(numbers_are_read):
    """A contact on coarse meshes whose edges can, or cannot, be read from gaps."""

    class Made(SimpleNamespace):
        @property
        def a(self):
            if numbers_are_read:
                return 2.2
            raise Failure("edge of the patch: vertices too few")

    return Made(
        s_range=(-1.1, 1.3),
        patch=Expected(2.6, (-1.2, 1.6)),
        spacing=0.5,
        bodies=bodies(),
        p=np.array([90.0]),
        solution=SimpleNamespace(state=SimpleNamespace(approach=0.1)),
        lateral_force=1.0,
        moment=2.0,
        centre_of_pressure=0.3,
    )


def test_unreadable_edges_on_coarse_meshes_add_half_their_spacing_to_the_estimate():
    fine = made_contact(numbers_are_read=True)
    fine.spacing = 0.2
    read, unread = (estimates(fine, made_contact(numbers_are_read=known)) for known in (True, False))
    assert [read.a, read.b] == pytest.approx([READING * 0.2] * 2)
    assert [unread.a, unread.b] == pytest.approx([0.4 + 0.25, 0.2 + 0.25])
    assert [read.F_y, read.M_x, read.s_centre, read.p_max] == [unread.F_y, unread.M_x, unread.s_centre, 0.0]
