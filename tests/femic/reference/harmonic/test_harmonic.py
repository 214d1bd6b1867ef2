"""The harmonic engine: the half-space, the ball, the solid engine, and what elasticity demands."""

from dataclasses import replace

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from approx.variants import approximate
from femic.reference.engine import Points
from femic.reference.engines import HARMONIC, SOLID
from femic.reference.harmonic.section import SectionSize, section_mesh
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.meshing import Cells
from femic.reference.result import combine, discounted
from femic.reference.run_options import MODELS, Level
from femic.reference.solid.engine import raw_ics as solid_raw_ics
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.materials import Material, one_body
from geometries.patches import COMPONENTS, Load, Patch, places
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import STEEL, UNSYMMETRIC, assert_honest, changed, line_errors
from tests.femic.reference.harmonic.fields import raw_ics
from tests.femic.reference.solid import test_sphere as sphere
from tests.femic.reference.solid.test_flat import LINES, OTHERS, halfspace, job, shares

DEFAULT = Cells(0.03, 0.4, 0.4)
BARE = Cells(0.1, 0.5, 0.5)


def harmonic(asked, factor=1.0):
    """The same by the harmonic engine, cells `factor` times those for a tolerance of 0.1 %."""
    return changed(asked, engine=HARMONIC, cells=DEFAULT.scaled(factor), tolerance=1e-3)


def reference(asked):
    return combine(asked, Level(), {Level(): raw_ics(asked.request(Level()))})


# --- coarser cells ---------------------------------------------------------------------------------


@pytest.mark.slow  # the estimates that it serves: test_estimates_bound_the_errors
def test_coarser_cells_at_some_wavenumbers_give_the_error_of_all_wavenumbers():
    """The change is interpolated: it differs by less than 2 % from that of a whole model."""
    request = harmonic(job(40.0, 1.0), 2.0).request(Level())
    model, coarser = raw_ics(request), raw_ics(request.coarser)
    change = model.perturbed["coarser"] - model.u
    assert coarser.cost.unknowns < model.cost.unknowns
    assert np.max(np.abs(change)) < 1e-2 * np.max(np.abs(model.u))
    np.testing.assert_allclose(change, coarser.u - model.u, rtol=0, atol=2e-2 * np.max(np.abs(change)))


# --- the half-space ----------------------------------------------------------------------------------


@pytest.mark.parametrize("side", [pytest.param(LOWER, marks=pytest.mark.slow), UPPER])
def test_all_nine_components_are_the_half_space_also_on_the_element(side):
    """1e-3 of the line's scale four elements away and more, 5e-3 of the local value nearer."""
    near = np.array([0.0, 0.1, 0.4, 0.8, 1.2, 2.0])
    asked = harmonic(job(1280.0, 1.0, side=side), 1.6)
    own = Points(np.append(asked.points.x, near), np.append(asked.points.s, 0 * near))
    asked = replace(asked, points=own)
    model = raw_ics(asked.request(Level()))
    result, a = discounted(asked, model.u)[0], halfspace(asked)
    assert model.cost.unknowns <= 30_000
    far = np.hypot(asked.points.x, asked.points.s) >= 4 * 0.6
    for part in LINES:
        chosen = np.arange(len(far))[part][far[part]]
        assert np.all(line_errors((result - a)[..., chosen], a[..., part], a[2, 2, part]) < 1e-3)
    local = (result - a)[..., -len(near) :] / a[2, 2, -len(near) :]
    assert np.max(np.abs(local)) < 5e-3


@pytest.mark.slow
def test_error_falls_at_least_like_h_cubed():
    factors = np.array([2.2, 1.6, 1.2])
    rms = []
    for factor in factors:
        asked = changed(harmonic(job(10_000.0, 1.0), factor), tolerance=1e-4)
        a = halfspace(asked)
        result = discounted(asked, raw_ics(asked.request(Level())).u)[0]
        rms.append(np.sqrt(np.mean(shares(result - a, a) ** 2)))
    assert np.polyfit(np.log(factors), np.log(rms), 1)[0] > 3


