"""A contact of Hertz's: crossed bodies whose patch is an ellipse, of different materials."""

from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.finite_elements.bodies import Expected
from femic.contact.finite_elements.meshed_contact import Bodies
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER

STEEL, BRASS = Material(210e3, 0.28), Material(100e3, 0.35)
ROLLING_RADIUS, OF_LOWER, OF_UPPER = 200.0, 150.0, 250.0  # mm; both are convex
LOAD = 900.0  # N
SURFACES = PointContact(1 / ROLLING_RADIUS, 1 / OF_LOWER + 1 / OF_UPPER, combined_modulus(STEEL, BRASS))
HERTZ = SURFACES.at_load(LOAD)


def bodies(*, symmetric=True, far=25.0, shift=0.0):
    """The bodies, in domains of some half-lengths; flanks make them unsymmetric, far from the patch."""
    flank = 0.6 if symmetric else 0.5
    domain = Domain(far, far)
    lower = Body(LOWER, arc(OF_LOWER, flank, 0.6), STEEL, domain)
    upper = Body(UPPER, arc(-OF_UPPER, flank, 0.6), BRASS, domain, rolling_radius=ROLLING_RADIUS)
    return Bodies(lower, upper, (-10.0, 10.0), shift)


def expected(middle=0.0):
    """Hertz's patch, its middle at an arc length [mm]."""
    return Expected(HERTZ.a, (middle - HERTZ.b, middle + HERTZ.b))
