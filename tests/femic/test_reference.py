"""Models of a body: what is solved, kept, combined and refined."""

from dataclasses import replace

import numpy as np
import pytest
from joblib import Memory

from femic import solid
from femic.linear import NotConverged
from femic.reference import (
    MODELS,
    SILENT,
    Job,
    Level,
    Watch,
    combine,
    converged,
    estimated_errors,
    factors,
    references,
    refine,
    refined,
    request,
    solve_models,
    summed,
)
from femic.solid import Points
from geometries.errors import WrongInput
from tests.femic.conftest import COARSE, PATCH, SYMMETRIC, request_for

BODY = request_for(SYMMETRIC).body
POINTS = request_for(SYMMETRIC).points
LINES = {"near": slice(0, 3), "far": slice(3, 6)}
JOB = Job(
    BODY,
    PATCH,
    ("nn",),
    POINTS,
    LINES,
    tolerance=1.0,
    cells=COARSE,
    rotation_reach=9.0,
    most_unknowns=100_000,
)
FIRST = list(Level().models().values())


def solve_all(memory):
    todo = [("lower", level) for level in FIRST]
    found = solve_models({"lower": JOB}, todo, workers=1, memory=memory)
    return {solved.level: solved.raw for solved in found}


@pytest.fixture(scope="module")
def models():
    return solve_all(Memory(None))


def test_models_differ_in_cells_and_domain_only_as_stated():
    fine, coarse, small = (request(JOB, Level().models()[name]) for name in MODELS)
    assert coarse.cells == JOB.cells.scaled(1.5)
    assert small.cells == coarse.cells
    assert small.body.domain == BODY.domain.scaled(0.5)
    assert fine.body == coarse.body == BODY
    assert fine.loads == coarse.loads == small.loads


def test_a_second_run_opens_no_mesh_and_an_interrupted_one_resumes(tmp_path, monkeypatch):
    meshed = []
    build = solid.build_mesh

    def counting(asked):
        if len(meshed) == 2 and not interrupted:
            interrupted.append(1)
            raise KeyboardInterrupt
        meshed.append(1)
        return build(asked)

    interrupted = []
    monkeypatch.setattr(solid, "build_mesh", counting)
    memory = Memory(tmp_path, verbose=0)
    try:
        solve_all(memory)
    except KeyboardInterrupt:
        assert len(meshed) == 2
    first = solve_all(memory)
    assert interrupted
    assert len(meshed) == len(MODELS)  # two before the interruption, the third after it
    todo = [("lower", level) for level in FIRST]
    again = list(solve_models({"lower": JOB}, todo, workers=1, memory=memory))
    assert all(solved.kept for solved in again)
    assert len(meshed) == len(MODELS)
    np.testing.assert_array_equal(first[Level()].u, again[0].raw.u)


def test_only_the_requested_column_is_a_number(models):
    reference = combine(JOB, Level(), models)
    assert np.all(np.isfinite(reference.ic[:, 2]))
    assert np.all(np.isnan(reference.ic[:, :2]))
    assert np.all(reference.estimate[:, 2] >= 0)
    assert all(len(cost.iterations) == 1 for cost in reference.models.values())


def test_estimated_errors_are_shares_of_the_scale_of_their_line(models):
    reference = combine(JOB, Level(), models)
    c = reference.ic[2, 2]
    for line, part in LINES.items():
        expected = reference.estimate[2, 2, part].max() / np.abs(c[part]).max()
        assert estimated_errors(JOB, reference, reference.estimate)[line][2, 2] == pytest.approx(expected)


def with_errors(models, mesh, truncation):
    """A reference whose two estimates are the given shares of max C_nn on each line."""
    reference = combine(JOB, Level(), models)
    scale = np.zeros(len(POINTS.x))
    for part in LINES.values():
        scale[part] = np.abs(reference.ic[2, 2, part]).max()
    whole = np.broadcast_to(scale, reference.ic.shape)
    return replace(reference, mesh_error=mesh * whole, truncation_error=truncation * whole)


STEPS = [  # estimates, tolerance, expected level; cells gain 1.5^3 = 3.4 a step, the domain 2^2 = 4
    (0.02, 0.001, 0.02, Level(1, 0)),
    (0.001, 0.02, 0.02, Level(0, 1)),
    (0.02, 0.02, 0.03, Level(1, 1)),
    (0.05, 0.001, 0.01, Level(2, 0)),
]


