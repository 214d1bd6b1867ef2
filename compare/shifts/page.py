"""File and report of `femic shifts`: at which shifts half-space ICs are good enough."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, join_words, write_results
from compare.report.tables import Cell, Column, Row, Table, numbers, texts
from compare.shifts.differences import (
    LIMITS,
    difference,
    ranked,
    reference_label,
    reference_names,
    reference_values,
)
from compare.shifts.figures import geometry, places, pressures

ELASTIC = (
    "Contacts are elastic and without friction: there are no creep forces and no plastic flow. Each wheel "
    "carries the same vertical load; the lateral forces follow from the contact, whatever a vehicle needs."
)
CONVENTION = (
    "Shifts are those of the wheelset at the rails, to the left; the roll follows from both wheels touching. "
    "Touching points and rolling radii are those of the undeformed profiles."
)


def write_shifts(dataset: xr.Dataset, folder: Path) -> Path:
    """Write `shifts.nc`, the figures and `shifts.html`; returns the path of the page."""
    title = f"Wheelset at lateral shifts: {dataset.attrs['title']}"
    page = Page(title, summary(dataset), _sections(dataset), answer_table(dataset))
    return write_results(page, folder, "shifts", dataset)


def summary(dataset: xr.Dataset) -> str:
    """Return where half-space ICs are good enough, the worst contact, and the geometry: three sentences."""
    return " ".join([_good_enough(dataset), _worst_case(dataset), _geometry_sentence(dataset)])


def compared(dataset: xr.Dataset) -> list[str]:
    """Return the ICs that are compared with better ones: half-spaces first."""
    return [name for name in reversed(ranked(dataset)) if np.isfinite(difference(dataset, name)).any()]


def _good_enough(dataset: xr.Dataset) -> str:
    names = compared(dataset)
    if not names:
        name = symbol_of(ranked(dataset)[0])
        return f"Only one kind of ICs, {name}, was used, so nothing is said about half-space ICs."
    name = names[0]
    parts = [f"within {100 * limit:.0f} % {shifts_within(dataset, name, limit)}" for limit in LIMITS]
    unique = _merged(parts)
    best = reference_label(dataset)
    return f"Half-space ICs ({symbol_of(name)}) give p_max as {best} does {join_words(unique)}."


def _merged(parts: list[str]) -> list[str]:
    """Return the limits and shifts; from the first limit that holds at all shifts on, no more."""
    complete = [k for k, part in enumerate(parts) if part.endswith("at all shifts")]
    return parts[: complete[0] + 1] if complete else parts


def shifts_within(dataset: xr.Dataset, ics: str, limit: float) -> str:
    """Return at which shifts both contacts agree with the reference to a limit, in words."""
    worst = abs(difference(dataset, ics)).max("side")
    known = np.isfinite(worst.values)
    good = known & (worst.values <= limit)
    if np.all(good[known]):
        return "at all shifts"
    return f"at {ranges(dataset['shift'].values[known], good[known])}" if good.any() else "at no shift"


def ranges(shifts: np.ndarray, good: np.ndarray) -> str:
    """Return the ranges of neighbouring shifts where something holds, in words."""
    starts = np.flatnonzero(good & ~np.append(False, good[:-1]))
    ends = np.flatnonzero(good & ~np.append(good[1:], False))
    parts = [
        f"{shifts[a]:g} mm" if a == b else f"{shifts[a]:g} to {shifts[b]:g} mm"
        for a, b in zip(starts, ends, strict=True)
    ]
    return join_words(parts)


def worst_of(dataset: xr.Dataset, ics: str) -> xr.Dataset:
    """Return the contact in which some ICs differ most from the best."""
    at = abs(difference(dataset, ics)).fillna(-1).argmax(["shift", "side"])
    return dataset.isel(at)


def _worst_case(dataset: xr.Dataset) -> str:
    names = compared(dataset)
    if not names:
        peak = reference_values(dataset, "p_max").fillna(-1).argmax(["shift", "side"])
        own = dataset.isel(peak)
        return f"The largest pressure is {float(own.p_max.max()):.0f} MPa, at {_where(own)}."
    own = worst_of(dataset, names[0])
    best, share = (
        _best(dataset, own),
        float(difference(dataset, names[0]).sel(shift=own["shift"], side=own.side)),
    )
    return (
        f"The worst is {_where(own)}, where the rail's inclination changes by "
        f"{float(own['angle'].sel(ics=best)):.0f} degrees across the patch: "
        f"{float(own.p_max.sel(ics=names[0])):.0f} MPa instead of {float(own.p_max.sel(ics=best)):.0f} MPa "
        f"({100 * share:+.1f} %)."
    )


def _best(dataset: xr.Dataset, own: xr.Dataset) -> str:
    return str(reference_names(dataset).sel(shift=own["shift"], side=own.side).item())


def _where(own: xr.Dataset) -> str:
    return f"{float(own['shift']):g} mm, {own.side.item()} wheel"


def _geometry_sentence(dataset: xr.Dataset) -> str:
    conicity, refused = dataset.attrs["conicity"], whole_shifts_refused(dataset)
    parts = []
    if np.isfinite(conicity):
        parts.append(f"the equivalent conicity at {dataset.attrs['amplitude']:g} mm is {conicity:.3f}")
    else:
        parts.append(f"there is no equivalent conicity at {dataset.attrs['amplitude']:g} mm")
    if refused:
        parts.append(f"at {', '.join(refused)} mm the wheelset cannot stand")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def whole_shifts_refused(dataset: xr.Dataset) -> list[str]:
    """Return the shifts [mm] at which no position was found."""
    return [place for place in json.loads(dataset.attrs["refused"]) if "," not in place]


def answer_table(dataset: xr.Dataset) -> Table:
    """Return for each ICs at which shifts they are good to 1, 5 and 10 %, and their worst contact."""
    rows = []
    for name in compared(dataset):
        own = worst_of(dataset, name)
        best = _best(dataset, own)
        share = float(difference(dataset, name).sel(shift=own["shift"], side=own.side))
        within = [shifts_within(dataset, name, limit).removeprefix("at ") for limit in LIMITS]
        worst = f"{float(own['shift']):g} mm, {own.side.item()}"
        pressures = [Cell(float(own.p_max.sel(ics=each)), ".0f") for each in (name, best)]
        rows.append(Row(symbol_of(name), [*within, worst, *pressures, Cell(100 * share, "+.2f")]))
    heads = texts(*(f"within {100 * limit:.0f} %" for limit in LIMITS), "worst")
    columns = [*heads, Column("p_max", "MPa"), Column("reference", "MPa"), Column("differs by", "%")]
    return Table("p_max by", columns, rows)


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    yield Section("", [pressures(dataset), Note(_reading(dataset))])
    yield Section("Where they touch", [places(dataset), Note(_places_note())])
    yield Section("Angles and radii", [geometry(dataset), Note(CONVENTION)])
    left_out = [f"{place} mm: {reason}" for place, reason in json.loads(dataset.attrs["refused"]).items()]
    left_out += [f"{place}: {note}" for place, note in json.loads(dataset.attrs["neglected"]).items()]
    if left_out:
        yield Folded("Not solved, and neglected", [Items(left_out)])
    yield Folded("All contacts: pressures", [_pressure_table(dataset), Note(ELASTIC)])
    yield Folded("All contacts: patches and forces", [_patch_table(dataset)])
    yield Folded("All shifts: geometry", [_geometry_table(dataset), Note(_conicity_note(dataset))])
    yield Folded("How the profiles were understood", [Items(json.loads(dataset.attrs["notes"]))])
    yield Folded("Grids", [_grid_table(dataset), Note(_time(dataset))])
    yield Folded("Specification", [Verbatim(dataset.attrs["specification"])])


def _reading(dataset: xr.Dataset) -> str:
    best = ranked(dataset)
    of_best = (
        "B̂ is itself an approximation: it is the reference where C was not computed (contact.c_above_deg). "
        if "Bhat" in best and np.any(reference_names(dataset).values == "Bhat")
        else ""
    )
    of_c = (
        "C is of bodies with flanks of 60 degrees beside the contact; its estimate has the change by nearer "
        "supports in it. "
        if np.any(reference_names(dataset).values == "C")
        else ""
    )
    alike = (
        "Both sides are alike: the right contact at a shift is the left one at the opposite shift. "
        if dataset.attrs["alike"]
        else ""
    )
    return (
        f"Vertical load {dataset.attrs['load'] / 1000:g} kN on each wheel. {of_best}{of_c}{alike}Bands: "
        f"estimated errors of p_max by the size of the elements, which all ICs of a contact share. {ELASTIC}"
    )


def _places_note() -> str:
    return (
        "Sections seen along the track, the left rail at the left; orange: patches with the best ICs, and "
        "the touching point of the undeformed profiles. Below: outlines of the patches, on the unrolled rail."
    )


def _rows(dataset: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield all contacts with their names."""
    for shift in dataset["shift"].values:
        for side in dataset.side.values:
            own = dataset.sel(shift=shift, side=side)
            if np.isfinite(own.p_max.values).any():
                yield f"{shift:g} mm, {side}", own


