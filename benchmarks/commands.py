"""Benchmark of commands as a user gives them (docs/evidence/performance.md).

    python benchmarks/commands.py [--record]   # eight minutes

Seconds of the clock from the command to the page: in an empty folder, and again with what the first run has
stored. Each command has run before, elsewhere, so that Python and Numba have compiled their sources.
"""

import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any

import tomlkit
from tables import Record, arguments, print_table

from femic.shifts.specification import example

SHIFTS = [-6.0, -4.5, -3.0, -1.5, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
ALIKE = ["A", "Bhat"]


def shifts_file(folder: Path) -> Path:
    """Write the built-in pair at eleven shifts, with friction and without C."""
    tables = tomllib.loads(example("s1002-on-60e1"))
    tables["shifts"], tables["contact"]["ics"] = SHIFTS, ALIKE
    del tables["contact"]["c_above_deg"]
    return written(folder / "shifts.toml", tables)


def contact_file(folder: Path) -> Path:
    """Write the built-in scene `tall` with A and B-hat."""
    tables = built_in("tall")
    tables["contact"]["ics"] = ALIKE
    return written(folder / "tall.toml", tables)


def ics_file(folder: Path, tolerance: float) -> Path:
    """Write the built-in scene `geometry1` with C to a tolerance, without the check."""
    tables = built_in("geometry1")
    tables.setdefault("engine", {}).update(tolerance=tolerance, check=False)
    return written(folder / f"geometry1-{tolerance:g}.toml", tables)


def built_in(name: str) -> dict[str, Any]:
    """Return a built-in scene as `femic scenes --show` prints it."""
    command = [*FEMIC, "scenes", "--show", name]
    return tomllib.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def written(path: Path, tables: dict[str, object]) -> Path:
    path.write_text(tomlkit.dumps(tables), encoding="utf-8")
    return path


FEMIC = (sys.executable, "-m", "femic")


def seconds(command: str, file: str, folder: Path) -> float:
    """Return the seconds of a command."""
    start = perf_counter()
    subprocess.run([*FEMIC, command, file, "--out", str(folder / "out")], check=True, capture_output=True)
    return perf_counter() - start


def rows() -> Iterator[list[str]]:
    with tempfile.TemporaryDirectory() as name:
        given = Path(name)
        for text, command, file in (
            ("`femic run geometry1`, with the check by the other engine", "run", "geometry1"),
            ("the same without the check, tolerance 0.01", "run", str(ics_file(given, 1e-2))),
            ("the same without the check, tolerance 0.001", "run", str(ics_file(given, 1e-3))),
            ("`femic contact`, scene `tall`, three loads, A and B̂", "contact", str(contact_file(given))),
            ("`femic shifts`, 11 shifts, A, B̂, planar, with friction", "shifts", str(shifts_file(given))),
        ):
            with tempfile.TemporaryDirectory() as folder:
                seconds(command, file, Path(folder))
            with tempfile.TemporaryDirectory() as folder:
                first, again = (seconds(command, file, Path(folder)) for _ in range(2))
            yield [text, f"{first:.0f}", f"{again:.0f}"]


if __name__ == "__main__":
    arguments()
    print_table(
        ("command", "first [s]", "again [s]"),
        rows(),
        record=Record(
            "commands.seconds",
            "Commands",
            "Seconds of the clock until the page is written; again: with what is stored.",
            "python benchmarks/commands.py",
        ),
    )
