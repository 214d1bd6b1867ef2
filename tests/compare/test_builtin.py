"""The built-in scenes at their default settings (minutes: `make test-all`)."""

import numpy as np
import pytest
from joblib import Memory

from compare.dataset import errors, to_dataset
from compare.pipeline import compute, estimated_errors
from compare.scenes import builtin_names, load_scene

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", builtin_names())
def test_default_settings_know_c_of_each_body_to_half_a_percent(name):
    results = compute(load_scene(name), workers=1, memory=Memory(None))
    for where, estimate in estimated_errors(results).items():
        assert np.nanmax(estimate) < 0.005, where
    if name == "flat":
        _check_against_the_half_space(results)


def _check_against_the_half_space(results):
    """A is exact on a plane: the errors of A are the errors of C."""
    found = errors(results, to_dataset(results))["max"].sel(variant="A")
    assert np.nanmax(found.sel(line=["s = 1.6 mm", "x = 1.6 mm"])) < 0.002
    assert np.nanmax(found.sel(line="s = 0 mm")) < 0.01
