"""The frame of a campaign's dataset: dims and coordinates of the swept axes, attributes."""

import json
from collections.abc import Iterable
from typing import Any

import numpy as np
import tomlkit
import xarray as xr

from femic.cache.digests import versions
from femic.campaigns.dataset.integrity import SCENE_VARIABLES
from femic.campaigns.files.campaign import Campaign, SweptAxis
from femic.campaigns.files.keys import is_number
from femic.scenes.errors import BadScene

SAMPLE = "sample"


def swept_dims(campaign: Campaign) -> tuple[str, ...]:
    """Return the dims of the campaign: its axes on a grid, else `SAMPLE`."""
    return tuple(axis.name for axis in campaign.axes) if campaign.is_grid else (SAMPLE,)


def swept_coords(campaign: Campaign) -> dict[str, Any]:
    """Return the values of the axes as coordinates."""
    points = () if campaign.is_grid else zip(*campaign.listed, strict=True)
    columns = [axis.values for axis in campaign.axes] if campaign.is_grid else points
    return {
        axis.name: (
            axis.name if campaign.is_grid else SAMPLE,
            _values(values),
            {"long_name": axis.label} | ({"units": axis.unit} if axis.unit else {}),
        )
        for axis, values in zip(campaign.axes, columns, strict=True)
    }


def require_other_names(campaign: Campaign, names: Iterable[str]) -> None:
    """Raise BadScene where an axis has the name of a result or of one of its dims."""
    reserved = {*names, *SCENE_VARIABLES, SAMPLE}
    for axis in campaign.axes:
        if axis.name in reserved:
            raise BadScene(
                f"sweep.{axis.name}: results have something of that name, too: rename the axis, such as "
                f"{axis.name}_swept"
            )


def attributes_of(campaign: Campaign, code: str) -> dict[str, str | int]:
    """Return the attributes that do not depend on results; `code`: the digest of the code of these."""
    return {
        "title": campaign.title,
        "campaign": campaign.text,
        "table": tomlkit.dumps(campaign.table),
        "axes": json.dumps([_described(axis) for axis in campaign.axes]),
        "keep": json.dumps(campaign.keep),
        "points": "grid" if campaign.is_grid else "samples",
        "scenes": campaign.size,
        "code": code,
        "versions": json.dumps(versions()),
    }


def continues(campaign: Campaign, code: str, earlier: xr.Dataset) -> bool:
    """Whether an earlier dataset is of this campaign and code, with the first values of each axis."""
    now, coords = attributes_of(campaign, code), xr.Dataset(coords=swept_coords(campaign))
    return (
        all(earlier.attrs[name] == now[name] for name in ("table", "keep", "points", "code"))
        and _keys_of(earlier.attrs["axes"]) == _keys_of(str(now["axes"]))
        and all(
            np.array_equal(earlier[axis.name].values, coords[axis.name].values[: earlier[axis.name].size])
            for axis in campaign.axes
        )
    )


def with_free_text(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset with coordinates of text of any length, the only text that zarr has specified."""
    return dataset.assign_coords(
        {name: values.astype(object) for name, values in dataset.coords.items() if values.dtype.kind == "U"}
    )


def _values(values: Iterable[Any]) -> np.ndarray[Any, Any]:
    """Return values of an axis: numbers, or else text."""
    listed = list(values)
    return np.array(listed, dtype=float) if all(map(is_number, listed)) else np.array(list(map(str, listed)))


def _described(axis: SweptAxis) -> dict[str, Any]:
    return {
        "name": axis.name,
        "label": axis.label,
        "unit": axis.unit,
        "keys": dict(axis.factors),
        "spacing": axis.spacing,
    }


def _keys_of(axes: str) -> list[tuple[str, dict[str, float | None]]]:
    """Return names and keys of axes from their attribute."""
    return [(axis["name"], axis["keys"]) for axis in json.loads(axes)]
