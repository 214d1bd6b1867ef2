"""Commands on small scenes: how they are run, and how their results are compared."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import xarray as xr

ROOT = Path(__file__).parents[2]
LONGEST = 300.0  # seconds that a command may take
BODIES = """
[lower]
E = 210e3
nu = 0.3
contour = { kind = "arc", radius = 10.0, flank_inclination_deg = 40.0 }
[upper]
E = 210e3
nu = 0.3
rolling_radius = 400.0
contour = { kind = "arc", radius = 12.0, flank_inclination_deg = 40.0 }
[patch]
a = 0.3
b = 0.3
"""
LIGHT = """
[[lines]]
along = "x"
s = 1.0
reach = 4.0
points = 9
[grid]
n_x = 6
n_s = 6
dx = 0.6
ds = 0.6
[calibration]
points = 9
[engine]
tolerance = 0.3
"""
FILES = {  # in the folder that commands run in
    "mine.toml": 'components = ["nn", "xn"]'
    + BODIES
    + LIGHT
    + '[contact]\nloads = [2000.0]\nics = ["A", "Bhat", "C"]\nelements = 8\nsupports = false\n',
    "other.toml": 'components = ["nn", "xn"]' + BODIES.replace("12.0", "13.0") + LIGHT,
    "rolls.toml": BODIES
    + '[contact]\nmotion = "rolling"\nloads = [2000.0]\nfriction = [0.3]\nelements = 8\n'
    + 'longitudinal = [-0.002, 0.0, 0.002]\nics = ["A", "Bhat"]\n',
    "pressed.toml": BODIES
    + '[contact]\nmotion = "compression"\nloads = [1000.0, 2000.0]\nfriction = [0.3]\nelements = 8\n'
    + 'ics = ["A", "Bhat"]\n',
    "many.toml": 'scene = "mine.toml"\n[sweep.nu]\nkeys = ["lower.nu"]\nvalues = [0.2, 0.25, 0.3]\n',
}
NOT_RESULTS = ("seconds", "memory", "checksum")  # ends of names of variables that no two runs have alike


@dataclass(frozen=True)
class Command:
    """A command, the folder that it writes to, and the files that are its results."""

    name: str
    arguments: Sequence[str]
    folder: str
    results: Sequence[str]

    def begin(self, at: Path, *more: str) -> subprocess.Popen[str]:
        """Return the process of the command in a folder, with a log of its own."""
        with (at / f"{self.name}.log").open("w", encoding="utf-8") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "femic", *self.arguments, *more],
                cwd=at,
                env=os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
                stdout=log,
                stderr=subprocess.STDOUT,
                text=True,
                start_new_session=True,
            )

    def ended(self, process: subprocess.Popen[str], at: Path) -> "Ended":
        """Return the end of a process, which is killed with all that it has begun where it does not end."""
        try:
            code = process.wait(LONGEST)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            code = process.wait()
        return Ended(code, (at / f"{self.name}.log").read_text(encoding="utf-8", errors="replace"))

    def run(self, at: Path, *more: str) -> "Ended":
        """Run to the end."""
        return self.ended(self.begin(at, *more), at)

    @property
    def again(self) -> "Command":
        """The command with a log of its own."""
        return replace(self, name=f"{self.name} again")

    def differences(self, at: Path, reference: Path) -> str:
        """Return what is not as in the reference among the results; "" if nothing is."""
        for name in self.results:
            mine, other = (folder / self.folder / name for folder in (at, reference))
            if text := _difference(mine, other):
                return f"{name}: {text}"
        return ""


@dataclass(frozen=True)
class Ended:
    """How a command ended: exit code and what it printed."""

    code: int
    text: str

    @property
    def trouble(self) -> str:
        """What no command may do."""
        if "Traceback (most recent call last)" in self.text:
            return f"traceback: {self.text.strip().splitlines()[-1][:200]}"
        return "" if self.code in (0, 1, 2, 130) else f"exit code {self.code}"

    @property
    def failure(self) -> str:
        """Trouble, or an exit code other than 0, which a command that can be done must have."""
        message = " ".join(self.text.split())[-200:]
        return self.trouble or (f"exit code {self.code}: {message}" if self.code else "")


COMMANDS = (
    Command("run", ["run", "mine.toml", "--out", "out/mine"], "out/mine", ["ics.nc", "errors.nc"]),
    Command("matrix", ["matrix", "mine.toml", "--out", "out/mine"], "out/mine", ["matrix.nc"]),
    Command("contact", ["contact", "mine.toml", "--out", "out/mine"], "out/mine", ["contact.nc"]),
    Command("rolling", ["contact", "rolls.toml", "--out", "out/r"], "out/r", ["contact.nc"]),
    Command("compression", ["contact", "pressed.toml", "--out", "out/p"], "out/p", ["contact.nc"]),
    Command("export", ["export", "mine.toml", "--out", "out/mine"], "out/mine", ["contact_C.txt"]),
    Command("calibrate", ["calibrate", "mine.toml", "--out", "out/mine"], "out/mine", ["calibration.nc"]),
    Command(
        "compare",
        ["compare", "mine.toml", "other.toml", "--results", "out"],
        "out",
        ["mine/ics.nc", "other/ics.nc", "other/errors.nc", "mine_other/curves_s1mm.csv"],
    ),
    Command("sweep", ["sweep", "many.toml", "--out", "out/many"], "out/many", ["sweep.nc"]),
)


class Place:
    """A temporary folder with the files of the scenes, and copies of it."""

    def __init__(self) -> None:
        self._folder = TemporaryDirectory(prefix="femic-attack-")
        self.path = Path(self._folder.name)
        self.fresh = self.path / "fresh"
        self.fresh.mkdir()
        self._references: dict[str, tuple[Path, float]] = {}
        for name, text in FILES.items():
            (self.fresh / name).write_text(text, encoding="utf-8")

    def __enter__(self) -> "Place":
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()

    def reference(self, command: Command) -> tuple[Path, float]:
        """Return a folder in which a command has run undisturbed, and how many seconds it took."""
        if command.name not in self._references:
            folder, start = self.copy(self.fresh, f"reference-{command.name}"), perf_counter()
            if failure := command.run(folder).failure:
                raise SystemExit(f"{command.name}, undisturbed: {failure}")
            self._references[command.name] = folder, perf_counter() - start
        return self._references[command.name]

    def copy_logs(self, to: Path) -> None:
        """Copy what commands printed in the last attack."""
        for log in self.path.glob("*/*.log"):
            if not log.parent.name.startswith("reference-"):
                to.mkdir(parents=True, exist_ok=True)
                shutil.copy(log, to)

    def copy(self, folder: Path, name: str) -> Path:
        """Return a copy of a folder under a name, in the place of an earlier one."""
        target = self.path / name
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(folder, target)
        return target


def kept_files(folder: Path) -> Iterator[Path]:
    """Yield all files in a folder that commands have written, without logs, scenes and locks."""
    for path in sorted((folder / "out").rglob("*")):
        if path.is_file() and not path.name.endswith(".lock"):
            yield path


def _difference(mine: Path, other: Path) -> str:
    """Return what differs between two files of results; "" if nothing does."""
    if not mine.exists():
        return "is missing"
    if mine.suffix != ".nc":
        return "" if mine.read_bytes() == other.read_bytes() else "differs"
    try:
        datasets = [xr.load_dataset(path, engine="h5netcdf") for path in (mine, other)]
    except (OSError, ValueError) as error:
        return f"cannot be read: {error}"
    actual, expected = (
        dataset.drop_vars([name for name in dataset.variables if str(name).endswith(NOT_RESULTS)])
        for dataset in datasets
    )
    if {*actual.variables} != {*expected.variables}:
        return f"has other variables: {sorted(map(str, {*actual.variables} ^ {*expected.variables}))}"
    differ = (name for name in actual.variables if not actual[name].variable.equals(expected[name].variable))
    return ", ".join(f"{name} differs" for name in differ)
