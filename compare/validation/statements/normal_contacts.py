"""Statements 26 to 30 ([BVSV] section 6.1): frictionless contact with A, B and B-hat beside C.

Errors of p_max, a, b and the approach are compared at angles Δδ by which the patch with C turns, at the same
load with all ICs. Estimates of errors are those of C and of the elements, on which all ICs are compared.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import product

import numpy as np

from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.contact_series import ICS, ContactSeries, Estimated, ratio
from compare.validation.statements.criteria import FOLLOWS, SATISFACTORY, Numbers, Statement
from compare.validation.statements.curves import rms
from compare.validation.statements.runs import Runs
from femic.contact.normal import NormalContact
from femic.contact.pairs.ics import C
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.contact.pairs.quantities import angle as patch_angle
from geometries.arrays import Array
from geometries.errors import Failure

WIDE, TALL = PAIRS = ("wide", "tall")
FROM_PRESSURES = ("p_max", "approach")
OF_EDGES = ("a", "b")
NAMES = (*FROM_PRESSURES, *OF_EDGES)
NUMBERS: Mapping[str, Callable[[NormalContact], float]] = {
    "p_max": lambda contact: float(np.max(contact.p)),
    "approach": lambda contact: contact.approach,
}
SMALL_ANGLES = (20.0, 30.0, 40.0)  # deg
ANGLES = tuple(np.arange(30.0, 101.0, 10.0))  # `wide` has no patch over more without one at its ends
GOOD = FOLLOWS  # as "B_ss is good along s" of statement 17
SOURCE_ANGLES = {  # deg, by pair and load [N]
    WIDE: {660e3: 40.0, 5300e3: 80.0, 18000e3: 110.0},
    TALL: {7.4e3: 40.0, 58e3: 80.0, 310e3: 110.0},
}


def size(series: ContactSeries, load: float, ics: str, name: str) -> Estimated:
    """Return the |error| of a number with some ICs."""
    error = series.error(load, ics, name)
    return Estimated(abs(error), error.estimate)


def sizes(ics: Sequence[str], angles: Sequence[float]) -> Numbers:
    """Measure |errors| of both pairs at angles of the patch with C."""

    def measure(runs: Runs) -> Mapping[str, float]:
        return {
            f"{pair}, {angle:g}°, {name} by {symbol_of(which)}": size(
                series := runs.contact_series(pair), series.load_at(angle), which, name
            )
            for pair, angle, name, which in product(PAIRS, angles, NAMES, ics)
        }

    return Numbers(measure)


def tall_minus_wide(runs: Runs) -> Mapping[str, float]:
    """Measure |error of A| on `tall` minus that on `wide` at equal angles."""

    def difference(angle: float, name: str) -> Estimated:
        wide, tall = (
            size(series := runs.contact_series(pair), series.load_at(angle), "A", name) for pair in PAIRS
        )
        return Estimated(tall - wide, tall.estimate + wide.estimate)

    return {f"{angle:g}°, {name}": difference(angle, name) for angle, name in product(ANGLES, NAMES)}


def bhat_over_b(cases: Sequence[tuple[str, str]]) -> Numbers:
    """Measure the rms error of B-hat over that of B at all angles, by pair and number."""

    def ratio_of(runs: Runs, pair: str, name: str) -> float:
        bhat, b = (rms_error(runs.contact_series(pair), ANGLES, ics, name) for ics in ("Bhat", "B"))
        return ratio(bhat, b)

    return Numbers(lambda runs: {f"{pair}, {name}": ratio_of(runs, pair, name) for pair, name in cases})


def rms_error(series: ContactSeries, angles: Sequence[float], ics: str, name: str) -> Estimated:
    """Return the root mean square of errors at angles of the patch with C.

    Its own error is at most that of their estimates, by the triangle inequality.
    """
    errors = [series.error(series.load_at(angle), ics, name) for angle in angles]
    return Estimated(rms(np.array(errors)), rms(np.array([error.estimate for error in errors])))


def errors_at(series: ContactSeries, angles: Sequence[float], ics: str, name: str) -> Array:
    """Return the errors of a number at angles of the patch with C, (n,)."""
    return np.array([series.error(series.load_at(angle), ics, name) for angle in angles])


def angle_deviations(runs: Runs) -> Mapping[str, float]:
    """Measure |Δδ with C over the angle of the source - 1| under its loads."""

    def deviation(turned: Estimated, angle: float) -> Estimated:
        return Estimated(abs(turned / angle - 1), turned.estimate / angle)

    return {
        f"{pair}, {load:g} N": deviation(runs.contact_series(pair).angle_with_c(load), angle)
        for pair, angles in SOURCE_ANGLES.items()
        for load, angle in angles.items()
    }


# --- panels and further numbers -------------------------------------------------------------------------


def error_panels(
    ics: Sequence[str], angles: Sequence[float], names: Sequence[str] = NAMES
) -> Callable[[Runs], list[Panel]]:
    """Make panels of errors over the angle of the patch: a row per number, a column per pair."""

    def panel(runs: Runs, name: str, pair: str) -> Panel:
        series = runs.contact_series(pair)
        curves = {symbol_of(which): 100 * errors_at(series, angles, which, name) for which in ics}
        return Panel(
            f"{pair}: error of {OF_FRICTIONLESS[name].symbol}",
            "Δδ with C [deg]",
            "error [%]",
            curves_of(angles, curves),
            levels=(-5.0, 5.0),
        )

    return lambda runs: [panel(runs, name, pair) for name, pair in product(names, PAIRS)]


def _pairs_panels(runs: Runs) -> list[Panel]:
    """Return panels of the errors of A on both pairs, by number."""
    return [
        Panel(
            f"error of {OF_FRICTIONLESS[name].symbol} by A",
            "Δδ with C [deg]",
            "|error| [%]",
            curves_of(
                ANGLES,
                {
                    pair: 100 * np.abs(errors_at(runs.contact_series(pair), ANGLES, "A", name))
                    for pair in PAIRS
                },
            ),
        )
        for name in NAMES
    ]


def _angle_panels(runs: Runs) -> list[Panel]:
    """Return panels of the angle of the patch over the load, with all ICs, and the angles of the source."""
    panels = []
    for pair, angles in SOURCE_ANGLES.items():
        series = runs.contact_series(pair)
        loads = np.array([series.load_at(angle) for angle in ANGLES])
        curves = {
            symbol_of(ics): np.array([series.angle(load, ics) for load in loads]) for ics in (C, "A", "Bhat")
        }
        kilonewtons = tuple(load / 1e3 for load in angles)
        panels.append(
            Panel(
                pair,
                "load [kN]",
                "Δδ [deg]",
                curves_of(loads / 1e3, curves),
                log_x=True,
                marks=kilonewtons,
                levels=tuple(angles.values()),
            )
        )
    return panels


def angles_by_ics(runs: Runs) -> Mapping[str, float]:
    """Return Δδ [deg] under the loads of the source with all ICs, with C also at the exact distance."""
    return {
        f"{pair}, {load:g} N, Δδ with {symbol_of(ics)} [deg]": runs.contact_series(pair).angle(load, ics)
        for pair, angles in SOURCE_ANGLES.items()
        for load in angles
        for ics in ICS
    } | {
        f"{pair}, {load:g} N, Δδ with C, exact distance [deg]": _exact_angle(runs.contact_series(pair), load)
        for pair, angles in SOURCE_ANGLES.items()
        for load in angles
    }


def _exact_angle(series: ContactSeries, load: float) -> float:
    try:
        contact = series.solved(load, exact=True)
    except Failure:
        return np.nan
    return patch_angle(contact.on_grid, contact.normal)


def _loads(runs: Runs, angles: Sequence[float]) -> Mapping[str, float]:
    """Return the loads at which the patch with C turns by angles."""
    return {
        f"{pair}: load at which Δδ with C is {angle:g}° [N]": runs.contact_series(pair).load_at(angle)
        for pair, angle in product(PAIRS, angles)
    }


def with_exact_distance(runs: Runs, angles: Sequence[float]) -> Mapping[str, float]:
    """Return errors of p_max and the approach with the distance of the displaced body; NaN if not found.

    That is the convention of the contact which changes most: the source's distance is linearised.
    """
    return {
        f"exact distance: {pair}, load of {angle:g}°, {name} by {symbol_of(ics)}": _exact_error(
            series := runs.contact_series(pair), series.load_at(angle), ics, name
        )
        for pair, angle, name, ics in product(PAIRS, angles, FROM_PRESSURES, ("A", "B", "Bhat"))
    }


def _exact_error(series: ContactSeries, load: float, ics: str, name: str) -> float:
    try:
        number, with_c = (NUMBERS[name](series.solved(load, which, exact=True).normal) for which in (ics, C))
    except Failure:
        return np.nan
    return number / with_c - 1


def approaches_on_supports(runs: Runs) -> Mapping[str, float]:
    """Return errors of the approach by A over that with C, and over C's with its rigid part.

    That is the convention that decides errors of approaches: the discount of C.
    """
    details = {}
    for pair, angle in product(PAIRS, (40.0, 80.0, 100.0)):
        series = runs.contact_series(pair)
        load = series.load_at(angle)
        by_a, by_c = (series.numbers(load, ics)["approach"] for ics in ("A", C))
        whole = by_c + series.rigid_compliance * load
        details[f"{pair}, {angle:g}°: approach by A over C's - 1"] = by_a / by_c - 1
        details[f"{pair}, {angle:g}°: the same with the rigid part"] = by_a / whole - 1
        details[f"{pair}, {angle:g}°: rigid part over C's approach"] = whole / by_c - 1
    return details


def rigid_differences(runs: Runs) -> Mapping[str, float]:
    """Return differences of approaches to C over the load [mm/MN], at angles of the patch.

    Where they are alike at all angles, the reference of approaches (a rigid motion) decides their sign.
    """
    return {
        f"{pair}, {angle:g}°: (approach by {symbol_of(ics)} - by C) / load [mm/MN]": 1e6
        * (series.numbers(load, ics)["approach"] - series.numbers(load)["approach"])
        / load
        for pair, angle, ics in product(PAIRS, ANGLES, ("B", "Bhat"))
        for series in [runs.contact_series(pair)]
        for load in [series.load_at(angle)]
    }


STATEMENTS = (
    Statement(
        26,
        "A_nn is within 5 % of C up to Δδ of 40° in p_max, a, b and approach, in both pairs "
        "(section 6.1; a and b as far as the mesh tells them).",
        (
            sizes(("A",), SMALL_ANGLES).below(
                SATISFACTORY, "A", "|error| of p_max, approach, a, b with A at Δδ of 20, 30, 40°"
            ),
        ),
        error_panels(("A",), (*SMALL_ANGLES, *ANGLES[2:])),
        lambda runs: {**_loads(runs, SMALL_ANGLES), **with_exact_distance(runs, (40.0,))},
    ),
    Statement(
        27,
        "At equal Δδ errors of A are larger on the tall pair than on the wide one (section 6.1).",
        (
            Numbers(tall_minus_wide).above(
                0.0,
                "tall minus wide",
                "|error| of p_max, approach, a, b with A on tall minus wide, at Δδ of 30, 40 ... 100°",
            ),
        ),
        _pairs_panels,
        lambda runs: {**_loads(runs, ANGLES), **approaches_on_supports(runs)},
    ),
    Statement(
        28,
        "B and B̂ are good in both pairs up to Δδ of about 100° (section 6.1; good: within 10 %, as in 17).",
        (
            sizes(("B", "Bhat"), ANGLES).below(
                GOOD, "B, B̂", "|error| of p_max, approach, a, b with B and B̂ at Δδ of 30, 40 ... 100°"
            ),
        ),
        error_panels(("B", "Bhat"), ANGLES),
        partial(with_exact_distance, angles=(80.0, 100.0)),
    ),
    Statement(
        29,
        "B̂ is better than B, but for the approach on the tall pair (section 6.1).",
        (
            bhat_over_b(
                [(pair, name) for pair in PAIRS for name in NAMES if (pair, name) != (TALL, "approach")]
            ).below(1.0, "better", "rms error of B̂ over that of B at Δδ of 30, 40 ... 100°"),
            bhat_over_b([(TALL, "approach")]).above(1.0, "approach", "the same of the approach on tall"),
        ),
        error_panels(("B", "Bhat"), ANGLES),
        rigid_differences,
    ),
    Statement(
        30,
        "Loads of 660, 5300 and 18 000 kN on the wide pair and of 7.4, 58 and 310 kN on the tall one give Δδ "
        "near 40, 80 and 110° (section 6.1; near: within 10 %).",
        (Numbers(angle_deviations).below(FOLLOWS, "angles", "|Δδ with C over the angle of the source - 1|"),),
        _angle_panels,
        angles_by_ics,
    ),
)
