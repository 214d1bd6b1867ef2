"""Wheelsets on tracks with keys changed at random, and profiles of damaged files: refused, or as they say."""

import random
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np
from damages import DAMAGES, emptied, exchanged
from fuzz import by_code, changed, outcome
from outcomes import Outcome

import femic
from femic.cli.main import exit_code
from femic.reference.run_options import RunOptions
from femic.results.wheelset import canted_rails, compute_shifts, require_track, values_used
from femic.scenes.load import load_scene
from femic.shifts.sides import doubts, lay_out_wheelset, prepare_sections
from femic.shifts.specification import ShiftsFile, builtin_names, example, load_shifts
from geometries.profiles.files import read_profile

SOLVED = 75  # of so many wheelsets one is solved, at one shift
WRITTEN = 3  # of so many the scene of a wheel is written
LONGEST = 300  # seconds that this may take on a busy machine
BUILTIN = "s1002-on-60e1"
TRACK = """
[track]
gauge = 1435.0
gauge_depth = 14.0
rail_inclination = 0.025
[wheelset]
flange_back_distance = 1360.0
nominal_radius = [460.0, 459.0]
tape_circle = 70.0
[contact]
load = 90e3
ics = ["A"]
elements = 8
planar = false
"""
OF_FILES = (
    'shifts = [-4.0, 0.0, 3.0]\n[rail]\nprofile = "rail.prr"\ntolerance = 0.01\n'
    '[wheel]\nprofile = "wheel.prw"\nE = 210e3\nnu = 0.28\n' + TRACK
)
OF_COLUMNS = (
    'shifts = [-4.0, 0.0, 3.0]\nrolls = [-0.1, 0.0, 0.2]\n[rail]\nprofile = "rail.txt"\naxes = "field up"\n'
    'unit = "mm"\n[right_rail]\nprofile = "rail.prr"\n[wheel]\nprofile = "S1002"\nflange_back = -70.0\n'
    + TRACK
    + "[rolling]\nfriction = 0.3\nby_angle = [[20.0, 1.0], [40.0, 0.3]]\nlateral = 1e-3\nspin = 1e-6\n"
)
BASES = (OF_FILES, OF_COLUMNS)
NUMBERS = re.compile(r"\s*-?\d[\d.e+-]*\s+-?\d[\d.e+-]*(\s|$)")  # at the beginning of a line


