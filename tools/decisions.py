"""The numbers of docs/decide/which-ics.md: where the errors of ICs in contact pass tolerances.

Pairs of arcs by conformity (radius ratio) and flanks, academic pairs, wheels on rails, and wheels that
roll with friction, each on one grid with one C. Called by tools/write_docs.py; models are stored in
out/decisions/.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

from compare.studies.validity_limits import (
    LOAD_ACCURACY,
    NUMBERS,
    Crossing,
    Ladder,
    Law,
    PairDeviations,
    RollingDeviations,
    find_crossing,
    solve_deviations,
)
from femic.cache.digests import STUDY_FOLDERS, results_digest, versions
from femic.cache.store import Store
from femic.contact.motions import solve_with_friction
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import numbers
from femic.reference.run_options import RunOptions, Watch, cores
from femic.scenes.load import load_scene, scene_from_table
from femic.scenes.scene import Scene

STORE = Path("out") / "decisions" / "store"
STEEL = {"E": 210e3, "nu": 0.28}
RADIUS, ROLLING_RADIUS = 10.0, 500.0  # of the rail's arc and of the wheel [mm]
ELEMENTS, TOLERANCE = 24, 0.03  # across the largest patch; of C
ROLLING_ELEMENTS, ROLLING_LOADS = 20, 5
CHANGES: Mapping[str, Mapping[str, Any]] = {
    "contact": {"elements": ELEMENTS},
    "engine": {"tolerance": TOLERANCE},
}
ICS = ("A", "Bhat")
WITH_FRICTION = ("A", "Bhat", "Bhat_prime", "mix")
TOLERANCES = {"p_max": (0.01, 0.02, 0.05, 0.1)} | dict.fromkeys(NUMBERS[1:], (0.05,))
OF_FORCES = {"half": (0.025, 0.05), "free": (0.05, 0.1), "sliding": ()}
SAME = 0.05  # loads that differ by less are one
FORCE_ACCURACY = 0.08  # of a load, relative: 2 % of the angle
FRICTIONS = (0.2, 0.4, 0.6)
ROLLS = "rolling of"  # in front of names of pairs with friction
MOST_ON_RAILS = 150e3  # N
WIDEST = 60.0  # flanks of arcs [deg]
MOST_ROLLING = 1e6  # N


@dataclass(frozen=True)
class Case:
    """A pair: its name, what it is in words and in short, and the loads solved.

    Of arcs also the ratio of radii and the flanks [deg].
    """

    name: str
    title: str
    short: str
    scene: Callable[[], Scene]
    ladder: Ladder
    ratio: float | None = None
    flanks: float | None = None


def arcs(ratio: float, flanks: float) -> Scene:
    """Return a wheel on a rail, sections of arcs whose radii have a ratio."""
    lower = {"kind": "arc", "radius": RADIUS, "flank_inclination_deg": flanks}
    upper = lower | {"radius": RADIUS * ratio}
    return scene_from_table(
        {
            "lower": STEEL | {"contour": lower},
            "upper": STEEL | {"contour": upper, "rolling_radius": ROLLING_RADIUS},
            "patch": {"a": 0.1, "b": 0.1},
            **CHANGES,
            "contact": CHANGES["contact"] | {"loads": [1e4], "flanks": False},
        },
        f"arcs-{ratio:g}-{flanks:g}",
    )


def _arcs(ratio: float, flanks: float) -> Case:
    at_flanks = "" if flanks == WIDEST else f", flanks at {flanks:g}°"
    title = f"arcs of {RADIUS:g} and {RADIUS * ratio:g} mm{at_flanks}"
    ladder = Ladder(25.0 if flanks == WIDEST else 15.0, 1.5 * flanks)
    name = f"arcs-{ratio:g}-{flanks:g}"
    return Case(name, title, f"1 : {ratio:g}{at_flanks}", lambda: arcs(ratio, flanks), ladder, ratio, flanks)


def _builtin(name: str, title: str, short: str, ladder: Ladder) -> Case:
    return Case(name, title, short, lambda: load_scene(name, CHANGES), ladder)


CASES = {
    case.name: case
    for case in (
        *(_arcs(ratio, WIDEST) for ratio in (1.01, 1.02, 1.05, 1.1, 1.25)),
        *(_arcs(ratio, 30.0) for ratio in (1.1,)),
        _builtin("tall", "`tall`", "tall", Ladder(25.0, 140.0, 310e3)),
        _builtin("wide", "`wide`", "wide", Ladder(25.0, 140.0, 18000e3)),
        _builtin(
            "s1002-on-60e1",
            "S1002 on 60E1, flange root on gauge corner",
            "60E1",
            Ladder(12.0, 120.0, MOST_ON_RAILS),
        ),
        _builtin(
            "s1002-on-60e1-worn", "S1002 on 60E1, worn", "60E1 worn", Ladder(12.0, 120.0, MOST_ON_RAILS)
        ),
    )
}


@dataclass(frozen=True)
class RollingCase:
    """A pair that rolls with friction: `rolling`, or with another section of its wheel.

    In short, the smallest and the largest angle [deg], the largest load [N], and, by keys, what is not as in
    `rolling`: its fit of B-hat-prime is that of a wheel of 10.1 mm on its rail, whatever the wheel.
    """

    name: str
    short: str
    smallest_angle: float
    largest_angle: float
    largest_load: float
    changes: Mapping[str, Any] = field(default_factory=dict)
    frictions: tuple[float, ...] = FRICTIONS


def _rolling_arc(ratio: float) -> RollingCase:
    """Return the rail of `rolling` under a wheel whose section is an arc."""
    contour = {"kind": "arc", "radius": RADIUS * ratio, "flank_inclination_deg": WIDEST}
    title = f"its rail under a wheel with an arc of {RADIUS * ratio:g} mm"
    changes = {"title": title, "upper": {"contour": contour}}
    return RollingCase(f"arc-{ratio:g}", f"1 : {ratio:g}", 40.0, 1.5 * WIDEST, MOST_ROLLING, changes)


ROLLING = {
    f"{ROLLS} {case.name}": case
    for case in (
        RollingCase("rolling", "`rolling`", 40.0, 140.0, 100e3),
        _rolling_arc(1.02),
        _rolling_arc(1.1),
    )
}


def compute(names: Sequence[str] = (*ROLLING, *CASES), workers: int | None = None) -> dict[str, Any]:
    """Return the numbers of the page, `workers` pairs at a time (default: one per core)."""
    with ProcessPoolExecutor(workers or cores()) as pool:
        solved = dict(zip(names, pool.map(solve, names), strict=True))
    return {
        "code": results_digest(*STUDY_FOLDERS),
        "versions": versions(),
        "tolerance": TOLERANCE,
        "elements": ELEMENTS,
        "rolling_elements": ROLLING_ELEMENTS,
        "rolling": {case.name: solved[name] for name, case in ROLLING.items() if name in solved},
        "pairs": {name: solved[name] for name in CASES if name in solved},
    }


def solve(name: str) -> dict[str, Any]:
    """Return the numbers of a pair, without friction or rolling."""
    start = perf_counter()
    options = RunOptions(1, Store(STORE), Watch(on_stage=lambda line: report(f"{name}: {line.strip()}")))
    rolls = name in ROLLING
    numbers = _rolling(ROLLING[name], options) if rolls else _frictionless(CASES[name], options)
    report(f"{name}: {perf_counter() - start:.0f} s")
    return numbers


def report(line: str) -> None:
    sys.stderr.write(f"{line}\n")
    sys.stderr.flush()


def _frictionless(case: Case, options: RunOptions) -> dict[str, Any]:
    """Return deviations by load and crossings of a pair without friction."""
    scene = case.scene()
    problem = scene.contact_problem
    loads = case.ladder.loads(problem)
    own = [load for load in scene.contact.loads if loads[0] < load < loads[-1]] if case.ratio is None else []
    loads = sorted([*own, *(load for load in loads if all(abs(load / other - 1) > SAME for other in own))])

    def deviations(pair: PairDeviations) -> dict[str, Any]:
        laws = {ics: {number: pair.law(number, ics) for number in TOLERANCES} for ics in ICS}
        return {
            "p_max": [numbers(pair.on_grid, pair.contact(load, "C").normal)["p_max"] for load in loads],
            "own_loads": own,
        } | _of_laws(laws, loads, TOLERANCES)

    facts = {
        "name": case.name,
        "title": case.title,
        "short": case.short,
        "ratio": case.ratio,
        "flanks": case.flanks,
    }
    return facts | solve_deviations(problem, loads, ICS, deviations, options)


def _rolling_scene(case: RollingCase, largest_load: float) -> Scene:
    """Return the scene of a pair; its grid is that of the largest load [N]."""
    specified = {
        "motion": "rolling",
        "friction": list(case.frictions),
        "loads": [largest_load],
        "elements": ROLLING_ELEMENTS,
        "ics": [*WITH_FRICTION, "C"],
    }
    return load_scene("rolling", CHANGES | case.changes | {"contact": specified})


def _rolling(case: RollingCase, options: RunOptions) -> dict[str, Any]:
    """Return deviations of forces and of sliding, by friction, and their crossings."""
    ladder = Ladder(case.smallest_angle, case.largest_angle, case.largest_load, ROLLING_LOADS)
    loads = ladder.loads(_rolling_scene(case, case.largest_load).contact_problem)
    scene = _rolling_scene(case, loads[-1])

    def deviations(pair: PairWithFriction) -> dict[str, Any]:
        operators = {name: pair.operator(name) for name in (*WITH_FRICTION, "C")}
        by_friction = {}
        for friction in case.frictions:
            rolled = RollingDeviations(pair, operators, friction, pair.perturbed("C"), tuple(loads[::2]))
            laws = {ics: {number: rolled.law(number, ics) for number in OF_FORCES} for ics in WITH_FRICTION}
            creepages = [rolled.solved(load, "C").creepages for load in loads]
            by_friction[f"{friction:g}"] = {
                "creepage_half": [half for half, _ in creepages],
                "creepage_free": [free for _, free in creepages],
                "sliding": [rolled.solved(load, "C").numbers["sliding"] for load in loads],
            } | _of_laws(laws, loads, OF_FORCES, FORCE_ACCURACY)
            report(f"{ROLLS} {case.name}: friction {friction:g} solved")
        return by_friction

    facts = {"title": scene.title, "short": case.short}
    return facts | {"frictions": solve_with_friction(scene.contact_problem, deviations, options)}


def _of_laws(
    laws: Mapping[str, Mapping[str, Law]],
    loads: Sequence[float],
    tolerances: Mapping[str, Sequence[float]],
    accuracy: float = LOAD_ACCURACY,
) -> dict[str, Any]:
    """Return deviations at loads, and crossings, of laws by ICs and number."""
    some = next(iter(next(iter(laws.values())).values()))
    return {
        "loads": list(loads),
        "angles": [some(load).angle for load in loads],
        "angle_estimates": [some(load).angle_estimate for load in loads],
        "errors": {
            ics: {
                number: [[law(load).error, law(load).estimate] for load in loads]
                for number, law in of.items()
            }
            for ics, of in laws.items()
        },
        "crossings": {
            ics: {
                number: {
                    f"{tolerance:g}": _record(find_crossing(law, loads, tolerance, accuracy))
                    for tolerance in tolerances[number]
                }
                for number, law in of.items()
            }
            for ics, of in laws.items()
        },
    }


def _record(found: Crossing) -> dict[str, Any]:
    """Return a crossing as JSON: NaN has no place there."""
    return {
        "at": None if found.at is None else asdict(found.at),
        "estimate": None if found.at is None else found.estimate,
        "before": found.before,
        "stays": found.stays,
        "largest": asdict(found.largest),
        "end": asdict(found.end),
    }
