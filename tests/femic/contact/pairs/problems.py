"""A wheel on a rail as a contact problem, without a scene, for tests."""

import numpy as np

from femic.contact.pairs.frictionless import solve_frictionless
from femic.contact.pairs.quantities import numbers
from femic.contact.specification import ContactProblem, ContactSpecification
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER

RADIUS, WHEEL, ROLLING = 10.0, 14.0, 400.0  # mm: arcs of rail and wheel, rolling radius
FLANKS = 60.0  # deg
SMALL = 2.0  # N: a patch of a degree in all, b / R = 0.006
DOMAIN = Domain(1280.0, 320.0)


def problem(upper_radius=WHEEL, inclination=FLANKS, grid=None, **keys):
    """A softer wheel of revolution on a rail, arcs, with the keys of a specification; on a grid, if given."""
    lower, upper = (arc(radius, *[np.radians(inclination)] * 2) for radius in (RADIUS, upper_radius))
    bodies = (
        Body(LOWER, lower, Material(210e3, 0.3), DOMAIN),
        Body(UPPER, upper, Material(100e3, 0.25), DOMAIN, ROLLING),
    )
    on_grid = {} if grid is None else {"grid": "scene"}
    specification = ContactSpecification(**{"ics": ("A", "Bhat")} | on_grid | keys)
    return ContactProblem.of(*bodies, specification, **{} if grid is None else {"grid": grid})


def solved(of, ics="Bhat"):
    """Numbers of the only contact of a problem with some ICs, and their estimated errors."""
    (loading,) = of.specification.loadings
    contact = solve_frictionless(of).contacts[loading, ics]
    return numbers(contact.on_grid, contact.normal), contact.estimated_errors()
