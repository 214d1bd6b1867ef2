"""The harmonic engine: bodies of revolution, the solid engine, symmetry, units, what the sums assume."""

from dataclasses import replace

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from approx.variants import approximate
from femic.reference.engine import Points
from femic.reference.engines import HARMONIC, SOLID
from femic.reference.harmonic.engine import solve
from femic.reference.harmonic.section import SectionSize, section_mesh
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.harmonic.synthesis import displacements
from femic.reference.harmonic.waves import tail
from femic.reference.meshing import Cells
from femic.reference.run_options import Level
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.materials import Material, one_body
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import STEEL, UNSYMMETRIC, changed
from tests.femic.reference.harmonic.fields import raw_ics
from tests.femic.reference.known_bodies import first_c, harmonic, harmonic_job, job, reference, shares
from tests.femic.reference.small_model import BODY, TASK

BARE = Cells(0.1, 0.5, 0.5)


# --- coarser cells ---------------------------------------------------------------------------------


@pytest.mark.slow  # the estimates that it serves: test_estimates_bound_the_errors
def test_coarser_cells_at_some_wavenumbers_give_the_error_of_all_wavenumbers():
    """The change is interpolated: it differs by less than 2 % from that of a whole model."""
    request = harmonic_job(40.0, 2.0).request(Level())
    model, coarser = raw_ics(request), raw_ics(request.coarser)
    change = model.perturbed["coarser"] - model.u
    assert coarser.cost.unknowns < model.cost.unknowns
    assert np.max(np.abs(change)) < 1e-2 * np.max(np.abs(model.u))
    np.testing.assert_allclose(change, coarser.u - model.u, rtol=0, atol=2e-2 * np.max(np.abs(change)))


# --- bodies of revolution ------------------------------------------------------------------------------


@pytest.mark.slow
def test_prismatic_is_the_limit_of_a_large_wheel_with_a_difference_like_1_over_r():
    radii = np.array([1e3, 2e3, 4e3])
    crown = {"side": UPPER, "contour": arc(10.0, 0.4, 0.4)}
    c, *of_wheels = (first_c(harmonic_job(80.0, 2.0, rolling_radius=R, **crown)) for R in (np.inf, *radii))
    off = [np.max(np.abs(of_wheel - c)[0, 2]) for of_wheel in of_wheels]
    assert np.polyfit(np.log(radii), np.log(off), 1)[0] == pytest.approx(-1, abs=0.1)


@pytest.mark.slow  # of all components: test_the_ball_is_known_to_the_estimate
def test_xn_of_a_wheel_has_the_longitudinal_curvature_of_b_hat():
    """A plane rolled up: what it adds to C_xn and C_nx is what turns A into B-hat, up to a tenth.

    Both alike, as reciprocity demands: C_nx = -C_xn on the line of the load.
    """
    x = np.array([1.0, 2.0, 5.0, 10.0])
    plane_one = replace(
        harmonic_job(640.0, 2.0, side=UPPER),
        points=Points(x, 0 * x),
        lines={"x": slice(None)},
        components=("xn", "nx"),
    )
    wheel = replace(plane_one, body=replace(plane_one.body, rolling_radius=500.0))
    on_plane, on_wheel = (first_c(j) for j in (plane_one, wheel))
    half_space = HalfSpace(one_body(STEEL, UPPER))
    b_hat, a = (
        approximate("Bhat", half_space, j.body.surface, j.patch, (x, 0 * x)) / j.patch.area
        for j in (wheel, plane_one)
    )
    for i, j in ((0, 2), (2, 0)):
        share = (on_wheel - on_plane)[i, j] / (b_hat - a)[i, j]
        np.testing.assert_allclose(share, 1, atol=0.1)
    np.testing.assert_allclose(on_wheel[2, 0], -on_wheel[0, 2], rtol=1e-4)


def test_a_wheel_is_periodic():
    """Observers once round apart see the same."""
    body = Body(UPPER, plane(), STEEL, Domain(60.0, 60.0), 40.0)
    loads = tuple(Load(Patch(0.5, 0.4), direction) for direction in range(3))
    x = np.array([3.0, 3.0 - 2 * np.pi * 40.0])
    asked = harmonic_job(60.0).request(Level())
    u = raw_ics(replace(asked, body=body, loads=loads, points=Points(x, 0 * x + 2.0), cells=BARE)).u
    np.testing.assert_allclose(u[..., 1], u[..., 0], rtol=0, atol=1e-9 * np.max(np.abs(u)))


# --- the solid engine ----------------------------------------------------------------------------------

BOTH = {
    "unsymmetric": {"contour": UNSYMMETRIC},
    "wheel": {"contour": UNSYMMETRIC, "side": UPPER, "rolling_radius": 60.0},
    "roller": {"contour": arc(10.0, 0.7, 0.4), "side": LOWER, "rolling_radius": 400.0, "s": -1.0},
}


@pytest.mark.slow  # of a squat column: test_outlines.py::test_the_solid_engine_agrees
@pytest.mark.parametrize("changes", BOTH.values(), ids=BOTH)
def test_both_engines_agree_within_their_estimates(changes):
    """The same section; that of the solid is clamped at its ends too, which its estimate contains."""
    solid = job(80.0, 2.8, **changes)
    c, other = (reference(asked).c for asked in (solid, harmonic(solid, 2.0)))
    off, known = (shares(v, c.ic) for v in (c.ic - other.ic, c.estimate + other.estimate))
    assert np.all(off <= known), off / known


