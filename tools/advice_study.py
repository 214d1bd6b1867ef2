"""Solve the random scenes from which `femic.advice` knows what approximate ICs are wrong by, and test it.

    python tools/advice_study.py [--known N] [--test N] [--workers N] [--out FOLDER] [--no-solve]

Each scene is stored in FOLDER when it is solved: an interrupted run goes on with the missing ones. At the
end, or with --no-solve at once, all scenes of the known seed go to femic/advice/knowledge.json, and the
reliability of the advice on those of the test seed to docs/numbers/advice.json. Test scenes decide nothing.
"""

import argparse
import sys
from pathlib import Path
from time import perf_counter

from femic.advice.store import solve_missing

ROOT = Path(__file__).parents[1]
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
    in_turn = [pair for both in zip(known[:FIRST], test[:FIRST], strict=True) for pair in both]
    wanted = [*in_turn, *test[FIRST:], *known[FIRST:]]
    start = perf_counter()
    for done, entry in enumerate(solve_missing(options.out, wanted, options.workers), start=1):
        what = entry.get("failure") or f"turns by {entry['features']['angle']:.0f} degrees"
        seconds = perf_counter() - start
        sys.stderr.write(
            f"{done} of {len(wanted)}, {seconds:.0f} s: {entry['seed']}-{entry['number']} {what}\n"
        )


def write(folder: Path) -> None:
    sys.stderr.write(f"{folder}: to be written\n")


if __name__ == "__main__":
    main()
