"""The work of friction where little slides: what grids miss of it is in its estimate."""

import numpy as np
import pytest

from femic.contact.estimates import errors
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion
from femic.contact.motions.rolling import EDGE_SHARE, OF_ROLLING, measured_rolling
from femic.contact.pairs.ics import approximation
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.quantities import kinds, measured
from geometries.patches import Grid
from tests.femic.contact.wheel_on_rail import scene

LOAD = Loading(1e4)
SCENE = scene(
    10.3, motion="rolling", loads=[1e4], longitudinal=[0.0, 1e-4], friction=[0.3], ics=["Bhat"], elements=8
)


def rolled(xi, n_x=20, n_s=28):
    """The grid's bodies, the problem and the contact at a creepage, on 14 by 16.8 mm."""
    problem = SCENE.contact_problem
    pair = pair_in_motion(problem, pair_on_grid(problem, Grid(n_x, n_s, 14.0 / n_x, 16.8 / n_s)))
    rolling = pair.rolling(pair.frictional(approximation(pair.on_grid, "Bhat"), 0.3))
    return pair.on_grid, rolling, rolling.contact(Creepages(xi), LOAD)


def estimate(of):
    """The estimated error of work if larger elements have the same numbers."""
    return errors(kinds(OF_ROLLING), of, [of])["dissipation"]


def test_forces_that_creepages_follow_from_are_exact():
    """A wheel that rolls freely has no longitudinal force on any grid; its lateral one is computed."""
    on_grid, rolling, _ = rolled(1e-4)
    free = rolling.contact(Creepages(lateral=2e-4), LOAD, forces={"longitudinal": 0.0})
    known = measured_rolling(on_grid, rolling, free)
    assert "F_x" in known.exact
    assert not {"F_y", "p_max", "approach"} & set(known.exact)
    assert "F_x" not in measured_rolling(*rolled(1e-4)[:2], rolled(1e-4)[2]).exact


def test_the_estimate_of_work_is_at_least_what_slip_misses():
    """The work on the rigid motion converges faster: it is the judge."""
    on_grid, rolling, contact = rolled(1e-4)
    known, plain = measured_rolling(on_grid, rolling, contact), measured(on_grid, contact.contact, OF_ROLLING)
    missed = abs(rolling.power(contact) - rolling.climbing(contact) - known.numbers["dissipation"])
    assert missed > 0.3 * known.numbers["dissipation"]
    assert estimate(plain) < 0.9 * missed  # without it, grids that agree would hide it
    assert (
        missed <= estimate(known) < (1.01 + EDGE_SHARE / 0.3) * missed
    )  # and a share of the work at the edge


def test_nothing_else_changes():
    on_grid, rolling, contact = rolled(1e-4)
    known, plain = measured_rolling(on_grid, rolling, contact), measured(on_grid, contact.contact, OF_ROLLING)
    assert known.numbers == plain.numbers
    assert known.scales == plain.scales
    assert {name for name in plain.floors if known.floors[name] != plain.floors[name]} == {"work"}


def test_where_all_slides_the_slip_misses_little():
    on_grid, rolling, contact = rolled(0.05)
    assert rolling.missed_work(contact) < 2e-3 * rolling.power(contact)
    known = measured_rolling(on_grid, rolling, contact)
    assert known.floors["work"] < 2e-3 + EDGE_SHARE * 0.3  # shares of all of it; less than 0.3 is at the edge


def test_without_friction_there_is_no_work():
    problem = SCENE.contact_problem
    pair = pair_in_motion(problem, pair_on_grid(problem, Grid(20, 28, 0.7, 0.6)))
    rolling = pair.rolling(pair.frictional(approximation(pair.on_grid, "Bhat"), 0.0))
    known = measured_rolling(pair.on_grid, rolling, rolling.contact(Creepages(1e-3), LOAD))
    assert known.numbers["dissipation"] == pytest.approx(0.0, abs=1e-12)
    assert np.isfinite(list(known.floors.values())).all()
