"""What is known of a contact before C is solved, and on what the errors of approximate ICs depend.

With B-hat alone: by what the patch turns and where it lies, how conformal the bodies are, what lies beyond
the patch, materials, friction.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from femic.contact.pairs.contact_size import Size
from femic.contact.specification import ContactProblem
from geometries.contours import Contour

FLAT = 1e-6  # curvature [1/mm] below which a contour is flat
INSIDE = 0.98  # of a patch, over which its curvatures are compared
SATURATION = 4.0  # G a b times this is a slope of creep forces, nearly that of Kalker's linear theory


@dataclass(frozen=True)
class Feature:
    """A number on which errors depend: in words, and the difference that counts like one of 1 elsewhere."""

    meaning: str
    scale: float
    unit: str = ""
    logarithmic: bool = False
    only_with_friction: bool = False

    def on_scale(self, value: float) -> float:
        """Return a value over the scale."""
        return float(np.log(value) if self.logarithmic else value) / self.scale


FEATURES: Mapping[str, Feature] = {
    "angle": Feature("the angle by which the patch turns", 0.15, "deg", logarithmic=True),
    "middle": Feature("the inclination at its middle", 15.0, "deg"),
    "aspect": Feature("its aspect a/b", 0.7, logarithmic=True),
    "unlike": Feature("the relative difference of the bodies' curvatures", 1.0, logarithmic=True),
    "varying": Feature("the curvature at its ends over that at its middle", 0.5, logarithmic=True),
    "beyond": Feature(
        "the inclination of the flatter flank beyond its ends, less that of the end", 25.0, "deg"
    ),
    "modulus": Feature("the modulus of the upper over that of the lower body", 0.5, logarithmic=True),
    "nu_lower": Feature("Poisson's ratio of the lower body", 0.15),
    "nu_upper": Feature("Poisson's ratio of the upper body", 0.15),
    "long": Feature("a over the rolling radius", 1.5, logarithmic=True),
    "friction": Feature("the coefficient of friction", 0.25, only_with_friction=True),
}


def features_of(problem: ContactProblem, size: Size) -> dict[str, float]:
    """Return the features of a contact by name; `size` is that of its patch with B-hat.

    Each angle [deg] and ratio as in `FEATURES`; 0 where there is no friction.
    """
    lower, upper = (problem.bodies[name] for name in ("lower", "upper"))
    ends, middle = np.array(size.s), sum(size.s) / 2
    inclination = np.degrees(lower.contour.inclination(ends))
    a, b = size.x[1], (size.s[1] - size.s[0]) / 2
    friction = problem.specification.friction
    return {
        "angle": float(np.ptp(inclination)),
        "middle": abs(float(np.mean(inclination))),
        "aspect": a / b,
        "unlike": _unlike(problem, middle),
        "varying": _varying(lower.contour, size),
        "beyond": _beyond(problem, inclination),
        "modulus": upper.material.E / lower.material.E,
        "nu_lower": lower.material.nu,
        "nu_upper": upper.material.nu,
        "long": a / upper.rolling_radius,
        "friction": max(friction.coefficients) if friction else 0.0,
    }


def saturation(problem: ContactProblem, size: Size, friction: float, load: float) -> float:
    """Return a creepage at which a contact is nearly saturated: friction times load over a linear slope."""
    compliance = np.mean([1 / body.material.G for body in problem.bodies.values()])
    a, b = size.x[1], (size.s[1] - size.s[0]) / 2
    return float(friction * load * compliance / (SATURATION * a * b))


def _unlike(problem: ContactProblem, s: float) -> float:
    """Return 1 less the curvature of the upper over that of the lower contour, where both face each other."""
    lower, upper = (problem.bodies[name].contour for name in ("lower", "upper"))
    own = abs(float(lower.curvature(s)))
    return max(abs(1 - _curvature_at(upper, float(lower.inclination(s))) / max(own, FLAT)), 1e-3)


def _curvature_at(contour: Contour, inclination: float) -> float:
    """Return the curvature of a contour where it has an inclination [rad], or comes nearest to it."""
    s = np.linspace(*contour.limits, 401)
    return float(contour.curvature(s[np.argmin(np.abs(contour.inclination(s) - inclination))]))


def _varying(contour: Contour, size: Size) -> float:
    """Return the mean curvature at both ends of a patch over that at its middle."""
    middle, half = sum(size.s) / 2, INSIDE * (size.s[1] - size.s[0]) / 2
    ends = np.abs(contour.curvature(middle + half * np.array([-1.0, 1.0])))
    return max(float(np.mean(ends)), FLAT) / max(abs(float(contour.curvature(middle))), FLAT)


def _beyond(problem: ContactProblem, ends: np.ndarray) -> float:
    """Return by how much contours turn further beyond the ends of a patch [deg], on the side of the least."""
    turns = []
    for body in problem.bodies.values():
        left, right = np.degrees(body.contour.inclination(np.array(body.contour.limits)))
        turns += [float(ends[0] - left), float(right - ends[1])]
    return min(turns)
