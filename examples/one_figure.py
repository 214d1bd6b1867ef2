"""One figure of the report, made by hand: C_sn of Geometry 1 along s against A, B and B-hat.

The lower body under a normal load, on the line x = 1.6 mm. On the flank A has the wrong sign. Takes
20 s on 2 cores, seconds when run again; the picture is OUT/one_figure.png:

    .venv/bin/python examples/one_figure.py [--out FOLDER] [--tolerance 0.005]
"""

from pathlib import Path

import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

from compare.ics.compute import compute
from compare.ics.dataset import to_dataset
from compare.report.curves import draw_curve
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene

ASKED = {
    "bodies": ["lower"],
    "components": ["sn"],
    "variants": ["A", "B", "Bhat"],
    "lines": [{"along": "s", "x": 1.6}],
}


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.005) -> xr.Dataset:
    """Compute to an estimated error of `tolerance`; picture and solved models go to `out`."""
    scene = load_scene("geometry1", ASKED | {"engine": {"tolerance": tolerance, "check": False}})
    ics = to_dataset(compute(scene, RunOptions(store=Store(out / "store"))))
    sn = ics.sel(body="lower", i="s", j="n")
    draw(sn).savefig(out / "one_figure.png", dpi=150)
    return sn


def draw(sn: xr.Dataset) -> Figure:
    """C with its error band, and the approximations: s in multiples of L, ICs in multiples of 1 / (E L)."""
    L, E = sn.reference_length, sn.reference_E
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.subplots()
    draw_curve(axes, sn.s / L, sn)
    axes.set(
        title="Geometry 1, lower body, x = 1.6 mm",
        xlabel=f"s / L  [-],  L = {L:g} mm",
        ylabel=f"IC$_{{sn}}$ · E · L  [-],  E = {E / 1000:g} GPa",
    )
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    run(main, result_action="return_value")
