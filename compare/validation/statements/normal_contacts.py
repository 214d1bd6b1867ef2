"""Statements 26 to 32 ([BVSV] section 6.1): frictionless contact with A, B and B-hat beside C.

Errors of p_max, a, b and the approach are compared at angles Δδ by which the patch with C turns, at the same
load with all ICs. Estimates of errors are those of C and of the elements, on which all ICs are compared.
Shapes of pressures say where errors of ICs matter.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise, product

import numpy as np

from compare.report.charts import Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.contact_series import ICS, ContactSeries
from compare.validation.statements.curves import rms
from compare.validation.statements.frame import (
    FOLLOWS,
    SATISFACTORY,
    Estimated,
    Measure,
    Statement,
    Values,
    above,
    below,
    ratio,
)
from compare.validation.statements.runs import Runs
from femic.contact.motions.none import REFERENCE, Sensitivity, SolvedContact, sensitivities
from femic.contact.pairs.ics import C
from femic.contact.pairs.pair_on_grid import PairContact
from femic.contact.pairs.quantities import OF_FRICTIONLESS, half_length, half_width, s_range
from femic.contact.pairs.quantities import angle as patch_angle
from geometries.arrays import Array
from geometries.errors import Failure

WIDE, TALL = PAIRS = ("wide", "tall")
NAMES = ("p_max", "approach", "a", "b")
SMALL_ANGLES = (20.0, 30.0, 40.0)  # deg
ANGLES = tuple(np.arange(30.0, 101.0, 10.0))  # `wide` has no patch over more without one at its ends
GOOD = FOLLOWS  # as "B_ss is good along s" of statement 17
SOURCE_ANGLES = {  # deg, by pair and load [N]
    WIDE: {660e3: 40.0, 5300e3: 80.0, 18000e3: 110.0},
    TALL: {7.4e3: 40.0, 58e3: 80.0, 310e3: 110.0},
}

# --- 26 to 30: errors of numbers at angles of the patch -------------------------------------------------


def at_angles(runs: Runs, angles: Sequence[float]) -> Iterator[tuple[str, ContactSeries, float]]:
    """Yield pair and angle in words, the contacts of the pair, and the load [N] of each angle."""
    for pair, angle in product(PAIRS, angles):
        series = runs.contact_series(pair)
        yield f"{pair}, {angle:g}°", series, series.load_at(angle)


def at_source_loads(runs: Runs) -> Iterator[tuple[str, ContactSeries, float, float]]:
    """Yield pair and load in words, the contacts of the pair, the load [N], and the angle of the source."""
    for pair, angles in SOURCE_ANGLES.items():
        for load, angle in angles.items():
            yield f"{pair}, {load:g} N", runs.contact_series(pair), load, angle


def error_sizes(ics: Sequence[str], angles: Sequence[float]) -> Measure:
    """Measure |errors| of both pairs at angles of the patch with C."""
    return lambda runs: {
        f"{case}, {name} by {ics_symbol(which)}": abs(series.error(load, which, name))
        for case, series, load in at_angles(runs, angles)
        for name, which in product(NAMES, ics)
    }


@above(
    0.0,
    "tall minus wide",
    "|error| of p_max, approach, a, b with A on tall minus wide, at Δδ of 30, 40 ... 100°",
)
def _tall_minus_wide(runs: Runs) -> Values:
    measured = {}
    for angle, name in product(ANGLES, NAMES):
        wide, tall = (
            abs(series.error(series.load_at(angle), "A", name)) for series in map(runs.contact_series, PAIRS)
        )
        measured[f"{angle:g}°, {name}"] = Estimated(tall - wide, tall.estimate + wide.estimate)
    return measured


def errors_at(series: ContactSeries, angles: Sequence[float], ics: str, name: str) -> list[Estimated]:
    """Return the errors of a number at angles of the patch with C."""
    return [series.error(series.load_at(angle), ics, name) for angle in angles]


def bhat_over_b(cases: Sequence[tuple[str, str]]) -> Measure:
    """Measure the rms error of B-hat over that of B at all angles, by pair and number.

    What an rms is known to is at most the rms of the estimates, by the triangle inequality.
    """

    def rms_error(series: ContactSeries, ics: str, name: str) -> Estimated:
        errors = errors_at(series, ANGLES, ics, name)
        return Estimated(rms(np.array(errors)), rms(np.array([error.estimate for error in errors])))

    def measure(runs: Runs) -> Values:
        measured = {}
        for pair, name in cases:
            bhat, b = (rms_error(runs.contact_series(pair), ics, name) for ics in ("Bhat", "B"))
            measured[f"{pair}, {name}"] = ratio(bhat, b)
        return measured

    return measure


@below(FOLLOWS, "angles", "|Δδ with C over the angle of the source - 1|")
def _angle_deviations(runs: Runs) -> Values:
    measured = {}
    for case, series, load, angle in at_source_loads(runs):
        turned = series.angle_with_c(load)
        measured[case] = Estimated(abs(turned / angle - 1), turned.estimate / angle)
    return measured


def error_panels(ics: Sequence[str], angles: Sequence[float]) -> Callable[[Runs], Iterable[Panel]]:
    """Draw errors over the angle of the patch: a row per number, a column per pair."""

    def panels(runs: Runs) -> Iterator[Panel]:
        for name, pair in product(NAMES, PAIRS):
            errors = {which: errors_at(runs.contact_series(pair), angles, which, name) for which in ics}
            curves = {ics_symbol(which): 100 * np.array(values) for which, values in errors.items()}
            yield Panel(
                f"{pair}: error of {OF_FRICTIONLESS[name].symbol}",
                "Δδ with C [deg]",
                "error [%]",
                make_curves(angles, curves),
                levels=(-5.0, 5.0),
            )

    return panels


def _pairs_panels(runs: Runs) -> Iterator[Panel]:
    for name in NAMES:
        errors = {pair: errors_at(runs.contact_series(pair), ANGLES, "A", name) for pair in PAIRS}
        curves = make_curves(ANGLES, {pair: 100 * np.abs(values) for pair, values in errors.items()})
        title = f"error of {OF_FRICTIONLESS[name].symbol} by A"
        yield Panel(title, "Δδ with C [deg]", "|error| [%]", curves)


def _angle_panels(runs: Runs) -> Iterator[Panel]:
    """Return panels of the angle of the patch over the load, with all ICs, and the angles of the source."""
    for pair, angles in SOURCE_ANGLES.items():
        series = runs.contact_series(pair)
        loads = np.array([series.load_at(angle) for angle in ANGLES])
        curves = {
            ics_symbol(ics): np.array([series.angle(load, ics) for load in loads]) for ics in (C, "A", "Bhat")
        }
        yield Panel(
            pair,
            "load [kN]",
            "Δδ [deg]",
            make_curves(loads / 1e3, curves),
            log_x=True,
            marks=tuple(load / 1e3 for load in angles),
            levels=tuple(angles.values()),
        )


def _angle_details(runs: Runs) -> Values:
    """Return Δδ [deg] under the loads of the source with all ICs, with C also at the exact distance."""
    details, exact_details = dict[str, float](), dict[str, float]()
    for case, series, load, _ in at_source_loads(runs):
        for ics in ICS:
            details[f"{case}, Δδ with {ics_symbol(ics)} [deg]"] = series.angle(load, ics)
        exact = f"{case}, Δδ with C, exact distance [deg]"
        try:
            contact = series.solved(load, exact=True)
            exact_details[exact] = patch_angle(contact.on_grid, contact.normal)
        except Failure:
            exact_details[exact] = np.nan
    return details | exact_details


def load_details(angles: Sequence[float]) -> Measure:
    """Measure the loads at which the patch with C turns by angles."""
    return lambda runs: {
        f"{pair}: load at which Δδ with C is {angle:g}° [N]": runs.contact_series(pair).load_at(angle)
        for pair, angle in product(PAIRS, angles)
    }


def exact_details(angles: Sequence[float]) -> Measure:
    """Measure errors of p_max and the approach with the distance of the displaced body; NaN if not found.

    That is the convention of the contact which changes most: the source's distance is linearised.
    """

    def error(series: ContactSeries, load: float, ics: str, name: str) -> float:
        try:
            ours, with_c = (series.solved(load, which, exact=True).normal for which in (ics, C))
        except Failure:
            return np.nan
        if name == "approach":
            return ours.approach / with_c.approach - 1
        return float(np.max(ours.p)) / float(np.max(with_c.p)) - 1

    return lambda runs: {
        f"exact distance: {case.replace(', ', ', load of ')}, {name} by {ics_symbol(ics)}": error(
            series, load, ics, name
        )
        for case, series, load in at_angles(runs, angles)
        for name, ics in product(("p_max", "approach"), ("A", "B", "Bhat"))
    }


def _approach_details(runs: Runs) -> Values:
    """Return errors of the approach by A over that with C, and over C's with its rigid part.

    That is the convention that decides errors of approaches: the discount of C.
    """
    details = {}
    for case, series, load in at_angles(runs, (40.0, 80.0, 100.0)):
        by_a, by_c = (series.numbers(load, ics)["approach"] for ics in ("A", C))
        whole = by_c + series.rigid_compliance * load
        details[f"{case}: approach by A / approach by C - 1"] = by_a / by_c - 1
        details[f"{case}: the same with the rigid part"] = by_a / whole - 1
        details[f"{case}: rigid part over C's approach"] = whole / by_c - 1
    return details


def _rigid_details(runs: Runs) -> Values:
    """Return differences of approaches to C over the load [mm/MN], at angles of the patch.

    Where they are alike at all angles, the reference of approaches (a rigid motion) decides their sign.
    """
    details: dict[str, float] = {}
    for case, series, load in at_angles(runs, ANGLES):
        for ics in ("B", "Bhat"):
            apart = series.numbers(load, ics)["approach"] - series.numbers(load)["approach"]
            details[f"{case}: (approach by {ics_symbol(ics)} - by C) / load [mm/MN]"] = 1e6 * apart / load
    return details


ERRORS = (
    Statement(
        26,
        "A_nn is within 5 % of C up to Δδ of 40° in p_max, a, b and approach, in both pairs "
        "(section 6.1; a and b as far as the mesh tells them).",
        [
            below(SATISFACTORY, "A", "|error| of p_max, approach, a, b with A at Δδ of 20, 30, 40°")(
                error_sizes(("A",), SMALL_ANGLES)
            )
        ],
        error_panels(("A",), (*SMALL_ANGLES, *ANGLES[2:])),
        lambda runs: {**load_details(SMALL_ANGLES)(runs), **exact_details((40.0,))(runs)},
    ),
    Statement(
        27,
        "At equal Δδ, the errors of A are larger on the tall pair than on the wide pair (section 6.1).",
        [_tall_minus_wide],
        _pairs_panels,
        lambda runs: {**load_details(ANGLES)(runs), **_approach_details(runs)},
    ),
    Statement(
        28,
        "B and B̂ are accurate on both pairs up to Δδ of about 100° (section 6.1; accurate: within 10 %, "
        "as in 17).",
        [
            below(GOOD, "B, B̂", "|error| of p_max, approach, a, b with B and B̂ at Δδ of 30, 40 ... 100°")(
                error_sizes(("B", "Bhat"), ANGLES)
            )
        ],
        error_panels(("B", "Bhat"), ANGLES),
        exact_details((80.0, 100.0)),
    ),
    Statement(
        29,
        "B̂ is better than B, except for the approach on the tall pair (section 6.1).",
        (
            below(1.0, "better", "rms error of B̂ over that of B at Δδ of 30, 40 ... 100°")(
                bhat_over_b([case for case in product(PAIRS, NAMES) if case != (TALL, "approach")])
            ),
            above(1.0, "approach", "the same of the approach on tall")(bhat_over_b([(TALL, "approach")])),
        ),
        error_panels(("B", "Bhat"), ANGLES),
        _rigid_details,
    ),
    Statement(
        30,
        "Loads of 660, 5300 and 18 000 kN on the wide pair and of 7.4, 58 and 310 kN on the tall one give Δδ "
        "near 40, 80 and 110° (section 6.1; near: within 10 %).",
        [_angle_deviations],
        _angle_panels,
        _angle_details,
    ),
)

# --- 31: shapes of pressures ----------------------------------------------------------------------------

OF_HERTZ = 4 / np.pi  # largest over mean of an ellipse over its axis
KURTOSIS_OF_HERTZ = 2.0


def pressure_profile(contact: PairContact, along: str) -> tuple[Array, Array]:
    """Return places from the middle over the half-length of the patch, and pressures there [MPa], (n,).

    Those of the two lines of elements beside x = 0, or beside the middle of the patch along s, are averaged.
    """
    on_grid, p = contact.on_grid, contact.normal.p
    low, high = s_range(on_grid, contact.normal)
    s, middle = on_grid.grid.strips, (low + high) / 2
    if along == "s":
        return (s - middle) / half_width(on_grid, contact.normal), _interpolated_row(p, on_grid.x, 0.0)
    return on_grid.x / half_length(on_grid, contact.normal), _interpolated_row(p.T, s, middle)


def _interpolated_row(rows: Array, places: Array, at: float) -> Array:
    after = int(np.clip(np.searchsorted(places, at), 1, len(places) - 1))
    share = (at - places[after - 1]) / (places[after] - places[after - 1])
    return np.asarray((1 - share) * rows[after - 1] + share * rows[after])


def peakedness(places: Array, p: Array) -> float:
    """Return largest over mean pressure on a line from -1 to 1: 1 if uniform, 4/pi of Hertz's ellipse."""
    mean = np.sum(p) * (places[1] - places[0]) / 2
    return float(np.max(p) / mean)


