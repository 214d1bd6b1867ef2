"""Figures, sentences, table and page of contact by ICs beside that by finite elements."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from compare.contact.quantities import QUANTITIES
from compare.finite_elements.dataset import FE, NUMBERS, OF_PATCH, OF_PLACE
from compare.finite_elements.deviations import deviations, differences, known
from compare.report.panels import add_legend
from compare.report.parts import Page, Part, Row, Table, furthest, listed, onset
from compare.report.styles import RC, symbol_of, with_further
from femic.cache import folders
from femic.cache.files import write_dataset

SHARES = (0.01, 0.02, 0.05)  # deviations from which the angles are told
DRAWN = ("p_max", "a", "b", "approach")
SIDEWAYS = 1e-6  # lateral force over load from which a contact counts as not symmetric
OF_APPROACHES = (
    "Approaches by FE and by C are without the rigid part M_zz of the compliance, which the models of C give "
    "on the same supports; nothing is fitted. Approximations have no supports: their approach is that of "
    "half-spaces under the contact."
)
RAW = (
    "Approaches by FE and by C have the compliance of the whole bodies in them; those by approximations not."
)
BELOW = (
    "Small, below each number: its estimated error, and how far it is from that by finite elements (FE): as "
    "a share, but of numbers that vanish where all is symmetric in their unit. "
)


def write_fe_contact(dataset: xr.Dataset, out: Path) -> Path:
    """Write `fe_contact.nc`, figures and `fe_contact.html` into a folder; returns the path of the page."""
    folders.make(out)
    write_dataset(dataset, out / "fe_contact.nc")
    title = str(dataset.attrs["title"]).replace(
        "Frictionless contact", "Contact by ICs, and by finite elements"
    )
    page = Page(
        title,
        summary(dataset),
        list(_parts(dataset)),
        [_table(dataset, number) for number in range(dataset.sizes["case"])],
        BELOW + of_approaches(dataset),
        cost(dataset),
        str(dataset.attrs["scene"]),
    )
    return page.write(out / "fe_contact.html", "fe_contact")


def of_approaches(dataset: xr.Dataset) -> str:
    """What is in approaches, in words."""
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
        f"{float(case.F_y.sel(ics=name)) / load:+.3f}, {float(case.s_centre.sel(ics=name)):+.2f} mm by "
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
    told = [f"more than {share:.0%} {where}" for share, where in found.items() if where]
    return (
        f"beyond the estimate, off by {listed(told)}" if told else f"within {SHARES[0]:.0%} and the estimate"
    )


def _parts(dataset: xr.Dataset) -> Iterator[Part]:
    yield Part(
        "Deviations over the angle of the patch",
        "Numbers by ICs over those by finite elements, less 1. Band: estimate of the latter.",
        "deviations",
        over_angle(dataset),
    )
    yield Part(
        "Pressures across the patch",
        "At x = 0, by finite elements, and by ICs on the elements beside it.",
        "profiles",
        profiles(dataset),
    )


def over_angle(dataset: xr.Dataset) -> Figure:
    """Deviations of all ICs from finite elements over the angle of the patch, a panel per number."""
    cases = dataset.isel(case=np.argsort(dataset.angle.sel(ics=FE).values))
    names, angle = [str(name) for name in cases.ics.values if name != FE], cases.angle.sel(ics=FE)
    looks = with_further(names)
    with mpl.rc_context(RC):
        figure = Figure(figsize=(3.2 * len(DRAWN), 3.4), layout="constrained")
        for axes, key in zip(figure.subplots(1, len(DRAWN)), DRAWN, strict=True):
            off, band = 100 * deviations(cases, key), 100 * known(cases, key)
            for name in names:
                marker, style = looks[name]
                axes.plot(
                    angle, off.sel(ics=name), label=symbol_of(name), **style, marker=marker, markersize=4
                )
            axes.fill_between(
                angle, -band, band, color="black", alpha=0.15, linewidth=0, label="estimate of FE"
            )
            axes.set(title=QUANTITIES[key].symbol, xlabel="Δδ by FE [deg]")
        figure.axes[0].set_ylabel("by ICs less by FE [%]")
        add_legend(figure)
        return figure


def profiles(dataset: xr.Dataset) -> Figure:
    """Pressures along s at x = 0 by finite elements and all ICs, a panel per case."""
    count = dataset.sizes["case"]
    with mpl.rc_context(RC):
        figure = Figure(figsize=(4.1 * count, 3.4), layout="constrained")
        for number, axes in enumerate(figure.subplots(1, count, squeeze=False)[0]):
            _draw_profile(axes, dataset, number)
            axes.set(xlabel="s [mm]", title=str(dataset.case.values[number]))
        figure.axes[0].set_ylabel("pressure at x = 0 [MPa]")
        add_legend(figure)
        return figure


def _draw_profile(axes: mpl.axes.Axes, dataset: xr.Dataset, number: int) -> None:
    p = dataset[f"p_{number}"]
    at = p[f"s_{number}"]
    shown = np.flatnonzero((p > 0).any("ics"))
    part = slice(max(shown[0] - 1, 0), shown[-1] + 2)
    names = [str(name) for name in p.dropna("ics", how="all").ics.values]
    looks = with_further(names)
    for name in names:
        axes.plot(at[part], p.sel(ics=name)[part], label=symbol_of(name), **looks[name][1])
    if f"p_fe_{number}" not in dataset:
        return
    of_fe, s = dataset[f"p_fe_{number}"], dataset[f"s_fe_{number}"]
    inside = (s >= at[part].values[0]) & (s <= at[part].values[-1])
    axes.plot(s[inside], of_fe[inside], "o", color="black", markersize=2.5, label=FE)


def _table(dataset: xr.Dataset, number: int) -> Table:
    """All numbers of a case."""
    case = dataset.isel(case=number)
    columns = [f"{QUANTITIES[name].symbol} [{QUANTITIES[name].unit}]" for name in NUMBERS]
    rows = [
        Row(FE if name == FE else symbol_of(name), [_cell(dataset, number, name, key) for key in NUMBERS])
        for name in map(str, case.ics.values)
    ]
    return Table(str(case.case.values), columns, rows)


def _cell(dataset: xr.Dataset, number: int, ics: str, key: str) -> dict[str, str]:
    case = dataset.isel(case=number).sel(ics=ics)
    value, estimate = (float(case[name]) for name in (key, f"estimate_{key}"))
    if key in OF_PLACE and _symmetric(dataset, number):
        return {"text": "0", "below": ""}
    apart, form = (differences, "+.2g") if key in OF_PLACE else (deviations, "+.2%")
    off = "" if ics == FE else f", {float(apart(dataset, key).isel(case=number).sel(ics=ics)):{form}}"
    return {"text": f"{value:.4g}", "below": f"± {estimate:.1g}{off}"}


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
        f"Finite elements: {_range(_all(dataset.fe_unknowns, 'body'), ',.0f')} unknowns of the modelled "
        f"parts, {_range(_all(dataset.fe_seconds, 'stage'), '.0f')} s a load, up to "
        f"{most['memory'] / 1e3:.1f} GB. Pressures and reactions carry the load to {np.nanmax(balance):.1g}, "
        f"tensions are at most {most['tension']:.1g} of the largest pressure, penetrations "
        f"{most['penetration']:.1g} of the approach. Rigid part of the compliance that is taken from "
        f"approaches: M_zz = {float(dataset.rigid_compliance):.4g} mm/N. Contacts by ICs: "
        f"{_range(dataset.seconds.values, '.2g')} s."
    )


def _all(values: xr.DataArray, dim: str) -> np.ndarray:
    """Sums along a dimension by case, NaN where nothing was solved."""
    return np.asarray(values.sum(dim, min_count=1).values)


def _range(values: np.ndarray | Sequence[float], form: str) -> str:
    low, high = (format(float(of(values)), form) for of in (np.nanmin, np.nanmax))
    return low if low == high else f"{low} ... {high}"
