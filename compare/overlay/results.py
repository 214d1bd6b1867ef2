"""What is overlaid: the results of several scenes, and the content and errors that they have in common."""

from collections.abc import Sequence
from dataclasses import dataclass

import xarray as xr

from compare.overlay.sources import Content, Source, common, read


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


@dataclass(frozen=True)
class Overlay:
    """The results of two or more scenes, and the content that all of them have in common."""

    common: Content
    results: tuple[Result, ...]


def load(sources: Sequence[Source]) -> Overlay:
    """Read the results of all sources from their folders; raises WrongInput without common content."""
    return Overlay(common(sources), tuple(Result(source.name, *read(source.folder)) for source in sources))


def worst(overlay: Overlay, result: Result, body: str, component: str) -> xr.Dataset:
    """The worst error and weight of a component over the common lines [-], by variant; of C, its estimate.

    Where the component vanishes, which is said, too, errors are shares of 0.05 max |C_nn|.
    """
    line_errors = result.errors[["error", "weight", "vanishes"]].sel(
        body=body, i=component[0], j=component[1], line=list(overlay.common.lines)
    )
    return line_errors.max("line", skipna=False)
