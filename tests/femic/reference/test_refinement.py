"""What is refined, how far, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from femic.reference.engine import Points
from femic.reference.engines import HARMONIC, SOLID
from femic.reference.job import NotConverged
from femic.reference.refinement import assess_references, next_levels, references
from femic.reference.result import EstimatedICs, combine, scales, shares, total, worst
from femic.reference.run_options import MODELS, Level, RunOptions, Watch, factors
from femic.reference.solid import engine as solid
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.surfaces import UPPER
from tests.femic.reference.closed_engine import CLOSED
from tests.femic.reference.conftest import COARSE, JOB, LINES, PATCH, changed


def with_errors(models, mesh, truncation, waves=0.0):
    """A reference whose two estimates are the given shares of max C_nn on each line."""
    reference = combine(JOB, Level(), models)
    scale = np.zeros(len(JOB.points.x))
    for part in LINES.values():
        scale[part] = np.abs(reference.c.ic[2, 2, part]).max()
    whole = np.broadcast_to(scale, reference.c.ic.shape)
    return replace(reference, c=EstimatedICs(reference.c.ic, mesh * whole, truncation * whole, waves * whole))


def own_shares(job, reference):
    return shares(job, reference.c, scales([job], reference.c.ic))


def met(job, reference):
    return own_shares(job, reference).total <= job.settings.tolerance


@pytest.mark.parametrize("engine", [CLOSED, pytest.param(SOLID, marks=pytest.mark.slow)])
def test_refinement_goes_on_until_the_tolerance_is_met_and_solves_no_model_twice(engine):
    asked = []
    watch = Watch(asked.append)
    job = changed(JOB, tolerance=0.002, engine=engine)
    result = references({"lower": job}, RunOptions(1, watch=watch))["lower"]
    assert len(asked) > 1
    flat = [task.level for tasks in asked for task in tasks]
    assert len(set(flat)) == len(flat)
    assert result.level != Level()
    assert met(job, result)
    cells, domain = factors(result.level)
    assert result.cells == COARSE.scaled(cells)
    assert result.body.domain == JOB.body.domain.scaled(domain)
    assert len(result.models) == len(flat)


def test_a_harmonic_job_solves_one_model_a_solid_one_three():
    assert list(Level(1, 1, 1).models(HARMONIC.models).values()) == [Level(1, 1, 1)]
    assert list(Level(1, 1).models(SOLID.models).values()) == [Level(1, 1), Level(0, 1), Level(0, 0)]


def given(job, **keys):
    """A job whose boundaries are given, or some of them."""
    domain = replace(job.body.domain, **{"radius_given": True, "length_given": True} | keys)
    return replace(job, body=replace(job.body, domain=domain))


def test_given_boundaries_have_no_part_in_the_estimate_and_no_model_of_their_own(models):
    truncated, own = combine(JOB, Level(), models), combine(given(JOB), Level(), models)
    assert np.nanmax(truncated.c.truncation_error) > 0
    assert np.nanmax(own.c.truncation_error) == 0
    np.testing.assert_array_equal(own.c.mesh_error, truncated.c.mesh_error)
    assert (set(truncated.models), set(own.models) - {"earlier 1"}) == (set(MODELS), {"fine", "coarse"})


def test_of_two_boundaries_the_one_that_is_not_given_counts_and_moves(models):
    half = given(JOB, length_given=False)
    assert np.nanmax(combine(half, Level(), models).c.truncation_error) > 0
    domain = half.request(Level(domain=1)).body.domain
    assert (domain.far_radius, domain.half_length) == (40.0, 100.0)
    assert given(JOB).request(Level(domain=1)).body.domain == given(JOB).body.domain


def test_sum_of_both_bodies_is_assessed_too(models):
    """Opposite ICs of two bodies cancel: their errors do not, and the scale of the sum is small."""
    job = changed(JOB, tolerance=0.02, most_unknowns=10_000_000)
    good = with_errors(models, 0.001, 0.0)
    poor = with_errors(models, 0.011, 0.0)
    worse = replace(poor, c=replace(poor.c, ic=-0.95 * good.c.ic))
    jobs, result = {"lower": job, "upper": job}, {"lower": good, "upper": worse}
    assert next_levels(jobs, result, assess_references(jobs, result, combined=False)) == {}
    assert set(next_levels(jobs, result, assess_references(jobs, result, combined=True))) == {"upper"}
    found_sum = total([good.c, worse.c])
    np.testing.assert_allclose(found_sum.estimate, good.c.estimate + worse.c.estimate)
    assert (
        next_levels(
            jobs, result | {"upper": poor}, assess_references(jobs, result | {"upper": poor}, combined=True)
        )
        == {}
    )


def test_a_first_model_beyond_the_limit_is_refused():
    with pytest.raises(NotConverged, match=r"a model needs [\d,]+ unknowns, `most_unknowns` = 1,000"):
        references({"lower": changed(JOB, most_unknowns=1000)}, RunOptions(1))


def test_points_outside_the_smallest_model_are_refused_before_any_work(monkeypatch):
    monkeypatch.setattr(solid, "build_mesh", lambda _: pytest.fail("a mesh was made"))
    far = replace(JOB, points=Points(np.array([30.0]), np.array([0.0])), lines={"far": slice(0, 1)})
    with pytest.raises(WrongInput, match=r"lower body: the point s = 0 mm, 30 mm along x, .* 25 mm along x"):
        references({"lower": far}, RunOptions(1))  # the small model goes to x = 25 mm
    with pytest.raises(WrongInput, match="lies outside"):
        references({"lower": replace(JOB, patch=replace(PATCH, s=22.0))}, RunOptions(1))


def without_nn(models, job, share):
    """A reference of which xx alone was solved: it is 0, its estimate the given share of its scale."""
    ic, error = np.full((2, 3, 3, len(JOB.points.x)), np.nan)
    ic[0, 0] = 0.0
    for line, scale in scales([job], ic).items():
        error[0, 0, LINES[line]] = share * scale[0, 0]
    return replace(combine(JOB, Level(), models), c=EstimatedICs(ic, error, 0 * error, 0 * error))


def test_without_nn_the_sum_of_both_half_spaces_is_the_scale_of_the_sum(models):
    """What is a share of each body's scale is the same share of the scale of their sum."""
    job = changed(replace(JOB, components=("xx",)), tolerance=0.02)
    softer = replace(JOB.body, side=UPPER, material=Material(70e3, 0.33))
    jobs = {"lower": job, "upper": replace(job, body=softer)}
    result = {
        name: without_nn(models, of_body, 0.7 * job.settings.tolerance) for name, of_body in jobs.items()
    }
    c = total([reference.c for reference in result.values()])
    share, *_ = worst(job, c.estimate, scales(list(jobs.values()), c.ic))
    assert share == pytest.approx(0.7 * job.settings.tolerance)
    assert next_levels(jobs, result, assess_references(jobs, result, combined=True)) == {}
