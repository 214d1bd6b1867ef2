"""The page of compression with friction by several ICs, from its dataset."""

import xarray as xr

from compare.pages.contact_numbers import verdict
from compare.pages.friction import (
    MotionPage,
    PageParts,
    abscissa,
    by_friction,
    curves_by_ics,
    difference,
    difference_panel,
    largest_differences,
    main_number,
    percent_change,
    place_text,
    places,
    reference_symbol,
    signed_text,
    worst_friction,
)
from compare.report.charts import Chart, Panel
from compare.report.looks import ics_symbol
from compare.report.parts import range_text
from compare.report.tables import Cell, Column, Row, Table, number_text, with_estimate
from femic.results.contact import compared_ics, ics_names, reference_ics

SUFFICES = 5.0  # % of the contact area: difference of sliding areas up to which ICs suffice
SLIDING = "sliding area [% of contact area]"


def parts(dataset: xr.Dataset) -> PageParts:
    """Return how much of the contact slides at the last load, and how far ICs are off."""
    symbol, last = reference_symbol(dataset), place_text(dataset, float(dataset["load"][-1]))
    at_last = dataset.isel(load=-1).sel(ics=reference_ics(dataset))
    return PageParts(
        summary=(
            f"At {last}, {range_text(100 * at_last.sliding_share, '.0f')} % of the contact area slides, "
            f"with {symbol} and friction {range_text(dataset.friction, 'g')}. The surface turns by up to "
            f"{float(at_last.angle.max()):.0f} degrees across the patch."
        ),
        answer=answer(dataset, last),
        note=(
            f"Sliding area divided by contact area. Band: estimated error of {symbol}, which includes the "
            "error from the load steps."
        ),
        contact=f"At {last}.",
        work="Work of friction in the last load step, per unit area (minus traction times slip).",
    )


def answer(dataset: xr.Dataset, last: str) -> Table:
    """Return how much slides at the last load and the friction where ICs differ most, and verdicts."""
    friction, symbol, reference = worst_friction(dataset), reference_symbol(dataset), reference_ics(dataset)
    at = dataset.sel(friction=friction)
    share, known, away = (
        values.isel(load=-1) for values in (main_number(at), main_number(at, "estimate_"), difference(at))
    )
    largest, known_largest = largest_differences(dataset)
    p_max = at.isel(load=-1).p_max.sel(ics=reference)
    rows = []
    for name in ics_names(dataset):
        contact = at.isel(load=-1).sel(ics=name)
        most, its_estimate = (each.sel(ics=name) for each in (largest, known_largest))
        cells: list[Cell | str] = [
            with_estimate(share.sel(ics=name), known.sel(ics=name)),
            signed_text(away.sel(ics=name), known.sel(ics=reference)),
            Cell(with_estimate(most, its_estimate), below=verdict(most, its_estimate, SUFFICES)),
            with_estimate(contact.p_max, contact.estimate_p_max),
            number_text(percent_change(contact.p_max, p_max), "+.1f"),
        ]
        if name == reference:
            cells[1] = cells[2] = cells[4] = ""
        rows.append(Row(ics_symbol(name), cells))
    columns = [
        Column(f"sliding area at {last}, friction {friction:g}", "% of contact"),
        Column(f"minus that with {symbol}", "% of contact"),
        Column("largest difference at all loads, any friction", "% of contact"),
        Column(f"p_max at {last}, friction {friction:g}", "MPa"),
        Column(f"off {symbol} by", "%"),
    ]
    return Table("ICs", columns, rows)


def sliding(dataset: xr.Dataset) -> Chart:
    """Return sliding over contact area by all ICs, over the load and the angle, and its difference."""

    def panels(contacts: xr.Dataset) -> list[Panel]:
        share, estimate = main_number(contacts), main_number(contacts, "estimate_")
        by_load = curves_by_ics(places(dataset), share, estimate, share=True)
        by_angle = curves_by_ics(contacts.angle, share, estimate, share=True)
        title = f"difference from the value with {reference_symbol(dataset)}"
        return [
            Panel("against load", abscissa(dataset).title, SLIDING, by_load),
            *([difference_panel(dataset, contacts, title)] if compared_ics(dataset) else []),
            Panel("against the angle of the patch", "Δδ with the same ICs [deg]", SLIDING, by_angle),
        ]

    alt = "sliding part of the contact area with each of the ICs, and differences from the reference"
    return by_friction(dataset, "sliding", panels, 3, 1.2, alt)


COMPRESSION = MotionPage(sliding, parts)
