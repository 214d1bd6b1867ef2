"""Commands are killed at random moments; what they had written is whole, and the same command goes on."""

import os
import random
import signal
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import sleep

import xarray as xr
from commands import COMMANDS, Command, Place
from outcomes import Outcome

SIGNALS = (signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT)


def kills(place: Place, count: int, seed: int, commands: Sequence[Command] = COMMANDS) -> Iterator[Outcome]:
    """Kill each command in turn, then run it to its end, and compare its results with undisturbed ones."""
    moments = random.Random(seed)
    for number in range(count):
        command, kind = commands[number % len(commands)], moments.choice(SIGNALS)
        reference, seconds = place.reference(command)
        after = moments.uniform(0.2, 1.0) * seconds
        at = place.copy(place.fresh, "killed")
        process = command.begin(at)
        sleep(after)
        os.kill(process.pid, kind)
        ended = command.ended(process, at)
        short = broken(at) or ("" if ended.code < 0 else ended.trouble)
        short = short or command.again.run(at).failure or command.differences(at, reference)
        yield Outcome(
            f"{command.name} after {after:.1f} s by {kind.name}", answer_of(command, ended.code), short
        )


def answer_of(command: Command, code: int) -> str:
    """Whether the command had been killed, or had ended by then."""
    return "killed" if code < 0 or code == 130 else "had ended" if code == 0 else f"{command.name}: {code}"


def broken(at: Path) -> str:
    """Return a published dataset that cannot be read."""
    for path in (at / "out").rglob("*.nc"):
        if "store" not in path.parts and ".unfinished." not in path.name:
            try:
                xr.load_dataset(path, engine="h5netcdf")
            except (OSError, ValueError) as error:
                return f"{path.name} was left broken: {error}"
    return ""
