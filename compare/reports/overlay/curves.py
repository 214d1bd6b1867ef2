"""Overlay of the results of several scenes: curves and errors of what they have in common."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr

from compare.reports.overlay.sources import Content, Source, common, read
from geometries.arrays import Array

MIRRORED = 1e-6  # of the largest value on a line


@dataclass(frozen=True)
class Result:
    """The results of one scene."""

    name: str
    ics: xr.Dataset
    errors: xr.Dataset

    @property
    def reference_length(self) -> float:
        """Unit of length L of the scene [mm]."""
        return float(self.ics.attrs["reference_length"])

    @property
    def unit(self) -> float:
        """E · L [N/mm]: makes the scene's ICs dimensionless."""
        return float(self.ics.attrs["reference_E"]) * self.reference_length


@dataclass(frozen=True)
class Overlay:
    """Results of two or more scenes, and what all of them have."""

    common: Content
    results: tuple[Result, ...]


@dataclass(frozen=True)
class Curve:
    """One component of one body on a line, dimensionless: coordinate / L, IC · E · L; (n,) each."""

    along: Literal["x", "s"]
    at: Array
    values: Mapping[str, Array]  # by variant, C among them
    estimate: Array


def load(found: Sequence[Source]) -> Overlay:
    """Read the results of all scenes from their folders."""
    return Overlay(common(found), tuple(Result(source.name, *read(source.folder)) for source in found))


def curve(result: Result, line: str, body: str, component: str) -> Curve:
    """All curves of one scene in one panel."""
    on_line = result.ics.isel(point=np.flatnonzero(result.ics.line.values == line))
    found = on_line.sel(body=body, i=component[0], j=component[1])
    along: Literal["x", "s"] = "x" if np.ptp(on_line.s.values) == 0 else "s"
    values = {str(v): found.ic.sel(variant=v).values * result.unit for v in found.variant.values}
    at = on_line[along].values / result.reference_length
    return Curve(along, at, values, found.estimate.values * result.unit)


def is_mirrored(overlay: Overlay, line: str) -> bool:
    """Whether every curve of every scene repeats itself, up to its sign, on the other half of a line."""
    return all(
        _repeats(curve(result, line, body, component))
        for result, body, component in product(
            overlay.results, overlay.common.bodies, overlay.common.components
        )
    )


def _repeats(drawn: Curve) -> bool:
    if drawn.along == "x":
        return True  # all bodies and loads are symmetric in x
    sizes = np.abs(list(drawn.values.values()))
    asymmetry = np.max(np.abs(sizes - sizes[:, ::-1]))
    return np.allclose(drawn.at, -drawn.at[::-1]) and bool(asymmetry <= MIRRORED * np.max(sizes))


def worst(
    overlay: Overlay, result: Result, of: tuple[str, str], measure: Literal["error", "weight"] = "error"
) -> dict[str, float]:
    """Worst error (weight) of a body's component over the common lines, by variant; C: as estimated."""
    body, component = of
    of_component = result.errors[measure].sel(
        body=body, i=component[0], j=component[1], line=list(overlay.common.lines)
    )
    largest = of_component.max("line", skipna=False)
    return {variant: largest.sel(variant=variant).item() for variant in (*overlay.common.variants, "C")}


def vanishes(result: Result, body: str, component: str) -> bool:
    """Whether a component of C vanishes in a scene, so that its errors are shares of 0.05 max |C_nn|."""
    return bool(result.errors.vanishes.sel(body=body, i=component[0], j=component[1]))


def write_curves(overlay: Overlay, folder: Path) -> None:
    """One CSV per line: a row per scene, body, component and point, a column per variant [-]."""
    variants = (*overlay.common.variants, "C")
    for line in overlay.common.lines:
        along = curve(overlay.results[0], line, overlay.common.bodies[0], overlay.common.components[0]).along
        name = line.replace(" ", "").replace("=", "")
        with (folder / f"curves_{name}.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(["scene", "body", "component", f"{along}/L", *variants, "estimate"])
            for result, body, component in product(
                overlay.results, overlay.common.bodies, overlay.common.components
            ):
                drawn = curve(result, line, body, component)
                columns = [drawn.at, *(drawn.values[variant] for variant in variants), drawn.estimate]
                for row in np.column_stack(columns):
                    table.writerow([result.name, body, component, *(f"{value:.8g}" for value in row)])
