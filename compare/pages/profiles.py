"""The page of `femic profiles`: how a profile was understood.

Its charts show the profile to scale, and residual, inclination and curvature over the arc length. No page is
written over that of another file.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.charts import Chart, Curve, Panel, chart_of
from compare.report.looks import INK, Look
from compare.report.parts import Folded, Items, Note, Page, Section, write_results
from compare.report.tables import Cell, Row, Table, numbers
from femic.results.profiles import UM, Understood, to_dataset
from geometries.arrays import Array
from geometries.profiles.noise import ProfileFigure, noise, radius_text

# --- the page -------------------------------------------------------------------------------------------


UNIT, Y, Z = "1 unit of the file is", "In the file y", "In the file z"  # beginnings of notes
SMOOTHED, THROUGH = "Smoothed by", "A cubic spline through"
READING = (
    "y grows to the field side and z upwards, for rails and wheels; the arc length s begins at the gauge "
    "side. Inclinations are positive where the surface falls as y grows, curvatures where it bends down: on "
    "the head of a rail and in the flange root of a wheel. Contours of scenes end where they are steeper "
    "than 85 degrees (dotted)."
)
NOISE = (
    "The band of the curvature is the rms error that the residual leaves in it, if it is noise and "
    "neighbouring points err independently; what the smoothing takes away from real shape is not in it."
)


def write_profile_page(understood: Understood, folder: Path) -> Path:
    """Write `profile.nc` and `profile.html`; returns the path of the page."""
    figure = understood.figure
    title = f"{understood.kind.capitalize()} {figure.name}: how it was understood"
    page = Page(title, summary(understood), _sections(understood), answer_table(understood))
    return write_results(page, folder, "profile", to_dataset(understood))


def summary(understood: Understood) -> str:
    """Return what it is, its unit and axes, and the smoothing with its residual, in three sentences."""
    figure = understood.figure
    what = f"{understood.source}: a curve {understood.length:.1f} mm long"
    if understood.is_exact:
        return f"Standard {what} from the gauge side to the field side. {figure.notes[0]}"
    axes = "; ".join(note.removesuffix(".") for note in figure.notes if note.startswith((UNIT, Y, Z)))
    return (
        f"A {understood.kind}, {what} from the gauge side to the field side. "
        f"{axes.replace(f'; {Y}', '; y').replace(f'; {Z}', ', z')}. {_smoothing(figure)}"
    )


def doubts(understood: Understood) -> list[str]:
    """Return what looks like noise; a standard has none."""
    doubt = "" if understood.is_exact else noise(understood.figure)
    return [doubt] if doubt else []


def answer_table(understood: Understood) -> Table:
    """Return points, length, residual, least radii and the steepest place."""
    figure = understood.figure
    count = [] if understood.is_exact else [Row("points", [f"{len(figure.places)}", "", ""])]
    rows = [*count, Row("length [mm]", [f"{understood.length:.2f}", "", ""])]
    if understood.is_smoothed:
        worst = int(np.argmax(np.abs(figure.residual)))
        rms = np.sqrt(np.mean(figure.residual**2))
        rows += [
            Row("residual, rms [µm]", [f"{UM * rms:.2g}", "", ""]),
            Row(
                "residual, largest [µm]",
                [
                    f"{UM * abs(figure.residual[worst]):.2g}",
                    *_place(figure.places[worst], figure.points[:, worst]),
                ],
            ),
        ]
    outwards = 1 if understood.kind == "rail" else -1  # sign of the curvature of a convex body
    for name, sign in (("convex", outwards), ("hollow", -outwards)):
        tightest = int(np.argmax(sign * figure.curvature))
        if sign * figure.curvature[tightest] > 0:
            rows.append(
                Row(
                    f"least radius, {name} [mm]",
                    [radius_text(figure, tightest), *_place_at(figure, tightest)],
                )
            )
    steepest = int(np.argmax(np.abs(figure.inclination)))
    rows.append(
        Row(
            "steepest [deg]",
            [f"{np.degrees(figure.inclination[steepest]):.2f}", *_place_at(figure, steepest)],
        )
    )
    return Table("", numbers("value", "at s", "at y, z"), rows)


def _sections(understood: Understood) -> Iterator[Section | Folded]:
    doubtful = doubts(understood)
    if doubtful:
        yield Section("", [Items(doubtful)])
    notes = [note for note in understood.figure.notes if not note.startswith((UNIT, Y, Z, SMOOTHED, THROUGH))]
    if notes and not understood.is_exact:
        yield Section("", [Items(notes)])
    known = 0 < understood.figure.curvature_noise < np.inf
    yield Section("", [section(understood), over_length(understood), Note(READING)])
    if known:
        yield Section("", [Note(NOISE)])
    if not understood.is_exact:
        yield Folded("All that was done with the points, in this order", [Items(understood.figure.notes)])


def _smoothing(figure: ProfileFigure) -> str:
    """Return the sentence about the smoothing."""
    return next(note for note in figure.notes if note.startswith((SMOOTHED, THROUGH)))


def _place_at(figure: ProfileFigure, k: int) -> list[str | Cell]:
    return _place(figure.s[k], figure.curve[:, k])


def _place(s: float, point: Array) -> list[str | Cell]:
    return [f"{s:.1f} mm", f"{point[0]:.1f}, {point[1]:.1f} mm"]


# --- charts ---------------------------------------------------------------------------------------------


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


# --- folders --------------------------------------------------------------------------------------------


DATASET = "profile.nc"


def folders_of(profiles: Sequence[Understood], out: Path) -> list[Path]:
    """Return a folder in `out` for each profile: the first of its names that has no page of another file."""
    result: list[Path] = []
    for one in profiles:
        free = (
            folder for name in names_of(one) if _is_free(folder := out / name, one) and folder not in result
        )
        result.append(next(free))
    return result


def names_of(profile: Understood) -> Iterator[str]:
    """Yield names of a folder: that of the file, with its ending, with its folders, and numbered."""
    name, path = profile.figure.name, Path(profile.file)
    yield name
    name = f"{name}-{path.suffix.removeprefix('.') or 'profile'}"
    yield name
    for parent in path.parents[:-1]:
        name = f"{parent.name}-{name}"
        yield name
    number = 1
    while True:
        number += 1
        yield f"{name}-{number}"


def _is_free(folder: Path, profile: Understood) -> bool:
    """Whether a folder has no page, or one of this profile."""
    path = folder / DATASET
    if not path.is_file():
        return True
    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            return bool(dataset.attrs.get("file") == profile.file)
    except OSError:  # no dataset: left by an interrupted run
        return True
