"""
How wrong approximations become as the flanks get steeper
=========================================================

A sweep of A, B and B-hat over the inclination of the flanks. Combined nn and sn of conformal bodies
(arcs of 10 mm with flanks), worst error along s on the line x = 1.6 mm. A_sn of equal bodies is 0,
always 100 % wrong. Takes 15 s on 2 cores, seconds when run again; the picture of both errors against the
angle is OUT/flank_sweep.png::

    .venv/bin/python examples/flank_sweep.py [--out FOLDER] [--tolerance 0.05]
"""

from pathlib import Path

import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

import femic
from compare.report.charts import Curve, Panel, simple_chart
from compare.report.looks import ics_looks, ics_symbol
from compare.report.static import picture

ANGLES = [0, 15, 30, 45, 60]  # degrees
VARIANTS = ["A", "B", "Bhat", "C"]
STEEL = femic.Material(E=210e3, nu=0.28)


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.05) -> xr.DataArray:
    """Compute to estimated errors of `tolerance`; picture and solved models go to `out`."""
    options = femic.Options(tolerance, store=str(out / "store"))
    worst = xr.concat([worst_errors(angle, options) for angle in ANGLES], xr.Variable("angle", ANGLES))
    for i in "ns":
        print(f"Errors of {i}n against the inclination of the flanks; of C estimated:")
        print(worst.sel(i=i).to_pandas().map("{:.1%}".format))
    draw(worst).savefig(out / "flank_sweep.png", dpi=150)
    assert 0.08 < worst.sel(angle=60, i="n", variant="A") < 0.10
    return worst


def worst_errors(angle: float, options: femic.Options) -> xr.DataArray:
    """Return the worst errors under a normal load, by direction i and variant, with flanks at an angle."""
    body = femic.Body(femic.arc(10.0, angle), STEEL)
    ics = femic.compute_ics(
        femic.Pair(body, body),
        femic.Patch(a=0.2, b=0.2),
        [femic.line_along_s(x=1.6)],
        VARIANTS,
        bodies=["combined"],
        components=["nn", "sn"],
        options=options,
    )
    return femic.compare_ics(ics).error.max("line").sel(body="combined", i=["n", "s"], j="n")


def draw(worst: xr.DataArray) -> Figure:
    """Draw the errors against the angle, one panel per component."""
    panels = [
        Panel(
            f"combined {i}n on x = 1.6 mm (C: estimate)",
            "inclination of the flanks [°]",
            "worst error [%]",
            [
                Curve(ics_symbol(variant), ANGLES, 100 * worst.sel(i=i, variant=variant), look)
                for variant, look in ics_looks(VARIANTS).items()
            ],
        )
        for i in "ns"
    ]
    return picture(simple_chart("flank_sweep", panels))


if __name__ == "__main__":
    run(main, result_action="return_value")
