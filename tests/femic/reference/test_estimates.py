"""What says how accurate C is, on numbers made by hand: estimates, orders, scales, the worst of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from femic.reference import engine
from femic.reference.engine import Cost, Points, RawICs, Request, peak_memory
from femic.reference.engines import ENGINES, HARMONIC, SOLID
from femic.reference.harmonic.request import HIGHEST, tightening
from femic.reference.result import (
    EstimatedICs,
    combine,
    discounted,
    estimated,
    model_costs,
    orders_at,
    pooled,
    scales,
    shares,
    total,
    worst,
)
from femic.reference.run_options import HIGHER, Level, factors
from geometries.contours import arc
from geometries.patches import Patch
from tests.femic.reference.conftest import COARSE, JOB, changed, request_for

COST = Cost(1, 1, "none", (), 0.0, {}, 0.0)
RNG = np.random.default_rng(5)
EXACT = RNG.normal(size=(3, 3, 4))
ERROR = 0.01 * (EXACT + np.swapaxes(EXACT, 0, 1))  # alike for ij and ji
SAFETY = {"solid": 1.25, "harmonic": 2.0}


# --- the parts of an estimate ----------------------------------------------------------------------------


@pytest.mark.parametrize("engine", SAFETY)
def test_errors_of_the_assumed_orders_are_bounded_with_their_safety(engine):
    """Errors of coarse cells are 1.5^order times those of fine ones: the difference tells them."""
    ic, mesh, truncation = EXACT + ERROR, np.array([2, 1, 2, 1]), np.array([2, 2, 1, 1])
    less = {"coarser": EXACT + 1.5**mesh * ERROR, "nearer": EXACT + 2.0**truncation * ERROR}
    result = estimated(ic, less, safety=ENGINES[engine].safety, orders=(mesh, truncation))
    np.testing.assert_allclose(result.mesh_error, SAFETY[engine] * np.abs(ERROR))
    np.testing.assert_allclose(result.truncation_error, 1.25 * np.abs(ERROR))
    assert np.all(result.waves_error == 0)
    assert result.ic is ic


def test_parts_add_up_and_do_not_cancel():
    ic = EXACT + ERROR
    less = {"nearer": EXACT + 4 * ERROR, "sparser": EXACT + 32 * ERROR, "lower": EXACT - 1 * ERROR}
    result = estimated(ic, less | {"coarser": EXACT + 2.25 * ERROR}, safety=2.0)
    np.testing.assert_allclose(result.waves_error, 1.25 * 2 * np.abs(ERROR))  # 2 ERROR / (3 - 1): as above
    np.testing.assert_allclose(result.estimate, (2.0 + 1.25 + 2.5) * np.abs(ERROR))


def test_unsolved_components_are_nan_and_do_not_affect_their_transposes():
    error = np.abs(EXACT)
    error[:, 1] = np.nan
    result = pooled(error)
    assert np.all(np.isnan(result[:, 1]))
    np.testing.assert_array_equal(result[1, 0], error[1, 0])
    np.testing.assert_array_equal(result[0, 2], np.maximum(error[0, 2], error[2, 0]))


def test_the_mesh_part_is_pooled_the_truncation_is_not():
    """sn agrees on two meshes by luck, ns does not: sn is not believed to be better."""
    ic, other = EXACT.copy(), EXACT.copy()
    other[2, 1] += 0.25
    by_mesh = estimated(ic, {"coarser": other, "nearer": ic}, safety=2.0).mesh_error
    np.testing.assert_allclose(by_mesh[1, 2], 2.0 * 0.25 / 1.25)
    np.testing.assert_allclose(by_mesh[1, 2], by_mesh[2, 1])
    by_size = estimated(ic, {"coarser": ic, "nearer": other}, safety=2.0).truncation_error
    assert np.all(by_size[1, 2] == 0)
    np.testing.assert_allclose(by_size[2, 1], 1.25 * 0.25 / 3)


# --- where the orders are lower --------------------------------------------------------------------------

A, B, AT = 0.3, 0.5, 2.0  # outline +- 0.06
MESH = {  # x, s: order of the mesh error
    (0.0, AT): 2,
    (A, AT): 1,
    (-A, AT): 1,
    (A - 0.059, AT): 1,
    (A - 0.061, AT): 2,
    (A + 0.059, AT): 1,
    (A + 0.061, AT): 2,
    (0.0, AT + B): 1,
    (0.0, AT - B): 1,
    (0.0, AT + B - 0.059): 1,
    (0.0, AT + B - 0.061): 2,
    (0.0, AT - B - 0.059): 1,
    (0.0, AT - B - 0.061): 2,
    (-A, AT - B): 1,
    (A, AT + 3.0): 2,  # beside the patch, in line with its edge
    (3.0, AT + B): 2,
    (0.0, B): 2,  # the outline moves with the patch
}
FAR = 30.0
TRUNCATION = {  # a third of the far radius from the load on
    (0.0, AT): 2,
    (9.99, AT): 2,
    (-10.01, AT): 1,
    (0.0, AT + 9.99): 2,
    (0.0, AT - 9.99): 2,
    (0.0, AT + 10.01): 1,
    (0.0, AT - 10.01): 1,
    (6.0, AT + 7.99): 2,
    (6.0, AT + 8.01): 1,
}


@pytest.mark.parametrize(("part", "orders"), [(0, MESH), (1, TRUNCATION)], ids=["mesh", "truncation"])
def test_errors_fall_slowly_on_the_outline_of_the_patch_and_close_to_the_far_arc(part, orders):
    result = orders_at(Patch(A, B, AT), Points(*np.array(list(orders)).T), FAR)[part]
    assert dict(zip(orders, result.tolist(), strict=True)) == orders


def made_up(job, u_of):
    """Models of a job that nobody solved: displacements by a function of cells and domain."""
    models = Level().models(job.settings.engine.models).values()
    loads, n = job.request(Level()).loads, len(job.request(Level()).points.x)
    exact, error = np.random.default_rng(8).normal(size=(2, len(loads), 3, n))
    return {level: RawICs(exact + u_of(*factors(level)) * error, COST) for level in models}


@pytest.mark.parametrize("level", [0, 1])
def test_c_is_estimated_with_these_orders_in_the_domain_of_its_level(level):
    """Points between 40 / 3 and 80 / 3 mm from the load are close to the arc of 40 mm, not to that of 80."""
    x = np.array([1.0, 14.0, 24.0])  # from the load
    points = Points(x, np.zeros_like(x))
    job = replace(JOB, points=points, lines={"x": slice(0, 3)}, components=("nn",))
    models = made_up(job, lambda _, domain: 1 / domain)
    models = {replace(one, domain=one.domain + level): raw for one, raw in models.items()}
    result = combine(job, Level(domain=level), models)
    gain = np.array([3, 3, 3]) if level else np.array([3, 1, 1])  # 2^order - 1
    coarse, small = models[Level(-1, level)].u, models[Level(-1, level - 1)].u
    apart = discounted_difference(job, coarse, small)
    np.testing.assert_allclose(result.c.truncation_error[2, 2] * gain, 1.25 * apart, rtol=1e-9)


def discounted_difference(job, one, other):
    return np.abs(discounted(job, one)[0] - discounted(job, other)[0])[2, 2]


@pytest.mark.parametrize(
    ("part", "share"),
    [("mesh_error", lambda cells, _: cells**2), ("truncation_error", lambda _, domain: domain**-2)],
)
def test_estimates_are_a_quarter_above_errors_of_second_order(part, share):
    """Those of a job, of the one column that was requested."""
    models = made_up(JOB, share)
    c, (truth, *_) = combine(JOB, Level(), models).c, discounted(JOB, made_up(JOB, lambda *_: 0)[Level()].u)
    np.testing.assert_allclose(getattr(c, part), 1.25 * np.abs(c.ic - truth), atol=1e-12)
    np.testing.assert_allclose(c.estimate, getattr(c, part), atol=1e-12)
    assert np.all(np.isfinite(c.ic[:, 2]))
    assert np.all(np.isnan(c.ic[:, :2]))


# --- how accurately wavenumbers are asked for, first cells -------------------------------------------------


def asked(tolerance, scale, waves):
    """The harmonic engine's request for a model of a tolerance, a least scale and refined wavenumbers."""
    return HARMONIC.request(Request(JOB.body, JOB.loads, JOB.points, COARSE, "auto", tolerance, scale, waves))


