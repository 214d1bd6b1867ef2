"""
One figure of the report, made by hand
======================================

C_sn of Geometry 1 along s against A, B and B-hat: the lower body under a normal load, on the line x =
1.6 mm. On the flank A has the wrong sign. Takes 20 s on 2 cores, seconds when run again; the picture is
OUT/one_figure.png::

    .venv/bin/python examples/one_figure.py [--out FOLDER] [--tolerance 0.005]
"""

from pathlib import Path

import xarray as xr
from cyclopts import run

import femic


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.005) -> xr.Dataset:
    """Compute to an estimated error of `tolerance`; picture and solved models go to `out`."""
    ics = femic.compute_ics(
        femic.load_pair("geometry1"),
        femic.Patch(a=0.2, b=0.2),
        [femic.line_along_s(x=1.6)],
        ["A", "B", "Bhat", "C"],
        bodies=["lower"],
        components=["sn"],
        options=femic.Options(tolerance, store=str(out / "store")),
    )
    figure = femic.plot_ics(ics, "sn")
    figure.suptitle("Geometry 1, lower body")
    figure.savefig(out / "one_figure.png", dpi=150)
    sn = ics.sel(body="lower", i="s", j="n")
    flank = sn.ic.isel(point=sn.s.values > 4.5)  # mm: where the arc of 25.5 degrees ends
    assert flank.sel(variant="A").min() > 0 > flank.sel(variant="C").max()
    return sn


if __name__ == "__main__":
    run(main, result_action="return_value")
