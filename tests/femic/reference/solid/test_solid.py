"""The solid engine: equilibrium, reciprocity, symmetries, units, invariances."""

from dataclasses import replace

import numpy as np
import pytest

from femic.reference.engine import Points
from femic.reference.engines import SOLID
from femic.reference.job import Job, Settings
from femic.reference.solid import engine
from femic.reference.solid.engine import build_mesh, observe, patch_load, raw_ics, solve
from femic.reference.symmetry import Parity, held_by_symmetry, parities
from geometries.bodies import Domain
from geometries.contours import arc, through_points
from geometries.materials import Material
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import (
    COARSE,
    PATCH,
    SMALL,
    STEEL,
    SYMMETRIC,
    UNSYMMETRIC,
    ics_of,
    request_for,
)
from tests.femic.reference.known_bodies import reference

EVEN_IN_X = np.array([[1, -1, -1], [-1, 1, 1], [-1, 1, 1]])  # [i, j]: parity of component i under load j
# the solver stops at a relative residual of 1e-9; displacements are then known to about 1e-8
SOLVED = 1e-7


def the_parity(load):
    (parity,) = parities(load, half_section=False)
    return parity


@pytest.mark.parametrize("direction", [0, 1, 2])
def test_patch_load_carries_unit_force_and_its_moments(half_model, direction):
    load = Load(Patch(0.3, 0.5, s=1.0), direction)
    solid, patch = half_model.solid, load.patch
    force = patch_load(solid, load, the_parity(load))
    s, w = np.polynomial.legendre.leggauss(20)
    s, w = patch.s + patch.b * s, w / 4  # half of the patch is modelled: x >= 0
    axes = solid.body.surface.axes(0.0, s)[direction]
    np.testing.assert_allclose(force.sum(axis=0), axes @ w, atol=1e-13)
    points = solid.body.surface.position(patch.a / 2, s)
    moments = np.cross(points.T, axes.T).T @ w
    by_nodes = np.cross(solid.nodes.T, force).sum(axis=0)
    # nodes lie on the arc, facets between them deviate from it by h^4 terms of order 1e-6 here
    np.testing.assert_allclose(by_nodes, moments, atol=2e-6)


def test_patches_on_a_wheel_are_equally_long_on_every_circle():
    """|x| <= a is an angle of a / R(s): the load's second moment along the chart says so."""
    load = Load(Patch(0.3, 0.5, s=2.5), 1)
    solid = build_mesh(request_for(UNSYMMETRIC, side=UPPER, rolling_radius=60.0, patch=load.patch))
    force, xi = patch_load(solid, load, the_parity(load)), solid.trace.basis.doflocs[0]
    s, w = np.polynomial.legendre.leggauss(20)
    s, w = load.patch.s + load.patch.b * s, w / 4  # half of the patch is modelled: x >= 0
    end = 60.0 * load.patch.a / solid.body.surface.circle_radius(s)
    expected = end**2 / 3 * np.cos(UNSYMMETRIC.inclination(s)) @ w  # a lateral load's part along y
    assert xi**2 @ force[solid.trace.nodes, 1] == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("direction", [0, 1, 2])
@pytest.mark.parametrize("s", [0.0, 0.2, 3.0])
def test_even_and_odd_parts_of_a_load_add_up_to_it(direction, s):
    """Force of the two parts on y >= 0, and of their mirror images on y <= 0: of the load on each side."""
    solid = build_mesh(request_for(SYMMETRIC))
    load = Load(Patch(0.3, 0.5, s), direction)
    parts = parities(load, half_section=True)
    assert len(parts) == (1 if s == 0 else 2)
    force = np.array([patch_load(solid, load, parity).sum(axis=0) for parity in parts])
    mirrored = np.array([p.signs(1) for p in parts]) * force
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for side, total_force in ((1, force.sum(axis=0)), (-1, mirrored.sum(axis=0))):
        ends = np.clip([s - 0.5, s + 0.5], *((0, 9) if side > 0 else (-9, 0)))
        at = ends.mean() + np.ptp(ends) / 2 * nodes
        share = solid.body.surface.axes(0.0, at)[direction] @ weights * np.ptp(ends) / 2 / (2 * 1.0)
        np.testing.assert_allclose(total_force, share, atol=1e-12)


