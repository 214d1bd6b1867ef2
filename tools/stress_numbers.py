"""The numbers of docs/decide/stresses.md: how wrong half-spaces are inside the bodies, by the patch's angle.

The two academic pairs without friction, at loads that give patches of 20 to 110 degrees. Called by
tools/write_docs.py; results are stored in out/stresses/.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from femic.cache.digests import STUDY_FOLDERS, results_digest, versions
from femic.cache.store import Store
from femic.contact.motions.none import solve_frictionless
from femic.contact.pairs.quantities import numbers
from femic.reference.run_options import RunOptions, Watch, cores
from femic.results.stresses import ACTUAL, HALF_SPACE, HALF_SPACE_OF_A, compute_stresses
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene

STORE = Path("out") / "stresses" / "store"
LOADS = {  # N; those near 40, 80 and 110 degrees are the source's
    "wide": (82e3, 660e3, 2230e3, 5300e3, 18000e3),
    "tall": (0.92e3, 7.4e3, 25e3, 58e3, 310e3),
}
ICS = ("A", "C")
OFF = (0.05, 0.1)  # of the largest von Mises stress


def compute() -> dict[str, Any]:
    """Return the numbers of the page."""
    options = RunOptions(cores(), Store(STORE), Watch(on_stage=report))
    pairs = {name: [_row(name, load, options) for load in loads] for name, loads in LOADS.items()}
    return {
        "code": results_digest(*STUDY_FOLDERS),
        "versions": versions(),
        "off": list(OFF),
        "pairs": {
            name: {"rows": rows, "from": {_percent(off): _first_angles(rows, off) for off in OFF}}
            for name, rows in pairs.items()
        },
    }


def _row(name: str, load: float, options: RunOptions) -> dict[str, Any]:
    """Return the numbers of a pair at a load [N]."""
    start = perf_counter()
    scene = load_scene(name, {"contact": {"loads": [load], "ics": list(ICS)}})
    dataset = compute_stresses(scene, options)
    report(f"{name}, {load:g} N: {perf_counter() - start:.0f} s")
    return {
        "load": load,
        "angle": _angle(scene, options),
        "p_max": float(dataset.attrs["p_max_of_reference"]),
        "p_max_of_A": float(dataset.attrs["p_max_of_A"]),
        "bodies": {body: _of_body(dataset.sel(body=body)) for body in map(str, dataset.body.values)},
    }


def _angle(scene: Scene, options: RunOptions) -> float:
    """Return the angle of the patch with C [deg]."""
    solved = solve_frictionless(scene.contact_problem, options)
    (loading,) = solved.loadings
    contact = solved.contacts[loading, "C"]
    return numbers(contact.on_grid, contact.normal)["angle"]


def _of_body(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the largest von Mises stress of a body, where it is, and how far half-spaces are off."""
    true = dataset.sel(source=ACTUAL)
    return {
        "von_mises": float(true.von_mises),
        "estimate": float(true.estimate_von_mises),
        "s": float(true.s_von_mises),
        "depth": float(true.depth_von_mises),
        "half_space": float(dataset.difference_von_mises.sel(source=HALF_SPACE)),
        "half_space_of_A": float(dataset.difference_von_mises.sel(source=HALF_SPACE_OF_A)),
        "section": float(dataset.section_difference.sel(source=HALF_SPACE)),
    }


def _first_angles(rows: Sequence[dict[str, Any]], off: float) -> dict[str, float | None]:
    """Return the angles [deg] from which on half-spaces are off by more, by body and number.

    Between the loads that were solved errors are taken as linear in the angle; from 0 on they grow from 0.
    None where they never are.
    """
    angles = [0.0, *(row["angle"] for row in rows)]
    return {
        f"{body}, {number}": _first(angles, [0.0, *(abs(row["bodies"][body][number]) for row in rows)], off)
        for body in rows[0]["bodies"]
        for number in ("half_space", "section")
    }


def _first(angles: Sequence[float], errors: Sequence[float], off: float) -> float | None:
    above = np.flatnonzero(np.array(errors) > off)
    if not len(above):
        return None
    ends = slice(int(above[0]) - 1, int(above[0]) + 1)
    return float(np.interp(off, errors[ends], angles[ends]))


def _percent(share: float) -> str:
    return f"{100 * share:g}"


def report(line: str) -> None:
    sys.stderr.write(f"{line}\n")
