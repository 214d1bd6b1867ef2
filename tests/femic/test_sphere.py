"""A ball of revolution against the exact solution of the sphere: curvature, local frames, estimate."""

import numpy as np

from femic.accuracy import line_errors
from femic.discount import conditions, fit_discount, rigid_part
from femic.reference import Level, combine, request
from femic.solid import raw_ics
from geometries.contours import arc
from geometries.surfaces import LOWER, UPPER
from tests.femic.conftest import STEEL, assert_honest
from tests.femic.test_flat import LINES, halfspace, job
from tests.truths.sphere import sphere_ics

RADIUS = 300.0
MESHES, DOMAINS = (2.8, 2.4, 2.0), (80.0, 160.0)


def ball(size, factor, side):
    """Crown of the lower ball, bottom of the upper one: the contour falls away from the other body."""
    return job(size, factor, side=side, contour=arc(-side * RADIUS, 1.2, 1.2), rolling_radius=RADIUS)


def exact(asked):
    """The sphere's ICs with the same discount; its load is balanced far away, not at the far arc."""
    fit_points, n = asked.rule.points(asked.body), len(asked.points.x)
    x = np.concatenate([asked.points.x, fit_points.x])
    s = np.concatenate([asked.points.s, fit_points.s])
    u = sphere_ics(STEEL, RADIUS, asked.body.side, asked.patch, x, s)
    fit = conditions(asked.body, asked.rule, asked.loads)
    m = fit_discount(asked.body, asked.rule, fit, {load: u[:, load.direction, n:] for load in asked.loads})
    rigid = [rigid_part(m, asked.body, asked.points, load) for load in asked.loads]
    return u[..., :n] - np.swapaxes(rigid, 0, 1)


def error_and_estimate(asked, truth):
    models = {level: raw_ics(request(asked, level)) for level in Level().models().values()}
    reference = combine(asked, Level(), models)
    error, estimate = (
        np.max([line_errors(d[..., p], truth[..., p], truth[2, 2, p]) for p in LINES], axis=0)
        for d in (reference.c.ic - truth, reference.c.estimate)
    )
    return error, estimate


def test_estimates_bound_the_errors_and_are_at_most_ten_times_them():
    balls = [ball(size, f, side) for size in DOMAINS for f in MESHES for side in (LOWER, UPPER)]
    assert_honest([error_and_estimate(asked, exact(asked)) for asked in balls])


def test_the_half_space_is_not_mistaken_for_the_ball():
    asked = ball(160.0, 2.0, LOWER)
    error, estimate = error_and_estimate(asked, halfspace(asked))
    assert np.sum(error > 1.2 * estimate) >= 4, error / estimate
