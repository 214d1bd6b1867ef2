# ruff: noqa: ARG002 (arguments of an engine that it does not need)
"""An engine of closed formulas: half-space displacements with a known error; no matrices and no fields."""

from dataclasses import replace

import numpy as np

from approx.halfspace import HalfSpace
from femic.reference.engine import Cost, Engine, ExpectedCost, Limits, RawICs, scale_cells
from femic.reference.meshing import Cells
from femic.reference.run_options import Solved
from geometries.materials import one_body

OFF = 8.0  # error of its C in cells of 1 mm: a share of each displacement, with the cube of the cell size


def half_space(request):
    """Displacements of a half-space (load, 3, n), too large by a share that falls like h^3."""
    solid = HalfSpace(one_body(request.body.material, request.body.side))
    share = 1 + OFF * request.cells.smallest**3
    u = [
        share
        * solid.ics(load.patch, request.points.x, request.points.s - load.patch.s)[:, load.direction]
        / load.patch.area
        for load in request.loads
    ]
    return np.stack(u)


class ClosedEngine(Engine):
    name = "closed"
    description = "closed formulas with an error"
    limits = Limits(0.5, np.inf, 0.0, 90.0, np.inf)
    models = ("fine", "coarse")
    safety = 1.0
    growth_of_unknowns = 3.0
    infinite_length = shares_a_model = True

    def least_side(self, patch):
        return patch.b

    def first_cells(self, tolerance, patch, *, on_strips=False):
        return scale_cells(Cells(0.5, 1.0, 1.0), tolerance, 1.0, 1.0)

    def far_radius(self, tolerance, grid=None):
        return 100.0

    def key(self, request, store):
        return store.key(self.name, request)

    def expected_cost(self, request, workers):
        return ExpectedCost(1, 0, 1, False, 0.0, 0.0)

    def solve(self, tasks, options):
        for task in tasks:
            unknowns = round(task.request.cells.smallest**-3)
            cost = Cost(unknowns, 1, "A", (), 0.0, {}, 0.0)
            raw = RawICs(half_space(task.request), cost)
            yield Solved(task, replace(raw, perturbed={"nearer": raw.u}), cached=False)

    def displacements(self, solved, loads, points):
        return solved


CLOSED = ClosedEngine()
