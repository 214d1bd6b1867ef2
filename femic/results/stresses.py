"""Stresses below a contact in both bodies, and what half-spaces make of the same tractions: `stresses.nc`.

The dataset has numbers and fields, and the wear and fatigue of a rolling contact.
"""

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter

import numpy as np
import xarray as xr

from femic.cache.digests import results_digest
from femic.contact.datasets import PREFIXES
from femic.damage.dang_van import DangVan, equivalent_stress
from femic.damage.specification import CONSTANTS
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import provenance
from femic.results.damage import Number, compute_damage, compute_wear
from femic.results.stressed_contact import Contacts, Lattice, lattice_below, require_stresses, solve_contacts
from femic.scenes.scene import Scene, StressSpecification
from femic.stresses.engine import StressSettings, stress_field
from femic.stresses.field import principal_values, rise_between, tresca, von_mises
from femic.stresses.half_space import half_space_field
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.patches import DIRECTIONS

ACTUAL, HALF_SPACE, HALF_SPACE_OF_A = "actual body", "half-space", "half-space, A"
BODIES = "upper", "lower"
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
FINER, BESIDE = 4, 0.25  # outlines: points per interval of the lattice; length beside it, over its own

# --- the dataset ----------------------------------------------------------------------------------------


def compute_stresses(scene: Scene, options: RunOptions = DEFAULT) -> xr.Dataset:
    """Solve one contact of a scene with each of its ICs; return the stresses below it, and its damage.

    NUMBER of `OF_STRESS` (body, source) [MPa] is the largest value on a lattice below the contact,
    `x_NUMBER`, `s_NUMBER`, `depth_NUMBER` its place, `deepest_NUMBER` whether that is the deepest point;
    `estimate_NUMBER` is the estimated error of the largest value, in the actual body alone: that of the
    stress, and what may lie between the points; `difference_NUMBER` the share by which a source differs from
    the actual body. Sources are the actual body and a half-space, both under the tractions of the reference,
    and a half-space under those of A. `section_difference` is the largest difference of von Mises stresses
    anywhere on the section at `x_section`, over the largest in the actual body.

    `stress_BODY` [MPa] lie on the lattice `x_BODY`, `s_BODY` (arc length of the lower contour), `depth_BODY`,
    `column_stress_BODY` at depths `column_BODY` below the middle of the patch, `middle` [mm]. `outline_BODY`
    and `inward_BODY` (axis, outline_s_BODY) are the contour in y and z [mm] and its normal into the body; a
    point of the lattice lies `depth_BODY` along the normal. `dang_van_BODY` is Dang
    Van's equivalent stress over a passage, not of contacts that do not travel. Of rolling contacts, wear and
    fatigue numbers over `ics` are those of `femic.results.damage`.

    Raises BadScene for what cannot be solved, NotConverged and Failure as `femic contact` and the stress
    engine.
    """
    start = perf_counter()
    require_stresses(scene)
    contacts, damage = solve_contacts(scene, options), scene.damage
    worn = []
    for name, solution in contacts.rolling.items() if damage.wears else ():
        options.watch.on_stage(f"  wear with {name}")
        worn.append(compute_wear(solution, damage))
    bodies, fields = [], []
    for body in BODIES:
        options.watch.on_stage(f"  stresses in the {body} body")
        numbers, own = _compute_body(contacts, body, scene, options)
        bodies.append(numbers)
        fields.append(own)
    parts = [xr.concat(bodies, "body").assign_coords(body=list(BODIES)), *fields]
    passages = [compute_damage(solution, damage) for solution in contacts.rolling.values()]
    for by_ics in filter(None, (passages, worn)):
        parts.append(xr.concat(by_ics, "ics").assign_coords(ics=list(contacts.rolling)))
    dataset = xr.merge(parts, compat="no_conflicts")
    constants = {name: getattr(damage, name) for name in CONSTANTS}
    return dataset.assign_attrs(
        title=f"Stresses in both bodies: {scene.title}",
        meaning="stresses along x, s, n of the surface above each point; tension is positive",
        motion=contacts.problem.specification.motion,
        load=contacts.load,
        friction=contacts.friction,
        fineness=scene.stresses.fineness,
        reference=contacts.reference,
        p_max_of_reference=contacts.p_max(contacts.reference),
        p_max_of_A=contacts.p_max("A") if "A" in contacts.tractions else np.nan,
        **{name: value for name, value in constants.items() if value is not None},
        passages=damage.passages,
        revolutions=damage.revolutions,
        dang_van_hydrostatic=damage.dang_van.hydrostatic,
        dang_van_compression=damage.dang_van.compression,
        **provenance(scene, perf_counter() - start),
    )


