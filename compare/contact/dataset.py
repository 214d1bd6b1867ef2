"""The labelled arrays of contacts, `contact.nc`: numbers with their estimates, pressures and gaps."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from operator import itemgetter

import numpy as np
import xarray as xr

from compare.contact.compute import ContactResults, reference_name
from femic.cache.digests import results_digest, versions
from femic.contact.finite_strain import finite_strain_share
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.pair_on_grid import PairContact
from femic.contact.pairs.quantities import OF_FRICTIONLESS, Quantity, numbers
from femic.scenes.scene import Scene

NUMBERS = ("case", "ics")
NONE = dict.fromkeys(OF_FRICTIONLESS, np.nan)


def ics_of(dataset: xr.Dataset) -> list[str]:
    """Return the names of the ICs."""
    return [str(name) for name in dataset.ics.values]


def reference_of(dataset: xr.Dataset) -> str:
    """Return the ICs that others are compared with."""
    return reference_name(ics_of(dataset))


def others_of(dataset: xr.Dataset) -> list[str]:
    """Return the ICs that are compared with the reference."""
    return [name for name in ics_of(dataset) if name != reference_of(dataset)]


def variables(
    quantities: Mapping[str, Quantity], dims: str | tuple[str, ...], tables: Mapping[str, object]
) -> dict[str, xr.Variable]:
    """Return variables PREFIX + NAME of quantities; `tables` has nested lists of numbers by prefix."""
    return {
        prefix + name: xr.Variable(
            dims,
            np.vectorize(itemgetter(name), otypes=[float])(table),
            {"units": quantity.unit, "long_name": quantity.meaning},
        )
        for prefix, table in tables.items()
        for name, quantity in quantities.items()
    }


def to_dataset(results: ContactResults) -> xr.Dataset:
    """Return numbers by case and ICs, and pressures [MPa] and gaps [mm] of each case on its own grid.

    `estimate_NAME` is the estimated error of NAME: from elements twice and four times as large
    (`femic.contact.estimates`), and, of C, the change with C plus its estimated error. `displaced_NAME`
    is the number with the exact distance of the displaced body; NaN where there is none.
    `finite_strain_p_max` is by how much strains that are not small may change p_max
    (`femic.contact.finite_strain`), with all ICs alike: it is in no estimate.
    """
    solution = results.solved
    solved = [[solution.contacts[loading, name] for name in solution.ics] for loading in solution.loadings]
    tables = {
        "": [[_numbers(contact.contact) for contact in row] for row in solved],
        "estimate_": [[contact.estimated_errors() for contact in row] for row in solved],
        "displaced_": [[_numbers(contact.displaced) for contact in row] for row in solved],
    }
    dataset = xr.Dataset(
        variables(OF_FRICTIONLESS, NUMBERS, tables),
        coords={"case": [str(loading) for loading in solution.loadings], "ics": list(solution.ics)},
        attrs=_attributes(results),
    )
    dataset["finite_strain_p_max"] = _finite_strain(results, dataset.p_max)
    dataset["iterations"] = (
        NUMBERS,
        [[contact.normal.solution.iterations for contact in row] for row in solved],
    )
    dataset["seconds"] = (NUMBERS, [[contact.seconds for contact in row] for row in solved], {"units": "s"})
    return dataset.merge(xr.merge([_fields(number, row) for number, row in enumerate(solved)]))


def _finite_strain(results: ContactResults, p_max: xr.DataArray) -> xr.DataArray:
    """Return by how much finite strains may change p_max [MPa], by case and ICs."""
    softest = min(body.material.E for body in results.scene.bodies.values())
    per_pressure = [
        [finite_strain_share(1.0, softest, load_given=loading.load is not None).p_max]
        for loading in results.solved.loadings
    ]
    meaning = "change of p_max by finite strains, at most"
    return (p_max**2 * np.array(per_pressure)).assign_attrs(units="MPa", long_name=meaning)


def with_supports(dataset: xr.Dataset, supports: Mapping[str, Mapping[str, float]]) -> xr.Dataset:
    """Return the arrays with `supported_NAME` (supports): the largest contact with C on other supports."""
    if not supports:
        return dataset
    loads = dataset["load"].sel(ics="C").values
    quantities = {
        name: replace(quantity, meaning=f"{quantity.meaning}, with other supports")
        for name, quantity in OF_FRICTIONLESS.items()
    }
    numbers_by_name = variables(quantities, "supports", {"supported_": list(supports.values())})
    supported = xr.Dataset(numbers_by_name, coords={"supports": list(supports)})
    return dataset.merge(supported).assign_attrs(dataset.attrs | {"supported_case": int(np.argmax(loads))})


def _numbers(contact: PairContact | None) -> dict[str, float]:
    """Return the numbers of a contact; NaN where there is none."""
    return NONE if contact is None else numbers(contact.on_grid, contact.normal)


def _fields(number: int, row: Sequence[SolvedContact]) -> xr.Dataset:
    """Return pressures and gaps of a case with all ICs: `p_0`, `gap_0` over `x_0`, `s_0` of case 0."""
    on_grid, ics = row[0].on_grid, [contact.ics for contact in row]
    x, s = f"x_{number}", f"s_{number}"
    p, gap = (np.stack([getattr(contact.normal, name) for contact in row]) for name in ("p", "gap"))
    inclination = on_grid.undeformed.lower.contour.inclination(on_grid.grid.strips)
    return xr.Dataset(
        {
            f"p_{number}": (("ics", x, s), p, {"units": "MPa"}),
            f"gap_{number}": (("ics", x, s), gap, {"units": "mm"}),
            f"inclination_{number}": (s, inclination, {"units": "rad"}),
        },
        coords={"ics": ics, x: (x, on_grid.x, {"units": "mm"}), s: (s, on_grid.grid.strips, {"units": "mm"})},
    )


def _attributes(results: ContactResults) -> dict[str, str | float]:
    references = {
        f"{grid.n_x} x {grid.n_s} x {grid.dx:g} x {grid.ds:g} mm": {
            "estimate": c.estimate,
            "asymmetry": c.asymmetry.share,
            "smallest_eigenvalue": c.eigenvalue,
            "seconds": c.seconds,
        }
        for grid, c in results.solved.references.items()
    }
    return {
        "title": f"Frictionless contact: {results.scene.title}",
        "meaning": "pressures of the upper on the lower body along its normals; x, s of the lower surface",
        "references": json.dumps(references),
        **provenance(results.scene, results.solved.seconds, __name__),
    }


def provenance(scene: Scene, seconds: float, module: str) -> dict[str, str | float]:
    """Return attributes on the origin of a file of contacts: scene, seconds, code, versions."""
    return {
        "scene": scene.text,
        "seconds": seconds,
        "code": results_digest(module),
        "versions": json.dumps(versions()),
    }
