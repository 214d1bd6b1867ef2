"""Datasets of campaigns with known errors, and what their pages have."""

import json
from itertools import product

import numpy as np
import xarray as xr

from compare.campaigns.report.fields import find_fields, prepare
from compare.campaigns.report.page import sweep_page
from compare.report.charts import Chart
from tests.compare.pages import read_chart

VARIANTS = ["A", "Bhat", "C"]
FLANKS, RATIOS = np.linspace(0.0, 60.0, 7), np.array([1.05, 1.2, 1.5])
ESTIMATE = 0.002
SHARES = {"A": 1.0, "Bhat": 0.25}
# error = share * 0.19 * flank / 60 / (20 (ratio - 1)): linear in flank, so that crossings are exact


def error(variant, flank, ratio=1.05):
    return SHARES[variant] * 0.19 * flank / 60 / (20 * (ratio - 1))


def crossing(variant, level, ratio=1.05):
    return level * 60 * 20 * (ratio - 1) / (0.19 * SHARES[variant])


def campaign(axes, flank, ratio, **attrs):
    """A dataset of errors of sn (twice as large on the second line, as of `error`) and nn (a tenth)."""
    is_grid = attrs.get("points", "grid") == "grid"
    dims = tuple(axes) if is_grid else ("sample",)
    flank, ratio = np.broadcast_arrays(flank, ratio)
    errors = np.full((*flank.shape, 2, len(VARIANTS), 2, 3, 3), np.nan)
    for k, name in enumerate(VARIANTS):
        sn = np.full(flank.shape, ESTIMATE) if name == "C" else error(name, flank, ratio)
        for line, (column, part) in product(range(2), ((1, 1.0), (2, 0.1))):
            errors[..., 1, k, line, column, 2] = part * sn * (line + 1) / 2
        errors[..., 1, k, :, 0, 1] = 1e-15  # xs vanishes by symmetry
    errors[..., 0, :, :, :, :] = 7.0  # of another body
    coords = {
        name: (name if is_grid else "sample", values, {"long_name": f"the {name}", "units": "u"})
        for name, values in axes.items()
    }
    return xr.Dataset(
        {
            "failure": (dims, np.full(flank.shape, "", dtype=object)),
            "seconds": (dims, np.ones(flank.shape)),
            "error": ((*dims, "body", "variant", "line", "i", "j"), errors),
            "vanishes": ((*dims, "body", "i", "j"), np.zeros((*flank.shape, 2, 3, 3))),
        },
        coords=coords
        | {
            "body": ["lower", "combined"],
            "variant": VARIANTS,
            "line": ["x = 0", "s = 0"],
            "i": list("xsn"),
            "j": list("xsn"),
        },
        attrs={
            "title": "a title",
            "campaign": "the text of the campaign",
            "axes": json.dumps([{"name": name} for name in axes]),
            "keep": json.dumps(["errors"]),
            "points": "grid",
            "scenes": flank.size,
            "computed": flank.size,
            "failed": 0,
        }
        | attrs,
    )


def on_three_axes(dataset, third=(0.0, 1.0, 2.0)):
    """The dataset over a third axis, with errors that are one, two, three ... times as large."""
    names = (*dataset.seconds.dims, "third")
    thick = dataset.expand_dims(third=len(third)).transpose(*names, ...)
    factors = xr.DataArray(1.0 + np.arange(len(third)), dims="third")
    thick = thick.assign(error=(thick.error * factors).transpose(*thick.error.dims))
    attrs = {"axes": json.dumps([{"name": name} for name in names]), "scenes": thick.seconds.size}
    return thick.assign_coords(third=("third", np.asarray(third))).assign_attrs(attrs)


def with_failures(dataset, failing):
    """The dataset where some scenes, a mask over the swept dims, have failed."""
    dims = dataset.seconds.dims
    mask = xr.DataArray(failing, dims=dims)
    failed = int(mask.sum())
    broken = dataset.assign(
        error=dataset.error.where(~mask),
        vanishes=dataset.vanishes.where(~mask),
        failure=(dims, np.where(failing, "not converged", "").astype(object)),
    )
    return broken.assign_attrs(computed=dataset.attrs["scenes"] - failed, failed=failed)


def keeping(dataset, kind, variables, **coords):
    """The dataset with results of another kind than errors."""
    kept = dataset.drop_vars(["error", "vanishes"]).assign(variables).assign_coords(coords)
    return kept.assign_attrs(keep=json.dumps([kind]))


def charts(dataset):
    """The charts of the page of a dataset, by name, as the browser gets them."""
    dataset = prepare(dataset)
    sections = sweep_page(dataset, find_fields(dataset)).sections
    return {chart.name: read_chart(chart) for chart in _charts_in(sections)}


def _charts_in(blocks):
    for block in blocks:
        if isinstance(block, Chart):
            yield block
        yield from _charts_in(getattr(block, "blocks", ()))


def values_of(cell):
    """The numbers of the map in a cell of a chart, (n_across, n_up)."""
    trace = cell["traces"][0]
    return np.array(trace.get("customdata", trace["z"]), dtype=float).T
