"""`femic contact` solves the contact of a scene with several ICs and writes the file, figures and report."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
import xarray as xr

from compare.contact import figures, sensitivity
from compare.contact.compute import ContactResults, reference_name
from compare.contact.dataset import to_dataset, with_supports
from compare.contact.quantities import QUANTITIES
from compare.finite_elements.compute import kept_fe_contact
from compare.finite_elements.dataset import FE, OF_PLACE
from compare.finite_elements.dataset import NUMBERS as KNOWN_TO_FE
from compare.finite_elements.page import of_approaches, over_angle
from compare.finite_elements.page import summary as fe_summary
from compare.matrix.compute import discounted
from compare.report import views
from compare.report.html import write_page
from compare.report.parts import changed_cell, listed, onset
from compare.report.styles import save, symbol_of
from femic.cache import folders
from femic.cache.files import write_dataset
from femic.cache.store import Store
from geometries.patches import N

RELIEF, LIFTED = 0.2, 0.02  # height of the largest pressure over the grid's width; of none, over that
NOTHING_KEPT = Store()
NO_OTHERS: Mapping[str, Mapping[str, float]] = MappingProxyType({})
SIDEWAYS = 1e-3  # lateral force over load from which the summary speaks of it
FAILS = 0.05  # deviation of the largest pressure from which the summary says that ICs fail


def write_contact(
    results: ContactResults,
    out: Path,
    store: Store = NOTHING_KEPT,
    supports: Mapping[str, Mapping[str, float]] = NO_OTHERS,
) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page.

    What finite elements without ICs have found of the same contacts stands beside, as far as the store has
    it; so do the numbers of the largest contact with other `supports`, by what is other.
    """
    folders.make(out)
    scene = results.scene
    dataset = with_supports(to_dataset(results), supports)
    by_fe = kept_fe_contact(scene, dataset, store)
    write_dataset(dataset, out / "contact.nc")
    (out / "figures").mkdir(exist_ok=True)
    drawn = [
        save(draw(dataset), out / "figures" / f"contact_{name}.png")
        for name, draw in (
            ("numbers", figures.over_angle),
            ("profiles", figures.profiles),
            ("surfaces", figures.surfaces),
        )
    ]
    if views.can_render():
        drawn += list(_drawn_in_3d(results, out / "figures"))
    deviations = "" if by_fe is None else save(over_angle(by_fe), out / "figures" / "contact_fe.png")
    return write_page(
        out / "contact.html",
        "contact.html.j2",
        by_fe="" if by_fe is None else fe_summary(by_fe),
        fe_figures=[deviations] if deviations else [],
        of_approaches="" if by_fe is None else of_approaches(by_fe),
        title=str(dataset.attrs["title"]),
        summary=summary(dataset),
        reference=symbol_of(figures.reference_of(dataset)),
        quantities=QUANTITIES,
        tables=[
            {
                "case": str(case),
                "rows": [*_rows(dataset.sel(case=case)), *_fe_row(dataset, by_fe, number)],
            }
            for number, case in enumerate(dataset.case.values)
        ],
        grids=list(_grids(results)),
        discounted=discounted(scene),
        supports=list(_support_rows(dataset)),
        figures=drawn,
        seconds=f"{results.seconds:.1f}",
        text=scene.text,
    )


def _drawn_in_3d(results: ContactResults, folder: Path) -> Iterator[Path]:
    """Draw pressures of the reference on the lower surface, as heights and colours, a picture per case."""
    name = reference_name(results.ics)
    for number, case in enumerate(results.cases):
        contact = results.contacts[case, name]
        surface, grid = contact.placed.undeformed.lower, contact.placed.grid
        p = np.where(contact.normal.in_contact, contact.normal.p, np.nan)
        x = np.linspace(contact.placed.x[0], contact.placed.x[-1], 2)
        s = np.linspace(*surface.contour.limits, 200)
        path = folder / f"contact_3d_{number}.png"
        rail, patch = (
            np.reshape(surface.position(*map(np.ravel, np.meshgrid(*at, indexing="ij"))), (3, *map(len, at)))
            for at in ((x, s), (contact.placed.x, grid.strips))
        )
        heights = RELIEF * grid.n_s * grid.ds * (contact.normal.p / contact.normal.p.max() + LIFTED)
        raised = patch + heights * surface.axes(0.0, grid.strips)[N][:, None]
        views.draw_pressures(rail, raised, p, path, title=f"{case}, pressures by {name}")
        yield path


