"""Curves of statements: components of ICs along lines, their errors, and panels that show them.

Numbers of such curves are measured on both geometries of the source, and drawn side by side.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from approx.pair import Solid
from compare.report.charts import Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.frame import Measure
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.results.ics import Results, ics_measure, line_points, reference_ics, select_ics, solved_parts
from geometries.arrays import Array
from geometries.patches import OffsetLine, indices

BODIES = ("combined", "lower", "upper")
CONVEX, CONCAVE = "lower", "upper"
ALONE = (CONVEX, CONCAVE)
INDEPENDENT = ("nn", "ss", "xx", "xs", "xn", "sn")  # the other components are reciprocals of these
ACROSS, BESIDE, THROUGH = "x = 1.6 mm", "s = 1.6 mm", "s = 0 mm"  # the lines of the geometries

STEEP = 0.15  # reference lengths from the load: steep curves are drawn from here on
INVISIBLE = 1e-9  # dimensionless IC below which a curve is rounding


@dataclass(frozen=True)
class Curve:
    """A component of a body's ICs, dimensionless, at the points of lines of a scene.

    `on` is the name of a line, or the direction "x" or "s" of several ones; None stands for all lines.
    Variants are compared with C.
    """

    results: Results
    body: str
    component: str
    on: str | None = None

    @property
    def lines(self) -> list[OffsetLine]:
        """The lines of the curve."""
        return [line for line in self.results.scene.lines if self.on in (None, line.name, line.along)]

    def values(self, ics: Array) -> Array:
        """Return the component of ICs (3, 3, n_points) [mm/N] on the lines, (n,)."""
        on_lines = ics[indices(self.component)][line_points(self.results, self.lines)]
        return np.asarray(unit(self.results) * on_lines)

    def variant(self, name: str) -> Array:
        """Return the component of a variant, or of C, (n,)."""
        return self.values(select_ics(self.results, name, self.body))

    def difference(self, variant: str) -> Array:
        """Return C minus a variant, (n,)."""
        return np.asarray(self.variant("C") - self.variant(variant))

    def size(self, variant: str) -> float:
        """Return the largest |v| of a variant v, or of C."""
        return float(np.max(np.abs(self.variant(variant))))

    def largest(self, variant: str) -> float:
        """Return the largest |v - C| of a variant v."""
        return float(np.max(np.abs(self.difference(variant))))

    def share(self, variant: str) -> float:
        """Return the largest |v - C| of a variant v as a share of max |C| on the same lines."""
        return self.largest(variant) / self.size("C")

    def at(self, variant: str, coordinate: float) -> float:
        """Return the component of a variant, or of C, at a coordinate [mm] along the only line."""
        (line,) = self.lines
        return float(np.interp(coordinate, line.running, self.variant(variant)))

    def relative(self, variant: str, coordinate: float) -> float:
        """Return |v / C - 1| at a coordinate [mm] along the only line."""
        return abs(self.at(variant, coordinate) / self.at("C", coordinate) - 1)

    def error(self, ics: str | Array) -> float:
        """Return the largest error [-] of a variant, or of ICs (3, 3, n_points) [mm/N]."""
        approximation = select_ics(self.results, ics, self.body) if isinstance(ics, str) else ics
        deviations = approximation - reference_ics(self.results, self.body).ic
        shares = ics_measure(self.results, self.body).shares(deviations)
        return max(float(shares[line.name][indices(self.component)]) for line in self.lines)

    def panel(self, *variants: str, more: Mapping[str, Array] | None = None, beyond: float = 0.0) -> Panel:
        """Return a panel of C, variants and further curves from a coordinate [reference lengths] on.

        `more` has the further curves (n,), dimensionless, by label.
        """
        (line,) = self.lines
        at = line.running / self.results.scene.reference_length
        shown = at >= beyond
        curves = {ics_symbol(name): self.variant(name) for name in ("C", *variants)} | dict(more or {})
        estimate = self.values(reference_ics(self.results, self.body).estimate)
        return Panel(
            f"{self.results.scene.name}, {self.body}: {self.component} on {line.name}",
            f"{line.along} / L  [-]",
            "IC · E · L  [-]",
            make_curves(
                at[shown], {label: values[shown] for label, values in curves.items()}, estimate[shown]
            ),
            least=INVISIBLE,
        )


def find_line(results: Results, name: str) -> OffsetLine:
    """Return the line with a name."""
    return next(line for line in results.scene.lines if line.name == name)


def unit(results: Results) -> float:
    """Return E L [N/mm], the factor that makes ICs [mm/N] dimensionless."""
    return results.scene.reference_E * results.scene.reference_length


def rms(values: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def prismatic_ics(results: Results, variant: str, body: str) -> Array:
    """Return a variant for prismatic surfaces, without curvature along x as in [BVSV]; (3, 3, n) [mm/N]."""
    scene, points = results.scene, (results.points.x, results.points.s)
    solids = [getattr(scene.pair, name) for name in solved_parts(body)]
    prismatic = [Solid(solid.material, solid.surface.prismatic) for solid in solids]
    total = np.sum([solid.approximate(variant, scene.patch, points) for solid in prismatic], axis=0)
    return np.asarray(total / scene.patch.area)


# --- numbers of criteria, on both geometries ------------------------------------------------------------


def per_geometry(number: Callable[..., float], *choices: Sequence[str], fitted: bool = False) -> Measure:
    """Measure a number of each geometry for each combination of `choices`: bodies, lines or components.

    With `fitted` the results include B-hat-prime.
    """
    return lambda runs: {
        ", ".join((name, *choice)): number(runs.fitted(name) if fitted else runs.geometry(name), *choice)
        for name, *choice in product(GEOMETRIES, *choices)
    }


def per_body(number: Callable[[Results, str], float], *, fitted: bool = False) -> Measure:
    """Measure a number of each geometry and body, of both together as well."""
    return per_geometry(number, BODIES, fitted=fitted)


def second_minus_first(number: Callable[[Results], float]) -> Measure:
    """Measure a number of Geometry 2 minus the same of Geometry 1."""
    first, second = GEOMETRIES
    return lambda runs: {"both": number(runs.geometry(second)) - number(runs.geometry(first))}


def error_ratio(first: str, second: str, component: str, on: str | None = None) -> Callable[..., float]:
    """Measure the error of a component of one variant over another one's, on a line (default: all)."""

    def ratio(results: Results, body: str = "combined") -> float:
        curve = Curve(results, body, component, on)
        return curve.error(first) / curve.error(second)

    return ratio


def across_over_along(component: str) -> Callable[[Results, str], float]:
    """Measure the largest |C - A| of a component on the line along s over that on the lines along x."""

    def ratio(results: Results, body: str) -> float:
        across, lengthwise = (Curve(results, body, component, direction).largest("A") for direction in "sx")
        return across / lengthwise

    return ratio


# --- panels ---------------------------------------------------------------------------------------------


def side_by_side(
    draw: Callable[[Results], Iterable[Panel]], *, fitted: bool = False
) -> Callable[[Runs], list[Panel]]:
    """Draw panels of both geometries, side by side."""

    def panels(runs: Runs) -> list[Panel]:
        columns = [draw(runs.fitted(name) if fitted else runs.geometry(name)) for name in GEOMETRIES]
        return [panel for row in zip(*columns, strict=True) for panel in row]

    return panels


def curve_panels(
    places: Iterable[tuple[str, str, str]], *variants: str, beyond: float = 0.0, fitted: bool = False
) -> Callable[[Runs], list[Panel]]:
    """Draw C and variants of both geometries, by places: body, component, line."""
    rows = tuple(places)
    return side_by_side(
        lambda results: [Curve(results, *row).panel(*variants, beyond=beyond) for row in rows], fitted=fitted
    )
