"""Statements 34 to 37 ([BVSV] section 6.2): how ICs change steady rolling and static compression."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from compare.report.charts import Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.curves import rms
from compare.validation.statements.frame import FOLLOWS, SMALL_PART, Measure, Statement, above, below, ratio
from compare.validation.statements.friction_contacts import (
    FRICTIONS,
    HIGH,
    LOW,
    SINGLE,
    Distance,
    between_frictions,
    by_symbol,
    case,
    centre_line,
    compared,
    compression,
    curve_distance,
    distances,
    distances_by_label,
    largest_curve_distance,
    left_after_shift,
    line_distance,
    line_distance_over_bound,
    measured,
    rolling,
    rolling_pair,
    shift,
    sliding_distance,
    traction_distance,
    traction_distance_along,
)
from compare.validation.statements.runs import Runs, solved_once
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.motions.rolling import scaled_force
from femic.contact.pairs.ics import C
from geometries.arrays import Array
from geometries.patches import N, X

SHIFTED = ("B", "Bhat")
ROTATED = ("B", "Bhat", "Bhat_prime")  # those whose directions rotate: the source's
GROWING = tuple(zip(FRICTIONS[1:], FRICTIONS[:-1], strict=True))  # each friction with the one below
FROM_LOW = [(LOW, friction) for friction in HIGH]
DRAWN = (*SINGLE, "mix", "C")
CREEPAGE = "longitudinal creepage [1e-3]"

# --- 34, 36: creep-force curves -------------------------------------------------------------------------


def _curve_details(runs: Runs) -> Mapping[str, float]:
    return distances_by_label(rolling(runs), {"shift": shift, "rms of curve": curve_distance})


def shrinking_details(runs: Runs) -> Mapping[str, float]:
    """Return ratios of distances from friction to friction of the other ICs, and of forces in N of all."""
    contacts, details = rolling(runs), dict[str, float]()
    for one, other in GROWING:
        for name in SINGLE:
            curves, lines = (
                [distance(contacts, friction, name) for friction in (one, other)]
                for distance in (curve_distance, line_distance_over_bound)
            )
            frictions = f"{ics_symbol(name)}, friction {one:g} over {other:g}"
            details[f"of friction load: {frictions}"] = ratio(*curves)
            details[f"in N: {frictions}"] = ratio(curves[0] * one, curves[1] * other)
            details[f"p_x over friction times pressure: {frictions}"] = ratio(*lines)
    return details


def _curve_panel(runs: Runs) -> Panel:
    contacts = rolling(runs).sel(friction=[LOW])
    force, estimate = (scaled_force(contacts, name).sel(friction=LOW) for name in ("F_x", "estimate_F_x"))
    curves = make_curves(1e3 * contacts.xi.values, by_symbol(force, DRAWN), estimate.sel(ics="C").values)
    return Panel(f"friction {LOW:g}", CREEPAGE, "F_x over friction load [-]", curves)


def _difference_panel(runs: Runs, friction: float) -> Panel:
    """Return the differences of creep-force curves from C."""
    contacts = rolling(runs)
    force = scaled_force(contacts).sel(friction=friction)
    curves = make_curves(1e3 * contacts.xi.values, by_symbol(force - force.sel(ics="C"), DRAWN[:-1]))
    return Panel(f"friction {friction:g}", CREEPAGE, "F_x minus F_x with C, over friction load [-]", curves)


def _line_panels(runs: Runs, frictions: Sequence[float] = (LOW,)) -> Iterator[Panel]:
    contacts = rolling(runs)
    for friction in frictions:
        line = centre_line(contacts.sel(friction=friction))
        line = line / float(np.max(np.abs(line.sel(ics="C").values)))
        yield Panel(
            f"friction {friction:g}, F_x = {contacts.attrs['equal_force']:g} friction load",
            "x [mm]",
            "p_x at s = 0 over the largest with C [-]",
            make_curves(contacts.x.values, by_symbol(line, DRAWN)),
        )


# --- 35: tractions at equal force, and elsewhere on the curve -------------------------------------------

FORCES = (-0.5, 0.0, 0.5, 0.8)  # F_x / (friction load) at which tractions are compared, too
XN_ONLY = "Bhat+xn:Bhat_prime"  # effective properties in xn and nx alone
LINE_ICS = ("B", "Bhat", "Bhat_prime", XN_ONLY, "mix", C)


@solved_once("tractions elsewhere")
def lines_elsewhere(runs: Runs) -> Mapping[tuple[str, str], Array]:
    """Return tractions (n_x, 3) on the centre line at the least friction by place on the curve and ICs.

    Places are several longitudinal forces, and the creepage at which C has the force of `rolling`.
    """
    pair, contacts = rolling_pair(runs), rolling(runs)
    at, load = contacts.sel(friction=LOW, ics=C), contacts.attrs["load"]
    guess, same = (Creepages(float(at[name])) for name in ("zero_creepage", "equal_creepage"))
    forces = {f"F_x = {share:g} friction load": {"longitudinal": share * LOW * load} for share in FORCES}
    lines, middle = {}, pair.on_grid.grid.n_s // 2
    for name in LINE_ICS:
        wheel = pair.rolling(pair.frictional(pair.operator(name), LOW))
        for place, prescribed in (forces | {"equal creepage": {}}).items():
            rolled = wheel.contact(guess if prescribed else same, Loading(load), forces=prescribed)
            lines[place, name] = rolled.contact.p[:, middle - 1 : middle + 1].mean(axis=1)
    return lines


def line_details(runs: Runs) -> Mapping[str, float]:
    """Return distances of p_x at s = 0, over p_x and over its bound with C, also elsewhere on the curve.

    Where all of the line slips p_x is friction times pressure with any ICs; where hardly any of it slips p_x
    may be small, and a share of it large. With effective properties in xn alone the other components stay
    those of B-hat; in B-hat-prime they change sn, too.
    """
    labels = {"over p_x": line_distance, "over friction times pressure": line_distance_over_bound}
    details = distances_by_label(rolling(runs), labels)
    lines = lines_elsewhere(runs)
    for place, name in lines:
        if name != C:
            by_c, at = lines[place, C], f"{place}, {case(LOW, name)}"
            apart = rms(lines[place, name][:, X] - by_c[:, X])
            details[f"over p_x, {at}"] = apart / rms(by_c[:, X])
            details[f"over friction times pressure, {at}"] = apart / (LOW * rms(by_c[:, N]))
    return details


# --- 37: compression ------------------------------------------------------------------------------------


def traction_over(ics: str, pick: str, others: Sequence[str]) -> Measure:
    """Measure the distance of tractions of some ICs from C over the "least" or "largest" of others."""
    chosen = {"least": min, "largest": max}[pick]
    return measured(
        compression,
        lambda contacts, friction: ratio(
            traction_distance(contacts, friction, ics),
            chosen(traction_distance(contacts, friction, name) for name in others),
        ),
        {case(friction, ics): (friction,) for friction in HIGH},
    )


COMPRESSED: Mapping[str, Distance] = {
    "tractions": traction_distance,
    "tractions over pressures": lambda dataset, friction, ics: (
        friction * traction_distance(dataset, friction, ics)
    ),
    "p_s alone": traction_distance_along("s"),  # depends on sn
    "p_x alone": traction_distance_along("x"),  # on xn
    "difference of sliding share": sliding_distance,
}


def _compression_details(runs: Runs) -> Mapping[str, float]:
    contacts = compression(runs)
    details = distances_by_label(contacts, COMPRESSED)
    for friction in FRICTIONS:
        share = contacts.sliding_share.sel(friction=friction, ics="C").isel(load=-1)
        details[f"sliding share: {case(friction, 'C')}"] = float(share)
    return details


def _compression_panels(runs: Runs) -> Iterator[Panel]:
    """Yield p_s along x = 0 over the largest bound, and sliding shares over the load."""
    contacts = compression(runs)
    kilonewtons = contacts["load"].values / 1e3
    for friction in FRICTIONS:
        p = contacts.p.sel(friction=friction).interp(x=0.0)
        bound = friction * float(np.max(p.sel(ics="C", direction="n")))
        title = f"friction {friction:g}, {kilonewtons[-1]:g} kN"
        curves = make_curves(contacts.s.values, by_symbol(p.sel(direction="s") / bound, DRAWN))
        yield Panel(title, "s [mm]", "p_s at x = 0 over friction p_max with C [-]", curves)
    for friction in FRICTIONS:
        at = contacts.sel(friction=friction)
        band = at.estimate_sliding_share.sel(ics="C").values
        curves = make_curves(kilonewtons, by_symbol(at.sliding_share, DRAWN), band)
        yield Panel(f"friction {friction:g}", "load [kN]", "sliding part of the patch [-]", curves)


STATEMENTS = (
    Statement(
        34,
        "B and B̂ shift the creep-force curve at friction 0.20, and B̂′ restores it.",
        (
            above(
                FOLLOWS,
                "shift",
                "difference to C of the creepage without force, times the slope with C, over friction load",
            )(distances(rolling, shift, SHIFTED, (LOW,))),
            below(
                SMALL_PART,
                "as a whole",
                "share of the distance to C's curve that is left when the curve is moved by that difference",
            )(distances(rolling, left_after_shift, SHIFTED, (LOW,))),
            below(SMALL_PART, "restored", "the same difference: B̂′ over B̂")(
                compared(rolling, shift, "Bhat_prime", ("Bhat",), (LOW,))
            ),
            below(FOLLOWS, "close", "largest distance of the curve with B̂′ from C's, over friction load")(
                distances(rolling, largest_curve_distance, ("Bhat_prime",), (LOW,))
            ),
        ),
        lambda runs: [_curve_panel(runs), _difference_panel(runs, LOW)],
        _curve_details,
    ),
    Statement(
        35,
        "At equal F_x / (friction load), p_x along the centre line is wrong with B and B̂ at friction "
        "0.20, and B̂′ restores it.",
        (
            above(
                FOLLOWS, "off", "distance of p_x from C's at s = 0, over p_x with C, rms; F_x at half of it"
            )(distances(rolling, line_distance, SHIFTED, (LOW,))),
            below(SMALL_PART, "restored", "the same: B̂′ over B̂")(
                compared(rolling, line_distance, "Bhat_prime", ("Bhat",), (LOW,))
            ),
            below(FOLLOWS, "close", "the same with B̂′")(
                distances(rolling, line_distance, ("Bhat_prime",), (LOW,))
            ),
        ),
        _line_panels,
        line_details,
    ),
    Statement(
        36,
        "Differences in rolling become smaller with friction 0.40 and 0.60.",
        (
            below(
                1.0, "curve", "rms distance of the creep-force curve over friction load: over the one before"
            )(between_frictions(rolling, curve_distance, SHIFTED, GROWING)),
            below(1.0, "p_x", "the same for the difference of p_x at s = 0 at equal F_x / (friction load)")(
                between_frictions(rolling, line_distance, SHIFTED, GROWING)
            ),
        ),
        lambda runs: [
            *(_difference_panel(runs, friction) for friction in FRICTIONS),
            *_line_panels(runs, HIGH),
        ],
        shrinking_details,
        columns=3,
    ),
    Statement(
        37,
        "In static compression at friction 0.40 and 0.60, B is closest to C and B̂′ least accurate; at "
        "0.20 the differences are smaller.",
        (
            below(1.0, "B", "distance of tangential tractions from C's: B over the least of A, B̂, B̂′")(
                traction_over("B", "least", ("A", "Bhat", "Bhat_prime"))
            ),
            above(1.0, "B̂′", "the same: B̂′ over the larger one of B, B̂")(
                traction_over("Bhat_prime", "largest", ("B", "Bhat"))
            ),
            below(1.0, "smaller", "distance over friction times pressure: at 0.20 over that at more")(
                between_frictions(compression, traction_distance, ROTATED, FROM_LOW)
            ),
            below(1.0, "sliding", "the same for the difference of the sliding part from C")(
                between_frictions(compression, sliding_distance, ROTATED, FROM_LOW)
            ),
        ),
        _compression_panels,
        _compression_details,
        columns=3,
    ),
)