# --- parts of sections, symmetry, units ---------------------------------------------------------------


def test_what_vanishes_by_symmetry_vanishes():
    asked = harmonic_job(40.0, 3.0, contour=arc(10.0, 0.6, 0.6))
    u = raw_ics(asked.request(Level())).u[:3, :, : len(asked.points.x)]
    on_plane = asked.points.s == 0
    across = asked.points.x == 0
    for i, j in ((0, 1), (1, 0), (1, 2), (2, 1)):
        assert np.all(u[j, i][on_plane] == 0), (i, j)
    for i, j in ((0, 1), (1, 0), (0, 2), (2, 0)):
        assert np.all(np.abs(u[j, i][across]) < 1e-12 * np.max(np.abs(u))), (i, j)


def test_loads_of_both_c_ij_and_c_ji_are_solved():
    """Their estimates are pooled, whatever else is asked for."""

    def directions(components, engine=HARMONIC):
        asked = changed(replace(job(40.0, 1.0), components=components), engine=engine)
        return [load.direction for load in asked.loads]

    assert directions(("sn",)) == directions(("ns",)) == [1, 2]
    assert directions(("xn", "nn")) == [0, 2]
    assert directions(("nn",)) == [2]
    assert directions(("sn",), SOLID) == [2]  # a field each, as dear as the first


@pytest.mark.slow
def test_units_do_not_matter():
    """Millimetres and MPa, or metres and Pa."""
    asked = harmonic_job(40.0).request(Level())
    points = Points(np.array([0.0, 1.5]), np.array([0.3, 1.6]))
    u = []
    for length, stress in ((1.0, 1.0), (1e-3, 1e6)):
        body = Body(
            LOWER,
            arc(8.0 * length, 0.3, 0.6),
            Material(210e3 * stress, 0.28),
            Domain(40.0 * length, 40.0 * length),
        )
        loads = tuple(Load(Patch(0.3 * length, 0.4 * length), direction) for direction in range(3))
        scaled = Points(points.x * length, points.s * length)
        cells = Cells(0.1 * length, 0.3, 0.3)
        u.append(
            raw_ics(replace(asked, body=body, loads=loads, points=scaled, cells=cells)).u * length * stress
        )
    # Gmsh's mesh may differ by rounding: the mesh error of these coarse cells
    np.testing.assert_allclose(u[1], u[0], rtol=0, atol=1e-3 * np.max(np.abs(u[0])))


@pytest.mark.slow
def test_on_the_flank_of_a_wheel_the_patch_keeps_its_length():
    """R(s) is 15 % above R_roll there: close to a small patch it gives way as the half-space does."""
    body = Body(UPPER, arc(10.0, 0.9, 0.9), STEEL, Domain(40.0, 40.0), 20.0)
    assert body.surface.circle_radius(8.0) == pytest.approx(23.0, rel=0.01)
    patch, x = Patch(0.05, 0.04, 8.0), np.array([0.0, 0.05, 0.2])
    asked = harmonic_job(15.0).request(Level())
    points, load = Points(x, 0 * x + 8.0), (Load(patch, 2),)
    u = raw_ics(replace(asked, body=body, loads=load, points=points, cells=Cells(0.004, 0.4, 0.4))).u[0, 2]
    a = HalfSpace(one_body(STEEL, UPPER)).ics(patch, x, 0 * x)[2, 2] / patch.area
    np.testing.assert_allclose(u[:2] - u[2], a[:2] - a[2], rtol=0.01)  # 0.2 mm of radii of 10 and 23 mm


def test_displacements_without_responses_are_the_tail_of_the_half_space():
    """Component i under load j is that of the half-space: C_xn and C_nx differ in sign."""
    request = TASK.request
    solved = solve(request, workers=2)
    silent = replace(solved.samples, responses=np.zeros_like(solved.samples.responses))
    u = displacements(replace(solved, samples=silent), request.loads, request.points).u
    half_space, patch = HalfSpace(one_body(BODY.material, BODY.side)), request.loads[0].patch
    for point, (x, s) in enumerate(zip(request.points.x, request.points.s, strict=True)):
        beyond = tail(half_space, patch, request.k_max, np.array([x]))(s)[..., 0]
        for load, of_load in zip(request.loads, u, strict=True):
            np.testing.assert_allclose(of_load[:, point], beyond[:, load.direction], rtol=1e-9, atol=1e-18)
    assert np.max(np.abs(u[2, 0])) > 1e-3 * np.max(np.abs(u[2, 2]))  # x under n is not nothing


def test_responses_are_smooth_at_zero():
    """Even in k (or odd): what the interpolation assumes."""
    body = Body(LOWER, UNSYMMETRIC, STEEL, Domain(40.0, 40.0))
    section = section_mesh(body, SectionSize(BARE, np.array([[-0.3, 0.5]])))
    at = SectionSolver(section, [Load(Patch(0.3, 0.4, 0.1), 2)], np.array([1.0]))
    k = np.array([1e-4, 2e-4])
    zero, one, two = at([0.0, *k])[0][:, 0, 0, :, 0]
    assert zero[0] == 0
    assert two[0] / one[0] == pytest.approx(2, rel=1e-3)
    np.testing.assert_allclose((two - zero)[1:] / (one - zero)[1:], 4, rtol=1e-2)
