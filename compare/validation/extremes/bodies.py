"""Bodies in contact at limits, as scenes, and the contacts of Hertz of those that have one.

Rollers on crowns, so flat that half-spaces and Hertz hold; a wheel whose groove embraces a rail; two bumps.
"""

from typing import Any

import numpy as np

from compare.validation.extremes.engines import NO_CHANGES, Changes
from femic.contact.exact.hertz import LoadedPoint, PointContact, combined_modulus
from femic.contact.specification import ContactProblem, Profile
from geometries.contours import Contour

CROWN, ROLLER = 300.0, 500.0  # mm
TIGHT = 10.0  # radius of the arc of a rail that a groove embraces [mm]
FLANK = 60.0  # degrees
BUMP_RADIUS, APART = 50.0, 6.0  # of two bumps, and their distance [mm]
BUMP_GRID = {"n_x": 48, "n_s": 208, "dx": 0.04, "ds": 0.04}
BUMP_POINTS = 4001  # of a gap that is linear between them
STEP = 1e-4  # mm, to both sides of a crown, for its curvature

# --- scenes ----------------------------------------------------------------------------------------------


def crossed(
    load: float,
    *,
    crown: float = CROWN,
    roller: float = ROLLER,
    bodies: Changes = NO_CHANGES,
    **contact: Any,
) -> Changes:
    """Return changes of `flat`: a roller on a rail with a crown, so flat that Hertz and A hold.

    `bodies` has further keys of both.
    """
    return {
        "lower": {"contour": _arc(crown, 20.0), **bodies.get("lower", {})},
        "upper": {"rolling_radius": roller, **bodies.get("upper", {})},
        "contact": {"loads": [load], "ics": ["A"], **contact},
    }


def conformal(
    load: float,
    ratio: float,
    *,
    flanks: float | list[float] = FLANK,
    roller: float = ROLLER,
    bodies: Changes = NO_CHANGES,
    **contact: Any,
) -> Changes:
    """Return changes of `geometry1`: a wheel whose groove is by a ratio wider than the rail it embraces.

    `bodies` has further keys of both.
    """
    return {
        "lower": {"contour": _arc(TIGHT, flanks), **bodies.get("lower", {})},
        "upper": {
            "contour": _arc(TIGHT * (1 + ratio), flanks),
            "rolling_radius": roller,
            **bodies.get("upper", {}),
        },
        "contact": {"loads": [load], "ics": ["Bhat"], **contact},
        "engine": {"kind": "harmonic", "check": False, "tolerance": 0.1},
    }


def _arc(radius: float, flanks: float | list[float]) -> Changes:
    return {"kind": "arc", "radius": radius, "flank_inclination_deg": flanks}


def bumps(*, load: float = 200.0, automatic: bool = False, **contact: Any) -> Changes:
    """Return changes of `flat`: a roller above two bumps (`two_bumps`), on a grid that has both."""
    own: Changes = {} if automatic else {"grid": BUMP_GRID, "rotation_reach": 5.0}
    kind = "automatic" if automatic else "scene"
    return {
        **own,
        "upper": {"rolling_radius": BUMP_RADIUS},
        "contact": {"loads": [load], "ics": ["A"], "grid": kind, **contact},
    }


def two_bumps() -> Profile:
    """Return the gap between a plane and two bumps along x, by whose radius it is curved."""
    s = np.linspace(-4 * APART, 4 * APART, BUMP_POINTS)
    return Profile(s, (np.abs(s) - APART / 2) ** 2 / (2 * BUMP_RADIUS))


def base_of(changes: Changes) -> str:
    """Return the name of the built-in scene that changes of rollers or of conformal bodies are of."""
    return "geometry1" if "engine" in changes else "flat"


# --- Hertz -----------------------------------------------------------------------------------------------


def hertz_of(problem: ContactProblem) -> LoadedPoint:
    """Return the contact of Hertz of the bodies at their crowns, under the last load."""
    lower, upper = (problem.bodies[name] for name in ("lower", "upper"))
    modulus = combined_modulus(upper.material, lower.material)
    across = _curvature(lower.contour) - _curvature(upper.contour)
    surfaces = PointContact(1 / upper.rolling_radius, across, modulus)
    return surfaces.at_load(problem.specification.loads[-1])


def _curvature(contour: Contour) -> float:
    """Return the derivative of the inclination at s = 0 [1/mm]."""
    return float(np.ptp(contour.inclination(np.array([-STEP, STEP])))) / (2 * STEP)


def one_of_two(problem: ContactProblem) -> LoadedPoint:
    """Return the contact of Hertz of one of two bumps, under half of the load."""
    modulus = combined_modulus(*(problem.bodies[name].material for name in ("upper", "lower")))
    curvature = 1 / BUMP_RADIUS
    return PointContact(curvature, curvature, modulus).at_load(problem.specification.loads[-1] / 2)
