"""Statements 34 to 36: how ICs change creep forces and tractions of steady rolling ([BVSV] section 6.2)."""

from collections.abc import Mapping

import numpy as np

from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.contact_series import ratio
from compare.validation.statements.criteria import FOLLOWS, SMALL_PART, Statement
from compare.validation.statements.curves import rms
from compare.validation.statements.friction_contacts import (
    FRICTIONS,
    HIGH,
    LOW,
    SINGLE,
    against,
    case,
    centre_line,
    curve_distance,
    from_friction_to_friction,
    largest_curve_distance,
    left_after_shift,
    line_distance,
    line_distance_over_bound,
    of_ics,
    pair_of,
    rolling,
    shift,
)
from compare.validation.statements.runs import Runs
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.motions.rolling import scaled_force
from femic.contact.pairs.ics import C
from femic.results.contact import others_of
from geometries.arrays import Array
from geometries.patches import N, X

SHIFTED = ("B", "Bhat")
GROWING = tuple(zip(FRICTIONS[1:], FRICTIONS[:-1], strict=True))  # each friction with the one below
FORCES = (-0.5, 0.0, 0.5, 0.8)  # F_x / (friction load) at which tractions are compared, too
XN_ONLY = "Bhat+xn:Bhat_prime"  # effective properties in xn and nx alone
LINES_OF = ("B", "Bhat", "Bhat_prime", XN_ONLY, "mix", C)


def _distances(runs: Runs) -> Mapping[str, float]:
    """Return distances of curves from C and shifts of all ICs at each coefficient of friction."""
    contacts = rolling(runs)
    return {
        f"{kind}: {case(friction, name)}": measure(contacts, friction, name)
        for kind, measure in (("shift", shift), ("rms of curve", curve_distance))
        for friction in FRICTIONS
        for name in others_of(contacts)
    }


def _shrinking(runs: Runs) -> Mapping[str, float]:
    """Return ratios of distances from friction to friction of the other ICs, and of forces in N of all."""
    contacts, details = rolling(runs), dict[str, float]()
    for one, other in GROWING:
        for name in SINGLE:
            distances = [curve_distance(contacts, friction, name) for friction in (one, other)]
            frictions = f"{symbol_of(name)}, friction {one:g} over {other:g}"
            details[f"of friction load: {frictions}"] = ratio(*distances)
            details[f"in N: {frictions}"] = ratio(distances[0] * one, distances[1] * other)
            lines = [line_distance_over_bound(contacts, friction, name) for friction in (one, other)]
            details[f"p_x over friction times pressure: {frictions}"] = ratio(*lines)
    return details


def lines_elsewhere(runs: Runs) -> Mapping[tuple[str, str], Array]:
    """Return tractions (n_x, 3) on the centre line at the least friction by place on the curve and ICs.

    Places are several longitudinal forces, and the creepage at which C has the force of `rolling`.
    """
    pair, contacts = pair_of(runs), rolling(runs)
    at, load = contacts.sel(friction=LOW, ics=C), contacts.attrs["load"]
    guess, same = (Creepages(float(at[name])) for name in ("zero_creepage", "equal_creepage"))
    forces = {f"F_x = {share:g} friction load": {"longitudinal": share * LOW * load} for share in FORCES}
    lines, middle = {}, pair.on_grid.grid.n_s // 2
    for name in LINES_OF:
        wheel = pair.rolling(pair.frictional(pair.operator(name), LOW))
        for place, prescribed in (forces | {"equal creepage": {}}).items():
            rolled = wheel.contact(guess if prescribed else same, Loading(load), forces=prescribed)
            lines[place, name] = rolled.contact.p[:, middle - 1 : middle + 1].mean(axis=1)
    return lines


def _lines(runs: Runs) -> Mapping[str, float]:
    """Return distances of p_x at s = 0, over p_x and over its bound with C, also elsewhere on the curve.

    Where all of the line slips p_x is friction times pressure with any ICs; where hardly any of it slips p_x
    may be small, and a share of it large. With effective properties in xn alone the other components stay
    those of B-hat; in B-hat-prime they change sn, too.
    """
    contacts, details = rolling(runs), dict[str, float]()
    for friction in FRICTIONS:
        for name in others_of(contacts):
            at = case(friction, name)
            details[f"over p_x: {at}"] = line_distance(contacts, friction, name)
            details[f"over friction times pressure: {at}"] = line_distance_over_bound(
                contacts, friction, name
            )
    lines: Mapping[tuple[str, str], Array] = runs.remembered("tractions elsewhere", lines_elsewhere)
    for place, name in lines:
        if name != C:
            by_c = lines[place, C]
            apart, at = rms(lines[place, name][:, X] - by_c[:, X]), f"{place}, {case(LOW, name)}"
            details[f"over p_x, {at}"] = apart / rms(by_c[:, X])
            details[f"over friction times pressure, {at}"] = apart / (LOW * rms(by_c[:, N]))
    return details


