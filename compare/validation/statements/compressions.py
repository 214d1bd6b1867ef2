"""Statement 37: static compression with friction ([BVSV] section 6.2)."""

from collections.abc import Mapping

import numpy as np

from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.contact_series import ratio
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.friction_contacts import (
    FRICTIONS,
    HIGH,
    LOW,
    SINGLE,
    case,
    compression,
    from_friction_to_friction,
    sliding_distance,
    traction_distance,
)
from compare.validation.statements.runs import Runs
from femic.results.contact import others_of

ROTATED = ("B", "Bhat", "Bhat_prime")  # those whose directions rotate: the source's


def over_others(of_others: str, ics: str) -> Numbers:
    """Measure the distance of tractions of some ICs from C over the "least" or "largest" of others."""
    pick, others = {
        "least": (min, [name for name in SINGLE if name != ics]),
        "largest": (max, [name for name in ROTATED if name != ics]),
    }[of_others]

    def measure(runs: Runs) -> Mapping[str, float]:
        contacts = compression(runs)
        return {
            case(friction, ics): ratio(
                traction_distance(contacts, friction, ics),
                pick(traction_distance(contacts, friction, name) for name in others),
            )
            for friction in HIGH
        }

    return Numbers(measure)


def _details(runs: Runs) -> Mapping[str, float]:
    """Return distances of all ICs from C: of tractions over their bound, over pressure, of sliding shares.

    Of p_s and p_x alone, too: they depend on different components of the ICs, p_s on sn, p_x on xn.
    """
    contacts, details = compression(runs), dict[str, float]()
    for friction in FRICTIONS:
        for name in others_of(contacts):
            at, distance = case(friction, name), traction_distance(contacts, friction, name)
            details[f"tractions: {at}"] = distance
            details[f"tractions over pressures: {at}"] = friction * distance
            for direction in "sx":
                alone = traction_distance(contacts, friction, name, (direction,))
                details[f"p_{direction} alone: {at}"] = alone
            details[f"difference of sliding share: {at}"] = sliding_distance(contacts, friction, name)
        share = contacts.sliding_share.sel(friction=friction, ics="C").isel(load=-1)
        details[f"sliding share: {case(friction, 'C')}"] = float(share)
    return details


def _panels(runs: Runs) -> list[Panel]:
    """Return p_s along x = 0 over the largest bound, and sliding shares over the load."""
    contacts, panels = compression(runs), []
    names = (*SINGLE, "mix", "C")
    for friction in FRICTIONS:
        p = contacts.p.sel(friction=friction).interp(x=0.0)
        bound = friction * float(np.max(p.sel(ics="C", direction="n")))
        curves = {symbol_of(name): p.sel(ics=name, direction="s").values / bound for name in names}
        panels.append(
            Panel(
                f"friction {friction:g}, {contacts['load'].values[-1] / 1e3:g} kN",
                "s [mm]",
                "p_s at x = 0 over friction p_max with C [-]",
                curves_of(contacts.s.values, curves),
            )
        )
    for friction in FRICTIONS:
        at = contacts.sliding_share.sel(friction=friction)
        shares = {symbol_of(name): at.sel(ics=name).values for name in names}
        band = contacts.estimate_sliding_share.sel(friction=friction, ics="C").values
        panels.append(
            Panel(
                f"friction {friction:g}",
                "load [kN]",
                "sliding share of the patch [-]",
                curves_of(contacts["load"].values / 1e3, shares, band),
            )
        )
    return panels


STATEMENTS = (
    Statement(
        37,
        "In static compression B is closest to C and B̂′ worst at friction 0.40 and 0.60; at 0.20 differences "
        "are smaller.",
        (
            over_others("least", "B").below(
                1.0, "B", "distance of tangential tractions from C's: B over the least of A, B̂, B̂′"
            ),
            over_others("largest", "Bhat_prime").above(1.0, "B̂′", "the same: B̂′ over the larger one of B, B̂"),
            from_friction_to_friction(
                compression, traction_distance, ROTATED, [(LOW, friction) for friction in HIGH]
            ).below(1.0, "smaller", "distance over friction times pressure: at 0.20 over that at more"),
            from_friction_to_friction(
                compression, sliding_distance, ROTATED, [(LOW, friction) for friction in HIGH]
            ).below(1.0, "sliding", "difference of the sliding share from C's: likewise"),
        ),
        _panels,
        _details,
        columns=3,
    ),
)