def shifts(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield wheelsets: read and placed; scenes of some are written, some are solved."""
    files = _profiles(folder)
    bases = (*BASES, *map(example, builtin_names()))
    path = folder / "wheelset.toml"
    for number in range(count):
        chance = random.Random(f"shifts {seed} {number}")
        for file, content in files.items():
            file.write_bytes(content)
        if number % 2:
            path.write_text(chance.choice(BASES), encoding="utf-8")
            yield _damaged(number, path, chance.choice(list(files)), chance)
        else:
            path.write_text(changed(bases, chance), encoding="utf-8", errors="replace")
            yield outcome(f"wheelset {number}", partial(_placed, path, number, chance), LONGEST)


def _profiles(folder: Path) -> dict[Path, bytes]:
    """Write a rail as a spline block and as columns, and a wheel; return their contents by path."""
    rail, wheel = (femic.Profile(standard=name) for name in ("60E1", "S1002"))
    paths = [folder / name for name in ("rail.prr", "wheel.prw", "rail.txt")]
    femic.write_profile(rail, paths[0])
    femic.write_profile(wheel, paths[1])
    points = np.column_stack([rail.data.y, rail.data.z])[::5]
    paths[2].write_text("\n".join(f"{y:.4f} {z:.4f}" for y, z in points) + "\n", encoding="utf-8")
    return {path: path.read_bytes() for path in paths}


def _placed(path: Path, number: int, chance: random.Random) -> str:
    """Read a specification and place its profiles; write the scene of a wheel, or solve it, now and then."""
    _, _, file = load_shifts(str(path))
    require_track(file)
    sections = prepare_sections(file)
    layout = lay_out_wheelset(file, sections)
    for text in (*doubts(sections), *canted_rails(file), *values_used(file, layout)):
        assert text
    if number % SOLVED == 0:
        return _solved(file)
    return _written(path, file, chance) if number % WRITTEN == 0 else "taken"


def _solved(file: ShiftsFile) -> str:
    """Solve the middle one of the shifts, on few elements; contacts are finite, or have a reason."""
    k = len(file.shifts) // 2
    quick = {"ics": ("A",), "elements": 8, "c_above_deg": None, "planar": False}
    one = {"shifts": file.shifts[k : k + 1], "rolls": file.rolls[k : k + 1], "rolling": None}
    contact = file.contact.model_copy(update=quick)
    found = compute_shifts(file.model_copy(update=one | {"contact": contact}), "", RunOptions(1))
    p_max = found.p_max.values
    if not np.any(p_max > 0) or np.any(p_max <= 0):
        raise AssertionError(f"the largest pressures are {p_max.ravel()} MPa")
    if np.any(np.isnan(p_max)) and found.attrs["refused"] == "{}":
        raise AssertionError("a contact is missing without a reason")
    return "solved"


def _written(path: Path, file: ShiftsFile, chance: random.Random) -> str:
    """Write the scene of a wheel at a shift; it can be loaded, and has the load of the wheel."""
    shift = chance.choice((*file.shifts, 0.0, chance.uniform(-8, 8), 1e3, -1e-300, float("nan")))
    wheel = chance.choice(((), (), ("--wheel", "left"), ("--wheel", "right")))
    out = path.parent / f"out {chance.random()}"
    answer = by_code(exit_code(["shifts", str(path), "--write", str(shift), *wheel, "--out", str(out)]))
    written = list(out.glob("*.toml"))
    if (answer == "taken") != (len(written) == 1):
        raise AssertionError(f"{answer}, and {len(written)} scenes were written")
    for scene in written:
        if load_scene(str(scene)).contact.loads != (file.contact.load,):
            raise AssertionError("the scene has another load")
    return "written" if written else answer


# --- profiles --------------------------------------------------------------------------------------------


def _damaged(number: int, path: Path, file: Path, chance: random.Random) -> Outcome:
    """Return what femic answers where a file of a profile has been changed."""
    name, change = chance.choice(list(CHANGES.items()))
    before = read_profile(file, "wheel" if file.suffix == ".prw" else "rail", axes=_axes(file)).points
    change(file, chance)

    def read() -> str:
        if name in SAME:
            now = read_profile(file, "wheel" if file.suffix == ".prw" else "rail", axes=_axes(file)).points
            if not np.array_equal(now, before):
                raise AssertionError("the profile is another")
        return _placed(path, number, chance)

    return outcome(f"{name} {file.name}, wheelset {number}", read, LONGEST)


def _axes(file: Path) -> str | None:
    return "field up" if file.suffix == ".txt" else None


def _in_lines(change: Callable[[list[str], int, random.Random], object]) -> Callable[..., None]:
    """Return a change of a file by one of its lines, at a place with numbers if there is one."""

    def changed_file(path: Path, chance: random.Random) -> None:
        lines = path.read_text(encoding="utf-8").splitlines()
        at = chance.choice([k for k, line in enumerate(lines) if NUMBERS.match(line)])
        change(lines, at, chance)
        path.write_text("\n".join(lines) + "\n", encoding="utf-8", errors="surrogateescape")

    return changed_file


def _with_number(text: Callable[[float, random.Random], str]) -> Callable[..., None]:
    """Return a change of one number of a file."""

    def change(lines: list[str], at: int, chance: random.Random) -> None:
        words = lines[at].split()
        k = chance.randrange(2)
        words[k] = text(float(words[k]), chance)
        lines[at] = " ".join(words)

    return _in_lines(change)


def _encoded(encoding: str, end: str = "\n") -> Callable[..., None]:
    def change(path: Path, _: random.Random) -> None:
        path.write_bytes(path.read_text(encoding="utf-8").replace("\n", end).encode(encoding))

    return change


CHANGES: MappingProxyType[str, Callable[[Path, random.Random], None]] = MappingProxyType(
    {damage.__name__: damage for damage in DAMAGES if damage not in (emptied, exchanged)}
    | {
        "line left out": _in_lines(lambda lines, at, _: lines.pop(at)),
        "line twice": _in_lines(lambda lines, at, _: lines.insert(at, lines[at])),
        "lines exchanged": _in_lines(lambda lines, at, _: lines.insert(max(0, at - 3), lines.pop(at))),
        "text among numbers": _in_lines(lambda lines, at, _: lines.insert(at, "12 mm o'clock")),
        "half a line": _in_lines(lambda lines, at, _: lines.insert(at, lines.pop(at)[:3])),
        "no numbers": _with_number(lambda _, chance: chance.choice(("nan", "inf", "-", "1e400", "1,5", "x"))),
        "huge": _with_number(lambda number, chance: f"{number * 10.0 ** chance.randint(3, 300):g}"),
        "sign": _with_number(lambda number, _: f"{-number:.4f}"),
        "off": _with_number(lambda number, chance: f"{number + chance.gauss(0, 0.5):.4f}"),
        "CRLF": _encoded("utf-8", "\r\n"),
        "byte order mark": _encoded("utf-8-sig"),
        "UTF-16": _encoded("utf-16"),
        "end of lines at the end": lambda path, _: path.write_bytes(path.read_bytes() + b"\n\n\n") and None,
    }
)
SAME = ("CRLF", "byte order mark", "UTF-16", "end of lines at the end")  # changes that mean nothing
