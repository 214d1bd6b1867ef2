"""
A wheel that rolls on a rail of another stiffness
=================================================

What A, B-hat, the mix and B-hat-prime miss there. The pair of scene `rolling` has Young's moduli of
ratios E_upper / E_lower, both chosen so that 1 / E_upper + 1 / E_lower stays the same: A of both then
changes in K alone. C of a body goes like 1 / E, so the store has it after the first ratio. B-hat-prime
has the K of each body, fitted to its C_xn; so has the mix in xn. Shown are creepages without force, root
mean square distances of creep-force curves to those with C over friction times load, pressures and
patches at no creepage. Takes 20 minutes; the picture is OUT/dissimilar_bodies.png, the numbers are
OUT/dissimilar_bodies.nc::

    .venv/bin/python examples/dissimilar_bodies.py [--out FOLDER] [--tolerance 0.03] [--elements 20]

.. image:: /images/dissimilar_bodies.png
   :alt: creepages without force, deviations of creep-force curves and of the largest pressure, over the ratio
"""

# sphinx_gallery_thumbnail_path = "images/dissimilar_bodies.png"

from dataclasses import replace
from pathlib import Path

import xarray as xr
from cyclopts import run
from matplotlib.figure import Figure

import femic
from compare.report.charts import Curve, Panel, simple_chart
from compare.report.looks import ics_looks, ics_symbol
from compare.report.static import picture

PAIR, PATCH = femic.load_pair("rolling"), femic.Patch(a=0.167, b=0.158)
RATIOS = (1.0, 0.1, 0.3, 3.0, 10.0)  # the first sizes the grid
ICS = ("A", "Bhat", "mix", "Bhat_prime", "C")
MOTION = femic.Rolling(load=100e3, friction=0.4)
OF_PATCH = ("p_max", "a", "b")  # numbers of the patch at no creepage
PANELS = {  # variable: label of its axis, factor
    "zero_creepage": ("creepage without force [1e-3]", 1e3),
    "rms": ("curve less the one with C, rms [% of friction load]", 100),
    "p_max_error": ("p_max over p_max with C less 1 [%]", 100),
}


def main(*, out: Path = Path("out/examples"), tolerance: float = 0.03, elements: int = 20) -> xr.Dataset:
    """Compute C to estimated errors of `tolerance`, `elements` across the patch; results go to `out`."""
    options = femic.Options(tolerance, store=str(out / "store"))
    fitted = femic.fit_bhat_prime(PAIR, PATCH, bodies=("lower", "upper"), options=options).pair
    setup, rows = femic.ContactSetup(elements), []
    for ratio in RATIOS:
        rolled = femic.solve_contact(with_ratio(fitted, ratio), MOTION, ICS, setup, options)
        setup = femic.ContactSetup(elements, grid=grid_of(rolled))
        rows.append(numbers(rolled))
    results = xr.concat(rows, xr.Variable("ratio", list(RATIOS))).sortby("ratio")
    results.to_netcdf(out / "dissimilar_bodies.nc", engine="h5netcdf")
    for name in ("zero_creepage", "rms", *(f"{name}_error" for name in OF_PATCH)):
        print(f"{name}:")
        print(results[name].to_pandas().map("{:.3g}".format))
    draw(results).savefig(out / "dissimilar_bodies.png", dpi=150)
    unlike = results.rms.sel(ratio=[0.1, 10.0])
    assert (unlike.sel(ics="Bhat_prime") < unlike.sel(ics="Bhat")).all()
    return results


def with_ratio(pair: femic.Pair, ratio: float) -> femic.Pair:
    """Return the pair with a ratio of E_upper to E_lower, and the same mean of 1 / E."""
    lower = (1 + 1 / ratio) / (1 / pair.upper.material.E + 1 / pair.lower.material.E)
    moduli = {"upper": ratio * lower, "lower": lower}
    bodies = {
        name: replace(body, material=replace(body.material, E=moduli[name]))
        for name, body in (("upper", pair.upper), ("lower", pair.lower))
    }
    return replace(pair, **bodies)


def grid_of(rolled: xr.Dataset) -> femic.Grid:
    """Return the grid on which a contact was solved."""
    sizes, attrs = rolled.sizes, rolled.attrs
    return femic.Grid(sizes["x"], sizes["s"], attrs["dx"], attrs["ds"], attrs["s_middle"])


def numbers(rolled: xr.Dataset) -> xr.Dataset:
    """Return the force over friction times load, the creepage without it, the patch, and distances to C."""
    rolled = rolled.sel(friction=MOTION.friction, drop=True)
    patch = rolled[list(OF_PATCH)].sel(xi=0.0, drop=True)
    errors = {f"{name}_error": patch[name] / patch[name].sel(ics="C") - 1 for name in OF_PATCH}
    force = rolled.F_x.drop_attrs() / (MOTION.friction * MOTION.load)
    return rolled[["zero_creepage", "rms"]].assign(force=force, **errors)


def draw(results: xr.Dataset) -> Figure:
    """Draw all ICs over the ratio of moduli."""
    looks = ics_looks(str(name) for name in results.ics.values)
    panels = [
        Panel(
            "",
            "E of the wheel over E of the rail [-]",
            label,
            [
                Curve(ics_symbol(ics), results.ratio, factor * results[name].sel(ics=ics), look)
                for ics, look in looks.items()
                if name == "zero_creepage" or ics != "C"
            ],
            log_x=True,
        )
        for name, (label, factor) in PANELS.items()
    ]
    return picture(simple_chart("dissimilar_bodies", panels))


if __name__ == "__main__":
    run(main, result_action="return_value")
