"""Files that femic keeps are damaged; it notices, says so, and computes again what they held."""

import random
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from commands import COMMANDS, Command, Place, kept_files
from outcomes import Outcome

FOREIGN = b"no file of femic\n"


def flipped(path: Path, chance: random.Random) -> None:
    """Flip one bit."""
    content = bytearray(path.read_bytes())
    if content:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        path.write_bytes(content)


def cut(path: Path, chance: random.Random) -> None:
    """Cut off the end."""
    content = path.read_bytes()
    path.write_bytes(content[: chance.randrange(len(content) + 1)])


def emptied(path: Path, _: random.Random) -> None:
    """Leave an empty file."""
    path.write_bytes(b"")


def deleted(path: Path, _: random.Random) -> None:
    """Delete the file."""
    path.unlink()


def foreign(path: Path, _: random.Random) -> None:
    """Replace the content as another program would."""
    path.write_bytes(FOREIGN)


def exchanged(path: Path, chance: random.Random) -> None:
    """Copy the content of another file of its kind."""
    others = [other for other in path.parent.glob(f"*{path.suffix}") if other != path and other.is_file()]
    if others:
        shutil.copyfile(chance.choice(others), path)
    else:
        foreign(path, chance)


def of_another_time(path: Path, _: random.Random) -> None:
    """Write the first half twice: the length is right, the content is not."""
    content = bytearray(path.read_bytes())
    half = len(content) // 2
    content[half : 2 * half] = content[:half]
    path.write_bytes(content)


DAMAGES: tuple[Callable[[Path, random.Random], None], ...] = (
    flipped,
    cut,
    emptied,
    deleted,
    foreign,
    exchanged,
    of_another_time,
)


def damages(place: Place, count: int, seed: int, commands: Sequence[Command] = COMMANDS) -> Iterator[Outcome]:
    """Damage a file that a command has left, run it again, and compare its results with undisturbed ones.

    Every second file is one of the store. A folder in the place of a file of results is refused before any
    work, and in the store it is replaced.
    """
    chance = random.Random(seed)
    for number in range(count):
        command = commands[number % len(commands)]
        reference, _ = place.reference(command)
        at = place.copy(reference, "damaged")
        files = list(kept_files(at))
        stored = [path for path in files if "store" in path.parts]
        path = chance.choice(stored if stored and number % 2 else files)
        damage = DAMAGES[(number // 2) % len(DAMAGES)]
        damage(path, chance)
        ended = command.run(at)
        short = ended.failure or command.differences(at, reference)
        noticed = "told" if "computed again" in ended.text else "not needed or computed again"
        yield Outcome(f"{command.name}: {path.relative_to(at)} {damage.__name__}", noticed, short)
