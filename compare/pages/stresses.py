"""`femic stresses` writes the file, figures and the page of stresses, wear and fatigue below a contact.

Charts show maps of sections, curves into depth, the load cycle, and wear.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.charts import Cell as ChartCell
from compare.report.charts import Chart, Curve, Map, Panel
from compare.report.looks import OWN, Look, ics_looks, ics_symbol
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, write_results
from compare.report.tables import Cell, Column, Row, Table, number_text, with_estimate
from femic.results.damage import OF_DAMAGE
from femic.results.stresses import HALF_SPACE, HALF_SPACE_OF_A, MEASURES, OF_STRESS, TRUE
from femic.stresses.field import von_mises
from geometries.arrays import Array

# --- the page -------------------------------------------------------------------------------------------


SECTION = (
    "“true” is the actual body and “half-space” a half-space, both under the tractions of the reference; "
    "“half-space of A” carries the tractions of A. The maps show von Mises stress over arc length s (of "
    "the lower contour) and depth below each surface, at the x where the stress is largest. Beside the "
    "actual body: the estimated error of the largest stress component. Beside half-spaces: their "
    "difference from the actual body."
)
WEAR = (
    "The depths are the material lost by the rail per passage and by the wheel per revolution. Energy: "
    "law of Krause and Poll. Twin disc: BRR function of T-gamma/area. Archard: wear map of KTH. The "
    "coefficients come from laboratory tests of dry steel, so ratios between ICs are more reliable than "
    "depths."
)
WORN = (
    "The rail wears in {:g} passages and the wheel in {:g} revolutions, by the energy law, in up to {} "
    "steps. After each step the contact is solved again with the material that both bodies have lost. ± "
    "is the estimated error from the size of the steps only. The ICs are those of the new surfaces: once "
    "wear turns a surface by more than 1°, components that vanish on new surfaces may be wrong by that "
    "angle times C_nn."
)
SHAKEDOWN = (
    "The limit of p_max/k assumes residual stresses without shear along x. It is exact for line contact "
    "and a lower bound for a patch that runs on one track."
)
MILD = "Without damage.speed (--speed), the energy law assumes mild wear everywhere."
FATIGUE = (
    "Equivalent stress of Dang Van (c = {:.3g} in tension, {:.3g} in compression) for the load cycle of "
    "one passage, starting without stress. Expect fatigue where it exceeds the fatigue limit in shear."
)
SURFACE = 1e-9  # mm: depths below are the surface
PASSES = {"lower": "passages", "upper": "revolutions"}  # attributes: what wears a body


def write_stresses(dataset: xr.Dataset, out: Path) -> Path:
    """Write `stresses.nc`, figures and `stresses.html`; return the path of the page."""
    title = str(dataset.attrs["title"])
    page = Page(title, summary(dataset), _sections(dataset), stress_table(dataset))
    return write_results(page, out, "stresses", dataset)


def summary(dataset: xr.Dataset) -> str:
    """Return the largest von Mises stress of each body and its place."""
    found = []
    for body in bodies(dataset):
        true = dataset.sel(body=body, source=TRUE)
        number = with_estimate(true.von_mises, true.estimate_von_mises)
        found.append(f"{body} body {number} MPa {place_text(true, 'von_mises')}")
    load, friction, p_max = (dataset.attrs[key] for key in ("load", "friction", "p_max_of_reference"))
    return (
        f"Largest von Mises stress at {load} and friction {friction:g}, under the tractions of "
        f"{reference_symbol(dataset)} with p_max {p_max:.0f} MPa: {'; '.join(found)}."
    )


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    attributes, symbol = dataset.attrs, reference_symbol(dataset)
    yield Section("", [section_maps(dataset), Note(SECTION)])
    bands = Note("Bands: estimated error of the largest stress component in the actual body.")
    yield Section("Into depth", [depth_curves(dataset), bands])
    yield Section("Stress along the rolling direction", [plane_maps(dataset)])
    cycle = Note(
        "Stress components along x, s and n of the surface above, at the point of the largest "
        "von Mises stress."
    )
    yield Section("The load cycle", [load_cycle(dataset), cycle])
    if "dang_van" in dataset:
        c = float(attributes["dang_van_hydrostatic"])
        note = Note(FATIGUE.format(c, c * float(attributes["dang_van_compression"])))
        yield Section("Fatigue below the surface", [fatigue_maps(dataset), note])
    if "ics" in dataset.dims:
        notes = [
            f"The small number below is the difference from the number with {symbol}.",
            "" if "speed" in attributes else MILD,
            SHAKEDOWN
            if "yield_stress" in attributes
            else "Give damage.yield_stress (--yield-stress) to obtain shakedown and the surface fatigue "
            "index.",
        ]
        blocks: list[Block] = [damage_table(dataset), Note(" ".join(filter(None, notes)))]
        yield Section("Wear and surface fatigue by ICs", [*blocks, wear_chart(dataset), Note(WEAR)])
    if "worn" in dataset:
        steps = int(dataset.wear_steps.max())
        note = Note(WORN.format(attributes["passages"], attributes["revolutions"], steps))
        yield Section("After all passages", [worn_table(dataset), worn_chart(dataset), note])
    lattice = " × ".join(str(dataset.sizes[f"{name}_lower"]) for name in ("x", "s", "depth"))
    method = (
        f"The tractions of {symbol} load the two actual bodies (harmonic engine) and half-spaces unrolled "
        f"along the arc length. Stresses are computed at {lattice} points; the largest values are the "
        f"largest at these points. The whole run took {float(attributes['seconds']):.0f} s."
    )
    yield Folded("How these numbers are computed", [method])
    yield Folded("Scene file", [Verbatim(str(attributes["scene"]))])


# --- tables ---------------------------------------------------------------------------------------------


def place_text(numbers: xr.Dataset, name: str) -> str:
    """Return where a number is largest."""
    s, depth = float(numbers[f"s_{name}"]), float(numbers[f"depth_{name}"])
    x = f"x = {float(numbers[f'x_{name}']):.2g}, " if f"x_{name}" in numbers else ""
    edge = " (the deepest point that was computed)" if bool(numbers[f"deepest_{name}"]) else ""
    where = "on the surface" if depth < SURFACE else f"{depth:.2g} mm deep{edge}"
    return f"{where} at {x}s = {s:.2g} mm"


def stress_table(dataset: xr.Dataset) -> Table:
    """Return the largest stresses of each body and source.

    True bodies have estimates, half-spaces below their values the differences to the true body; then stresses
    over p_max, and places.
    """
    names = [name for name in OF_STRESS if name in dataset]
    heads = [Column(OF_STRESS[name].symbol, OF_STRESS[name].unit) for name in names]
    share = Column("largest difference on the section", "% of largest σ_Mises")
    rows = []
    for body in bodies(dataset):
        for source in sources(dataset):
            values, cells = dataset.sel(body=body, source=source), []
            for name in names:
                known = float(values.get(f"estimate_{name}", np.nan)) if source == TRUE else np.nan
                text = f"{float(values[name]):.0f}" if np.isnan(known) else with_estimate(values[name], known)
                below = [] if source == TRUE else [_change(values[f"difference_{name}"])]
                if source != HALF_SPACE_OF_A:
                    below.append(f"{float(values[f'{name}_over_p_max']):.3f} p_max")
                cells.append(Cell(text, below="; ".join([*below, place_text(values, name)])))
            off = Cell("" if source == TRUE else f"{100 * float(values.section_difference):.0f}")
            rows.append(Row(f"{body} body: {source_label(dataset, source)}", [*cells, off]))
    return Table("body, stresses", [*heads, share], rows)


def damage_table(dataset: xr.Dataset) -> Table:
    """Return wear and fatigue numbers, a column per ICs; below each number its difference."""
    names, reference = list(map(str, dataset.ics.values)), dataset.sel(ics=dataset.attrs["reference"])
    rows = []
    for variable, number in OF_DAMAGE.items():
        if variable in dataset:
            cells = []
            for name in names:
                value, estimate = (dataset[one].sel(ics=name) for one in (variable, f"estimate_{variable}"))
                text = f"{float(value):.4g}" if np.isnan(float(estimate)) else with_estimate(value, estimate)
                if name == dataset.attrs["reference"]:
                    below = ""
                elif variable == "surface_index":  # it may vanish
                    below = number_text(float(value - reference[variable]), "+.3f")
                else:
                    below = _change(value / reference[variable] - 1)
                cells.append(Cell(text, below=below))
            rows.append(Row(f"{number.title}: {number.meaning}", cells))
    return Table("number", [Column(ics_symbol(name)) for name in names], rows)


def worn_table(dataset: xr.Dataset) -> Table:
    """Return what all passages wear off and make of the contact, a column per ICs."""
    names, reference, rows = list(map(str, dataset.ics.values)), dataset.attrs["reference"], []
    for body in map(str, dataset.worn_body.values):
        if dataset.attrs[PASSES[body]] > 0:
            worn = dataset.worn.sel(worn_body=body).max("s")
            cells = []
            for name in names:
                value, estimate = worn.sel(ics=name), dataset.estimate_worn.sel(worn_body=body, ics=name)
                below = "" if name == reference else _change(value / worn.sel(ics=reference) - 1)
                cells.append(Cell(with_estimate(value, estimate), below=below))
            rows.append(Row(f"largest wear depth of the {body} body [µm]", cells))
    for variable, symbol in (("worn_p_max", "p_max [MPa]"), ("worn_work", "W [J/m]")):
        values = [dataset[variable].sel(ics=name).values for name in names]
        rows.append(Row(f"{symbol}, new → worn", [" → ".join(f"{v:.4g}" for v in both) for both in values]))
    turned = [f"{float(dataset.turned.sel(ics=name)):.2g}" for name in names]
    rows.append(Row("largest change of a surface's inclination [°]", turned))
    return Table("worn contact", [Column(ics_symbol(name)) for name in names], rows)


def _change(share: xr.DataArray) -> str:
    """Return a difference as a share, nothing where there is nothing to compare with."""
    return number_text(float(share), "+.1%") if np.isfinite(float(share)) else ""


# --- charts ---------------------------------------------------------------------------------------------


LOOKS = {TRUE: OWN["C"], HALF_SPACE: OWN["A"], HALF_SPACE_OF_A: OWN["B"]}
COMPONENTS = {  # of stresses: indices and looks
    "σ_xx": ((0, 0), Look("#0072b2")),
    "σ_ss": ((1, 1), Look("#e69f00")),
    "σ_nn": ((2, 2), Look("ink")),
    "σ_sn": ((1, 2), Look("#009e73", "dash")),
    "σ_xn": ((0, 2), Look("#d55e00", "dash")),
    "σ_xs": ((0, 1), Look("#cc79a7", "dash")),
}
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


def _by_body(
    dataset: xr.Dataset, name: str, alt: str, heights: float, cells: Callable[[str], Sequence[ChartCell]]
) -> Chart:
    """Return a chart with a step per body."""
    steps = {f"{body} body": cells(body) for body in bodies(dataset)}
    return Chart(name, steps, 3, "body", heights, next(iter(steps)), alt=alt)


def _body_fields(dataset: xr.Dataset, body: str) -> xr.Dataset:
    """Return the fields of a body: stress, estimate, perhaps dang_van, over x, s, depth."""
    names = {f"{name}_{body}": name for name in ("stress", "estimate", "dang_van")}
    places = {f"{name}_{body}": name for name in ("x", "s", "depth")}
    return dataset[[name for name in names if name in dataset]].rename(
        {name: short for name, short in (names | places).items() if name in dataset.variables}
    )


def _below(dataset: xr.Dataset, body: str, place: dict[str, float]) -> xr.Dataset:
    """Return the fields of a body over x and depth, at the s of a place.

    Below the middle of the patch they go down to the deepest point.
    """
    middle = float(dataset.middle.sel(body=body))
    if abs(place["s"] - middle) >= SAME:
        return _body_fields(dataset, body).sel(s=place["s"], method="nearest")
    names = {f"column_{name}_{body}": name for name in ("stress", "estimate")}
    column = dataset[list(names)].rename({**names, f"column_{body}": "depth", f"x_{body}": "x"})
    return column.assign_coords(s=middle)


def _worst(dataset: xr.Dataset, body: str) -> dict[str, float]:
    """Return the place of the largest von Mises stress in a true body [mm]."""
    numbers = dataset.sel(body=body, source=TRUE)
    return {name: float(numbers[f"{name}_von_mises"]) for name in ("x", "s", "depth")}


def _mises(dataset: xr.Dataset, fields: xr.Dataset) -> tuple[dict[str, Array], tuple[float, float]]:
    """Return von Mises stresses by source, and the limits of their common colours."""
    values = {
        source: von_mises(np.asarray(fields.stress.sel(source=source), dtype=float))
        for source in sources(dataset)
    }
    return values, (0.0, max(float(np.max(one)) for one in values.values()))


def _map(section: xr.Dataset, title: str, values: Array, limits: tuple[float, float] | None) -> Map:
    s, depth = section.s.values, section.depth.values
    return Map(title, "s [mm]", "depth [mm]", s, depth, values, "MPa", limits=limits)


def section_maps(dataset: xr.Dataset) -> Chart:
    """Return maps of von Mises stresses on the section of a body, a step per body and source.

    The section is that through the largest stress. Beside each map: the estimate, or the difference to the
    true body.
    """
    steps: dict[str, list[ChartCell]] = {}
    for body in bodies(dataset):
        section = _body_fields(dataset, body).sel(x=_worst(dataset, body)["x"], method="nearest")
        values, limits = _mises(dataset, section)
        estimate = np.asarray(section.estimate, dtype=float)
        largest = float(np.max(estimate)) if np.all(np.isfinite(estimate)) else 1.0  # without estimates
        for source, mises in values.items():
            beside = _map(section, "minus the actual body", mises - values[TRUE], None)
            steps[f"{body}, {SHORT[source]}"] = [
                _map(section, f"x = {float(section.x):.2g} mm", mises, limits),
                _map(section, "estimated error", estimate, (0.0, largest))
                if source == TRUE
                else replace(beside, scale="diverging"),
            ]
    alt = "von Mises stress on the section below the contact, and differences from the actual body"
    return Chart("section", steps, 2, "body and stresses", 0.9, next(iter(steps)), alt=alt)


def plane_maps(dataset: xr.Dataset) -> Chart:
    """Return maps of von Mises stresses on the plane along x through the largest one, a step per body."""

    def maps(body: str) -> list[Map]:
        plane = _below(dataset, body, _worst(dataset, body))
        (x, depth), (values, limits) = (plane.x.values, plane.depth.values), _mises(dataset, plane)
        titles = {source: f"{SHORT[source]}, s = {float(plane.s):.2g} mm" for source in values}
        return [
            Map(titles[source], "x [mm]", "depth [mm]", x, depth, mises, "MPa", limits=limits)
            for source, mises in values.items()
        ]

    return _by_body(dataset, "plane", "von Mises stresses along the rolling direction", 0.8, maps)


def depth_curves(dataset: xr.Dataset) -> Chart:
    """Return stresses along the line into depth below the largest von Mises stress, a step per body."""

    def panels(body: str) -> list[Panel]:
        place, drawn = _worst(dataset, body), []
        line = _below(dataset, body, place).sel(x=place["x"], method="nearest")
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
            title = f"{symbol} at x = {place['x']:.2g}, s = {place['s']:.2g} mm"
            drawn.append(Panel(title, "depth [mm]", f"{symbol} [MPa]", curves))
        return drawn

    alt = "stresses against depth in the actual body and in half-spaces; bands are estimated errors"
    return _by_body(dataset, "depth", alt, 1.0, panels)


def load_cycle(dataset: xr.Dataset) -> Chart:
    """Return stress components along x at the worst depth of each body, in the true body and half-spaces."""

    def panels(body: str) -> list[Panel]:
        place, drawn = _worst(dataset, body), []
        line = _below(dataset, body, place).sel(depth=place["depth"], method="nearest")
        for source in sources(dataset):
            stress = line.stress.sel(source=source).values
            band = line.estimate.values if source == TRUE else None
            curves = [
                Curve(name, line.x.values, stress[:, i, j], look, band)
                for name, ((i, j), look) in COMPONENTS.items()
            ]
            title = f"{SHORT[source]}, s, depth = {float(line.s):.2g}, {float(line.depth):.2g} mm"
            drawn.append(Panel(title, "x [mm]", "stress [MPa]", curves))
        return drawn

    alt = "stress components along x: the load cycle of a material point as the contact passes"
    return _by_body(dataset, "cycle", alt, 1.0, panels)


def fatigue_maps(dataset: xr.Dataset) -> Chart:
    """Return maps of Dang Van's equivalent stress over s and depth, a step per body."""

    def maps(body: str) -> list[Map]:
        fields = _body_fields(dataset, body)
        values = {source: np.asarray(fields.dang_van.sel(source=source)) for source in sources(dataset)}
        low, high = (end([float(end(one)) for one in values.values()]) for end in (np.min, np.max))
        limits = min(0.0, float(low)), float(high)
        return [_map(fields, SHORT[source], one, limits) for source, one in values.items()]

    return _by_body(dataset, "fatigue", "equivalent stress of Dang Van", 0.8, maps)


