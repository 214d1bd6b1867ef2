"""The labelled arrays of contacts, `contact.nc`: numbers with their estimates, pressures and gaps."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from compare.contact.compute import ContactResults, SolvedContact
from compare.contact.pair_on_grid import Settled
from compare.contact.quantities import QUANTITIES, kinds, measured, numbers
from femic.cache.digests import results_digest, versions
from femic.contact.estimates import changes, estimates, summed
from femic.scenes.scene import Scene

NUMBERS = ("case", "ics")
NONE = dict.fromkeys(QUANTITIES, np.nan)


def to_dataset(results: ContactResults) -> xr.Dataset:
    """Numbers by case and ICs, and pressures [MPa] and gaps [mm] of each case on its own grid.

    `estimate_NAME` is the estimated error of NAME: from elements twice and four times as large
    (`femic.contact.estimates`), and, of C, the change with C plus its estimated error. `displaced_NAME`
    is the number with the exact distance of the displaced body; NaN where it is not known.
    """
    solved = [[results.contacts[case, name] for name in results.ics] for case in results.cases]
    tables = {
        "": [[_numbers(contact.settled) for contact in row] for row in solved],
        "estimate_": [[estimates_of(contact) for contact in row] for row in solved],
        "displaced_": [[_numbers(contact.displaced) for contact in row] for row in solved],
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


def _numbers(found: Settled | None) -> dict[str, float]:
    """The numbers of a contact that was found; NaN where none was."""
    return NONE if found is None else numbers(found.placed, found.normal)


def estimates_of(contact: SolvedContact) -> dict[str, float]:
    """Estimated errors of the numbers; NaN where the grid is too small for one of larger elements."""
    normal, found, of_all = contact.normal, measured(contact.placed, contact.normal), kinds()
    if normal.coarser is None:
        return NONE
    larger = [
        numbers(replace(contact.placed, grid=one.problem.grid), one)
        for one in (normal.coarser, normal.coarser.coarser)
        if one is not None
    ]
    parts = [estimates(found, of_all, *larger)]
    if contact.perturbed is not None:
        parts.append(changes(found, of_all, _numbers(contact.perturbed)))
    known = summed(parts)
    if np.isfinite(contact.settled.stiffness):  # the lateral force is given, and the position follows
        known["position"] += known["F_y"] / contact.settled.stiffness
    return known


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


def provenance(scene: Scene, seconds: float, module: str) -> dict[str, str | float]:
    """Attributes that say what made a file of contacts: a module, with what it imports."""
    return {
        "scene": scene.text,
        "seconds": seconds,
        "code": results_digest(module),
        "versions": json.dumps(versions()),
    }
