"""Contact of a scene by finite elements, which use no ICs, beside contact with ICs: `fe_contact.nc`.

Each finished load is stored. The bodies have the same supports as in contact with C, so nothing is fitted.
Only approaches differ: with C they exclude the rigid part M_zz of the compliance (`ApproachRule`). So M_zz
times the load, with M_zz from the models of C on the same supports, is subtracted from approaches by finite
elements: a motion of a whole body along z adds its length to the approach and changes nothing else.
"""

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np
import xarray as xr

from femic.cache.digests import results_digest
from femic.cache.store import Store
from femic.contact.datasets import S
from femic.contact.finite_elements import CELLS, require_enough
from femic.contact.finite_elements.meshed_contact import rigid_compliance, supported_bodies
from femic.contact.finite_elements.result import FEContact, fe_contact
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import padded, require_solvable
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import BadScene, require_none
from femic.scenes.scene import Scene
from geometries.errors import Failure

# --- the solution ---------------------------------------------------------------------------------------


MODELS = ("lower", "upper")
CHECKS = ("load", "load_of_pressures", "tension", "penetration", "memory")


def compute_fe_contact(
    scene: Scene, contacts: xr.Dataset, options: RunOptions = DEFAULT, cells: float = CELLS
) -> xr.Dataset:
    """Return numbers of `contacts` with ICs, and by finite elements, `ics` = "FE", at all loads of a scene.

    `cells` of the finest mesh lie along the shorter half-length of the patch. Loads at which finite elements
    fail have no numbers; `left_out` says why. Raises BadScene for scenes with friction and without loads, and
    WrongInput for too few cells, before any work; Failure where finite elements fail at all loads.
    """
    require_suitable(scene)
    require_enough(cells)
    solved: list[xr.Dataset | None] = []
    failed: list[str] = []
    for load in scene.contact.loads:
        try:
            solved.append(_solve_or_load(scene, load, options, cells))
        except Failure as failure:
            failed.append(f"{load:g} N: {failure}")
            options.watch.on_stage(f"  skipped: {failed[-1]}")
            solved.append(None)
    if len(failed) == len(solved):
        raise Failure("; ".join(failed))
    key = _rigid_key(scene, options.store)
    rigid = options.store.get(key)
    if rigid is None:
        compliance = rigid_compliance(scene.contact_problem, options)
        rigid = xr.Dataset({"compliance": ((), compliance, {"units": "mm/N"})})
        options.store.put(key, rigid)
    dataset = join_finite_elements(contacts, solved, cells, float(rigid.compliance))
    return dataset.assign_attrs(left_out="; ".join(failed))


def stored_fe_contact(scene: Scene, contacts: xr.Dataset, store: Store) -> xr.Dataset | None:
    """Return stored results of `compute_fe_contact`; None where no load is stored."""
    if unsuitable(scene):
        return None
    solved = {load: store.get(_key(scene, load, CELLS, store)) for load in scene.contact.loads}
    missing = [f"{load:g} N (not stored)" for load, contact in solved.items() if contact is None]
    rigid = store.get(_rigid_key(scene, store))
    if rigid is None or len(missing) == len(solved):
        return None
    dataset = join_finite_elements(contacts, list(solved.values()), CELLS, float(rigid.compliance))
    return dataset.assign_attrs(left_out="; ".join(missing))


def require_suitable(scene: Scene) -> None:
    """Raise BadScene for scenes that contact by finite elements does not support, before any work."""
    require_solvable(scene)
    require_none(scene.name, matrix_engine_misfits(scene))
    for given, remedy in unsuitable(scene):
        raise BadScene(f"{scene.name}: {given}: not supported in contact by finite elements; {remedy}")


def unsuitable(scene: Scene) -> list[tuple[str, str]]:
    """Return keys of a scene that contact by finite elements does not support, each with its remedy."""
    contact, outlines = scene.contact, [body.outline is not None for body in scene.bodies.values()]
    found = {
        f"contact.motion = {contact.motion!r}": (
            contact.friction is not None,
            "leave it out: it is frictionless",
        ),
        "contact.loads = []": (not contact.loads, "give loads [N] instead of approaches"),
        "contact.gap = 'exact'": (contact.exact, "use the linear one"),
        "contact.extra_gap": (contact.extra_gap is not None, "leave it out"),
        "contact.lateral_force": (
            contact.lateral_force is not None,
            "give the `shift` that `contact` finds",
        ),
        "discount = 'source'": (
            scene.discount == "source",
            "contact by C would then leave out the bending of the bodies; use 'approach'",
        ),
        "outline of a body": (any(outlines), "leave it out; the solid mesh cannot follow narrow webs"),
    }
    return [(given, remedy) for given, (is_unsuitable, remedy) in found.items() if is_unsuitable]


def _solve_or_load(scene: Scene, load: float, options: RunOptions, cells: float) -> xr.Dataset:
    """Return the contact under a load [N] by finite elements, from the store if it is there."""
    key = _key(scene, load, cells, options.store)
    stored = options.store.get(key)
    if stored is None:
        options.watch.on_stage(f"  {load:g} N by finite elements")
        stored = _label(fe_contact(supported_bodies(scene.contact_problem), load, cells=cells))
        options.store.put(key, stored)
    seconds, unknowns = float(stored.seconds.sum()), int(stored.unknowns.max())
    options.watch.on_stage(f"  {load:g} N by finite elements: {unknowns:,} unknowns, {seconds:.0f} s")
    return stored


