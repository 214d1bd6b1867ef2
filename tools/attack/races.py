"""Two commands run at the same time, in one folder or with one store; results are those of each alone."""

import random
from collections.abc import Iterator
from itertools import combinations_with_replacement
from time import sleep

from commands import COMMANDS, Command, Place
from outcomes import Outcome

ANOTHER = "another femic"


def races(place: Place, count: int, seed: int) -> Iterator[Outcome]:
    """Begin two commands nearly at once: each ends with its results, or says that another writes there."""
    chance = random.Random(seed)
    pairs = list(combinations_with_replacement(COMMANDS, 2))
    chance.shuffle(pairs)
    for number in range(count):
        first, second = pairs[number % len(pairs)]
        at = place.copy(place.fresh, "raced")
        begun = [(first, first.begin(at))]
        sleep(chance.choice((0.0, 0.0, 0.5, 2.0)))
        begun.append((renamed(second), renamed(second).begin(at)))
        outcomes = [_judged(place, at, command, process) for command, process in begun]
        short = "; ".join(text for _, text in outcomes if text)
        answers = sorted(answer for answer, _ in outcomes)
        if not short and answers == ["refused", "refused"]:
            short = "both were refused"
        yield Outcome(f"{first.name} and {second.name}", " and ".join(answers), short)


def renamed(command: Command) -> Command:
    """The command with a log of its own."""
    return Command(f"{command.name} too", command.arguments, command.folder, command.results)


def _judged(place, at, command, process) -> tuple[str, str]:
    """How a command ended, and what falls short."""
    ended = command.ended(process, at)
    if ended.code == 1 and ANOTHER in ended.text and not ended.trouble:
        return "refused", ""
    reference, _ = place.references[command.name.removesuffix(" too")]
    return "done", ended.failure or command.differences(at, reference)
