"""Errors of ICs in tables, coloured by their size, and their definition for pages."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from compare.report.tables import ROUNDING, Cell, Row

VANISHING = " †"  # marks errors of components that vanish: shares of 0.05 max |C_nn|
MEASURE = (
    "The error of a component is max |v − C| over a line, relative to the component itself: to max |C_ij| "
    "over all lines at four or more elements from the load (for nearer points: over all points). The "
    "small number below is the weight: the same difference relative to max |C_nn| on the line. It shows "
    "how much the error affects displacements. “Vanishes”: C_ij is zero by symmetry, or smaller than ten "
    "times its own estimated error. An approximation is then compared with zero, and its number (†) is "
    "relative to 0.05 max |C_nn|. “0”: rounding error only."
)
ERRORS_HEADING = "Largest error of the {} influence coefficients against C"
DEEPEST = 0.55  # opacity of the background of the worst errors
COMPONENTS = (
    "A component names the displacement, then the traction. x is the rolling direction, s follows the "
    "contour, n is the normal from the lower into the upper body."
)


def error_cell(
    error: float, weight: float = np.nan, *, vanishes: bool = False, mark: str = "", is_estimate: bool = False
) -> Cell:
    """Return an error, coloured by its size, with its weight below; a dash where nothing was computed.

    `is_estimate`: the error is the estimate of C, which has no share where the component vanishes.
    """
    below = "" if np.isnan(weight) or weight < ROUNDING else percent(weight)
    if is_estimate and vanishes:
        return Cell("vanishes" + mark, below=below)
    if np.isnan(error):
        return Cell(error)
    if error < ROUNDING:
        return Cell("0" + mark)
    return Cell(percent(error) + (VANISHING if vanishes else "") + mark, below=below, colour=colour(error))


def error_row(
    name: str, errors: xr.Dataset, components: Sequence[str], *, is_estimate: bool, place: str = ""
) -> Row:
    """Return a row of errors [-] of components, with their `weight`, if any, and whether they vanish.

    `errors` has the dims i and j, `place` is the first cell.
    """
    weight = errors.get("weight", xr.full_like(errors.error, np.nan))
    found = [each.transpose("i", "j").values for each in (errors.error, weight, errors.vanishes)]
    i, j = (errors[dim].values.tolist() for dim in "ij")
    cells = []
    for component in components:
        at = i.index(component[0]), j.index(component[1])
        error, own_weight, vanishes = (values[at].item() for values in found)
        cells.append(error_cell(error, own_weight, vanishes=vanishes, is_estimate=is_estimate))
    return Row(name, [place, *cells] if place else cells)


def percent(share: float) -> str:
    """Return a share in percent, as tables show it."""
    if share < 5e-5:
        return "< 0.01 %"
    return f"{100 * share:.2f} %" if share < 0.1 else f"{100 * share:.1f} %"


def colour(error: float) -> str:
    """Return the background of an error: none up to 0.1 %, orange from 100 % on, logarithmic between."""
    share = float(np.clip((np.log10(max(error, 1e-9)) + 3) / 3, 0, 1))
    return orange(DEEPEST * share)


def orange(opacity: float) -> str:
    """Return the background of what is bad, on light and on dark pages; the text is readable on both.

    What is good is blue, if anything: who cannot tell red from green sees both.
    """
    return f"rgba(213, 94, 0, {opacity:.2f})"