def _pressure_table(dataset: xr.Dataset) -> Table:
    """Return p_max of all contacts by ICs, with estimates and differences to the best."""
    names = [str(name) for name in dataset.ics.values]
    rows = []
    for label, own in _rows(dataset):
        cells = [Cell(float(own.p_max.sel(ics=n)), ".1f", _estimate(own, n)) for n in names]
        shares = [
            Cell(100 * float(difference(dataset, n).sel(shift=own["shift"], side=own.side)), "+.2f")
            for n in compared(dataset)
        ]
        rows.append(Row(label, [*cells, *shares]))
    heads = [Column(f"p_max, {symbol_of(name)}", "MPa") for name in names]
    further = [Column(f"{symbol_of(name)} differs", "%") for name in compared(dataset)]
    return Table("shift, wheel", [*heads, *further], rows)


def _estimate(own: xr.Dataset, ics: str) -> str:
    estimate = float(own.estimate_p_max.sel(ics=ics))
    return "" if np.isnan(estimate) else f"± {estimate:.2g}"


def _patch_table(dataset: xr.Dataset) -> Table:
    """Return the patches of all contacts with the best ICs, and the forces."""
    rows = []
    for label, own in _rows(dataset):
        best = own.sel(ics=_best(dataset, own))
        rows.append(
            Row(
                label,
                [
                    Cell(float(best["angle"]), ".1f"),
                    Cell(float(best.a), ".2f"),
                    Cell(float(best.b), ".2f"),
                    Cell(1000 * float(best.approach), ".1f"),
                    Cell(
                        float(best.patches),
                        ".0f",
                        f"{100 * float(best.beside):.1f} %" if best.patches > 1 else "",
                    ),
                    Cell(float(best.vertical) / 1000, ".2f"),
                    Cell(float(best.lateral) / 1000, ".2f"),
                ],
            )
        )
    columns = [
        Column("Δδ", "deg"),
        Column("a", "mm"),
        Column("b", "mm"),
        Column("approach", "um"),
        Column("patches"),
        Column("vertical", "kN"),
        Column("lateral", "kN"),
    ]
    return Table("shift, wheel", columns, rows)


