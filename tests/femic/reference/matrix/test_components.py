"""Some components of the IC matrix alone: their loads, the same C and M, the refinement, the store."""

from dataclasses import replace

import numpy as np
import pytest

from femic.cache.store import Store
from femic.reference.engines import HARMONIC
from femic.reference.harmonic.stored import stored_model
from femic.reference.matrix.reference import assess_matrices, column_scale, matrices
from femic.reference.refinement import next_levels
from femic.reference.run_options import Level, RunOptions
from geometries.bodies import Domain
from geometries.contours import arc
from geometries.patches import COMPONENTS, Grid, N, S, indices
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import changed
from tests.femic.reference.harmonic.test_condensation import largest
from tests.femic.reference.matrix.test_column_scales import column
from tests.femic.reference.matrix.test_matrix import ARM, matrix_job

NN = ("nn",)
GRID = Grid(6, 4, 0.4, 0.4)
BODIES = {
    "wheel": (UPPER, arc(10.2, 0.12, 0.12), 300.0),
    "rail without symmetry": (LOWER, arc(10.0, 0.12, 0.3), np.inf),
}


def of_all(body):
    side, contour, radius = BODIES[body]
    job = matrix_job(side, contour, GRID, radius, 0.3)
    return replace(job, body=replace(job.body, domain=Domain(100.0, np.inf)))


def solved(job, store):
    return matrices({"body": job}, RunOptions(2, store))["body"]


@pytest.fixture(scope="module")
def of_nn():
    """Models that were solved for nn alone."""
    return Store("memory://nn alone")


@pytest.fixture(
    scope="module", params=["wheel", pytest.param("rail without symmetry", marks=pytest.mark.slow)]
)
def both(request, of_nn):
    """The matrix of all components, that of nn alone, and that of nn by the model of all."""
    job = of_all(request.param)
    store = Store(f"memory://components of a {request.param}")
    whole = solved(job, store)
    alone = replace(job, components=NN)
    return whole, solved(alone, of_nn), solved(alone, store)


def test_c_of_one_component_agrees_with_c_of_all_within_both_estimates(both):
    whole, alone, _ = both
    for strip in range(GRID.n_s):
        ours, of_whole = alone.column(strip), whole.column(strip)
        scale = column_scale(strip, of_whole.ic, [whole.job])[N, N]
        off, known = (
            np.max(values[N, N] / scale)
            for values in (np.abs(ours.ic - of_whole.ic), ours.estimate + of_whole.estimate)
        )
        assert off <= known, strip


def test_it_is_the_same_to_rounding_by_the_same_model(both):
    whole, _, served = both
    for strip in range(GRID.n_s):
        for part in ("ic", "estimate"):
            ours, of_whole = (getattr(result.column(strip), part)[N, N] for result in (served, whole))
            np.testing.assert_allclose(ours, of_whole, rtol=1e-6, atol=1e-9 * largest(of_whole))
        raw = whole.raw_column(strip)[N, N]
        np.testing.assert_allclose(served.raw_column(strip)[N, N], raw, rtol=0, atol=1e-12 * largest(raw))


def test_components_that_are_not_requested_are_nan(both):
    _, alone, _ = both
    for part in ("ic", "estimate"):
        values = getattr(alone.column(2), part).reshape(9, -1)
        known = np.all(np.isfinite(values), axis=1)
        assert [name for name, result in zip(COMPONENTS, known, strict=True) if result] == ["nn"]
        assert np.all(np.isnan(values[~known]))


def test_only_loads_are_solved_that_nn_and_m_need():
    """Besides the strips under n: a lateral load, and normal ones at the contact centre and at the arm."""
    loads = replace(of_all("wheel"), components=NN).request(Level()).requested_loads
    strips = {GRID.patch(strip) for strip in range(GRID.n_s)}
    assert {load.direction for load in loads if load.patch in strips} == {N}
    further = {(load.patch.s, load.direction) for load in loads if load.patch not in strips}
    assert further == {(0.0, S), (0.0, N), (ARM, N)}


# --- refinement ----------------------------------------------------------------------------------------


class Known:
    """A matrix whose errors are made up: that of nn is small, that of xs large."""

    level, cells = Level(), 1.0

    def __init__(self):
        error = {indices("nn"): 1e-3, indices("xs"): 1e3}
        entries = {(*place, lag, strip): e for place, e in error.items() for lag, strip in np.ndindex(7, 6)}
        self.made = column(mesh_error=entries)

    def column(self, _):
        return self.made


@pytest.mark.parametrize("combined", [False, True])
def test_only_requested_components_are_assessed(combined):
    grid = Grid(7, 6, 0.4, 0.5)
    result = Known()
    errors = {}
    for components in (NN, COMPONENTS):
        jobs = {name: replace(of_all("wheel"), grid=grid, components=components) for name in ("a", "b")}
        assessed = assess_matrices(jobs, dict.fromkeys(jobs, result), combined=combined)
        errors[components] = [assessed.own["a"], *([assessed.combined] if combined else [])]
        errors[components] += [assessed.in_combined["b"]] if combined else []
    for of_nn, of_all_components in zip(*errors.values(), strict=True):
        assert (of_nn.component, of_all_components.component) == ("nn", "xs")
        ratio = of_all_components.total / of_nn.total
        assert ratio == pytest.approx(1e6)  # near the load, where the scale of both is 5 A_nn


@pytest.mark.slow
def test_nn_alone_is_accurate_on_cells_on_which_other_components_are_not():
    """All nine are judged by one model; that of nn stays as it is, and meets the tolerance."""
    side, contour, radius = BODIES["wheel"]
    first = matrix_job(side, contour, GRID, radius, 0.02)
    job = changed(first, cells=first.first_cells.scaled(1.6), tolerance=np.inf)
    coarse = solved(job, Store())
    shares = {
        components: assess_matrices(
            {"body": replace(job, components=components)}, {"body": coarse}, combined=False
        ).own["body"]
        for components in (NN, COMPONENTS)
    }
    tolerance = np.sqrt(shares[NN].total * shares[COMPONENTS].total)
    assert shares[NN].total < tolerance < shares[COMPONENTS].total
    asked = {"body": changed(replace(job, components=NN), tolerance=tolerance)}
    assert not next_levels(asked, {"body": coarse}, assess_matrices(asked, {"body": coarse}, combined=False))


# --- store and plan ------------------------------------------------------------------------------------


def test_a_model_of_nn_does_not_serve_other_components(both, of_nn):
    _, alone, _ = both
    assert stored_model(alone.job.request(Level()), Store("memory://nothing")) is None
    assert stored_model(alone.job.request(Level()), of_nn) is not None
    for components in (COMPONENTS, ("ss",), ("xn",)):
        other = replace(alone.job, components=components)
        assert stored_model(other.request(Level()), of_nn) is None


def test_a_plan_counts_the_fields_that_are_solved():
    """On half a section two strips, and the loads of M on two widths of strips: nn needs none along x."""
    fewer, all_nine = (
        HARMONIC.expected_cost(replace(of_all("wheel"), components=components).request(Level()), 1)
        for components in (NN, COMPONENTS)
    )
    assert (fewer.fields, all_nine.fields) == (2 + 2 * 3, 3 * 2 + 2 * 4)
    assert fewer.wavenumbers <= all_nine.wavenumbers
    assert fewer.seconds <= all_nine.seconds
    assert fewer.unknowns == all_nine.unknowns
