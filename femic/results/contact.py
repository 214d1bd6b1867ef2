"""Frictionless contact of a scene with several ICs: what is refused, the solution, the dataset `contact.nc`.

The dataset has the numbers with their estimates, and pressures and gaps by place.
"""

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from approx.variants import needs_effective
from femic.cache.digests import results_digest, versions
from femic.contact.datasets import (
    CHANGE,
    DISPLACED,
    FLOOR,
    INCLINATION,
    LARGER,
    MISSED,
    SECONDS,
    S,
    X,
    variables,
)
from femic.contact.feasibility import impossible, without_operator
from femic.contact.finite_strain import finite_strain_shares
from femic.contact.loading import amount
from femic.contact.motions.none import FrictionlessContacts, SolvedContact, solve_frictionless
from femic.contact.pairs import ics as given_ics
from femic.contact.pairs.ics import NONE_GIVEN, C, NormalICs
from femic.contact.pairs.quantities import OF_FRICTIONLESS, numbers
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.matrices import discounted
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import BadScene, require_none
from femic.scenes.ic_names import is_map
from femic.scenes.lines import grid_misfits, single_load_misfits
from femic.scenes.scene import Scene
from geometries.arrays import Array

# --- the solution ---------------------------------------------------------------------------------------


def require_solvable(scene: Scene, given: Collection[str] = ()) -> None:
    """Raise BadScene where the contact of a scene cannot be solved, before any work; `given` name ICs."""
    specification = scene.contact
    if not specification.loadings:
        raise BadScene(f"{scene.name}: [contact]: give loads = [...] in N, or approaches = [...] in mm")
    approximations = [
        name for name in specification.ics if name != C and name not in given and not is_map(name)
    ]
    if needs_effective(*approximations) and not scene.pair.has_effective("combined"):
        raise BadScene(
            f"{scene.name}: contact.ics: Bhat_prime needs effective properties of both bodies: "
            "`femic calibrate` fits them"
        )
    misfits: list[str] = []
    if C in specification.ics and C not in given:
        misfits += [*single_load_misfits(scene), *matrix_engine_misfits(scene)]
        misfits += () if specification.automatic else grid_misfits(scene)
    problem = scene.contact_problem
    require_none(scene.name, [*misfits, *without_operator(problem, approximations), *impossible(problem)])


def map_names(ics: Sequence[str]) -> list[str]:
    """Return the names of maps of C among names of ICs."""
    return [name for name in ics if is_map(name)]


def reference_name(ics: Sequence[str]) -> str:
    """Return the ICs that others are compared with: C, or else a map of it, B-hat, or the last."""
    return given_ics.reference_name(ics, map_names(ics))


def solve_scene(
    scene: Scene, options: RunOptions = DEFAULT, given: Mapping[str, NormalICs] = NONE_GIVEN
) -> FrictionlessContacts:
    """Solve all frictionless contacts of a scene; `given` are ICs by name, such as its maps of C.

    Raises BadScene for what cannot be solved, and Failure as `femic.contact`.
    """
    require_solvable(scene, given)
    return solve_frictionless(scene.contact_problem, options, given)


def compute_contact(
    scene: Scene, options: RunOptions = DEFAULT, given: Mapping[str, NormalICs] = NONE_GIVEN
) -> xr.Dataset:
    """Return the dataset of all frictionless contacts of a scene; raises as `solve_scene`."""
    return to_dataset(scene, solve_scene(scene, options, given))


# --- the dataset ----------------------------------------------------------------------------------------


def ics_names(dataset: xr.Dataset) -> list[str]:
    """Return the names of the ICs."""
    return [str(name) for name in dataset.ics.values]


def reference_ics(dataset: xr.Dataset) -> str:
    """Return the ICs that others are compared with."""
    return reference_name(ics_names(dataset))


def compared_ics(dataset: xr.Dataset) -> list[str]:
    """Return the ICs that are compared with the reference."""
    return [name for name in ics_names(dataset) if name != reference_ics(dataset)]


def case_names(dataset: xr.Dataset) -> list[str]:
    """Return the cases with their unit: 4000 N, 0.01 mm."""
    return [amount(value, dataset.case.attrs["units"]) for value in dataset.case.values.tolist()]


def pressures(dataset: xr.Dataset, number: int) -> xr.DataArray:
    """Return the pressures of a case on its own grid, with places `x` and `s` [mm]."""
    p = dataset.p.isel(case=number)
    for dim in {"x", "s"}.intersection(p.dims):
        p = p.dropna(dim, how="all")
    return p


def padded(arrays: Sequence[Array]) -> Array:
    """Return arrays along a new first dimension, with NaN beyond those that are smaller."""
    whole = np.full((len(arrays), *np.max([array.shape for array in arrays], axis=0)), np.nan)
    for row, array in zip(whole, arrays, strict=True):
        row[tuple(map(slice, array.shape))] = array
    return whole