@pytest.mark.parametrize("direction", [0, 1, 2])
def test_reactions_balance_the_load(half_model, direction, monkeypatch):
    monkeypatch.setattr(engine, "RESIDUAL", 1e-9)
    unit = Load(PATCH, direction)
    ((parity, solution),) = solve(half_model, (unit,), "multigrid")[unit]
    nodes, load = half_model.solid.nodes, patch_load(half_model.solid, unit, parity)
    reaction = (half_model.stiffness @ solution.displacement.ravel()).reshape(-1, 3) - load
    held = half_model.supported | held_by_symmetry(nodes, parity)
    assert np.abs(reaction[~held]).max() < 1e-9  # equilibrium where nothing is held, in N per 1 N
    on_held = np.where(held, reaction, 0)
    np.testing.assert_allclose(on_held.sum(axis=0), -load.sum(axis=0), atol=1e-6)
    moments = np.cross(nodes.T, on_held).sum(axis=0) + np.cross(nodes.T, load).sum(axis=0)
    np.testing.assert_allclose(moments, 0, atol=1e-6 * SMALL.far_radius)


def test_raw_reciprocity_between_two_load_positions(half_model):
    here, there = Patch(0.3, 0.5, s=0.0), Patch(0.4, 0.25, s=2.5)
    works = np.array([[_work(half_model, p, q) for q in (here, there)] for p in (here, there)])
    # work of the load p on the displacements of q, all direction pairs: Maxwell-Betti
    scale = np.abs(works).max()
    np.testing.assert_allclose(works[0, 1], works[1, 0].T, atol=SOLVED * scale)


def _work(model, observer, load):
    """Work of unit loads on `observer` (even part in x) on the displacements of loads on `load`."""
    fields = solve(model, [Load(load, j) for j in (1, 2)], "multigrid").values()
    forces = [patch_load(model.solid, Load(observer, i), Parity(1, 0)) for i in (1, 2)]
    return np.array([[np.sum(f * solution.displacement) for ((_, solution),) in fields] for f in forces])


@pytest.mark.parametrize(
    ("contour", "mirrored", "parity"),
    [(UNSYMMETRIC, 1, EVEN_IN_X), (SYMMETRIC, 4, EVEN_IN_X[np.ix_([1, 0, 2], [1, 0, 2])])],
    ids=["x", "s of a symmetric section"],
)
def test_observed_displacements_are_even_or_odd(contour, mirrored, parity):
    ic = ics_of(request_for(contour))
    np.testing.assert_allclose(ic[..., mirrored], parity * ic[..., 0], rtol=1e-12)
    assert np.all(np.abs(ic[..., 0]) > 0)


@pytest.mark.parametrize("s", [pytest.param(0.0, marks=pytest.mark.slow), 1.5])
def test_half_and_quarter_models_agree(s):
    """A flank steeper by nothing to speak of needs the half model: a second route to the same ICs."""
    nearly = arc(10.0, np.radians(25.5), np.radians(25.5) + 1e-6)
    domain, points = Domain(20.0, 20.0), Points(np.array([1.5, 3.0, 2.0]), np.array([0.8, -2.0, 0.0]))
    fine = replace(request_for(SYMMETRIC).cells, smallest=0.15, growth=0.35, line_growth=0.2)
    quarter, half = (
        raw_ics(
            request_for(
                contour, domain=domain, points=points, cells=fine, patch=replace(PATCH, s=s), solver="auto"
            )
        )
        for contour in (SYMMETRIC, nearly)
    )
    assert half.cost.cells > (1.5 if s == 0 else 1.2) * quarter.cost.cells
    # two different meshes: each is good to about 1 % of the largest component here
    np.testing.assert_allclose(half.u, quarter.u, atol=0.01 * np.abs(quarter.u).max())


@pytest.mark.parametrize("k", [1e-3, pytest.param(25.4, marks=pytest.mark.slow)])
def test_units_do_not_matter(k):
    """Lengths times k: displacements per unit force fall by k, and with the modulus; so in m and N/m^2."""
    one = request_for(UNSYMMETRIC)
    other = request_for(
        arc(8.0 * k, np.radians(20), np.radians(35)),
        material=Material(STEEL.E / 7, STEEL.nu),
        patch=Patch(k * PATCH.a, k * PATCH.b),
        domain=SMALL.scaled(k),
        cells=replace(one.cells, smallest=k * one.cells.smallest),
        points=Points(k * one.points.x, k * one.points.s),
    )
    ic = ics_of(one)
    # rounding may flip a few cells: the mesh error of these coarse cells is some percent
    np.testing.assert_allclose(k / 7 * ics_of(other), ic, atol=0.02 * np.abs(ic).max())


