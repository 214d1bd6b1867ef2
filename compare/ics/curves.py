"""Curves of ICs along lines, drawn from the dataset of `compare.ics.dataset.to_dataset`."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from compare.report import static
from compare.report.charts import Chart, Curve, Panel, chart_of, marked
from compare.report.looks import Look, drawing_order, looks_of, symbol_of
from femic.scenes.scene import Scene
from geometries.arrays import Array, Mask
from geometries.patches import OffsetLine

INVISIBLE = 1e-9  # dimensionless IC below which a curve is rounding
ESTIMATES = {"C": "estimate", "C_solid": "estimate_solid"}  # variables with the errors of both engines
MOST_COLUMNS = 4


@dataclass(frozen=True)
class Units:
    """Factors of lengths [mm] and of ICs [mm/N] in a chart, and how its axes name them."""

    length: float
    ic: float
    across: str
    up: str
    rounding: float  # IC that is shown as zero


def absolute(dataset: xr.Dataset) -> Units:
    """Return the units of a scene's own page."""
    ic = 1e6
    return Units(1.0, ic, " [mm]", " [µm/kN]", INVISIBLE * ic / _unit(dataset))


def dimensionless(dataset: xr.Dataset) -> Units:
    """Return the units in which ICs of bodies of other sizes and moduli compare."""
    return Units(1 / dataset.reference_length, _unit(dataset), " / L  [-]", " · E · L  [-]", INVISIBLE)


def _unit(dataset: xr.Dataset) -> float:
    return float(dataset.reference_E * dataset.reference_length)


def chart(scene: Scene, dataset: xr.Dataset) -> Chart:
    """Return the ICs of a scene, a step per component: curves and differences from C, then other bodies."""
    first, *others = combined_first(scene.compared)
    units, steps = absolute(dataset), {}
    for component in scene.components:
        curves_of_first = _panels(scene, dataset, component, [first], units)
        differences = map(of_differences, _panels(scene, minus_c(dataset), component, [first], units))
        curves_of_others = _panels(scene, dataset, component, others, units)
        steps[component] = [*curves_of_first, *differences, *curves_of_others]
    return by_component(steps, len(scene.lines))


def by_component(steps: Mapping[str, Sequence[Panel]], lines: int) -> Chart:
    """Return a chart of panels by component, a column per line; it starts with nn."""
    start = "nn" if "nn" in steps else next(iter(steps))
    columns = min(max(2, lines), MOST_COLUMNS)
    return Chart("curves", steps, columns, "component", heights=0.75, start=start)


def combined_first(bodies: Iterable[str]) -> list[str]:
    """Return bodies in their order, but both together first."""
    return sorted(bodies, key=lambda body: body != "combined")


def main_body(bodies: Iterable[str]) -> str:
    """Return the body that pages speak of: both together, or else the first."""
    return combined_first(bodies)[0]


def curves(scene: Scene, dataset: xr.Dataset, component: str) -> Figure:
    """Return a figure of one component, dimensionless: a row per body, a column per line of the scene."""
    panels = list(_panels(scene, dataset, component, scene.compared, dimensionless(dataset)))
    return static.picture(_chart(panels, dataset, len(scene.lines)))


def _panels(
    scene: Scene, dataset: xr.Dataset, component: str, bodies: Sequence[str], units: Units
) -> Iterator[Panel]:
    """Yield the panels of bodies along the lines of a scene, without halves that symmetry repeats."""
    for body, line in product(bodies, scene.lines):
        part = along_line(dataset, line.name, body, component, units).isel(point=shown_half(scene, line))
        marks = joints(scene, part["at"].values, units) if line.along == "s" else ()
        yield replace(_panel(part, component, units), title=f"{body}, {line.name}", marks=marks)


