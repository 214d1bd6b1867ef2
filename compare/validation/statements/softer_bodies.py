"""Statement 41: how the ratio of the moduli changes what approximations miss ([BVSV] section 6.2).

1 / E_upper + 1 / E_lower stays the same, so that load, patch and A_nn do.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.contact_series import ratio
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.friction_contacts import (
    FEW_CREEPAGES,
    STEEL_E,
    Distance,
    curve_distance,
    pressure_distance,
    rolling_on_same_grid,
)
from compare.validation.statements.runs import Runs

FRICTION = 0.4
ICS = ("A", "B", "Bhat")  # those without a fit, which would belong to one ratio
CONVEX, CONCAVE = 10.0, 0.1  # E_upper / E_lower with a softer convex, lower body, and a softer concave one
RATIOS = (CONCAVE, 1.0, CONVEX)


def moduli(upper_over_lower: float) -> dict[str, float]:
    """Return Young's moduli [MPa] of both bodies with this ratio and the compliance of two of steel."""
    lower = STEEL_E * (1 + 1 / upper_over_lower) / 2
    return {"upper": upper_over_lower * lower, "lower": lower}


def with_moduli(runs: Runs, upper_over_lower: float) -> xr.Dataset:
    """Return rolling of bodies with this ratio of moduli, on the grid of all other rolling."""
    changes: dict[str, object] = {body: {"E": E} for body, E in moduli(upper_over_lower).items()}
    changes["contact"] = {
        "friction": [FRICTION],
        "ics": [*ICS, "C"],
        "longitudinal": list(FEW_CREEPAGES),
    }
    return rolling_on_same_grid(runs, changes)


def over_equal(distance: Distance, upper_over_lower: float) -> Numbers:
    """Measure distances from C with unequal bodies over those with equal ones."""

    def measure(runs: Runs) -> Mapping[str, float]:
        unequal, equal = with_moduli(runs, upper_over_lower), with_moduli(runs, 1.0)
        return {
            symbol_of(name): ratio(distance(unequal, FRICTION, name), distance(equal, FRICTION, name))
            for name in ICS
        }

    return Numbers(measure)


def _details(runs: Runs) -> Mapping[str, float]:
    """Return distances of curves and signed errors of pressures by the ratio of moduli."""
    details = {}
    for ratio_of_moduli in RATIOS:
        contacts = with_moduli(runs, ratio_of_moduli)
        p_max = contacts.p_max.sel(friction=FRICTION, xi=0.0)
        zero = contacts.zero_creepage.sel(friction=FRICTION)
        for name in ICS:
            at = f"E_upper/E_lower = {ratio_of_moduli:.3g}, {symbol_of(name)}"
            details[f"curve: {at}"] = curve_distance(contacts, FRICTION, name)
            details[f"p_max over p_max with C - 1: {at}"] = float(
                p_max.sel(ics=name) / p_max.sel(ics="C") - 1
            )
            apart = 1e3 * float(zero.sel(ics=name) - zero.sel(ics="C"))
            details[f"creepage without force minus C's [1e-3]: {at}"] = apart
    return details


def _panels(runs: Runs) -> list[Panel]:
    """Return distances of curves and errors of pressures over the ratio of moduli."""
    by_ratio = [with_moduli(runs, ratio_of_moduli) for ratio_of_moduli in RATIOS]
    return [
        Panel(
            title,
            "E of the concave body over E of the convex body [-]",
            label,
            curves_of(
                RATIOS,
                {
                    symbol_of(name): np.array([distance(contacts, FRICTION, name) for contacts in by_ratio])
                    for name in ICS
                },
            ),
            log_x=True,
        )
        for title, label, distance in (
            ("creep-force curve", "rms distance from C over friction load [-]", curve_distance),
            ("pressure", "|p_max / p_max with C - 1| [-]", pressure_distance),
        )
    ]


STATEMENTS = (
    Statement(
        41,
        "A softer convex body makes approximations worse, a softer concave one better.",
        tuple(
            criterion
            for kind, distance, meaning in (
                ("curve", curve_distance, "rms distance of the creep-force curve from C's"),
                ("pressure", pressure_distance, "|p_max / p_max with C - 1|"),
            )
            for criterion in (
                over_equal(distance, CONVEX).above(
                    1.0, f"convex {kind}", f"{meaning}: convex body ten times softer over equal bodies"
                ),
                over_equal(distance, CONCAVE).below(
                    1.0, f"concave {kind}", f"{meaning}: concave body ten times softer over equal bodies"
                ),
            )
        ),
        _panels,
        _details,
    ),
)
