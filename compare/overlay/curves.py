"""Curves of several scenes along the lines that they have in common, as panels and as CSV files."""

import csv
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from compare.ics.curves import panel_of
from compare.overlay.results import Overlay, SceneResults
from compare.report.panels import Panel
from compare.report.styles import SYMBOLS
from femic.cache.files import replacing

MIRRORED = 1e-6  # largest asymmetry of a mirrored curve, as a share of the largest value on its line


def curve(result: SceneResults, line: str, body: str, component: str) -> Panel:
    """The curves of all variants of one scene for one component of one body along a line, dimensionless."""
    on_line = result.ics.isel(point=np.flatnonzero(result.ics.line.values == line))
    along = "x" if np.ptp(on_line.s.values) == 0 else "s"
    component_ics = on_line.sel(body=body, i=component[0], j=component[1])
    panel = panel_of(component_ics, on_line[along].values / result.reference_length)
    return replace(panel, across=f"{along} / L  [-]")


def is_mirrored(overlay: Overlay, line: str) -> bool:
    """Whether the two halves of a line have the same values, up to the sign, in all curves of all scenes."""
    return all(
        _repeats(curve(result, line, body, component))
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
        first = curve(overlay.results[0], line, overlay.common.bodies[0], overlay.common.components[0])
        file_name = line.replace(" ", "").replace("=", "")
        with (
            replacing(folder / f"curves_{file_name}.csv") as unfinished,
            unfinished.open("w", newline="", encoding="utf-8") as file,
        ):
            table = csv.writer(file)
            table.writerow(["scene", "body", "component", f"{first.across[0]}/L", *variants, "estimate"])
            for result, body, component in product(
                overlay.results, overlay.common.bodies, overlay.common.components
            ):
                panel = curve(result, line, body, component)
                curves = [panel.curves[SYMBOLS[variant]] for variant in variants]
                for row in np.column_stack([panel.at, *curves, np.asarray(panel.estimate)]):
                    table.writerow([result.name, body, component, *(f"{value:.8g}" for value in row)])