def chart_in(dataset: xr.Dataset, component: str) -> Chart:
    """Return a chart of one component of labelled ICs, dimensionless: a row per body, a column per line."""
    lines, units = list(dict.fromkeys(dataset.line.values)), dimensionless(dataset)
    panels = [
        replace(
            _panel(along_line(dataset, line, body, component, units), component, units),
            title=f"{component}, {body}, {line}",
        )
        for body, line in product(dataset.body.values, lines)
    ]
    return _chart(panels, dataset, len(lines))


def _chart(panels: Sequence[Panel], dataset: xr.Dataset, columns: int) -> Chart:
    """Return a chart of panels, which name the length that makes abscissas dimensionless."""
    length = f",  L = {dataset.reference_length:g} mm"
    return chart_of("curves", [replace(panel, across=panel.across + length) for panel in panels], columns)


def along_line(dataset: xr.Dataset, line: str, body: str, component: str, units: Units) -> xr.Dataset:
    """Return a component of a body along a line, and its estimates, in units over the coordinate `at`."""
    on_line = dataset.isel(point=np.flatnonzero(dataset.line.values == line))
    along = "x" if np.ptp(on_line.s.values) == 0 else "s"
    curve = on_line.sel(body=body, i=component[0], j=component[1])
    return _scaled(curve, units.length * on_line[along].values, units).assign_attrs(
        across=f"{along}{units.across}"
    )


def _scaled(curve: xr.Dataset, at: ArrayLike, units: Units) -> xr.Dataset:
    names = [name for name in ("ic", *ESTIMATES.values()) if name in curve]
    return (curve[names] * units.ic).assign_coords(at=("point", np.asarray(at)))


def _panel(part: xr.Dataset, component: str, units: Units) -> Panel:
    """Return the panel of ICs of `along_line`; those that were not computed are left out."""
    names = [str(name) for name in part.variant.values]
    looks = looks_of(names)
    drawn = [name for name in drawing_order(names) if not part.ic.sel(variant=name).isnull().all()]
    return Panel(
        "",
        part.attrs.get("across", ""),
        f"{component}{units.up}",
        [_curve(part, name, looks[name]) for name in drawn],
        least=units.rounding,
    )


def _curve(part: xr.Dataset, name: str, look: Look) -> Curve:
    """Return a curve, with its estimate where it has one; C of the other engine as a few marks."""
    values, estimate = part.ic.sel(variant=name).values, ESTIMATES.get(name, "")
    band = part[estimate].values if estimate in part else None
    return marked(Curve(symbol_of(name), part["at"].values, values, look, band))


def minus_c(dataset: xr.Dataset) -> xr.Dataset:
    """Return the differences of ICs from C; what remains of C is its estimate."""
    return dataset.assign(ic=dataset.ic - dataset.ic.sel(variant="C", drop=True))


def of_differences(panel: Panel) -> Panel:
    """Return a panel of curves of `minus_c` with its title."""
    return replace(panel, title=f"{panel.title}: minus C", up=f"Δ{panel.up}")


def draw_curve(axes: Axes, at: ArrayLike, curve: xr.Dataset) -> None:
    """Draw one component on one line, dimensionless: C with its error band, and every approximation.

    `curve` is a part of the dataset of `compare.ics.dataset.to_dataset` with the dims variant and point,
    drawn against the abscissas `at`.
    """
    units = dimensionless(curve)
    static.draw_panel(axes, _panel(_scaled(curve, at, units), "", units))


def joints(scene: Scene, at: Array, units: Units) -> tuple[float, ...]:
    """Return abscissas of the joints of arcs and flanks, within the range of `at`."""
    places = {units.length * round(s, 9) for body in scene.bodies.values() for s in body.contour.joints}
    return tuple(sorted(place for place in places if at[0] <= place <= at[-1]))


def shown_half(scene: Scene, line: OffsetLine) -> Mask:
    """Return which points of a line are shown, (n,): without the half that symmetry repeats."""
    mirrored = scene.patch.s == 0 and all(body.contour.symmetric for body in scene.bodies.values())
    symmetric = line.along == "x" or mirrored
    return line.running >= (0 if symmetric else -np.inf)
