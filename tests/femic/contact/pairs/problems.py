"""A wheel on a rail as a contact problem, without a scene, for tests."""

import numpy as np

from approx.pair import Pair, Solid, matrix
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.motions.none import solve_frictionless
from femic.contact.operators.dense import Asymmetry, GridOperator
from femic.contact.pairs.ics import ReferenceICs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.quantities import numbers
from femic.contact.specification import APPROACH_SHARE, ContactProblem, ContactSpecification
from femic.reference.engines import HARMONIC
from femic.reference.harmonic.request import FAR_RADIUS
from femic.reference.job import Settings
from femic.shifts.sides import Place, bodies_at, contact_problem
from femic.shifts.specification import ContactTable
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.patches import Grid, N
from geometries.surfaces import LOWER, UPPER
from geometries.track.wheelset import settle
from tests.femic.shifts.test_shift_contact import RAIL
from tests.femic.shifts.test_shift_contact import WHEEL as WHEEL_STEEL

RADIUS, WHEEL, ROLLING = 10.0, 14.0, 400.0  # mm: arcs of rail and wheel, rolling radius
FLANKS = 60.0  # deg
SMALL = 2.0  # N: a patch of a degree in all, b / R = 0.006
DOMAIN = Domain(1280.0, 320.0)
SETTINGS = Settings(HARMONIC)


def problem(upper_radius=WHEEL, inclination=FLANKS, grid=None, **keys):
    """A softer wheel of revolution on a rail, arcs, with the keys of a specification; on a grid, if given."""
    lower, upper = (arc(radius, *[np.radians(inclination)] * 2) for radius in (RADIUS, upper_radius))
    bodies = {
        "lower": Body(LOWER, lower, Material(210e3, 0.3), DOMAIN),
        "upper": Body(UPPER, upper, Material(100e3, 0.25), DOMAIN, ROLLING),
    }
    solids = (Solid(bodies[name].material, bodies[name].surface) for name in ("upper", "lower"))
    on_grid = {} if grid is None else {"grid": "scene"}
    specification = ContactSpecification(**{"ics": ("A", "Bhat")} | on_grid | keys)
    return ContactProblem(
        "contact",
        bodies,
        Pair(*solids),
        specification,
        grid or Grid(64, 32, 0.2, 0.2),
        SETTINGS,
        "approach",
        FAR_RADIUS,
        SETTINGS.approach_side * APPROACH_SHARE,
    )


def hertz(of=None):
    """The contact of Hertz of both arcs, with the materials of a problem."""
    bodies = (of or problem()).bodies
    modulus = combined_modulus(bodies["upper"].material, bodies["lower"].material)
    return PointContact(1 / ROLLING, 1 / RADIUS - 1 / WHEEL, modulus)


def wheel_on_rail(layout, load=9e4, shift=0.0, rail=RAIL, wheel=WHEEL_STEEL):
    """Rail and left wheel of a wheelset on its track, on any grid, and the roll."""
    where = Place(layout, settle(layout, shift, roll="about rails"), "left")
    of = contact_problem(bodies_at(where, rail, wheel), ContactTable(load=load, ics=("A",)))
    return pair_on_grid(of, of.grid), where.roll


def like_bhat(*factors):
    """What computes ICs that stand for C and C plus its estimate: B-hat times factors, the last one twice."""

    def computed(of, on_grid, _):
        nn = matrix("Bhat", of.pair, on_grid.grid)[..., 2:, 2:]
        operators = [GridOperator.from_ics(f * nn, (N,)) for f in (*factors, factors[-1])[:2]]
        return ReferenceICs(*operators, 0.0, Asymmetry(0.0, "nn"), 1.0, 0.0)

    return computed


def solved(of, ics="Bhat"):
    """Numbers of the only contact of a problem with some ICs, and their estimated errors."""
    (loading,) = of.specification.loadings
    contact = solve_frictionless(of).contacts[loading, ics]
    return numbers(contact.on_grid, contact.normal), contact.estimated_errors()
