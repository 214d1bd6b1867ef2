"""The page of contact with ICs beside contact with finite elements.

On the page of a contact finite elements have a section, and a column in the table of each case.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages.contact import FurtherSolution
from compare.pages.contact_figures import MAIN, beside_numbers, loaded_part, over_angle, profile_panels
from compare.pages.contact_numbers import answer_sentence, answer_table, case_labels, numbers_table
from compare.report.charts import Chart, Panel, chart_of
from compare.report.looks import symbol_of
from compare.report.parts import (
    Block,
    Folded,
    Items,
    Page,
    Section,
    Verbatim,
    extreme,
    join_words,
    onset,
    range_text,
    write_results,
)
from compare.report.tables import Table, number_text
from femic.cache.store import Store
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.results.contact import ContactResults, case_names, ics_of, pressures, to_dataset
from femic.results.finite_elements import FE, NUMBERS, OF_PATCH, OF_PLACE, stored_fe_contact

# --- the page -------------------------------------------------------------------------------------------


SHARES = (0.01, 0.02, 0.05)  # deviations: sentences give the angles from which they are exceeded
FURTHER = ("a", "approach")
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
    "With estimated errors. Small, below each number: its difference to the number by finite elements (FE), "
    "in its unit where it may vanish by symmetry. "
)
PROFILES = "Pressures at x = 0 by finite elements, and with ICs on the elements beside it."


def write_fe_contact(dataset: xr.Dataset, out: Path) -> Path:
    """Write `fe_contact.nc`, figures and `fe_contact.html` into a folder; returns the path of the page."""
    title = str(dataset.attrs["title"]).replace(
        "Frictionless contact", "Contact with ICs, and with finite elements"
    )
    answer = answer_table(dataset, FE, _compared_ics(dataset))
    return write_results(
        Page(title, summary(dataset), _sections(dataset), answer), out, "fe_contact", dataset
    )


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    yield Section("", [answer_chart(dataset), PROFILES])
    yield Folded("How far each of the ICs is off, and from which angle on", [*details(dataset)])
    if dataset.sizes["case"] > 1:
        chart = numbers_chart(dataset, FURTHER, "numbers")
        yield Folded("Further numbers over the angle of the patch", [chart])
    tables = [_table(dataset, number) for number in range(dataset.sizes["case"])]
    yield Folded("All numbers, by load and ICs", [BELOW + approach_note(dataset), *tables])
    yield Folded("Cost of finite elements", [cost(dataset)])
    yield Folded("The scene", [Verbatim(str(dataset.attrs["scene"]))])


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
    """Return the answer: pressure and patch by finite elements, deviations of ICs, and loads without one."""
    sentences = [answer_sentence(dataset, FE)]
    if dataset.attrs["left_out"]:
        sentences.append(f"Finite elements did not solve {dataset.attrs['left_out']}")
    return " ".join(sentences)


def details(dataset: xr.Dataset) -> Iterator[Block]:
    """Yield what else is off, from where on, and the lateral force, in sentences."""
    dataset = dataset.isel(case=dataset.angle.sel(ics=FE).notnull().values)
    estimate = max(float(relative_estimates(dataset, name).max()) for name in OF_PATCH)
    sentences = [f"Estimated error of the patch by finite elements: {estimate:.1%}."]
    for name in _compared_ics(dataset):
        worst = join_words(
            f"{number_text(extreme(deviations(dataset, key).sel(ics=name)), '+.1%')} in {key}"
            for key in (*MAIN, *FURTHER)
        )
        sentences.append(f"{symbol_of(name)}: at worst {worst}; {_from_where(dataset, name)}.")
    yield Items([*sentences, *_lateral_force_sentence(dataset)])


def _compared_ics(dataset: xr.Dataset) -> list[str]:
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
    to = float(with_fe.estimate_F_y) / load
    force, centre = (
        {
            name: number_text(per_unit * case[key].sel(ics=name), form)
            for name in (FE, *_compared_ics(dataset))
        }
        for key, per_unit, form in (("F_y", 1 / load, "+.3f"), ("s_centre", 1.0, "+.2f"))
    )
    by_ics = join_words(
        f"{force[name]}, {centre[name]} mm with {symbol_of(name)}" for name in _compared_ics(dataset)
    )
    yield (
        f"Beside the crown, at {case_names(dataset)[worst]}: by finite elements the lateral force on the "
        f"upper body is {force[FE]} ± {to:.1g} of the load, the centre of pressure "
        f"{centre[FE]} ± {float(with_fe.estimate_s_centre):.1g} mm; {by_ics}."
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


def numbers_chart(dataset: xr.Dataset, keys: tuple[str, ...], name: str) -> Chart:
    """Return numbers over the angle of the patch, and below them their differences to finite elements."""
    above, below = over_angle(dataset, keys, FE)
    return chart_of(name, [*above, *below], len(keys))


def answer_chart(dataset: xr.Dataset) -> Chart:
    """Return pressures at x = 0 by load beside numbers over the angle; below, differences to FE."""
    profiles = {label: _profile(dataset, number) for number, label in enumerate(case_labels(dataset))}
    return beside_numbers(dataset, profiles, FE)


def _profile(dataset: xr.Dataset, number: int) -> list[Panel]:
    """Return pressures along s at x = 0, and below them differences at the nodes of finite elements."""
    p, p_fe = pressures(dataset, number), dataset.p_fe.isel(case=number).dropna("s_fe")
    part = loaded_part(p)
    s = p.s.values[part]
    lines = {name: (s, p.sel(ics=name).values[part]) for name in _compared_ics(dataset)}
    if not p_fe.size:
        return profile_panels("pressure at x = 0, without FE", lines, {}, FE)
    with_fe, s_fe = p_fe.values, p_fe.s_fe.values
    inside = (s_fe >= s[0]) & (s_fe <= s[-1])
    with_fe, s_fe = with_fe[inside], s_fe[inside]
    differences = {
        name: (s_fe, np.interp(s_fe, at, values) - with_fe) for name, (at, values) in lines.items()
    }
    angle = float(dataset.angle.sel(ics=FE)[number])
    title = f"pressure at x = 0, patch over {angle:.0f}°"
    return profile_panels(title, lines | {FE: (s_fe, with_fe)}, differences, FE)


def _table(dataset: xr.Dataset, number: int) -> Table:
    """Return the table of all numbers of a case."""
    case = dataset.isel(case=number)
    solutions = {symbol_of(name): case.sel(ics=name) for name in (FE, *_compared_ics(dataset))}
    zeros = OF_PLACE if _symmetric(dataset, number) else ()
    quantities = {name: OF_FRICTIONLESS[name] for name in NUMBERS}
    return numbers_table(case_labels(dataset)[number], quantities, solutions, solutions[FE], zeros)


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


# --- on the page of a contact ---------------------------------------------------------------------------


def stored_solution(results: ContactResults, store: Store) -> FurtherSolution | None:
    """Return stored contacts of a scene by finite elements; None where there are none."""
    fe_contacts = stored_fe_contact(results.scene, to_dataset(results), store)
    if fe_contacts is None:
        return None
    named = [prefix + name for name in NUMBERS for prefix in ("", "estimate_")]
    with_fe = fe_contacts[named].sel(ics=FE)
    chart = numbers_chart(fe_contacts, (*MAIN, *FURTHER), "fe")
    return FurtherSolution(
        FE,
        Folded(
            "Comparison with finite elements without ICs (FE)",
            [summary(fe_contacts), *details(fe_contacts), chart],
        ),
        {number: with_fe.isel(case=number) for number in map(int, np.flatnonzero(with_fe.a.notnull()))},
        "FE: the bodies have the same supports as with C; estimates are differences to cells twice as "
        f"large. {approach_note(fe_contacts)}",
    )


# --- deviations from finite elements --------------------------------------------------------------------


def deviations(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return ratios of a number with ICs to the same by finite elements, minus 1, by case and ICs."""
    return _with_ics(dataset, name) / _with_fe(dataset, name) - 1


def relative_estimates(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the estimated error of a number by finite elements as a share of it, by case."""
    return abs(estimates(dataset, name) / _with_fe(dataset, name))


def differences(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return numbers with ICs minus finite elements, in their unit, by case and ICs.

    They serve for numbers that vanish by symmetry.
    """
    return _with_ics(dataset, name) - _with_fe(dataset, name)


def estimates(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the estimated error of a number by finite elements, in its unit, by case."""
    return _with_fe(dataset, f"estimate_{name}")


def _with_ics(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset[name].drop_attrs().drop_sel(ics=FE)


def _with_fe(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset[name].drop_attrs().sel(ics=FE, drop=True)
