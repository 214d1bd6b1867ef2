"""Statements 31 and 32 ([BVSV] section 6.1): shapes of pressures, and what they mean for errors of ICs."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, product

import numpy as np

from compare.report.charts import Panel, curves_of
from compare.validation.statements.criteria import FOLLOWS, Numbers, Statement
from compare.validation.statements.normal_contacts import PAIRS, SOURCE_ANGLES, TALL, WIDE
from compare.validation.statements.runs import Runs
from femic.contact.motions.none import REFERENCE, Sensitivity, SolvedContact, sensitivities
from femic.contact.pairs.pair_on_grid import PairContact
from femic.contact.pairs.quantities import half_length, half_width, s_range
from geometries.arrays import Array

OF_HERTZ = 4 / np.pi  # largest over mean of an ellipse over its axis
KURTOSIS_OF_HERTZ = 2.0
SHAPE_LOADS = {WIDE: 5300e3, TALL: 310e3}  # N, those of the source's figure: as the scenes have them
EQUAL_ANGLES = (40.0, 80.0, 100.0)  # deg
ALONG = ("s", "x")

# --- 31 -------------------------------------------------------------------------------------------------


def profile(contact: PairContact, along: str) -> tuple[Array, Array]:
    """Return places from the middle over the half-length of the patch, and pressures there [MPa], (n,).

    Those of the two lines of elements beside x = 0, or beside the middle of the patch along s, are averaged.
    """
    on_grid, p = contact.on_grid, contact.normal.p
    low, high = s_range(on_grid, contact.normal)
    s, middle = on_grid.grid.strips, (low + high) / 2
    if along == "s":
        return (s - middle) / half_width(on_grid, contact.normal), _beside(p, on_grid.x, 0.0)
    return on_grid.x / half_length(on_grid, contact.normal), _beside(p.T, s, middle)


def _beside(rows: Array, places: Array, at: float) -> Array:
    """Return the row of values at a place, interpolated between rows (n, m); (m,)."""
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


def growth(along: str, pairs: Sequence[str]) -> Numbers:
    """Measure the peakedness with C under each of the source's loads over that under the load before, - 1."""

    def measure(runs: Runs) -> Mapping[str, float]:
        return {
            f"{pair}, {low / 1e3:g} to {high / 1e3:g} kN": _peakedness(runs, pair, high, along)
            / _peakedness(runs, pair, low, along)
            - 1
            for pair in pairs
            for low, high in pairwise(SOURCE_ANGLES[pair])
        }

    return Numbers(measure)


def off_hertz(along: str) -> Numbers:
    """Measure |peakedness with C over that of Hertz's pressures - 1| under the source's loads."""
    return Numbers(
        lambda runs: {
            f"{pair}, {load / 1e3:g} kN": abs(_peakedness(runs, pair, load, along) / OF_HERTZ - 1)
            for pair, load in _cases()
        }
    )


def _peakedness(runs: Runs, pair: str, load: float, along: str) -> float:
    return peakedness(*profile(runs.contact_series(pair).solved(load), along))


def _cases() -> Iterator[tuple[str, float]]:
    return ((pair, load) for pair in PAIRS for load in SOURCE_ANGLES[pair])


def _shape_details(runs: Runs) -> Mapping[str, float]:
    """Return peakedness over that of Hertz and kurtosis of all profiles."""
    details: dict[str, float] = {}
    for (pair, load), along in product(_cases(), ALONG):
        places, p = profile(runs.contact_series(pair).solved(load), along)
        case = f"{pair}, {load / 1e3:g} kN, along {along}"
        details[f"{case}: largest over mean pressure, of Hertz's"] = peakedness(places, p) / OF_HERTZ
        details[f"{case}: kurtosis ({KURTOSIS_OF_HERTZ:g} of Hertz's)"] = kurtosis(places, p)
    return details


def _shape_panels(runs: Runs) -> list[Panel]:
    """Return profiles over their mean, a row per line, a column per pair, and Hertz's."""
    return [_shape_panel(runs, along, pair) for along, pair in product(ALONG, PAIRS)]


def _shape_panel(runs: Runs, along: str, pair: str) -> Panel:
    at = np.linspace(-1, 1, 101)
    curves = {}
    for load in SOURCE_ANGLES[pair]:
        places, p = profile(runs.contact_series(pair).solved(load), along)
        curves[f"{load / 1e3:g} kN"] = np.interp(at, places, p) * peakedness(places, p) / np.max(p)
    return Panel(
        f"{pair}: pressures with C along {along}",
        f"{along} over the half-length of the patch",
        "pressure over its mean",
        curves_of(at, curves | {"Hertz": OF_HERTZ * np.sqrt(1 - at**2)}),
    )


