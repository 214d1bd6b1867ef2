"""Stresses below a contact in both bodies, and what half-spaces make of the same tractions.

The dataset `stresses.nc` has numbers and fields, and the wear and fatigue of a rolling contact.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from femic.cache.digests import results_digest
from femic.contact.datasets import PREFIXES
from femic.contact.pairs.ics import NONE_GIVEN, GivenICs
from femic.damage.dang_van import DangVan, EquivalentStress, equivalent_stress
from femic.damage.specification import CONSTANTS
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import provenance
from femic.results.damage import Damage, Wear, compute_damage, compute_wear
from femic.results.stressed_contact import Contacts, Lattice, lattice_below, require_stresses, solve_contacts
from femic.scenes.scene import Scene, StressSpecification
from femic.stresses.engine import StressSettings, stress_field
from femic.stresses.field import principal_values, rise_between, tresca, von_mises
from femic.stresses.half_space import half_space_field
from geometries.arrays import Array
from geometries.patches import DIRECTIONS

# --- the computation ------------------------------------------------------------------------------------


TRUE, HALF_SPACE, HALF_SPACE_OF_A = "true body", "half-space", "half-space, A"
BODIES = "upper", "lower"


@dataclass(frozen=True, eq=False)
class Stresses:
    """Stresses [MPa] along x, s, n by source, shape (n_x, ..., 3, 3) each.

    Sources are the true body and a half-space, both under the tractions of the reference, and a half-space
    under those of A. `estimate` [MPa], (n_x, ...), is the estimated error in the true body. `fatigue` are
    Dang Van's equivalent stresses over a passage by source, (...) each; empty of contacts that do not travel.
    """

    stresses: Mapping[str, Array]
    estimate: Array
    fatigue: Mapping[str, EquivalentStress]


@dataclass(frozen=True, eq=False)
class BodyStresses:
    """Stresses in a body on its lattice, (n_x, n_s, n_d), and on its column, (n_x, n_d + n_c)."""

    lattice: Lattice
    on_lattice: Stresses
    on_column: Stresses
    seconds: float


@dataclass(frozen=True, eq=False)
class StressResults:
    """A contact of a scene, the stresses of its tractions by body, and wear and fatigue numbers by ICs.

    `worn` are the worn contacts, by ICs; none where the scene asks for no passages.
    """

    scene: Scene
    contacts: Contacts
    bodies: Mapping[str, BodyStresses]
    damage: Mapping[str, Damage]
    worn: Mapping[str, Wear]
    seconds: float


def compute_stresses(
    scene: Scene,
    options: RunOptions = DEFAULT,
    given: Mapping[str, GivenICs] = NONE_GIVEN,
) -> StressResults:
    """Solve one contact of a scene with each of its ICs, and compute the stresses below it.

    `given` are ICs of the caller by name. Raises BadScene for what cannot be
    solved, NotConverged and Failure as `femic contact` and the stress engine.
    """
    start = perf_counter()
    require_stresses(scene)
    contacts = solve_contacts(scene, options, given)
    worn = {}
    for name, one in contacts.rolling.items() if scene.damage.wears else ():
        options.watch.on_stage(f"  wear with {name}")
        worn[name] = compute_wear(one.own, scene.damage)
    bodies = {}
    for body in BODIES:
        options.watch.on_stage(f"  stresses in the {body} body")
        bodies[body] = _body_stresses(contacts, body, scene, options)
    damage = {name: compute_damage(one, scene.damage) for name, one in contacts.rolling.items()}
    return StressResults(scene, contacts, bodies, damage, worn, perf_counter() - start)


def _body_stresses(contacts: Contacts, name: str, scene: Scene, options: RunOptions) -> BodyStresses:
    lattice, start = lattice_below(contacts, name), perf_counter()
    part = _stored_field(contacts, name, lattice, scene.stresses, options)
    stresses = {
        source: lattice.split(np.asarray(part.stress.sel(source=source))) for source in part.source.values
    }
    estimates = lattice.split(np.asarray(part.estimate))
    criterion = scene.damage.dang_van if contacts.problem.specification.motion != "compression" else None
    on_lattice, on_column = (
        _with_fatigue({source: both[k] for source, both in stresses.items()}, estimates[k], criterion)
        for k in range(2)
    )
    return BodyStresses(lattice, on_lattice, on_column, perf_counter() - start)


def _with_fatigue(stresses: Mapping[str, Array], estimate: Array, criterion: DangVan | None) -> Stresses:
    """Return stresses, with Dang Van's where the contact travels: where there is a criterion."""
    fatigue = {source: _passage(one, criterion) for source, one in stresses.items()} if criterion else {}
    return Stresses(stresses, estimate, fatigue)


