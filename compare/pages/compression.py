"""The page of compression with friction by several ICs, from its dataset."""

import xarray as xr

from compare.pages.contact_numbers import tolerance
from compare.pages.friction import (
    MotionPage,
    PageParts,
    abscissa,
    by_friction,
    curves_by_ics,
    difference,
    difference_panel,
    difference_unit,
    friction_text,
    main_number,
    percent_change,
    place_text,
    places,
    reference_symbol,
    signed_text,
    verdict_cells,
    verdict_text,
    worst_friction,
)
from compare.report.charts import Chart, Panel
from compare.report.looks import ics_symbol
from compare.report.parts import range_text
from compare.report.tables import Cell, Column, Row, Table, number_text, with_estimate
from femic.results.contact import compared_ics, reference_ics

EVERYWHERE = "at every load", "at one load or more"
NOTE = (
    "Sliding area divided by contact area. Band: estimated error of {0}, which includes the error from the "
    "load steps. Bars: estimated errors of the differences; dotted lines: the tolerance, key ics_tolerance "
    "of the scene."
)
SLIDING = "sliding area [% of contact area]"


def parts(dataset: xr.Dataset) -> PageParts:
    """Return with which ICs sliding areas are within the tolerance, and how much slides at the last load."""
    symbol, last = reference_symbol(dataset), place_text(dataset, float(dataset["load"][-1]))
    at_last = dataset.isel(load=-1).sel(ics=reference_ics(dataset))
    share = range_text(100 * at_last.sliding_share, ".0f").replace("...", "to")
    return PageParts(
        summary=(
            f"{verdict_text(dataset, 'the sliding area', EVERYWHERE)} At {last}, {share} % of the contact "
            f"area slides with {symbol} and friction {friction_text(dataset)}. The surface turns by up to "
            f"{float(at_last.angle.max()):.0f}° across the patch. ± is the estimated error."
        ).strip(),
        answer=answer(dataset, last),
        note=NOTE.format(symbol),
        contact=f"At {last}.",
        work="The maps show the work of friction in the last load step, per unit area: −(traction · slip).",
    )


def answer(dataset: xr.Dataset, last: str) -> Table:
    """Return with which ICs sliding areas are within the tolerance, and numbers at the last load."""
    friction, symbol, cells = worst_friction(dataset), reference_symbol(dataset), verdict_cells(dataset)
    by_load = dataset.sel(friction=friction)
    share, known, away = (
        values.isel(load=-1)
        for values in (main_number(by_load), main_number(by_load, "estimate_"), difference(by_load))
    )
    at = by_load.isel(load=-1)
    p_max, rows = at.p_max.sel(ics=reference_ics(dataset)), list[Row]()
    for name in [reference_ics(dataset), *compared_ics(dataset)]:
        contact, apart = at.sel(ics=name), ["", ""]
        if name in cells:
            moved = signed_text(away.sel(ics=name), known.sel(ics=reference_ics(dataset)))
            apart = [moved, f"{number_text(percent_change(contact.p_max, p_max), '+.1f')} %"]
        texts = [
            with_estimate(share.sel(ics=name), known.sel(ics=name)),
            with_estimate(contact.p_max, contact.estimate_p_max),
        ]
        numbers = [Cell(text, below=below) for text, below in zip(texts, apart, strict=True)]
        rows.append(Row(ics_symbol(name), [cells.get(name, Cell("reference")), *numbers]))
    columns = [
        Column(f"sliding area within {tolerance(dataset):g} {difference_unit(dataset)}?"),
        Column(f"sliding area at {last}, friction {friction:g}", "% of the contact area"),
        Column(f"p_max at {last}, friction {friction:g}", "MPa"),
    ]
    return Table(f"ICs; small: difference from {symbol}", columns, rows)


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
            Panel("against the angle of the patch", "Δδ with the same ICs [°]", SLIDING, by_angle),
        ]

    alt = "sliding part of the contact area with each of the ICs, and differences from the reference"
    return by_friction(dataset, "sliding", panels, 3, 1.2, alt)


COMPRESSION = MotionPage(sliding, parts)
