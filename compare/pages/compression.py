"""Verdict and charts of compression with friction by several ICs."""

from collections.abc import Sequence
from dataclasses import replace

import xarray as xr

from compare.pages.friction import (
    MotionPage,
    abscissa,
    by_friction,
    curves_by_ics,
    difference,
    difference_unit,
    largest_differences,
    main_estimate,
    main_number,
    percent_change,
    place_text,
    places,
    reference_symbol,
    share_curves,
    signed_text,
    worst_friction,
)
from compare.report.charts import Chart, Panel
from compare.report.looks import symbol_of
from compare.report.parts import join_words
from compare.report.tables import Column, Row, Table, number_text, with_estimate
from femic.results.contact import ics_of, others_of, reference_of

SUFFICES = 0.05  # difference of sliding over contact area up to which ICs are said to suffice
SLIDING = "sliding area [% of contact area]"


def summary(dataset: xr.Dataset) -> str:
    """Return how much of the contact slides at the last load, and which ICs suffice to predict it."""
    last, symbol = dataset.isel(load=-1), reference_symbol(dataset)
    of_reference = last.sel(ics=reference_of(dataset))
    shares = join_words(f"{float(share):.0%}" for share in of_reference.sliding_share.values)
    frictions = join_words(f"{friction:g}" for friction in dataset.friction.values)
    begun = (
        f"At {_last(dataset)}, where the patch covers up to {float(of_reference.angle.max()):.0f} degrees, "
        f"{shares} of the contact area slides with {symbol} and friction {frictions}."
    )
    return f"{begun} {_verdict(dataset)}"


def _last(dataset: xr.Dataset) -> str:
    """Return the last load with its unit."""
    return place_text(dataset, float(dataset["load"][-1]))


def _verdict(dataset: xr.Dataset) -> str:
    """Return which ICs have ratios close enough to the reference's at all loads, and which do not."""
    if not others_of(dataset):
        return f"No other ICs than {reference_symbol(dataset)} are compared."
    reference = dataset.sel(ics=reference_of(dataset))
    away = abs(dataset.sliding_share - reference.sliding_share)
    worst = (away - reference.estimate_sliding_share).clip(0).max(["friction", "load"])
    enough, others = (
        [name for name in others_of(dataset) if (float(worst.sel(ics=name)) <= SUFFICES) == suffices]
        for suffices in (True, False)
    )
    symbol = reference_symbol(dataset)
    near = f"within {SUFFICES:.0%} of the area from {symbol}, beyond its estimate, at all loads"
    if not enough:
        return f"None is {near}: {_list_names(others, away)} away at most."
    begun = f"{join_words(map(symbol_of, enough))} {'is' if len(enough) == 1 else 'are'} {near}"
    furthest = join_words(f"{float(away.sel(ics=name).max()):.0%}" for name in enough)
    begun += f" (at most {furthest} away)"
    return f"{begun}, but not {_list_names(others, away)}." if others else f"{begun}."


def _list_names(names: Sequence[str], away: xr.DataArray) -> str:
    """Return ICs with their largest distances from the reference."""
    return join_words(f"{symbol_of(name)} ({float(away.sel(ics=name).max()):.0%})" for name in names)


def answer(dataset: xr.Dataset) -> Table:
    """Return how much slides at the last load and the friction where ICs differ most, and differences."""
    friction, symbol = worst_friction(dataset), reference_symbol(dataset)
    of_friction = dataset.sel(friction=friction)
    at = of_friction.isel(load=-1)
    share, known_share, away = (
        of(of_friction).isel(load=-1) for of in (main_number, main_estimate, difference)
    )
    columns = [
        Column(f"sliding area at {_last(dataset)}, friction {friction:g}", "% of contact"),
        Column(f"minus that with {symbol}", "% of contact"),
        Column("largest difference at all loads, any friction", "% of contact"),
        Column(f"p_max at {_last(dataset)}, friction {friction:g}", "MPa"),
        Column(f"off {symbol} by", "%"),
    ]
    known = known_share.sel(ics=reference_of(dataset))
    largest, known_largest = largest_differences(dataset)
    p_max = at.p_max.sel(ics=reference_of(dataset))
    rows = []
    for name in ics_of(dataset):
        contact, is_reference = at.sel(ics=name), name == reference_of(dataset)
        cells = [
            with_estimate(share.sel(ics=name), known_share.sel(ics=name)),
            "" if is_reference else signed_text(away.sel(ics=name), known),
            "" if is_reference else with_estimate(largest.sel(ics=name), known_largest.sel(ics=name)),
            with_estimate(contact.p_max, contact.estimate_p_max),
            "" if is_reference else number_text(percent_change(contact.p_max, p_max), "+.1f"),
        ]
        rows.append(Row(symbol_of(name), cells))
    return Table("ICs", columns, rows)


def sliding(dataset: xr.Dataset) -> Chart:
    """Return sliding over contact area by all ICs, over the load and the angle, and its difference."""

    def panels(of_friction: xr.Dataset) -> list[Panel]:
        share, estimate = main_number(of_friction), main_estimate(of_friction)
        across, symbol = abscissa(dataset).title, reference_symbol(dataset)
        cells = [Panel("over the load", across, SLIDING, share_curves(places(dataset), share, estimate))]
        if others_of(dataset):
            away = curves_by_ics(places(dataset), difference(of_friction), estimate)
            up = f"difference [{difference_unit(dataset)}]"
            cells.append(Panel(f"minus the share with {symbol}", across, up, away))
        over_angle = share_curves(of_friction.angle, share, estimate)
        return [
            *cells,
            Panel("over the angle of the patch", "Δδ with the same ICs [deg]", SLIDING, over_angle),
        ]

    alt = "sliding share of the contact area by ICs, and differences from the reference's"
    return replace(by_friction(dataset, "sliding", panels), heights=1.2, alt=alt)


def note(dataset: xr.Dataset) -> str:
    """Return what the main chart shows."""
    return (
        f"Sliding area over contact area. Band: estimate of {reference_symbol(dataset)}, which includes the "
        "error of the steps of load."
    )


def contact(dataset: xr.Dataset) -> str:
    """Return at which load the maps are."""
    return f"At {_last(dataset)}."


COMPRESSION = MotionPage(
    summary,
    answer,
    sliding,
    note,
    contact,
    "Minus traction times slip in the last step of load, per area.",
)
