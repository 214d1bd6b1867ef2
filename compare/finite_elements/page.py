"""Figures, sentences, table and page of contact with ICs beside contact with finite elements."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.contact.dataset import ics_of
from compare.contact.figures import loaded_part
from compare.finite_elements.dataset import FE, NUMBERS, OF_PATCH, OF_PLACE
from compare.finite_elements.deviations import deviations, differences, relative_estimates
from compare.report.panels import draw_band, draw_by_ics, figure_grid
from compare.report.parts import (
    Page,
    Part,
    extreme,
    final_sections,
    join_words,
    onset,
    range_text,
    write_results,
)
from compare.report.styles import symbol_of
from compare.report.tables import Cell, Row, Table, columns_of
from femic.contact.pairs.quantities import OF_FRICTIONLESS

SHARES = (0.01, 0.02, 0.05)  # deviations: the summary gives the angles from which they are exceeded
DRAWN = ("p_max", "a", "b", "approach")
SIDEWAYS = 1e-6  # lateral force over load from which a contact counts as unsymmetric
WITHOUT_RIGID = (
    "Approaches with FE and with C exclude the rigid part M_zz of the compliance, computed by the models of "
    "C on the same supports; nothing is fitted. Approximations have no supports: they give the approach of "
    "half-spaces in contact."
)
RAW = (
    "Approaches with FE and with C contain the compliance of the whole bodies, approaches with "
    "approximations do not."
)
BELOW = (
    "Small, below each number: its estimated error, and its deviation from finite elements (FE), as a share, "
    "or in its unit where it vanishes by symmetry. "
)


def write_fe_contact(dataset: xr.Dataset, out: Path) -> Path:
    """Write `fe_contact.nc`, figures and `fe_contact.html` into a folder; returns the path of the page."""
    title = str(dataset.attrs["title"]).replace(
        "Frictionless contact", "Contact with ICs, and with finite elements"
    )
    tables = [_table(dataset, number) for number in range(dataset.sizes["case"])]
    end = final_sections(tables, BELOW + approach_note(dataset), cost(dataset), str(dataset.attrs["scene"]))
    return write_results(
        Page(title, summary(dataset), chain(_parts(dataset), end)), out, "fe_contact", dataset
    )


def approach_note(dataset: xr.Dataset) -> str:
    """Return the note on the content of approaches."""
    return WITHOUT_RIGID if float(dataset.rigid_compliance) else RAW


def exceeds(dataset: xr.Dataset, ics: str, share: float) -> xr.DataArray:
    """Return in which cases a number of the patch deviates by more than a share and the estimate."""
    exceeding = [
        abs(deviations(dataset, name).sel(ics=ics)) > share + relative_estimates(dataset, name)
        for name in OF_PATCH
    ]
    return xr.concat(exceeding, "quantity").any("quantity")


def summary(dataset: xr.Dataset) -> str:
    """Return sentences computed from the numbers: deviations of ICs from finite elements, and their onset."""
    angle = dataset.angle.sel(ics=FE)
    dataset = dataset.isel(case=angle.notnull().values)
    estimate = max(float(relative_estimates(dataset, name).max()) for name in OF_PATCH)
    sentences = [
        f"Patches over {float(angle.min()):.0f} ... {float(angle.max()):.0f} degrees. Estimated error of the "
        f"patch by finite elements: {estimate:.1%}."
    ]
    for name in _compared(dataset):
        worst = join_words(
            f"{extreme(deviations(dataset, key).sel(ics=name)):+.1%} in {key}" for key in DRAWN
        )
        sentences.append(f"{symbol_of(name)}: at worst {worst}; {_from_where(dataset, name)}.")
    sentences += _lateral_force_sentence(dataset)
    if dataset.attrs["left_out"]:
        sentences.append(f"Finite elements did not solve {dataset.attrs['left_out']}")
    return " ".join(sentences)


def _compared(dataset: xr.Dataset) -> list[str]:
    """Return the ICs that are compared with finite elements."""
    return [name for name in ics_of(dataset) if name != FE]


def _lateral_force_sentence(dataset: xr.Dataset) -> Iterator[str]:
    """Yield lateral force and centre of pressure in the case where the force is largest."""
    share = abs(dataset.F_y / dataset["load"]).sel(ics=FE)
    worst = int(np.nanargmax(share.values))
    if float(share[worst]) < SIDEWAYS:
        return
    case = dataset.isel(case=worst)
    with_fe, load = case.sel(ics=FE), float(case["load"])
    force, to = float(with_fe.F_y) / load, float(with_fe.estimate_F_y) / load
    by_ics = join_words(
        f"{float(case.F_y.sel(ics=name)) / load:+.3f}, {float(case.s_centre.sel(ics=name)):+.2f} mm with "
        f"{symbol_of(name)}"
        for name in _compared(dataset)
    )
    yield (
        f"Beside the crown, at {dataset.case.values[worst]}: by finite elements the lateral force on the "
        f"upper body is {force:+.3f} ± {to:.1g} of the load, the centre of pressure "
        f"{float(with_fe.s_centre):+.2f} ± {float(with_fe.estimate_s_centre):.1g} mm; {by_ics}."
    )


def _from_where(dataset: xr.Dataset, ics: str) -> str:
    """Return the angles from which ICs deviate by more than some shares and the estimate."""
    angles = dataset.angle.sel(ics=FE).values
    onsets = {share: onset(angles, exceeds(dataset, ics, share).values) for share in SHARES}
    exceeded = [f"more than {share:.0%} {where}" for share, where in onsets.items() if where]
    return (
        f"beyond the estimate, off by {join_words(exceeded)}"
        if exceeded
        else f"within {SHARES[0]:.0%} and the estimate"
    )


def _parts(dataset: xr.Dataset) -> Iterator[Part]:
    yield Part(
        "Deviations over the angle of the patch",
        "Numbers with ICs over the numbers with finite elements, minus 1. Band: estimate of finite elements.",
        "deviations",
        over_angle(dataset),
    )
    yield Part(
        "Pressures across the patch",
        "At x = 0, with finite elements, and with ICs on the elements beside it.",
        "profiles",
        profiles(dataset),
    )


def over_angle(dataset: xr.Dataset) -> Figure:
    """Draw deviations of all ICs from finite elements over the angle of the patch, a panel per number."""
    cases = dataset.isel(case=np.argsort(dataset.angle.sel(ics=FE).values))
    angle = cases.angle.sel(ics=FE)
    with figure_grid(1, len(DRAWN), (3.2, 2.9)) as (figure, grid):
        for axes, key in zip(grid[0], DRAWN, strict=True):
            off, band = 100 * deviations(cases, key), 100 * relative_estimates(cases, key)
            draw_by_ics(axes, angle, off)
            draw_band(axes, angle, -band, band, "estimate of FE")
            axes.set(title=OF_FRICTIONLESS[key].symbol, xlabel="Δδ with FE [deg]")
        figure.axes[0].set_ylabel("ICs minus FE, over FE [%]")
    return figure


def profiles(dataset: xr.Dataset) -> Figure:
    """Draw pressures along s at x = 0 by finite elements and all ICs, a panel per case."""
    with figure_grid(1, dataset.sizes["case"]) as (figure, grid):
        for number, axes in enumerate(grid[0]):
            _draw_profile(axes, dataset, number)
            axes.set(xlabel="s [mm]", title=str(dataset.case.values[number]))
        figure.axes[0].set_ylabel("pressure at x = 0 [MPa]")
    return figure


def _draw_profile(axes: Axes, dataset: xr.Dataset, number: int) -> None:
    p = dataset[f"p_{number}"]
    at = p[f"s_{number}"]
    part = loaded_part(p)
    draw_by_ics(axes, at[part], p.dropna("ics", how="all")[..., part], 0)
    if f"p_fe_{number}" not in dataset:
        return
    with_fe, s = dataset[f"p_fe_{number}"], dataset[f"s_fe_{number}"]
    inside = (s >= at[part].values[0]) & (s <= at[part].values[-1])
    axes.plot(s[inside], with_fe[inside], "o", color="black", markersize=2.5, label=FE)


def _table(dataset: xr.Dataset, number: int) -> Table:
    """Return the table of all numbers of a case."""
    case = dataset.isel(case=number)
    columns = columns_of(OF_FRICTIONLESS[name] for name in NUMBERS)
    rows = [
        Row(FE if name == FE else symbol_of(name), [_cell(dataset, number, name, key) for key in NUMBERS])
        for name in ics_of(case)
    ]
    return Table(str(case.case.values), columns, rows)


def _cell(dataset: xr.Dataset, number: int, ics: str, key: str) -> Cell:
    case = dataset.isel(case=number).sel(ics=ics)
    value, estimate = (float(case[name]) for name in (key, f"estimate_{key}"))
    if key in OF_PLACE and _symmetric(dataset, number):
        return Cell("0")
    apart, form = (differences, "+.2g") if key in OF_PLACE else (deviations, "+.2%")
    off = "" if ics == FE else f", {float(apart(dataset, key).isel(case=number).sel(ics=ics)):{form}}"
    return Cell(value, ".4g", f"± {estimate:.1g}{off}")


def _symmetric(dataset: xr.Dataset, number: int) -> bool:
    """Return whether a case has no lateral force except rounding."""
    case = dataset.isel(case=number)
    return bool((abs(case.F_y) < SIDEWAYS * case["load"]).all())


def cost(dataset: xr.Dataset) -> str:
    """Return the cost of finite elements, and how well they satisfy the conditions of contact."""
    load = dataset["load"].values
    balance = [
        *abs(dataset.fe_load_of_pressures.values / load - 1),
        *abs(np.abs(dataset.fe_reaction.values) / load[:, None] - 1).ravel(),
    ]
    most = {name: float(dataset[f"fe_{name}"].max()) for name in ("memory", "tension", "penetration")}
    return (
        f"Finite elements: {range_text(_all(dataset.fe_unknowns, 'body'), ',.0f')} unknowns of the modelled "
        f"parts, {range_text(_all(dataset.fe_seconds, 'stage'), '.0f')} s a load, up to "
        f"{most['memory'] / 1e3:.1f} GB. Pressures and reactions carry the load to {np.nanmax(balance):.1g}, "
        f"tensions are at most {most['tension']:.1g} of the largest pressure, penetrations "
        f"{most['penetration']:.1g} of the approach. Rigid part of the compliance, subtracted from "
        f"approaches: M_zz = {float(dataset.rigid_compliance):.4g} mm/N. Contacts with ICs took "
        f"{range_text(dataset.seconds.values, '.2g')} s."
    )


def _all(values: xr.DataArray, dim: str) -> np.ndarray:
    """Return sums along a dimension by case, NaN where nothing was solved."""
    return np.asarray(values.sum(dim, min_count=1).values)
