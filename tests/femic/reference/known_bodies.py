"""Bodies whose C is known, on a line along x and one along s: a half-space and a ball; errors of engines."""

import numpy as np

from approx.halfspace import HalfSpace
from femic.reference.discount import fit_discount, rigid_part
from femic.reference.engine import Points
from femic.reference.engines import HARMONIC, SOLID
from femic.reference.job import Job, Settings, line_scale
from femic.reference.meshing import Cells
from femic.reference.result import combine, discounted
from femic.reference.run_options import Level
from femic.reference.solid.engine import raw_ics as solid_raw_ics
from geometries.bodies import Body, Domain
from geometries.contours import arc, plane
from geometries.materials import Material, one_body
from geometries.patches import COMPONENTS, Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import STEEL, changed
from tests.femic.reference.harmonic.fields import raw_ics as harmonic_raw_ics
from tests.truths.sphere import sphere_ics

PATCH = Patch(0.2, 0.3)
RUNNING = np.linspace(0, 12, 49)
LINES = slice(0, 49), slice(49, 98)
POINTS = Points(np.concatenate([RUNNING, 0 * RUNNING + 1.6]), np.concatenate([0 * RUNNING + 1.6, RUNNING]))
SOLID_CELLS, HARMONIC_CELLS = Cells(0.2 / 12, 0.14, 0.05), Cells(0.03, 0.4, 0.4)
RADIUS = 300.0  # of the ball
OTHERS = {  # than a lower body of steel under a load at its centre
    "upper": {"side": UPPER},
    "nu = 0": {"material": Material(210e3, 0.0)},
    "nu = 0.49": {"material": Material(210e3, 0.49)},
    "soft": {"material": Material(1.0, 0.28)},
    "off centre": {"s": 1.0},
}


def job(size, factor, *, side=LOWER, s=0.0, material=STEEL, contour=None, rolling_radius=np.inf):
    """For the solid engine, with cells `factor` times the default; the lines move with the patch."""
    body = Body(side, contour or plane(), material, Domain(size, size), rolling_radius)
    settings = Settings(SOLID, cells=SOLID_CELLS.scaled(factor), rotation_reach=min(20.0, size / 8))
    lines = {"s": LINES[0], "x": LINES[1]}
    return Job(body, Patch(PATCH.a, PATCH.b, s), COMPONENTS, Points(POINTS.x, POINTS.s + s), lines, settings)


def harmonic(asked, factor=1.0, tolerance=1e-3):
    """The same by the harmonic engine, cells `factor` times those for a tolerance of 0.1 %."""
    return changed(asked, engine=HARMONIC, cells=HARMONIC_CELLS.scaled(factor), tolerance=tolerance)


def harmonic_job(size, factor=1.0, **changes):
    return harmonic(job(size, 1.0, **changes), factor)


def ball(size, factor, side, *, s=0.0, right_flank=1.2):
    """Crown of the lower ball, bottom of the upper one: the contour falls away from the other body."""
    contour = arc(-side * RADIUS, 1.2, right_flank)
    return job(size, factor, side=side, s=s, contour=contour, rolling_radius=RADIUS)


# --- what the engines give, and the truth ---------------------------------------------------------------


START = Level()


def raw(asked, level=START):
    """A model of the engine of a job."""
    solve = solid_raw_ics if asked.settings.engine is SOLID else harmonic_raw_ics
    return solve(asked.request(level))


def first_c(asked):
    """C by the first model alone."""
    return discounted(asked, raw(asked).u)[0]


def reference(asked):
    """C with its estimate."""
    levels = START.models(asked.settings.engine.models).values()
    return combine(asked, START, {level: raw(asked, level) for level in levels})


def half_space(asked):
    solid = HalfSpace(one_body(asked.body.material, asked.body.side))
    return solid.ics(asked.patch, asked.points.x, asked.points.s - asked.patch.s) / asked.patch.area


def sphere(asked):
    """The ball's ICs with the same discount; its load is balanced far away, not at the far arc."""
    body, rule, fit = asked.body, asked.rule, asked.fit

    def u(load, points):
        ics = sphere_ics(STEEL, RADIUS, body.side, load.patch, points.x, points.s)
        return ics[:, load.direction]

    at_fit_points = {load: u(load, rule.points(body)) for c in fit for load in c.loads}
    m = fit_discount(body, rule, fit, at_fit_points)
    columns = [u(load, asked.points) - rigid_part(m, body, asked.points, load) for load in asked.loads]
    return np.stack(columns, axis=1)


def line_errors(difference, c_line, nn_line):
    """The largest error of each component on a line as a share of its scale, (3, 3)."""
    return np.max(np.abs(difference), axis=-1) / line_scale(c_line, nn_line)


def shares(difference, c):
    """The larger of a line's errors over both lines, per component."""
    return np.max([line_errors(difference[..., p], c[..., p], c[2, 2, p]) for p in LINES], axis=0)


def error(asked, truth):
    """Error of the first model, per component."""
    return shares(first_c(asked) - truth, truth)


def error_and_estimate(asked, truth):
    c = reference(asked).c
    return shares(c.ic - truth, truth), shares(c.estimate, truth)
