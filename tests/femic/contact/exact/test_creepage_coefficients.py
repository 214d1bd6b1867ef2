"""Creepage coefficients against elements on half-spaces, limits of slender ellipses, and reciprocity."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.exact.friction import TractiveRolling
from femic.contact.exact.hertz import LineContact
from geometries.errors import WrongInput
from geometries.materials import ElasticConstants
from geometries.patches import Patch, S, X

NAMES = "C11", "C22", "C23", "C32", "C33"


def five(*arguments, **options):
    result = creepage_coefficients(*arguments, **options)
    return np.array([getattr(result, name) for name in NAMES])


def by_elements(a, b, nu, n):
    """The five by n strips of n elements each, as long as the strips are: slip vanishes between the middle of
    each element and a point ahead by its length, which a particle passes before.
    """
    edges = -b * np.cos(np.linspace(0, np.pi, n + 1))  # narrower where the ellipse ends
    strips, half_widths = (edges[1:] + edges[:-1]) / 2, np.diff(edges) / 2
    lengths = 2 * a * np.sqrt(1 - (strips / b) ** 2) / n
    x = np.multiply.outer(np.arange(n) - (n - 1) / 2, lengths)  # (n, strips)
    s = np.broadcast_to(strips, x.shape)
    change = np.zeros((2, n, n, 2, n, n))  # observer: direction, along x, strip; then load
    space = HalfSpace(ElasticConstants(1.0, nu, 0.0, 2))
    for strip in range(n):
        patch = Patch(lengths[strip] / 2, half_widths[strip])
        lags = x[:, :, None] - x[:, strip], s[:, :, None] - s[:, strip]
        here, ahead = (space.ics(patch, lags[0] + d, lags[1])[:2, :2] for d in (0.0, lengths[:, None]))
        change[..., strip] = (ahead - here).transpose(0, 2, 3, 1, 4)
    ones, zeros = np.ones_like(x), np.zeros_like(x)
    slips = [(ones, zeros), (zeros, ones), (-s, x + lengths / 2)]
    right = np.stack([np.stack(slip) * lengths for slip in slips], axis=-1)
    size = 2 * n**2
    p = np.linalg.solve(change.reshape(size, size), right.reshape(size, 3)).reshape(2, n, n, 3)
    loads = p * (lengths * 2 * half_widths)[:, None]
    forces = loads.sum(axis=(1, 2))  # (direction, slip)
    moments = (x[..., None] * loads[S] - s[..., None] * loads[X]).sum(axis=(0, 1))
    c = np.sqrt(a * b)
    return -np.array(
        [forces[X, 0] / c**2, forces[S, 1] / c**2, forces[S, 2] / c**3, moments[1] / c**3, moments[2] / c**4]
    )


@pytest.mark.parametrize(("a", "b", "nu"), [(0.7, 1.0, 0.25), (4.0, 1.0, 0.5)])
def test_elements_on_half_spaces_converge_to_them(a, b, nu):
    """Order 1 by the elements at the ends of the strips, so that two grids give more."""
    coarse, fine = (by_elements(a, b, nu, n) for n in (8, 16))
    exact = five(a, b, nu)
    np.testing.assert_allclose(fine, exact, rtol=0.14)
    np.testing.assert_allclose(2 * fine - coarse, exact, rtol=0.02)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("nu", [0.0, 0.5])
def test_errors_are_below_the_estimate_which_is_below_a_thousandth(ratio, nu):
    result = creepage_coefficients(ratio, 1.0, nu)
    assert result.estimate < 5e-4
    finer = five(ratio, 1.0, nu, degree=32)
    allowed = result.estimate + 1e-11
    np.testing.assert_allclose(five(ratio, 1.0, nu), finer, rtol=allowed)
    np.testing.assert_allclose(-result.C32, result.C23, rtol=allowed)  # by reciprocity: rolling backwards


def test_the_errors_fall_as_the_fourth_power_of_the_degree():
    exact = five(0.3, 1.0, 0.4, degree=32)
    errors = [np.max(np.abs(five(0.3, 1.0, 0.4, degree=n) / exact - 1)) for n in (8, 16)]
    assert errors[0] / errors[1] > 2**3.5


@pytest.mark.parametrize("ratio", [0.2, 1.0, 5.0])
def test_without_poisson_s_ratio_both_directions_are_alike(ratio):
    """The ICs couple no directions, and both are 1/R."""
    result = creepage_coefficients(ratio, 1.0, 0.0)
    np.testing.assert_allclose(result.C11, result.C22, rtol=1e-12)


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
def test_ellipse_wide_across_agrees_with_carter_strip_by_strip(nu):
    """C11 by the force per creepage of strips as long as the ellipse, C33 by their moments about the middle.

    Across the direction of rolling a strip is softer by 1 - nu: C22. C23 by the series of Kalker (1990).
    """
    result = creepage_coefficients(0.01, 1.0, nu)
    middles = (np.arange(1000) + 0.5) / 1000
    lengths = 0.01 * np.sqrt(1 - middles**2)  # half of those of the strips

    def slope(half_length):
        """Force per creepage and length of a Hertz contact as wide, for G = 1."""
        line = LineContact(1e-3, 1 / (1 - nu))
        load = np.pi * line.modulus * line.curvature * half_length**2 / 4
        return TractiveRolling(line, load, 1.0, 1e-12).force / 1e-12

    slopes = np.array([slope(half_length) for half_length in lengths])
    C11 = 2 * np.mean(slopes) / 0.01
    np.testing.assert_allclose(result.C11, C11, rtol=1e-3)
    np.testing.assert_allclose(result.C22, (1 - nu) * C11, rtol=1e-3)
    np.testing.assert_allclose(result.C33, 2 * np.mean(slopes * middles**2) / 0.01**2, rtol=4e-3)
    bent = 1 + nu * (np.log(16 / 0.01**2) / 2 + np.log(4) - 5)
    np.testing.assert_allclose(result.C23, np.pi * 0.01**0.5 / (3 * (1 - nu)) * bent, rtol=2e-3)


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
def test_ellipse_long_in_rolling_agrees_with_kalkers_series(nu):
    """Kalker (1990), appendix E: for b / a = g to 0 with L = ln(16 / g^2); terms of L^-2 and g^2 are left.

    C33 without Poisson's ratio: each section turns as a strip does that is twisted.
    """
    g = 0.01
    L = np.log(16 / g**2)
    result = creepage_coefficients(1.0, g, nu)
    bent = (1 - nu) * L - 2 + 4 * nu
    np.testing.assert_allclose(result.C23, 2 * np.pi / (3 * g**1.5 * bent), rtol=1e-3)
    C11 = 2 * np.pi / ((L - 2 * nu) * g) * (1 + (3 - np.log(4)) / (L - 2 * nu))
    np.testing.assert_allclose(result.C11, C11, rtol=8 / L**2)
    if not nu:
        np.testing.assert_allclose(result.C33, np.pi / 4, rtol=1e-3)


def test_the_forces_are_per_unit_of_the_creepages():
    """In the signs of rolling: a driven wheel pushes, sideways drift is resisted; in any units."""
    result = creepage_coefficients(3.0, 2.0, 0.3)
    unit = creepage_coefficients(1.5, 1.0, 0.3)
    F_x, F_s, M_n = result.forces(80e3, 1e-4, 2e-4, 3e-5)
    assert F_x == pytest.approx(80e3 * 6 * unit.C11 * 1e-4)
    assert F_s == pytest.approx(-80e3 * 6 * (unit.C22 * 2e-4 + np.sqrt(6) * unit.C23 * 3e-5))
    assert M_n == pytest.approx(-80e3 * 6**1.5 * (unit.C32 * 2e-4 + np.sqrt(6) * unit.C33 * 3e-5))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"b": 0.0}, r"a = 1\.0, b = 0\.0: must be positive"),
        ({"b": 200.0}, r"a / b within 1/100 \.\.\. 100"),
        ({"nu": -0.1}, r"nu = -0\.1: must lie in 0 \.\.\. 0\.5"),
        ({"degree": 5}, "degree = 5: at least 6"),
    ],
)
def test_input_out_of_range_is_refused(changes, message):
    with pytest.raises(WrongInput, match=message):
        creepage_coefficients(**{"a": 1.0, "b": 1.0, "nu": 0.3} | changes)
