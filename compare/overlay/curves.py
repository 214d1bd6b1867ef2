"""Curves of several scenes along the lines that they have in common, as panels and as CSV files."""

import csv
from itertools import product
from pathlib import Path

import numpy as np

from compare.ics.curves import line_panel
from compare.ics.dataset import curves_file
from compare.overlay.results import Overlay
from compare.report.panels import Panel
from compare.report.styles import SYMBOLS
from femic.cache.files import replacing

MIRRORED = 1e-6  # largest asymmetry of a mirrored curve, as a share of the largest value on its line


def is_mirrored(overlay: Overlay, line: str) -> bool:
    """Whether the two halves of a line have the same values, up to the sign, in all curves of all scenes."""
    return all(
        _repeats(line_panel(result.ics, line, body, component))
        for result, body, component in product(
            overlay.results, overlay.common.bodies, overlay.common.components
        )
    )


def _repeats(panel: Panel) -> bool:
    if panel.across.startswith("x"):
        return True  # every body and every load is symmetric in x
    sizes = np.abs(list(panel.curves.values()))
    asymmetry = np.max(np.abs(sizes - sizes[:, ::-1]))
    return np.allclose(panel.at, -panel.at[::-1]) and bool(asymmetry <= MIRRORED * np.max(sizes))


def write_curves(overlay: Overlay, folder: Path) -> None:
    """Write one CSV file per line, with a row per scene, body, component and point.

    Each variant has a column; all values are dimensionless.
    """
    variants = (*overlay.common.variants, "C")
    for line in overlay.common.lines:
        first = line_panel(
            overlay.results[0].ics, line, overlay.common.bodies[0], overlay.common.components[0]
        )
        with (
            replacing(folder / curves_file(line)) as unfinished,
            unfinished.open("w", newline="", encoding="utf-8") as file,
        ):
            table = csv.writer(file)
            table.writerow(["scene", "body", "component", f"{first.across[0]}/L", *variants, "estimate"])
            for result, body, component in product(
                overlay.results, overlay.common.bodies, overlay.common.components
            ):
                panel = line_panel(result.ics, line, body, component)
                curves = [panel.curves[SYMBOLS[variant]] for variant in variants]
                for row in np.column_stack([panel.at, *curves, np.asarray(panel.estimate)]):
                    table.writerow([result.name, body, component, *(f"{value:.8g}" for value in row)])