def test_solvers_agree():
    pytest.importorskip("pypardiso")
    iterated, direct = (raw_ics(request_for(UNSYMMETRIC, solver=name)) for name in ("multigrid", "direct"))
    np.testing.assert_allclose(iterated.u, direct.u, atol=SOLVED * np.abs(direct.u).max())
    assert max(direct.cost.iterations) == 0 < min(iterated.cost.iterations)


def test_observers_interpolate_a_quadratic_field_exactly(half_model):
    """The trace is quadratic in (x, s): a field that is so too comes back to rounding."""
    trace = half_model.solid.trace
    x, s = trace.basis.doflocs
    u = np.zeros((half_model.solid.nodes.shape[1], 3))
    u[trace.nodes, 0] = x**2 - 3 * x * s + 2 * s**2 + x
    points = Points(np.array([0.7, 3.1]), np.array([-1.3, 2.2]))
    load = Load(PATCH, 0)
    ((parity, solution),) = solve(half_model, (load,), "multigrid")[load]
    seen = observe(half_model, load, ((parity, replace(solution, displacement=u)),), points)[0]
    expected = points.x**2 - 3 * points.x * points.s + 2 * points.s**2 + points.x
    np.testing.assert_allclose(seen, expected, rtol=1e-10)


# --- loads on both sides of the crown, before and after the discount -----------------------------------

HERE, THERE = -1.5, 2.5
FINE = replace(COARSE, smallest=0.1, growth=0.3, line_growth=0.2)
FINER = replace(COARSE, smallest=0.08, growth=0.25, line_growth=0.15)
BODIES = {"rail": (LOWER, np.inf, FINE), "wheel": (UPPER, 80.0, FINER)}


def lateral_ics(name, contour, s_load, s_observer, x=0.0):
    """C of s and n before and after the discount, and its estimate, (2, 2) each, at one observer."""
    side, radius, cells = BODIES[name]
    body = request_for(contour, side=side, rolling_radius=radius).body
    points = Points(np.array([x]), np.array([s_observer]))
    settings = Settings(SOLID, cells=cells, rotation_reach=5.0, moment_arm=2.0)
    loads = Patch(0.2, 0.2, s_load), ("ss", "sn", "ns", "nn")
    result = reference(Job(body, *loads, points, {"point": slice(0, 1)}, settings))
    return [values[1:, 1:, 0] for values in (result.raw, result.c.ic, result.c.estimate)]


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_loads_on_both_sides_of_the_crown_are_reciprocal(name):
    *there, known_there = lateral_ics(name, UNSYMMETRIC, HERE, THERE)
    *here, known_here = lateral_ics(name, UNSYMMETRIC, THERE, HERE)
    allowed = known_there + known_here.T
    for one, other in zip(there, here, strict=True):
        assert np.all(np.abs(one - other.T) <= allowed), np.abs(one - other.T) / allowed
    assert np.all(allowed < 0.03 * np.abs(there[1]).max())  # not trivially large
    # not trivially true either: it fails by far more with observer and load not exchanged
    assert np.abs(there[1] - here[1]).max() > 10 * allowed.max()


@pytest.mark.slow
def test_a_load_at_s_is_the_mirrored_load_at_minus_s_on_the_mirrored_section():
    y = np.linspace(-12, 12, 41)
    z = -(y**2) / 30 - 0.03 * y - 0.0005 * y**3
    *here, known = lateral_ics("wheel", through_points(y, z), THERE, HERE, 1.5)
    *mirrored, known_mirrored = lateral_ics("wheel", through_points(y, z[::-1]), -THERE, -HERE, 1.5)
    allowed, signs = known + known_mirrored, np.array([[1, -1], [-1, 1]])
    for one, other in zip(here, mirrored, strict=True):
        assert np.all(np.abs(one - signs * other) <= allowed), np.abs(one - signs * other) / allowed
    assert np.all(allowed < 0.05 * np.abs(here[1]).max())


def test_mesh_is_repeatable():
    first, second = (build_mesh(request_for(UNSYMMETRIC)).nodes for _ in range(2))
    np.testing.assert_array_equal(first, second)
