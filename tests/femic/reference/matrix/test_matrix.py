"""The IC matrix: the half-space, single loads, reciprocity, definiteness, the circular contour."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.contact.operators.dense import GridOperator, reciprocity_defects
from femic.reference.discount import generalized, rigid_part
from femic.reference.engine import Points
from femic.reference.engines import HARMONIC, HarmonicEngine
from femic.reference.harmonic.engine import solve
from femic.reference.harmonic.synthesis import columns, displacements
from femic.reference.job import Job, Settings
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import assess_matrices, column_scale, column_shares, matrices
from femic.reference.refinement import references
from femic.reference.result import estimated
from femic.reference.run_options import Level, RunOptions
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.materials import one_body
from geometries.patches import COMPONENTS, Grid, Load
from geometries.surfaces import LOWER, UPPER
from tests.coarse import SIZES, coarse_sections
from tests.femic.reference.conftest import STEEL, changed

GRID = Grid(10, 8, 0.4, 0.4)
REACH, ARM = 12.0, 3.0
ROUGH = 0.03  # tolerance of C where nothing is said of its error
FAIR_STRIPS = {  # coarse elsewhere: reciprocity of a strip under another demands cells within both
    **SIZES,
    (HarmonicEngine, "cells_per_half_strip"): 1.2,
    (HarmonicEngine, "growth_on_strips"): 0.5,
}


def matrix_job(side, contour, grid=GRID, radius=np.inf, tolerance=1e-3):
    """After the source's discount C is comparable with ICs of half-spaces, and with single loads."""
    body = Body(side, contour, STEEL, Domain(HARMONIC.far_radius(tolerance, grid), np.inf), radius)
    settings = Settings(HARMONIC, tolerance, rotation_reach=REACH, moment_arm=ARM)
    return MatrixJob(body, grid, settings, discounts=("source", "approach"))


def solved(jobs, *, combined=False):
    return matrices(jobs, RunOptions(2), combined=combined)


@pytest.fixture(scope="module", params=[1e-2, pytest.param(1e-3, marks=pytest.mark.slow)])
def on_plane(request):
    job = matrix_job(LOWER, plane(), tolerance=request.param)
    with coarse_sections(FAIR_STRIPS) if request.param > 1e-3 else nullcontext():
        return solved({"lower": job})["lower"]


@pytest.fixture(
    scope="module",
    params=[("lower",), pytest.param(("lower", "upper"), marks=pytest.mark.slow)],
    ids=["rail", "both"],
)
def on_arcs(request):
    """A rail and a wheel of some radius with arcs continued by flanks, whose joints lie within the grid."""
    flank = 0.12
    jobs = {
        "lower": matrix_job(LOWER, arc(10.0, flank, flank), tolerance=ROUGH),
        "upper": matrix_job(UPPER, arc(10.2, flank, flank), radius=300.0, tolerance=ROUGH),
    }
    with coarse_sections(FAIR_STRIPS) if len(request.param) == 1 else nullcontext():
        return solved({name: jobs[name] for name in request.param}, combined=True)


def all_columns(result, *, raw=False):
    """(lag, observing strip, loaded strip, i, j)."""
    made = [result.raw_column(m) if raw else result.column(m).ic for m in range(result.job.grid.n_s)]
    return np.moveaxis(np.stack(made), (0, 1, 2, 3, 4), (2, 3, 4, 0, 1))


# --- the half-space ----------------------------------------------------------------------------------


def test_on_a_plane_it_is_the_half_space_for_all_lags_and_strips(on_plane):
    job, half_space = on_plane.job, HalfSpace(one_body(STEEL, LOWER))
    tolerance = job.settings.tolerance
    for strip in range(GRID.n_s):
        c = on_plane.column(strip)
        a = (
            half_space.ics(GRID.patch(strip), GRID.lags[:, None], GRID.strips - GRID.strips[strip])
            / GRID.area
        )
        scale = column_scale(strip, a, [job])
        assert np.max(np.abs(c.ic - a) / scale) < tolerance
        assert column_shares(strip, c, scale).total < tolerance
        own = np.abs(c.ic - a)[:, :, 0, strip] / a[2, 2, 0, strip]
        assert np.max(own) < 5 * tolerance
        for i, j in np.ndindex(3, 3):  # the estimate covers the error, component by component
            error, estimate = (np.max(np.abs(v)[i, j] / scale[i, j]) for v in (c.ic - a, c.estimate))
            assert error <= 1.5 * estimate, (strip, i, j)


# --- lags, single loads --------------------------------------------------------------------------------


SQUARE = Grid(4, 4, 1.0, 1.0)
NARROW = Grid(2, 4, 0.2, 0.637)  # the half-space reaches one or two strips, as the radius of the load is


