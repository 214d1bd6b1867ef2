"""The labelled arrays of contacts by ICs beside those by finite elements, `fe_contact.nc`."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

FE = "FE"  # the name of contact by finite elements among the ICs
OF_PATCH = ("angle", "a", "b", "p_max")
APPROACH = "approach"
OF_PLACE = ("F_y", "M_x", "s_centre")  # numbers that vanish where all is symmetric
NUMBERS = (*OF_PATCH, APPROACH, *OF_PLACE)
CHECKS = ("load_of_pressures", "reaction", "tension", "penetration", "unknowns", "memory")


def beside(
    contacts: xr.Dataset, by_fe: Sequence[xr.Dataset | None], cells: float, rigid_compliance: float
) -> xr.Dataset:
    """Numbers with their estimates of all ICs and of finite elements, and what is known of the latter.

    Cases that finite elements have not solved, None, are NaN there.

    The approach by finite elements has in it that of the whole bodies, whose `rigid_compliance` M_zz [mm/N]
    C is without: `approach` is without that times the load, and `fe_raw_approach` with it.
    """
    named = [prefix + name for name in NUMBERS for prefix in ("", "estimate_")]
    of_all = _by_case(by_fe).assign_coords(case=contacts.case)
    fe = of_all[named].expand_dims(ics=[FE])
    dataset = xr.concat([contacts[named], fe], "ics", combine_attrs="override")
    load = contacts["load"].isel(ics=0, drop=True)
    rigid = rigid_compliance * load
    dataset[APPROACH] = dataset[APPROACH].where(dataset.ics != FE, dataset[APPROACH] - rigid)
    dataset[f"fe_raw_{APPROACH}"] = of_all[APPROACH].assign_attrs(units="mm")
    for name in CHECKS:
        dataset[f"fe_{name}"] = of_all[name]
    dataset["seconds"] = contacts.seconds
    dataset["fe_seconds"] = of_all.seconds
    dataset["load"] = load.assign_attrs(units="N")
    dataset["rigid_compliance"] = (), rigid_compliance, {"units": "mm/N"}
    lines = [_profile(one, number) for number, one in enumerate(by_fe) if one is not None]
    of_ics = [_profile_of_ics(contacts, number) for number in range(len(by_fe))]
    joined = xr.merge([dataset, *lines, *of_ics], join="outer")  # there is no profile of FE on grids
    return joined.assign_attrs(contacts.attrs | {"cells": cells})


def _by_case(by_fe: Sequence[xr.Dataset | None]) -> xr.Dataset:
    """What has the same shape in all cases, as a dimension; NaN for what is not solved."""
    solved = [None if one is None else one.drop_vars(_ragged(one)).astype(float) for one in by_fe]
    some = next(one for one in solved if one is not None)
    return xr.concat([xr.full_like(some, np.nan) if one is None else one for one in solved], "case")


def _ragged(one: xr.Dataset) -> list[str]:
    return [str(name) for name in one.variables if "point" in one[name].dims]


def _profile(one: xr.Dataset, number: int) -> xr.Dataset:
    """Pressures by finite elements at x = 0 along s."""
    at_middle = np.flatnonzero(one.x.values < 1e-9 * float(one.x.max()))
    order = at_middle[np.argsort(one.s.values[at_middle])]
    s = f"s_fe_{number}"
    return xr.Dataset(
        {f"p_fe_{number}": (s, one.p.values[order], {"units": "MPa"})},
        coords={s: (s, one.s.values[order], {"units": "mm"})},
    )


def _profile_of_ics(contacts: xr.Dataset, number: int) -> xr.Dataset:
    """Pressures by ICs beside x = 0 along s."""
    p = contacts[f"p_{number}"]
    return p.isel({f"x_{number}": p.sizes[f"x_{number}"] // 2}, drop=True).to_dataset(name=f"p_{number}")
