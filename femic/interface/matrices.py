"""IC matrices: ICs of all pairs of elements of a grid, by lag along x and by strips."""

from dataclasses import asdict
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from approx.pair import matrix
from approx.variants import forms_of
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.interface.arguments import array, new_file, with_checked_arguments
from femic.interface.bodies import Pair
from femic.interface.labels import by_label
from femic.interface.options import DEFAULT, Options, in_turn, make_scene
from femic.reference.matrix.job import Discount
from femic.reference.matrix.reference import matrices, pair_column
from femic.results import contact_file
from femic.results.export import distances_after, to_contact, write_distances
from femic.results.matrices import DIMENSIONS, matrix_jobs
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import DIRECTIONS, Grid

MEANINGS = {
    "ic": ("mm/MPa", "displacement i of an element per traction j on another"),
    "estimate": ("mm/MPa", "estimated error of ic"),
    "lag": ("mm", "distance along x from the loaded element"),
    "observed": ("mm", "arc length of the displaced strip"),
    "loaded": ("mm", "arc length of the loaded strip"),
}
OF_PAIR = DIMENSIONS[1:]  # lag, observed, loaded, i, j
SAME_PLACE = 1e-6  # of an element, by which labels may be off


@with_checked_arguments
@in_turn
def compute_matrix(
    pair: Pair, grid: Grid, ics: str = "C", options: Options = DEFAULT, *, discount: Discount = "approach"
) -> xr.Dataset:
    """Compute the combined IC matrix of a pair on a grid, for contact programs.

    `ics` is "C" or the name of an approximation, which may have exchanged components such as "Bhat+sn:B". The
    variable `ic` (lag, observed, loaded, i, j) [mm/MPa] is the displacement i on the observed strip under a
    traction j on an element of the loaded strip, at a lag along x. For C there is also the estimated error
    `estimate` [mm/MPa]. At negative lags, xs, sx, xn and nx change sign.

    `discount` says what is subtracted from C: "approach", the rigid part of the normal approach; "source",
    everything that [BVSV] subtracts before comparing single loads with half-spaces; or "none".

    Raises WrongInput, and Failure where C cannot be computed to the tolerance.
    """
    scene = make_scene(pair, options, {"grid": asdict(grid), "discount": discount})
    if ics != "C":
        try:
            forms_of(ics)
        except WrongInput as error:
            raise WrongInput(f"ics: {error}") from error
        return label_matrix(matrix(ics, scene.pair, grid), grid, ics)
    references = matrices(matrix_jobs(scene), options.run, combined=True)
    contour = scene.bodies["lower"].contour
    columns = [pair_column(references, contour, strip) for strip in range(grid.n_s)]
    c, estimate = (
        grid.area * np.stack([getattr(column, part) for column in columns], axis=-1).transpose(2, 3, 4, 0, 1)
        for part in ("ic", "estimate")
    )
    return label_matrix(c, grid, ics, estimate)


@with_checked_arguments
def label_matrix(
    ics: ArrayLike | xr.DataArray,
    grid: Grid,
    name: str,
    estimate: ArrayLike | xr.DataArray | None = None,
) -> xr.Dataset:
    """Return ICs from elsewhere in the form of `compute_matrix`, which `solve_contact` takes.

    `ics` and their estimated error `estimate` have the shape (n_x, n_s, n_s, 3, 3) [mm/MPa]: lag, observed
    strip, loaded strip, displacement i and traction j along x, s, n. Labelled arrays, such as the variables
    of `compute_matrix`, are read by their labels, in any order. `name` is the name shown in results.

    Raises WrongInput for another shape or other labels, and for numbers that are not finite.
    """
    arrays = {"ic": _checked("ics", ics, grid)}
    if estimate is not None:
        arrays["estimate"] = _checked("estimate", estimate, grid)
    places = {"lag": grid.lags, "observed": grid.strips, "loaded": grid.strips}
    attributes = {key: {"units": unit, "long_name": meaning} for key, (unit, meaning) in MEANINGS.items()}
    return xr.Dataset(
        {key: (OF_PAIR, values, attributes[key]) for key, values in arrays.items()},
        coords={key: (key, at, attributes[key]) for key, at in places.items()}
        | {"i": list(DIRECTIONS), "j": list(DIRECTIONS)},
        attrs={"ics": name, "dx": grid.dx, "ds": grid.ds},
    )