def _key(scene: Scene, load: float, cells: float, store: Store) -> str:
    """Return the key of a contact by finite elements in a store."""
    bodies = supported_bodies(scene.contact_problem)
    given = bodies.lower, bodies.upper, bodies.s_range, bodies.shift, load, cells
    return store.key("fe_contact", results_digest(), *given)


def _rigid_key(scene: Scene, store: Store) -> str:
    """Return the key of the rigid part of the compliance in a store."""
    bodies, settings = supported_bodies(scene.contact_problem), scene.settings
    given = bodies.lower, bodies.upper, scene.discount, settings.approach_side, settings.tolerance
    return store.key("fe_contact", "rigid", results_digest(), *given)


def _label(contact: FEContact) -> xr.Dataset:
    """Return a contact as labelled arrays; angles in degrees."""
    values = {
        prefix + name: float(np.degrees(value)) if name == "angle" else value
        for prefix, numbers in (("", contact.numbers), ("estimate_", contact.estimate))
        for name, value in asdict(numbers).items()
    }
    return xr.Dataset(
        {
            **values,
            **{name: getattr(contact, name) for name in CHECKS},
            **{name: ("point", np.asarray(getattr(contact, name))) for name in ("x", "s", "p")},
            "reaction": ("body", list(contact.reactions)),
            "unknowns": ("body", list(contact.unknowns)),
            "seconds": ("stage", list(contact.seconds.values())),
        },
        coords={"body": list(MODELS), "stage": list(contact.seconds)},
    )


# --- the dataset ----------------------------------------------------------------------------------------


FE = "FE"  # the name of contact by finite elements among the ICs
OF_PATCH = ("angle", "a", "b", "p_max")
APPROACH = "approach"
OF_PLACE = ("F_y", "M_x", "s_centre")  # numbers that vanish where all is symmetric
NUMBERS = (*OF_PATCH, APPROACH, *OF_PLACE)
CHECK_NAMES = ("load_of_pressures", "reaction", "tension", "penetration", "unknowns", "memory")


def join_finite_elements(
    contacts: xr.Dataset, fe_contacts: Sequence[xr.Dataset | None], cells: float, rigid_compliance: float
) -> xr.Dataset:
    """Return numbers with estimates of all ICs and of finite elements, and checks of the latter.

    Cases without a solution by finite elements, None, are NaN there. `approach` by finite elements excludes
    the `rigid_compliance` M_zz [mm/N], which C does not have, times the load; `fe_raw_approach` includes it.
    """
    named = [prefix + name for name in NUMBERS for prefix in ("", "estimate_")]
    some = next(contact for contact in fe_contacts if contact is not None)
    unsolved = xr.full_like(some.astype(float), np.nan)
    cases = [unsolved if contact is None else contact for contact in fe_contacts]
    solved = xr.concat([case.drop_dims("point").astype(float) for case in cases], "case")
    solved = solved.assign_coords(case=contacts.case)
    fe = solved[named].expand_dims(ics=[FE])
    dataset = xr.concat([contacts[named], fe], "ics", combine_attrs="override")
    load = contacts["load"].isel(ics=0, drop=True)
    rigid = rigid_compliance * load
    dataset[APPROACH] = dataset[APPROACH].where(dataset.ics != FE, dataset[APPROACH] - rigid)
    dataset[f"fe_raw_{APPROACH}"] = solved[APPROACH].assign_attrs(units="mm")
    for name in CHECK_NAMES:
        dataset[f"fe_{name}"] = solved[name]
    dataset["seconds"] = contacts.seconds
    dataset["fe_seconds"] = solved.seconds
    dataset["load"] = load.assign_attrs(units="N")
    dataset["rigid_compliance"] = (), rigid_compliance, {"units": "mm/N"}
    profiles = []
    for contact in fe_contacts:  # arc lengths [mm] and pressures [MPa] at x = 0
        profile = np.zeros((2, 0))
        if contact is not None:
            at_middle = contact.isel(point=contact.x.values < 1e-9 * float(contact.x.max())).sortby("s")
            profile = np.stack([at_middle.s.values, at_middle.p.values])
        profiles.append(profile)
    s, p = (padded([profile[k] for profile in profiles]) for k in range(2))
    by_fe = {"units": "MPa", "long_name": "pressure by finite elements at x = 0"}
    dataset = dataset.assign_coords(s_fe=(("case", "s_fe"), s, S))
    dataset["p_fe"] = ("case", "s_fe"), p, by_fe
    middle = contacts.x.notnull().sum("x") // 2
    beside = contacts.p.isel(x=middle).drop_vars("x").assign_attrs(long_name="pressure with ICs beside x = 0")
    dataset["p"] = beside.reindex(ics=dataset.ics)
    return dataset.assign_attrs(contacts.attrs | {"cells": cells})
