"""Charts of stresses below a contact: maps of sections, curves into depth, the load cycle, wear."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from compare.pages.stress_answers import bodies, source_label, sources
from compare.report.charts import Cell, Chart, Curve, Map, Panel
from compare.report.looks import OWN, Look, looks_of, symbol_of
from femic.results.contact import ics_of
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


def of_body(dataset: xr.Dataset, body: str) -> xr.Dataset:
    """Return the fields of a body: stress, estimate, perhaps dang_van, over x, s, depth."""
    names = {f"{name}_{body}": name for name in ("x", "s", "depth", "stress", "estimate", "dang_van")}
    present = {name: short for name, short in names.items() if name in dataset.variables}
    fields = dataset[[name for name in present if name in dataset.data_vars]]
    return fields.rename({name: present[name] for name in present if name in fields.variables})


def column_of(dataset: xr.Dataset, body: str) -> xr.Dataset:
    """Return the fields of a body below the middle of the patch, over x and depth, to the deepest point."""
    names = {f"column_{name}_{body}": name for name in ("stress", "estimate")}
    fields = dataset[list(names)].rename({**names, f"column_{body}": "depth", f"x_{body}": "x"})
    return fields.assign_coords(s=float(dataset.middle.sel(body=body)))


def below(dataset: xr.Dataset, body: str, place: dict[str, float]) -> xr.Dataset:
    """Return the fields of a body over x and depth, at the s of a place."""
    if abs(place["s"] - float(dataset.middle.sel(body=body))) < SAME:
        return column_of(dataset, body)
    return of_body(dataset, body).sel(s=place["s"], method="nearest")


def worst(dataset: xr.Dataset, body: str) -> dict[str, float]:
    """Return the place of the largest von Mises stress in a true body [mm]."""
    numbers = dataset.sel(body=body, source=TRUE)
    return {name: float(numbers[f"{name}_von_mises"]) for name in ("x", "s", "depth")}


def section_maps(dataset: xr.Dataset) -> Chart:
    """Return maps of von Mises stresses on the section of a body, a step per body and source."""
    steps = {}
    for body in bodies(dataset):
        section = _section(dataset, body)
        values = {source: _mises(section, source) for source in sources(dataset)}
        limits = (0.0, max(float(np.max(one)) for one in values.values()))
        for source, mises in values.items():
            title = f"{body}, {SHORT[source]}"
            steps[title] = [
                _map(section, f"x = {float(section.x):.2g} mm", mises, limits),
                *_difference(section, mises - values[TRUE], source),
            ]
    alt = "von Mises stresses on the section below the contact, and differences to the true body"
    start = next(iter(steps))
    return Chart("section", steps, 2, "body and stresses", 0.9, start, alt=alt)


def _section(dataset: xr.Dataset, body: str) -> xr.Dataset:
    """Return the fields of a body on the section through its largest von Mises stress."""
    return of_body(dataset, body).sel(x=worst(dataset, body)["x"], method="nearest")


def _mises(fields: xr.Dataset, source: str) -> Array:
    return von_mises(np.asarray(fields.stress.sel(source=source), dtype=float))


def _map(section: xr.Dataset, title: str, values: Array, limits: tuple[float, float]) -> Map:
    s, depth = section.s.values, section.depth.values
    return Map(title, "s [mm]", "depth [mm]", s, depth, values, "MPa", limits=limits)


def _difference(section: xr.Dataset, difference: Array, source: str) -> list[Cell]:
    """Return the map of a difference to the true body, or of the estimate there."""
    if source == TRUE:
        estimate = np.asarray(section.estimate, dtype=float)
        largest = float(np.max(estimate)) if np.all(np.isfinite(estimate)) else 1.0  # without estimates
        return [_map(section, "estimated error", estimate, (0.0, largest))]
    shown = _map(section, "minus the true body", difference, (0.0, 1.0))
    return [replace(shown, scale="diverging", limits=None)]


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
    steps = {body: _into_depth(dataset, body) for body in bodies(dataset)}
    named = {f"{body} body": cells for body, cells in steps.items()}
    alt = "stresses into depth in the true body and in half-spaces; bands are estimates"
    return Chart("depth", named, 3, SLIDER, 1.0, next(iter(named)), alt=alt)


def _into_depth(dataset: xr.Dataset, body: str) -> list[Panel]:
    place = worst(dataset, body)
    line = below(dataset, body, place).sel(x=place["x"], method="nearest")
    where = f"x = {place['x']:.2g}, s = {place['s']:.2g} mm"
    panels = []
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
    return panels


def load_cycle(dataset: xr.Dataset) -> Chart:
    """Return stress components along x at the worst depth of each body, in the true body and half-spaces."""
    steps = {}
    for body in bodies(dataset):
        place = worst(dataset, body)
        line = below(dataset, body, place).sel(depth=place["depth"], method="nearest")
        steps[f"{body} body"] = [_cycle(line, source) for source in sources(dataset)]
    alt = "stress components along x: the load cycle of a particle as the contact passes"
    return Chart("cycle", steps, 3, SLIDER, 1.0, next(iter(steps)), alt=alt)


def _cycle(line: xr.Dataset, source: str) -> Panel:
    stress = line.stress.sel(source=source).values
    curves = [
        Curve(name, line.x.values, stress[:, i, j], look, line.estimate.values if source == TRUE else None)
        for (name, (i, j)), look in zip(COMPONENTS.items(), COMPONENT_LOOKS, strict=True)
    ]
    where = f"s, depth = {float(line.s):.2g}, {float(line.depth):.2g} mm"
    return Panel(f"{SHORT[source]}, {where}", "x [mm]", "stress [MPa]", curves)


def wear_chart(dataset: xr.Dataset) -> Chart:
    """Return the depths worn along s by each law, with all ICs, and the work of friction along s."""
    names, looks = ics_of(dataset), looks_of(ics_of(dataset))
    worn = dataset.depth.max(["ics", "law"]) > 0
    s = dataset.s.values[worn.values]
    panels = [
        Panel(
            f"worn by a passage: {law}",
            "s [mm]",
            "depth [nm]",
            _by_ics(names, s, dataset.depth.sel(law=law).isel(s=worn.values), looks),
        )
        for law in dataset.law.values
    ]
    energy = dataset.work_density.sum("x") * float(dataset.x[1] - dataset.x[0])
    panels.append(
        Panel(
            "work of friction along s",
            "s [mm]",
            "energy [mJ/mm²]",
            _by_ics(names, s, energy.isel(s=worn.values), looks),
        )
    )
    return Chart("wear", {"": panels}, 2, heights=0.9, alt="depths worn per passage along s by ICs")


def worn_chart(dataset: xr.Dataset) -> Chart:
    """Return the depths worn off both bodies along s after all passages, with all ICs."""
    names, looks = ics_of(dataset), looks_of(ics_of(dataset))
    s = dataset.s.values[(dataset.worn.max(["ics", "worn_body"]) > 0).values]
    panels = [
        Panel(
            f"worn off the {body} body",
            "s [mm]",
            "depth [µm]",
            _by_ics(names, s, dataset.worn.sel(worn_body=body, s=s), looks),
        )
        for body in map(str, dataset.worn_body.values)
        if float(dataset.worn.sel(worn_body=body).max()) > 0
    ]
    return Chart("worn", {"": panels}, 2, heights=0.9, alt="depths worn along s after all passages by ICs")


def _by_ics(names: Sequence[str], s: Array, values: xr.DataArray, looks: dict[str, Look]) -> list[Curve]:
    return [Curve(symbol_of(name), s, values.sel(ics=name).values, looks[name]) for name in names]


def fatigue_maps(dataset: xr.Dataset) -> Chart:
    """Return maps of Dang Van's equivalent stress over s and depth, a step per body."""
    steps = {}
    for body in bodies(dataset):
        fields = of_body(dataset, body)
        values = {source: np.asarray(fields.dang_van.sel(source=source)) for source in sources(dataset)}
        low = min(0.0, *(float(np.min(one)) for one in values.values()))
        limits = (low, max(float(np.max(one)) for one in values.values()))
        steps[f"{body} body"] = [_map(fields, SHORT[source], one, limits) for source, one in values.items()]
    return Chart("fatigue", steps, 3, SLIDER, 0.8, next(iter(steps)), alt="Dang Van's equivalent stress")
