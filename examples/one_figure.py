"""One figure of the report, made by hand: C_sn of Geometry 1 along s against A, B and B-hat.

The lower body under a normal load, on the line x = 1.6 mm. On the flank A has the wrong sign. Takes
20 s on 2 cores, seconds when run again; the picture is OUT/one_figure.png:

    .venv/bin/python examples/one_figure.py [--out FOLDER] [--tolerance 0.005]
"""

from pathlib import Path

import xarray as xr
from cyclopts import run
from joblib import Memory
from matplotlib.figure import Figure

from compare.dataset import to_dataset
from compare.figures import STYLES, SYMBOLS
from compare.pipeline import compute
from compare.scenes import read_scene, scene_from_table, scene_path
from femic.provenance import code_digest

LINE = {"along": "s", "x": 1.6}


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.005) -> xr.Dataset:
    """Compute to an estimated error of `tolerance`; picture and solved models go to `out`."""
    _, table = read_scene(scene_path("geometry1"))
    table |= {"bodies": ["lower"], "components": ["sn"], "lines": [LINE], "engine": {"tolerance": tolerance}}
    scene = scene_from_table(table, "geometry1")
    memory = Memory(out / "solved" / code_digest(), verbose=0)
    ics = to_dataset(compute(scene, workers=2, memory=memory))
    sn = ics.sel(body="lower", i="s", j="n")
    draw(sn).savefig(out / "one_figure.png", dpi=150)
    return sn


def draw(sn: xr.Dataset) -> Figure:
    """C with its error band, and the approximations: s in multiples of L, ICs in multiples of 1 / (E L)."""
    L, E = sn.reference_length, sn.reference_E
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.subplots()
    c = sn.ic.sel(variant="C")
    low, high = ((c + sign * sn.estimate) * E * L for sign in (-1, 1))
    axes.fill_between(sn.s / L, low, high, color="black", alpha=0.2, linewidth=0, label="C ± estimate")
    for variant in ("C", "A", "B", "Bhat"):
        curve = sn.ic.sel(variant=variant) * E * L
        axes.plot(sn.s / L, curve, label=SYMBOLS[variant], **STYLES[variant])
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
