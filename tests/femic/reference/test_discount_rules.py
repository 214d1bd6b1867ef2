"""What the rules take for rigid: the logarithm at a load, the approach, the independence of elements."""

from functools import cache

import numpy as np
import pytest

from approx.pair import Solid
from femic.reference.discount import ApproachRule, Rule, fit_discount, rigid_part
from femic.reference.engine import Points
from femic.reference.engines import HARMONIC
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.job import Settings
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import matrices
from femic.reference.run_options import RunOptions
from geometries.bodies import Body, Domain
from geometries.contours import arc, ellipse
from geometries.materials import Material
from geometries.patches import Grid, Load, N, Patch, S
from geometries.surfaces import LOWER, UPPER
from tests.coarse import coarse_sections
from tests.femic.reference.harmonic.fields import raw_ics

RADIUS, NU, FAR = 10.0, 0.28, 320.0
CENTRE = Points(np.zeros(1), np.zeros(1))
BODIES = {  # the sum of both principal curvatures [1/mm], positive where convex
    "rail": ((LOWER, arc(RADIUS, 1.0, 1.0), np.inf), 1 / RADIUS),
    "groove": ((UPPER, arc(RADIUS, 1.0, 1.0), np.inf), -1 / RADIUS),
    "wheel with a groove": ((UPPER, arc(RADIUS, 1.0, 1.0), 25.0), 1 / 25.0 - 1 / RADIUS),
}


def body_of(side, contour, radius, nu=NU, far=FAR):
    return Body(side, contour, Material(210e3, nu), Domain(far, np.inf), radius)


@cache
def above_half_space(name, half_side, nu=NU):
    """C_nn - A_nn [mm/N] at the centre of a load on a body of `BODIES`, before any discount."""
    body, load = body_of(*BODIES[name][0], nu), Load(Patch(half_side, half_side), N)
    request = HarmonicRequest(
        body, (load,), CENTRE, HARMONIC.first_cells(1e-3, load.patch).scaled(2.0), 3e-11
    )
    a = Solid(body.material, body.surface).approximate("A", load.patch, (CENTRE.x, CENTRE.s))
    return float(raw_ics(request).u[0, N, 0] - a[N, N, 0] / load.patch.area)


@pytest.mark.parametrize(
    "name",
    [*(pytest.param(name, marks=pytest.mark.slow) for name in ("rail", "groove")), "wheel with a groove"],
)
def test_c_less_a_goes_like_a_logarithm_of_the_distance_from_the_load(name):
    """By (1 - 2 nu)^2 kappa / (8 pi G) ln 2 per halving of the load, but for terms in proportion to it."""
    sizes = (0.4, 0.2, 0.1)
    first, second = np.diff([above_half_space(name, size) for size in sizes])
    material = Material(210e3, NU)
    expected = (1 - 2 * NU) ** 2 * BODIES[name][1] / (8 * np.pi * material.G) * np.log(2)
    assert 2 * second - first == pytest.approx(expected, rel=0.06)


def test_approach_rule_fits_m_zz_so_that_c_equals_a_at_the_centre_of_its_load():
    body = body_of(LOWER, ellipse(8.0, 12.0, 0.7, 0.9), np.inf)
    rule = ApproachRule(0.2)
    loads = (Load(Patch(0.5, 0.3, 2.0), S), Load(Patch(0.5, 0.3, 2.0), N))
    (condition,) = fit = rule.conditions(body, loads)
    (load,) = condition.loads
    u = np.random.default_rng(2).standard_normal((3, 1))
    m = fit_discount(body, rule, fit, {load: u})
    assert np.count_nonzero(m) == 1
    left = u - rigid_part(m, body, CENTRE, load)
    a = Solid(body.material, body.surface).approximate("A", load.patch, (CENTRE.x, CENTRE.s))
    assert left[N, 0] == pytest.approx(a[N, N, 0] / load.patch.area, rel=1e-12)


def test_nothing_is_subtracted_without_a_rule_or_without_loads():
    body = body_of(LOWER, arc(RADIUS, 1.0, 1.0), np.inf)
    for rule, loads in ((Rule(), (Load(Patch(1, 1), N),)), (ApproachRule(0.2), ())):
        fit = rule.conditions(body, loads)
        assert fit == []
        assert not np.any(fit_discount(body, rule, fit, {}))
    assert len(Rule().observers(body, []).x) == 0


# --- on grids ---------------------------------------------------------------------------------------------


@cache
def found_on(grid, discounts=("approach", "source"), far=FAR):
    body = body_of(LOWER, arc(RADIUS, 1.1, 1.1), np.inf, far=far)
    job = MatrixJob(body, grid, Settings(HARMONIC, 0.1, approach_side=0.3), ("nn",), discounts)
    with coarse_sections():
        return matrices({"lower": job}, RunOptions(1))["lower"]


COARSE, FINE = (Grid(2, n, 2.4 / n, 4.8 / n) for n in (4, 6))


def test_m_zz_is_the_only_entry_and_does_not_depend_on_the_elements():
    """Two grids, by models of their own; the same elements before the discount differ by M_zz cos cos."""
    coarse, fine = found_on(COARSE), found_on(FINE, ("approach",))
    assert fine.discount[2, 2] == pytest.approx(coarse.discount[2, 2], rel=2e-3)
    assert np.count_nonzero(fine.discount) == 1
    cosine = np.cos(FINE.strips / RADIUS)
    for strip in (0, 5):
        taken = fine.raw_column(strip)[N, N] - fine.column(strip).ic[N, N]
        expected = fine.discount[2, 2] * cosine[strip] * cosine
        np.testing.assert_allclose(taken, np.broadcast_to(expected, taken.shape), rtol=1e-10)


def test_far_arc_is_part_of_the_body_except_for_the_source_rule():
    given = found_on(COARSE)
    assert given.column(1).truncation_error[N, N].max() == 0.0
    assert given.column(1, "source").truncation_error[N, N].max() > 0.0


@pytest.mark.slow
def test_a_body_clamped_at_half_the_distance_gives_way_less_as_a_whole_and_as_much_near_the_contact():
    grid = Grid(4, 4, 0.6, 0.9)
    given = found_on(grid, ("approach", "none"))
    nearer = found_on(grid, ("approach",), far=FAR / 2)
    own = given.column(1).ic[N, N, 0, 1]
    raw = given.paired_column(1, "nearer")[N, N]
    cosine = np.cos(grid.strips / RADIUS)
    half = raw - given.approach("nearer") * cosine[1] * cosine
    np.testing.assert_allclose(nearer.column(1).ic[N, N], half, atol=2e-4 * own)
    changed = np.max(np.abs(half - given.column(1).ic[N, N]))
    whole = raw - given.column(1, "none").ic[N, N]
    assert changed < 0.1 * np.max(np.abs(whole))
