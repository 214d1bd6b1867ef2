"""The labelled arrays of contacts with ICs and by finite elements, `fe_contact.nc`."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from compare.contact.dataset import S, padded
from geometries.arrays import Array

FE = "FE"  # the name of contact by finite elements among the ICs
OF_PATCH = ("angle", "a", "b", "p_max")
APPROACH = "approach"
OF_PLACE = ("F_y", "M_x", "s_centre")  # numbers that vanish where all is symmetric
NUMBERS = (*OF_PATCH, APPROACH, *OF_PLACE)
CHECKS = ("load_of_pressures", "reaction", "tension", "penetration", "unknowns", "memory")


def joined(
    contacts: xr.Dataset, fe_contacts: Sequence[xr.Dataset | None], cells: float, rigid_compliance: float
) -> xr.Dataset:
    """Return numbers with estimates of all ICs and of finite elements, and checks of the latter.

    Cases without a solution by finite elements, None, are NaN there. `approach` by finite elements excludes
    the `rigid_compliance` M_zz [mm/N], which C does not have, times the load; `fe_raw_approach` includes it.
    """
    named = [prefix + name for name in NUMBERS for prefix in ("", "estimate_")]
    solved = _by_case(fe_contacts).assign_coords(case=contacts.case)
    fe = solved[named].expand_dims(ics=[FE])
    dataset = xr.concat([contacts[named], fe], "ics", combine_attrs="override")
    load = contacts["load"].isel(ics=0, drop=True)
    rigid = rigid_compliance * load
    dataset[APPROACH] = dataset[APPROACH].where(dataset.ics != FE, dataset[APPROACH] - rigid)
    dataset[f"fe_raw_{APPROACH}"] = solved[APPROACH].assign_attrs(units="mm")
    for name in CHECKS:
        dataset[f"fe_{name}"] = solved[name]
    dataset["seconds"] = contacts.seconds
    dataset["fe_seconds"] = solved.seconds
    dataset["load"] = load.assign_attrs(units="N")
    dataset["rigid_compliance"] = (), rigid_compliance, {"units": "mm/N"}
    s, p = (padded(part) for part in zip(*map(_profile, fe_contacts), strict=True))
    by_fe = {"units": "MPa", "long_name": "pressure by finite elements at x = 0"}
    dataset = dataset.assign_coords(s_fe=(("case", "s_fe"), s, S))
    dataset["p_fe"] = ("case", "s_fe"), p, by_fe
    dataset["p"] = _beside_middle(contacts).reindex(ics=dataset.ics)
    return dataset.assign_attrs(contacts.attrs | {"cells": cells})


def _by_case(fe_contacts: Sequence[xr.Dataset | None]) -> xr.Dataset:
    """Return variables with the same shape in all cases along a dimension, NaN for unsolved cases."""
    some = next(contact for contact in fe_contacts if contact is not None)
    unsolved = xr.full_like(some.astype(float), np.nan)
    cases = [unsolved if contact is None else contact for contact in fe_contacts]
    return xr.concat([case.drop_dims("point").astype(float) for case in cases], "case")


def _profile(contact: xr.Dataset | None) -> tuple[Array, Array]:
    """Return arc lengths [mm] and pressures [MPa] by finite elements at x = 0; none without a solution."""
    if contact is None:
        return np.zeros(0), np.zeros(0)
    at_middle = np.flatnonzero(contact.x.values < 1e-9 * float(contact.x.max()))
    order = at_middle[np.argsort(contact.s.values[at_middle])]
    return contact.s.values[order], contact.p.values[order]


def _beside_middle(contacts: xr.Dataset) -> xr.DataArray:
    """Return pressures with ICs beside x = 0, (case, ics, s)."""
    middle = contacts.x.notnull().sum("x") // 2
    return contacts.p.isel(x=middle).drop_vars("x").assign_attrs(long_name="pressure with ICs beside x = 0")
