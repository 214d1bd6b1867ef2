"""Outcomes of attacks, and the table of them."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

HELD = ""  # what falls short: nothing
SHOWN = 5  # of what falls short, of each kind


@dataclass(frozen=True)
class Outcome:
    """An attack, the answer of femic, and the shortcoming, if any."""

    attack: str
    answer: str
    short: str = HELD


def row(kind: str, meaning: str, outcomes: Iterable[Outcome]) -> dict[str, Any]:
    """Return the row of a kind of attacks: how many, the answers, and what falls short."""
    outcomes = list(outcomes)
    short = [one for one in outcomes if one.short]
    return {
        "kind": kind,
        "meaning": meaning,
        "attacks": len(outcomes),
        "answers": dict(Counter(one.answer for one in outcomes).most_common()),
        "short": len(short),
        "shown": [f"{one.attack}: {one.short}" for one in short[:SHOWN]],
    }


def text_of_rows(rows: Iterable[dict[str, Any]]) -> str:
    """Return the table as text."""
    lines = []
    for one in rows:
        answers = ", ".join(f"{count} {answer}" for answer, count in one["answers"].items())
        counted = f"{one['kind']:10} {one['attacks']:6} attacks in {one['seconds']} s: {answers}"
        lines.append(f"{counted}; {one['short']} fall short")
        lines += [f"    {text}" for text in one["shown"]]
    return "\n".join(lines)
