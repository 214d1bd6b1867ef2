"""Outcomes of attacks, and the table of them."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

SHOWN = 5  # of what falls short, of each kind


@dataclass(frozen=True)
class Outcome:
    """An attack, the answer of femic, and the shortcoming, if any."""

    attack: str
    answer: str
    short: str = ""


def row_of(kind: str, meaning: str, outcomes: Iterable[Outcome]) -> dict[str, Any]:
    """Return the row of a kind of attacks: how many, the answers, and what falls short."""
    outcomes = list(outcomes)
    short = [outcome for outcome in outcomes if outcome.short]
    return {
        "kind": kind,
        "meaning": meaning,
        "attacks": len(outcomes),
        "answers": dict(Counter(outcome.answer for outcome in outcomes).most_common()),
        "short": len(short),
        "shown": [f"{outcome.attack}: {outcome.short}" for outcome in short[:SHOWN]],
    }


def text_of_row(row: dict[str, Any]) -> str:
    """Return a row as text."""
    answers = ", ".join(f"{count} {answer}" for answer, count in row["answers"].items())
    counted = f"{row['kind']:10} {row['attacks']:6} attacks in {row['seconds']} s: {answers}"
    return "\n    ".join([f"{counted}; {row['short']} fall short", *row["shown"]])