def _stored_field(
    contacts: Contacts, name: str, lattice: Lattice, wanted: StressSpecification, options: RunOptions
) -> xr.Dataset:
    """Return the stresses in a body at all points of its lattice, from the store if they are there."""
    body, reference = contacts.problem.bodies[name], contacts.reference
    loads = {
        ics: contacts.on_body(name, ics)
        for ics in dict.fromkeys((reference, "A"))
        if ics in contacts.tractions
    }
    inputs = body, lattice, [(one.grid, one.p) for one in loads.values()], wanted.fineness, wanted.estimated
    key = options.store.key("stresses", results_digest(), *inputs)
    if (part := options.store.get(key)) is not None:
        return part
    settings = StressSettings(wanted.fineness, wanted.estimated, options.workers)
    true = stress_field(body, loads[reference], lattice.points, settings)
    assert true.half_space is not None
    stresses = {TRUE: true.stress, HALF_SPACE: true.half_space}
    if "A" in loads:
        stresses[HALF_SPACE_OF_A] = half_space_field(body, loads["A"], lattice.points).stress
    part = xr.Dataset(
        {
            "stress": (("source", "point", "i", "j"), np.stack(list(stresses.values()))),
            "estimate": ("point", true.estimate),
        },
        coords={"source": list(stresses)},
    )
    options.store.put(key, part)
    return part


def _passage(stress: Array, criterion: DangVan) -> EquivalentStress:
    """Dang Van's equivalent stress (...) as the contact passes: from no stress through all x, (n_x, ...)."""
    cycle = np.concatenate([np.zeros((1, *stress.shape[1:])), stress])
    symmetric = (cycle + np.swapaxes(cycle, -1, -2)) / 2
    return equivalent_stress(symmetric, criterion)


# --- the dataset ----------------------------------------------------------------------------------------


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
    "shakedown_limit": Number(
        "limit", "1", "limit of p_max/k in the shakedown map, without residual shear along x"
    ),
    "load_factor": Number("limit/(p_max/k)", "1", "below 1 the contact may ratchet"),
    "surface_index": Number("FI_surf", "1", "index of surface fatigue; above 0 cracks start"),
}
NANO, MICRO = 1e6, 1e3  # nm and µm per mm


def to_dataset(results: StressResults) -> xr.Dataset:
    """Return numbers by body and source, fields by body, and wear and fatigue numbers by ICs.

    `stress_BODY` [MPa] lie on the lattice `x_BODY`, `s_BODY` (arc length of the lower contour), `depth_BODY`,
    `column_stress_BODY` at depths `column_BODY` below the middle of the patch, `middle` [mm].
    NUMBER is the largest value at these points, `x_NUMBER`, `s_NUMBER`, `depth_NUMBER` its place,
    `deepest_NUMBER` whether that is the deepest point there; `estimate_NUMBER` is the estimated error of the
    largest value, in the true body alone: that of the stress, and what may lie between the points;
    `difference_NUMBER` the share by which a source is off the true body. `section_difference` is the largest
    difference of von Mises stresses anywhere on the section at `x_section`, over the largest in the true
    body.
    """
    names = list(results.bodies)
    numbers = xr.concat([_numbers(one, results.contacts) for one in results.bodies.values()], "body")
    parts = [numbers.assign_coords(body=names)]
    parts += [_fields(name, one) for name, one in results.bodies.items()]
    parts += [_damage(results)] if results.damage else []
    parts += [_wear(results)] if results.worn else []
    return xr.merge(parts, compat="no_conflicts").assign_attrs(_attributes(results))


