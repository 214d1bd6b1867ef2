"""The labelled arrays of contacts, `contact.nc`: numbers with their estimates, pressures and gaps."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from compare.results.contact.compute import ContactResults, SolvedContact
from compare.results.contact.quantities import QUANTITIES, main_patch, numbers
from compare.results.provenance import results_digest
from compare.scenes.scene import Scene
from femic.work.provenance import versions

NUMBERS = ("case", "ics")
OF_EDGES = ("a", "b", "aspect", "angle", "area", "stiffness")  # numbers that rest on where edges lie
OF_ALL = ("approach", "p_max")  # numbers that rest on all pressures
OF_PLACE = ("F_y", "M_x", "s_centre")  # numbers that vanish where all is symmetric
NONE = dict.fromkeys(QUANTITIES, np.nan)


def to_dataset(results: ContactResults) -> xr.Dataset:
    """Numbers by case and ICs, and pressures [MPa] and gaps [mm] of each case on its own grid.

    `estimate_NAME` is the estimated error of NAME: the difference to elements twice as large (the largest of
    those of related numbers, because one alone may be small by luck, and the accuracy of edges) and, of C,
    that to C plus its estimated error. `displaced_NAME` is the number with the exact distance of the
    displaced body; NaN where it is not known.
    """
    solved = [[results.contacts[case, name] for name in results.ics] for case in results.cases]
    tables = {
        "": [[_numbers(contact) for contact in row] for row in solved],
        "estimate_": [[_estimates(contact) for contact in row] for row in solved],
        "displaced_": [[_displaced(contact) for contact in row] for row in solved],
    }
    dataset = xr.Dataset(
        {
            prefix + name: (
                NUMBERS,
                [[contact[name] for contact in row] for row in table],
                {"units": quantity.unit, "long_name": quantity.meaning},
            )
            for prefix, table in tables.items()
            for name, quantity in QUANTITIES.items()
        },
        coords={"case": [str(case) for case in results.cases], "ics": list(results.ics)},
        attrs=_attributes(results),
    )
    dataset["iterations"] = (
        NUMBERS,
        [[contact.normal.solution.iterations for contact in row] for row in solved],
    )
    dataset["seconds"] = (NUMBERS, [[contact.seconds for contact in row] for row in solved], {"units": "s"})
    return dataset.merge(xr.merge([_fields(number, row) for number, row in enumerate(solved)]))


def with_supports(dataset: xr.Dataset, supports: Mapping[str, Mapping[str, float]]) -> xr.Dataset:
    """The arrays with `supported_NAME` (supports): numbers of the largest contact by C with others."""
    if not supports:
        return dataset
    loads = dataset["load"].sel(ics="C").values
    numbers_by_name = {
        f"supported_{name}": (
            "supports",
            [of_supports[name] for of_supports in supports.values()],
            {"units": quantity.unit, "long_name": f"{quantity.meaning}, with other supports"},
        )
        for name, quantity in QUANTITIES.items()
    }
    found = xr.Dataset(numbers_by_name, coords={"supports": list(supports)})
    return dataset.merge(found).assign_attrs(dataset.attrs | {"supported_case": int(np.argmax(loads))})


def _numbers(contact: SolvedContact) -> dict[str, float]:
    return numbers(contact.placed, contact.normal)


def _displaced(contact: SolvedContact) -> dict[str, float]:
    displaced = contact.displaced
    return NONE if displaced is None else numbers(displaced.placed, displaced.normal)


def _estimates(contact: SolvedContact) -> dict[str, float]:
    """Estimated errors of the numbers; NaN where the grid is too small for one of larger elements."""
    normal, values = contact.normal, _numbers(contact)
    if normal.coarser is None:
        return NONE
    coarse = numbers(replace(contact.placed, grid=normal.coarser.problem.grid), normal.coarser)
    other = contact.perturbed
    perturbed = values if other is None else numbers(other.placed, other.normal)
    changes = {name: abs(coarse[name] / values[name] - 1) for name in (*OF_EDGES, *OF_ALL, "load")}
    patch, grid = main_patch(normal), contact.placed.grid
    readings = patch.accuracy_x * grid.dx / values["a"] + patch.accuracy_s * grid.ds / values["b"]
    of_edges = max(changes[name] for name in OF_EDGES) + readings
    of_all = max(changes[name] for name in OF_ALL)
    shares = dict.fromkeys(OF_EDGES, of_edges) | dict.fromkeys(OF_ALL, of_all) | {"load": changes["load"]}
    parts = {name: abs(values[name]) * share for name, share in shares.items()}
    parts |= {name: abs(values[name] - coarse[name]) for name in OF_PLACE}
    parts["position"] = parts["F_y"] / contact.settled.stiffness
    return {name: part + abs(values[name] - perturbed[name]) for name, part in parts.items()}


def _fields(number: int, row: Sequence[SolvedContact]) -> xr.Dataset:
    """Pressures and gaps of one case by all ICs, on its grid: `p_0`, `gap_0` over `x_0`, `s_0` of case 0."""
    placed, ics = row[0].placed, [contact.ics for contact in row]
    x, s = f"x_{number}", f"s_{number}"
    inclination = placed.undeformed.lower.contour.inclination(placed.grid.strips)
    return xr.Dataset(
        {
            f"p_{number}": (("ics", x, s), np.stack([contact.normal.p for contact in row]), {"units": "MPa"}),
            f"gap_{number}": (
                ("ics", x, s),
                np.stack([contact.normal.gap for contact in row]),
                {"units": "mm"},
            ),
            f"inclination_{number}": (s, inclination, {"units": "rad"}),
        },
        coords={"ics": ics, x: (x, placed.x, {"units": "mm"}), s: (s, placed.grid.strips, {"units": "mm"})},
    )


def _attributes(results: ContactResults) -> dict[str, str | float]:
    references = {
        f"{grid.n_x} x {grid.n_s} x {grid.dx:g} x {grid.ds:g} mm": {
            "estimate": c.estimate,
            "asymmetry": c.asymmetry,
            "smallest_eigenvalue": c.eigenvalue,
            "seconds": c.seconds,
        }
        for grid, c in results.references.items()
    }
    return {
        "title": f"Frictionless contact: {results.scene.title}",
        "meaning": "pressures of the upper on the lower body along its normals; x, s of the lower surface",
        "references": json.dumps(references),
        **provenance(results.scene, results.seconds, __name__),
    }


def write(dataset: xr.Dataset, path: Path) -> None:
    """Write labelled arrays completely or not at all."""
    temporary = path.with_suffix(".part")
    dataset.to_netcdf(temporary, engine="h5netcdf")
    temporary.replace(path)


def provenance(scene: Scene, seconds: float, module: str) -> dict[str, str | float]:
    """Attributes that say what made a file of contacts: a module, with what it imports."""
    return {
        "scene": scene.text,
        "seconds": seconds,
        "code": results_digest(module),
        "versions": json.dumps(versions()),
    }
