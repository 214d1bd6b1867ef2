"""The built-in scenes at their default settings (minutes: `make test-all`)."""

from dataclasses import replace

import numpy as np
import pytest

from femic.reference.engines import HARMONIC
from femic.reference.job import component_of
from femic.reference.result import combine, scales, worst
from femic.reference.run_options import Level, RunOptions
from femic.results.ics import compute, jobs
from femic.results.ics_dataset import errors, to_dataset
from femic.scenes.load import builtin_names, load_scene
from tests.compare.conftest import estimated_errors
from tests.femic.reference.harmonic.fields import raw_ics

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", builtin_names())
def test_default_settings_give_c_to_one_percent_in_first_round(name):
    results = compute(load_scene(name), RunOptions(1))
    for where, estimate in estimated_errors(results).items():
        assert all(component_of(estimate, c) < 0.007 for c in results.scene.components), where
    assert all(reference.level == Level() for reference in results.references.values())
    if name == "flat":
        _check_against_the_half_space(results)


def _check_against_the_half_space(results):
    """A is exact on a plane: the errors of A are the errors of C."""
    errors_of_a = errors(results, to_dataset(results)).error.sel(variant="A")
    assert np.nanmax(errors_of_a.sel(line=["s = 1.6 mm", "x = 1.6 mm"])) < 0.002
    assert np.nanmax(errors_of_a.sel(line="s = 0 mm")) < 0.01


@pytest.mark.parametrize("body", ["lower", "upper"])
def test_doubling_domain_of_geometry_2_changes_c_by_less_than_estimate(body):
    job = jobs(load_scene("geometry2"))[body]
    first, doubled = (_first(replace(job, body=job.body.enlarged(size))) for size in (1.0, 2.0))
    scale = scales([job], first.c.ic)
    change = worst(job, np.abs(doubled.c.ic - first.c.ic), scale)
    known = worst(job, first.c.estimate, scale)
    assert change[0] < known[0], (change, known)


def _first(job):
    """C by the first models of a job."""
    models = {level: raw_ics(job.request(level)) for level in Level().models(HARMONIC.models).values()}
    return combine(job, Level(), models)
