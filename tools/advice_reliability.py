"""Errors in solved scenes, and how often bounds of errors hold and decisions by them are right in others."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from advice_scenes import CREEPAGES, NORMAL_ICS, PERTURBED, ROLLING_ICS

from femic.advice.expected import Bounds, bounds_at, bounds_by
from femic.advice.knowledge import (
    NORMAL_NUMBERS,
    PACKAGED,
    PRESSURE_IN_ROLLING,
    ROLLING_NUMBERS,
    BoundCoverage,
    Knowledge,
    KnownScene,
    Rule,
)
from femic.cache.files import write_text
from femic.contact.pairs.ics import C

# --- errors in a solved scene ---

MIX, SAME_NORMAL = "mix", "Bhat"  # the mix has the nn ICs of B-hat
NUMBERS = (*NORMAL_NUMBERS, *ROLLING_NUMBERS)
AWAY = np.array(CREEPAGES) != 0  # creepages at which the force is not nearly none
LEAST_FORCE = 1e-3  # over friction times load: shares of smaller forces with C are shares of this

Errors = dict[str, dict[str, float]]  # by ICs and number


def ics_errors(entry: Mapping[str, Any]) -> Errors:
    """Return the errors of all ICs of an entry against C, each a share as in docs/evidence/advice.md.

    Those without friction have a sign; of rolling, each is the largest over the creepages, without a sign.
    """
    errors = {name: _frictionless(entry, name) for name in NORMAL_ICS}
    errors[MIX] = dict(errors[SAME_NORMAL])
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


# --- bounds and decisions in other scenes ---

TOLERANCES = 0.02, 0.05, 0.1  # of decisions
RULES = tuple(Rule(*rule) for rule in product((6, 8, 12, 20), (0.1, 0.25, 0.5, 1.0), (0.0, 1.0, 2.0)))
LEAST_HELD = 0.95  # share of bounds that hold in known scenes, each left out once, with the chosen rule
WORST = 10  # trials that are listed


@dataclass(frozen=True)
class Trial:
    """An error in a scene, its bounds without this scene, and the estimated error of C, shares all."""

    scene: KnownScene
    ics: str
    number: str
    bounds: Bounds

    @property
    def error(self) -> float:
        """The size of the error."""
        return abs(self.scene.errors[self.ics][self.number])

    @property
    def estimate(self) -> float:
        """The estimated error of C."""
        return self.scene.estimates[self.number]

    @property
    def beyond(self) -> float:
        """By how much the error is beyond its bounds and the estimate of C; 0 or less: they hold."""
        return max(self.bounds.low - self.error, self.error - self.bounds.high) - self.estimate

    def outcome(self, tolerance: float) -> str:
        """Return how a decision ends: right, wrong, not decided; open where the estimate of C decides."""
        if self.bounds.low <= tolerance < self.bounds.high:
            return "undecided"
        if abs(self.error - tolerance) <= self.estimate:
            return "open"
        good = self.bounds.high <= tolerance
        return "right" if good == (self.error <= tolerance) else "wrong"


def known_scenes(entries: Sequence[dict[str, Any]]) -> list[KnownScene]:
    """Return the scenes of entries that have a solution."""
    return [
        KnownScene(
            entry["seed"], entry["number"], entry["features"], ics_errors(entry), reference_estimates(entry)
        )
        for entry in entries
        if "failure" not in entry
    ]


def trials(knowledge: Knowledge, tested: Sequence[KnownScene]) -> Iterator[Trial]:
    """Yield the trials of scenes within what is known."""
    for scene in tested:
        for number in NUMBERS:
            if knowledge.outside(scene.features, friction=number in ROLLING_NUMBERS):
                continue
            for ics, bounds in bounds_at(knowledge, scene.features, number).items():
                if number in scene.errors.get(ics, {}):
                    yield Trial(scene, ics, number, bounds)


def choose_rule(scenes: Sequence[KnownScene]) -> Rule:
    """Return the rule by which most decisions are right in known scenes, each left out once.

    Among those whose bounds hold in `LEAST_HELD` of all trials; where none does, the one that holds most.
    """
    knowledge, most = Knowledge(scenes, RULES[0]), max(rule.nearest for rule in RULES)
    others: list[dict[bool, list[KnownScene]]] = []  # the most similar first, by whether friction counts
    for scene in scenes:
        orders = {friction: knowledge.order(scene.features, friction=friction) for friction in (False, True)}
        others.append(
            {
                friction: [scenes[k] for k in order if scenes[k] is not scene][:most]
                for friction, order in orders.items()
            }
        )
    scores = {}
    for rule in RULES:
        tried = []
        for scene, similar in zip(scenes, others, strict=True):
            for ics, number in ((one, other) for one in scene.errors for other in scene.errors[one]):
                nearest = similar[number in ROLLING_NUMBERS][: rule.nearest]
                if bounds := bounds_by(rule, nearest, scene.features["angle"], (ics, number)):
                    tried.append(Trial(scene, ics, number, bounds))
        held = sum(trial.beyond <= 0 for trial in tried) / max(len(tried), 1)
        right = sum(trial.outcome(tolerance) == "right" for trial in tried for tolerance in TOLERANCES)
        scores[rule] = (held >= LEAST_HELD, right) if held >= LEAST_HELD else (False, held)
    return max(scores, key=scores.__getitem__)


def check_bounds(knowledge: Knowledge, scenes: Sequence[KnownScene]) -> tuple[Knowledge, list[Trial]]:
    """Return the knowledge with how often its bounds held in other scenes, and the trials."""
    tried = list(trials(knowledge, scenes))
    counts: dict[str, dict[str, list[int]]] = {}
    for trial in tried:
        count = counts.setdefault(trial.ics, {}).setdefault(trial.number, [0, 0])
        count[0] += trial.beyond <= 0
        count[1] += 1
    return replace(knowledge, held=BoundCoverage(len(scenes), counts)), tried


def coverage_rows(tried: Sequence[Trial]) -> list[dict[str, Any]]:
    """Return how bounds held and decisions ended, by number and ICs."""
    groups: dict[tuple[str, str], list[Trial]] = {}
    for trial in tried:
        groups.setdefault((trial.number, trial.ics), []).append(trial)
    return [
        {
            "number": number,
            "ics": ics,
            "scenes": len(group),
            "held": sum(trial.beyond <= 0 for trial in group),
            "median_high": _finite(float(np.median([trial.bounds.high for trial in group]))),
            "median_error": float(np.median([trial.error for trial in group])),
            "largest_error": max(trial.error for trial in group),
            "decisions": [
                {"tolerance": tolerance, **count_outcomes(group, tolerance)} for tolerance in TOLERANCES
            ],
        }
        for (number, ics), group in sorted(groups.items(), key=lambda item: NUMBERS.index(item[0][0]))
    ]


def _finite(bound: float) -> float | None:
    """Return a bound; None where there is none, as JSON has no infinity."""
    return bound if np.isfinite(bound) else None


def count_outcomes(tried: Sequence[Trial], tolerance: float) -> dict[str, int]:
    """Return how many decisions at a tolerance end in which way."""
    outcomes = [trial.outcome(tolerance) for trial in tried]
    return {name: outcomes.count(name) for name in ("right", "wrong", "undecided", "open")}


def worst_trials(tried: Sequence[Trial]) -> list[dict[str, Any]]:
    """Return the errors that are farthest beyond their bounds, and the features of their scenes."""
    failed = sorted((trial for trial in tried if trial.beyond > 0), key=lambda trial: -trial.beyond)
    return [
        {
            "scene": f"{trial.scene.seed}-{trial.scene.number}",
            "number": trial.number,
            "ics": trial.ics,
            "error": trial.error,
            "low": trial.bounds.low,
            "high": _finite(trial.bounds.high),
            "estimate": trial.estimate,
            "features": dict(trial.scene.features),
        }
        for trial in failed[:WORST]
    ]


# --- file of knowledge ---

DIGITS = 4  # of stored numbers


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
