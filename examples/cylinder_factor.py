"""Does the cylinder help B_sn? A_sn fading like the line load on a cylinder, against C_sn.

In plane strain B is exact on a cylinder or in a cavity if A_sn is multiplied by (pi - |alpha|) / pi
(approx.cylinder). This script tries that factor in 3D, on both bodies of Geometries 1 and 2. Takes two
minutes on 2 cores, seconds when run again; the picture is OUT/cylinder_factor.png:

    .venv/bin/python examples/cylinder_factor.py [--out FOLDER] [--tolerance 0.01]
"""

from pathlib import Path

import numpy as np
import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

from approx.forms import FORMS
from approx.halfspace import HalfSpace
from approx.pair import Solid
from approx.rotation import rotation_between
from compare.ics.compute import Results, compute
from compare.ics.dataset import errors, to_dataset
from compare.ics.errors import measure_of
from compare.report.styles import STYLES, SYMBOLS
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.arrays import Array
from geometries.materials import one_body
from geometries.patches import Patch

SCENES, BODIES = ("geometry1", "geometry2"), ("lower", "upper", "combined")
LINE = "x = 1.6 mm"
VARIANTS = ["A", "B", "Bhat", "C"]


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.01) -> xr.DataArray:
    """Compute to estimated errors of `tolerance`; picture and solved models go to `out`."""
    figure = Figure(figsize=(11, 6), layout="constrained")
    found = []
    for name, row in zip(SCENES, figure.subplots(2, 3, sharex=True), strict=True):
        engine = {"tolerance": tolerance, "check": False}
        scene = load_scene(name, {"components": ["nn", "sn"], "engine": engine})
        results = compute(scene, RunOptions(store=Store(out / "store")))
        found.append(errors_with_factor(results))
        for axes, body in zip(row, BODIES, strict=True):
            draw(axes, results, body)
            axes.set(title=f"{name}, {body}", ylabel="sn × E L [-]", xlabel="s [mm]")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    figure.savefig(out / "cylinder_factor.png", dpi=150)
    worst = xr.concat(found, xr.Variable("scene", list(SCENES)))
    for name in SCENES:
        print(f"Errors of sn on the lines, {name}; of C estimated:")
        print(worst.sel(scene=name).stack(row=("body", "line")).T.to_pandas().map("{:.1%}".format))
    return worst


def errors_with_factor(results: Results) -> xr.DataArray:
    """Errors of sn by variant, body and line, among them "B with factor"."""
    dataset = to_dataset(results)
    worst = errors(results, dataset).error.sel(i="s", j="n", variant=VARIANTS).drop_vars(["i", "j"])
    c, extra = dataset.ic.sel(variant="C", i="s", j="n"), worst.sel(variant=["B"]).copy()
    for body in BODIES:
        off = np.zeros((3, 3, len(results.points.x)))
        off[1, 2] = with_factor(results, body) - c.sel(body=body).values
        for line, shares in measure_of(results, body).shares(off).items():
            extra.loc[{"body": body, "line": line}] = shares[1, 2]
    return xr.concat([worst, extra.assign_coords(variant=["B with factor"])], "variant")


def with_factor(results: Results, body: str) -> Array:
    """B_sn per unit load [mm/N] with A_sn, A_ns times (pi - |alpha|) / pi; combined: the sum."""
    pair, patch = results.scene.pair, results.scene.patch
    solids = {"lower": [pair.lower], "upper": [pair.upper], "combined": [pair.lower, pair.upper]}[body]
    return np.sum([faded_sn(solid, patch, results.points.x, results.points.s) for solid in solids], axis=0)


def faded_sn(solid: Solid, patch: Patch, x: Array, s: Array) -> Array:
    """The same of one body."""
    contour = solid.surface.contour
    alpha = contour.inclination(s) - contour.inclination(patch.s)
    a = HalfSpace(one_body(solid.material, solid.surface.side)).ics(patch, x, s - patch.s)
    a[[1, 2], [2, 1]] *= (np.pi - np.abs(alpha)) / np.pi
    rotation = rotation_between(solid.surface, (x, s), patch.s)
    return FORMS["B"].rotate(a, rotation)[1, 2] / patch.area


def draw(axes, results: Results, body: str) -> None:
    """Sn along s, dimensionless."""
    part, scene = results.lines[LINE], results.scene
    unit = scene.reference_E * scene.reference_length
    ics = to_dataset(results).isel(point=part).ic.sel(body=body, i="s", j="n")
    s = results.points.s[part]
    for variant in VARIANTS:
        axes.plot(s, ics.sel(variant=variant) * unit, label=SYMBOLS[variant], **STYLES[variant])
    faded = with_factor(results, body)[part] * unit
    axes.plot(s, faded, color="tab:purple", linestyle=":", linewidth=2, label="B, factor on A_sn")
    axes.grid(alpha=0.3)


if __name__ == "__main__":
    run(main, result_action="return_value")
