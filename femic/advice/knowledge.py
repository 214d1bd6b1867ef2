"""What is known: features and errors of random scenes, the rule of bounds, and how often these held.

Features are what is known of a contact with B-hat alone, before C is solved, and on what the errors of
approximate ICs depend: by what the patch turns and where it lies, how conformal the bodies are, what lies
beyond the patch, materials, friction. Errors are by ICs and number, with the names of `femic advise`.
tools/advice_study.py solves the scenes.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from femic.contact.pairs.grids import Size
from femic.contact.specification import ContactProblem
from geometries.arrays import Array, Indices

# --- numbers ---

NORMAL_NUMBERS = ("p_max", "a", "b", "angle", "approach", "area", "stiffness")
PRESSURE_IN_ROLLING = "p_max in rolling"  # tangential tractions change pressures, too
ROLLING_NUMBERS = (
    *("F_x/limit", "F_x", "F_y/limit", "sliding_share", "zero_creepage", "slope"),
    PRESSURE_IN_ROLLING,
)

# --- features of a contact ---

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
    "angle": Feature("the angle by which the surface turns across the patch", 0.15, "deg", logarithmic=True),
    "middle": Feature("the inclination at the middle of the patch", 15.0, "deg"),
    "aspect": Feature("its aspect a/b", 0.7, logarithmic=True),
    "unlike": Feature("the relative difference of the bodies' curvatures", 1.0, logarithmic=True),
    "varying": Feature(
        "the ratio of the curvatures at the ends and at the middle of the patch", 0.5, logarithmic=True
    ),
    "beyond": Feature(
        "the inclination of the flatter flank beyond the patch, minus the inclination at the end of the "
        "patch",
        25.0,
        "deg",
    ),
    "modulus": Feature("the modulus ratio of the upper to the lower body", 0.5, logarithmic=True),
    "nu_lower": Feature("Poisson's ratio of the lower body", 0.15),
    "nu_upper": Feature("Poisson's ratio of the upper body", 0.15),
    "long": Feature("the ratio of a to the rolling radius", 1.5, logarithmic=True),
    "friction": Feature("the coefficient of friction", 0.25, only_with_friction=True),
}


def contact_features(problem: ContactProblem, size: Size) -> dict[str, float]:
    """Return the features of a contact by name; `size` is that of its patch with B-hat.

    Each angle [deg] and ratio as in `FEATURES`; 0 where there is no friction.
    """
    lower, upper = (problem.bodies[name] for name in ("lower", "upper"))
    ends, middle, friction = np.array(size.s), sum(size.s) / 2, problem.specification.friction
    inclination = np.degrees(lower.contour.inclination(ends))
    a, b = size.x[1], (size.s[1] - size.s[0]) / 2
    curvature = max(abs(float(lower.contour.curvature(middle))), FLAT)
    at_ends = np.abs(lower.contour.curvature(middle + INSIDE * b * np.array([-1.0, 1.0])))
    s = np.linspace(*upper.contour.limits, 401)  # the upper contour has the inclination of the middle there
    turned = np.abs(upper.contour.inclination(s) - float(lower.contour.inclination(middle)))
    opposite = float(upper.contour.curvature(s[np.argmin(turned)]))
    return {
        "angle": float(np.ptp(inclination)),
        "middle": abs(float(np.mean(inclination))),
        "aspect": a / b,
        "unlike": max(abs(1 - opposite / curvature), 1e-3),
        "varying": max(float(np.mean(at_ends)), FLAT) / curvature,
        "beyond": turn_beyond(problem, inclination),
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


def turn_beyond(problem: ContactProblem, ends: np.ndarray) -> float:
    """Return by how much contours turn further beyond the ends of a patch [deg], on the side of the least."""
    turns = []
    for body in problem.bodies.values():
        left, right = np.degrees(body.contour.inclination(np.array(body.contour.limits)))
        turns += [float(ends[0] - left), float(right - ends[1])]
    return min(turns)


# --- knowledge of many scenes ---

PACKAGED = Path(__file__).with_name("knowledge.json")
NEARLY = 0.1  # of the scale of a feature: so far outside of known values is still inside


@dataclass(frozen=True)
class Rule:
    """How bounds follow from the `nearest` known scenes.

    Their errors are taken to the angle of a contact as if they grew with it to the power `growth`, plus and
    minus the estimated errors of C; their range is made longer at both ends by the share `widened`.
    """

    nearest: int
    widened: float
    growth: float


@dataclass(frozen=True)
class KnownScene:
    """A solved random scene: features, errors by ICs and number, and estimated errors of C by number."""

    seed: int
    number: int
    features: Mapping[str, float]
    errors: Mapping[str, Mapping[str, float]]
    estimates: Mapping[str, float]


@dataclass(frozen=True)
class BoundCoverage:
    """In how many of some test scenes bounds held, by ICs and number: (held, of)."""

    scenes: int = 0
    counts: Mapping[str, Mapping[str, Sequence[int]]] = field(default_factory=dict)

    def count(self, ics: str, number: str) -> tuple[int, int]:
        """Return in how many scenes bounds held, and of how many; (0, 0) where none were tested."""
        held, tested = self.counts.get(ics, {}).get(number, (0, 0))
        return int(held), int(tested)


@dataclass(frozen=True)
class Knowledge:
    """Known scenes, the rule of bounds, how often they held in other scenes, and which code solved them."""

    scenes: Sequence[KnownScene]
    rule: Rule
    held: BoundCoverage = field(default_factory=BoundCoverage)
    code: str = ""

    def order(self, features: Mapping[str, float], *, friction: bool) -> Indices:
        """Return the indices of the known scenes, the most similar first."""
        apart = self._scaled - _on_scale(features)
        counts = [friction or not feature.only_with_friction for feature in FEATURES.values()]
        return np.argsort(np.linalg.norm(apart[:, counts], axis=1), kind="stable")

    @cached_property
    def _scaled(self) -> Array:
        """Features of the scenes over their scales, (scenes, features)."""
        return np.array([_on_scale(scene.features) for scene in self.scenes])

    def outside(self, features: Mapping[str, float], *, friction: bool) -> list[str]:
        """Return what lies outside of the known scenes, or nearly so, in words."""
        reasons = []
        for name, feature in FEATURES.items():
            values = [scene.features[name] for scene in self.scenes]
            low, own, high = map(feature.on_scale, (min(values), features[name], max(values)))
            if (feature.only_with_friction and not friction) or low - NEARLY <= own <= high + NEARLY:
                continue
            unit = f" {feature.unit}" if feature.unit else ""
            reasons.append(
                f"{feature.meaning} ({features[name]:.3g}{unit}; known: {min(values):.3g} ... "
                f"{max(values):.3g}{unit})"
            )
        return reasons


def _on_scale(features: Mapping[str, float]) -> Array:
    """Return features over their scales, shape (features,)."""
    return np.array([feature.on_scale(features[name]) for name, feature in FEATURES.items()])


@cache
def packaged_knowledge() -> Knowledge:
    """Return the knowledge of the package."""
    return read(PACKAGED)


def read(path: Path) -> Knowledge:
    """Return the knowledge of a file."""
    content = json.loads(path.read_text(encoding="utf-8"))
    scenes = [KnownScene(**scene) for scene in content["scenes"]]
    return Knowledge(scenes, Rule(**content["rule"]), BoundCoverage(**content["held"]), content["code"])
