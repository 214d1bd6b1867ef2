"""What is known: features and errors of random scenes, the rule of bounds, and how often these held.

Errors of approximate ICs in a studied scene are by ICs and number, with the names of `femic advise`.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from femic.advice.scenes import CREEPAGES
from femic.advice.study import FEATURES, NORMAL_ICS, NORMAL_NUMBERS, PERTURBED, ROLLING_ICS
from femic.cache.files import write_text
from femic.contact.pairs.ics import C
from geometries.arrays import Array, Indices

# --- errors in a studied scene ---

MIX, SAME_NORMAL = "mix", "Bhat"  # the mix has the nn ICs of B-hat
PRESSURE_IN_ROLLING = "p_max in rolling"  # tangential tractions change pressures, too
ROLLING_NUMBERS = (
    *("F_x/limit", "F_x", "F_y/limit", "sliding_share", "zero_creepage", "slope"),
    PRESSURE_IN_ROLLING,
)
NUMBERS = (*NORMAL_NUMBERS, *ROLLING_NUMBERS)
AWAY = np.array(CREEPAGES) != 0  # creepages at which the force is not nearly none
LEAST_FORCE = 1e-3  # over friction times load: shares of smaller forces with C are shares of this

Errors = dict[str, dict[str, float]]  # by ICs and number


def ics_errors(entry: Mapping[str, Any]) -> Errors:
    """Return the errors of all ICs of an entry against C, each a share as in docs/evidence/advice.md.

    Those without friction have a sign; of rolling, each is the largest over the creepages, without a sign.
    """
    of_normal = {name: _frictionless(entry, name) for name in NORMAL_ICS}
    of_normal[MIX] = of_normal[SAME_NORMAL]
    errors: Errors = {name: dict(row) for name, row in of_normal.items()}
    for name in ROLLING_ICS:
        if name in entry["rolling"]:
            errors[name] |= _rolling(entry, name)
    return errors


def reference_estimates(entry: Mapping[str, Any]) -> dict[str, float]:
    """Return the estimated error of C by number, on the same scales; of rolling 0 where it is not known."""
    estimates = {name: abs(error) for name, error in _frictionless(entry, PERTURBED).items()}
    return estimates | (
        _rolling(entry, PERTURBED) if PERTURBED in entry["rolling"] else dict.fromkeys(ROLLING_NUMBERS, 0.0)
    )


def _frictionless(entry: Mapping[str, Any], name: str) -> dict[str, float]:
    own, reference = entry["frictionless"][name], entry["frictionless"][C]
    return {number: own[number] / reference[number] - 1 for number in NORMAL_NUMBERS}


def _rolling(entry: Mapping[str, Any], name: str) -> dict[str, float]:
    own, reference = entry["rolling"][name], entry["rolling"][C]
    away = {
        number: np.abs(np.array(own[number]) - np.array(reference[number]))
        for number in ("F_x", "F_y", "sliding_share")
    }
    shares = away["F_x"][AWAY] / np.maximum(np.abs(np.array(reference["F_x"]))[AWAY], LEAST_FORCE)
    pressures = np.abs(np.array(own["p_max"]) / np.array(reference["p_max"]) - 1)
    return {
        PRESSURE_IN_ROLLING: float(np.max(pressures)),
        "F_x/limit": float(np.max(away["F_x"])),
        "F_x": float(np.max(shares)),
        "F_y/limit": float(np.max(away["F_y"])),
        "sliding_share": float(np.max(away["sliding_share"])),
        "zero_creepage": abs(own["zero_creepage"] - reference["zero_creepage"]) * abs(reference["slope"]),
        "slope": abs(own["slope"] / reference["slope"] - 1),
    }


# --- knowledge of many scenes ---

PACKAGED = Path(__file__).with_name("knowledge.json")
DIGITS = 4  # of stored numbers
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
        counts = [friction or not of.only_with_friction for of in FEATURES.values()]
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
    return np.array([of.on_scale(features[name]) for name, of in FEATURES.items()])


@cache
def packaged() -> Knowledge:
    """Return the knowledge of the package."""
    return read(PACKAGED)


def read(path: Path) -> Knowledge:
    """Return the knowledge of a file."""
    content = json.loads(path.read_text(encoding="utf-8"))
    scenes = [KnownScene(**scene) for scene in content["scenes"]]
    return Knowledge(scenes, Rule(**content["rule"]), BoundCoverage(**content["held"]), content["code"])


def write(knowledge: Knowledge, facts: Mapping[str, Any], path: Path = PACKAGED) -> None:
    """Write knowledge, and facts on how it was computed, to a file."""
    content = {
        "code": knowledge.code,
        **facts,
        "rule": asdict(knowledge.rule),
        "held": asdict(knowledge.held),
    }
    scenes = [json.dumps(_rounded(asdict(scene)), ensure_ascii=False) for scene in knowledge.scenes]
    head = json.dumps(content, ensure_ascii=False)[:-1]
    listed = ",\n".join(scenes)
    write_text(f'{head},\n"scenes": [\n{listed}\n]}}\n', path)


def _rounded(values: Any) -> Any:
    """Return values with numbers to `DIGITS` digits."""
    if isinstance(values, Mapping):
        return {key: _rounded(value) for key, value in values.items()}
    return float(f"{values:.{DIGITS}g}") if isinstance(values, float) else values
