"""Contact of a scene by finite elements, which use no ICs; each finished load is kept in the store."""

from dataclasses import asdict, replace

import numpy as np
import xarray as xr

from compare.results.contact.compute import cases_of
from compare.results.contact.pairing import placed_on
from compare.results.judge.dataset import beside
from compare.results.provenance import results_digest
from compare.scenes.errors import BadScene
from compare.scenes.scene import Scene
from contact.judge.judgement import CELLS, Judgement, Numbers, judge, require_enough
from contact.judge.levels import Bodies
from femic.means import DEFAULT, Means
from femic.solid.record import SOLID
from femic.work.store import Store
from geometries.bodies import Body, Domain
from geometries.errors import Failure

MODELS = ("lower", "upper")


def compute_judged(
    scene: Scene, contacts: xr.Dataset, means: Means = DEFAULT, cells: float = CELLS
) -> xr.Dataset:
    """Numbers of `contacts` by ICs, and by finite elements, `ics` = "FE", of all loads of a scene.

    `cells` of the finest mesh lie along the shorter half-length of the patch. Loads at which finite elements
    fail have no numbers; `left_out` says why. Raises BadScene for scenes with friction and without loads, and
    WrongInput for too few cells, before any work; Failure where finite elements fail at all loads.
    """
    require_judgeable(scene)
    require_enough(cells)
    judged: list[xr.Dataset | None] = []
    failed: list[str] = []
    for load in scene.contact.loads:
        try:
            judged.append(_judged(scene, load, means, cells))
        except Failure as failure:
            failed.append(f"{load:g} N: {failure}")
            means.watch.on_stage(f"  left out: {failed[-1]}")
            judged.append(None)
    if len(failed) == len(judged):
        raise Failure("; ".join(failed))
    return beside(contacts, judged, cells).assign_attrs(left_out="; ".join(failed))


def kept_judged(scene: Scene, contacts: xr.Dataset, store: Store) -> xr.Dataset | None:
    """What `compute_judged` gave for the loads that a store has, None where it has none of them."""
    if unjudgeable(scene):
        return None
    judged = [store.get(_key(scene, load, CELLS, store)) for load in scene.contact.loads]
    if not any(one is not None for one in judged):
        return None
    missing = [
        f"{load:g} N (not kept)" for load, one in zip(scene.contact.loads, judged, strict=True) if one is None
    ]
    return beside(contacts, judged, CELLS).assign_attrs(left_out="; ".join(missing))


def require_judgeable(scene: Scene) -> None:
    """Raise BadScene for what is not judged, before any work."""
    cases_of(scene)
    for given, remedy in unjudgeable(scene):
        raise BadScene(f"{scene.name}: {given}: finite elements do not judge that; {remedy}")


def unjudgeable(scene: Scene) -> list[tuple[str, str]]:
    """What finite elements do not judge in a scene, and what to do about it."""
    wanted = scene.contact
    asked = (
        (wanted.friction is None, f"contact.motion = {wanted.motion!r}", "leave it out: it is frictionless"),
        (bool(wanted.loads), "contact.loads = []", "give loads [N] instead of approaches"),
        (not wanted.exact, "contact.gap = 'exact'", "use the linear one"),
        (not wanted.extra_gap, "contact.extra_gap", "leave it out"),
    )
    return [(given, remedy) for judged, given, remedy in asked if not judged]


def _judged(scene: Scene, load: float, means: Means, cells: float) -> xr.Dataset:
    """The contact under a load [N] by finite elements, from the store if it is there."""
    key = _key(scene, load, cells, means.store)
    kept = means.store.get(key)
    if kept is None:
        means.watch.on_stage(f"  {load:g} N by finite elements")
        kept = _labelled(judge(_bodies(scene), load, cells=cells))
        means.store.put(key, kept)
    seconds, unknowns = float(kept.seconds.sum()), int(kept.unknowns.max())
    means.watch.on_stage(f"  {load:g} N by finite elements: {unknowns:,} unknowns, {seconds:.0f} s")
    return kept


def _key(scene: Scene, load: float, cells: float, store: Store) -> str:
    """The key of a contact by finite elements in a store."""
    of = _bodies(scene)
    given = of.lower, of.upper, of.s_range, of.shift, load, cells
    return store.key("judge", results_digest(__name__), *given)


def _bodies(scene: Scene) -> Bodies:
    """The bodies of a scene, as they are meshed and placed."""
    undeformed = placed_on(scene, scene.grid).undeformed
    lower, upper = (_meshable(scene, name) for name in MODELS)
    return Bodies(lower, upper, undeformed.s_range, undeformed.shift)


def _meshable(scene: Scene, name: str) -> Body:
    """A body of the scene with the domain of the solid engine, where its own has no end along x."""
    body, settings = scene.bodies[name], scene.settings
    if not settings.engine.endless:
        return body
    far_radius = SOLID.far_radius(settings.tolerance)
    return replace(body, domain=Domain(far_radius, far_radius))


def _labelled(judgement: Judgement) -> xr.Dataset:
    """A judgement as labelled arrays; angles in degrees."""
    named = {"": judgement.numbers, "estimate_": judgement.estimate}
    numbers = {
        prefix + name: value
        for prefix, of_all in named.items()
        for name, value in _in_degrees(of_all).items()
    }
    checks = {
        "load": judgement.load,
        "load_of_pressures": judgement.load_of_pressures,
        "tension": judgement.tension,
        "penetration": judgement.penetration,
        "memory": judgement.memory,
    }
    points = {name: ("point", np.asarray(getattr(judgement, name))) for name in ("x", "s", "p")}
    return xr.Dataset(
        {
            **numbers,
            **checks,
            **points,
            "reaction": ("body", list(judgement.reactions)),
            "unknowns": ("body", list(judgement.unknowns)),
            "seconds": ("stage", list(judgement.seconds.values())),
        },
        coords={"body": list(MODELS), "stage": list(judgement.seconds)},
    )


def _in_degrees(numbers: Numbers) -> dict[str, float]:
    return {name: float(np.degrees(v)) if name == "angle" else v for name, v in asdict(numbers).items()}
