"""Charts of stresses below a contact: maps of sections, curves into depth, the load cycle, wear."""

from dataclasses import replace

import numpy as np
import xarray as xr

from compare.report.charts import Cell, Chart, Curve, Map, Panel
from compare.report.looks import OWN, Look, ics_looks, ics_symbol
from femic.results.stresses import HALF_SPACE, HALF_SPACE_OF_A, MEASURES, OF_STRESS, TRUE
from femic.stresses.field import von_mises
from geometries.arrays import Array

LOOKS = {TRUE: OWN["C"], HALF_SPACE: OWN["A"], HALF_SPACE_OF_A: OWN["B"]}
COMPONENTS = {"σ_xx": (0, 0), "σ_ss": (1, 1), "σ_nn": (2, 2), "σ_sn": (1, 2), "σ_xn": (0, 2), "σ_xs": (0, 1)}
COMPONENT_LOOKS = [
    Look("#0072b2"),
    Look("#e69f00"),
    Look("ink"),
    Look("#009e73", "dash"),
    Look("#d55e00", "dash"),
    Look("#cc79a7", "dash"),
]
SLIDER = "body"
SAME = 1e-9  # mm
SHORT = {TRUE: "true", HALF_SPACE: "half-space", HALF_SPACE_OF_A: "half-space of A"}  # in titles


def reference_symbol(dataset: xr.Dataset) -> str:
    """Return the symbol of the ICs whose tractions load the bodies."""
    return ics_symbol(str(dataset.attrs["reference"]))


def source_label(dataset: xr.Dataset, source: str) -> str:
    """Return in words which body and which tractions stresses are of."""
    if source == HALF_SPACE_OF_A:
        return "half-space, tractions of A"
    return f"{source}, tractions of {reference_symbol(dataset)}"


def sources(dataset: xr.Dataset) -> list[str]:
    """Return the sources; half-spaces under A's tractions only where these are others."""
    names = [str(name) for name in dataset.source.values]
    return [name for name in names if name != HALF_SPACE_OF_A or dataset.attrs["reference"] != "A"]


def bodies(dataset: xr.Dataset) -> list[str]:
    """Return the names of the bodies."""
    return [str(name) for name in dataset.body.values]


def body_fields(dataset: xr.Dataset, body: str) -> xr.Dataset:
    """Return the fields of a body: stress, estimate, perhaps dang_van, over x, s, depth."""
    names = {f"{name}_{body}": name for name in ("stress", "estimate", "dang_van")}
    places = {f"{name}_{body}": name for name in ("x", "s", "depth")}
    return dataset[[name for name in names if name in dataset]].rename(
        {name: short for name, short in (names | places).items() if name in dataset.variables}
    )


def below(dataset: xr.Dataset, body: str, place: dict[str, float]) -> xr.Dataset:
    """Return the fields of a body over x and depth, at the s of a place.

    Below the middle of the patch they go down to the deepest point.
    """
    middle = float(dataset.middle.sel(body=body))
    if abs(place["s"] - middle) >= SAME:
        return body_fields(dataset, body).sel(s=place["s"], method="nearest")
    names = {f"column_{name}_{body}": name for name in ("stress", "estimate")}
    column = dataset[list(names)].rename({**names, f"column_{body}": "depth", f"x_{body}": "x"})
    return column.assign_coords(s=middle)


def worst(dataset: xr.Dataset, body: str) -> dict[str, float]:
    """Return the place of the largest von Mises stress in a true body [mm]."""
    numbers = dataset.sel(body=body, source=TRUE)
    return {name: float(numbers[f"{name}_von_mises"]) for name in ("x", "s", "depth")}


def section_maps(dataset: xr.Dataset) -> Chart:
    """Return maps of von Mises stresses on the section of a body, a step per body and source.

    The section is that through the largest stress. Beside each map: the estimate, or the difference to the
    true body.
    """
    steps: dict[str, list[Cell]] = {}
    for body in bodies(dataset):
        section = body_fields(dataset, body).sel(x=worst(dataset, body)["x"], method="nearest")
        values = {source: _mises(section, source) for source in sources(dataset)}
        limits = (0.0, max(float(np.max(one)) for one in values.values()))
        estimate = np.asarray(section.estimate, dtype=float)
        largest = float(np.max(estimate)) if np.all(np.isfinite(estimate)) else 1.0  # without estimates
        for source, mises in values.items():
            beside = _map(section, "minus the true body", mises - values[TRUE], None)
            steps[f"{body}, {SHORT[source]}"] = [
                _map(section, f"x = {float(section.x):.2g} mm", mises, limits),
                _map(section, "estimated error", estimate, (0.0, largest))
                if source == TRUE
                else replace(beside, scale="diverging"),
            ]
    alt = "von Mises stresses on the section below the contact, and differences to the true body"
    return Chart("section", steps, 2, "body and stresses", 0.9, next(iter(steps)), alt=alt)


def _mises(fields: xr.Dataset, source: str) -> Array:
    return von_mises(np.asarray(fields.stress.sel(source=source), dtype=float))


def _map(section: xr.Dataset, title: str, values: Array, limits: tuple[float, float] | None) -> Map:
    s, depth = section.s.values, section.depth.values
    return Map(title, "s [mm]", "depth [mm]", s, depth, values, "MPa", limits=limits)


