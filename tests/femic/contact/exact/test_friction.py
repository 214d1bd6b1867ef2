"""Closed forms with friction: Carter's rolling, Cattaneo's shift, full stick; by integration and elements."""

import numpy as np
import pytest
from scipy.integrate import quad

from approx.halfspace import HalfSpace
from femic.contact.exact.friction import ShiftedPoint, StickingPoint, TractiveRolling
from femic.contact.exact.hertz import LineContact, PointContact, combined_modulus
from geometries.errors import WrongInput
from geometries.materials import ElasticConstants, Material, both_bodies
from geometries.patches import N, Patch, S, X

# ---- Carter: rolling cylinders

LINE, LOAD, FRICTION = LineContact(0.004, 115e3), 800.0, 0.4
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
    assert np.all(np.isnan(contact.slip([-1.1 * A, 1.1 * A])))
    sticks = at > contact.stick_start
    assert not np.any(contact.slip(at)[sticks])
    assert np.all(np.sign(contact.slip(at)[~sticks]) == -np.sign(share))
    p = LINE.pressure(LOAD, at)
    q = contact.traction(at)
    np.testing.assert_allclose(np.abs(q[~sticks]), FRICTION * p[~sticks], rtol=1e-12)
    assert np.all(np.abs(q[sticks]) < FRICTION * p[sticks])


def test_small_creepage_agrees_with_the_linear_law():
    """Force = pi E* a xi / 2: traction C sqrt((a - x) / (a + x)) has the slope -2 C / E* everywhere."""
    contact = rolling(1e-7)
    assert contact.force == pytest.approx(np.pi * LINE.modulus * A * contact.creepage / 2, rel=1e-6)


# ---- Cattaneo and Mindlin: a shift

NU = 0.3

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


# ---- full stick of dissimilar bodies


CURVATURE = 0.05
each_beta = pytest.mark.parametrize("beta", [0.5, -0.35, 0.1])


def point(beta):
    return StickingPoint(CURVATURE, 1000.0, beta)


@pytest.mark.parametrize(("beta", "nu"), [(0.5, 0.0), (-0.35, 0.4)])
def test_the_tractions_of_a_point_press_without_slip(beta, nu):
    """The gap is closed, and the tangential displacement is that of all sizes: proportional to r^2."""
    contact, n = point(beta), 100
    a = contact.radius(LOAD)
    middles = a * ((np.arange(n) + 0.5) / n * 2 - 1)
    x, s = (grid.ravel() for grid in np.meshgrid(middles, middles, indexing="ij"))
    r = np.hypot(x, s)
    radii, places = np.unique(np.round(r, 9), return_inverse=True)
    p, q = (values[places] for values in contact.tractions(LOAD, radii))
    tractions = np.stack([q * x / r, q * s / r, p])
    at = a * np.array([0.05, 0.2, 0.4, 0.6, 0.8])
    constants = ElasticConstants(1000.0 * (1 - nu), nu, beta * (1 - nu), 2)  # of E* = 1000 MPa
    space, patch = HalfSpace(constants), Patch(a / n, a / n)
    u = np.array([np.einsum("ijk,jk->i", space.ics(patch, x_at - x, -s), tractions) for x_at in at])
    approach = contact.approach(LOAD)
    np.testing.assert_allclose(u[:, N] + CURVATURE * at**2 / 2, approach, rtol=2e-3)
    coefficient = u[-1, X] / at[-1] ** 2
    assert np.sign(coefficient) == -np.sign(beta)  # inwards for K > 0
    np.testing.assert_allclose(u[:, X], coefficient * at**2, atol=1e-3 * approach)
    assert not np.any(contact.tractions(LOAD, 1.01 * a))


@each_beta
def test_tractions_of_a_point_carry_the_load(beta):
    contact = point(beta)
    a = contact.radius(LOAD)
    t = (np.arange(400) + 0.5) / 400
    r = a * (1 - t**2)
    p, q = contact.tractions(LOAD, r)
    assert np.sum(2 * np.pi * r * p * 2 * t * a) / 400 == pytest.approx(LOAD, rel=1e-5)
    assert np.all(np.sign(q[r < 0.99 * a]) == np.sign(beta))


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.49])
def test_rigid_punch_agrees_with_mossakovskii(nu):
    """Load per approach of any indenter is the stiffness of a flat one: 4 G a ln(3 - 4 nu) / (1 - 2 nu)."""
    G = 3.0
    contact = StickingPoint(CURVATURE, 2 * G / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu)))
    loads = LOAD * np.array([1 - 1e-5, 1 + 1e-5])
    stiffness = np.diff(loads)[0] / np.diff([contact.approach(load) for load in loads])[0]
    expected = 4 * G * contact.radius(LOAD) * np.log(3 - 4 * nu) / (1 - 2 * nu)
    assert stiffness == pytest.approx(expected, rel=1e-6)