def ordered(name: str, labelled: xr.Dataset) -> xr.Dataset:
    """Return a labelled matrix in the order of `compute_matrix`, read by its labels.

    `name` is its argument. Raises WrongInput where labels are missing or are not those of a grid.
    """
    labelled = by_label(name, labelled, OF_PAIR, "compute_matrix or label_matrix")
    for along in ("lag", "observed", "loaded"):
        if labelled[along].dtype.kind not in "iuf":
            raise WrongInput(
                f"{name}: {along} = {labelled[along].values[0]!r}, ...: lengths in mm are needed"
            )
    labelled = labelled.sortby(["lag", "observed", "loaded"])
    grid = matrix_grid(labelled)
    wanted = {
        "lag": (grid.lags, grid.dx, f"0, dx, 2 dx, ... with dx = {grid.dx:g}"),
        "observed": (grid.strips, grid.ds, f"strips side by side, ds = {grid.ds:g}"),
        "loaded": (grid.strips, grid.ds, "the strips of observed"),
    }
    for along, (places, size, words) in wanted.items():
        own = labelled[along].values
        if len(own) != len(places) or not np.allclose(own, places, rtol=0, atol=SAME_PLACE * size):
            first = ", ".join([f"{value:g}" for value in own[:3]] + ["..."] * (len(own) > 3))
            raise WrongInput(f"{name}: {along} = {first}: {words} mm are needed, in any order")
    for variable in ("ic", *({"estimate"} & set(labelled.data_vars))):
        _require_finite(f"{name}: {variable}", labelled[variable].values)
    return labelled


def matrix_name(labelled: xr.Dataset) -> str:
    """Return the name of a labelled matrix; raise WrongInput where it has lost its labels."""
    if missing := {"ics", "dx", "ds"} - set(labelled.attrs):
        raise WrongInput(
            f"ics: a matrix without attributes {', '.join(sorted(missing))}: label it by label_matrix"
        )
    return str(labelled.attrs["ics"])


def matrix_grid(labelled: xr.Dataset) -> Grid:
    """Return the grid of a labelled matrix. Raises WrongInput where it has lost its labels."""
    matrix_name(labelled)
    dx, ds = (float(array(key, labelled.attrs[key])) for key in ("dx", "ds"))
    strips = labelled.observed.values
    middle = float((strips.min() + strips.max()) / 2)
    return Grid(labelled.sizes["lag"], len(strips), dx, ds, middle)


@with_checked_arguments
def write_for_contact(
    pair: Pair, ics: xr.Dataset, path: str | Path, *, approach: float | None = None
) -> None:
    """Write an IC matrix, labelled as by `compute_matrix`, to a file for the program CONTACT.

    If you give a vertical `approach` [mm], the distances of the bodies along n after this approach are
    written to `contact_distances.txt` next to the file, x fastest, as CONTACT reads them with N = 0. `femic
    export` prints the other settings for CONTACT. Raises WrongInput.
    """
    ics, path = ordered("ics", ics), new_file(path)
    scene = make_scene(pair, DEFAULT, {"grid": asdict(matrix_grid(ics))})
    try:
        contact_file.write(to_contact(scene, ics.ic.values), path)
        if approach is not None:
            on_grid = pair_on_grid(scene.contact_problem, scene.grid)
            write_distances(distances_after(on_grid, approach), path.parent)
    except OSError as error:
        raise WrongInput(f"path = {str(path)!r}: {error.strerror or error}") from error


def _checked(name: str, given: ArrayLike | xr.DataArray, grid: Grid) -> Array:
    """Return numbers for a grid, labelled ones in the order of `compute_matrix`."""
    if isinstance(given, xr.DataArray):
        own = xr.Dataset({"ic": given.drop_attrs()}, attrs={"ics": name, "dx": grid.dx, "ds": grid.ds})
        own = ordered(name, own)
        if not np.allclose(own.observed.values[:1], grid.strips[:1], rtol=0, atol=SAME_PLACE * grid.ds):
            raise WrongInput(
                f"{name}: strips from s = {own.observed.values[0]:g}, of the grid from {grid.strips[0]:g} mm"
            )
        given = own.ic.values
    values = np.asarray(given, dtype=float)
    shape = (grid.n_x, grid.n_s, grid.n_s, 3, 3)
    if values.shape != shape:
        raise WrongInput(f"{name} of shape {values.shape}: {shape} is needed: lag, observed, loaded, i, j")
    _require_finite(name, values)
    return values


def _require_finite(name: str, values: Array) -> None:
    if not np.all(np.isfinite(values)):
        raise WrongInput(f"{name}: {np.sum(~np.isfinite(values))} of {values.size} numbers are not finite")