@pytest.mark.parametrize("waves", [0, 1, 3])
def test_the_interpolation_takes_half_of_the_tolerance_and_gains_32_a_level(waves):
    tight, loose, looser = (asked(tolerance, 3.0, waves).accuracy for tolerance in (0.004, 0.01, 1.0))
    assert tight == pytest.approx(0.5 * 0.004 * 3.0 / 32**waves)
    assert loose == looser


@pytest.mark.parametrize(("tolerance", "larger"), [(0.1, 1), (1e-3, 1), (1.25e-4, 2), (1e-6, 10)])
def test_the_largest_wavenumber_grows_by_the_cube_root_of_the_tolerance_and_doubles_a_level(
    tolerance, larger
):
    assert HIGHER == 2
    for waves in (0, 1, 2):
        assert asked(tolerance, 1.0, waves).highest == pytest.approx(larger * 2**waves * HIGHEST)


@pytest.mark.parametrize(("radius", "larger"), [(100.0, 1.0), (2.0, 2.0)])
def test_the_largest_wavenumber_grows_with_the_root_of_the_curvature_under_the_load(radius, larger):
    """From elements on, the half-side of which is a twentieth of the radius."""
    request = HARMONIC.request(request_for(arc(radius, 0.5, 0.5), patch=Patch(0.4, 0.3)))
    assert request.k_max == pytest.approx(larger * request.highest / 0.3, rel=1e-3)


