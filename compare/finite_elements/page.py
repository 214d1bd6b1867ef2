"""Figures, sentences, table and page of contact with ICs beside contact with finite elements."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.finite_elements.dataset import FE, NUMBERS, OF_PATCH, OF_PLACE
from compare.finite_elements.deviations import deviations, differences, known
from compare.report.panels import draw_band, draw_by_ics, grid_of
from compare.report.parts import Page, Part, closing, furthest, listed, onset, span, write_results
from compare.report.styles import symbol_of
from compare.report.tables import Cell, Row, Table, columns_of
from femic.contact.pairs.quantities import OF_FRICTIONLESS

SHARES = (0.01, 0.02, 0.05)  # deviations: the summary says from which angle on they are exceeded
DRAWN = ("p_max", "a", "b", "approach")
SIDEWAYS = 1e-6  # lateral force over load from which a contact counts as not symmetric
OF_APPROACHES = (
    "Approaches with FE and with C are without the rigid part M_zz of the compliance, which the models of C "
    "give on the same supports; nothing is fitted. Approximations have no supports: they give the approach "
    "of half-spaces in contact."
)
RAW = (
    "Approaches with FE and with C contain the compliance of the whole bodies, approaches with "
    "approximations do not."
)
BELOW = (
    "Small, below each number: its estimated error, and how far it is from the number by finite elements "
    "(FE): as a share, but in its unit where it vanishes by symmetry. "
)


def write_fe_contact(dataset: xr.Dataset, out: Path) -> Path:
    """Write `fe_contact.nc`, figures and `fe_contact.html` into a folder; returns the path of the page."""
    title = str(dataset.attrs["title"]).replace(
        "Frictionless contact", "Contact with ICs, and with finite elements"
    )
    tables = [_table(dataset, number) for number in range(dataset.sizes["case"])]
    end = closing(tables, BELOW + of_approaches(dataset), cost(dataset), str(dataset.attrs["scene"]))
    return write_results(
        Page(title, summary(dataset), chain(_parts(dataset), end)), out, "fe_contact", dataset
    )


def of_approaches(dataset: xr.Dataset) -> str:
    """The sentence on what approaches contain."""
    return OF_APPROACHES if float(dataset.rigid_compliance) else RAW


def off_by(dataset: xr.Dataset, ics: str, share: float) -> xr.DataArray:
    """In which cases a number of the patch is off by more than a share and the estimate."""
    return xr.concat(
        [abs(deviations(dataset, name).sel(ics=ics)) > share + known(dataset, name) for name in OF_PATCH],
        "quantity",
    ).any("quantity")


def summary(dataset: xr.Dataset) -> str:
    """Sentences computed from the numbers: how far ICs are from finite elements, and from where on."""
    solved = np.flatnonzero(dataset.angle.sel(ics=FE).notnull())
    dataset, angle = dataset.isel(case=solved), dataset.angle.sel(ics=FE)
    sentences = [
        f"Patches over {float(angle.min()):.0f} ... {float(angle.max()):.0f} degrees. Numbers of the patch "
        f"by finite elements are known to {max(float(known(dataset, name).max()) for name in OF_PATCH):.1%}."
    ]
    for name in (str(name) for name in dataset.ics.values if name != FE):
        worst = listed(f"{furthest(deviations(dataset, key).sel(ics=name)):+.1%} in {key}" for key in DRAWN)
        sentences.append(f"{symbol_of(name)}: at worst {worst}; {_from_where(dataset, name)}.")
    sentences += _beside_the_crown(dataset)
    if dataset.attrs["left_out"]:
        sentences.append(f"Finite elements did not solve {dataset.attrs['left_out']}")
    return " ".join(sentences)


def _beside_the_crown(dataset: xr.Dataset) -> Iterator[str]:
    """Yield what all say of lateral force and centre of pressure, in the case where the force is largest."""
    share = abs(dataset.F_y / dataset["load"]).sel(ics=FE)
    worst = int(np.nanargmax(share.values))
    if float(share[worst]) < SIDEWAYS:
        return
    case = dataset.isel(case=worst)
    of_fe, load = case.sel(ics=FE), float(case["load"])
    force, to = float(of_fe.F_y) / load, float(of_fe.estimate_F_y) / load
    by_ics = listed(
        f"{float(case.F_y.sel(ics=name)) / load:+.3f}, {float(case.s_centre.sel(ics=name)):+.2f} mm with "
        f"{symbol_of(str(name))}"
        for name in dataset.ics.values
        if name != FE
    )
    yield (
        f"Beside the crown, at {dataset.case.values[worst]}: by finite elements the lateral force on the "
        f"upper body is {force:+.3f} ± {to:.1g} of the load, the centre of pressure "
        f"{float(of_fe.s_centre):+.2f} ± {float(of_fe.estimate_s_centre):.1g} mm; {by_ics}."
    )


def _from_where(dataset: xr.Dataset, ics: str) -> str:
    """From which angles on ICs are further from finite elements than some shares and the estimate."""
    angles = dataset.angle.sel(ics=FE).values
    found = {share: onset(angles, off_by(dataset, ics, share).values) for share in SHARES}
    exceeded = [f"more than {share:.0%} {where}" for share, where in found.items() if where]
    return (
        f"beyond the estimate, off by {listed(exceeded)}"
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
    """Deviations of all ICs from finite elements over the angle of the patch, a panel per number."""
    cases = dataset.isel(case=np.argsort(dataset.angle.sel(ics=FE).values))
    angle = cases.angle.sel(ics=FE)
    with grid_of(1, len(DRAWN), (3.2, 2.9)) as (figure, grid):
        for axes, key in zip(grid[0], DRAWN, strict=True):
            off, band = 100 * deviations(cases, key), 100 * known(cases, key)
            draw_by_ics(axes, angle, off)
            draw_band(axes, angle, -band, band, "estimate of FE")
            axes.set(title=OF_FRICTIONLESS[key].symbol, xlabel="Δδ with FE [deg]")
        figure.axes[0].set_ylabel("ICs minus FE, over FE [%]")
    return figure


def profiles(dataset: xr.Dataset) -> Figure:
    """Pressures along s at x = 0 by finite elements and all ICs, a panel per case."""
    with grid_of(1, dataset.sizes["case"], (4.1, 2.9)) as (figure, grid):
        for number, axes in enumerate(grid[0]):
            _draw_profile(axes, dataset, number)
            axes.set(xlabel="s [mm]", title=str(dataset.case.values[number]))
        figure.axes[0].set_ylabel("pressure at x = 0 [MPa]")
    return figure


def _draw_profile(axes: Axes, dataset: xr.Dataset, number: int) -> None:
    p = dataset[f"p_{number}"]
    at = p[f"s_{number}"]
    shown = np.flatnonzero((p > 0).any("ics"))
    part = slice(max(shown[0] - 1, 0), shown[-1] + 2)
    draw_by_ics(axes, at[part], p.dropna("ics", how="all")[..., part], 0)
    if f"p_fe_{number}" not in dataset:
        return
    of_fe, s = dataset[f"p_fe_{number}"], dataset[f"s_fe_{number}"]
    inside = (s >= at[part].values[0]) & (s <= at[part].values[-1])
    axes.plot(s[inside], of_fe[inside], "o", color="black", markersize=2.5, label=FE)


def _table(dataset: xr.Dataset, number: int) -> Table:
    """All numbers of a case."""
    case = dataset.isel(case=number)
    columns = columns_of(OF_FRICTIONLESS[name] for name in NUMBERS)
    rows = [
        Row(FE if name == FE else symbol_of(name), [_cell(dataset, number, name, key) for key in NUMBERS])
        for name in map(str, case.ics.values)
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
    """Whether there is no lateral force in a case, but for rounding."""
    case = dataset.isel(case=number)
    return bool((abs(case.F_y) < SIDEWAYS * case["load"]).all())


def cost(dataset: xr.Dataset) -> str:
    """What finite elements took, and how well they hold what contact has to satisfy."""
    load = dataset["load"].values
    balance = [
        *abs(dataset.fe_load_of_pressures.values / load - 1),
        *abs(np.abs(dataset.fe_reaction.values) / load[:, None] - 1).ravel(),
    ]
    most = {name: float(dataset[f"fe_{name}"].max()) for name in ("memory", "tension", "penetration")}
    return (
        f"Finite elements: {span(_all(dataset.fe_unknowns, 'body'), ',.0f')} unknowns of the modelled "
        f"parts, {span(_all(dataset.fe_seconds, 'stage'), '.0f')} s a load, up to "
        f"{most['memory'] / 1e3:.1f} GB. Pressures and reactions carry the load to {np.nanmax(balance):.1g}, "
        f"tensions are at most {most['tension']:.1g} of the largest pressure, penetrations "
        f"{most['penetration']:.1g} of the approach. Rigid part of the compliance that is taken from "
        f"approaches: M_zz = {float(dataset.rigid_compliance):.4g} mm/N. Contacts with ICs took "
        f"{span(dataset.seconds.values, '.2g')} s."
    )


def _all(values: xr.DataArray, dim: str) -> np.ndarray:
    """Sums along a dimension by case, NaN where nothing was solved."""
    return np.asarray(values.sum(dim, min_count=1).values)
