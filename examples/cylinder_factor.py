"""
An approximation of your own: does the cylinder help B_sn?
==========================================================

In plane strain B is exact on a cylinder or in a cavity if A_sn is multiplied by (pi - abs(alpha)) / pi,
where A_sn fades like the line load on a cylinder (approx.cylinder). This script registers B with that
factor as an approximation of its own, and compares it with C_sn in 3D on both bodies of Geometries 1 and
2. Takes two minutes on 2 cores, seconds when run again; the picture is OUT/cylinder_factor.png::

    .venv/bin/python examples/cylinder_factor.py [--out FOLDER] [--tolerance 0.01]
"""

from pathlib import Path

import numpy as np
import xarray as xr
from cyclopts import run

import femic
from approx.forms import FORMS, Form, Rotation
from approx.variants import MIRRORS, VARIANTS, Variant
from compare.report.charts import Curve, Panel, simple_chart
from compare.report.looks import ics_looks, ics_symbol
from compare.report.static import picture
from geometries.arrays import Array

PATCHES = {"geometry1": femic.Patch(0.2, 0.2), "geometry2": femic.Patch(0.167, 0.158)}
LINES = [femic.line_along_x(s=1.6), femic.line_along_x(s=0.0), femic.line_along_s(x=1.6)]
FADED = "B_faded"
ICS = ["A", "B", "Bhat", FADED, "C"]


def faded(a: Array, rotation: Rotation) -> Array:
    """Return B whose A_sn, A_ns are multiplied by (pi - |alpha|) / pi, alpha from load to observer."""
    alpha = np.minimum(rotation.angle, 2 * np.pi - rotation.angle)
    ics = np.array(a)
    ics[[1, 2], [2, 1]] *= (np.pi - alpha) / np.pi
    return FORMS["B"].rotate(ics, rotation)


FORMS[FADED] = Form(faded)
VARIANTS[FADED] = Variant("B, factor on A_sn", "B with the cylinder's factor", MIRRORS)


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.01) -> xr.DataArray:
    """Compute to estimated errors of `tolerance`; picture and solved models go to `out`."""
    errors, panels, options = [], [], femic.Options(tolerance, store=str(out / "store"))
    for name, patch in PATCHES.items():
        pair = femic.load_pair(name)
        ics = femic.compute_ics(pair, patch, LINES, ICS, components=["nn", "sn"], options=options)
        errors.append(femic.compare_ics(ics).error.sel(i="s", j="n", drop=True))
        panels += [
            panel_of_sn(f"{name}, {body}", ics.sel(body=body, i="s", j="n"))
            for body in ("lower", "upper", "combined")
        ]
    picture(simple_chart("cylinder_factor", panels)).savefig(out / "cylinder_factor.png", dpi=150)
    worst = xr.concat(errors, xr.Variable("scene", list(PATCHES)))
    for name in PATCHES:
        print(f"Errors of sn on the lines, {name}; of C estimated:")
        print(worst.sel(scene=name).stack(row=("body", "line")).T.to_pandas().map("{:.1%}".format))
    combined = worst.sel(scene="geometry1", body="combined")  # of equal bodies the factor cancels
    np.testing.assert_allclose(combined.sel(variant=FADED), combined.sel(variant="B"), rtol=1e-12)
    return worst


def panel_of_sn(title: str, sn: xr.Dataset) -> Panel:
    """Return the curves of sn along s on x = 1.6 mm, dimensionless."""
    on_line = sn.isel(point=sn.line.values == "x = 1.6 mm")
    unit = sn.reference_E * sn.reference_length
    curves = [
        Curve(ics_symbol(variant), on_line.s, on_line.ic.sel(variant=variant) * unit, look)
        for variant, look in ics_looks(ICS).items()
    ]
    return Panel(title, "s [mm]", "sn × E L [-]", curves)


if __name__ == "__main__":
    run(main, result_action="return_value")
