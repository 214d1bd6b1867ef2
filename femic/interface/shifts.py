"""A wheelset on its track at several lateral shifts."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import tomlkit
import xarray as xr

from femic.interface.arguments import with_checked_arguments
from femic.interface.bodies import plain
from femic.interface.options import DEFAULT, Options, in_turn
from femic.interface.profiles import Profile
from femic.results import wheelset as compute
from femic.scenes.load import merged
from femic.shifts.specification import parse_specification
from geometries.errors import WrongInput
from geometries.profiles.profile import Kind

NAME = Path("shifts")  # of specifications that Python describes, in messages


@with_checked_arguments
@in_turn
def compute_shifts(
    rail: Profile,
    wheel: Profile,
    shifts: Sequence[float],
    *,
    tables: Mapping[str, Any] | None = None,
    options: Options = DEFAULT,
) -> xr.Dataset:
    """Set a wheelset on its track at lateral `shifts` [mm], and solve the contacts of both wheels.

    `tables` has further keys of a specification (docs/how-to/shifts.md): of "track", "wheelset", "contact",
    with the load and the ICs, and of "rail" and "wheel", such as E and flange_back. Of `options` only
    workers, store and report count.

    Variables of the result have units and meanings: where rail and wheel touch and rolling radii, by shift
    and side; forces, pressures [MPa] and patches also by ICs. What is not possible is NaN, and the attribute
    `refused` has the reasons. Raises WrongInput, and Failure where no shift is possible.
    """
    profiles = {"rail": _table(rail, "rail"), "wheel": _table(wheel, "wheel")}
    table = plain(merged({"shifts": shifts, **profiles}, tables or {}))
    return compute.compute_shifts(parse_specification(table, NAME), tomlkit.dumps(table), options.run)


def _table(profile: Profile, kind: Kind) -> dict[str, Any]:
    """Return the keys of a profile in a specification; raise WrongInput for one of the other kind."""
    if (seen := profile.understood.kind) != kind:
        raise WrongInput(f"{kind} = {profile.standard or str(profile.file)!r}: the profile of a {seen}")
    keys = profile.keys
    name = profile.standard or keys.pop("file")  # an absolute path: no standard profile has such a name
    return {"profile": name} | keys
