"""A section of one's own: a rail head through points, loaded in its gauge corner.

The section is not symmetric and the patch is not at the contact centre. Of the lower body alone, the
errors of A, B, B-hat and the estimated one of C are printed. Takes 30 s on 2 cores, seconds when run
again; the picture of the section and of nn and sn along s is OUT/custom_section.png:

    .venv/bin/python examples/custom_section.py [--out FOLDER] [--tolerance 0.02]
"""

from pathlib import Path

import numpy as np
import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

from compare.ics.compute import compute
from compare.ics.dataset import errors, to_dataset
from compare.report.curves import draw_curve
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene

STEEL = {"E": 210e3, "nu": 0.28}
VARIANTS = ["A", "B", "Bhat", "C"]


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.02) -> xr.DataArray:
    """Compute to an estimated error of `tolerance`; picture and solved models go to `out`."""
    out.mkdir(parents=True, exist_ok=True)
    scene = rail_scene(tolerance)
    results = compute(scene, RunOptions(store=Store(out / "store")))
    ics = to_dataset(results)
    draw(scene, ics.sel(body="lower", j="n")).savefig(out / "custom_section.png", dpi=150)
    worst = errors(results, ics).error.max("line").sel(body="lower", i=["n", "s"], j="n", variant=VARIANTS)
    print("Errors in direction i under the normal load; of C estimated:")
    print(worst.T.to_pandas().map("{:.1%}".format))
    return worst


def rail_head() -> np.ndarray:
    """Points (y, z) [mm] of a head with radii of 300 and 80 mm and, in the gauge corner, 13 mm."""
    s, step = np.linspace(-36, 36, 7201, retstep=True)
    curvature = 1 / np.select([abs(s) < 10.25, s < 26.2], [300, 80], 13)
    inclination = step * (np.cumsum(curvature) - np.sum(curvature[s < 0]))
    points = step * np.cumsum([np.cos(inclination), -np.sin(inclination)], axis=1)
    return (points - points[:, s == 0]).T[::150]


def rail_scene(tolerance: float) -> Scene:
    """The head with its contact centre, s = 0, at y = 26 mm: where the gauge corner begins."""
    head = {"kind": "points", "points": rail_head().round(4).tolist(), "y_centre": 26.0}
    table = {
        "bodies": ["lower"],
        "components": ["nn", "sn"],
        "variants": VARIANTS[:-1],
        "reference_length": 13.0,
        "lower": STEEL | {"contour": head},
        "upper": STEEL | {"contour": {"kind": "plane"}},  # needed, but not computed
        "patch": {"a": 0.5, "b": 0.5, "s": 3.0},
        "lines": [{"along": "s", "x": 1.6, "reach": 12.0}],
        "engine": {"tolerance": tolerance},
    }
    return scene_from_table(table, "rail_head")


def draw(scene: Scene, ics: xr.Dataset) -> Figure:
    """The section with its patch; below, nn and sn along s, the patch shaded."""
    figure = Figure(figsize=(9, 5.6), layout="constrained")
    panels = figure.subplot_mosaic([["section", "section"], ["n", "s"]], height_ratios=[1, 2.4])
    contour, L = scene.bodies["lower"].contour, scene.reference_length
    patch = scene.patch.s + scene.patch.b * np.array([-1, 1])
    section = panels.pop("section")
    section.plot(*contour.position(np.linspace(*contour.limits, 400)), "k-", label="lower body")
    section.plot(*contour.position(patch), "C3-", linewidth=5, label="patch")
    section.set(aspect="equal", xlabel="y from the contact centre [mm]", ylabel="z [mm]")
    section.legend(loc="lower center", ncols=2)
    for i, axes in panels.items():
        axes.axvspan(*patch / L, color="C3", alpha=0.15)
        draw_curve(axes, ics.s / L, ics.sel(i=i))
        axes.set(title=f"{i}n on x = 1.6 mm", xlabel=f"s / L  [-],  L = {L:g} mm", ylabel="IC · E · L  [-]")
    panels["n"].legend()
    return figure


if __name__ == "__main__":
    run(main, result_action="return_value")
