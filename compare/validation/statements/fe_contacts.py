"""Statements 22 and 23: whether contact with C agrees with contact of two meshed bodies, without ICs.

Both have the same supports, and nothing is fitted between them.
"""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
import xarray as xr

from compare.pages.finite_elements import deviations, differences, estimates, relative_estimates
from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.runs import Contacts, Runs
from femic.contact.finite_elements.fineness import FEWEST
from femic.results.contact import case_names, pressures
from femic.results.finite_elements import APPROACH, FE, OF_PATCH, OF_PLACE

AGREES = 0.02  # of a number, beside the estimate of finite elements
AGREES_FORCE, AGREES_CENTRE = 0.02, 0.2  # lateral force over load; centre of pressure [mm]

CENTRED = Contacts("wide", (660e3, 5300e3))  # patches over 39 and 77 degrees
AT_ALL_ANGLES = Contacts("tall", (7.4e3, 58e3, 310e3), cells=FEWEST)  # over 46, 79 and 109 degrees
# touching first where the rail inclines by 61 deg
BESIDE = Contacts("tall", (58e3,), shift=0.1, cells=FEWEST)


def deviations_beyond_estimate(contacts: Contacts, names: Sequence[str]) -> Numbers:
    """Measure deviations of numbers with C from finite elements, less the estimate of the latter."""

    def measure(runs: Runs) -> Mapping[str, float]:
        dataset = runs.fe_contact(contacts)
        return _by_case(
            dataset,
            {name: abs(deviations(dataset, name)) - relative_estimates(dataset, name) for name in names},
        )

    return Numbers(measure)


def differences_beyond_estimate(contacts: Contacts, name: str, *, over_load: bool = False) -> Numbers:
    """Measure the same of a number that vanishes by symmetry, in its unit or over the load."""

    def measure(runs: Runs) -> Mapping[str, float]:
        dataset = runs.fe_contact(contacts)
        beyond = abs(differences(dataset, name)) - estimates(dataset, name)
        return _by_case(dataset, {name: beyond / dataset["load"] if over_load else beyond})

    return Numbers(measure)


def _by_case(dataset: xr.Dataset, by_name: Mapping[str, xr.DataArray]) -> dict[str, float]:
    """Return the values with C by load and name."""
    return {
        f"{case}, {name}": float(values.sel(ics="C")[k])
        for name, values in by_name.items()
        for k, case in enumerate(case_names(dataset))
    }


def details(contacts: Contacts, runs: Runs) -> Mapping[str, float]:
    """Return deviations of all ICs from finite elements, and the estimates of the latter.

    They are shares of the numbers by finite elements, except for numbers that vanish by symmetry.
    """
    dataset = runs.fe_contact(contacts)
    details: dict[str, float] = {}
    for name in (*OF_PATCH, APPROACH, *(OF_PLACE if contacts.shift else ())):
        in_unit = name in OF_PLACE
        deviation = (differences if in_unit else deviations)(dataset, name)
        estimate = (estimates if in_unit else relative_estimates)(dataset, name)
        for k, case in enumerate(case_names(dataset)):
            details |= {
                f"{case}, {name} by {symbol_of(ics)}": float(deviation.sel(ics=ics)[k])
                for ics in map(str, deviation.ics.values)
            }
            details[f"{case}, {name}: estimate of FE"] = float(estimate[k])
    return details


def panels(contacts: Contacts, runs: Runs) -> list[Panel]:
    """Return pressures across the patch by finite elements and with ICs, a panel per load."""
    dataset = runs.fe_contact(contacts)
    return [_panel(dataset, contacts.scene, number) for number in range(dataset.sizes["case"])]


def _panel(dataset: xr.Dataset, scene: str, number: int) -> Panel:
    """Return pressures across the patch by finite elements and with ICs."""
    p = pressures(dataset, number).dropna("ics", how="all")
    p_fe = dataset.p_fe.isel(case=number).dropna("s_fe")
    s = p_fe.s_fe.values
    with_ics = {
        symbol_of(str(name)): np.interp(s, p.s.values, p.sel(ics=name).values) for name in p.ics.values
    }
    return Panel(
        f"{scene}, {case_names(dataset)[number]}",
        "s [mm]",
        "pressure at x = 0 [MPa]",
        curves_of(s, with_ics | {FE: p_fe.values}),
    )


STATEMENTS = (
    Statement(
        22,
        "Contact with C agrees with contact of two meshed bodies without ICs.",
        (
            deviations_beyond_estimate(CENTRED, OF_PATCH).below(
                AGREES,
                "patch",
                f"{CENTRED.scene}: a, b, Δδ, p_max with C: deviation from finite elements minus "
                "their estimate",
            ),
            deviations_beyond_estimate(CENTRED, (APPROACH,)).below(
                AGREES,
                "approach",
                f"{CENTRED.scene}: approach with C, likewise; without M_zz of both bodies, and "
                "nothing fitted",
            ),
        ),
        partial(panels, CENTRED),
        partial(details, CENTRED),
    ),
    Statement(
        23,
        "Beside the crown, too, contact with C agrees with contact of two meshed bodies without ICs.",
        (
            deviations_beyond_estimate(BESIDE, ("p_max",)).below(
                AGREES,
                "pressure",
                f"{BESIDE.scene}, upper body moved by {BESIDE.shift:g} mm: p_max with C: deviation from "
                "finite elements minus their estimate",
            ),
            differences_beyond_estimate(BESIDE, "F_y", over_load=True).below(
                AGREES_FORCE, "force", "lateral force with C, likewise, over the load"
            ),
            differences_beyond_estimate(BESIDE, "s_centre").below(
                AGREES_CENTRE, "centre", "centre of pressure with C, likewise [mm]"
            ),
            deviations_beyond_estimate(BESIDE, (APPROACH,)).below(
                AGREES,
                "approach",
                "approach with C, likewise, as a share; without M_zz of both bodies, and nothing fitted",
            ),
        ),
        partial(panels, BESIDE),
        partial(details, BESIDE),
    ),
)