def kurtosis(places: Array, p: Array) -> float:
    """Return the kurtosis of pressures over their line: 1.8 if uniform, 2 of Hertz's ellipse."""
    offsets = places - np.sum(p * places) / np.sum(p)
    return float(np.sum(p * offsets**4) * np.sum(p) / np.sum(p * offsets**2) ** 2)


def source_profile(runs: Runs, pair: str, load: float, along: str) -> tuple[Array, Array]:
    """Return places and pressures of the profile with C under a load of the source [N]."""
    return pressure_profile(runs.contact_series(pair).solved(load), along)


def peakedness_growth(along: str, pairs: Sequence[str]) -> Measure:
    """Measure the peakedness with C under each of the source's loads over that under the load before, - 1."""
    return lambda runs: {
        f"{pair}, {low / 1e3:g} to {high / 1e3:g} kN": peakedness(*source_profile(runs, pair, high, along))
        / peakedness(*source_profile(runs, pair, low, along))
        - 1
        for pair in pairs
        for low, high in pairwise(SOURCE_ANGLES[pair])
    }


def off_hertz(along: str) -> Measure:
    """Measure |peakedness with C over that of Hertz's pressures - 1| under the source's loads."""
    return lambda runs: {
        f"{pair}, {load / 1e3:g} kN": abs(peakedness(*source_profile(runs, pair, load, along)) / OF_HERTZ - 1)
        for pair in PAIRS
        for load in SOURCE_ANGLES[pair]
    }