@dataclass(frozen=True, eq=False)
class Peak:
    """Values on the lattice or on the column of a body, whichever has the largest one, and where that is."""

    values: Array
    at: tuple[int, ...]
    s: float
    depths: Array

    @classmethod
    def find(cls, lattice: Lattice, on_lattice: Array, on_column: Array) -> "Peak":
        """Return the peak of values (..., n_s, n_d) on the lattice and (..., n_d + n_c) on the column."""
        if np.max(on_column) > np.max(on_lattice):
            at = _place_of_largest(on_column)
            return cls(on_column, at, float(lattice.s[lattice.middle]), lattice.column)
        at = _place_of_largest(on_lattice)
        return cls(on_lattice, at, float(lattice.s[at[-2]]), lattice.depth)

    def numbers(self, name: str) -> dict[str, float]:
        """Return the value and its place by the names of variables."""
        depth = float(self.depths[self.at[-1]])
        place = {f"s_{name}": self.s, f"depth_{name}": depth, f"deepest_{name}": depth >= self.depths[-1]}
        return {name: float(self.values[self.at]), **place}


def _place_of_largest(values: Array) -> tuple[int, ...]:
    return tuple(map(int, np.unravel_index(int(np.argmax(values)), values.shape)))


def largest_below(body: BodyStresses, source: str, name: str) -> dict[str, float]:
    """Return the largest of a measure of stresses below a contact, its place and its estimated error."""
    lattice, measure = body.lattice, MEASURES[name]
    parts = body.on_lattice, body.on_column
    peak = Peak.find(lattice, *(measure(part.stresses[source]) for part in parts))
    numbers = peak.numbers(name) | {f"x_{name}": float(lattice.x[peak.at[0]]), f"estimate_{name}": np.nan}
    if source == TRUE:
        axes = [lattice.x, peak.depths] if peak.values.ndim == 2 else [lattice.x, lattice.s, peak.depths]
        estimate = parts[peak.values.ndim == 2].estimate[peak.at]
        numbers[f"estimate_{name}"] = float(estimate) + rise_between(peak.values, axes)
    return numbers


def section_of(vm: Array) -> int:
    """Return the number along x of the section through the largest of values (n_x, n_s, n_d)."""
    return _place_of_largest(vm)[0]


def _numbers(body: BodyStresses, contacts: Contacts) -> xr.Dataset:
    """Return the numbers of a body by source."""
    lattice, rows = body.lattice, list[dict[str, float]]()
    true = von_mises(body.on_lattice.stresses[TRUE])
    section = section_of(true)
    for source, stress in body.on_lattice.stresses.items():
        row = dict[str, float]()
        for name in MEASURES:
            row |= largest_below(body, source, name)
        if body.on_lattice.fatigue:
            row |= _fatigue(body, source)
        away = np.abs(von_mises(stress[section]) - true[section])
        row["section_difference"] = float(np.max(away) / np.max(true))
        rows.append(row)
    numbers = xr.Dataset({name: ("source", [row[name] for row in rows]) for name in rows[0]})
    numbers = numbers.assign_coords(source=list(body.on_lattice.stresses))
    numbers["x_section"] = float(lattice.x[section])
    numbers["middle"] = (), float(lattice.s[lattice.middle]), {"units": "mm"}
    return _label(numbers, contacts)


def _fatigue(body: BodyStresses, source: str) -> dict[str, float]:
    """Return the largest equivalent stress of Dang Van [MPa] of a source and its place."""
    values = (part.fatigue[source].value for part in (body.on_lattice, body.on_column))
    return Peak.find(body.lattice, *values).numbers("dang_van")