def to_dataset(scene: Scene, solution: FrictionlessContacts) -> xr.Dataset:
    """Return numbers by case, a prescribed load or approach, and ICs, and pressures and gaps by place.

    Each case has a grid of its own: `x` and `s` [mm] are its places, and beyond them all is NaN.

    `estimate_NAME` is the estimated error of NAME: from elements twice and four times as large
    (`femic.contact.estimates`), and, of C, the change with C plus its estimated error. `displaced_NAME`
    is the number with the exact distance of the displaced body; NaN where there is none. `larger_NAME`,
    `change_NAME` and `floor_NAME` are as in `femic.contact.datasets`.
    `finite_strain_p_max` is by how much strains that are not small may change p_max
    (`femic.contact.finite_strain`), with all ICs alike: it is in no estimate.
    """
    dims = ("case", "ics")
    solved = [[solution.contacts[loading, name] for name in solution.ics] for loading in solution.loadings]
    nothing = dict.fromkeys(OF_FRICTIONLESS, np.nan)

    def by_contact(value: Callable[[SolvedContact], Any]) -> list[list[Any]]:
        return [[value(contact) for contact in row] for row in solved]

    def displaced(contact: SolvedContact) -> dict[str, float]:
        other = contact.displaced
        return numbers(other.on_grid, other.normal) if other else nothing

    tables = {
        "": by_contact(lambda contact: contact.measured.numbers),
        "estimate_": by_contact(lambda contact: contact.estimated_errors()),
        DISPLACED: by_contact(displaced),
    }
    varied = by_contact(lambda contact: contact.variations())
    for prefix in (LARGER, CHANGE, FLOOR, MISSED):
        tables[prefix] = [[variations[prefix] for variations in row] for row in varied]
    by_load = solution.loadings[0].load is not None
    name, unit = ("load", "N") if by_load else ("approach", "mm")
    cases = [float(getattr(loading, name)) for loading in solution.loadings]
    grids = [row[0].on_grid for row in solved]
    mpa, mm = {"units": "MPa", "long_name": "pressure"}, {"units": "mm"}
    gap = mm | {"long_name": "gap between the deformed bodies"}
    fields = {
        field: padded([np.stack([getattr(contact.normal, field) for contact in row]) for row in solved])
        for field in ("p", "gap")
    }
    inclinations = [each.undeformed.lower.contour.inclination(each.grid.strips) for each in grids]
    dataset = xr.Dataset(
        variables(OF_FRICTIONLESS, dims, tables)
        | {
            "iterations": xr.Variable(
                dims,
                by_contact(lambda contact: contact.normal.solution.iterations),
                {"units": "1", "long_name": "iterations for the pressures"},
            ),
            "seconds": xr.Variable(dims, by_contact(lambda contact: contact.seconds), SECONDS),
            "p": xr.Variable((*dims, "x", "s"), fields["p"], mpa),
            "gap": xr.Variable((*dims, "x", "s"), fields["gap"], gap),
            "inclination": xr.Variable(("case", "s"), padded(inclinations), INCLINATION),
        },
        coords={
            "case": xr.Variable("case", cases, {"units": unit, "long_name": f"prescribed {name}"}),
            "ics": list(solution.ics),
            "x": xr.Variable(("case", "x"), padded([on_grid.x for on_grid in grids]), X),
            "s": xr.Variable(("case", "s"), padded([on_grid.grid.strips for on_grid in grids]), S),
        },
    )
    softest = min(body.material.E for body in scene.bodies.values())
    per_square, _ = finite_strain_shares(1.0, softest, load_given=by_load)
    dataset["finite_strain_p_max"] = (dataset.p_max**2 * per_square).assign_attrs(
        units="MPa", long_name="largest change of p_max by finite strains"
    )
    references = {
        f"{grid.n_x} x {grid.n_s} x {grid.dx:g} x {grid.ds:g} mm": {
            "estimate": c.estimate,
            "asymmetry": c.asymmetry.share,
            "smallest_eigenvalue": c.eigenvalue,
            "seconds": c.seconds,
        }
        for grid, c in solution.references.items()
    }
    return dataset.assign_attrs(
        title=f"Contact without friction: {scene.title}",
        meaning="pressures of the upper on the lower body along its normals; x, s of the lower surface",
        references=json.dumps(references),
        discounted=discounted(scene),
        **provenance(scene, solution.seconds),
    )


def with_supports(dataset: xr.Dataset, supports: Mapping[str, Mapping[str, float]]) -> xr.Dataset:
    """Return the arrays with `supported_NAME` (supports): the largest contact with C on other supports."""
    if not supports:
        return dataset
    loads = dataset["load"].sel(ics="C").values
    numbers_by_name = variables(OF_FRICTIONLESS, "supports", {"supported_": list(supports.values())})
    supported = xr.Dataset(numbers_by_name, coords={"supports": list(supports)})
    return dataset.merge(supported).assign_attrs(dataset.attrs | {"supported_case": int(np.argmax(loads))})


def provenance(scene: Scene, seconds: float) -> dict[str, str | float]:
    """Return attributes on the origin of a file of contacts: scene, tolerance, seconds, code, versions."""
    return {
        "scene": scene.text,
        "ics_tolerance": scene.ics_tolerance,
        "seconds": seconds,
        "code": results_digest(),
        "versions": json.dumps(versions()),
    }