@each_beta
def test_the_approach_is_the_integral_by_parts(beta):
    epsilon = np.arctanh(beta) / np.pi

    def turned(t):
        return np.cos(epsilon * np.log((1 + t) / (1 - t)))

    of_point, _ = quad(lambda angle: np.sin(angle) * np.cos(angle) * turned(np.sin(angle)), 0, np.pi / 2)
    assert point(beta).approach_ratio == pytest.approx(1 / (2 * of_point), rel=1e-7)


def test_beta_is_that_of_the_combined_constants():
    soft, stiff = Material(1000.0, 0.1), Material(70e3, 0.3)
    constants = both_bodies(soft, stiff)
    differences = [(1 - 2 * material.nu) / material.G for material in (soft, stiff)]
    dundurs = (differences[0] - differences[1]) * combined_modulus(soft, stiff) / 4
    assert constants.mismatch_k / (1 - constants.nu) == pytest.approx(dundurs, rel=1e-12)


def test_no_mismatch_gives_hertz():
    hertz, contact = PointContact(CURVATURE, CURVATURE, 1000.0).at_load(LOAD), point(0.0)
    assert contact.radius(LOAD) == pytest.approx(hertz.a, rel=1e-12)
    assert contact.approach(LOAD) == pytest.approx(hertz.approach, rel=1e-12)
    r = hertz.a * np.array([0.0, 0.3, 0.99, 1.2])
    p, q = contact.tractions(LOAD, r)
    np.testing.assert_allclose(p, hertz.pressure(r, 0.0), rtol=1e-10)
    assert not np.any(q)


def test_exchanged_bodies_reverse_the_tangential_tractions():
    (p, q), (p_other, q_other) = (point(beta).tractions(LOAD, [0.1, 0.5, 1.0]) for beta in (0.4, -0.4))
    np.testing.assert_allclose(p, p_other, rtol=1e-12)
    np.testing.assert_allclose(q, -q_other, rtol=1e-12)


def test_tractions_are_smooth_in_the_middle():
    """q is r ln(r), and 0 in the centre itself."""
    p, q = point(0.4).tractions(LOAD, [0.0, 1e-8, 1e-4])
    np.testing.assert_allclose(p, p[0], rtol=1e-3)
    assert not q[0]
    assert 0 < q[1] < q[2] < 1e-3 * p[0]


SHIFT = {"normal": NORMAL, "nu": NU, "friction": FRICTION, "force": 10.0}
ROLLING = {"surfaces": LINE, "load": LOAD, "friction": FRICTION, "creepage": 1e-3}
STICK = {"curvature": CURVATURE, "modulus": 1000.0, "beta": 0.1}


@pytest.mark.parametrize(
    ("kind", "arguments", "message"),
    [
        (TractiveRolling, ROLLING | {"load": 0.0}, r"load = 0\.0: must be positive"),
        (TractiveRolling, ROLLING | {"friction": -0.1}, r"friction = -0\.1: must be positive"),
        (TractiveRolling, ROLLING | {"creepage": np.nan}, r"creepage = nan: must be finite"),
        (ShiftedPoint, SHIFT | {"nu": 0.6}, r"nu = 0\.6: must lie in 0 \.\.\. 0\.5"),
        (ShiftedPoint, SHIFT | {"friction": 0.0}, r"friction = 0\.0: must be positive"),
        (ShiftedPoint, SHIFT | {"force": -800.0}, r"force = -800\.0: must be below friction \* load = 800"),
        (ShiftedPoint, SHIFT | {"direction": 2}, r"direction = 2: must be 0 \(x\) or 1 \(s\)"),
        (StickingPoint, STICK | {"beta": 0.6}, r"beta = 0\.6: must lie in -0\.5 \.\.\. 0\.5"),
        (StickingPoint, STICK | {"curvature": 0.0}, r"curvature = 0\.0: must be positive"),
    ],
)
def test_input_outside_the_validity_is_refused(kind, arguments, message):
    with pytest.raises(WrongInput, match=message):
        kind(**arguments)


def test_loads_that_do_not_press_are_refused():
    with pytest.raises(WrongInput, match=r"load = -1\.0: must be positive"):
        point(0.1).radius(-1.0)