def _label(numbers: xr.Dataset, contacts: Contacts) -> xr.Dataset:
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
            meaning = quantity.meaning + PREFIXES["estimate_"]
            numbers[f"estimate_{name}"].attrs |= {"units": "MPa", "long_name": meaning}
    numbers["section_difference"].attrs["units"] = "1"
    numbers["x_section"].attrs["units"] = "mm"
    return numbers


def _fields(name: str, body: BodyStresses) -> xr.Dataset:
    """Return the stresses of a body on its lattice by source, estimates, and Dang Van's stresses."""
    lattice = body.lattice
    axes = {"x": lattice.x, "s": lattice.s, "depth": lattice.depth, "column": lattice.column}
    variables = {
        f"{prefix}{variable}": values
        for prefix, part, dims in (
            ("", body.on_lattice, PLACES),
            ("column_", body.on_column, ("x", "column")),
        )
        for variable, values in _variables(part, [f"{dim}_{name}" for dim in dims], name).items()
    }
    return xr.Dataset(
        variables,
        coords={
            "source": list(body.on_lattice.stresses),
            "i": list(DIRECTIONS),
            "j": list(DIRECTIONS),
            **{f"{dim}_{name}": (f"{dim}_{name}", at, {"units": "mm"}) for dim, at in axes.items()},
        },
    )


def _variables(part: Stresses, dims: Sequence[str], body: str) -> dict[str, Any]:
    """Return stresses, estimates and Dang Van's stresses over dimensions, the first of them x."""
    units, variables = {"units": "MPa"}, dict[str, Any]()
    stresses = np.stack(list(part.stresses.values())).astype("f4")
    variables[f"stress_{body}"] = ("source", *dims, "i", "j"), stresses, units
    estimated = units | {"long_name": "estimated error of stresses"}
    variables[f"estimate_{body}"] = tuple(dims), part.estimate.astype("f4"), estimated
    if part.fatigue:
        values = np.stack([one.value for one in part.fatigue.values()])
        variables[f"dang_van_{body}"] = ("source", *dims[1:]), values, units
    return variables


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
        tables = {
            "": [one.numbers[name] for one in damage],
            "estimate_": [one.errors.get(name, np.nan) for one in damage],
        }
        for prefix, table in tables.items():
            units = {"units": quantity.unit, "long_name": quantity.meaning + PREFIXES[prefix]}
            arrays[prefix + variable_of(name)] = "ics", [factor * value for value in table], units
    return arrays


def _wear(results: StressResults) -> xr.Dataset:
    """Return what is worn off both bodies after all passages, and the worn contact, by ICs."""
    worn = list(results.worn.values())
    meaning = "depth worn after all passages and revolutions"
    arrays = xr.Dataset(
        {
            "worn": (
                ("ics", "worn_body", "s"),
                MICRO * np.stack([one.depths for one in worn]),
                {"units": "µm", "long_name": meaning},
            ),
            "estimate_worn": (
                ("ics", "worn_body"),
                MICRO * np.stack([one.estimates for one in worn]),
                {"units": "µm", "long_name": meaning + PREFIXES["estimate_"]},
            ),
            "wear_steps": ("ics", [one.steps for one in worn]),
            "turned": ("ics", np.degrees([one.turned for one in worn]), {"units": "deg"}),
        },
        coords={"ics": list(results.worn), "worn_body": ["lower", "upper"]},
    )
    for name, unit in (("p_max", "MPa"), ("work", "J/m")):
        arrays[f"worn_{name}"] = ("ics", "state"), [getattr(one, name) for one in worn], {"units": unit}
    return arrays.assign_coords(state=["new", "worn"])


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
        "passages": damage.passages,
        "revolutions": damage.revolutions,
        "dang_van_hydrostatic": damage.dang_van.hydrostatic,
        "dang_van_compression": damage.dang_van.compression,
        **provenance(results.scene, results.seconds),
    }