def test_peak_memory_is_about_the_same_by_the_state_of_the_process_and_by_its_usage(monkeypatch):
    by_state = peak_memory()
    assert 20 < by_state < 20_000  # MB, of Python and its libraries
    monkeypatch.setattr(engine, "STATE", Path("nowhere"))
    assert 0.5 * by_state < peak_memory() < 4 * by_state  # of what started this one, where that was larger


def test_accuracy_of_wavenumbers_follows_the_line_with_the_least_displacements():
    """A twentieth of the largest A_nn there, a point load's: (1 - nu) / (2 pi G r)."""
    x = np.array([3.0, -5.0, 8.0, 40.0, -20.0])
    lines = {"near": slice(0, 3), "far": slice(3, 5)}
    job = changed(replace(JOB, points=Points(x, 0 * x), lines=lines), engine=HARMONIC, tolerance=0.004)
    material = JOB.body.material
    least = (1 - material.nu) / (2 * np.pi * material.G * 20.0) / 20
    asked = job.request(Level())
    assert asked.accuracy == pytest.approx(0.5 * 0.004 * least, rel=1e-3)
    assert asked.highest == pytest.approx(2 * np.pi)
    assert job.request(Level(waves=1)).highest == pytest.approx(4 * np.pi)


def test_how_much_tighter_than_tuned():
    assert [tightening(t) for t in (1.0, 1e-3, 5e-4)] == [1, 1, 2]
    assert HARMONIC.far_radius(1e-3 / 4) == pytest.approx(2 * HARMONIC.far_radius(1e-3))
    assert HARMONIC.far_radius(1.0) == HARMONIC.far_radius(1e-3)
    assert SOLID.far_radius(1e-4) == SOLID.far_radius(1.0)


@pytest.mark.parametrize(("engine", "tuned", "smallest"), [("solid", 0.01, 0.2), ("harmonic", 0.001, 0.5)])
def test_first_cells_follow_the_cube_root_of_the_tolerance(engine, tuned, smallest):
    """The solid engine resolves both sides of the patch, the harmonic one that along s."""
    patch, first_cells = Patch(0.2, 0.5), ENGINES[engine].first_cells
    at_tuned, finer = (first_cells(t, patch) for t in (tuned, tuned / 8))
    assert at_tuned.smallest == pytest.approx(smallest / 12)
    assert finer == at_tuned.scaled(0.5)
    assert first_cells(1.0, patch) == at_tuned.scaled({"solid": 3.0, "harmonic": 1.5}[engine])


# --- scales, shares, the worst -----------------------------------------------------------------------------

LINES = {"one": slice(0, 2), "other": slice(2, 5)}
TWO = replace(JOB, points=Points(np.arange(1.0, 6.0), np.zeros(5)), lines=LINES, components=("nn", "sn"))


def ics(**curves):
    """ICs (3, 3, 5), 0 but for some components."""
    result = np.zeros((3, 3, 5))
    for name, values in curves.items():
        result["xsn".index(name[0]), "xsn".index(name[1])] = values
    return result


def test_scales_are_of_each_line_by_itself_and_at_least_a_twentieth_of_c_nn_where_that_was_solved():
    result = scales([TWO], ics(nn=[4, -8, 2, 1, -1], sn=[-3, 1, 0, 1.5, -1]))
    assert (result["one"][2, 2], result["other"][2, 2]) == (8, 2)
    assert (result["one"][1, 2], result["other"][1, 2]) == (3, 1.5)
    small = ics(nn=[4, -8, 2, 1, -1], sn=0.01)
    result = scales([TWO], small)
    assert (result["one"][1, 2], result["other"][1, 2]) == pytest.approx((0.05 * 8, 0.05 * 2))
    small[2, 2] = np.nan
    a_nn = np.abs(TWO.half_space_nn[TWO.lines["one"]])
    assert scales([TWO, TWO], small)["one"][1, 2] == pytest.approx(max(0.01, 0.05 * 2 * np.max(a_nn)))


def test_where_nn_was_not_solved_small_components_are_judged_by_that_of_a_point_load():
    """Boussinesq: (1 - nu) / (2 pi G r), of which the floor is a twentieth."""
    ic = np.full((3, 3, len(JOB.points.x)), np.nan)
    ic[0, 0] = 0.0
    material, r = JOB.body.material, np.hypot(JOB.points.x, JOB.points.s)
    nn = (1 - material.nu) / (2 * np.pi * material.G * r)
    for line, part in JOB.lines.items():  # patches are small against r
        assert scales([JOB], ic)[line][0, 0] == pytest.approx(0.05 * nn[part].max(), rel=0.03)


