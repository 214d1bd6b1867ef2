"""Charts of a profile: to scale, and residual, inclination and curvature over the arc length."""

from collections.abc import Iterator

import numpy as np

from compare.profiles.understood import UM, Understood
from compare.report.charts import Chart, Curve, Panel, chart_of
from compare.report.looks import INK, Look
from geometries.arrays import Array
from geometries.profiles.preparation import ProfileFigure

POINTS = Look("#56b4e9", "", "circle")
CURVE = Look(INK, "solid", "", 1.6)
STEEPEST = 85.0  # deg, at which contours end
ALONG = "arc length s from the gauge side [mm]"


def section(understood: Understood) -> Chart:
    """Return the points and the curve to scale."""
    return chart_of("section", [_section(understood)], 1, 1.5)


def over_length(understood: Understood) -> Chart:
    """Return residual, inclination and curvature over the arc length."""
    panels = list(_over_length(understood))
    return chart_of("over_length", panels, len(panels))


def all_panels(understood: Understood) -> Chart:
    """Return all panels: the section to scale, residual, inclination and curvature over the arc length."""
    return chart_of("profile", [_section(understood), *_over_length(understood)], 2)


def _section(understood: Understood) -> Panel:
    figure = understood.figure
    (y, z), (y_points, z_points) = figure.curve, figure.points
    curves = [
        Curve(_points_label(understood), y_points, z_points, POINTS),
        Curve(_curve_label(understood), y, z, CURVE, notes=list(_notes_of_curve(figure))),
    ]
    return Panel("", "y [mm], to the field side", "z [mm], upwards", curves, to_scale=True)


def _over_length(understood: Understood) -> Iterator[Panel]:
    figure, label = understood.figure, _curve_label(understood)
    if understood.is_smoothed:
        residual = Curve("points", figure.places, UM * figure.residual, POINTS)
        yield Panel("Residual", ALONG, "points above the curve [µm]", [residual], levels=(0.0,))
    known = 0 < figure.curvature_noise < np.inf
    band = figure.curvature_noise if known else None
    inclination = Curve(label, figure.s, np.degrees(figure.inclination), CURVE)
    curvature = Curve(label, figure.s, figure.curvature, CURVE, band)
    yield Panel("Inclination", ALONG, "inclination [deg]", [inclination], levels=(-STEEPEST, STEEPEST))
    yield Panel("Curvature", ALONG, "curvature [1/mm]", [curvature], levels=(0.0,))


def _points_label(understood: Understood) -> str:
    return "ends of pieces" if understood.is_exact else "points"


def _curve_label(understood: Understood) -> str:
    if understood.is_exact:
        return "exact curve"
    return "smoothed curve" if understood.is_smoothed else "curve through the points"


def _notes_of_curve(figure: ProfileFigure) -> Iterator[str]:
    """Yield what hovering over the curve says."""
    rows: Array = np.stack([*figure.curve, figure.s, np.degrees(figure.inclination), figure.curvature])
    for y, z, s, inclination, curvature in rows.T:
        radius = f"radius {1 / curvature:.4g} mm" if abs(curvature) > 1e-6 else "straight"
        yield f"y {y:.3f}, z {z:.3f} mm\ns {s:.2f} mm\n{inclination:.2f}°, {radius}"
