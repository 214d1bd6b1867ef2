"""Largest stresses under the contact of a scene by body, and wear and fatigue numbers of its rolling."""

from collections.abc import Iterator

import xarray as xr

from compare.campaigns.results.contact import jobs_of_contact, seconds_of_contacts
from compare.campaigns.results.kind import Jobs, ResultKind
from femic.reference.run_options import RunOptions
from femic.results.damage import OF_DAMAGE
from femic.results.stressed_contact import require_stresses, with_one_contact
from femic.results.stresses import BODIES, HALF_SPACE, TRUE, compute_stresses
from femic.scenes.scene import Scene

SHORT = {"von_mises": "mises", "tresca": "tresca", "principal": "principal", "dang_van": "dang_van"}
PLACES = ("s", "depth")
OF_CONTACTS = ("xi", "p_max")  # numbers that `contact` has of all contacts of the scene, under these names
DAMAGE = [name for name in OF_DAMAGE if name not in OF_CONTACTS]
SECONDS_OF_STRESSES = 30.0  # on the lattice in both bodies
HALF = "half_space_"  # before the names of stresses in half-spaces
PREFIXES = ("", HALF, "estimate_", *(f"{place}_" for place in PLACES))
NAMES = frozenset(
    {f"{prefix}{name}_{body}" for prefix in PREFIXES for name in SHORT.values() for body in BODIES}
    | {*DAMAGE, *(f"estimate_{name}" for name in DAMAGE), "ics"}
)


def stresses(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return the largest stresses [MPa] on the lattice, as `femic stresses` does, and damage by ICs.

    `mises_BODY`, `tresca_BODY`, `principal_BODY`, of contacts that travel `dang_van_BODY`, of the true body;
    with their places `s_...` and `depth_...`, estimates `estimate_...`, and those of a half-space under the
    same tractions, `half_space_...`. Of rolling `t_gamma`, `work`, `largest_depth_energy`, ... over `ics`.
    """
    computed = compute_stresses(scene, options)
    numbers = xr.Dataset({name: values.drop_vars(values.coords) for name, values in _of_bodies(computed)})
    if "ics" not in computed.dims:
        return numbers
    of_ics = [f"{prefix}{name}" for name in DAMAGE if name in computed for prefix in ("", "estimate_")]
    return numbers.merge(computed[of_ics])


def _of_bodies(computed: xr.Dataset) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield numbers of the bodies with their names in campaigns."""
    for name, short in ((name, short) for name, short in SHORT.items() if name in computed):
        for body in BODIES:
            true = computed.sel(body=body, source=TRUE)
            yield f"{short}_{body}", true[name]
            yield f"{HALF}{short}_{body}", computed[name].sel(body=body, source=HALF_SPACE)
            for prefix in ("estimate_", *(f"{place}_" for place in PLACES)):
                if f"{prefix}{name}" in computed:
                    yield f"{prefix}{short}_{body}", true[f"{prefix}{name}"]


def _jobs(scene: Scene) -> list[Jobs]:
    """Return the jobs of C on the grid of the contact."""
    return jobs_of_contact(with_one_contact(scene))


def _seconds(scene: Scene) -> float:
    """Return about how many seconds stresses and damage take, besides C."""
    return SECONDS_OF_STRESSES + seconds_of_contacts(with_one_contact(scene))


STRESSES = ResultKind(stresses, _jobs, require_stresses, NAMES, _seconds)