# --- one body -------------------------------------------------------------------------------------------


def _compute_body(
    contacts: Contacts, name: str, scene: Scene, options: RunOptions
) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the numbers of a body by source, and its fields."""
    lattice = lattice_below(contacts, name)
    field = _solve_or_load(contacts, name, lattice, scene.stresses, options)
    sources = [str(source) for source in field.source.values]
    stresses = {source: lattice.split(np.asarray(field.stress.sel(source=source))) for source in sources}
    estimates = lattice.split(np.asarray(field.estimate))
    fatigue = {}
    if contacts.problem.specification.motion != "compression":
        for source, parts in stresses.items():
            fatigue[source] = [_passage(part, scene.damage.dang_van) for part in parts]

    true = von_mises(stresses[ACTUAL][0])
    section, rows = int(np.unravel_index(np.argmax(true), true.shape)[0]), []
    for source, parts in stresses.items():
        row = dict[str, float]()
        for number, measure in MEASURES.items():
            known = estimates if source == ACTUAL else None
            row |= largest_below(lattice, number, [measure(part) for part in parts], known)
        if fatigue:
            row |= largest_below(lattice, "dang_van", fatigue[source])
        away = np.abs(von_mises(parts[0][section]) - true[section])
        row["section_difference"] = float(np.max(away) / np.max(true))
        rows.append(row)
    numbers = xr.Dataset({key: ("source", [row[key] for row in rows]) for key in rows[0]})
    numbers = numbers.assign_coords(source=sources)
    numbers["x_section"] = (), float(lattice.x[section]), {"units": "mm"}
    numbers["middle"] = (), float(lattice.s[lattice.middle]), {"units": "mm"}
    _label_numbers(numbers, contacts.p_max(contacts.reference))

    mpa, variables = {"units": "MPa"}, {}
    for k, (prefix, dims) in enumerate((("", PLACES), ("column_", ("x", "column")))):
        over = [f"{dim}_{name}" for dim in dims]
        on_part = np.stack([parts[k] for parts in stresses.values()]).astype("f4")
        variables[f"{prefix}stress_{name}"] = ("source", *over, "i", "j"), on_part, mpa
        estimated = mpa | {"long_name": "estimated error of stresses"}
        variables[f"{prefix}estimate_{name}"] = tuple(over), estimates[k].astype("f4"), estimated
        if fatigue:
            values = np.stack([parts[k] for parts in fatigue.values()])
            variables[f"{prefix}dang_van_{name}"] = ("source", *over[1:]), values, mpa
    outline_s = _outline_s(lattice, solid := contacts.problem.bodies[name])
    own_s = outline_s + lattice.offset
    for variable, values in (
        ("outline", solid.contour.position(own_s)),
        ("inward", solid.side * solid.contour.normal(own_s)),
    ):
        units = {"units": "mm" if variable == "outline" else "1"}
        variables[f"{variable}_{name}"] = ("axis", f"outline_s_{name}"), values, units
    axes = {"x": lattice.x, "s": lattice.s, "depth": lattice.depth, "column": lattice.column}
    axes["outline_s"] = outline_s
    coords = {f"{dim}_{name}": (f"{dim}_{name}", at, {"units": "mm"}) for dim, at in axes.items()}
    labels = {"source": sources, "i": list(DIRECTIONS), "j": list(DIRECTIONS), "axis": ["y", "z"]}
    fields = xr.Dataset(variables, coords | labels)
    return numbers, fields


def _outline_s(lattice: Lattice, body: Body) -> Array:
    """Return arc lengths of the lower contour for drawing: the lattice's, between them, and beside."""
    s, own = lattice.s, np.array(body.s_range) - lattice.offset
    between = np.interp(np.arange(FINER * (len(s) - 1) + 1) / FINER, np.arange(len(s)), s)
    reach = BESIDE * (s[-1] - s[0])
    left, right = max(own[0], s[0] - reach), min(own[1], s[-1] + reach)
    count = len(s)
    return np.unique([*np.linspace(left, s[0], count), *between, *np.linspace(s[-1], right, count)])


