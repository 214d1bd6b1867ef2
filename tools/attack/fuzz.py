"""Scenes, campaigns, tables of points and gap files are changed at random: taken, or refused with words.

Most changes stay within the types of keys, so that what is changed gets past the first check.
"""

import io
import random
import signal
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from commands import FILES
from outcomes import Outcome

from compare.campaigns.load import load_campaign
from compare.campaigns.plan import require_computable
from femic.cli.main import exit_code
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.reference.run_options import RunOptions
from femic.results.contact import compute_contact, require_solvable
from femic.scenes import plausibility
from femic.scenes.listing import listing
from femic.scenes.load import builtin_names, load_scene
from geometries.errors import Failure, WrongInput

LONGEST = 120  # seconds that a file may take to be read, and plans to be made, on a busy machine
SOLVED = 40  # of so many gap files one is solved with
PLANNED = 50  # of so many scenes one is planned
GENTLE = 0.9  # share of changes that stay within types and sizes
# fmt: off
WORDS = (
    "A", "B", "Bbar", "Bhat", "Bhat_prime", "mix", "C", "auto", "nn", "xx", "ss", "xn", "sn",
    "combined", "lower", "upper", "rolling", "compression", "none", "linear", "exact", "arc", "ellipse",
    "plane", "points", "solid", "harmonic", "approach", "source", "automatic", "scene", "map:none.nc",
    "Bhat+sn:B", "x", "s", "all", "random",
)
# fmt: on
ODD_NUMBERS = (0, -1, 1, 1e-300, 5e-324, 1e300, float("nan"), float("inf"), -float("inf"), 10**30, True)
ODD_WORDS = ("", " ", "nn,nn", "\u202e", "ü" * 50, "../..", "/", "a" * 5000, "0x10", "1.0", "nan", "\x7f")
ODD_LINES = ("[" * 3000, "x = 1" + "0" * 5000, "[[lower]]", "= 3", '"', "lower.E = 1", "\x00", "a.b.c.d = {}")