def test_variations_of_a_model_are_discounted_like_c():
    """Wavenumbers and the far arc change the displacements where M is fitted, too."""
    job = changed(replace(JOB, components=("nn",)), engine=HARMONIC)
    models = made_up(job, lambda *_: 0.0)
    fine = models[Level()]
    noise = np.random.default_rng(3).normal(size=fine.u.shape)
    weights = {"nearer": 0.1, "sparser": 0.2, "lower": 0.3, "coarser": 0.4}
    less = {name: fine.u + weight * noise for name, weight in weights.items()}
    result = combine(job, Level(), models | {Level(): replace(fine, perturbed=less)}).c
    off = {name: discounted_difference(job, fine.u, u) for name, u in less.items()}
    far = orders_at(job.patch, job.points, job.body.domain.far_radius)[1]
    np.testing.assert_allclose(result.truncation_error[2, 2], 1.25 * off["nearer"] / (2.0**far - 1))
    np.testing.assert_allclose(result.waves_error[2, 2], 1.25 * (off["sparser"] / 31 + off["lower"] / 2))
    np.testing.assert_allclose(result.mesh_error[2, 2], 2.0 * off["coarser"] / (1.5**2 - 1))


def test_loads_that_only_m_needs_are_no_columns_of_c():
    """Beside the contact centre M is fitted with loads at it: more are solved than were asked for."""
    job = replace(JOB, patch=replace(JOB.patch, s=1.0), components=("sn",))
    assert len(job.solved_loads) > len(job.loads) == 1
    n = len(job.request(Level()).points.x)
    u = np.random.default_rng(4).normal(size=(len(job.solved_loads), 3, n))
    ic, raw, _ = discounted(job, u)
    np.testing.assert_array_equal(raw[:, 2], u[0, :, : len(job.points.x)])
    assert np.all(np.isnan(ic[:, :2]))


def test_the_worst_is_that_of_what_was_asked_with_its_name():
    scale = {"one": np.ones((3, 3)), "other": np.ones((3, 3))}
    error = ics(xx=9.0, nn=[0.1, 0.2, 0.3, 0, 0], sn=[0, 0.35, 0, -0.4, 0])
    assert worst(TWO, error, scale) == (0.4, "sn", "other")
    assert worst(TWO, error, scale | {"other": np.full((3, 3), 2.0)}) == (0.35, "sn", "one")
    assert worst(replace(TWO, components=("nn",)), error, scale) == (0.3, "nn", "other")
    error[2, 2, 1] = np.nan
    assert worst(TWO, error, scale) == (np.inf, "nn", "one")


def test_shares_are_those_of_each_part_and_of_their_sum():
    """Parts are worst at different points: the sum is that of one point, not of the worst parts."""
    scale = {"one": np.full((3, 3), 2.0), "other": np.ones((3, 3))}
    mesh, size = ics(nn=[0.4, 0, 0, 0, 0]), ics(nn=[0.1, 0.5, 0, 0, 0])
    waves = ics(sn=[0, 0, 0, 0, 0.15])
    result = shares(TWO, EstimatedICs(0 * mesh, mesh, size, waves), scale)
    assert (result.mesh, result.truncation, result.waves) == (0.2, 0.25, 0.15)
    assert (result.total, result.component, result.line) == (0.25, "nn", "one")


def test_bodies_add_up_and_so_do_their_estimates():
    """Opposite ICs cancel, errors do not."""
    parts = np.arange(1.0, 5.0)[:, None, None, None] * np.ones((4, 3, 3, 2))
    one, other = EstimatedICs(*parts), EstimatedICs(-parts[0], *parts[1:])
    both = total([one, other])
    assert np.all(both.ic == 0)
    np.testing.assert_array_equal(both.errors, 2 * parts[1:])
    np.testing.assert_array_equal(total([one]).errors, parts[1:])
    other.ic[0, 0] = np.nan
    assert np.all(np.isnan(total([one, other]).ic[0, 0]))
    assert np.all(np.isfinite(total([one, other]).ic[1, 1]))


def test_costs_are_named_and_those_of_earlier_rounds_are_counted():
    models = {Level(cells=k): RawICs(np.empty(0), replace(COST, unknowns=k)) for k in (-1, 0, 1, 2)}
    costs = model_costs(Level(cells=2).models(("fine", "coarse")), models)
    unknowns = {name: cost.unknowns for name, cost in costs.items()}
    assert unknowns == {"fine": 2, "coarse": 1, "earlier 1": -1, "earlier 2": 0}