# --- 32 -------------------------------------------------------------------------------------------------


def differences(runs: Runs, loads: Mapping[str, float]) -> dict[tuple[str, str], Sensitivity]:
    """Return differences of u_n by A and B-hat under given pressures, by their pair and that of the patch."""
    contacts: dict[str, SolvedContact] = {
        pair: runs.contact_series(pair).contact(load, REFERENCE) for pair, load in loads.items()
    }
    return {(case.pressures, case.patch): case for case in sensitivities(contacts)}


def all_differences(runs: Runs) -> Iterator[tuple[str, dict[tuple[str, str], Sensitivity]]]:
    """Yield the differences under the source's loads, and at equal angles of both patches, with a name."""
    yield "5300 and 310 kN", differences(runs, SHAPE_LOADS)
    for angle in EQUAL_ANGLES:
        yield (
            f"both {angle:g}°",
            differences(runs, {pair: runs.contact_series(pair).load_at(angle) for pair in PAIRS}),
        )


def by_pressures(runs: Runs) -> Mapping[str, float]:
    """Measure the largest difference under the pressures of `wide` over that of `tall`, on either patch."""
    return {
        f"{name}, patch of {patch}": cases[WIDE, patch].largest / cases[TALL, patch].largest
        for name, cases in all_differences(runs)
        for patch in PAIRS
    }


def by_patch(runs: Runs) -> Mapping[str, float]:
    """Measure the largest difference on the patch of `tall` over that on `wide`, under equal pressures."""
    return {
        f"{name}, pressures of {pressures}": cases[pressures, TALL].largest / cases[pressures, WIDE].largest
        for name, cases in all_differences(runs)
        for pressures in PAIRS
    }


def _difference_details(runs: Runs) -> Mapping[str, float]:
    """Return the largest differences, of the largest displacement with B-hat, and their range."""
    return {
        f"{name}, pressures of {pressures} on {patch}: {what}": value
        for name, cases in all_differences(runs)
        for (pressures, patch), case in cases.items()
        for what, value in (
            ("largest |difference|", case.largest),
            ("range of differences", float(np.ptp(case.inside))),
        )
    }


def _difference_panels(runs: Runs) -> list[Panel]:
    """Return differences along s at x = 0 on the patch of each pair, under the pressures of both."""
    cases = differences(runs, SHAPE_LOADS)
    panels = []
    for patch in PAIRS:
        case = cases[WIDE, patch]
        row = len(case.x) // 2
        inside = case.on_patch[row]
        curves = {
            f"pressures of {pressures}": 100 * cases[pressures, patch].difference[row, inside]
            for pressures in PAIRS
        }
        panels.append(
            Panel(
                f"patch of {patch}: u_n by A less B̂",
                "s [mm]",
                "of the largest u_n by B̂ [%]",
                curves_of(case.s[inside], curves),
            )
        )
    return panels


STATEMENTS = (
    Statement(
        31,
        "With the load, pressures along s grow more uniform on the wide pair and more peaked on the tall "
        "one; those along x stay near Hertz's and become slightly more peaked (section 6.1).",
        (
            growth("s", (WIDE,)).below(
                0.0, "uniform", "along s, wide: change of largest over mean pressure from load to load"
            ),
            growth("s", (TALL,)).above(0.0, "peaked", "along s, tall: the same"),
            off_hertz("x").below(
                FOLLOWS, "near Hertz", "along x: |largest over mean pressure, over 4/π of Hertz's, - 1|"
            ),
            growth("x", PAIRS).above(0.0, "along x", "along x: change from load to load"),
        ),
        _shape_panels,
        _shape_details,
    ),
    Statement(
        32,
        "Under equal errors of ICs more spread pressures give larger differences of u_n (eq. (18)) on each "
        "pair, and the tall pair has larger ones than the wide one (section 6.1).",
        (
            Numbers(by_pressures).above(
                1.0,
                "spread",
                "largest |u_n by A - u_n by B̂| on a patch: under the pressures of wide, which spread more, "
                "over those of tall",
            ),
            Numbers(by_patch).above(
                1.0, "tall", "the same on the patch of tall over that of wide, under equal pressures"
            ),
        ),
        _difference_panels,
        _difference_details,
    ),
)
