"""The pin in a hole by the solver of contact with bounds on both bodies' line loads, and against Hertz."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import toeplitz

from approx.cylinder import cavity_ics, solid_cylinder_ics
from femic.contact.exact.hertz import LineContact
from femic.contact.normal import Bounded, pressures
from femic.contact.patch import extents
from geometries.errors import WrongInput
from geometries.materials import Material
from tests.femic.contact.exact.pin import PinInHole

STEEL = Material(210e3, 0.28)
SIMILAR = Material(50e3 * 1.45, 0.45)  # against a pin of G = 50e3 / (2 * 0.1) (1 - 2 nu), nu = 0
RUBBERS = Material(3.0, 0.5), Material(70.0, 0.5)
PINS = {
    "equal": PinInHole(STEEL, STEEL, 12.0, 0.05),
    "soft pin": PinInHole(*RUBBERS, 12.0, 0.05),
    "soft hole": PinInHole(*RUBBERS[::-1], 12.0, 0.05),
    "other nu": PinInHole(Material(2.0 * 250e3, 0.0), SIMILAR, 12.0, 0.05),
}
each_pin = pytest.mark.parametrize("pin", PINS.values(), ids=PINS)


def compliance(pin, half_angle, n):
    """Radial displacement differences at the middles of n elements due to unit pressures on them, (n, n)."""
    width = 2 * half_angle / n

    def nn(angle):
        return cavity_ics(pin.hole, angle)[1, 1] + solid_cylinder_ics(pin.pin, angle)[1, 1]

    nodes, weights = np.polynomial.legendre.leggauss(12)
    own = (nodes + 1) / 2  # half of the loaded element; crowded where the logarithm is infinite
    lags = [2 * np.sum(weights / 2 * 3 * own**2 * nn(width / 2 * own**3)) * width / 2]
    lags += [np.sum(weights / 2 * nn(width * (k + nodes / 2))) * width for k in range(1, n)]
    return pin.radius * toeplitz(lags)


def by_bounds(pin, load, n):
    """Pressures and half-angle by the solver of contact with bounds, on elements from -90 to 90 degrees."""
    angles = np.pi / n * (np.arange(n) + 0.5) - np.pi / 2
    S = compliance(pin, np.pi / 2, n)
    S = S + np.outer(np.cos(angles), np.cos(angles)) * np.max(S)  # a rigid compliance: ICs become positive
    own = S[0, 0]
    h, c = pin.clearance * (1 - np.cos(angles)), np.cos(angles)
    problem = Bounded(lambda p: p @ S, lambda u: u / own, h[None], c[None])
    solution = pressures(problem, load=load * n / (np.pi * pin.radius))
    (extent,) = extents(np.pad(solution.p, ((3, 3), (0, 0))), np.pad(solution.gap, ((3, 3), (0, 0))))
    return angles, solution.p[0], np.diff(extent.s)[0] * np.pi / n / 2


@each_pin
@pytest.mark.parametrize("half_angle", [0.4, 1.1])
@pytest.mark.parametrize("n", [40, 80, 160, 320])
def test_bound_constrained_solver_converges_to_the_pin(pin, half_angle, n):
    """Conformal contact in the plane, with ICs that are exact: order 1.5, because pressures end as a root."""
    assert abs(pin.beta) < 1e-12  # similar materials, though not equal
    load, element = pin.load(half_angle), np.pi / n
    angles, p, result = by_bounds(pin, load, n)
    assert result == pytest.approx(half_angle, abs=element / 4)
    error = np.mean(np.abs(p - pin.pressure(load, angles))) / np.mean(p)
    assert error < 0.25 * (element / half_angle) ** 1.5


@each_pin
@pytest.mark.parametrize("half_angle", [0.01, 0.7, 1.2])
def test_pressures_carry_the_load(pin, half_angle):
    load = pin.load(half_angle)

    def carried(t):
        angle = half_angle * np.sin(t)
        return pin.radius * pin.pressure(load, angle) * np.cos(angle) * half_angle * np.cos(t)

    assert quad(carried, -np.pi / 2, np.pi / 2)[0] == pytest.approx(load, rel=1e-9)
    assert pin.half_angle(load) == pytest.approx(half_angle, rel=1e-12)
    assert not pin.pressure(load, 1.001 * half_angle)


@each_pin
def test_small_contacts_agree_with_hertz(pin):
    line = LineContact(pin.clearance / pin.radius**2, pin.modulus)
    differences = []
    for half_angle in (0.02, 0.01):
        load = pin.load(half_angle)
        differences.append(pin.radius * half_angle / line.half_width(load) - 1)
        angles = half_angle * np.array([0.0, -0.4, 0.7])
        expected = line.p_max(load) * np.sqrt(1 - (angles / half_angle) ** 2)
        np.testing.assert_allclose(pin.pressure(load, angles), expected, rtol=2 * half_angle**2)
    assert abs(differences[1]) < 1e-3
    assert differences[0] / differences[1] == pytest.approx(4, rel=0.01)  # half_angle^2


@each_pin
def test_the_contact_grows_with_the_load_up_to_that_without_clearance(pin):
    angles = [pin.half_angle(load) for load in np.geomspace(1e-6, 1e9, 31) * pin.load(0.5)]
    assert np.all(np.diff(angles) > 0)
    closed = replace(pin, clearance=0.0)
    assert angles[-1] == pytest.approx(pin.largest_half_angle, rel=1e-6)
    assert closed.half_angle(3.0) == pytest.approx(closed.half_angle(3e5)) == pin.largest_half_angle


def test_a_soft_pin_in_a_stiff_hole_has_the_wider_contact():
    """The combined modulus is the same: only the pin is squeezed evenly from all sides, and so smaller."""
    soft_pin, soft_hole = PINS["soft pin"], PINS["soft hole"]
    assert soft_pin.modulus == soft_hole.modulus
    load = soft_pin.load(0.9)
    assert soft_pin.half_angle(load) > soft_hole.half_angle(load)


def test_other_units_change_nothing():
    pin = PINS["equal"]
    metres = PinInHole(Material(210e9, 0.28), Material(210e9, 0.28), 0.012, 0.05e-3)
    assert metres.half_angle(1e6) == pytest.approx(pin.half_angle(1e3), rel=1e-12)
    assert metres.pressure(1e6, 0.1) == pytest.approx(1e6 * pin.pressure(1e3, 0.1), rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": -1.0}, r"radius = -1\.0: must be a positive length"),
        ({"clearance": -0.1}, r"clearance = -0\.1: must be 0 or a positive"),
        ({"hole": Material(70e3, 0.28)}, r"Dundurs' beta = 0\.\d+.*must be the same for both"),
    ],
)
def test_input_outside_the_validity_is_refused(changes, message):
    with pytest.raises(WrongInput, match=message):
        replace(PINS["equal"], **changes)


def test_half_angle_that_no_load_produces_is_refused():
    with pytest.raises(WrongInput, match=r"half_angle = 1\.6: must lie in 0 \.\.\. 1\."):
        PINS["equal"].load(1.6)
    with pytest.raises(WrongInput, match=r"with a clearance \(now 0 mm\)"):
        replace(PINS["equal"], clearance=0.0).load(0.4)
    with pytest.raises(WrongInput, match=r"load = 0\.0: must be positive"):
        PINS["equal"].half_angle(0.0)
