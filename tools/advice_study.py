"""Solve the random scenes from which `femic.advice` knows what approximate ICs are wrong by, and test it.

    python tools/advice_study.py [--known N] [--test N] [--workers N] [--out FOLDER] [--no-solve]

Each scene is stored in FOLDER when it is solved: an interrupted run goes on with the missing ones. At the end,
or with --no-solve at once, all stored scenes go to femic/advice/knowledge.json (those of the known seed) and the
reliability of the advice on those of the test seed to docs/numbers/advice.json. Test scenes decide nothing:
neither scales nor numbers of neighbours come from them.
"""

import argparse
import json
import sys
from pathlib import Path
from time import perf_counter

from femic.advice.store import solve_missing

ROOT = Path(__file__).parents[1]
KNOWN_SEED, TEST_SEED = 40, 41
FIRST = 100  # known scenes that are solved before those of the test, the others after them


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
    wanted = [*known[:FIRST], *test, *known[FIRST:]]
    start = perf_counter()
    for done, entry in enumerate(solve_missing(options.out, wanted, options.workers), start=1):
        what = entry.get("failure") or f"turns by {entry['features']['angle']:.0f} degrees"
        seconds = perf_counter() - start
        sys.stderr.write(f"{done} of {len(wanted)}, {seconds:.0f} s: {entry['seed']}-{entry['number']} {what}\n")


def write(folder: Path) -> None:
    sys.stderr.write(f"{folder}: to be written\n")


if __name__ == "__main__":
    main()
