"""The labelled arrays of stresses below a contact, `stresses.nc`: numbers, fields, wear and fatigue."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from compare.contact.dataset import provenance
from compare.stresses.compute import TRUE, BodyStresses, StressResults
from compare.stresses.contacts import Contacts
from femic.damage.specification import CONSTANTS
from femic.stresses.measures import largest, principal_values, tresca, von_mises
from femic.stresses.points import InnerPoints
from geometries.arrays import Array
from geometries.patches import DIRECTIONS


@dataclass(frozen=True)
class Number:
    """A number: its symbol, its unit, and what it is."""

    symbol: str
    unit: str
    meaning: str

    @property
    def title(self) -> str:
        """The symbol, and the unit in brackets."""
        return self.symbol if self.unit == "1" else f"{self.symbol} [{self.unit}]"


OF_STRESS = {
    "von_mises": Number("σ_Mises", "MPa", "largest von Mises stress"),
    "tresca": Number("σ_Tresca", "MPa", "largest Tresca stress, twice the largest shear stress"),
    "principal": Number("σ_1", "MPa", "largest principal stress, positive in tension"),
    "dang_van": Number("τ_DV", "MPa", "largest equivalent stress of Dang Van over a passage"),
}
MEASURES: Mapping[str, Callable[[Array], Array]] = {
    "von_mises": von_mises,
    "tresca": tresca,
    "principal": lambda stress: np.asarray(principal_values(stress)[..., 2]),
}
PLACES = "x", "s", "depth"
OF_DAMAGE = {
    "xi": Number("ξ", "1", "longitudinal creepage"),
    "p_max": Number("p_max", "MPa", "largest pressure"),
    "work": Number("W", "J/m", "work of friction per rolled distance"),
    "t_gamma": Number("Tγ", "N", "forces times creepages"),
    "t_gamma_with_spin": Number("Tγ + Mω", "N", "forces times creepages, with spin"),
    "utilised_friction": Number("μ_used", "1", "tangential over normal force"),
    "depth_energy": Number("depth, energy", "nm", "largest depth worn per passage, by energy"),
    "depth_twin disc": Number("depth, BRR", "nm", "largest depth worn per passage, by T-gamma over area"),
    "depth_Archard": Number("depth, Archard", "nm", "largest depth worn per passage, by Archard"),
    "pressure_ratio": Number("p_max/k", "1", "largest pressure over the yield stress in shear"),
    "shakedown_limit": Number("limit", "1", "limit of p_max/k in the shakedown map"),
    "load_factor": Number("limit/(p_max/k)", "1", "below 1 the surface ratchets"),
    "surface_index": Number("FI_surf", "1", "index of surface fatigue; above 0 cracks start"),
}
NANO = 1e6  # nm per mm


def to_dataset(results: StressResults) -> xr.Dataset:
    """Return numbers by body and source, fields by body, and wear and fatigue numbers by ICs.

    `stress_BODY` [MPa] lie on the lattice `x_BODY`, `s_BODY` (arc length of the lower contour), `depth_BODY`.
    NUMBER is the largest value on the lattice, `x_NUMBER`, `s_NUMBER`, `depth_NUMBER` its place,
    `estimate_NUMBER` the estimated error of a stress there, in the true body alone; `difference_NUMBER` the
    share by which a source is off the true body. `section_difference` is the largest difference of von Mises
    stresses anywhere on the section at `x_section`, over the largest in the true body.
    """
    names = list(results.bodies)
    numbers = xr.concat([_numbers(one, results.contacts) for one in results.bodies.values()], "body")
    parts = [numbers.assign_coords(body=names)]
    parts += [_fields(name, one) for name, one in results.bodies.items()]
    parts += [_damage(results)] if results.damage else []
    return xr.merge(parts, compat="no_conflicts").assign_attrs(_attributes(results))


def at_place(points: InnerPoints, values: Array, estimate: Array) -> dict[str, float]:
    """Return the largest of values (...) at points, its place, and the estimate there."""
    found, where = largest(values, points), int(np.argmax(values))
    estimated = float(estimate.ravel()[where])
    return {"": found.value, "estimate_": estimated, "x_": found.x, "s_": found.s, "depth_": found.depth}


def section_of(vm: Array) -> int:
    """Return the number along x of the section through the largest of values (n_x, n_s, n_d)."""
    return int(np.unravel_index(int(np.argmax(vm)), vm.shape)[0])


def _numbers(body: BodyStresses, contacts: Contacts) -> xr.Dataset:
    """Return the numbers of a body by source."""
    lattice = body.lattice
    points = InnerPoints(lattice.x[:, None, None], lattice.s[:, None], lattice.depth)
    unknown, rows = np.full(points.shape, np.nan), list[dict[str, float]]()
    true = von_mises(body.stresses[TRUE])
    section = section_of(true)
    for source, stress in body.stresses.items():
        estimate = body.estimate if source == TRUE else unknown
        row = dict[str, float]()
        for name, measure in MEASURES.items():
            found = at_place(points, measure(stress), estimate)
            row |= {prefix + name: value for prefix, value in found.items()}
        if body.fatigue:
            row |= _fatigue(body, source)
        away = np.abs(von_mises(stress[section]) - true[section])
        row["section_difference"] = float(np.max(away) / np.max(true))
        rows.append(row)
    numbers = xr.Dataset({name: ("source", [row[name] for row in rows]) for name in rows[0]})
    numbers = numbers.assign_coords(source=list(body.stresses))
    numbers["x_section"] = float(lattice.x[section])
    return _labelled(numbers, contacts)


def _fatigue(body: BodyStresses, source: str) -> dict[str, float]:
    """Return the largest equivalent stress of Dang Van [MPa] of a source and its place."""
    value, lattice = body.fatigue[source].value, body.lattice
    at_s, at_depth = np.unravel_index(int(np.argmax(value)), value.shape)
    return {
        "dang_van": float(value[at_s, at_depth]),
        "s_dang_van": float(lattice.s[at_s]),
        "depth_dang_van": float(lattice.depth[at_depth]),
    }


def _labelled(numbers: xr.Dataset, contacts: Contacts) -> xr.Dataset:
    """Return numbers with units, differences to the true body, and largest values over p_max."""
    for name, quantity in OF_STRESS.items():
        if name not in numbers:
            continue
        numbers[f"difference_{name}"] = numbers[name] / numbers[name].sel(source=TRUE) - 1
        numbers[f"difference_{name}"].attrs["units"] = "1"
        numbers[f"{name}_over_p_max"] = numbers[name] / contacts.p_max(contacts.reference)
        numbers[f"{name}_over_p_max"].attrs["units"] = "1"
        numbers[name].attrs |= {"units": quantity.unit, "long_name": quantity.meaning}
        for prefix in PLACES:
            if f"{prefix}_{name}" in numbers:
                numbers[f"{prefix}_{name}"].attrs["units"] = "mm"
        if f"estimate_{name}" in numbers:
            numbers[f"estimate_{name}"].attrs["units"] = "MPa"
    numbers["section_difference"].attrs["units"] = "1"
    numbers["x_section"].attrs["units"] = "mm"
    return numbers


def _fields(name: str, body: BodyStresses) -> xr.Dataset:
    """Return the stresses of a body on its lattice by source, estimates, and Dang Van's stresses."""
    dims = tuple(f"{place}_{name}" for place in PLACES)
    fields = xr.Dataset(
        {
            f"stress_{name}": (
                ("source", *dims, "i", "j"),
                np.stack(list(body.stresses.values())).astype("f4"),
            ),
            f"estimate_{name}": (dims, body.estimate.astype("f4")),
        },
        coords={
            "source": list(body.stresses),
            "i": list(DIRECTIONS),
            "j": list(DIRECTIONS),
            **{dim: (dim, at, {"units": "mm"}) for dim, at in zip(dims, _axes(body), strict=True)},
        },
    )
    if body.fatigue:
        values = np.stack([one.value for one in body.fatigue.values()])
        fields[f"dang_van_{name}"] = ("source", *dims[1:]), values
    for variable in fields.data_vars.values():
        variable.attrs["units"] = "MPa"
    return fields


