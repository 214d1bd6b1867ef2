"""Contact with friction of a scene with several ICs, as `femic.contact` solves it: arrays of `contact.nc`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any

import xarray as xr

from compare.contact.compute import require_solvable
from compare.contact.dataset import provenance
from compare.friction import compression, rolling, transient
from compare.friction.parts import by_friction_and_ics
from compare.matrix.jobs import discounted
from femic.contact.pairs.given_ics import NONE_GIVEN, GivenICs
from femic.contact.pairs.pair_with_friction import PairWithFriction, solve_with_friction
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene


@dataclass(frozen=True)
class Labels:
    """How the solutions of a motion become labelled arrays: of each friction and ICs, and of all together."""

    title: str
    labelled: Callable[[PairWithFriction, Any], xr.Dataset]
    of_all: Callable[[Scene, xr.Dataset], xr.Dataset] = lambda _, dataset: dataset


LABELS: dict[str, Labels] = {
    "rolling": Labels("Rolling with friction", rolling.labelled, rolling.with_distances),
    "transient": Labels("Transient rolling with friction", transient.labelled, transient.with_creepages),
    "compression": Labels("Compression with friction", compression.labelled),
}


def _labels_of(scene: Scene) -> Labels:
    """Return the labels of a scene's motion; raises BadScene where none are registered."""
    motion = scene.contact.motion
    if motion not in LABELS:
        raise BadScene(
            f"{scene.name}: contact.motion = {motion!r}: its solutions have no labels: register some in "
            f"{__name__}.LABELS, or use one of {', '.join(LABELS)}"
        )
    return LABELS[motion]


def compute_with_friction(
    scene: Scene, options: RunOptions = DEFAULT, given: Mapping[str, GivenICs] = NONE_GIVEN
) -> xr.Dataset:
    """Return numbers by friction, ICs and the dimension of the motion, each with `estimate_NAME`, and maps.

    `given` are ICs of the caller by name. Raises BadScene for what cannot be solved, and Failure as
    `femic.contact`.
    """
    require_solvable(scene, given)
    start, labels = perf_counter(), _labels_of(scene)
    solve = partial(by_friction_and_ics, labelled=labels.labelled)
    joined = solve_with_friction(scene.contact_problem, solve, options, given)
    attributes = {
        "title": f"{labels.title}: {scene.title}",
        "meaning": "tractions on the upper body along x, s, n of the lower surface; slip over that surface",
        "discounted": discounted(scene),
        **provenance(scene, perf_counter() - start, __name__),
    }
    return labels.of_all(scene, joined.assign_attrs(attributes))
