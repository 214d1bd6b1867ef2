"""Solve the random scenes from which `femic.advice` knows what approximate ICs are wrong by, and test it.

    python tools/advice_study.py [--known N] [--test N] [--workers N] [--out FOLDER] [--no-solve]

Each scene is stored in FOLDER when it is solved: an interrupted run goes on with the missing ones. At the
end, or with --no-solve at once, all scenes of the known seed go to femic/advice/knowledge.json, and the
reliability of the advice on those of the test seed to docs/numbers/advice.json. Test scenes decide nothing.
"""

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from advice_reliability import (
    LEAST_HELD,
    TOLERANCES,
    check_bounds,
    choose_rule,
    count_outcomes,
    coverage_rows,
    known_scenes,
    worst_trials,
)
from advice_reliability import NUMBERS as NUMBERS_OF
from advice_reliability import write as write_knowledge
from advice_scenes import ELEMENTS, entries, solve_missing
from write_docs import rounded

from femic.advice.knowledge import FEATURES, Knowledge, KnownScene
from femic.cache.digests import versions

ROOT = Path(__file__).parents[1]
NUMBERS = ROOT / "docs" / "numbers" / "advice.json"
KNOWN_SEED, TEST_SEED = 40, 41
FIRST = 100  # scenes of each kind that are solved in turn, so that both are there at any time


def main() -> None:
    options = arguments()
    if not options.no_solve:
        solve(options)
    write(options.out)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--known", type=int, default=200, help="scenes to learn from")
    parser.add_argument("--test", type=int, default=210, help="scenes to test with")
    parser.add_argument("--workers", type=int, default=2, help="processes at a time")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "advice", help="folder of solved scenes")
    parser.add_argument("--no-solve", action="store_true", help="write with the scenes that are stored")
    return parser.parse_args()


def solve(options: argparse.Namespace) -> None:
    known = [(KNOWN_SEED, number) for number in range(options.known)]
    test = [(TEST_SEED, number) for number in range(options.test)]
    first = min(FIRST, len(known), len(test))
    in_turn = [pair for both in zip(known[:first], test[:first], strict=True) for pair in both]
    wanted = [*in_turn, *test[first:], *known[first:]]
    start = perf_counter()
    for done, entry in enumerate(solve_missing(options.out, wanted, options.workers), start=1):
        what = entry.get("failure") or f"turns by {entry['features']['angle']:.0f} degrees"
        seconds = perf_counter() - start
        sys.stderr.write(
            f"{done} of {len(wanted)}, {seconds:.0f} s: {entry['seed']}-{entry['number']} {what}\n"
        )


def write(folder: Path) -> None:
    """Write the knowledge file and the numbers of the page from the stored scenes."""
    known, test = (entries(folder, seed) for seed in (KNOWN_SEED, TEST_SEED))
    codes = sorted({entry["code"] for entry in [*known, *test]})
    scenes = known_scenes(known)
    untested = Knowledge(scenes, choose_rule(scenes), code=" and ".join(codes))
    knowledge, tried = check_bounds(untested, known_scenes(test))
    facts = {"is_sample": True, "versions": versions(), "elements": ELEMENTS}  # a slow test solves two again
    write_knowledge(knowledge, facts)
    record = {
        "code": knowledge.code,
        **facts,
        "seeds": {"known": KNOWN_SEED, "test": TEST_SEED},
        "known": counts(known),
        "test": counts(test),
        "rule": asdict(knowledge.rule),
        "ranges": ranges(knowledge),
        "outside": sum(
            bool(knowledge.outside(scene.features, friction=True)) for scene in known_scenes(test)
        ),
        "trials": len(tried),
        "held": sum(trial.beyond <= 0 for trial in tried),
        "decisions": [
            {"tolerance": tolerance, **count_outcomes(tried, tolerance)} for tolerance in TOLERANCES
        ],
        "rows": coverage_rows(tried),
        "worst": worst_trials(tried),
        "least_held": LEAST_HELD,
        "estimates": largest_estimates(scenes),
    }
    text = json.dumps(rounded(record), indent=1, ensure_ascii=False, allow_nan=False)
    NUMBERS.write_text(text + "\n", encoding="utf-8")
    sys.stderr.write(f"{len(scenes)} known scenes, {len(known_scenes(test))} of the test, {knowledge.rule}\n")
    sys.stderr.write(f"bounds held in {record['held']} of {len(tried)} trials; {record['decisions']}\n")


def counts(found: list[dict[str, Any]]) -> dict[str, Any]:
    """Return how many scenes were solved, and why others were not."""
    failures = [entry["failure"] for entry in found if "failure" in entry]
    return {"solved": len(found) - len(failures), "failures": failures}


def ranges(knowledge: Knowledge) -> list[dict[str, Any]]:
    """Return the ranges of the features of known scenes."""
    return [
        {
            "meaning": feature.meaning,
            "unit": feature.unit,
            "low": min(values),
            "high": max(values),
            "scale": feature.scale,
        }
        | {"logarithmic": feature.logarithmic}
        for name, feature in FEATURES.items()
        if (values := [scene.features[name] for scene in knowledge.scenes])
    ]


def largest_estimates(scenes: list[KnownScene]) -> dict[str, dict[str, float]]:
    """Return median and largest estimated error of C by number."""
    by_number = {name: [scene.estimates[name] for scene in scenes] for name in NUMBERS_OF}
    return {
        name: {"median": float(np.median(values)), "largest": max(values)}
        for name, values in by_number.items()
    }


if __name__ == "__main__":
    main()
