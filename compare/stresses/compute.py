"""Stresses below a contact in both bodies, and what half-spaces make of the same tractions."""

from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter

import numpy as np
import xarray as xr

from compare.stresses.contacts import Contacts, require_stresses, solve_contacts
from compare.stresses.damage import Damage, damage_of
from compare.stresses.lattice import Lattice, lattice_below
from compare.stresses.worn import Worn, worn_of
from femic.cache.digests import results_digest
from femic.contact.pairs.given_ics import NONE_GIVEN, GivenICs
from femic.damage.dang_van import DangVan
from femic.damage.equivalent_stress import EquivalentStress, equivalent_stress
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.scene import Scene, StressSpecification
from femic.stresses.engine import StressSettings, stress_field
from femic.stresses.half_space import half_space_field
from geometries.arrays import Array

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
    worn: Mapping[str, Worn]
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
        worn[name] = worn_of(one.own, scene.damage)
    bodies = {}
    for body in BODIES:
        options.watch.on_stage(f"  stresses in the {body} body")
        bodies[body] = _body_stresses(contacts, body, scene, options)
    damage = {name: damage_of(one, scene.damage) for name, one in contacts.rolling.items()}
    return StressResults(scene, contacts, bodies, damage, worn, perf_counter() - start)


def _body_stresses(contacts: Contacts, name: str, scene: Scene, options: RunOptions) -> BodyStresses:
    lattice, start = lattice_below(contacts, name), perf_counter()
    part = _stored_field(contacts, name, scene.stresses, options)
    stresses = {
        source: lattice.of_points(np.asarray(part.stress.sel(source=source))) for source in part.source.values
    }
    estimates = lattice.of_points(np.asarray(part.estimate))
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
    contacts: Contacts, name: str, wanted: StressSpecification, options: RunOptions
) -> xr.Dataset:
    """Return the stresses in a body at all points of its lattice, from the store if they are there."""
    body, lattice, reference = (
        contacts.problem.bodies[name],
        lattice_below(contacts, name),
        contacts.reference,
    )
    loads = {
        ics: contacts.on_body(name, ics)
        for ics in dict.fromkeys((reference, "A"))
        if ics in contacts.tractions
    }
    inputs = body, lattice, [(one.grid, one.p) for one in loads.values()], wanted.fineness, wanted.estimated
    key = options.store.key("stresses", results_digest(__name__), *inputs)
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