def _curve_panels(runs: Runs, frictions: tuple[float, ...] = (LOW,)) -> list[Panel]:
    contacts = rolling(runs)
    force = scaled_force(contacts)
    estimate = scaled_force(contacts, "estimate_F_x").sel(ics="C")
    panels = []
    for friction in frictions:
        curves = {
            symbol_of(name): force.sel(friction=friction, ics=name).values for name in (*SINGLE, "mix", "C")
        }
        band = estimate.sel(friction=friction).values
        panels.append(
            Panel(
                f"friction {friction:g}",
                "longitudinal creepage [1e-3]",
                "F_x over friction load [-]",
                curves_of(1e3 * contacts.xi.values, curves, band),
            )
        )
    return panels


def _difference_panel(runs: Runs, friction: float) -> Panel:
    """Return the differences of creep-force curves from C."""
    contacts = rolling(runs)
    force = scaled_force(contacts).sel(friction=friction)
    away = {symbol_of(name): (force.sel(ics=name) - force.sel(ics="C")).values for name in (*SINGLE, "mix")}
    return Panel(
        f"friction {friction:g}",
        "longitudinal creepage [1e-3]",
        "F_x minus F_x with C, over friction load [-]",
        curves_of(1e3 * contacts.xi.values, away),
    )


def _line_panels(runs: Runs, frictions: tuple[float, ...] = (LOW,)) -> list[Panel]:
    contacts = rolling(runs)
    panels = []
    for friction in frictions:
        line = centre_line(contacts, friction)
        curves = {symbol_of(name): line.sel(ics=name).values for name in (*SINGLE, "mix", "C")}
        largest = np.max(np.abs(line.sel(ics="C").values))
        panels.append(
            Panel(
                f"friction {friction:g}, F_x = {contacts.attrs['equal_force']:g} friction load",
                "x [mm]",
                "p_x at s = 0 over the largest with C [-]",
                curves_of(contacts.x.values, {name: p / largest for name, p in curves.items()}),
            )
        )
    return panels


STATEMENTS = (
    Statement(
        34,
        "B and B̂ shift the creep-force curve at friction 0.20, and B̂′ restores it.",
        (
            of_ics(rolling, shift, SHIFTED, (LOW,)).above(
                FOLLOWS,
                "shift",
                "difference to C of the creepage without force, times the slope with C, over friction load",
            ),
            of_ics(rolling, left_after_shift, SHIFTED, (LOW,)).below(
                SMALL_PART,
                "as a whole",
                "share of the distance to C's curve that is left when the curve is moved by that difference",
            ),
            against(rolling, shift, ("Bhat_prime",), ("Bhat",), (LOW,)).below(
                SMALL_PART, "restored", "the same difference: B̂′ over B̂"
            ),
            of_ics(rolling, largest_curve_distance, ("Bhat_prime",), (LOW,)).below(
                FOLLOWS, "close", "largest distance of the curve with B̂′ from C's, over friction load"
            ),
        ),
        lambda runs: [*_curve_panels(runs), _difference_panel(runs, LOW)],
        _distances,
    ),
    Statement(
        35,
        "At equal F_x over friction load, p_x along the centre line is off with B and B̂ at friction 0.20, "
        "and B̂′ restores it.",
        (
            of_ics(rolling, line_distance, SHIFTED, (LOW,)).above(
                FOLLOWS, "off", "distance of p_x from C's at s = 0, over p_x with C, rms; F_x at half of it"
            ),
            against(rolling, line_distance, ("Bhat_prime",), ("Bhat",), (LOW,)).below(
                SMALL_PART, "restored", "the same: B̂′ over B̂"
            ),
            of_ics(rolling, line_distance, ("Bhat_prime",), (LOW,)).below(
                FOLLOWS, "close", "the same with B̂′"
            ),
        ),
        _line_panels,
        _lines,
    ),
    Statement(
        36,
        "Differences in rolling shrink with friction 0.40 and 0.60.",
        (
            from_friction_to_friction(rolling, curve_distance, SHIFTED, GROWING).below(
                1.0, "curve", "rms distance of the creep-force curve over friction load: over the one before"
            ),
            from_friction_to_friction(rolling, line_distance, SHIFTED, GROWING).below(
                1.0, "p_x", "distance of p_x at s = 0 at equal F_x over friction load: likewise"
            ),
        ),
        lambda runs: [
            *(_difference_panel(runs, friction) for friction in FRICTIONS),
            *_line_panels(runs, HIGH),
        ],
        _shrinking,
        columns=3,
    ),
)
