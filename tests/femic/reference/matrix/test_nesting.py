"""One solved model serves coarser, smaller and shifted grids: with their own C, and nothing factored."""

from dataclasses import replace

import numpy as np
import pytest

from femic.cache.store import Store
from femic.reference.harmonic import stored as nesting
from femic.reference.harmonic.section_response import Condensation
from femic.reference.harmonic.stored import stored_model
from femic.reference.matrix.reference import column_scale, matrices
from femic.reference.run_options import Level, RunOptions
from geometries.bodies import Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.patches import Grid, Load, Patch
from geometries.surfaces import UPPER
from tests.femic.reference.conftest import changed
from tests.femic.reference.matrix.test_matrix import matrix_job

GRID = Grid(10, 8, 0.4, 0.4)
CONTOUR = arc(10.2, 0.12, 0.12)
SERVED = {
    "twice as wide and long": Grid(5, 4, 0.8, 0.8),
    "fewer, shifted by one": Grid(10, 4, 0.4, 0.4, s=0.4),
    "more lags, longer": Grid(30, 6, 0.5, 0.4),
    "twice as wide, fewer": Grid(10, 2, 0.4, 0.8),
}


def job_on(grid, tolerance=0.3):
    job = matrix_job(UPPER, CONTOUR, grid, radius=300.0, tolerance=tolerance)
    return replace(job, body=replace(job.body, domain=Domain(100.0, np.inf)))


def solved(job, store):
    return matrices({"upper": job}, RunOptions(2, store))["upper"]


@pytest.fixture(scope="module")
def store():
    result = Store("memory://nesting")
    solved(job_on(GRID), result)
    return result


@pytest.fixture
def factored(monkeypatch):
    """Wavenumbers that are solved from here on."""
    result, respond = [], Condensation.respond
    monkeypatch.setattr(Condensation, "respond", lambda self, k, *s: result.extend(k) or respond(self, k, *s))
    return result


def test_some_of_the_strips_are_served_as_they_are(store, factored):
    """The same displacements before the discount."""
    whole, served = (solved(job_on(grid), store) for grid in (GRID, SERVED["fewer, shifted by one"]))
    assert not factored
    first = int(np.flatnonzero(np.isclose(GRID.strips, served.job.grid.strips[0]))[0])
    for strip in range(served.job.grid.n_s):
        expected = whole.raw_column(first + strip)[..., first : first + served.job.grid.n_s]
        atol = 1e-6 * np.max(np.abs(expected))
        np.testing.assert_allclose(served.raw_column(strip), expected, rtol=0, atol=atol)


@pytest.mark.slow
@pytest.mark.parametrize("grid", SERVED.values(), ids=SERVED)
def test_another_grid_is_served_within_both_estimates(store, factored, grid):
    job = job_on(grid)
    served = solved(job, store)
    assert not factored
    alone = solved(job, Store())
    assert factored
    for strip in range(grid.n_s):
        ours, own = served.column(strip), alone.column(strip)
        scale = column_scale(strip, own.ic, [job])
        off, known = (
            np.max(values / scale, axis=(2, 3))
            for values in (np.abs(ours.ic - own.ic), ours.estimate + own.estimate)
        )
        assert np.all(off <= known), (off / known, strip)


NOT_SERVED = {
    "of other strips": Grid(10, 6, 0.4, 0.5),
    "shifted by half a strip": Grid(10, 4, 0.4, 0.4, s=0.2),
    "larger": Grid(10, 10, 0.4, 0.4),
    "four times as wide": Grid(4, 2, 1.6, 1.6),
}


@pytest.mark.parametrize("grid", NOT_SERVED.values(), ids=NOT_SERVED)
def test_a_grid_that_the_model_does_not_have_is_not_served(store, grid):
    assert stored_model(job_on(grid).request(Level()), store) is None


def test_other_bodies_and_tighter_tolerances_are_not_served(store):
    job = job_on(SERVED["twice as wide and long"])
    assert stored_model(job.request(Level()), store) is not None
    other_nu = replace(job.body, material=Material(200e3, 0.3))
    for other in (
        changed(job, tolerance=1e-4),
        job_on(Grid(10, 4, 0.3, 0.8)),
        replace(job, body=other_nu),
        replace(job, body=job.body.enlarged(2.0)),
    ):
        assert stored_model(other.request(Level()), store) is None
    assert stored_model(job.request(Level()), Store()) is None


def test_equal_strips_side_by_side_make_up_a_load():
    loads = [Load(Patch(0.1, 0.2, s), i) for s in (-0.6, -0.2, 0.2, 0.6) for i in (0, 2)]
    members = lambda s, b, i: nesting._members(loads, Load(Patch(9.0, b, s), i)).tolist()  # noqa: E731
    assert members(0.2, 0.2, 2) == [5]
    assert members(0.0, 0.4, 2) == [3, 5]
    assert members(0.0, 0.8, 0) == [0, 2, 4, 6]
    assert members(0.0, 0.4, 1) == []  # another direction
    assert members(0.1, 0.5, 2) == members(-0.1, 0.5, 2) == []  # more than the two that begin where it does
    assert members(0.1, 0.2, 2) == members(0.0, 0.5, 2) == members(0.0, 0.6, 2) == members(0.0, 1.2, 0) == []
    wide = [*loads, Load(Patch(0.1, 0.4, 0.4), 0)]
    assert nesting._members(wide, Load(Patch(0.1, 0.4, 0.4), 0)).tolist() == [8]  # rather than two
