"""The bodies of a contact problem as they are meshed, and the rigid part of their approach.

The bodies have the supports that contact with C gives them: the far arc of the problem, on which both are
clamped. A body without end along x is meshed as far as its far arc screens what lies beyond.
"""

from dataclasses import replace

from femic.contact.finite_elements.meshed_contact import Bodies
from femic.contact.pairs.c_jobs import job_of
from femic.contact.pairs.pair_on_grid import undeformed_of
from femic.contact.specification import ContactProblem
from femic.reference.discount import FZ
from femic.reference.matrix.reference import matrices
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.bodies import Domain
from geometries.grids import Grid

LENGTH = 3.0  # of the meshed half of a body along x, in radii of its far arc


def meshed_bodies(problem: ContactProblem) -> Bodies:
    """Return the bodies in their places, with the supports that C has, and ends that do not matter."""
    undeformed, radius = undeformed_of(problem), problem.support_radius
    lower, upper = (
        replace(problem.bodies[name], domain=Domain(radius, LENGTH * radius)) for name in ("lower", "upper")
    )
    return Bodies(lower, upper, undeformed.s_range, undeformed.shift)


def rigid_compliance(problem: ContactProblem, options: RunOptions = DEFAULT) -> float:
    """M_zz [mm/N] of both bodies on their supports, which is subtracted from the approach of contact with C.

    It needs a model of each section with a single strip, the load under which it is matched. 0 where nothing
    is subtracted.
    """
    if problem.discount == "none":
        return 0.0
    side = 2 * problem.settings.approach_side
    jobs = {name: job_of(problem, name, Grid(1, 1, side, side), ("nn",)) for name in problem.bodies}
    references = matrices(jobs, options, combined=True)
    return sum(float(reference.discount[FZ, FZ]) for reference in references.values())
