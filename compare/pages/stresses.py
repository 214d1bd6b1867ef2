"""`femic stresses` writes the file, figures and the page of stresses, wear and fatigue below a contact."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages import stress_figures as figures
from compare.pages.stress_figures import bodies, reference_symbol, source_label, sources
from compare.report.looks import ics_symbol
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, write_results
from compare.report.tables import Cell, Column, Row, Table, number_text, with_estimate
from femic.results.damage import OF_DAMAGE
from femic.results.stresses import HALF_SPACE_OF_A, OF_STRESS, TRUE

# --- the page -------------------------------------------------------------------------------------------


SECTION = (
    "“true” and “half-space” have the tractions of the reference, “half-space of A” those of A. "
    "Von Mises stresses over arc length s (of the lower contour) and depth below each surface, at the x of "
    "the largest one. Beside the true body: the estimated error of the largest stress component; beside "
    "half-spaces: their difference to the true body."
)
WEAR = (
    "Per passage of the contact the rail, per revolution the wheel, loses these depths. Energy: Krause and "
    "Poll; twin disc: the BRR function of T-gamma over area; Archard: the wear map of KTH. Coefficients are "
    "those of dry steel in laboratories: ratios between ICs are surer than depths."
)
WORN = (
    "{:g} passages of such wheels wear the rail, {:g} revolutions the wheel, in {} steps or less, by the law "
    "of energy: after each the contact is solved again with the gap that both have lost. ± is the error by "
    "the size of steps alone. ICs are those of the new surfaces: once a surface has turned by more than 1°, "
    "components that vanish on new ones may be off by that angle times C_nn."
)
SHAKEDOWN = (
    "The limit of p_max/k is that of residual stresses without shear along x: exact for lines, a lower "
    "bound for a patch on one track."
)
MILD = "Without damage.speed (--speed) wear by energy is mild everywhere."
FATIGUE = (
    "Dang Van's equivalent stress (c = {:.3g} in tension, {:.3g} in compression) over the cycle from no "
    "stress through all x. Fatigue is to be expected where it exceeds the fatigue limit in shear."
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
        f"Largest von Mises stress at {load}, friction {friction:g} (tractions of "
        f"{reference_symbol(dataset)}, p_max {p_max:.0f} MPa): {'; '.join(found)}."
    )


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    attributes, symbol = dataset.attrs, reference_symbol(dataset)
    yield Section("", [figures.section_maps(dataset), Note(SECTION)])
    bands = Note("Bands: the estimated error of the largest stress component in the true body.")
    yield Section("Into depth", [figures.depth_curves(dataset), bands])
    yield Section("Along the rolling direction", [figures.plane_maps(dataset)])
    cycle = Note("Stresses along x, s, n of the surface above, at the place of the largest von Mises stress.")
    yield Section("The load cycle", [figures.load_cycle(dataset), cycle])
    if "dang_van" in dataset:
        c = float(attributes["dang_van_hydrostatic"])
        note = Note(FATIGUE.format(c, c * float(attributes["dang_van_compression"])))
        yield Section("Fatigue below the surface", [figures.fatigue_maps(dataset), note])
    if "ics" in dataset.dims:
        notes = [
            f"Small, below each number: its difference to that with {symbol}.",
            "" if "speed" in attributes else MILD,
            SHAKEDOWN
            if "yield_stress" in attributes
            else "With damage.yield_stress (--yield-stress): shakedown and surface index.",
        ]
        blocks: list[Block] = [damage_table(dataset), Note(" ".join(filter(None, notes)))]
        yield Section("Wear and surface fatigue by ICs", [*blocks, figures.wear_chart(dataset), Note(WEAR)])
    if "worn" in dataset:
        steps = int(dataset.wear_steps.max())
        note = Note(WORN.format(attributes["passages"], attributes["revolutions"], steps))
        yield Section("After all passages", [worn_table(dataset), figures.worn_chart(dataset), note])
    lattice = " × ".join(str(dataset.sizes[f"{name}_lower"]) for name in ("x", "s", "depth"))
    method = (
        f"Tractions of {symbol} load both true bodies (harmonic engine) and half-spaces that are unrolled by "
        f"arc length, at {lattice} points; largest values are those on these points. All of it took "
        f"{float(attributes['seconds']):.0f} s."
    )
    yield Folded("How these numbers are computed", [method])
    yield Folded("Scene file", [Verbatim(str(attributes["scene"]))])


# --- tables ---------------------------------------------------------------------------------------------


def place_text(numbers: xr.Dataset, name: str) -> str:
    """Return where a number is largest."""
    s, depth = float(numbers[f"s_{name}"]), float(numbers[f"depth_{name}"])
    x = f"x = {float(numbers[f'x_{name}']):.2g}, " if f"x_{name}" in numbers else ""
    edge = " (as deep as was computed)" if bool(numbers[f"deepest_{name}"]) else ""
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
            rows.append(Row(f"largest depth worn off the {body} body [µm]", cells))
    for variable, symbol in (("worn_p_max", "p_max [MPa]"), ("worn_work", "W [J/m]")):
        values = [dataset[variable].sel(ics=name).values for name in names]
        rows.append(Row(f"{symbol}, new → worn", [" → ".join(f"{v:.4g}" for v in both) for both in values]))
    turned = [f"{float(dataset.turned.sel(ics=name)):.2g}" for name in names]
    rows.append(Row("largest change of a surface's inclination [°]", turned))
    return Table("worn contact", [Column(ics_symbol(name)) for name in names], rows)


def _change(share: xr.DataArray) -> str:
    """Return a difference as a share, nothing where there is nothing to compare with."""
    return number_text(float(share), "+.1%") if np.isfinite(float(share)) else ""