def _geometry_table(dataset: xr.Dataset) -> Table:
    rows = []
    for shift in dataset["shift"].values:
        own = dataset.sel(shift=shift)
        if np.isnan(own["roll"]):
            continue
        angles = [Cell(float(own.contact_angle.sel(side=side)), ".2f") for side in dataset.side.values]
        radii = [Cell(float(own.radius.sel(side=side)), ".3f") for side in dataset.side.values]
        rows.append(
            Row(
                f"{shift:g} mm",
                [*angles, *radii, Cell(float(own.rrd), ".3f"), Cell(float(own["roll"]), ".3f")],
            )
        )
    heads = [
        *numbers("angle left", "angle right", unit="deg"),
        *numbers("radius left", "radius right", unit="mm"),
    ]
    return Table("shift", [*heads, Column("difference", "mm"), Column("roll", "mrad")], rows)


def _conicity_note(dataset: xr.Dataset) -> str:
    if np.isfinite(dataset.attrs["conicity"]):
        jumps = np.atleast_1d(dataset.attrs["jumps"])
        where = (
            f" Touching points jump at {', '.join(f'{jump:g}' for jump in jumps)} mm." if len(jumps) else ""
        )
        return f"Equivalent conicity {dataset.attrs['conicity']:.4f} (EN 15302).{where}"
    return f"No equivalent conicity: {dataset.attrs['conicity_reason']}"


def _grid_table(dataset: xr.Dataset) -> Table:
    rows = [
        Row(label, [str(own.grid.item()), Cell(float(own.seconds.sum()), ".1f")])
        for label, own in _rows(dataset)
    ]
    return Table("shift, wheel", [*texts("grid"), Column("time", "s")], rows)


def _time(dataset: xr.Dataset) -> str:
    return (
        "One grid covers all patches of a contact; the share of the load beside the main patch stands below "
        f"their number. The whole run took {dataset.attrs['seconds']:.0f} s; stored contacts count nothing."
    )
