"""IC matrices: the ICs of all pairs of elements of a grid, by their lag along x and their strips."""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from approx.matrix import matrix
from compare.export import contact_file
from compare.export.export import to_contact
from compare.export.grid import distances_after, write_distances
from compare.matrix.file import DIMENSIONS
from compare.matrix.jobs import matrix_jobs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.interface.bodies import Pair
from femic.interface.options import DEFAULT, Options
from femic.interface.scenes import NAME, scene_of
from femic.reference.matrix.job import Discount
from femic.reference.matrix.pair import pair_column
from femic.reference.matrix.reference import matrices
from femic.scenes.errors import require_none
from femic.scenes.grid import grid_misfits
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.patches import DIRECTIONS

OF_PAIR = DIMENSIONS[1:]  # lag, observed, loaded, i, j


def compute_matrix(
    pair: Pair, grid: Grid, ics: str = "C", options: Options = DEFAULT, *, discount: Discount = "approach"
) -> xr.Dataset:
    """Compute the IC matrix of both bodies together on a grid, for contact programs.

    `ics` is "C" or the name of an approximation, also with exchanged components: "Bhat+sn:B". The variable
    `ic` (lag, observed, loaded, i, j) [mm/MPa] is the displacement i on an observed strip, at a lag along x
    from an element of a loaded strip with traction j; with C comes its estimated error, `estimate` [mm/MPa].
    At negative lags xs, sx, xn and nx change their signs.

    `discount` says what is taken from C: "approach", the rigid part of the normal approach; "source", as in
    [BVSV], all that has to go before single loads are compared with half-spaces; or "none".

    Raises WrongInput, and Failure where C cannot be computed to the tolerance.
    """
    scene = replace(_scene(pair, grid, options), discount=discount)
    if ics != "C":
        return label_matrix(matrix(ics, scene.pair, grid), grid, ics)
    references = matrices(matrix_jobs(scene), options.run, combined=True)
    contour = scene.bodies["lower"].contour
    columns = [pair_column(references, contour, strip) for strip in range(grid.n_s)]
    c, estimate = (
        grid.area * np.stack([getattr(column, part) for column in columns], axis=-1).transpose(2, 3, 4, 0, 1)
        for part in ("ic", "estimate")
    )
    return label_matrix(c, grid, ics, estimate)


def label_matrix(ics: ArrayLike, grid: Grid, name: str, estimate: ArrayLike | None = None) -> xr.Dataset:
    """Return ICs from elsewhere in the form of `compute_matrix`, which `solve_contact` takes.

    `ics` and `estimate`, their estimated error, have the shape (n_x, n_s, n_s, 3, 3) [mm/MPa]: lag, observed
    and loaded strip, displacement i and traction j along x, s, n. `name` says what they are.

    Raises WrongInput for another shape, and for numbers that are not finite.
    """
    given = {"ic": ics} if estimate is None else {"ic": ics, "estimate": estimate}
    arrays = {key: _checked(key, np.asarray(values, dtype=float), grid) for key, values in given.items()}
    mm, units = {"units": "mm"}, {"units": "mm/MPa"}
    return xr.Dataset(
        {key: (OF_PAIR, values, units) for key, values in arrays.items()},
        coords={
            "lag": ("lag", grid.lags, mm),
            "observed": ("observed", grid.strips, mm),
            "loaded": ("loaded", grid.strips, mm),
            "i": list(DIRECTIONS),
            "j": list(DIRECTIONS),
        },
        attrs={"ics": name, "dx": grid.dx, "ds": grid.ds},
    )


def name_of(labelled: xr.Dataset) -> str:
    """Return the name of a labelled matrix; raise WrongInput where it has lost its labels."""
    if missing := {"ics", "dx", "ds"} - set(labelled.attrs):
        raise WrongInput(
            f"a matrix without attributes {', '.join(sorted(missing))}: label it by label_matrix"
        )
    return str(labelled.attrs["ics"])


def grid_of(labelled: xr.Dataset) -> Grid:
    """Return the grid of a labelled matrix."""
    strips = labelled.observed.values
    middle = float((strips[0] + strips[-1]) / 2)
    return Grid(labelled.sizes["lag"], len(strips), labelled.attrs["dx"], labelled.attrs["ds"], middle)


def write_for_contact(
    pair: Pair, ics: xr.Dataset, path: str | Path, *, approach: float | None = None
) -> None:
    """Write an IC matrix, labelled as by `compute_matrix`, to a file for the program CONTACT.

    With a vertical `approach` [mm] the distances of the bodies on the grid after it, along n, are written to
    `contact_distances.txt` beside the file, x fastest, as CONTACT takes them with N = 0. `femic export`
    prints what else has to be set there.
    """
    name_of(ics)
    scene = _scene(pair, grid_of(ics), DEFAULT)
    contact_file.write(to_contact(scene, ics.ic.values), Path(path))
    if approach is not None:
        on_grid = pair_on_grid(scene.contact_problem, scene.grid)
        write_distances(distances_after(on_grid, approach), Path(path).parent)


def _scene(pair: Pair, grid: Grid, options: Options) -> Scene:
    """Return the scene of a matrix; raise WrongInput for a grid that does not fit."""
    scene = scene_of(pair, options, {"grid": asdict(grid)})
    require_none(NAME, grid_misfits(scene))
    return scene


def _checked(name: str, values: Array, grid: Grid) -> Array:
    shape = (grid.n_x, grid.n_s, grid.n_s, 3, 3)
    if values.shape != shape:
        raise WrongInput(f"{name} of shape {values.shape}: {shape} is needed: lag, observed, loaded, i, j")
    if not np.all(np.isfinite(values)):
        raise WrongInput(f"{name}: {np.sum(~np.isfinite(values))} of {values.size} numbers are not finite")
    return values
