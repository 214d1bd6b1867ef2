"""The page of contact with ICs beside contact with finite elements.

On the page of a contact finite elements have a section, and a column in the table of each case.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages.contact import FurtherSolution
from compare.pages.contact_figures import MAIN, beside_numbers, loaded_part, numbers_chart, profile_panels
from compare.pages.contact_numbers import answer_table, case_labels, largest_case, numbers_table
from compare.report.charts import Chart
from compare.report.looks import ics_symbol
from compare.report.parts import (
    Block,
    Folded,
    Page,
    Section,
    Verbatim,
    extreme,
    onset,
    range_text,
    write_results,
)
from compare.report.tables import Row, Table, number_text, numbers, texts, with_estimate
from femic.cache.store import Store
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.results.contact import ics_names, pressures
from femic.results.finite_elements import FE, NUMBERS, OF_PATCH, OF_PLACE, stored_fe_contact
from femic.scenes.scene import Scene

# --- the page -------------------------------------------------------------------------------------------


SHARES = (0.01, 0.02, 0.05)  # deviations: a table has the angles from which they are exceeded
FURTHER = ("a", "approach")
SIDEWAYS = 1e-6  # lateral force over load from which a contact counts as unsymmetric
WITHOUT_RIGID = (
    "The approaches with finite elements (FE) and with C exclude the rigid part M_zz of the compliance. "
    "M_zz comes from the models of C with the same supports; nothing is fitted. Approximate ICs have no "
    "supports; they give the approach of half-spaces."
)
RAW = (
    "The approaches with finite elements (FE) and with C include the compliance of the whole bodies; the "
    "approaches with approximate ICs do not."
)
BELOW = (
    "± is the estimated error. The small number below is the difference from finite elements (FE); it has "
    "the unit of the number where that may vanish by symmetry. "
)
DETAILS = (
    "Largest differences from finite elements, and the patch angle above which a number differs by more "
    "than the given percentage plus the estimated error of finite elements. That error is at most {:.1%}."
)
PROFILES = "Pressures at x = 0 by finite elements, and with ICs on the elements next to x = 0."


def write_fe_contact(dataset: xr.Dataset, out: Path) -> Path:
    """Write `fe_contact.nc`, figures and `fe_contact.html` into a folder; returns the path of the page."""
    title = str(dataset.attrs["title"]).replace(
        "Contact without friction", "Contact without friction by ICs and by finite elements"
    )
    answer = answer_table(dataset, FE, _compared_ics(dataset))
    page = Page(title, summary(dataset), _sections(dataset), answer, doubts(dataset))
    return write_results(page, out, "fe_contact", dataset)


def summary(dataset: xr.Dataset) -> str:
    """Return p_max by finite elements at the largest load, and the largest differences of ICs."""
    number, pressures_off = largest_case(dataset, FE), deviations(dataset, "p_max").dropna("case", how="all")
    case = dataset.isel(case=number).sel(ics=FE)
    known = relative_estimates(dataset, "p_max").sel(case=pressures_off.case)
    off = "; ".join(
        f"{ics_symbol(name)} {_largest_difference(pressures_off.sel(ics=name), known)}"
        for name in _compared_ics(dataset)
    )
    p_max = with_estimate(case.p_max, case.estimate_p_max)
    return (
        f"p_max by finite elements (FE) at {case_labels(dataset)[number]}: {p_max} MPa. Largest "
        f"differences of p_max from finite elements (± is the estimated error of FE): {off}."
    )


def _largest_difference(shares: xr.DataArray, known: xr.DataArray) -> str:
    """Return the share that is furthest from zero, in percent with its sign and its estimate."""
    worst = int(np.argmax(np.abs(shares.values)))
    return f"{with_estimate(100 * shares.values[worst], 100 * known.values[worst], signed=True)} %"


def doubts(dataset: xr.Dataset) -> list[str]:
    """Return which loads finite elements did not solve."""
    left_out = str(dataset.attrs["left_out"])
    return [f"Finite elements found no solution for {left_out}"] if left_out else []


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    yield Section("", [answer_chart(dataset), PROFILES])
    yield Folded(
        "Error of each of the ICs, and the angle above which it exceeds a limit", [*details(dataset)]
    )
    if dataset.sizes["case"] > 1:
        chart = numbers_chart(dataset, FURTHER, FE, "numbers")
        yield Folded("Other numbers against the angle of the patch", [chart])
    tables, quantities = [], {name: OF_FRICTIONLESS[name] for name in NUMBERS}
    for number, label in enumerate(case_labels(dataset)):
        case = dataset.isel(case=number)
        solutions = {ics_symbol(name): case.sel(ics=name) for name in (FE, *_compared_ics(dataset))}
        symmetric = bool((abs(case.F_y) < SIDEWAYS * case["load"]).all())
        zeros = OF_PLACE if symmetric else ()
        tables.append(numbers_table(label, quantities, solutions, solutions[FE], zeros))
    yield Folded("All numbers, by load and ICs", [BELOW + approach_note(dataset), *tables])
    yield Folded("Cost of finite elements", [cost(dataset)])
    yield Folded("The scene", [Verbatim(str(dataset.attrs["scene"]))])


def approach_note(dataset: xr.Dataset) -> str:
    """Return the note on the content of approaches."""
    return WITHOUT_RIGID if float(dataset.rigid_compliance) else RAW


def details(dataset: xr.Dataset) -> Iterator[Block]:
    """Yield how far each of the ICs is off at worst, and from which angle on it is too far."""
    dataset = dataset.isel(case=dataset.angle.sel(ics=FE).notnull().values)
    yield DETAILS.format(max(float(relative_estimates(dataset, name).max()) for name in OF_PATCH))
    angles, rows = dataset.angle.sel(ics=FE).values, []
    for name in _compared_ics(dataset):
        worst = [extreme(deviations(dataset, key).sel(ics=name)) for key in (*MAIN, *FURTHER)]
        onsets = [onset(angles, exceeds(dataset, name, share).values) or "nowhere" for share in SHARES]
        rows.append(Row(ics_symbol(name), [*(number_text(value, "+.1%") for value in worst), *onsets]))
    heads = [*numbers(*MAIN, *FURTHER), *texts(*(f"more than {share:.0%}" for share in SHARES))]
    yield Table("ICs", heads, rows)


def exceeds(dataset: xr.Dataset, ics: str, share: float) -> xr.DataArray:
    """Return in which cases a number of the patch deviates by more than a share and the estimate."""
    exceeding = [
        abs(deviations(dataset, name).sel(ics=ics)) > share + relative_estimates(dataset, name)
        for name in OF_PATCH
    ]
    return xr.concat(exceeding, "quantity").any("quantity")


def _compared_ics(dataset: xr.Dataset) -> list[str]:
    """Return the ICs that are compared with finite elements."""
    return [name for name in ics_names(dataset) if name != FE]


def answer_chart(dataset: xr.Dataset) -> Chart:
    """Return pressures at x = 0 by load beside numbers over the angle; below, differences to FE.

    Differences of pressures are at the nodes of finite elements.
    """
    profiles = {}
    for number, label in enumerate(case_labels(dataset)):
        p, p_fe = pressures(dataset, number), dataset.p_fe.isel(case=number).dropna("s_fe")
        part = loaded_part(p)
        s = p.s.values[part]
        lines = {name: (s, p.sel(ics=name).values[part]) for name in _compared_ics(dataset)}
        if not p_fe.size:
            profiles[label] = profile_panels("pressure at x = 0, without FE", lines, {}, FE)
            continue
        with_fe, s_fe = p_fe.values, p_fe.s_fe.values
        inside = (s_fe >= s[0]) & (s_fe <= s[-1])
        with_fe, s_fe = with_fe[inside], s_fe[inside]
        differences = {
            name: (s_fe, np.interp(s_fe, at, values) - with_fe) for name, (at, values) in lines.items()
        }
        title = f"pressure at x = 0; the surface turns by {float(dataset.angle.sel(ics=FE)[number]):.0f}°"
        profiles[label] = profile_panels(title, lines | {FE: (s_fe, with_fe)}, differences, FE)
    return beside_numbers(dataset, profiles, FE)


def cost(dataset: xr.Dataset) -> str:
    """Return the cost of finite elements, and how well they satisfy the conditions of contact."""
    load = dataset["load"].values
    balance = [
        *abs(dataset.fe_load_of_pressures.values / load - 1),
        *abs(np.abs(dataset.fe_reaction.values) / load[:, None] - 1).ravel(),
    ]
    unknowns, seconds = (  # NaN where nothing was solved
        dataset[name].sum(dim, min_count=1).values
        for name, dim in (("fe_unknowns", "body"), ("fe_seconds", "stage"))
    )
    most = {name: float(dataset[f"fe_{name}"].max()) for name in ("memory", "tension", "penetration")}
    return (
        f"Finite elements: {range_text(unknowns, ',.0f')} unknowns in the modelled part of the bodies, "
        f"{range_text(seconds, '.0f')} s per load, up to {most['memory'] / 1e3:.1f} GB. Pressures and "
        f"reactions carry the load to {np.nanmax(balance):.1g}, tensions are at most {most['tension']:.1g} "
        f"of the largest pressure, penetrations {most['penetration']:.1g} of the approach. Rigid part of "
        f"the compliance, subtracted from approaches: M_zz = {float(dataset.rigid_compliance):.4g} mm/N. "
        f"Contacts with ICs took {range_text(dataset.seconds.values, '.2g')} s."
    )


# --- on the page of a contact ---------------------------------------------------------------------------


def stored_solution(scene: Scene, contacts: xr.Dataset, store: Store) -> FurtherSolution | None:
    """Return stored contacts of a scene by finite elements; None where there are none."""
    fe_contacts = stored_fe_contact(scene, contacts, store)
    if fe_contacts is None:
        return None
    named = [prefix + name for name in NUMBERS for prefix in ("", "estimate_")]
    with_fe = fe_contacts[named].sel(ics=FE)
    chart = numbers_chart(fe_contacts, (*MAIN, *FURTHER), FE, "fe")
    return FurtherSolution(
        FE,
        Folded(
            "Comparison with contact by finite elements (FE), without ICs",
            [summary(fe_contacts), *doubts(fe_contacts), *details(fe_contacts), chart],
        ),
        {number: with_fe.isel(case=number) for number in map(int, np.flatnonzero(with_fe.a.notnull()))},
        "FE: the bodies have the same supports as with C. The estimated errors are the differences from "
        f"cells twice as large. {approach_note(fe_contacts)}",
    )


# --- deviations from finite elements --------------------------------------------------------------------


def deviations(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return ratios of a number with ICs to the same by finite elements, minus 1, by case and ICs."""
    values = dataset[name].drop_attrs()
    return values.drop_sel(ics=FE) / values.sel(ics=FE, drop=True) - 1


def differences(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return numbers with ICs minus finite elements, in their unit, by case and ICs.

    They serve for numbers that vanish by symmetry.
    """
    values = dataset[name].drop_attrs()
    return values.drop_sel(ics=FE) - values.sel(ics=FE, drop=True)


def estimates(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the estimated error of a number by finite elements, in its unit, by case."""
    return dataset[f"estimate_{name}"].drop_attrs().sel(ics=FE, drop=True)


def relative_estimates(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the estimated error of a number by finite elements as a share of it, by case."""
    return abs(estimates(dataset, name) / dataset[name].drop_attrs().sel(ics=FE, drop=True))