def scenes(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield scenes: read, with all checks before any work; some are planned."""
    bases = [listing(name) for name in builtin_names()] + [
        FILES[name] for name in ("mine.toml", "rolls.toml", "pressed.toml")
    ]
    path = folder / "scene.toml"
    for number in range(count):
        chance = random.Random(f"scene {seed} {number}")
        path.write_text(changed(bases, chance), encoding="utf-8", errors="replace")
        yield outcome(f"scene {number}", lambda plan=number % PLANNED == 0: _checked(path, plan=plan))


def _checked(path: Path, *, plan: bool) -> str:
    scene = load_scene(str(path))
    for text in plausibility.warnings(scene):
        assert text
    if scene.contact.loads or scene.contact.approaches:
        require_solvable(scene)
        grids_of(scene.contact_problem)
    return by_code(exit_code(["plan", str(path)])) if plan else "taken"


def campaigns(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield campaigns: read, with all scenes that are checked before any work."""
    examples = Path(__file__).parents[2] / "examples"
    bases = [path.read_text(encoding="utf-8") for path in examples.glob("*.toml")]
    bases += [
        'scene = "geometry2"\n[sweep.E]\nkeys = { "lower.E" = 1000 }\nfrom = 70\nto = 210\ncount = 5\n'
        'spacing = "inverse"\n[sweep.load]\nkeys = ["contact.loads"]\nvalues = [[1e3], [1e4]]\n',
        'scene = "flat"\npoints = "random"\nsamples = 8\nseed = 3\n[sweep.nu]\nkeys = ["lower.nu"]\n'
        "from = 0.0\nto = 0.45\n[sweep.a]\nkeys = ['patch.a']\nfrom = 0.1\nto = 0.3\n",
    ]
    path = folder / "campaign.toml"
    for number in range(count):
        chance = random.Random(f"campaign {seed} {number}")
        path.write_text(changed(bases, chance), encoding="utf-8", errors="replace")
        yield outcome(f"campaign {number}", lambda: _computable(path))


def _computable(path: Path) -> str:
    require_computable(load_campaign(path))
    return "taken"


def tables(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield tables of points (CSV): each is read as it says, or refused."""
    campaign = folder / "table.toml"
    campaign.write_text(
        'scene = "flat"\npoints = "points.csv"\n[sweep.nu]\nkeys = ["lower.nu", "upper.nu"]\n'
        "[sweep.E]\nkeys = ['lower.E']\n",
        encoding="utf-8",
    )
    for number in range(count):
        chance = random.Random(f"table {seed} {number}")
        rows = [
            [f"{chance.uniform(0, 0.45):.3f}", f"{chance.uniform(1e5, 3e5):.6g}"]
            for _ in range(chance.randint(1, 6))
        ]
        content, meant = _changed_table(rows, chance)
        (folder / "points.csv").write_bytes(content)
        yield outcome(f"table {number}", lambda meant=meant: _read_table(campaign, meant))


def _read_table(path: Path, meant: list[list[float]] | None) -> str:
    """Read a campaign with a table that means some numbers, None: unknown or nothing."""
    loaded = load_campaign(path)
    require_computable(loaded)
    points = [[float(value) for value in row] for row in loaded.listed]
    if meant is not None and not np.array_equal(points, meant):
        raise AssertionError(f"read as {points}, meant are {meant}")
    return "taken"


def _changed_table(rows: list[list[str]], chance: random.Random) -> tuple[bytes, list[list[float]] | None]:
    """Return a table as bytes, and its numbers if it can be read; None where that is unclear."""
    names, mark, end = ["nu", "E"], chance.choice(",,,;\t"), chance.choice(("\n", "\r\n"))
    meant: list[list[float]] | None = [[float(cell) for cell in row] for row in rows]
    table, never = [names, *rows], [[float("nan")]]  # `never`: must be refused
    row = chance.randrange(1, len(table))
    match chance.randrange(16):
        case 0:
            table[row].append("7")
            meant = never
        case 1:
            table[row].pop()
            meant = never
        case 2:
            table[0].append(chance.choice(names))
            table[1:] = [[*cells, "1"] for cells in table[1:]]
            meant = never
        case 3:
            table[row][chance.randrange(2)] = chance.choice(
                ("0x10", "1_2", "nan", "inf", "", "a", "1e", "--1")
            )
            meant = never
        case 4:
            table = [[*reversed(cells)] for cells in table]
        case 5:
            table = [["x y" if number else "note", *cells] for number, cells in enumerate(table)]
        case 6:
            table[row][0] = "a" * 200_000
            meant = never
        case 7:
            table = [[f'"{cell}"' for cell in cells] for cells in table]
        case 8:
            table[row][1] = chance.choice(("1e400", "-5", "0"))
            meant = None
        case 9:
            table.insert(row, [])
            meant = None
    text = end.join(map(mark.join, table)) + end
    encoding = chance.choice(("utf-8", "utf-8", "utf-8", "utf-8-sig", "utf-16"))
    content = text.encode(encoding)
    if chance.random() < 0.2:
        content = bytearray(content)
        for _ in range(chance.randint(1, 4)):
            content[chance.randrange(len(content))] = chance.randrange(256)
        return bytes(content), None
    return content, meant


def gaps(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield gap files: the distance with them is finite; some are solved with A."""
    text = FILES["mine.toml"].replace('["A", "Bhat", "C"]', '["A"]')
    scene = folder / "gap.toml"
    scene.write_text(f'{text}extra_gap = "gap.txt"\n', encoding="utf-8")
    for number in range(count):
        chance = np.random.default_rng([seed, number])
        (folder / "gap.txt").write_text(_gap_file(chance), encoding="utf-8")
        yield outcome(f"gap file {number}", lambda solve=number % SOLVED == 0: _with_gap(scene, solve=solve))


def _with_gap(path: Path, *, solve: bool) -> str:
    scene = load_scene(str(path))
    require_solvable(scene)
    for grid, _ in grids_of(scene.contact_problem):
        if not np.all(np.isfinite(pair_on_grid(scene.contact_problem, grid).distance)):
            raise AssertionError("the distance is not finite")
    if not solve:
        return "taken"
    compute_contact(scene, RunOptions(1))
    return "solved"


def _gap_file(chance: np.random.Generator) -> str:
    """Return points x, s, gap: scattered, on a grid, on a line, twice, nearly on a line, few; of any size."""
    n = int(chance.integers(1, 30))
    x, s = chance.uniform(-5, 5, (2, n))
    gap = chance.uniform(-0.02, 0.02, n)
    match int(chance.integers(10)):
        case 0:
            x[:] = chance.choice([0.0, 1.0])
        case 1:
            s[:] = 0.0
        case 2:
            x, s, gap = (np.append(values, values[0]) for values in (x, s, gap))
        case 3:
            s = 0.5 * x + chance.choice([0.0, 1e-13]) * chance.standard_normal(n)
        case 4:
            x, s = (values.ravel() for values in np.meshgrid(np.linspace(-4, 4, 7), np.linspace(-4, 4, 5)))
            gap = 0.03 * chance.choice([-1, 1]) * np.exp(-(x**2))
        case 5:
            x, s = 10.0 ** chance.integers(-12, 9) * x, 10.0 ** chance.integers(-12, 9) * s
        case 6:
            gap = gap * 10.0 ** chance.integers(-12, 9)
        case 7:
            gap[:] = chance.choice([-1e3, 1e3, 0.0, np.nan, np.inf])
    columns = [x, s, gap][: int(chance.choice([3, 3, 3, 3, 3, 2]))]
    rows = [" ".join(f"{value:.17g}" for value in row) for row in zip(*columns, strict=True)]
    if chance.random() < 0.1:
        rows.insert(
            int(chance.integers(len(rows) + 1)), str(chance.choice(["# note", "x s gap", "1 2", "1,2,3"]))
        )
    return "\n".join(rows)


# --- changes of TOML -------------------------------------------------------------------------------------


@cache
def _words_by_key(*texts: str) -> Mapping[str, list[str]]:
    """Return all words that keys have in some tables."""
    points: dict[str, set[str]] = {}

    def collect(key: str, value: Any) -> None:
        if isinstance(value, str):
            points.setdefault(key, set()).add(value)
        elif isinstance(value, dict | list):
            for inner, entry in value.items() if isinstance(value, dict) else ((key, part) for part in value):
                collect(inner, entry)

    for text in texts:
        collect("", tomllib.loads(text))
    return {key: sorted(words) for key, words in points.items()}


def changed(bases: Sequence[str], chance: random.Random) -> str:
    """Return the text of one of some tables with some changes; now and then of the text itself."""
    text = chance.choice(bases)
    if chance.random() < 0.1:
        lines = text.splitlines()
        lines.insert(chance.randrange(len(lines) + 1), chance.choice((*ODD_LINES, *lines)))
        return "\n".join(lines)
    table = tomllib.loads(text)
    for _ in range(chance.choice((1, 1, 1, 2))):
        _change(table, "", _words_by_key(*bases), chance)
    return tomlkit.dumps(table)


def _change(table: Any, name: str, words: Mapping[str, list[str]], chance: random.Random) -> None:
    """Change an entry somewhere in the table or list of a name; `words` are the values of keys."""
    keys = list(table) if isinstance(table, dict) else list(range(len(table)))
    if not keys:
        return
    key = chance.choice(keys)
    if isinstance(table[key], dict | list) and chance.random() < 0.85 and len(table[key]):
        _change(table[key], key if isinstance(key, str) else name, words, chance)
    elif chance.random() < 0.05:
        del table[key]
    elif chance.random() < 0.03 and isinstance(table, dict):
        table[f"{key}_"] = table[key]
    else:
        gentle = chance.random() < GENTLE
        words = words.get(key if isinstance(key, str) else name, WORDS)
        table[key] = _gently(table[key], words, chance) if gentle else _roughly(table[key], chance)


def _gently(value: Any, words: Sequence[str], chance: random.Random) -> Any:
    """Return another value of the same type."""
    match value:
        case bool():
            return not value
        case int():
            return max(0, value + chance.choice((-2, -1, 1, 2, value, 10 * value)))
        case float():
            scaled = value * 10 ** chance.gauss(0, 0.2) * chance.choice((*[1] * 9, -1))
            return scaled + chance.choice((*[0] * 5, 1e-3))
        case str():
            return chance.choice(words if chance.random() < 0.8 else WORDS)
        case list():
            return [*value, *value] if chance.random() < 0.5 else value[::-1]
    return {}


def _roughly(value: Any, chance: random.Random) -> Any:
    """Return a value of any type."""
    return chance.choice(
        (
            chance.choice(ODD_NUMBERS),
            chance.choice(ODD_WORDS),
            value * 10.0 ** chance.randint(-12, 12) if isinstance(value, float) else 1,
            [value],
            [],
            {"a": value},
            str(value),
            [[0.0, 1.0], [1.0, 2.0]],
        )
    )


# --- what femic says -------------------------------------------------------------------------------------


def outcome(attack: str, read: Callable[[], str], seconds: int = LONGEST) -> Outcome:
    """Return what femic answers where a file is read: taken, or refused with a message, in some seconds."""
    printed = io.StringIO()
    try:
        with limited(seconds), redirect_stdout(printed), redirect_stderr(printed):
            answer = read()
    except (WrongInput, Failure, OSError) as error:  # what commands print as a message
        return Outcome(attack, "refused", "" if str(error).strip() else "without a message")
    except AssertionError as error:
        return Outcome(attack, "wrong", str(error)[:300])
    except Exception as error:  # whatever it is, it would be a traceback
        return Outcome(attack, "traceback", f"{type(error).__name__}: {error}"[:300])
    if answer == "refused" and not printed.getvalue().strip():
        return Outcome(attack, answer, "without a message")
    return Outcome(attack, answer)


def by_code(code: int) -> str:
    """Return the answer of a command that ended with a code."""
    return "taken" if code == 0 else "refused"


@contextmanager
def limited(seconds: int = LONGEST) -> Iterator[None]:
    """Raise RuntimeError in what takes longer."""

    def late(*_: object) -> None:
        raise RuntimeError(f"does not end in {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
