"""The measures of both engines and of limits on hand-made curves, whose numbers are known."""

from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from compare.validation.statements import engines_and_limits
from compare.validation.statements.curves import ACROSS, BODIES, CONVEX
from compare.validation.statements.engines_and_limits import (
    cylinder_error,
    deviation_from_limit,
    far_field_error,
    largest_ratios,
    point_load,
)
from compare.validation.statements.page import STATEMENTS
from compare.validation.statements.runs import GEOMETRIES
from geometries.materials import Material, one_body
from geometries.patches import N, S
from geometries.surfaces import LOWER, UPPER
from tests.compare.validation.statements.handmade import made, times
from tests.compare.validation.statements.makers import engines

FIRST = GEOMETRIES[0]


def test_deviation_from_the_limit_is_the_largest_of_all_lines():
    def c(of):
        out = of.a.copy()
        out[S, N] *= np.where(of.on(ACROSS), 1.05, 1)
        return out

    assert deviation_from_limit(made("flat", c), CONVEX) == pytest.approx(0.05)

    def of_both(of):
        out = of.a.copy()
        out[S, N] += 0.02 * np.max(of.a[N, N, of.on(ACROSS)]) * of.on(ACROSS)
        return out

    assert deviation_from_limit(made("flat", of_both), "combined") == pytest.approx(0.02)  # A_sn is 0


def test_point_loads_are_homogeneous_and_reciprocal():
    """As Boussinesq and Cerruti have them: homogeneous of degree -1, C(-x) the transposed of C(x)."""
    constants = one_body(Material(210e3, 0.3), UPPER)
    x, s = np.array([0.3, -2.0]), np.array([1.0, 0.4])
    u = point_load(constants, x, s)
    np.testing.assert_allclose(point_load(constants, 2 * x, 2 * s), u / 2, rtol=1e-14)
    np.testing.assert_allclose(np.swapaxes(point_load(constants, -x, -s), 0, 1), u, rtol=1e-14)
    nn_there = (1 - 0.3**2) / (np.pi * 210e3 * np.hypot(x, s))
    np.testing.assert_allclose(u[2, 2], nn_there, rtol=1e-14)


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
def test_right_limits_hold_and_wrong_ones_do_not(nu, monkeypatch):
    criteria = {criterion.name: criterion for criterion in STATEMENTS[15].criteria}
    assert criteria["point loads"].met(far_field_error(nu))
    assert all(criteria["cylinder"].met(cylinder_error(side, nu)) for side in (UPPER, LOWER))
    wrong = partial(engines_and_limits.cylinder_ics, factor=False)
    monkeypatch.setattr(engines_and_limits, "cylinder_ics", wrong)
    assert criteria["cylinder"].met(cylinder_error(UPPER, nu)) == (nu == 0.5)  # nothing to multiply there
    monkeypatch.setattr(engines_and_limits, "FAR_PATCHES", 1e3)
    assert not criteria["point loads"].met(far_field_error(nu))


@pytest.mark.parametrize("side", [UPPER, LOWER])
def test_point_loads_agree_with_boussinesq_and_cerruti(side):
    """x = 3 mm, s = 4 mm, r = 5 mm, times 2 pi G = 2 pi: each by hand."""
    constants = one_body(Material(2.6, 0.3), side)  # G = 1
    u = 2 * np.pi * point_load(constants, np.array([3.0]), np.array([4.0]))[..., 0]
    expected = [
        [0.7 / 5 + 0.3 * 9 / 125, 0.3 * 12 / 125, -side * 0.2 * 3 / 25],
        [0.3 * 12 / 125, 0.7 / 5 + 0.3 * 16 / 125, -side * 0.2 * 4 / 25],
        [side * 0.2 * 3 / 25, side * 0.2 * 4 / 25, 0.7 / 5],
    ]
    np.testing.assert_allclose(u, expected, rtol=1e-14)


def test_estimates_count_as_a_billionth_at_least():
    """Differences of 5e-10 with no estimate are half of it, with one of 1e-9 as well; the worst line is."""
    differences = {"one": np.full((3, 3), 5e-10), "other": np.full((3, 3), 3e-10)}
    for estimate in (0.0, 1e-9):
        ratio = largest_ratios(differences, dict.fromkeys(differences, np.full((3, 3), estimate)))
        np.testing.assert_allclose(ratio, 0.5)
    np.testing.assert_allclose(
        largest_ratios(differences, dict.fromkeys(differences, np.ones((3, 3)))), 5e-10
    )


def test_details_of_the_engines_are_their_largest_estimate_and_difference():
    """C is known to 0.01 of the largest C_nn, the engines are 6 times that apart.

    Components below a tenth of it vanish: shares are of 0.05 of the largest C_nn far from the load.
    """
    runs = engines(3)()
    details, results = engines_and_limits.engine_details(runs), runs.geometry(GEOMETRIES[0])
    far = np.hypot(results.points.x, results.points.s) >= 1.6 - 1e-9  # four elements
    a_nn = results.approximations["A", "lower"][N, N]
    for body in BODIES:
        case = f"{GEOMETRIES[0]}, {body}"
        worst = 0.01 * np.max(a_nn) / (0.05 * np.max(a_nn[far]))
        assert details[f"estimate of C, harmonic: {case}"] == pytest.approx(worst)
        assert details[f"largest difference: {case}"] == pytest.approx(6 * worst)
    assert len(details) == 12


def test_deviations_of_variants_are_shares_of_the_largest_ic():
    """B_sn off by a hundredth of the largest A, on one body only: that, and half of it combined."""
    flat = made("flat", times("A", None, 1))
    changed = dict(flat.approximations)
    for body in ("lower", "combined"):
        off = np.zeros_like(changed["B", body])
        off[S, N] = 0.01 * np.max(np.abs(changed["A", "lower"]))
        changed["B", body] = changed["A", body] - off
    results = replace(flat, approximations=changed)
    off_a = engines_and_limits.variant_deviations(SimpleNamespace(plane=lambda: results))
    assert off_a["B"] == pytest.approx(0.01)
