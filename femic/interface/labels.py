"""Labelled datasets as the functions that take them need them: labels decide, whatever their order."""

from collections.abc import Hashable, Sequence

import numpy as np
import xarray as xr

from geometries.errors import WrongInput
from geometries.patches import DIRECTIONS

OF_ICS = ("variant", "body", "i", "j", "point")
OF_CONTACTS = (("shift", "side", "ics"), ("friction", "ics"), ("case", "ics"))
LEADING = ("friction", "case", "ics", "xi", "distance", "load", "supports")  # dimensions of contacts


def by_label(
    name: str, labelled: xr.Dataset, order: Sequence[str], maker: str, directions: str = "xsn"
) -> xr.Dataset:
    """Return a dataset of ICs with its dimensions in an order, and with all `directions` along i and j.

    `name` is the argument, `maker` the function that returns such datasets. Raises WrongInput for other
    dimensions, and for directions that are missing, twice, or not labelled.
    """
    if "ic" not in labelled:
        raise WrongInput(f"{name}: a dataset without the variable ic: give one of {maker}")
    for variable in ("ic", *({"estimate"} & set(labelled.data_vars))):
        needed = [dim for dim in order if variable == "ic" or dim != "variant"]
        if set(labelled[variable].dims) != set(needed):
            raise WrongInput(
                f"{name}: {variable} has the dimensions {', '.join(map(str, labelled[variable].dims))}: "
                f"{', '.join(needed)} are needed, in any order; .sel(i=['n']) keeps i, .sel(i='n') does not"
            )
    for dim in order:
        if dim not in labelled.coords and dim != "point":
            raise WrongInput(f"{name}: no labels along {dim}; give a dataset of {maker}")
    labelled = labelled.transpose(*order, ...)
    for dim in ("i", "j"):
        labels = [str(label) for label in labelled[dim].values]
        if sorted(labels) != sorted(set(labels)) or not set(directions) <= set(labels) <= set(DIRECTIONS):
            wanted = ", ".join(directions or DIRECTIONS)
            raise WrongInput(
                f"{name}: {dim} = {', '.join(labels)}: {wanted} are needed, each once, in any order"
            )
        labelled = labelled.sel({dim: [known for known in DIRECTIONS if known in labels]})
    return labelled


def ics_by_label(name: str, ics: xr.Dataset, component: str | None = None) -> xr.Dataset:
    """Return ICs in the order of `compute_ics`, the points of each line by x and s.

    All components have to be there, or one alone. Raises WrongInput.
    """
    if component is None:
        ics = by_label(name, ics, OF_ICS, "compute_ics")
    else:
        ics = by_label(name, ics, OF_ICS, "compute_ics", "")
        for dim, direction in zip("ij", component, strict=True):
            if direction not in ics[dim]:
                raise WrongInput(f"{name}: component {component}: no {direction} along {dim} in the dataset")
    for key in ("x", "s", "line"):
        if key not in ics.coords or ics[key].dims != ("point",):
            raise WrongInput(f"{name}: no coordinate {key} along point: give a dataset of compute_ics")
    lines = ics.line.values.tolist()
    numbers = {line: k for k, line in enumerate(dict.fromkeys(lines))}
    return ics.isel(point=np.lexsort((ics.s, ics.x, [numbers[line] for line in lines])))


def contacts_by_label(name: str, contacts: xr.Dataset) -> xr.Dataset:
    """Return contacts with dimensions in the order of `solve_contact`.

    Raises WrongInput for a dataset that is not of `solve_contact` or `compute_shifts`.
    """
    needed = next((dims for dims in OF_CONTACTS if dims[0] in contacts.dims), OF_CONTACTS[-1])
    if missing := [dim for dim in needed if dim not in contacts.dims or dim not in contacts.coords]:
        raise WrongInput(
            f"{name}: no dimension {', '.join(missing)} with labels: give a dataset of solve_contact or "
            "compute_shifts; .sel(ics=['A']) keeps ics, .sel(ics='A') does not"
        )
    for variable in ("p_max", *(("p",) if needed[0] == "case" else ())):
        if variable not in contacts:
            raise WrongInput(
                f"{name}: no variable {variable}: give a whole dataset of solve_contact or compute_shifts"
            )
    for dim in ("x", "s"):
        if dim in contacts.dims and dim in contacts.coords:
            # places grow as in the case that has most of them
            of_cases = contacts[dim].transpose(..., dim).values.reshape(-1, contacts.sizes[dim])
            most = int(np.argmax(np.sum(np.isfinite(of_cases), axis=1)))
            contacts = contacts.isel({dim: np.argsort(of_cases[most], kind="stable")})

    def rank(dim: Hashable) -> tuple[int, str]:
        """Return where a dimension stands: numbers before fields, x before s before directions."""
        text = str(dim)
        if text in LEADING:
            return LEADING.index(text), ""
        return len(LEADING) + {"x": 0, "s": 1}.get(text.removeprefix("larger_"), 2), text

    return contacts.transpose(*sorted(contacts.dims, key=rank), ...)
