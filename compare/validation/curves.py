"""Curves that statements are about: components of ICs along lines, their errors, and panels to look at."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from approx.target import indices
from compare.figures import SYMBOLS
from compare.pipeline import Results, ics_of, reference_of, shares_of
from geometries.patches import OffsetLine

Array = NDArray[np.float64]

BODIES = ("combined", "lower", "upper")
CONVEX, CONCAVE = "lower", "upper"


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves to look at, over one abscissa; `estimate`: that of the curve "C", drawn as a band."""

    title: str
    across: str  # label of the abscissa
    at: Array
    up: str  # label of the ordinate
    curves: Mapping[str, Array]
    estimate: Array | None = None


def beyond(panel: Panel, at: float) -> Panel:
    """A panel from an abscissa on."""
    kept = panel.at >= at
    curves = {name: values[kept] for name, values in panel.curves.items()}
    estimate = None if panel.estimate is None else panel.estimate[kept]
    return replace(panel, at=panel.at[kept], curves=curves, estimate=estimate)


@dataclass(frozen=True)
class Measured:
    """The numbers of a statement's criteria by case, and what to look at, in so many columns.

    `details`: what the numbers come from.
    """

    values: Mapping[str, Mapping[str, float]]
    panels: tuple[Panel, ...] = ()
    details: Mapping[str, float] = field(default_factory=dict)
    columns: int = 2  # one for each geometry


def along(results: Results, direction: str) -> list[OffsetLine]:
    """The lines of a scene along x, or along s."""
    return [line for line in results.scene.lines if line.along == direction]


def line_at(results: Results, s: float) -> OffsetLine:
    """The line along x at an arc length."""
    return next(line for line in along(results, "x") if abs(line.s[0] - s) < 1e-9)


def points_of(results: Results, lines: Iterable[OffsetLine]) -> NDArray[np.int64]:
    """The numbers of the points of lines."""
    parts = [results.lines[line.name] for line in lines]
    return np.concatenate([np.arange(part.start, part.stop) for part in parts])


def curve(
    results: Results, variant: str, body: str, component: str, lines: Iterable[OffsetLine] | None = None
) -> Array:
    """A component at the points of lines (default: all), dimensionless."""
    points = points_of(results, results.scene.lines if lines is None else lines)
    return np.asarray(unit(results) * ics_of(results, variant, body)[indices(component)][points])


def unit(results: Results) -> float:
    """What makes ICs dimensionless: E L [N/mm]."""
    return results.scene.reference_E * results.scene.reference_length


def error(
    results: Results, variant: str, body: str, component: str, lines: Iterable[OffsetLine] | None = None
) -> float:
    """Largest error of a component of a variant over lines (default: all), against C."""
    off = ics_of(results, variant, body) - reference_of(results, body).ic
    return deviation(results, off, body, component, lines)


def deviation(
    results: Results, off: Array, body: str, component: str, lines: Iterable[OffsetLine] | None = None
) -> float:
    """Largest share that a deviation (3, 3, n) has of the scale of a line (default: of all)."""
    shares = shares_of(results, body, off)
    return max(
        float(shares[line.name][indices(component)])
        for line in (results.scene.lines if lines is None else lines)
    )


def rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def panel(
    results: Results,
    variants: Iterable[str],
    of: tuple[str, str],
    line: OffsetLine,
    more: Mapping[str, Array] | None = None,
) -> Panel:
    """C, variants and further curves of a body and component on the half of a line that is not negative."""
    (body, component), shown = of, line.running >= 0
    curves = {name: curve(results, name, body, component, [line])[shown] for name in ("C", *variants)}
    named = {SYMBOLS.get(name, name): values for name, values in curves.items()}
    known = reference_of(results, body).estimate[indices(component)][points_of(results, [line])][shown]
    return Panel(
        f"{results.scene.name}, {body}: {component} on {line.name}",
        f"{line.along} / L  [-]",
        line.running[shown] / results.scene.reference_length,
        "IC · E · L  [-]",
        named | {name: values[shown] for name, values in (more or {}).items()},
        unit(results) * known,
    )