def _axes(body: BodyStresses) -> tuple[Array, Array, Array]:
    return body.lattice.x, body.lattice.s, body.lattice.depth


def variable_of(name: str) -> str:
    """Return the name of the variable of a number of damage."""
    return "largest_" + name.replace(" ", "_") if name.startswith("depth_") else name


def _damage(results: StressResults) -> xr.Dataset:
    """Return the wear and fatigue numbers of a rolling contact by ICs, the work, and depths along s."""
    ics, damage = list(results.damage), list(results.damage.values())
    grid, x = results.contacts.grid, results.contacts.on_grid.x
    arrays = xr.Dataset(
        {
            "work_density": (
                ("ics", "x", "s"),
                np.stack([one.power_density for one in damage]),
                {"units": "MPa"},
            ),
            "depth": (
                ("ics", "law", "s"),
                NANO * np.stack([list(one.depths.values()) for one in damage]),
                {"units": "nm", "long_name": "depth worn per passage (rail) or revolution (wheel)"},
            ),
            "regime_share": (
                ("ics", "regime"),
                [list(one.regimes.values()) for one in damage],
                {"units": "1"},
            ),
        },
        coords={
            "ics": ics,
            "law": list(damage[0].depths),
            "regime": list(damage[0].regimes),
            "x": ("x", x, {"units": "mm"}),
            "s": ("s", grid.strips, {"units": "mm"}),
        },
    )
    for name in damage[0].numbers:
        quantity, factor = OF_DAMAGE[name], NANO if name.startswith("depth_") else 1.0
        units = {"units": quantity.unit, "long_name": quantity.meaning}
        variable = variable_of(name)
        arrays[variable] = "ics", [factor * one.numbers[name] for one in damage], units
        errors = [factor * one.errors.get(name, np.nan) for one in damage]
        arrays[f"estimate_{variable}"] = "ics", errors, {"units": quantity.unit}
    return arrays


def _attributes(results: StressResults) -> dict[str, str | float]:
    contacts, damage = results.contacts, results.scene.damage
    constants = {name: getattr(damage, name) for name in CONSTANTS}
    return {
        "title": f"Stresses: {results.scene.title}",
        "meaning": "stresses along x, s, n of the surface above each point; tension is positive",
        "motion": contacts.problem.specification.motion,
        "load": contacts.load,
        "friction": contacts.friction,
        "reference": contacts.reference,
        "p_max_of_reference": contacts.p_max(contacts.reference),
        "p_max_of_A": contacts.p_max("A") if "A" in contacts.tractions else np.nan,
        **{name: value for name, value in constants.items() if value is not None},
        "dang_van_hydrostatic": damage.dang_van.hydrostatic,
        "dang_van_compression": damage.dang_van.compression,
        **provenance(results.scene, results.seconds, __name__),
    }
