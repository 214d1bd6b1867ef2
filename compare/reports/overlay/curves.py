"""Overlay of the results of several scenes: curves and errors of all that they have in common."""

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

MIRRORED = 1e-6  # largest asymmetry of a mirrored curve, as a share of the largest value on its line


@dataclass(frozen=True)
class Result:
    """The ICs and errors of one scene, under its name."""

    name: str
    ics: xr.Dataset
    errors: xr.Dataset

    @property
    def reference_length(self) -> float:
        """The reference length L of the scene [mm]."""
        return float(self.ics.attrs["reference_length"])

    @property
    def unit(self) -> float:
        """E · L [N/mm], the factor that makes the scene's ICs [mm/N] dimensionless."""
        return float(self.ics.attrs["reference_E"]) * self.reference_length


@dataclass(frozen=True)
class Overlay:
    """The results of two or more scenes, and the content that all of them have in common."""

    common: Content
    results: tuple[Result, ...]


@dataclass(frozen=True)
class Curve:
    """One component of one body along a line, dimensionless.

    `at` (n,) has coordinates over L, `values` and `estimate` (n,) have ICs and the estimate of C times E · L.
    """

    along: Literal["x", "s"]
    at: Array
    values: Mapping[str, Array]  # by variant, C among them
    estimate: Array


def load(sources: Sequence[Source]) -> Overlay:
    """Read the results of all sources from their folders; raises WrongInput without common content."""
    return Overlay(common(sources), tuple(Result(source.name, *read(source.folder)) for source in sources))


def curve(result: Result, line: str, body: str, component: str) -> Curve:
    """The curves of all variants of one scene for one component of one body along a line, dimensionless."""
    on_line = result.ics.isel(point=np.flatnonzero(result.ics.line.values == line))
    component_ics = on_line.sel(body=body, i=component[0], j=component[1])
    along: Literal["x", "s"] = "x" if np.ptp(on_line.s.values) == 0 else "s"
    values = {
        str(variant): component_ics.ic.sel(variant=variant).values * result.unit
        for variant in component_ics.variant.values
    }
    coordinates = on_line[along].values / result.reference_length
    return Curve(along, coordinates, values, component_ics.estimate.values * result.unit)


def is_mirrored(overlay: Overlay, line: str) -> bool:
    """Whether the two halves of a line have the same values, up to the sign, in all curves of all scenes."""
    return all(
        _repeats(curve(result, line, body, component))
        for result, body, component in product(
            overlay.results, overlay.common.bodies, overlay.common.components
        )
    )


def _repeats(scene_curve: Curve) -> bool:
    if scene_curve.along == "x":
        return True  # every body and every load is symmetric in x
    sizes = np.abs(list(scene_curve.values.values()))
    asymmetry = np.max(np.abs(sizes - sizes[:, ::-1]))
    return np.allclose(scene_curve.at, -scene_curve.at[::-1]) and bool(asymmetry <= MIRRORED * np.max(sizes))


def worst(
    overlay: Overlay,
    result: Result,
    body_component: tuple[str, str],
    measure: Literal["error", "weight"] = "error",
) -> dict[str, float]:
    """The worst error (or weight) of a component over the common lines [-], by variant; of C, its estimate.

    `body_component` names the body and the component.
    """
    body, component = body_component
    line_errors = result.errors[measure].sel(
        body=body, i=component[0], j=component[1], line=list(overlay.common.lines)
    )
    largest = line_errors.max("line", skipna=False)
    return {variant: largest.sel(variant=variant).item() for variant in (*overlay.common.variants, "C")}


def vanishes(result: Result, body: str, component: str) -> bool:
    """Whether a component of C vanishes in a scene; its errors are then shares of 0.05 max |C_nn|."""
    return bool(result.errors.vanishes.sel(body=body, i=component[0], j=component[1]))


def write_curves(overlay: Overlay, folder: Path) -> None:
    """Write one CSV file per line, with a row per scene, body, component and point.

    Each variant has a column; all values are dimensionless.
    """
    variants = (*overlay.common.variants, "C")
    for line in overlay.common.lines:
        along = curve(overlay.results[0], line, overlay.common.bodies[0], overlay.common.components[0]).along
        file_name = line.replace(" ", "").replace("=", "")
        with (folder / f"curves_{file_name}.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(["scene", "body", "component", f"{along}/L", *variants, "estimate"])
            for result, body, component in product(
                overlay.results, overlay.common.bodies, overlay.common.components
            ):
                scene_curve = curve(result, line, body, component)
                columns = [
                    scene_curve.at,
                    *(scene_curve.values[variant] for variant in variants),
                    scene_curve.estimate,
                ]
                for row in np.column_stack(columns):
                    table.writerow([result.name, body, component, *(f"{value:.8g}" for value in row)])
