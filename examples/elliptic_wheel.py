"""
What C of a wheel changes where its arc becomes an ellipse
==========================================================

The wheel of Geometry 2 has an arc of 10.1 mm, that of scene `rolling` an ellipse of semi-axes 10.15 and
10.25 mm. Single load, offset lines of the scene, C of the wheel alone. Differences of C and the
estimates of both are shares of the component's largest value on the line. Takes 20 s, seconds when run
again; the picture is OUT/elliptic_wheel.png::

    .venv/bin/python examples/elliptic_wheel.py [--out FOLDER] [--tolerance 0.01]
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

import femic

GEOMETRY_2 = femic.load_pair("geometry2")
ELLIPSE = femic.ellipse(10.15, 10.25, 60.0)
LINES = [femic.line_along_x(s=1.6), femic.line_along_x(s=0.0), femic.line_along_s(x=1.6)]
SHOWN = ("xx", "ss", "nn", "xs", "xn", "sn", "ns")
VANISHES = 1e-9  # of the largest C_nn


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.01) -> xr.Dataset:
    """Compute to estimated errors of `tolerance`; picture and solved models go to `out`."""
    options = femic.Options(tolerance, store=str(out / "store"))
    elliptic = replace(GEOMETRY_2.upper, contour=ELLIPSE)
    result = differences(wheel(GEOMETRY_2.upper, options), wheel(elliptic, options))
    print("Largest difference of C by the ellipse, and sum of both estimates, of the largest on the line:")
    for line in result.line.values:
        print(f"  {line}")
        table = result[["difference", "estimate"]].sel(line=line, drop=True).to_pandas()
        print(table.dropna().map("{:.3%}".format).T.to_string())
    draw(result).savefig(out / "elliptic_wheel.png", dpi=150)
    assert result.difference.max() < 0.005
    return result


def wheel(body: femic.Body, options: femic.Options) -> xr.Dataset:
    """Return C of a wheel on the rail of Geometry 2, and its estimate, at the points of the lines."""
    pair, patch = replace(GEOMETRY_2, upper=body), femic.Patch(a=0.167, b=0.158)
    ics = femic.compute_ics(pair, patch, LINES, ["C"], bodies=["upper"], options=options)
    return ics[["ic", "estimate"]].sel(variant="C", body="upper")


def differences(arc: xr.Dataset, ellipse: xr.Dataset) -> xr.Dataset:
    """Return the largest `difference`, and the largest sum of both `estimate`s, by component and line.

    They are shares; `resolved` is the largest difference over the sum of the estimates at its point. NaN for
    components that vanish on a line.
    """
    rows = [
        xr.concat([_of_component(arc, ellipse, line, component) for component in SHOWN], "component")
        for line in dict.fromkeys(arc.line.values)
    ]
    coords = {"line": list(dict.fromkeys(arc.line.values)), "component": list(SHOWN)}
    return xr.concat(rows, "line").assign_coords(coords)


def _of_component(arc: xr.Dataset, ellipse: xr.Dataset, line: str, component: str) -> xr.Dataset:
    """Return the shares of a component on a line."""
    of_arc, of_ellipse = (c.isel(point=np.flatnonzero(c.line.values == line)) for c in (arc, ellipse))
    largest_nn = float(np.abs(of_arc.ic.sel(i="n", j="n")).max())
    at = {"i": component[0], "j": component[1]}
    c, change = of_arc.ic.sel(at), np.abs(of_ellipse.ic.sel(at) - of_arc.ic.sel(at))
    known, largest = of_arc.estimate.sel(at) + of_ellipse.estimate.sel(at), float(np.abs(c).max())
    if largest <= VANISHES * largest_nn:
        return xr.Dataset({"difference": np.nan, "estimate": np.nan, "resolved": np.nan})
    worst = int(np.argmax(change.values))
    values = change[worst] / largest, known.max() / largest, change[worst] / known[worst]
    names = ("difference", "estimate", "resolved")
    return xr.Dataset({name: float(value) for name, value in zip(names, values, strict=True)})


def draw(result: xr.Dataset) -> Figure:
    """Draw differences and estimates by component, one panel per line."""
    figure = Figure(figsize=(10, 3.4), layout="constrained")
    at = np.arange(result.sizes["component"])
    for axes, line in zip(
        figure.subplots(1, result.sizes["line"], sharey=True), result.line.values, strict=True
    ):
        of_line = result.sel(line=line)
        axes.bar(at - 0.2, 100 * of_line.difference, 0.4, label="ellipse less arc", color="tab:blue")
        axes.bar(
            at + 0.2, 100 * of_line.estimate, 0.4, label="sum of the estimates", color="black", alpha=0.4
        )
        axes.set(xticks=at, xticklabels=result.component.values, title=f"C of the wheel, {line}")
        axes.set_xlim(-0.7, len(at) - 0.3)
        axes.grid(alpha=0.3, axis="y")
    figure.axes[0].set_ylabel("share of the largest on the line [%]")
    figure.axes[0].legend()
    return figure


if __name__ == "__main__":
    run(main, result_action="return_value")
