"""Attack femic, and report what gives way: `make attack`.

    python tools/attack [--only KIND ...] [--share 1.0] [--seed N] [--page]

Commands are killed at random moments, files that they keep are damaged, two commands run at the same time,
scenes, campaigns, tables of points and gap files are changed at random, pages have hostile texts and
files odd names, strange legal contacts are solved, profiles are damaged, public names of Python get wrong
arguments, and labelled arrays come in any order.
Each attack is held, or falls short: out/attack has what its commands printed. With --page the numbers go to
docs/numbers/attacks.json, of which docs/evidence/extremes.md shows a table (tools/write_docs.py).
"""

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import fuzz
import names
from commands import Place
from contacts import contacts
from damages import damages
from kills import kills
from labels import labels
from mistakes import mistakes
from outcomes import Outcome, row_of, text_of_row
from races import races
from stresses import stresses
from wheelsets import shifts

from femic.cache.digests import PAGE_FOLDERS, results_digest, versions

NUMBERS = Path(__file__).parents[2] / "docs" / "numbers" / "attacks.json"
LOGS = Path("out") / "attack"  # what commands printed in attacks that fall short
SEED = 36
Attack = Callable[[Place, int, int], Iterator[Outcome]]  # how many, and which random ones


@dataclass(frozen=True)
class Kind:
    """A kind of attacks: how many, what they do, and what makes them."""

    count: int
    meaning: str
    attack: Attack


def of_files(change: Callable[[Path, int, int], Iterator[Outcome]]) -> Attack:
    """Return attacks by files in a folder of their own."""

    def attack(_: Place, count: int, seed: int) -> Iterator[Outcome]:
        with TemporaryDirectory() as folder:
            yield from change(Path(folder), count, seed)

    return attack


KINDS = {
    "kills": Kind(63, "a command is ended at a random moment, and run again", kills),
    "damages": Kind(126, "a file that a command keeps is damaged, and the command run again", damages),
    "races": Kind(45, "two commands begin at the same time in one folder", races),
    "scenes": Kind(3000, "scene files with keys changed at random", of_files(fuzz.scenes)),
    "campaigns": Kind(3000, "campaign files, likewise", of_files(fuzz.campaigns)),
    "tables": Kind(3000, "tables of points (CSV), likewise", of_files(fuzz.tables)),
    "gaps": Kind(3000, "gap files, likewise", of_files(fuzz.gaps)),
    "pages": Kind(300, "texts of users that mean something to pages", of_files(names.pages)),
    "names": Kind(200, "profiles and wheelsets in files of odd names", of_files(names.names)),
    "contacts": Kind(
        150, "contacts of odd bodies, loads and motions", lambda _, count, seed: contacts(count, seed)
    ),
    "shifts": Kind(900, "wheelsets with keys changed at random, and damaged profiles", of_files(shifts)),
    "stresses": Kind(600, "scenes and options of stresses, likewise", of_files(stresses)),
    "labels": Kind(210, "labelled arrays in random orders, gaps in any order", of_files(labels)),
    "mistakes": Kind(4000, "wrong arguments of public names of Python, each kind once", of_files(mistakes)),
}


def main() -> int:
    """Attack, print the table, and return 1 if anything falls short."""
    options = arguments()
    rows = {}
    with Place() as place:
        for name in options.only or KINDS:
            rows[name] = attacked(name, place, options.share, options.seed)
            sys.stdout.write(f"{text_of_row(rows[name])}\n")
    if options.page:
        keep({name: row | provenance(options.seed) for name, row in rows.items()})
    return int(any(row["short"] for row in rows.values()))


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="*", choices=KINDS, help="default: all kinds")
    parser.add_argument("--share", type=float, default=1.0, help="of the number of attacks")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--page", action="store_true", help="write the numbers for docs/evidence/extremes.md")
    return parser.parse_args()


def attacked(name: str, place: Place, share: float, seed: int) -> dict[str, Any]:
    """Return the row of a kind of attacks; print each that falls short."""
    kind, start, outcomes = KINDS[name], perf_counter(), []
    count = max(1, round(share * kind.count))
    for outcome in kind.attack(place, count, seed):
        outcomes.append(outcome)
        if outcome.short:
            sys.stderr.write(f"{name}: {outcome.attack}: {outcome.short}\n")
            place.copy_logs(LOGS / f"{name}-{len(outcomes)}")
    return row_of(name, kind.meaning, outcomes) | {"seconds": round(perf_counter() - start)}


def provenance(seed: int) -> dict[str, Any]:
    """Return seed and versions behind the numbers; a sample goes out of date with no change of code."""
    return {"seed": seed, "versions": versions(), "is_sample": True, "code": results_digest(*PAGE_FOLDERS)}


def keep(rows: dict[str, dict[str, Any]]) -> None:
    """Write rows by kind, beside the rows of other kinds."""
    before = json.loads(NUMBERS.read_text(encoding="utf-8")) if NUMBERS.exists() else {}
    stored = {name: rows.get(name, before.get(name)) for name in KINDS if name in rows or name in before}
    NUMBERS.write_text(json.dumps(stored, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