def write_sensitivity(results: Mapping[str, ContactResults], out: Path) -> Path:
    """Write maps of where A and B-hat differ, of two or more scenes, and their page; returns its path."""
    (folders.make(out) / "figures").mkdir(exist_ok=True)
    drawn = save(sensitivity.maps(results), out / "figures" / "sensitivity.png")
    return write_page(
        out / "contact.html",
        "sensitivity.html.j2",
        title=f"Where A and B̂ differ: {', '.join(results)}",
        summary=sensitivity.summary(results),
        figures=[drawn],
    )


def summary(dataset: xr.Dataset) -> str:
    """Sentences computed from the numbers: what each of the ICs changes, and from which angle on."""
    reference = figures.reference_of(dataset)
    angle = dataset.angle.sel(ics=reference)
    sentences = [
        f"{_cases(dataset.sizes['case'])} over {_degrees(float(angle.min()), float(angle.max()))} degrees by "
        f"{symbol_of(reference)}."
    ]
    for name in (str(name) for name in dataset.ics.values if name != reference):
        deviations = {
            key: dataset[key].sel(ics=name) / dataset[key].sel(ics=reference) - 1
            for key in ("p_max", "b", "approach")
        }
        worst = {
            key: float(values.values[np.argmax(np.abs(values.values))]) for key, values in deviations.items()
        }
        failing = onset(angle.values, (abs(deviations["p_max"]) > FAILS).values)
        fails = (
            f"; p_max is off by more than {FAILS:.0%} {failing}"
            if failing
            else f"; p_max is within {FAILS:.0%} everywhere"
        )
        sentences.append(
            f"{symbol_of(name)}: p_max {worst['p_max']:+.1%}, b {worst['b']:+.1%}, approach "
            f"{worst['approach']:+.1%} of {symbol_of(reference)}'s at worst{fails}."
        )
    sentences += _beside_the_crown(dataset)
    seconds = dataset.seconds.values
    sentences.append(
        f"Pressures took {seconds.min():.2g} ... {seconds.max():.2g} s a case"
        + (f", C on its grids {_seconds_of_c(dataset):.0f} s." if "C" in dataset.ics else ".")
    )
    displaced = abs(dataset.displaced_p_max / dataset.p_max - 1).sel(ics=reference)
    if displaced.notnull().any():
        sentences.append(
            f"The exact distance of the displaced body instead of the linearised one changes p_max by up to "
            f"{float(displaced.max()):.1%}."
        )
    return " ".join(sentences)


def _beside_the_crown(dataset: xr.Dataset) -> Iterator[str]:
    """Yield what the ICs say of the lateral force, where the contact is not symmetric."""
    share = (dataset.F_y / dataset["load"]).transpose("case", "ics")
    reference = figures.reference_of(dataset)
    of_reference = share.sel(ics=reference)
    worst = int(np.argmax(np.abs(of_reference.values)))
    if abs(float(of_reference[worst])) < SIDEWAYS:
        return
    others = listed(
        f"{float(share.sel(ics=name)[worst]):+.3f} by {symbol_of(str(name))}"
        for name in dataset.ics.values
        if name != reference
    )
    yield (
        f"The lateral force on the upper body is {float(of_reference[worst]):+.3f} of the load by "
        f"{symbol_of(reference)} at {dataset.case.values[worst]}"
        + (f", {others}: approximations lack the bending of the sections." if others else ".")
    )


