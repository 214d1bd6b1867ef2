"""What all engines have, and one that is made here and nowhere else."""

import pickle

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.reference.engine import Points
from femic.reference.engines import ENGINES
from femic.reference.job import Job, NotConverged, Settings
from femic.reference.refinement import references
from femic.reference.run_options import MODELS, Level, RunOptions
from geometries.bodies import Body, Domain
from geometries.contours import plane
from geometries.materials import one_body
from geometries.patches import Patch
from geometries.surfaces import LOWER
from tests.femic.reference.closed_engine import CLOSED, OFF
from tests.femic.reference.conftest import STEEL

PATCH = Patch(0.3, 0.2)
BODY = Body(LOWER, plane(), STEEL, Domain(100.0, np.inf))
POINTS = Points(np.array([2.0, 4.0, 8.0]), np.array([0.5, 0.0, -3.0]))


@pytest.mark.parametrize("name", ENGINES)
def test_an_engine_is_known_by_its_name_and_solves_what_gives_c_and_its_error(name):
    engine = ENGINES[name]
    assert engine.name == name
    assert pickle.loads(pickle.dumps(engine)) is engine
    assert engine.models == MODELS[: len(engine.models)]
    assert engine.safety >= 1
    job = Job(BODY, PATCH, ("sn",), POINTS, {"all": slice(None)}, Settings(engine))
    request = job.request(Level())
    assert request.loads[: len(job.loads)] == job.loads
    np.testing.assert_array_equal(request.points.x[:3], POINTS.x)
    assert request.cells == job.first_cells


# --- an engine of closed formulas --------------------------------------------------------------------------


def c_of(tolerance, **settings):
    settings = Settings(CLOSED, tolerance, rotation_reach=12.0, **settings)
    job = Job(BODY, PATCH, ("nn", "xn"), POINTS, {"all": slice(None)}, settings)
    return references({"lower": job}, RunOptions(1))["lower"]


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 1e-3])
def test_a_new_engine_is_driven_by_its_class_alone(tolerance):
    """On a plane the discount of A is that of a point, so that C is A but for the share that is wrong."""
    result = c_of(tolerance)
    a = HalfSpace(one_body(STEEL, LOWER)).ics(PATCH, POINTS.x, POINTS.s)[:, 2] / PATCH.area
    scale = np.max(np.abs(a[2]))
    error = np.max(np.abs(result.raw[:, 2] - a)) / scale
    assert error == pytest.approx(OFF * result.cells.smallest**3, rel=1e-9)
    assert np.max(result.c.mesh_error[2, 2]) / scale <= tolerance
    assert set(result.models) >= {"fine", "coarse"}


def test_growth_of_unknowns_limits_refinement():
    unknowns = c_of(1e-3).models["fine"].unknowns
    with pytest.raises(NotConverged, match="`most_unknowns`"):
        c_of(1e-3, most_unknowns=unknowns // 2)