def _shape_details(runs: Runs) -> Values:
    """Return peakedness over that of Hertz and kurtosis of all profiles."""
    details: dict[str, float] = {}
    for pair in PAIRS:
        for load, along in product(SOURCE_ANGLES[pair], ("s", "x")):
            profile = source_profile(runs, pair, load, along)
            case = f"{pair}, {load / 1e3:g} kN, along {along}"
            details[f"{case}: largest over mean pressure, of Hertz's"] = peakedness(*profile) / OF_HERTZ
            details[f"{case}: kurtosis ({KURTOSIS_OF_HERTZ:g} of Hertz's)"] = kurtosis(*profile)
    return details


def _shape_panels(runs: Runs) -> Iterator[Panel]:
    """Return profiles over their mean, a row per line, a column per pair, and Hertz's."""
    at = np.linspace(-1, 1, 101)
    for along, pair in product(("s", "x"), PAIRS):
        curves = {}
        for load in SOURCE_ANGLES[pair]:
            places, p = source_profile(runs, pair, load, along)
            curves[f"{load / 1e3:g} kN"] = np.interp(at, places, p) * peakedness(places, p) / np.max(p)
        yield Panel(
            f"{pair}: pressures with C along {along}",
            f"{along} over the half-length of the patch",
            "pressure divided by its mean",
            make_curves(at, curves | {"Hertz": OF_HERTZ * np.sqrt(1 - at**2)}),
        )


