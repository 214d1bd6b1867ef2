"""Contact of a scene by finite elements, which use no ICs; each finished load is kept in the store.

The bodies have the supports that contact with C gives them, so nothing is fitted between the two. Approaches
alone differ: with C they lack the rigid part M_zz of the compliance (`ApproachRule`), which finite elements
have. M_zz times the load is subtracted from the latter, with M_zz from the models of C on the same supports:
a motion of a whole body along z adds its length to the approach and changes nothing else.
"""

from dataclasses import asdict

import numpy as np
import xarray as xr

from compare.contact.compute import require_solvable
from compare.finite_elements.dataset import beside
from femic.cache.digests import results_digest
from femic.cache.store import Store
from femic.contact.finite_elements.fineness import CELLS, require_enough
from femic.contact.finite_elements.result import FEContact, Numbers, fe_contact
from femic.contact.finite_elements.supports import meshed_bodies, rigid_compliance
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import BadScene, require_none
from femic.scenes.scene import Scene
from geometries.errors import Failure

MODELS = ("lower", "upper")


def compute_fe_contact(
    scene: Scene, contacts: xr.Dataset, options: RunOptions = DEFAULT, cells: float = CELLS
) -> xr.Dataset:
    """Numbers of `contacts` by ICs, and by finite elements, `ics` = "FE", of all loads of a scene.

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
            solved.append(_solved(scene, load, options, cells))
        except Failure as failure:
            failed.append(f"{load:g} N: {failure}")
            options.watch.on_stage(f"  left out: {failed[-1]}")
            solved.append(None)
    if len(failed) == len(solved):
        raise Failure("; ".join(failed))
    rigid = _rigid_compliance(scene, options)
    return beside(contacts, solved, cells, rigid).assign_attrs(left_out="; ".join(failed))


def kept_fe_contact(scene: Scene, contacts: xr.Dataset, store: Store) -> xr.Dataset | None:
    """What `compute_fe_contact` gave for the loads that a store has, None where it has none of them."""
    if unsuitable(scene):
        return None
    solved = [store.get(_key(scene, load, CELLS, store)) for load in scene.contact.loads]
    rigid = store.get(_rigid_key(scene, store))
    if rigid is None or not any(one is not None for one in solved):
        return None
    missing = [
        f"{load:g} N (not kept)" for load, one in zip(scene.contact.loads, solved, strict=True) if one is None
    ]
    return beside(contacts, solved, CELLS, float(rigid.compliance)).assign_attrs(left_out="; ".join(missing))


def require_suitable(scene: Scene) -> None:
    """Raise BadScene for what contact by finite elements cannot do, before any work."""
    require_solvable(scene)
    require_none(scene.name, matrix_engine_misfits(scene))
    for given, remedy in unsuitable(scene):
        raise BadScene(f"{scene.name}: {given}: not in contact by finite elements; {remedy}")


def unsuitable(scene: Scene) -> list[tuple[str, str]]:
    """What contact by finite elements cannot do of a scene, each with its remedy."""
    wanted = scene.contact
    asked = (
        (wanted.friction is None, f"contact.motion = {wanted.motion!r}", "leave it out: it is frictionless"),
        (bool(wanted.loads), "contact.loads = []", "give loads [N] instead of approaches"),
        (not wanted.exact, "contact.gap = 'exact'", "use the linear one"),
        (wanted.extra_gap is None, "contact.extra_gap", "leave it out"),
        (wanted.lateral_force is None, "contact.lateral_force", "give the `shift` that `contact` finds"),
        (
            scene.discount != "source",
            "discount = 'source'",
            "contact by C then lacks the bending of the bodies; take 'approach'",
        ),
    )
    return [(given, remedy) for suitable, given, remedy in asked if not suitable]


def _solved(scene: Scene, load: float, options: RunOptions, cells: float) -> xr.Dataset:
    """The contact under a load [N] by finite elements, from the store if it is there."""
    key = _key(scene, load, cells, options.store)
    kept = options.store.get(key)
    if kept is None:
        options.watch.on_stage(f"  {load:g} N by finite elements")
        kept = _labelled(fe_contact(meshed_bodies(scene.contact_problem), load, cells=cells))
        options.store.put(key, kept)
    seconds, unknowns = float(kept.seconds.sum()), int(kept.unknowns.max())
    options.watch.on_stage(f"  {load:g} N by finite elements: {unknowns:,} unknowns, {seconds:.0f} s")
    return kept


def _key(scene: Scene, load: float, cells: float, store: Store) -> str:
    """The key of a contact by finite elements in a store."""
    of = meshed_bodies(scene.contact_problem)
    given = of.lower, of.upper, of.s_range, of.shift, load, cells
    return store.key("fe_contact", results_digest(__name__), *given)


def _rigid_compliance(scene: Scene, options: RunOptions) -> float:
    """M_zz [mm/N] of both bodies, from the store if it is there."""
    key = _rigid_key(scene, options.store)
    kept = options.store.get(key)
    if kept is None:
        compliance = rigid_compliance(scene.contact_problem, options)
        kept = xr.Dataset({"compliance": ((), compliance, {"units": "mm/N"})})
        options.store.put(key, kept)
    return float(kept.compliance)


def _rigid_key(scene: Scene, store: Store) -> str:
    """The key of the rigid part of the compliance in a store."""
    of, settings = meshed_bodies(scene.contact_problem), scene.settings
    given = of.lower, of.upper, scene.discount, settings.approach_side, settings.tolerance
    return store.key("fe_contact", "rigid", results_digest(__name__), *given)


def _labelled(contact: FEContact) -> xr.Dataset:
    """A contact as labelled arrays; angles in degrees."""
    named = {"": contact.numbers, "estimate_": contact.estimate}
    numbers = {
        prefix + name: value
        for prefix, of_all in named.items()
        for name, value in _in_degrees(of_all).items()
    }
    checks = {
        "load": contact.load,
        "load_of_pressures": contact.load_of_pressures,
        "tension": contact.tension,
        "penetration": contact.penetration,
        "memory": contact.memory,
    }
    points = {name: ("point", np.asarray(getattr(contact, name))) for name in ("x", "s", "p")}
    return xr.Dataset(
        {
            **numbers,
            **checks,
            **points,
            "reaction": ("body", list(contact.reactions)),
            "unknowns": ("body", list(contact.unknowns)),
            "seconds": ("stage", list(contact.seconds.values())),
        },
        coords={"body": list(MODELS), "stage": list(contact.seconds)},
    )


def _in_degrees(numbers: Numbers) -> dict[str, float]:
    return {name: float(np.degrees(v)) if name == "angle" else v for name, v in asdict(numbers).items()}
