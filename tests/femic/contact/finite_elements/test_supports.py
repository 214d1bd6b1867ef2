"""What supports add to the approach of meshed bodies is M_zz of C on the same supports, times the load."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.finite_elements.meshed_contact import Bodies, mesh_bodies, solved
from femic.reference.discount import FZ
from femic.reference.engines import HARMONIC
from femic.reference.job import Settings
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import matrices
from geometries.bodies import Domain
from geometries.patches import Grid
from tests.femic.contact.finite_elements.ellipse import HERTZ, LOAD, bodies, expected

NEAR, FAR, CELLS, LENGTH = 8.0, 32.0, 6.0, 3.0
SIDE = HERTZ.b / 2  # of the load under which M_zz is matched; differences do not depend on it


def held_at(far):
    """The pair, clamped at far arcs of a radius [mm]."""
    pair, domain = bodies(), Domain(far, LENGTH * far)
    return Bodies(replace(pair.lower, domain=domain), replace(pair.upper, domain=domain), (-6.0, 6.0))


def rigid_compliance(far):
    """M_zz of both bodies by the harmonic engine [mm/N], endless along x and all the way round."""
    pair, settings = held_at(far), Settings(HARMONIC, tolerance=0.01, approach_side=SIDE)
    jobs = {
        str(body.side): MatrixJob(
            replace(body, domain=Domain(far, np.inf)), Grid(1, 1, 2 * SIDE, 2 * SIDE), settings, ("nn",)
        )
        for body in (pair.lower, pair.upper)
    }
    return sum(reference.discount[FZ, FZ] for reference in matrices(jobs, combined=True).values())


def raw_approach(far):
    pair = held_at(far)
    return solved(pair, mesh_bodies(pair, expected(), CELLS), LOAD).solution.state.approach


@pytest.mark.slow
def test_other_supports_change_the_approach_by_their_rigid_compliance_times_the_load():
    """No number is fitted between the two: meshes of the contact and C's models of single loads."""
    added = raw_approach(FAR) - raw_approach(NEAR)
    rigid = LOAD * (rigid_compliance(FAR) - rigid_compliance(NEAR))
    assert rigid > 0.05 * HERTZ.approach
    # meshes know approaches to 0.2 %; the patch is not small beside the nearer arc: (b / NEAR)^2
    assert added == pytest.approx(rigid, abs=0.003 * HERTZ.approach + (HERTZ.b / NEAR) ** 2 * rigid)


@pytest.mark.slow
def test_ends_along_x_do_not_matter_where_bodies_are_as_long_as_they_are_meshed():
    """Clamped far arcs screen what lies beyond: half as long again is the same."""
    pair = held_at(NEAR)
    meshed = raw_approach(NEAR)
    longer = Domain(NEAR, 1.5 * LENGTH * NEAR)
    other = Bodies(replace(pair.lower, domain=longer), replace(pair.upper, domain=longer), (-6.0, 6.0))
    result = solved(other, mesh_bodies(other, expected(), CELLS), LOAD).solution.state.approach
    assert result == pytest.approx(meshed, rel=0.002)  # as well as two meshes agree
