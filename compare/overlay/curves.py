"""Curves of several scenes along the lines that they have in common, dimensionless, and as CSV files."""

import csv
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from compare.ics.curves import along_line, dimensionless
from compare.ics.dataset import curves_file
from compare.overlay.results import Overlay
from femic.cache.files import replacing

MIRRORED = 1e-6  # largest asymmetry of a mirrored curve, as a share of the largest value on its line


def curves_of(ics: xr.Dataset, line: str, body: str, component: str) -> xr.Dataset:
    """Return a component of a body of a scene along a line over `at`, dimensionless."""
    return along_line(ics, line, body, component, dimensionless(ics))


def is_mirrored(overlay: Overlay, line: str) -> bool:
    """Whether the two halves of a line have the same values, up to the sign, in all curves of all scenes."""
    return all(
        _repeats(curves_of(result.ics, line, body, component))
        for result, body, component in product(
            overlay.results, overlay.common.bodies, overlay.common.components
        )
    )


def _repeats(curves: xr.Dataset) -> bool:
    if curves.across.startswith("x"):
        return True  # every body and every load is symmetric in x
    at, sizes = curves["at"].values, np.abs(curves.ic.values)
    asymmetry = np.max(np.abs(sizes - sizes[:, ::-1]))
    return np.allclose(at, -at[::-1]) and bool(asymmetry <= MIRRORED * np.max(sizes))


def write_curves(overlay: Overlay, folder: Path) -> None:
    """Write one CSV file per line, with a row per scene, body, component and point.

    Each variant has a column; all values are dimensionless.
    """
    common, variants = overlay.common, [*overlay.common.variants, "C"]
    for line in common.lines:
        across = curves_of(overlay.results[0].ics, line, common.bodies[0], common.components[0]).across
        with (
            replacing(folder / curves_file(line)) as unfinished,
            unfinished.open("w", newline="", encoding="utf-8") as file,
        ):
            table = csv.writer(file)
            table.writerow(["scene", "body", "component", f"{across[0]}/L", *variants, "estimate"])
            for result, body, component in product(overlay.results, common.bodies, common.components):
                curves = curves_of(result.ics, line, body, component)
                values = [
                    curves["at"].values,
                    *curves.ic.sel(variant=variants).values,
                    curves.estimate.values,
                ]
                for row in np.column_stack(values):
                    table.writerow([result.name, body, component, *(f"{value:.8g}" for value in row)])
