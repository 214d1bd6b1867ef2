"""What errors to expect of approximate ICs in a contact, from known scenes like it, before C is solved."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from femic.advice.knowledge import (
    NORMAL_NUMBERS,
    PRESSURE_IN_ROLLING,
    ROLLING_NUMBERS,
    Knowledge,
    KnownScene,
    Rule,
    contact_features,
    packaged_knowledge,
    saturation,
)
from femic.contact.pairs.grids import Size, contact_size
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.specification import ContactProblem
from geometries.errors import Failure

MOTIONS, DISCOUNT = ("none", "rolling"), "approach"  # that were studied
UNBOUNDED = ("F_x",)  # shares that grow without bound where the force vanishes: no largest is known

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Bounds:
    """Between what the size of an error lies, a share."""

    low: float
    high: float


@dataclass(frozen=True)
class Expectation:
    """Bounds of errors by ICs and number, from how many known scenes, and how often such bounds held."""

    bounds: Mapping[tuple[str, str], Bounds]
    knowledge: Knowledge
    studied: Mapping[str, str]  # names of the numbers in known scenes

    def high(self, ics: str, number: str) -> float:
        """Return the largest error to be expected, a share; infinite where nothing is known."""
        return self.bounds[ics, number].high if (ics, number) in self.bounds else np.inf

    def describe(self, ics: str, number: str) -> str:
        """Return what is expected of one number with some ICs, from what, and how often that was right."""
        if (ics, number) not in self.bounds:
            return f"No errors of {number} with {ics} are on record."
        low, high = self.bounds[ics, number].low, self.bounds[ics, number].high
        expected = f"to {100 * high:.1f} %" if np.isfinite(high) else "% or more"
        held, tested = self.knowledge.held.count(ics, self.studied[number])
        how_often = (
            f"bounds of this kind held in {held} of {tested} random scenes" if tested else "not tested"
        )
        return (
            f"Expected error of {number} with {ics}, from the {self.knowledge.rule.nearest} most similar "
            f"of {len(self.knowledge.scenes)} solved scenes: {100 * low:.1f} {expected}; {how_often}."
        )


def expect(
    problem: ContactProblem, want: Sequence[str], knowledge: Knowledge | None = None
) -> Expectation | None:
    """Return what errors to expect of the wanted numbers, at all loads and coefficients of friction together.

    None where the contact lies outside of what is known; why is logged. `knowledge` is by default that of the
    package.
    """
    knowledge = knowledge or packaged_knowledge()
    specification, friction = problem.specification, problem.specification.friction
    cases: list[tuple[dict[str, float], Size]] = []  # features and patch of each loading and friction
    try:
        on_grid = pair_on_grid(problem, problem.grid)
        for loading in specification.loadings:
            size = contact_size(on_grid, loading)
            features = contact_features(problem, size)
            coefficients = friction.coefficients if friction else (0.0,)
            cases += [(features | {"friction": coefficient}, size) for coefficient in coefficients]
    except Failure as failure:
        log.info(f"{problem.name}: no advice from solved scenes: {failure}")
        return None
    if reasons := _reasons(problem, cases, want, knowledge):
        log.info(f"{problem.name}: outside the range of the solved scenes: {'; '.join(reasons)}")
        return None
    spanned = True  # creepages reach as far as those studied; of fewer, the largest error may be smaller
    if friction is not None:
        load = max(specification.loads or (np.inf,))
        steps = [saturation(problem, size, features["friction"], load) for features, size in cases]
        spanned = min(friction.longitudinal) <= -max(steps) and max(steps) <= max(friction.longitudinal)
    bounds, studied = {}, _studied(problem, want)
    for number, name in studied.items():
        known = [bounds_at(knowledge, features, name) for features, _ in cases]
        for ics in known[0]:
            each = [by_ics[ics] for by_ics in known if ics in by_ics]
            if len(each) == len(known):
                low = max(one.low for one in each) if spanned else 0.0
                bounds[ics, number] = Bounds(low, max(one.high for one in each))
    return Expectation(bounds, knowledge, studied)


def _studied(problem: ContactProblem, want: Sequence[str]) -> dict[str, str]:
    """Return the names of wanted numbers in known scenes; without those that were not studied there.

    With friction tangential tractions change pressures and patches. Of these, p_max alone was studied so.
    """
    if problem.specification.friction is None:
        return {name: name for name in want if name in NORMAL_NUMBERS}
    return {name: name for name in want if name in ROLLING_NUMBERS} | {
        name: PRESSURE_IN_ROLLING for name in want if name == "p_max"
    }


def bounds_at(
    knowledge: Knowledge, features: Mapping[str, float], number: str, without: int | None = None
) -> dict[str, Bounds]:
    """Return the bounds of the errors of a number at features, by ICs, by the rule of `knowledge`.

    Left out are ICs of which too few errors are known. `without`: the index of a scene that does not count.
    """
    order = knowledge.order(features, friction=number in ROLLING_NUMBERS)
    nearest = [knowledge.scenes[index] for index in order if index != without][: knowledge.rule.nearest]
    names = dict.fromkeys(ics for scene in nearest for ics in scene.errors)
    found = {ics: bounds_by(knowledge.rule, nearest, features["angle"], (ics, number)) for ics in names}
    return {ics: bounds for ics, bounds in found.items() if bounds is not None}


def bounds_by(
    rule: Rule, nearest: Sequence[KnownScene], angle: float, which: tuple[str, str]
) -> Bounds | None:
    """Return the bounds of an error by a rule from scenes, where the patch turns by an angle [deg].

    `which`: ICs and number; numbers of `UNBOUNDED` have a least error alone. None where fewer than half of
    the scenes have one.
    """
    (ics, number), errors = which, []
    for scene in nearest:
        if number in scene.errors.get(ics, {}):
            grown, estimate = (angle / scene.features["angle"]) ** rule.growth, scene.estimates[number]
            errors += [grown * (scene.errors[ics][number] + part) for part in (-estimate, estimate)]
    if len(errors) < rule.nearest:  # two of each
        return None
    more = rule.widened * (max(errors) - min(errors))
    low, high = min(errors) - more, max(errors) + more
    least = 0.0 if low <= 0 <= high else min(abs(low), abs(high))
    return Bounds(least, np.inf if number in UNBOUNDED else max(abs(low), abs(high)))


def _reasons(
    problem: ContactProblem,
    cases: Sequence[tuple[Mapping[str, float], Size]],
    want: Sequence[str],
    knowledge: Knowledge,
) -> list[str]:
    """Return why a contact lies outside of what is known, in words."""
    specification, friction = problem.specification, problem.specification.friction
    unstudied = {
        f"motion = {specification.motion}": specification.motion not in MOTIONS,
        f"discount = {problem.discount}": problem.discount != DISCOUNT,
        "gap = exact": specification.exact,
        "a lateral force": specification.lateral_force is not None,
        "an extra gap": specification.extra_gap is not None,
        "lateral creepage or spin": friction and (friction.lateral or friction.spin),
        "friction that depends on the contact angle": friction and friction.friction_by_angle,
        **{
            f"the outline of the {name} body": body.outline is not None
            for name, body in problem.bodies.items()
        },
        f"{', '.join(want)} of this motion": not _studied(problem, want),
    }
    reasons = [reason for reason, holds in unstudied.items() if holds]
    for features, size in cases:
        reasons += ["several patches"] if size.smallest is not None else []
        reasons += knowledge.outside(features, friction=friction is not None)
        reasons += [
            f"a jump in the curvature of the {name} contour within the patch"
            for name, body in problem.bodies.items()
            if any(size.s[0] < jump < size.s[1] for jump in body.contour.jumps)
        ]
    return list(dict.fromkeys(reasons))
