"""Two commands run at the same time, in one folder or with one store; results are those of each alone."""

import random
from collections.abc import Iterator, Sequence
from itertools import combinations_with_replacement
from pathlib import Path
from time import sleep

from commands import COMMANDS, Command, Ended, Place
from outcomes import Outcome

ANOTHER = "another femic"


def races(place: Place, count: int, seed: int, commands: Sequence[Command] = COMMANDS) -> Iterator[Outcome]:
    """Begin two commands nearly at once: each ends with its results, or says that another writes there."""
    chance = random.Random(seed)
    pairs = list(combinations_with_replacement(commands, 2))
    chance.shuffle(pairs)
    for number in range(count):
        first, second = pairs[number % len(pairs)]
        at = place.copy(place.fresh, "raced")
        processes = [first.begin(at)]
        sleep(chance.choice((0.0, 0.0, 0.5, 2.0)))
        processes.append(second.again.begin(at))
        assessed = [
            _assessed(place.reference(command)[0], at, command, running.ended(process, at))
            for command, running, process in zip(
                (first, second), (first, second.again), processes, strict=True
            )
        ]
        short = "; ".join(text for _, text in assessed if text)
        answers = sorted(answer for answer, _ in assessed)
        if not short and answers == ["refused", "refused"]:
            short = "both were refused"
        yield Outcome(f"{first.name} and {second.name}", " and ".join(answers), short)


def _assessed(reference: Path, at: Path, command: Command, ended: Ended) -> tuple[str, str]:
    """Return how a command ended, and what falls short."""
    if ended.code == 1 and ANOTHER in ended.text and not ended.trouble:
        return "refused", ""
    return "done", ended.failure or command.differences(at, reference)
