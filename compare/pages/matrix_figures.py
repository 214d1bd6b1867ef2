"""The chart of an IC matrix: the response to one loaded strip by component, and differences from C."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from approx.pair import columns as approximations
from compare.pages.ics_figures import main_body
from compare.report.charts import Cell, Chart, Curve, Map, Panel
from compare.report.looks import INK, Look, drawing_order, looks_of, symbol_of
from femic.reference.result import total
from femic.results.ics import parts_of, solids
from femic.results.matrices import SOURCE, MatrixResults, combined_columns
from geometries.patches import COMPONENTS, DIRECTIONS

MAPPED_VARIANTS = ("A", "Bhat")  # variants whose difference from C is drawn as a map
SMALLEST = 1e-9  # of the largest IC of all components: smaller ones are rounding
MOST_DRAWN = 100  # about as many lags, and strips, a map has at most
UNIT, PER_KILONEWTON = "µm/kN", 1e6  # of mm/N
LOADED = Look(INK, "", "cross")
ABSCISSAS = {"s": "s", "lag": "x"}


def response(results: MatrixResults, strip: int) -> xr.Dataset:
    """Return the response to unit loads on a strip, (..., i, j, lag, s) [µm/kN], of both bodies or the first.

    `matrix` is C of the file. Of `ic` (variant, ...), C after the discount of [BVSV] has the `estimate`.
    Rounding is 0.
    """
    scene, grid, body = results.scene, results.scene.grid, main_body(results.scene.compared)
    names = dict.fromkeys([*results.deviations[body], *MAPPED_VARIANTS])
    c = total([results.matrices[part].column(strip, SOURCE) for part in parts_of(body)])
    approximated = approximations([name for name in names if name != "C"], solids(scene)[body], grid, strip)
    ics = {name: ics / grid.area for name, ics in approximated.items()} | {"C": c.ic}
    dims = ("i", "j", "lag", "s")
    arrays = {
        "matrix": (dims, combined_columns(scene, results.matrices, strip)[body].ic),
        "ic": (("variant", *dims), np.stack(list(ics.values()))),
        "estimate": (dims, c.estimate),
    }
    coordinates = {"variant": list(ics), "i": list(DIRECTIONS), "j": list(DIRECTIONS)}
    places = {"lag": grid.lags, "s": grid.strips, "loaded": grid.strips[strip]}
    scaled = xr.Dataset(arrays, coordinates | places) * PER_KILONEWTON
    return scaled.where(abs(scaled) > _rounding(scaled), 0.0)


def _rounding(response: xr.Dataset) -> float:
    return SMALLEST * float(abs(response.matrix).max())


def chart(response: xr.Dataset) -> Chart:
    """Return curves, maps and differences from C of a response, a step per component."""
    rounding = _rounding(response)
    steps = {
        component: list(_cells(response.sel(i=component[0], j=component[1]), component, rounding))
        for component in COMPONENTS
    }
    return Chart("response", steps, 4, "component", 0.8, "nn")


def _cells(part: xr.Dataset, component: str, rounding: float) -> Iterator[Cell]:
    """Yield curves along s and along x with their differences from C, then maps."""
    minus_c = part.assign(ic=part.ic - part.ic.sel(variant="C"))
    places = {
        "s": ({"lag": 0.0}, "along s, x = 0"),
        "lag": ({"s": part.loaded}, f"along x, s = {float(part.loaded):.3g} mm"),
    }
    for across, (at, place) in places.items():
        yield _panel(part.sel(at), across, place, f"{component} [{UNIT}]", rounding)
        yield _panel(minus_c.sel(at), across, "the same minus C", f"Δ{component} [{UNIT}]", rounding)
    yield _map(part.matrix, "C", part.matrix)
    differences = minus_c.ic.sel(variant=[*MAPPED_VARIANTS])
    for name in MAPPED_VARIANTS:
        yield _map(differences.sel(variant=name), f"{symbol_of(name)} minus C", differences)
    yield _map(part.estimate, "estimated error of C", part.estimate)


def _panel(part: xr.Dataset, across: str, title: str, up: str, rounding: float) -> Panel:
    looks = looks_of(map(str, part.variant.values))
    curves = [
        Curve(
            symbol_of(name),
            part[across].values,
            part.ic.sel(variant=name).values,
            looks[name],
            part.estimate.values if name == "C" else None,
        )
        for name in drawing_order(looks)
    ]
    return Panel(title, f"{ABSCISSAS[across]} [mm]", up, curves, least=rounding)


def _map(values: xr.DataArray, title: str, scale: xr.DataArray) -> Map:
    """Return a map of values (lag, s) in the colours of a scale, thinned; cross: the loaded element."""
    drawn = values[:: _step(values.sizes["lag"]), :: _step(values.sizes["s"])]
    x, s, largest = drawn.lag.values, drawn.s.values, float(abs(scale).max()) or 1.0
    loaded = Curve("", [0.0], [float(values.loaded)], LOADED)
    limits = -largest, largest
    return Map(title, "x [mm]", "s [mm]", x, s, drawn.values, UNIT, "logarithmic", limits, curves=[loaded])


def _step(size: int) -> int:
    """Return of how many values one is drawn."""
    return -(-size // MOST_DRAWN)
