"""A ball of revolution against the exact solution of the sphere: curvature, local frames, estimate."""

import numpy as np
import pytest

from femic.reference.discount import fit_discount, rigid_part
from femic.reference.result import combine
from femic.reference.run_options import MODELS, Level
from femic.reference.solid.engine import raw_ics
from geometries.contours import arc
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import STEEL, assert_honest, line_errors
from tests.femic.reference.solid.test_flat import LINES, halfspace, job
from tests.truths.sphere import sphere_ics

RADIUS = 300.0
MESHES, DOMAINS = (2.8, 2.4, 2.0), (80.0, 160.0)


def ball(size, factor, side, *, s=0.0, right_flank=1.2):
    """Crown of the lower ball, bottom of the upper one: the contour falls away from the other body."""
    contour = arc(-side * RADIUS, 1.2, right_flank)
    return job(size, factor, side=side, s=s, contour=contour, rolling_radius=RADIUS)


def exact(asked):
    """The sphere's ICs with the same discount; its load is balanced far away, not at the far arc."""
    body, rule, fit = asked.body, asked.rule, asked.fit
    at_fit_points = {load: displacements(body, load, rule.points(body)) for c in fit for load in c.loads}
    m = fit_discount(body, rule, fit, at_fit_points)
    columns = [
        displacements(body, load, asked.points) - rigid_part(m, body, asked.points, load)
        for load in asked.loads
    ]
    return np.stack(columns, axis=1)


def displacements(body, load, points):
    """Of the ball, shape (3, n)."""
    ics = sphere_ics(STEEL, RADIUS, body.side, load.patch, points.x, points.s)
    return ics[:, load.direction]


def error_and_estimate(asked, truth):
    models = {level: raw_ics(asked.request(level)) for level in Level().models(MODELS).values()}
    reference = combine(asked, Level(), models)
    error, estimate = (
        np.max([line_errors(d[..., p], truth[..., p], truth[2, 2, p]) for p in LINES], axis=0)
        for d in (reference.c.ic - truth, reference.c.estimate)
    )
    return error, estimate


def test_estimates_bound_the_errors_of_a_small_ball():
    """One of the balls of the test below."""
    asked = ball(DOMAINS[0], MESHES[0], UPPER)
    error, estimate = error_and_estimate(asked, exact(asked))
    assert np.all(error <= estimate), error / estimate


@pytest.mark.slow
def test_estimates_bound_the_errors_and_are_at_most_ten_times_them():
    balls = [ball(size, f, side) for size in DOMAINS for f in MESHES for side in (LOWER, UPPER)]
    assert_honest([error_and_estimate(asked, exact(asked)) for asked in balls])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("side", "inclined", "symmetric"),
    [
        (LOWER, {"s": 40.0}, True),
        (UPPER, {"s": -25.0, "right_flank": 1.1}, False),
    ],
)
def test_estimates_bound_the_errors_of_off_centre_loads(side, inclined, symmetric):
    """8 and 5 degrees inclined: even and odd parts on a quarter of the ball, half of it if flanks differ."""
    asked = ball(160.0, 2.8, side, **inclined)
    assert asked.body.contour.symmetric == symmetric
    assert_honest([error_and_estimate(asked, exact(asked))])


@pytest.mark.slow
def test_the_half_space_is_not_mistaken_for_the_ball():
    asked = ball(160.0, 2.0, LOWER)
    error, estimate = error_and_estimate(asked, halfspace(asked))
    assert np.sum(error > 1.2 * estimate) >= 4, error / estimate
