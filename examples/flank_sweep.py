"""How wrong A, B and B-hat become as the flanks get steeper: a sweep over their inclination.

Combined nn and sn of conformal bodies (arcs of 10 mm with flanks), worst error along s on the line
x = 1.6 mm. A_sn of equal bodies is 0, always 100 % wrong. Takes 15 s on 2 cores, seconds when run
again; the picture of both errors against the angle is OUT/flank_sweep.png:

    .venv/bin/python examples/flank_sweep.py [--out FOLDER] [--tolerance 0.05]
"""

from pathlib import Path

import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

from compare.ics.compute import compute
from compare.ics.dataset import errors, to_dataset
from compare.report.styles import MARKERS, STYLES, SYMBOLS
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene

ANGLES = [0, 15, 30, 45, 60]  # degrees
VARIANTS = ["A", "B", "Bhat", "C"]


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.05) -> xr.DataArray:
    """Compute to estimated errors of `tolerance`; picture and solved models go to `out`."""
    found = [worst_errors(flanks(angle, tolerance), Store(out / "store")) for angle in ANGLES]
    worst = xr.concat(found, xr.Variable("angle", ANGLES))
    for i in "ns":
        print(f"Errors of {i}n against the inclination of the flanks; of C estimated:")
        print(worst.sel(i=i).to_pandas().map("{:.1%}".format))
    draw(worst).savefig(out / "flank_sweep.png", dpi=150)
    return worst


def flanks(angle: float, tolerance: float) -> Scene:
    """Conformal bodies with flanks at an angle [degrees]."""
    arc = {"kind": "arc", "radius": 10.0, "flank_inclination_deg": angle}
    body = {"E": 210e3, "nu": 0.28, "contour": arc}
    table = {
        "bodies": ["combined"],
        "components": ["nn", "sn"],
        "lower": body,
        "upper": body,
        "patch": {"a": 0.2, "b": 0.2},
        "lines": [{"along": "s", "x": 1.6}],
        "engine": {"tolerance": tolerance},
    }
    return scene_from_table(table, f"flanks at {angle} degrees")


def worst_errors(scene: Scene, store: Store) -> xr.DataArray:
    """Worst errors of the combined ICs under a normal load, by direction i and variant."""
    results = compute(scene, RunOptions(store=store))
    worst = errors(results, to_dataset(results)).error.max("line")
    return worst.sel(body="combined", i=["n", "s"], j="n", variant=VARIANTS)


def draw(worst: xr.DataArray) -> Figure:
    """Errors against the angle, one panel per component."""
    figure = Figure(figsize=(9, 3.8), layout="constrained")
    for axes, i in zip(figure.subplots(1, 2), "ns", strict=True):
        for variant in VARIANTS:
            style = STYLES[variant] | {"marker": MARKERS[variant], "label": SYMBOLS[variant]}
            axes.plot(ANGLES, 100 * worst.sel(i=i, variant=variant), **style)
        axes.set(xlabel="inclination of the flanks [°]", ylabel="worst error [%]", xticks=ANGLES, ylim=0)
        axes.set(title=f"combined {i}n on x = 1.6 mm (C: estimate)")
        axes.grid(alpha=0.3)
        axes.legend(loc="center right")
    return figure


if __name__ == "__main__":
    run(main, result_action="return_value")
