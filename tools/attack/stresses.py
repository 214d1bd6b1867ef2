"""Stresses of scenes with keys and options changed at random: refused with words, or they obey mechanics."""

import random
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
import xarray as xr
from commands import FILES
from fuzz import by_code, changed, outcome
from outcomes import Outcome

from femic.cli.contact import option_changes
from femic.cli.main import exit_code
from femic.damage.dang_van import DangVan
from femic.damage.laws import ArchardMap, EnergyLaw, TwinDiscLaw
from femic.reference.run_options import RunOptions
from femic.results import stressed_contact as contacts
from femic.results.damage import OF_DAMAGE, compute_damage
from femic.scenes.load import load_scene

SOLVED, WHOLE = 15, 300  # of so many scenes the contact of one is solved, and the command of one is run
LONGEST = 600  # seconds that a command may take on a busy machine
ROUNDED = 1e-5  # of stresses in files, which have seven digits
FORCE = 1e-5  # of the load, by which forces may be off
WORK = 1e-6  # of the work of friction, by which that of an element may be below 0
OPTIONS = {
    "ics": ("A", "A,Bhat", "Bhat+sn:B", "", "A,A", "zz", "map:none.nc"),
    "friction": (0.1, 0.3, 1.0, 0.0, -0.3, 1e9, float("nan")),
    "force": (0.0, 0.5, -0.5, 0.999, 1.0, -2.0, float("inf")),
    "fineness": (0.25, 0.5, 1.0, 0.0, 100.0, float("nan")),
    "yield_stress": (600.0, 1e-9, 0.0, -1.0, 1e300),
    "hardness": (3000.0, 0.0, -1.0, float("nan")),
    "speed": (30.0, 1e-9, 0.0, -1.0, 1e300),
}
STRESSES = {"fineness": 0.25, "estimated": False}
LAWS = {"energy": EnergyLaw(), "twin_disc": TwinDiscLaw(), "archard": ArchardMap(), "dang_van": DangVan()}
DAMAGE: dict[str, Any] = {"yield_stress": 600.0, "hardness": 3000.0, "speed": 30.0}
DAMAGE |= {name: asdict(law) for name, law in LAWS.items()}
del DAMAGE["archard"]["hardness"]  # is a key of [damage]
WORN = {"passages": 1e4, "revolutions": 1e4, "steps": 2, "spread": 0.2}
TABLES: Sequence[tuple[str, dict[str, Any]]] = (
    ("mine.toml", {"damage": {"dang_van": DAMAGE["dang_van"]}}),
    ("rolls.toml", {"damage": DAMAGE}),
    ("rolls.toml", {"damage": DAMAGE | WORN}),
    ("pressed.toml", {}),
)


def stresses(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield scenes with [stresses], [damage] and options: read; the contacts of some are solved, some run."""
    bases = [
        tomlkit.dumps(tomllib.loads(FILES[name].replace(', "C"', "")) | {"stresses": STRESSES} | tables)
        for name, tables in TABLES
    ]
    path = folder / "stresses.toml"
    for number in range(count):
        chance = random.Random(f"stresses {seed} {number}")
        path.write_text(changed(bases, chance), encoding="utf-8", errors="replace")
        options = {name: chance.choice(values) for name, values in OPTIONS.items() if chance.random() < 0.04}
        if number % WHOLE == 0:
            yield outcome(f"stresses {number}", partial(_run, path, options), LONGEST)
        else:
            solve = number % SOLVED == 0
            yield outcome(f"stresses {number}", partial(_read, path, options, solve=solve), LONGEST)


def _read(path: Path, options: Mapping[str, Any], *, solve: bool) -> str:
    """Read a scene as the command does; solve its contact, with wear and fatigue numbers, if asked."""
    scene = load_scene(str(path), option_changes(**options))
    contacts.require_stresses(scene)
    if not solve:
        return "taken"
    solved = contacts.solve_contacts(scene, RunOptions(1))
    one = contacts.with_one_contact(scene).contact
    for name, tractions in solved.tractions.items():
        force = solved.on_grid.resultant(tractions).force[2]
        if one.loads and abs(force - one.loads[-1]) > FORCE * one.loads[-1]:
            raise AssertionError(f"{name} bears {force:g} N of {one.loads[-1]:g} N")
    for name, rolling in solved.rolling.items():
        _require_damage(name, compute_damage(rolling, scene.damage), solved.friction)
    return "solved"


def _require_damage(name: str, damage: xr.Dataset, friction: float) -> None:
    """Raise AssertionError where friction gives work, a depth is negative, or more friction than there is."""
    numbers = {key: float(damage[key]) for key in OF_DAMAGE if key in damage}
    work, shares = damage.work_density.values, damage.regime_share.values
    wrong = {
        "numbers are not finite": not np.all(np.isfinite([*numbers.values(), *shares])),
        "friction gives energy": numbers["work"] < 0 or np.min(work) < -WORK * np.max(np.abs(work)),
        "wear adds material": any(np.min(depth) < -WORK * np.max(depth) for depth in damage.depth.values),
        "more than all friction": numbers["utilised_friction"] > friction * (1 + FORCE),
        "shares beyond 0 ... 1": not 0 <= sum(shares) <= 1 + WORK,
    }
    if short := [text for text, holds in wrong.items() if holds]:
        raise AssertionError(f"{name}: {short[0]}")


def _run(path: Path, options: Mapping[str, Any]) -> str:
    """Run the command; stresses in its file lie between what von Mises and Tresca allow each other."""
    out = path.parent / "out"
    given = [text for name, value in options.items() for text in (f"--{name.replace('_', '-')}", str(value))]
    answer = by_code(exit_code(["stresses", str(path), *given, "--out", str(out), "--workers", "1"]))
    if answer == "refused":
        return answer
    with xr.load_dataset(out / "stresses.nc", engine="h5netcdf") as dataset:
        mises, shear = dataset.von_mises.values, dataset.tresca.values
        fields_of = [dataset[f"stress_{body}"].values for body in ("upper", "lower")]
    if not all(np.all(np.isfinite(values)) for values in (mises, shear, *fields_of)):
        raise AssertionError("stresses are not finite")
    if np.any(mises > shear * (1 + ROUNDED)) or np.any(shear > 2 / np.sqrt(3) * mises * (1 + ROUNDED)):
        raise AssertionError("stresses by Tresca are less than by von Mises, or more than 2/sqrt(3) of them")
    return "run"