def _cases(number: int) -> str:
    return "One case, a patch" if number == 1 else f"{number} cases, patches"


def _degrees(least: float, largest: float) -> str:
    low, high = f"{least:.0f}", f"{largest:.0f}"
    return low if low == high else f"{low} ... {high}"


def _seconds_of_c(dataset: xr.Dataset) -> float:
    return sum(float(of_grid["seconds"]) for of_grid in json.loads(dataset.attrs["references"]).values())


def _rows(case: xr.Dataset) -> Iterator[dict[str, object]]:
    """Yield a row per ICs: each number with its estimate, its ratio to the reference, and the cost."""
    reference = case.sel(ics=figures.reference_of(case))
    for name in map(str, case.ics.values):
        of_ics = case.sel(ics=name)
        ratios = of_ics / reference
        yield {
            "symbol": symbol_of(name),
            "cells": [
                {
                    "text": f"{float(of_ics[key]):.5g}",
                    "below": f"± {float(of_ics[f'estimate_{key}']):.2g}; {float(ratios[key]):.4f}",
                }
                for key in QUANTITIES
            ],
            "displaced": f"{float(of_ics.displaced_p_max):.5g}" if of_ics.displaced_p_max.notnull() else "–",
            "iterations": int(of_ics.iterations),
            "seconds": f"{float(of_ics.seconds):.2f}",
        }


def _support_rows(dataset: xr.Dataset) -> Iterator[dict[str, object]]:
    """Yield what other supports change of the largest contact by C, a row per change."""
    if "supports" not in dataset.coords:
        return
    by_c = dataset.sel(ics="C").isel(case=int(dataset.attrs["supported_case"]))
    for name in dataset.supports.values:
        other = dataset.sel(supports=name)
        yield {
            "name": str(name),
            "cells": [
                changed_cell(other[f"supported_{key}"], by_c[key], by_c[f"estimate_{key}"])
                for key in QUANTITIES
            ],
        }


def _fe_row(dataset: xr.Dataset, by_fe: xr.Dataset | None, number: int) -> Iterator[dict[str, object]]:
    """Yield the row of finite elements, where they have solved a case; they know some of the numbers."""
    if by_fe is None or np.isnan(float(by_fe.a.isel(case=number).sel(ics=FE))):
        return
    reference = dataset.isel(case=number).sel(ics=figures.reference_of(dataset))
    of_fe = by_fe.isel(case=number).sel(ics=FE)
    unknown = {"text": "–", "below": ""}
    yield {
        "symbol": FE,
        "cells": [
            {
                "text": f"{float(of_fe[key]):.5g}",
                "below": f"± {float(of_fe[f'estimate_{key}']):.2g}"
                + ("" if key in OF_PLACE else f"; {float(of_fe[key] / reference[key]):.4f}"),
            }
            if key in KNOWN_TO_FE
            else unknown
            for key in QUANTITIES
        ],
        "displaced": "–",
        "iterations": "–",
        "seconds": f"{float(by_fe.fe_seconds.isel(case=number).sum()):.0f}",
    }


def _grids(results: ContactResults) -> Iterator[dict[str, str]]:
    """Yield what is known of each grid and of C on it."""
    placed = {contact.placed.grid: contact.case for contact in results.contacts.values()}
    for grid in placed:
        c = results.references.get(grid)
        yield {
            "grid": f"{grid.n_x} x {grid.n_s} elements of {grid.dx:.4g} x {grid.ds:.4g} mm",
            "estimate": f"{c.estimate:.2%}" if c else "–",
            "asymmetry": f"{c.asymmetry:.1e}" if c else "–",
            "eigenvalue": f"{c.eigenvalue:.3f}" if c else "–",
            "seconds": f"{c.seconds:.1f}" if c else "–",
        }