@pytest.mark.slow
def test_error_falls_about_like_the_square_of_the_domain():
    sizes, off = np.array([40.0, 80.0, 160.0]), []
    for size in sizes:
        asked = changed(harmonic(job(size, 1.0)), rotation_reach=5.0)
        off.append(
            shares(
                discounted(asked, raw_ics(asked.request(Level())).u)[0] - halfspace(asked), halfspace(asked)
            )
        )
    for i, j in ((0, 2), (2, 0), (1, 2)):  # the components in which truncation dominates
        rate = -np.polyfit(np.log(sizes), np.log([errors[i, j] for errors in off]), 1)[0]
        assert rate == pytest.approx(2, abs=0.3), (i, j)


@pytest.mark.parametrize(
    ("nu", "components"),
    [
        pytest.param(0.0, COMPONENTS, marks=pytest.mark.slow),
        pytest.param(0.4999, COMPONENTS, marks=pytest.mark.slow),
        (0.4999, ("nn",)),
    ],
)
def test_poisson_s_ratio_may_come_close_to_one_half(nu, components):
    """No locking: as accurate as the truncation lets it be."""
    asked = replace(harmonic(job(2560.0, 1.0, material=Material(210e3, nu)), 1.3), components=components)
    model = raw_ics(asked.request(Level()))
    a = halfspace(asked)
    assert np.max(shares(discounted(asked, model.u)[0] - a, a)[places(components)]) < 1e-3
    assert model.cost.residual < 1e-7


@pytest.mark.slow  # estimates of a patch of few aspects: test_estimates_bound_the_errors
@pytest.mark.parametrize(("a", "b"), [(0.02, 2.0), (0.2, 2.0), (2.0, 0.02)])
def test_slender_patches(a, b):
    patch = Patch(a, b)
    base = harmonic(job(640.0, 1.0))
    asked = replace(base, patch=patch, points=Points(base.points.x, base.points.s))
    asked = changed(asked, cells=Cells(b / 5, 0.4, 0.4), tolerance=5e-3)
    result, exact = reference(asked), halfspace(asked)
    assert np.all(shares(result.c.ic - exact, exact) <= shares(result.c.estimate, exact))
    assert np.max(shares(result.c.estimate, exact)) < 5e-3


PLANES = ((80.0, 1.25), (640.0, 1.0))  # size of the domain, cells


def errors_and_estimates(asked):
    result, a = reference(asked), halfspace(asked)
    return shares(result.c.ic - a, a), shares(result.c.estimate, a)


@pytest.mark.parametrize(("size", "factor"), [PLANES[0], pytest.param(*PLANES[1], marks=pytest.mark.slow)])
def test_estimates_bound_the_errors(size, factor):
    error, estimate = errors_and_estimates(harmonic(job(size, 1.0), factor))
    assert np.all(error <= estimate)


@pytest.mark.slow
def test_estimates_bound_the_errors_and_are_at_most_ten_times_them():
    jobs = [harmonic(job(size, 1.0), factor) for size, factor in PLANES]
    jobs += [harmonic(job(320.0, 1.0, **changes)) for changes in OTHERS.values()]
    assert_honest([errors_and_estimates(asked) for asked in jobs])


# --- bodies of revolution ------------------------------------------------------------------------------


@pytest.mark.parametrize(("side", "s"), [(UPPER, 0.0), pytest.param(LOWER, 40.0, marks=pytest.mark.slow)])
def test_the_ball_is_known_to_the_estimate(side, s):
    asked = harmonic(sphere.ball(160.0, 1.0, side, s=s), 2.2)
    truth, result = sphere.exact(asked), reference(asked)
    error, estimate = (
        np.max([line_errors(d[..., p], truth[..., p], truth[2, 2, p]) for p in LINES], axis=0)
        for d in (result.c.ic - truth, result.c.estimate)
    )
    assert np.all(error <= estimate), error / estimate


@pytest.mark.slow
def test_prismatic_is_the_limit_of_a_large_wheel_with_a_difference_like_1_over_r():
    radii = np.array([1e3, 2e3, 4e3])
    crown = {"side": UPPER, "contour": arc(10.0, 0.4, 0.4)}
    asked = [harmonic(job(80.0, 1.0, rolling_radius=R, **crown), 2.0) for R in radii]
    straight = harmonic(job(80.0, 1.0, **crown), 2.0)
    c = discounted(straight, raw_ics(straight.request(Level())).u)[0]
    off = [np.max(np.abs(discounted(j, raw_ics(j.request(Level())).u)[0] - c), axis=-1)[0, 2] for j in asked]
    assert np.polyfit(np.log(radii), np.log(off), 1)[0] == pytest.approx(-1, abs=0.1)