def plane_maps(dataset: xr.Dataset) -> Chart:
    """Return maps of von Mises stresses on the plane along x through the largest one, a step per body."""
    steps = {}
    for body in bodies(dataset):
        plane = below(dataset, body, worst(dataset, body))
        values = {source: _mises(plane, source) for source in sources(dataset)}
        limits = (0.0, max(float(np.max(one)) for one in values.values()))
        steps[f"{body} body"] = [
            Map(
                f"{SHORT[source]}, s = {float(plane.s):.2g} mm",
                "x [mm]",
                "depth [mm]",
                plane.x.values,
                plane.depth.values,
                mises,
                "MPa",
                limits=limits,
            )
            for source, mises in values.items()
        ]
    alt = "von Mises stresses along the rolling direction"
    return Chart("plane", steps, 3, SLIDER, 0.8, next(iter(steps)), alt=alt)


def depth_curves(dataset: xr.Dataset) -> Chart:
    """Return stresses along the line into depth below the largest von Mises stress, a step per body."""
    steps = {}
    for body in bodies(dataset):
        place, panels = worst(dataset, body), []
        line = below(dataset, body, place).sel(x=place["x"], method="nearest")
        where = f"x = {place['x']:.2g}, s = {place['s']:.2g} mm"
        for name, measure in MEASURES.items():
            symbol = OF_STRESS[name].symbol
            curves = [
                Curve(
                    source_label(dataset, source),
                    line.depth.values,
                    measure(np.asarray(line.stress.sel(source=source), dtype=float)),
                    LOOKS[source],
                    line.estimate.values if source == TRUE else None,
                )
                for source in reversed(sources(dataset))
            ]
            panels.append(Panel(f"{symbol} at {where}", "depth [mm]", f"{symbol} [MPa]", curves))
        steps[f"{body} body"] = panels
    alt = "stresses into depth in the true body and in half-spaces; bands are estimates"
    return Chart("depth", steps, 3, SLIDER, 1.0, next(iter(steps)), alt=alt)


def load_cycle(dataset: xr.Dataset) -> Chart:
    """Return stress components along x at the worst depth of each body, in the true body and half-spaces."""
    steps = {}
    for body in bodies(dataset):
        place, panels = worst(dataset, body), []
        line = below(dataset, body, place).sel(depth=place["depth"], method="nearest")
        where = f"s, depth = {float(line.s):.2g}, {float(line.depth):.2g} mm"
        for source in sources(dataset):
            stress = line.stress.sel(source=source).values
            band = line.estimate.values if source == TRUE else None
            curves = [
                Curve(name, line.x.values, stress[:, i, j], look, band)
                for (name, (i, j)), look in zip(COMPONENTS.items(), COMPONENT_LOOKS, strict=True)
            ]
            panels.append(Panel(f"{SHORT[source]}, {where}", "x [mm]", "stress [MPa]", curves))
        steps[f"{body} body"] = panels
    alt = "stress components along x: the load cycle of a particle as the contact passes"
    return Chart("cycle", steps, 3, SLIDER, 1.0, next(iter(steps)), alt=alt)


def wear_chart(dataset: xr.Dataset) -> Chart:
    """Return the depths worn along s by each law, with all ICs, and the work of friction along s."""
    worn = dataset.isel(s=(dataset.depth.max(["ics", "law"]) > 0).values)
    energy = worn.work_density.sum("x") * float(dataset.x[1] - dataset.x[0])
    panels = [
        *(
            _along_s(f"worn by a passage: {law}", "depth [nm]", worn.depth.sel(law=law))
            for law in dataset.law.values
        ),
        _along_s("work of friction along s", "energy [mJ/mm²]", energy),
    ]
    return Chart("wear", {"": panels}, 2, heights=0.9, alt="depths worn per passage along s by ICs")


def worn_chart(dataset: xr.Dataset) -> Chart:
    """Return the depths worn off both bodies along s after all passages, with all ICs."""
    worn = dataset.worn.isel(s=(dataset.worn.max(["ics", "worn_body"]) > 0).values)
    panels = [
        _along_s(f"worn off the {body} body", "depth [µm]", worn.sel(worn_body=body))
        for body in map(str, dataset.worn_body.values)
        if float(worn.sel(worn_body=body).max()) > 0
    ]
    return Chart("worn", {"": panels}, 2, heights=0.9, alt="depths worn along s after all passages by ICs")


def _along_s(title: str, up: str, values: xr.DataArray) -> Panel:
    """Return curves over s by ICs."""
    looks = ics_looks(map(str, values.ics.values))
    curves = [
        Curve(ics_symbol(n), values.s.values, values.sel(ics=n).values, look) for n, look in looks.items()
    ]
    return Panel(title, "s [mm]", up, curves)


def fatigue_maps(dataset: xr.Dataset) -> Chart:
    """Return maps of Dang Van's equivalent stress over s and depth, a step per body."""
    steps = {}
    for body in bodies(dataset):
        fields = body_fields(dataset, body)
        values = {source: np.asarray(fields.dang_van.sel(source=source)) for source in sources(dataset)}
        low = min(0.0, *(float(np.min(one)) for one in values.values()))
        limits = (low, max(float(np.max(one)) for one in values.values()))
        steps[f"{body} body"] = [_map(fields, SHORT[source], one, limits) for source, one in values.items()]
    return Chart("fatigue", steps, 3, SLIDER, 0.8, next(iter(steps)), alt="Dang Van's equivalent stress")
