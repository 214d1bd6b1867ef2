"""Curves that statements are about: components of ICs along lines, their errors, and panels to look at."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from approx.pair import Solid
from approx.target import indices
from compare.pages.panels import Panel
from compare.pages.styles import SYMBOLS
from compare.results.compute import Results, ics_of, parts_of, reference_of, shares_of
from geometries.arrays import Array, Indices
from geometries.patches import OffsetLine

BODIES = ("combined", "lower", "upper")
CONVEX, CONCAVE = "lower", "upper"
ALONE = (CONVEX, CONCAVE)
SHOWN = ("nn", "ss", "xx", "xs", "xn", "sn")  # the others are their reciprocals
ACROSS, BESIDE, THROUGH = "x = 1.6 mm", "s = 1.6 mm", "s = 0 mm"  # the lines of the geometries

STEEP = 0.15  # reference lengths away: from here on curves are drawn that are steep beside the load


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


def line_of(results: Results, name: str) -> OffsetLine:
    """The line of a name."""
    return next(line for line in results.scene.lines if line.name == name)


def points_of(results: Results, lines: Iterable[OffsetLine]) -> Indices:
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


def value_at(results: Results, variant: str, of: tuple[str, str], place: tuple[str, float]) -> float:
    """A body's component, dimensionless, at a place: a line and the coordinate [mm] that varies on it."""
    (body, component), (name, at) = of, place
    line = line_of(results, name)
    return float(np.interp(at, line.running, curve(results, variant, body, component, [line])))


def relative(results: Results, variant: str, of: tuple[str, str], place: tuple[str, float]) -> float:
    """|v / C - 1| of a body's component at a place: what a variant misses of C there."""
    v, c = (value_at(results, which, of, place) for which in (variant, "C"))
    return abs(v / c - 1)


def error(
    results: Results, variant: str, body: str, component: str, lines: Iterable[OffsetLine] | None = None
) -> float:
    """Largest error of a component of a variant over lines (default: all), against C."""
    off = ics_of(results, variant, body) - reference_of(results, body).ic
    return deviation(results, off, body, component, lines)


def deviation(
    results: Results, off: Array, body: str, component: str, lines: Iterable[OffsetLine] | None = None
) -> float:
    """Largest share of the component itself that a deviation (3, 3, n) has on lines (default: on all)."""
    shares = shares_of(results, body, off)
    return max(
        float(shares[line.name][indices(component)])
        for line in (results.scene.lines if lines is None else lines)
    )


def largest(
    results: Results, variant: str, of: tuple[str, str], lines: Iterable[OffsetLine] | None = None
) -> float:
    """Largest |v - C| of a body's component over lines (default: all), dimensionless."""
    v, c = (curve(results, which, *of, lines) for which in (variant, "C"))
    return float(np.max(np.abs(v - c)))


def on_its_line(results: Results, variant: str, of: tuple[str, str], line: OffsetLine) -> float:
    """Largest |v - C| of a body's component on a line as a share of max |C| there."""
    c = curve(results, "C", *of, [line])
    return largest(results, variant, of, [line]) / float(np.max(np.abs(c)))


def not_revolved(results: Results, variant: str, body: str) -> Array:
    """A variant without curvature along x [mm/N], (3, 3, n): that of the prismatic surfaces, as in [BVSV]."""
    scene, points = results.scene, (results.points.x, results.points.s)
    solids = [getattr(scene.pair, name) for name in parts_of(body)]
    prismatic = [Solid(solid.material, solid.surface.prismatic) for solid in solids]
    total = np.sum([solid.approximate(variant, scene.patch, points) for solid in prismatic], axis=0)
    return np.asarray(total / scene.patch.area)


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