def wear_chart(dataset: xr.Dataset) -> Chart:
    """Return the depths worn along s by each law, with all ICs, and the work of friction along s."""
    worn = dataset.isel(s=(dataset.depth.max(["ics", "law"]) > 0).values)
    energy = worn.work_density.sum("x") * float(dataset.x[1] - dataset.x[0])
    panels = [
        *(
            _along_s(f"wear depth per passage: {law}", "depth [nm]", worn.depth.sel(law=law))
            for law in dataset.law.values
        ),
        _along_s("work of friction along s", "energy [mJ/mm²]", energy),
    ]
    return Chart(
        "wear", {"": panels}, 2, heights=0.9, alt="wear depths per passage along s with each of the ICs"
    )


def worn_chart(dataset: xr.Dataset) -> Chart:
    """Return the depths worn off both bodies along s after all passages, with all ICs."""
    worn = dataset.worn.isel(s=(dataset.worn.max(["ics", "worn_body"]) > 0).values)
    panels = [
        _along_s(f"wear depth of the {body} body", "depth [µm]", worn.sel(worn_body=body))
        for body in map(str, dataset.worn_body.values)
        if float(worn.sel(worn_body=body).max()) > 0
    ]
    return Chart(
        "worn",
        {"": panels},
        2,
        heights=0.9,
        alt="wear depths along s after all passages with each of the ICs",
    )


def _along_s(title: str, up: str, values: xr.DataArray) -> Panel:
    """Return curves over s by ICs."""
    looks = ics_looks(map(str, values.ics.values))
    curves = [
        Curve(ics_symbol(n), values.s.values, values.sel(ics=n).values, look) for n, look in looks.items()
    ]
    return Panel(title, "s [mm]", up, curves)