@pytest.mark.parametrize(("mesh", "truncation", "tolerance", "level"), STEPS)
def test_the_part_that_is_too_large_is_refined(models, mesh, truncation, tolerance, level):
    job = replace(JOB, tolerance=tolerance)
    reference = with_errors(models, mesh, truncation)
    assert not converged(job, reference)
    assert refined("lower", job, reference, reference) == level


def test_estimates_within_the_tolerance_are_enough(models):
    assert converged(replace(JOB, tolerance=0.02), with_errors(models, 0.011, 0.008))


def test_an_estimate_that_is_not_a_number_is_not_convergence(models):
    one_missing = with_errors(models, 0.0, 0.0)
    one_missing.mesh_error[..., 4] = np.nan
    assert not converged(JOB, one_missing)


def test_too_large_a_model_is_refused_with_the_numbers_and_what_to_try(models):
    job = replace(JOB, tolerance=0.01)
    reference = with_errors(models, 0.05, 0.2)
    with pytest.raises(NotConverged, match=r"lower body: .*C_nn .*5\.00% from the mesh.*10,000\).*Try"):
        refined("lower", replace(job, most_unknowns=10_000), reference, reference)


def test_refinement_goes_on_until_the_tolerance_is_met_and_solves_no_model_twice():
    asked = []
    watch = Watch(asked.append, SILENT.on_model)
    job = replace(JOB, tolerance=0.002)
    found = references({"lower": job}, watch=watch)["lower"]
    assert len(asked) > 1
    flat = [level for levels in asked for _, level in levels]
    assert len(set(flat)) == len(flat)
    assert found.level != Level()
    assert converged(job, found)
    cells, domain = factors(found.level)
    assert found.cells == COARSE.scaled(cells)
    assert found.body.domain == BODY.domain.scaled(domain)
    assert len(found.models) == len(flat)


def test_a_part_without_error_is_not_refined(models):
    reference = with_errors(models, 0.02, 0.0)
    assert refined("lower", replace(JOB, tolerance=0.01), reference, reference) == Level(2, 0)


def test_refinement_that_does_not_help_ends(models):
    job = replace(JOB, tolerance=0.01)
    reference = replace(with_errors(models, 0.0, 0.02), level=Level(0, 4))
    with pytest.raises(NotConverged, match=r"2\.00% from the domain.*domain more than 16 times the first"):
        refined("lower", job, reference, reference)


def test_the_sum_of_both_bodies_is_judged_too(models):
    """Opposite ICs of two bodies cancel: their errors do not, and the scale of the sum is small."""
    job = replace(JOB, tolerance=0.02, most_unknowns=10_000_000)
    good = with_errors(models, 0.001, 0.0)
    worse = replace(with_errors(models, 0.011, 0.0), ic=-0.95 * good.ic, level=Level(0, 0))
    jobs, found = {"lower": job, "upper": job}, {"lower": good, "upper": worse}
    assert refine(jobs, found, combined=False) == {}
    assert set(refine(jobs, found, combined=True)) == {"upper"}
    total = summed([good, worse])
    np.testing.assert_allclose(total.estimate, good.estimate + worse.estimate)
    assert refine(jobs, found | {"upper": replace(worse, ic=good.ic)}, combined=True) == {}


def test_a_first_model_beyond_the_limit_is_refused():
    with pytest.raises(NotConverged, match=r"a model needs [\d,]+ unknowns, engine\.most_unknowns = 1,000"):
        references({"lower": replace(JOB, most_unknowns=1000)})


def test_points_outside_the_smallest_model_are_refused_before_any_work(monkeypatch):
    monkeypatch.setattr(solid, "build_mesh", lambda _: pytest.fail("a mesh was made"))
    far = replace(JOB, points=Points(np.array([30.0]), np.array([0.0])), lines={"far": slice(0, 1)})
    with pytest.raises(WrongInput, match=r"lower body: the point s = 0 mm, 30 mm along x, .* 25 mm along x"):
        references({"lower": far})  # the small model goes to x = 25 mm
    with pytest.raises(WrongInput, match="lies outside"):
        references({"lower": replace(JOB, patch=replace(PATCH, s=22.0))})
