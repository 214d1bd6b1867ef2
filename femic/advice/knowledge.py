"""What is known: features and errors of random scenes, the rule of bounds, and how often these held."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from femic.advice.features import FEATURES
from femic.cache.files import write_text
from geometries.arrays import Array, Indices

PACKAGED = Path(__file__).with_name("knowledge.json")
DIGITS = 4
WITH_FRICTION = ("F_x/limit", "F_x", "F_y/limit", "sliding_share", "zero_creepage", "slope")


@dataclass(frozen=True)
class Rule:
    """How bounds follow from the `nearest` known scenes.

    Their errors are taken as if they grew with the angle to the power `growth`; the range of these is made
    longer at both ends by the share `widened`.
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
class Held:
    """In how many of some test scenes bounds held, by ICs and number: (held, of)."""

    scenes: int = 0
    counts: Mapping[str, Mapping[str, Sequence[int]]] = field(default_factory=dict)

    def of(self, ics: str, number: str) -> tuple[int, int]:
        """Return in how many scenes bounds held, and of how many; (0, 0) where none were tested."""
        held, tested = self.counts.get(ics, {}).get(number, (0, 0))
        return int(held), int(tested)


@dataclass(frozen=True)
class Knowledge:
    """Known scenes, the rule of bounds, how often they held in other scenes, and which code solved them."""

    scenes: Sequence[KnownScene]
    rule: Rule
    held: Held = field(default_factory=Held)
    code: str = ""

    def nearest(self, features: Mapping[str, float], number: str, without: int | None = None) -> Indices:
        """Return the indices of the nearest known scenes for a number, without one of them if given."""
        names = [
            name for name, of in FEATURES.items() if number in WITH_FRICTION or not of.only_with_friction
        ]
        own = np.array([FEATURES[name].on_scale(features[name]) for name in names])
        distances = np.linalg.norm(self._scaled(tuple(names)) - own, axis=1)
        if without is not None:
            distances[without] = np.inf
        return np.argsort(distances, kind="stable")[: self.rule.nearest]

    def _scaled(self, names: tuple[str, ...]) -> Array:
        """Features of the scenes over their scales, (scenes, names)."""
        rows = [[FEATURES[name].on_scale(scene.features[name]) for name in names] for scene in self.scenes]
        return np.array(rows)

    def outside(self, features: Mapping[str, float], *, friction: bool) -> list[str]:
        """Return what lies outside of the known scenes, in words."""
        return [
            _outside(name, features[name], [scene.features[name] for scene in self.scenes])
            for name, of in FEATURES.items()
            if (friction or not of.only_with_friction)
            and not self._range(name)[0] <= features[name] <= self._range(name)[1]
        ]

    def _range(self, name: str) -> tuple[float, float]:
        """Return the least and the largest value of a feature."""
        values = [scene.features[name] for scene in self.scenes]
        return min(values), max(values)


def _outside(name: str, value: float, values: Sequence[float]) -> str:
    feature = FEATURES[name]
    unit = f" {feature.unit}" if feature.unit else ""
    return f"{feature.meaning} ({value:.3g}{unit}; known: {min(values):.3g} ... {max(values):.3g}{unit})"


@cache
def packaged() -> Knowledge:
    """Return the knowledge of the package."""
    return read(PACKAGED)


def read(path: Path) -> Knowledge:
    """Return the knowledge of a file."""
    content = json.loads(path.read_text(encoding="utf-8"))
    scenes = [KnownScene(**scene) for scene in content["scenes"]]
    return Knowledge(scenes, Rule(**content["rule"]), Held(**content["held"]), content["code"])


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
