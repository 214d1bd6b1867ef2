"""Engines are records: what all have, and one that is made here and nowhere else."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.reference.accuracy import NotConverged
from femic.reference.at_points import references
from femic.reference.engine import Engine, Limits, Tuned
from femic.reference.engines import ENGINES, EngineName
from femic.reference.job import Job, Settings
from femic.reference.level import MODELS, Level
from femic.reference.meshing.cell_size import Cells
from femic.reference.models import Cost, Planned, Points, RawICs
from femic.reference.run_options import Means, Solved
from geometries.bodies import Body, Domain
from geometries.contours import plane
from geometries.materials import one_body
from geometries.patches import Patch
from geometries.surfaces import LOWER
from tests.femic.reference.conftest import STEEL

PATCH = Patch(0.3, 0.2)
BODY = Body(LOWER, plane(), STEEL, Domain(100.0, np.inf))
POINTS = Points(np.array([2.0, 4.0, 8.0]), np.array([0.5, 0.0, -3.0]))
OFF = 8.0  # error of its C in cells of 1 mm: a share of each displacement, with the cube of the cell size


def test_each_engine_is_registered_under_its_name():
    assert get_args(EngineName) == tuple(ENGINES)
    assert all(engine.name == name for name, engine in ENGINES.items())


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_an_engine_solves_the_models_that_give_c_and_its_error(engine):
    assert engine.models == MODELS[: len(engine.models)]
    assert engine.safety >= 1


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_what_is_asked_of_an_engine_is_what_it_solves(engine):
    job = Job(BODY, PATCH, ("sn",), POINTS, {"all": slice(None)}, Settings(engine))
    request = job.request(Level())
    assert request.loads[: len(job.loads)] == job.loads
    np.testing.assert_array_equal(request.points.x[:3], POINTS.x)
    assert request.cells == job.first_cells


# --- an engine of closed formulas --------------------------------------------------------------------------


def half_space(request):
    """Displacements of a half-space (load, 3, n), too large by a share that falls like h^3."""
    solid = HalfSpace(one_body(request.body.material, request.body.side))
    share = 1 + OFF * request.cells.smallest**3
    u = [
        share * solid.ics(load.patch, request.points.x, request.points.s - load.patch.s)[:, load.direction]
        for load in request.loads
    ]
    return np.stack(u) / PATCH.area


def solve(tasks, _means):
    for task in tasks:
        raw = RawICs(
            half_space(task.request), Cost(round(task.request.cells.smallest**-3), 1, "A", (), 0.0, {}, 0.0)
        )
        yield Solved(task, replace(raw, perturbed={"nearer": raw.u}), kept=False)


CLOSED = Engine(
    name="closed",
    describes="closed formulas with an error",
    models=("fine", "coarse"),
    safety=1.0,
    growth_of_unknowns=3.0,
    tuned=Tuned(1.0, lambda _: Cells(0.5, 1.0, 1.0), coarsest=1.0),
    far_radius=lambda _: 100.0,
    least_side=lambda patch: patch.b,
    limits=Limits(0.5, np.inf, 0.0, 90.0, np.inf),
    endless=True,
    both_loads=False,
    shares_a_model=True,
    has_fields=False,
    request=lambda asked: asked,
    solve=solve,
    key=lambda request, store: store.key("closed", request),
    displacements=lambda _, model: model,
    planned=lambda *_: Planned(1, 0, 1, False, 0.0, 0.0),
)


def c_of(tolerance, **settings):
    settings = Settings(CLOSED, tolerance, rotation_reach=12.0, **settings)
    job = Job(BODY, PATCH, ("nn", "xn"), POINTS, {"all": slice(None)}, settings)
    return references({"lower": job}, Means(1))["lower"]


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 1e-3])
def test_a_new_engine_is_driven_by_its_record_alone(tolerance):
    """On a plane the discount of A is that of a point, so that C is A but for the share that is wrong."""
    found = c_of(tolerance)
    a = HalfSpace(one_body(STEEL, LOWER)).ics(PATCH, POINTS.x, POINTS.s)[:, 2] / PATCH.area
    scale = np.max(np.abs(a[2]))
    error = np.max(np.abs(found.raw[:, 2] - a)) / scale
    assert error == pytest.approx(OFF * found.cells.smallest**3, rel=1e-9)
    assert np.max(found.c.mesh_error[2, 2]) / scale <= tolerance
    assert set(found.models) >= {"fine", "coarse"}


def test_its_growth_says_when_a_model_would_be_too_large():
    unknowns = c_of(1e-3).models["fine"].unknowns
    with pytest.raises(NotConverged, match="`most_unknowns`"):
        c_of(1e-3, most_unknowns=unknowns // 2)