@pytest.mark.parametrize(
    ("grid", "radius"),
    [
        pytest.param(SQUARE, np.inf, marks=pytest.mark.slow),
        pytest.param(SQUARE, 300.0, marks=pytest.mark.slow),
        pytest.param(SQUARE, 25.0, marks=pytest.mark.slow),
        (NARROW, 20.0),
    ],
)
def test_lags_are_points(grid, radius, monkeypatch):
    """The interpolation between radii against the sum at each point, to 1e-9 of the element's own.

    Both sums end at the same wavenumber.
    """
    monkeypatch.setattr("femic.reference.harmonic.synthesis.COLUMNS_NEED", 1.0)
    job = matrix_job(UPPER, arc(10.0, 0.6, 0.6), grid, radius, ROUGH)
    with coarse_sections():
        model = solve(job.request(Level(cells=-2)), workers=2)
    x, s = (v.ravel() for v in np.meshgrid(job.grid.lags, job.grid.strips, indexing="ij"))
    for name, by_lag in columns(model, job.grid, COMPONENTS).items():
        for strip in (0, 2, 3):
            loads = job.strip_loads[3 * strip : 3 * strip + 3]
            at_points = displacements(model, loads, Points(x, s))
            u = at_points.perturbed[name] if name else at_points.u
            column = np.moveaxis(by_lag(strip).reshape(3, 3, -1), 0, 1)
            np.testing.assert_allclose(column, u, atol=1e-9 * np.max(np.abs(u)))


@pytest.mark.slow
@pytest.mark.parametrize("strip", [1, 4])
def test_single_loads_are_columns(on_arcs, strip):
    """C of one load by its own models, fine at the edges of the patch, within both estimates."""
    lags = np.arange(1, GRID.n_x)
    for result in on_arcs.values():
        job, column = result.job, result.column(strip)
        observed = [0, 3, 6]
        x, s = (v.ravel() for v in np.meshgrid(GRID.lags[lags], GRID.strips[observed], indexing="ij"))
        names = [i + j for i in "xsn" for j in "xsn"]
        single = Job(
            replace(job.body, domain=Domain(1280.0, np.inf)),
            GRID.patch(strip),
            tuple(names),
            Points(x, s),
            {f"{m}": slice(m, None, len(observed)) for m in observed[:1]},
            Settings(HARMONIC, rotation_reach=REACH, moment_arm=ARM),
        )
        own = references({"lower": single}, RunOptions(2))["lower"].c
        at = np.ix_(range(3), range(3), lags, observed)
        together = [getattr(column, part)[at].reshape(3, 3, -1) for part in ("ic", "estimate")]
        nn = np.max(np.abs(own.ic[2, 2]))
        off = np.max(np.abs(own.ic - together[0]), axis=-1)
        allowed = np.max(own.estimate + together[1], axis=-1)
        assert np.all(off <= allowed), (off / allowed, nn)


def test_estimates_are_those_of_variations_after_their_own_discount(on_arcs):
    """Each variation of the model has an M of its own, which is subtracted from its columns."""
    for result in on_arcs.values():
        c, names = result.column(2), ("nearer", "coarser", "sparser", "lower")
        perturbed = {name: result.paired_column(2, name) for name in names}
        expected = estimated(c.ic, perturbed, safety=HARMONIC.safety)
        raw_changes = [result.raw_column(2) - result.raw_column(2, name) for name in names]
        # changes are kept in single precision
        rounding = np.finfo(np.float32).eps * np.max(np.abs(raw_changes))
        for ours, error in zip(c.errors, expected.errors, strict=True):
            np.testing.assert_allclose(ours, error, rtol=0, atol=1e-4 * np.max(error) + rounding)


def test_a_wheel_turns_between_the_lags_of_its_discount():
    """What is subtracted is D of M at each element: on a wheel not the same at all lags."""
    job = matrix_job(UPPER, arc(10.2, 0.12, 0.3), Grid(4, 3, 2.0, 0.4), 60.0, ROUGH)
    job = changed(job, tolerance=1.0, cells=job.first_cells.scaled(3.0))  # how accurate C is does not matter
    with coarse_sections():
        result, strip = solved({"upper": job})["upper"], 1
    x, s = (v.ravel() for v in np.meshgrid(job.grid.lags, job.grid.strips, indexing="ij"))
    taken = (result.raw_column(strip) - result.column(strip).ic).reshape(3, 3, -1)
    for direction in range(3):
        load = Load(job.grid.patch(strip), direction)
        expected = rigid_part(result.discount, job.body, Points(x, s), load)
        np.testing.assert_allclose(taken[:, direction], expected, atol=1e-12 * np.max(np.abs(taken)))


@pytest.mark.slow
def test_a_refined_model_agrees_with_its_first_one_within_the_estimate(on_plane):
    """The driver refines what is not accurate enough: here it is asked for more than it starts with."""
    job = changed(on_plane.job, cells=on_plane.cells.scaled(1.8), tolerance=4e-4)
    finer = solved({"lower": job})["lower"]
    assert finer.level.cells > 0
    assert assess_matrices({"lower": job}, {"lower": finer}, combined=False).own["lower"].total <= 4e-4


