"""What C of a wheel changes where its arc becomes an ellipse: Geometry 2, and the wheel of scene `rolling`.

The wheel of Geometry 2 has an arc of 10.1 mm, that of `rolling` an ellipse of semi-axes 10.15 and 10.25 mm.
Single load, offset lines of the scene, C of the wheel alone. Differences of C and the estimates of both are
shares of the component's largest value on the line. Takes 20 s, seconds when run again; the picture is
OUT/elliptic_wheel.png:

    .venv/bin/python examples/elliptic_wheel.py [--out FOLDER] [--tolerance 0.01]
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

from compare.ics.compute import Results, compute, reference_of
from compare.report.styles import STYLES
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.patches import COMPONENTS, indices

ELLIPSE = {"kind": "ellipse", "b_el": 10.15, "d_el": 10.25, "flank_inclination_deg": 60.0}
SHOWN = ("xx", "ss", "nn", "xs", "xn", "sn", "ns")
VANISHES = 1e-9  # of the largest C_nn


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.01) -> xr.Dataset:
    """Compute to estimated errors of `tolerance`; picture and solved models go to `out`."""
    store = Store(out / "store")
    found = differences(wheel({}, tolerance, store), wheel({"contour": ELLIPSE}, tolerance, store))
    print("Largest difference of C by the ellipse, and sum of both estimates, of the largest on the line:")
    for line in found.line.values:
        print(f"  {line}")
        table = found[["difference", "estimate"]].sel(line=line, drop=True).to_pandas()
        print(table.dropna().map("{:.3%}".format).T.to_string())
    draw(found).savefig(out / "elliptic_wheel.png", dpi=150)
    return found


def wheel(changes: dict[str, Any], tolerance: float, store: Store) -> Results:
    """C of the wheel of Geometry 2 with some keys of [upper] changed."""
    keys = {
        "bodies": ["upper"],
        "components": list(COMPONENTS),
        "upper": changes,
        "engine": {"tolerance": tolerance, "check": False},
    }
    return compute(load_scene("geometry2", keys), RunOptions(store=store))


def differences(arc: Results, ellipse: Results) -> xr.Dataset:
    """Shares by component and line: `difference`, the largest, and `estimate`, the largest sum of both.

    `resolved` is the largest difference over the sum of the estimates at its point. NaN for components that
    vanish on a line.
    """
    table = np.full((3, len(arc.lines), len(SHOWN)), np.nan)
    of_arc, of_ellipse = (reference_of(results, "upper") for results in (arc, ellipse))
    for number, part in enumerate(arc.lines.values()):
        for k, component in enumerate(SHOWN):
            at = (*indices(component), part)
            largest = np.max(np.abs(of_arc.ic[at]))
            if largest > VANISHES * np.max(np.abs(of_arc.ic[2, 2, part])):
                change = np.abs(of_ellipse.ic[at] - of_arc.ic[at])
                known = of_arc.estimate[at] + of_ellipse.estimate[at]
                worst = np.argmax(change)
                table[:, number, k] = (
                    change[worst] / largest,
                    np.max(known) / largest,
                    change[worst] / known[worst],
                )
    names = ("difference", "estimate", "resolved")
    dims, coords = ("line", "component"), {"line": list(arc.lines), "component": list(SHOWN)}
    return xr.Dataset({name: (dims, values) for name, values in zip(names, table, strict=True)}, coords)


def draw(found: xr.Dataset) -> Figure:
    """Differences and estimates by component, one panel per line."""
    figure = Figure(figsize=(10, 3.4), layout="constrained")
    at = np.arange(found.sizes["component"])
    for axes, line in zip(
        figure.subplots(1, found.sizes["line"], sharey=True), found.line.values, strict=True
    ):
        of_line, colour = found.sel(line=line), STYLES["C"]["color"]
        axes.bar(at - 0.2, 100 * of_line.difference, 0.4, label="ellipse less arc", color="tab:blue")
        axes.bar(at + 0.2, 100 * of_line.estimate, 0.4, label="sum of the estimates", color=colour, alpha=0.4)
        axes.set(xticks=at, xticklabels=found.component.values, title=f"C of the wheel, {line}")
        axes.set_xlim(-0.7, len(at) - 0.3)
        axes.grid(alpha=0.3, axis="y")
    figure.axes[0].set_ylabel("share of the largest on the line [%]")
    figure.axes[0].legend()
    return figure


if __name__ == "__main__":
    run(main, result_action="return_value")