# --- 32: displacements under given pressures ------------------------------------------------------------

SHAPE_LOADS = {WIDE: 5300e3, TALL: 310e3}  # N, those of the source's figure: as the scenes have them
EQUAL_ANGLES = (40.0, 80.0, 100.0)  # deg
Differences = dict[tuple[str, str], Sensitivity]  # by the pair of the pressures and that of the patch


def displacement_differences(runs: Runs, loads: Mapping[str, float]) -> Differences:
    """Return differences of u_n by A and B-hat under given pressures."""
    contacts: dict[str, SolvedContact] = {
        pair: runs.contact_series(pair).contact(load, REFERENCE) for pair, load in loads.items()
    }
    return {(case.pressures, case.patch): case for case in sensitivities(contacts)}


def all_differences(runs: Runs) -> Iterator[tuple[str, Differences]]:
    """Yield the differences under the source's loads, and at equal angles of both patches, with a name."""
    yield "5300 and 310 kN", displacement_differences(runs, SHAPE_LOADS)
    for angle in EQUAL_ANGLES:
        loads = {pair: runs.contact_series(pair).load_at(angle) for pair in PAIRS}
        yield f"both {angle:g}°", displacement_differences(runs, loads)


def by_pressures(runs: Runs) -> Values:
    """Measure the largest difference under the pressures of `wide` over that of `tall`, on either patch."""
    return {
        f"{name}, patch of {patch}": cases[WIDE, patch].largest / cases[TALL, patch].largest
        for name, cases in all_differences(runs)
        for patch in PAIRS
    }


