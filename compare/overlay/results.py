"""Results of several scenes, with their common content and errors."""

from collections.abc import Sequence
from dataclasses import dataclass

import xarray as xr

from compare.overlay.sources import Content, Source, common, read


@dataclass(frozen=True)
class SceneResults:
    """The ICs and errors of one scene, under its name."""

    name: str
    ics: xr.Dataset
    errors: xr.Dataset


@dataclass(frozen=True)
class Overlay:
    """The results of two or more scenes, and the content that all of them have in common."""

    common: Content
    results: tuple[SceneResults, ...]


def load(sources: Sequence[Source]) -> Overlay:
    """Read the results of all sources from their folders; raises WrongInput without common content."""
    return Overlay(
        common(sources), tuple(SceneResults(source.name, *read(source.folder)) for source in sources)
    )


def worst(overlay: Overlay, result: SceneResults, body: str, component: str) -> xr.Dataset:
    """Return the worst error and weight of a component over the common lines [-], by variant; C: estimate.

    Where the component `vanishes`, errors are shares of 0.05 max |C_nn|.
    """
    line_errors = result.errors[["error", "weight", "vanishes"]].sel(
        body=body, i=component[0], j=component[1], line=list(overlay.common.lines)
    )
    return line_errors.max("line", skipna=False)
