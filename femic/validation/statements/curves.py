"""Curves of statements: components of ICs along lines, their errors, and panels that show them."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from approx.pair import Solid
from compare.ics.compute import Results, ics_of, parts_of, points_of, reference_of
from compare.ics.errors import measure_of
from compare.report.panels import Panel
from compare.report.styles import SYMBOLS
from geometries.arrays import Array
from geometries.patches import OffsetLine, indices

BODIES = ("combined", "lower", "upper")
CONVEX, CONCAVE = "lower", "upper"
ALONE = (CONVEX, CONCAVE)
INDEPENDENT = ("nn", "ss", "xx", "xs", "xn", "sn")  # the other components are reciprocals of these
ACROSS, BESIDE, THROUGH = "x = 1.6 mm", "s = 1.6 mm", "s = 0 mm"  # the lines of the geometries

STEEP = 0.15  # reference lengths from the load: steep curves are drawn from here on


@dataclass(frozen=True)
class Evidence:
    """The numbers of a statement by criterion and case, its panels, and further numbers."""

    values: Mapping[str, Mapping[str, float]]
    panels: tuple[Panel, ...] = ()
    details: Mapping[str, float] = field(default_factory=dict)


def along(results: Results, direction: str) -> list[OffsetLine]:
    """Return the lines of a scene along x or along s."""
    return [line for line in results.scene.lines if line.along == direction]


def line_of(results: Results, name: str) -> OffsetLine:
    """Return the line with a name."""
    return next(line for line in results.scene.lines if line.name == name)


def curve(
    results: Results, variant: str, body: str, component: str, lines: Iterable[OffsetLine] | None = None
) -> Array:
    """Return a component at the points of lines (default: all), (n,), dimensionless."""
    points = points_of(results, results.scene.lines if lines is None else lines)
    return np.asarray(unit(results) * ics_of(results, variant, body)[indices(component)][points])


def difference(
    results: Results, variant: str, body_component: tuple[str, str], lines: Iterable[OffsetLine] | None = None
) -> Array:
    """Return C minus a variant at the points of lines (default: all), (n,), dimensionless."""
    c, approximation = (curve(results, which, *body_component, lines) for which in ("C", variant))
    return np.asarray(c - approximation)


def unit(results: Results) -> float:
    """Return E L [N/mm], the factor that makes ICs [mm/N] dimensionless."""
    return results.scene.reference_E * results.scene.reference_length


def value_at(
    results: Results, variant: str, body_component: tuple[str, str], place: tuple[str, float]
) -> float:
    """Return a component, dimensionless, at a place: a line and the coordinate along it [mm]."""
    (body, component), (name, coordinate) = body_component, place
    line = line_of(results, name)
    return float(np.interp(coordinate, line.running, curve(results, variant, body, component, [line])))


def relative(
    results: Results, variant: str, body_component: tuple[str, str], place: tuple[str, float]
) -> float:
    """Return |v / C - 1| of a component at a place, the relative deviation of a variant v from C."""
    approximation, c = (value_at(results, which, body_component, place) for which in (variant, "C"))
    return abs(approximation / c - 1)


def error(
    results: Results, variant: str, body: str, component: str, lines: Iterable[OffsetLine] | None = None
) -> float:
    """Return the largest error [-] of a component of a variant against C on lines (default: all)."""
    differences = ics_of(results, variant, body) - reference_of(results, body).ic
    return deviation(results, differences, body, component, lines)


def error_ratio(first: str, second: str, component: str, line: str | None = None) -> Callable[..., float]:
    """Measure the error of a component of one variant over another one's, on a line (default: all)."""

    def ratio(results: Results, body: str = "combined") -> float:
        lines = None if line is None else [line_of(results, line)]
        above, below = (error(results, variant, body, component, lines) for variant in (first, second))
        return above / below

    return ratio


def deviation(
    results: Results, differences: Array, body: str, component: str, lines: Iterable[OffsetLine] | None = None
) -> float:
    """Return the largest difference on lines (default: all) as a share of the component; (3, 3, n) [mm/N]."""
    shares = measure_of(results, body).shares(differences)
    return max(
        float(shares[line.name][indices(component)])
        for line in (results.scene.lines if lines is None else lines)
    )


def largest(
    results: Results, variant: str, body_component: tuple[str, str], lines: Iterable[OffsetLine] | None = None
) -> float:
    """Return the largest |v - C| of a variant v on lines (default: all), dimensionless."""
    return float(np.max(np.abs(difference(results, variant, body_component, lines))))


def across_over_along(component: str) -> Callable[[Results, str], float]:
    """Measure the largest |C - A| of a component on the line along s over that on the lines along x."""

    def ratio(results: Results, body: str) -> float:
        across, lengthwise = (largest(results, "A", (body, component), along(results, way)) for way in "sx")
        return across / lengthwise

    return ratio


def on_its_line(results: Results, variant: str, body_component: tuple[str, str], line: OffsetLine) -> float:
    """Return the largest |v - C| of a variant v on a line, as a share of max |C| there."""
    c = curve(results, "C", *body_component, [line])
    return largest(results, variant, body_component, [line]) / float(np.max(np.abs(c)))


def not_revolved(results: Results, variant: str, body: str) -> Array:
    """Return a variant for prismatic surfaces, without curvature along x as in [BVSV]; (3, 3, n) [mm/N]."""
    scene, points = results.scene, (results.points.x, results.points.s)
    solids = [getattr(scene.pair, name) for name in parts_of(body)]
    prismatic = [Solid(solid.material, solid.surface.prismatic) for solid in solids]
    total = np.sum([solid.approximate(variant, scene.patch, points) for solid in prismatic], axis=0)
    return np.asarray(total / scene.patch.area)


def rms(values: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def panel(
    results: Results,
    variants: Iterable[str],
    body_component: tuple[str, str],
    line: OffsetLine,
    more: Mapping[str, Array] | None = None,
) -> Panel:
    """Return a panel of C, variants and further curves of a component, at coordinates >= 0 of a line.

    `more` has the further curves (n,), dimensionless, by name.
    """
    (body, component), shown = body_component, line.running >= 0
    curves = {name: curve(results, name, body, component, [line])[shown] for name in ("C", *variants)}
    named = {SYMBOLS.get(name, name): values for name, values in curves.items()}
    estimate = reference_of(results, body).estimate[indices(component)][points_of(results, [line])][shown]
    return Panel(
        f"{results.scene.name}, {body}: {component} on {line.name}",
        f"{line.along} / L  [-]",
        line.running[shown] / results.scene.reference_length,
        "IC · E · L  [-]",
        named | {name: values[shown] for name, values in (more or {}).items()},
        unit(results) * estimate,
    )