def test_supports_are_where_they_should_be_however_large_their_cells_are():
    """A far arc of two chords instead of three changed C by three times what the estimates allow.

    The far arc is a support, a part of C: no variation of the model shows its error.
    """
    body = Body(LOWER, arc(10.0, 1.2, 1.2), STEEL, Domain(300.0, np.inf))
    job = MatrixJob(body, Grid(4, 4, 0.4, 0.4), Settings(HARMONIC, 1e-3), discounts=("none",))
    smaller = replace(job.first_cells, growth=job.first_cells.growth / 1.5)
    coarse, fine = (solved({"lower": asked})["lower"] for asked in (job, changed(job, cells=smaller)))
    c, finer = coarse.column(0), fine.column(0)
    scale = column_scale(0, c.ic, [job])
    assert np.max(np.abs(c.ic - finer.ic) / scale) <= np.max((c.estimate + finer.estimate) / scale)


# --- what elasticity demands -----------------------------------------------------------------------------


def test_reciprocity_of_the_raw_matrix_and_of_the_discounted_one(on_plane, on_arcs):
    """On a plane within the estimate. On arcs, observed at centres, also by the curvature across a strip.

    Shares are those of each component's own largest value.
    """
    estimate = np.max([on_plane.column(m).estimate for m in range(GRID.n_s)], axis=(0, 3, 4))
    raw = all_columns(on_plane, raw=True)
    sizes = np.max(np.abs(raw), axis=(0, 1, 2))
    assert np.all(reciprocity_defects(raw).max(axis=(0, 1)) * sizes <= 2 * estimate)
    for result in (on_plane, *on_arcs.values()):
        raw, discounted = (all_columns(result, raw=raw) for raw in (True, False))
        defects = reciprocity_defects(raw).max(axis=(0, 1))
        assert np.diag(defects).max() < 2e-3
        assert defects.max() < 2e-2  # of sn, which is ten times smaller than ss and nn: joints lie in strips
        rigid = raw - discounted
        sizes = np.max(np.abs(rigid), axis=(0, 1, 2))
        rounding = 1e-10 * np.max(sizes) / np.where(sizes > 1e-9 * np.max(sizes), sizes, np.inf)
        assert np.all(reciprocity_defects(rigid).max(axis=(0, 1)) <= np.maximum(rounding, rounding.T))


def test_raw_and_summed_matrices_are_positive_definite(on_arcs):
    raw = {name: all_columns(result, raw=True) for name, result in on_arcs.items()}
    together = sum(all_columns(result) for result in on_arcs.values())
    for ics in (*raw.values(), together):
        assert GridOperator.from_ics(ics).smallest_eigenvalue() > 0.2 * np.min(ics[0, 0, 0].diagonal())


# --- the circular contour ----------------------------------------------------------------------------------


@pytest.mark.slow  # convergence of arcs: the sphere in test_harmonic.py; raw matrices of arcs: above
def test_on_an_arc_only_the_distance_matters_but_for_a_rigid_motion():
    """Inside half of the arc C_nn at equal lag agrees within 3e-3 of the line's maximum.

    After the best symmetric rigid compliance: a least-squares fit of its ten entries.
    """
    grid = Grid(6, 16, 0.4, 0.4)
    result = solved({"lower": matrix_job(LOWER, arc(10.0, 0.6, 0.6), grid, tolerance=ROUGH)})["lower"]
    nn = all_columns(result)[..., 2, 2]
    inner = np.flatnonzero(np.abs(grid.strips) < 3.0)
    normal = generalized(result.job.body, 0 * grid.strips, grid.strips)[:4, 2]  # (4, n_s)
    unit = [np.eye(4)[a][:, None] * np.eye(4)[b] for a, b in zip(*np.triu_indices(4), strict=True)]
    rigid = np.array([normal.T @ (e + e.T) @ normal for e in unit])  # (entry, observer, load)
    unequal, of_rigid, scale = [], [], []
    for apart in range(len(inner) - 1):
        pairs = inner[apart:], inner[: len(inner) - apart]
        for c in nn[:, *pairs]:
            unequal.append(c - c.mean())
            of_rigid.append((rigid[:, *pairs] - rigid[:, *pairs].mean(axis=1, keepdims=True)).T)
            scale.append(np.full(len(c), np.max(nn[:, *pairs])))
    columns = np.concatenate(of_rigid)
    columns = columns[:, np.any(columns != 0, axis=0)]
    left = np.concatenate(unequal) - columns @ np.linalg.lstsq(columns, np.concatenate(unequal))[0]
    assert np.max(np.abs(left) / np.concatenate(scale)) < 3e-3