def _solve_or_load(
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
    if (field := options.store.get(key)) is not None:
        return field
    settings = StressSettings(wanted.fineness, wanted.estimated, options.workers)
    true = stress_field(body, loads[reference], lattice.points, settings)
    assert true.half_space is not None
    stresses = {ACTUAL: true.stress, HALF_SPACE: true.half_space}
    if "A" in loads:
        stresses[HALF_SPACE_OF_A] = half_space_field(body, loads["A"], lattice.points).stress
    field = xr.Dataset(
        {
            "stress": (("source", "point", "i", "j"), np.stack(list(stresses.values()))),
            "estimate": ("point", true.estimate),
        },
        coords={"source": list(stresses)},
    )
    options.store.put(key, field)
    return field


def _passage(stress: Array, criterion: DangVan) -> Array:
    """Dang Van's equivalent stress (...) as the contact passes: from no stress through all x, (n_x, ...)."""
    cycle = np.concatenate([np.zeros((1, *stress.shape[1:])), stress])
    return equivalent_stress((cycle + np.swapaxes(cycle, -1, -2)) / 2, criterion)


def largest_below(
    lattice: Lattice, name: str, parts: Sequence[Array], estimates: Sequence[Array] | None = None
) -> dict[str, float]:
    """Return the largest of values on the lattice, and on its column, and its place, by names of variables.

    `parts` have the shapes of `Lattice.split`, perhaps without x. With x there is an estimated error of the
    largest value, NaN without `estimates` of the values.
    """
    is_on_column = bool(np.max(parts[1]) > np.max(parts[0]))
    values, depths = parts[is_on_column], lattice.column if is_on_column else lattice.depth
    at = tuple(map(int, np.unravel_index(int(np.argmax(values)), values.shape)))
    numbers = {
        name: float(values[at]),
        f"s_{name}": float(lattice.s[lattice.middle if is_on_column else at[-2]]),
        f"depth_{name}": float(depths[at[-1]]),
        f"deepest_{name}": bool(depths[at[-1]] >= depths[-1]),
    }
    axes = [lattice.x, depths] if is_on_column else [lattice.x, lattice.s, depths]
    if values.ndim == len(axes):
        known = np.nan if estimates is None else float(estimates[is_on_column][at])
        between = 0.0 if estimates is None else rise_between(values, axes)
        numbers |= {f"x_{name}": float(lattice.x[at[0]]), f"estimate_{name}": known + between}
    return numbers


def _label_numbers(numbers: xr.Dataset, p_max: float) -> None:
    """Add units, differences to the actual body, and largest values over p_max to numbers."""
    for name, quantity in OF_STRESS.items():
        if name not in numbers:
            continue
        numbers[f"difference_{name}"] = numbers[name] / numbers[name].sel(source=ACTUAL) - 1
        numbers[f"{name}_over_p_max"] = numbers[name] / p_max
        for share in (f"difference_{name}", f"{name}_over_p_max"):
            numbers[share].attrs["units"] = "1"
        numbers[name].attrs |= {"units": quantity.unit, "long_name": quantity.meaning}
        for place in PLACES:
            if f"{place}_{name}" in numbers:
                numbers[f"{place}_{name}"].attrs["units"] = "mm"
        if f"estimate_{name}" in numbers:
            meaning = quantity.meaning + PREFIXES["estimate_"]
            numbers[f"estimate_{name}"].attrs |= {"units": "MPa", "long_name": meaning}
    numbers["section_difference"].attrs["units"] = "1"
