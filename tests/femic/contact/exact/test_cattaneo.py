"""Cattaneo and Mindlin: displacements by half-space ICs, and the limits of one form in the other."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.contact.exact.friction import ShiftedPoint
from femic.contact.exact.hertz import PointContact, combined_modulus
from geometries.errors import WrongInput
from geometries.materials import Material, both_bodies
from geometries.patches import Patch, S, X

NU, FRICTION = 0.3, 0.4
STEEL = Material(210e3, NU)
MODULUS = combined_modulus(STEEL, STEEL)
NORMAL = PointContact(0.02, 0.05, MODULUS).at_load(2000.0)  # longer along x


def shifted(share=0.6, direction=X, nu=NU, normal=NORMAL):
    return ShiftedPoint(normal, nu, FRICTION, share * FRICTION * normal.load, direction)


def displacements(contact, at, n=240):
    """Displacements [mm] along x and s at points (points, 2) due to the tractions, on n x n elements."""
    a, b = contact.normal.a, contact.normal.b
    middles = (np.arange(n) + 0.5) / n * 2 - 1
    x, s = (grid.ravel() for grid in np.meshgrid(a * middles, b * middles, indexing="ij"))
    q = contact.traction(x, s)
    loaded = np.flatnonzero(q)
    space, patch = HalfSpace(both_bodies(STEEL, STEEL)), Patch(a / n, b / n)
    return np.array(
        [
            space.ics(patch, point[0] - x[loaded], point[1] - s[loaded])[:2, contact.direction] @ q[loaded]
            for point in at
        ]
    )


@pytest.mark.parametrize("direction", [X, S])
@pytest.mark.parametrize("share", [0.6, -0.2])
def test_the_tractions_shift_all_that_sticks(direction, share):
    """Along the force by the shift, across the force not at all; beyond the ellipse by less."""
    contact = shifted(share, direction)
    inside = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, -0.5], [0.6, 0.6], [-0.3, 0.8]])
    at = inside * contact.stick_ratio * [NORMAL.a, NORMAL.b]
    u = displacements(contact, at)
    np.testing.assert_allclose(u[:, direction], contact.shift, rtol=1e-3)
    np.testing.assert_allclose(u[:, 1 - direction], 0, atol=1e-3 * abs(contact.shift))
    beyond = np.array([[0.98 * NORMAL.a, 0.0], [0.0, 0.98 * NORMAL.b]])
    assert np.all(displacements(contact, beyond)[:, direction] / contact.shift < 0.96)


@pytest.mark.parametrize("share", [0.6, -0.2])
def test_the_tractions_carry_the_force_within_friction(share):
    contact = shifted(share)
    t = (np.arange(2000) + 0.5) / 2000
    q = contact.traction(t * NORMAL.a, 0.0)
    carried = 2 * np.pi * NORMAL.a * NORMAL.b * np.mean(t * q)  # constant on similar ellipses
    assert carried == pytest.approx(contact.force, rel=1e-4)
    p = FRICTION * NORMAL.pressure(t * NORMAL.a, 0.0)
    slips = t > contact.stick_ratio
    np.testing.assert_allclose(np.abs(q[slips]), p[slips], rtol=1e-12)
    assert np.all(np.abs(q[~slips]) < p[~slips])


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("direction", [X, S])
def test_circle_agrees_with_mindlin(nu, direction):
    normal = PointContact(0.02, 0.02, MODULUS).at_load(2000.0)
    contact = shifted(0.6, direction, nu, normal)
    G = (1 - nu) * MODULUS
    lost = 1 - 0.4 ** (2 / 3)
    expected = 3 * FRICTION * 2000.0 * (2 - nu) / (8 * G * normal.a) * lost
    assert contact.shift == pytest.approx(expected, rel=1e-12)


def test_stiffness_is_the_derivative_of_force_by_shift():
    near = [shifted(0.6 * factor).shift for factor in (1 - 1e-5, 1 + 1e-5)]
    step = 2e-5 * shifted(0.6).force
    assert shifted(0.6).stiffness == pytest.approx(step / (near[1] - near[0]), rel=1e-8)
    # a circle that is shifted as a whole: F = 8 G a / (2 - nu) u on one body, half of it for both
    round_one = PointContact(0.02, 0.02, MODULUS).at_load(2000.0)
    expected = 4 * shifted(0.0).G * round_one.a / (2 - NU)
    assert shifted(1e-9, normal=round_one).stiffness == pytest.approx(expected, rel=1e-6)


def test_exchanged_axes_exchange_the_directions():
    other = PointContact(0.05, 0.02, MODULUS).at_load(2000.0)
    assert shifted(0.6, X).shift == pytest.approx(shifted(0.6, S, normal=other).shift, rel=1e-12)
    assert shifted(0.6, X).shift != pytest.approx(shifted(0.6, S).shift, rel=0.01)


@pytest.mark.parametrize("direction", [X, S])
def test_a_slender_ellipse_sticks_and_yields_as_a_line_in_its_middle(direction):
    """Between two lengths the shift grows by the logarithm of their ratio, as that of line loads does.

    The line load in the middle of the ellipse is that of the line, and its compliance 2 / (pi G) ln(length),
    times 1 - nu across the line.
    """
    shifts, lengths = [], []
    for slender in (1e-7, 1e-9):
        normal = PointContact(slender, 0.05, MODULUS).at_load(2000.0)
        line_load = 3 * normal.load / (4 * normal.a)
        shifts.append(shifted(0.6, direction, normal=normal).shift / line_load)
        lengths.append(normal.a / normal.b)
    factor = (1 - NU) if direction == S else 1.0
    lost = FRICTION * (1 - 0.4 ** (2 / 3))
    expected = 2 * factor / (np.pi * shifted().G) * np.log(lengths[1] / lengths[0]) * lost
    assert shifts[1] - shifts[0] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"nu": 0.6}, r"nu = 0\.6: must lie in 0 \.\.\. 0\.5"),
        ({"friction": 0.0}, r"friction = 0\.0: must be positive"),
        ({"force": -800.0}, r"force = -800\.0: must be below friction \* load = 800"),
        ({"direction": 2}, r"direction = 2: must be 0 \(x\) or 1 \(s\)"),
    ],
)
def test_input_outside_the_validity_is_refused(changes, message):
    arguments = {"normal": NORMAL, "nu": NU, "friction": FRICTION, "force": 10.0} | changes
    with pytest.raises(WrongInput, match=message):
        ShiftedPoint(**arguments)
