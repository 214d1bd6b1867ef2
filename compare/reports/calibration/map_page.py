"""`femic calibrate-map` writes the map as a file and a figure, and shows a table of its residuals."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.table import Table

from approx.effective import Transition
from compare.pages.styles import DASHES, RC, save
from compare.reports.calibration.figures import PROPERTIES
from compare.results.dataset import write

BY = {
    "map": ("tab:brown", "x", "fit from the map"),
    "fit": ("black", "o", "own fit"),
    "Bhat": ("tab:red", "D", "B̂"),
}


def write_map(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `calibration_map.nc` and `calibration_map.png`; returns the path of the first."""
    write(dataset, folder / "calibration_map.nc")
    save(figure(dataset), folder / "calibration_map.png")
    return folder / "calibration_map.nc"


def figure(dataset: xr.Dataset) -> Figure:
    """Draw the first fitted property at the nodes, and the residuals on the geometries left out."""
    with mpl.rc_context(RC):
        canvas = Figure(figsize=(11, 4.4), layout="constrained")
        fits, residuals = canvas.subplots(1, 2)
        _draw_fits(fits, dataset)
        _draw_residuals(residuals, dataset)
        return canvas


def _draw_fits(axes: Axes, dataset: xr.Dataset) -> None:
    name = str(dataset.parameter.values[0]).partition(".")[0]
    f0 = dataset.attrs["half_space"]
    length = dataset.attrs["reference_length"]
    r = np.linspace(0, 2.5 * length, 300)
    colours = mpl.colormaps["viridis"](np.linspace(0, 0.9, dataset.sizes["flank"]))
    for flank, colour in zip(dataset.flank.values, colours, strict=True):
        for ratio, linestyle in zip(dataset.ratio.values, DASHES * 9, strict=False):
            far, r_inf, m, n = dataset.value.sel(flank=flank, ratio=ratio).values[:4]
            label = f"{flank:g}°, ratio {ratio:g}"
            curve = Transition(far, r_inf, m, n).at(r, f0)
            axes.plot(r / length, curve, color=colour, linestyle=linestyle, label=label)
    axes.set(xlabel="r / L  [-]", ylabel=f"effective {PROPERTIES[name]}", title="fits at the nodes")
    axes.legend(fontsize=6, ncols=2)


def _draw_residuals(axes: Axes, dataset: xr.Dataset) -> None:
    for by, (colour, marker, label) in BY.items():
        rms = dataset.residual.sel(by=by, measure="rms").values
        axes.semilogy(np.arange(len(rms)), 100 * rms, marker, color=colour, mfc="none", label=label)
    names = [f"{f:g}°\n{r:.4g}" for f, r in _left_out(dataset)]
    axes.set_xticks(np.arange(len(names)), names, fontsize=6)
    axes.set(
        xlabel="flank inclination, radius ratio",
        ylabel="rms deviation from C, share of max |C|  [%]",
        title="geometries left out of the map",
    )
    axes.legend()


def table(dataset: xr.Dataset) -> Table:
    """The table of residuals on the geometries left out, as shares of max |C|."""
    residuals = Table(
        title="Geometries left out of the map: deviation from C, shares of max |C|, rms (worst)"
    )
    for heading in ("flank [deg]", "ratio", *(label for *_, label in BY.values())):
        residuals.add_column(heading, justify="right")
    for k, (flank, ratio) in enumerate(_left_out(dataset)):
        cells = [dataset.residual.isel(left_out=k).sel(by=by).values for by in BY]
        residuals.add_row(f"{flank:g}", f"{ratio:.4g}", *(f"{rms:.1%} ({worst:.0%})" for rms, worst in cells))
    return residuals


def _left_out(dataset: xr.Dataset) -> list[tuple[float, float]]:
    return list(zip(dataset.left_out_flank.values, dataset.left_out_ratio.values, strict=True))
