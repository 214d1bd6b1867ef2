"""Contact of a scene by finite elements, which use no ICs; each finished load is kept in the store.

The bodies have the supports that contact by C gives them: the far arc of the scene, on which both are
clamped. A body without end along x is meshed as far as its far arc screens what lies beyond. So nothing is
fitted between the two. Approaches alone are counted otherwise: C's is without the rigid part M_zz of the
compliance (`ApproachRule`), that of finite elements has it. M_zz times the load is
taken from the latter, with M_zz as the models of C give it on the same supports: a motion of a whole body
along z adds its length to the approach and changes nothing else. (In C each body's M_zz acts along its own
normals, which differ by a few 1e-4 of the approach.)
"""

from dataclasses import asdict, replace

import numpy as np
import xarray as xr

from compare.contact.compute import FRICTIONLESS, cases_of
from compare.contact.pair_on_grid import undeformed_of
from compare.finite_elements.dataset import beside
from compare.matrix.compute import matrix_jobs
from femic.cache.digests import results_digest
from femic.cache.store import Store
from femic.contact.finite_elements.levels import Bodies
from femic.contact.finite_elements.result import CELLS, FEContact, Numbers, fe_contact, require_enough
from femic.reference.discount import FZ
from femic.reference.matrix.reference import matrices
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import BadScene, require_none
from femic.scenes.scene import Scene
from geometries.bodies import Body, Domain
from geometries.errors import Failure
from geometries.grids import Grid

MODELS = ("lower", "upper")
LENGTH = 3.0  # of the meshed half of a body along x, in radii of its far arc


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
    rigid = rigid_compliance(scene, options)
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
    cases_of(scene)
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
        kept = _labelled(fe_contact(_bodies(scene), load, cells=cells))
        options.store.put(key, kept)
    seconds, unknowns = float(kept.seconds.sum()), int(kept.unknowns.max())
    options.watch.on_stage(f"  {load:g} N by finite elements: {unknowns:,} unknowns, {seconds:.0f} s")
    return kept


def _key(scene: Scene, load: float, cells: float, store: Store) -> str:
    """The key of a contact by finite elements in a store."""
    of = _bodies(scene)
    given = of.lower, of.upper, of.s_range, of.shift, load, cells
    return store.key("fe_contact", results_digest(__name__), *given)


def rigid_compliance(scene: Scene, options: RunOptions = DEFAULT) -> float:
    """M_zz [mm/N] of both bodies on the supports of the scene, which C's approach is without.

    It needs a model of each section with a single strip, the load under which it is matched. 0 where C's
    approach is with it.
    """
    if scene.discount == "none":
        return 0.0
    key = _rigid_key(scene, options.store)
    kept = options.store.get(key)
    if kept is None:
        side = 2 * scene.settings.approach_side
        alone = replace(scene, grid=Grid(1, 1, side, side), compared=("combined",))
        found = matrices(matrix_jobs(alone, FRICTIONLESS), options, combined=True)
        compliance = sum(float(reference.discount[FZ, FZ]) for reference in found.values())
        kept = xr.Dataset({"compliance": ((), compliance, {"units": "mm/N"})})
        options.store.put(key, kept)
    return float(kept.compliance)


def _rigid_key(scene: Scene, store: Store) -> str:
    """The key of the rigid part of the compliance in a store."""
    of, settings = _bodies(scene), scene.settings
    given = of.lower, of.upper, scene.discount, settings.approach_side, settings.tolerance
    return store.key("fe_contact", "rigid", results_digest(__name__), *given)


def _bodies(scene: Scene) -> Bodies:
    """The bodies of a scene, as they are meshed and placed."""
    undeformed = undeformed_of(scene)
    lower, upper = (_meshable(scene, name) for name in MODELS)
    return Bodies(lower, upper, undeformed.s_range, undeformed.shift)


def _meshable(scene: Scene, name: str) -> Body:
    """A body of the scene with the supports that C gives it, and ends that do not matter."""
    domain = Domain(scene.support_radius, LENGTH * scene.support_radius)
    return replace(scene.bodies[name], domain=domain)


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
