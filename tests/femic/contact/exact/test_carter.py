"""Carter by integration of his tractions, and by a solution that finds the stick zone itself."""

import numpy as np
import pytest
from scipy.integrate import quad

from femic.contact.exact.friction import TractiveRolling
from femic.contact.exact.hertz import LineContact
from geometries.errors import WrongInput

LINE, LOAD, FRICTION = LineContact(0.004, 115e3), 900.0, 0.35
A = LINE.half_width(LOAD)


def rolling(share):
    """At a share of the creepage of full sliding."""
    return TractiveRolling(LINE, LOAD, FRICTION, share * FRICTION * LINE.curvature * A)


each_share = pytest.mark.parametrize("share", [0.05, -0.4, 0.9, 1.0, 1.7])


@each_share
def test_the_tractions_carry_the_force(share):
    contact = rolling(share)

    def carried(angle):
        return contact.traction(A * np.sin(angle)) * A * np.cos(angle)

    joint = np.arcsin(contact.stick_start / A)
    total = sum(quad(carried, *ends)[0] for ends in ((-np.pi / 2, joint), (joint, np.pi / 2)))
    assert total == pytest.approx(contact.force, rel=1e-7)
    assert np.sign(total) == np.sign(share)
    assert not contact.traction(1.01 * A)


def slope(traction, edges, at):
    """Slope du/dx at `at` [mm]: -2 / (pi E*) times the integral of traction / (x - t).

    Piecewise constant tractions between edges have logarithms as integrals.
    """
    middles = (edges[1:] + edges[:-1]) / 2
    logs = np.log(np.abs((at[:, None] - edges[:-1]) / (at[:, None] - edges[1:])))
    return -2 / (np.pi * LINE.modulus) * logs @ traction(middles)


@each_share
def test_the_slip_is_that_of_the_tractions(share):
    """Zero where the contact sticks, against the traction elsewhere: -xi - du/dx."""
    contact = rolling(share)
    edges = -A * np.cos(np.linspace(0, np.pi, 4001))
    at = (edges[200:-200:97] + edges[201:-199:97]) / 2
    slip = -contact.creepage - slope(contact.traction, edges, at)
    np.testing.assert_allclose(contact.slip(at), slip, atol=2e-3 * contact.largest_creepage)
    sticks = at > contact.stick_start
    assert not np.any(contact.slip(at)[sticks])
    assert np.all(np.sign(contact.slip(at)[~sticks]) == -np.sign(share))
    p = LINE.pressure(LOAD, at)
    q = contact.traction(at)
    np.testing.assert_allclose(np.abs(q[~sticks]), FRICTION * p[~sticks], rtol=1e-12)
    assert np.all(np.abs(q[sticks]) < FRICTION * p[sticks])


@pytest.mark.parametrize("share", [0.3, 0.8])
def test_numerical_solution_of_the_stick_zone_agrees(share):
    """Elements leave the stick zone where the traction exceeds the bound; slip at their leading edges."""
    contact, n = rolling(share), 200
    edges = np.linspace(-A, A, n + 1)
    middles = (edges[1:] + edges[:-1]) / 2
    to_middles = middles[:, None] - edges
    # u(x_I + h) - u(x_I), ahead minus own place: integrals of -2 / (pi E*) ln|x - t| over the elements
    ahead = to_middles + 2 * A / n
    primitive, moved = (d * np.log(np.abs(d)) for d in (to_middles, ahead))
    change = -2 / (np.pi * LINE.modulus) * (np.diff(primitive, axis=1) - np.diff(moved, axis=1))
    bound = FRICTION * LINE.pressure(LOAD, middles)
    sticks = np.ones(n, dtype=bool)
    for _ in range(n):
        q = np.where(sticks, 0.0, bound)
        right = -contact.creepage * 2 * A / n - change @ q
        q[sticks] = np.linalg.solve(change[np.ix_(sticks, sticks)], right[sticks])
        if not np.any(q > bound * (1 + 1e-12)):
            break
        sticks &= q <= bound * (1 + 1e-12)
    assert np.sum(q) * 2 * A / n == pytest.approx(contact.force, rel=0.01)
    assert middles[sticks][0] == pytest.approx(contact.stick_start, abs=4 * A / n)
    assert np.max(np.abs(q - contact.traction(middles))) < 0.03 * np.max(bound)


def test_small_creepage_agrees_with_the_linear_law():
    """Force = pi E* a xi / 2: traction C sqrt((a - x) / (a + x)) has the slope -2 C / E* everywhere."""
    contact = rolling(1e-7)
    assert contact.force == pytest.approx(np.pi * LINE.modulus * A * contact.creepage / 2, rel=1e-6)


def test_outside_the_contact_nothing_slips():
    assert np.all(np.isnan(rolling(0.5).slip([-1.1 * A, 1.1 * A])))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"load": 0.0}, r"load = 0\.0: must be positive"),
        ({"friction": -0.1}, r"friction = -0\.1: must be positive"),
        ({"creepage": np.nan}, r"creepage = nan: must be finite"),
    ],
)
def test_input_out_of_range_is_refused(changes, message):
    arguments = {"surfaces": LINE, "load": LOAD, "friction": FRICTION, "creepage": 1e-3} | changes
    with pytest.raises(WrongInput, match=message):
        TractiveRolling(**arguments)