def by_patch(runs: Runs) -> Values:
    """Measure the largest difference on the patch of `tall` over that on `wide`, under equal pressures."""
    return {
        f"{name}, pressures of {pressures}": cases[pressures, TALL].largest / cases[pressures, WIDE].largest
        for name, cases in all_differences(runs)
        for pressures in PAIRS
    }


def _difference_details(runs: Runs) -> Values:
    details: dict[str, float] = {}
    for name, cases in all_differences(runs):
        for (pressures, patch), case in cases.items():
            label = f"{name}, pressures of {pressures} on {patch}"
            details[f"{label}: largest |difference|"] = case.largest
            details[f"{label}: range of differences"] = float(np.ptp(case.inside))
    return details


def _difference_panels(runs: Runs) -> Iterator[Panel]:
    """Return differences along s at x = 0 on the patch of each pair, under the pressures of both."""
    cases = displacement_differences(runs, SHAPE_LOADS)
    for patch in PAIRS:
        case = cases[WIDE, patch]
        row = len(case.x) // 2
        inside = case.on_patch[row]
        curves = {
            f"pressures of {pressures}": 100 * cases[pressures, patch].difference[row, inside]
            for pressures in PAIRS
        }
        title, label = f"patch of {patch}: u_n by A less B̂", "of the largest u_n by B̂ [%]"
        yield Panel(title, "s [mm]", label, make_curves(case.s[inside], curves))


SHAPES = (
    Statement(
        31,
        "With increasing load, the pressures along s become more uniform on the wide pair and more peaked "
        "on the tall pair. Along x they stay close to Hertz and become slightly more peaked (section "
        "6.1).",
        (
            below(0.0, "uniform", "along s, wide: change of largest over mean pressure from load to load")(
                peakedness_growth("s", (WIDE,))
            ),
            above(0.0, "peaked", "along s, tall: the same")(peakedness_growth("s", (TALL,))),
            below(FOLLOWS, "near Hertz", "along x: |largest over mean pressure, over 4/π of Hertz's, - 1|")(
                off_hertz("x")
            ),
            above(0.0, "along x", "along x: change from load to load")(peakedness_growth("x", PAIRS)),
        ),
        _shape_panels,
        _shape_details,
    ),
    Statement(
        32,
        "For equal IC errors, more widely spread pressures give larger differences of u_n (eq. (18)) on "
        "each pair, and the differences are larger on the tall pair than on the wide pair (section 6.1).",
        (
            above(
                1.0,
                "spread",
                "largest |u_n by A - u_n by B̂| on a patch: under the pressures of wide, which spread more, "
                "over those of tall",
            )(by_pressures),
            above(1.0, "tall", "the same on the patch of tall over that of wide, under equal pressures")(
                by_patch
            ),
        ),
        _difference_panels,
        _difference_details,
    ),
)

STATEMENTS = (*ERRORS, *SHAPES)