@pytest.mark.slow  # of all components: test_the_ball_is_known_to_the_estimate
def test_xn_of_a_wheel_has_the_longitudinal_curvature_of_b_hat():
    """A plane rolled up: what it adds to C_xn and C_nx is what turns A into B-hat, up to a tenth.

    Both alike, as reciprocity demands: C_nx = -C_xn on the line of the load.
    """
    x = np.array([1.0, 2.0, 5.0, 10.0])
    plane_one = replace(
        harmonic(job(640.0, 1.0, side=UPPER), 2.0),
        points=Points(x, 0 * x),
        lines={"x": slice(None)},
        components=("xn", "nx"),
    )
    wheel = replace(plane_one, body=replace(plane_one.body, rolling_radius=500.0))
    on_plane, on_wheel = (discounted(j, raw_ics(j.request(Level())).u)[0] for j in (plane_one, wheel))
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
    asked = harmonic(job(60.0, 1.0)).request(Level())
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
    result = combine(
        solid, Level(), {m: solid_raw_ics(solid.request(m)) for m in Level().models(MODELS).values()}
    )
    other = reference(harmonic(solid, 2.0))
    scale = result.c.ic
    off, known = (shares(v, scale) for v in (result.c.ic - other.c.ic, result.c.estimate + other.c.estimate))
    assert np.all(off <= known), off / known


# --- parts of sections, symmetry, units ---------------------------------------------------------------


def test_what_vanishes_by_symmetry_vanishes():
    asked = harmonic(job(40.0, 1.0, contour=arc(10.0, 0.6, 0.6)), 3.0)
    u = raw_ics(asked.request(Level())).u[:3, :, : len(asked.points.x)]
    on_plane = asked.points.s == 0
    across = asked.points.x == 0
    for i, j in ((0, 1), (1, 0), (1, 2), (2, 1)):
        assert np.all(u[j, i][on_plane] == 0), (i, j)
    for i, j in ((0, 1), (1, 0), (0, 2), (2, 0)):
        assert np.all(np.abs(u[j, i][across]) < 1e-12 * np.max(np.abs(u))), (i, j)


def test_threads_do_not_change_the_result():
    asked = harmonic(job(40.0, 1.0), 3.0).request(Level())
    counted = []
    alone = raw_ics(asked)
    together = raw_ics(asked, workers=3, progress=counted.append)
    np.testing.assert_allclose(together.u, alone.u, rtol=0, atol=1e-12 * np.max(np.abs(alone.u)))
    assert counted == list(range(len(counted)))  # 0: assembled
    n = int(together.cost.solver.split(", ")[1].split()[0])
    assert n < len(counted) - 1 < 2 * n  # all wavenumbers, then some of them with coarser cells


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
    asked = harmonic(job(40.0, 1.0)).request(Level())
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


@pytest.mark.slow
def test_on_the_flank_of_a_wheel_the_patch_keeps_its_length():
    """R(s) is 15 % above R_roll there: close to a small patch it gives way as the half-space does."""
    body = Body(UPPER, arc(10.0, 0.9, 0.9), STEEL, Domain(40.0, 40.0), 20.0)
    assert body.surface.circle_radius(8.0) == pytest.approx(23.0, rel=0.01)
    patch, x = Patch(0.05, 0.04, 8.0), np.array([0.0, 0.05, 0.2])
    asked = harmonic(job(15.0, 1.0)).request(Level())
    points, load = Points(x, 0 * x + 8.0), (Load(patch, 2),)
    u = raw_ics(replace(asked, body=body, loads=load, points=points, cells=Cells(0.004, 0.4, 0.4))).u[0, 2]
    a = HalfSpace(one_body(STEEL, UPPER)).ics(patch, x, 0 * x)[2, 2] / patch.area
    np.testing.assert_allclose(u[:2] - u[2], a[:2] - a[2], rtol=0.01)  # 0.2 mm of radii of 10 and 23 mm
