"""The page of `femic profiles`: how a profile was understood.

Its charts show the profile to scale, and residual, inclination and curvature over the arc length. No page is
written over that of another file.
"""

from collections.abc import Iterator, Sequence
from itertools import chain, count
from pathlib import Path

import numpy as np
import xarray as xr

from compare.report.charts import Chart, Curve, Panel, simple_chart
from compare.report.looks import INK, Look
from compare.report.parts import Folded, Items, Note, Page, Section, write_results
from compare.report.tables import Cell, Row, Table, numbers
from femic.results.profiles import UM, Understood, to_dataset
from geometries.arrays import Array
from geometries.profiles.noise import noise, radius_text

# --- the page -------------------------------------------------------------------------------------------


SAID = (  # beginnings of the notes in the summary
    "1 unit of the file is",
    "In the file y",
    "In the file z",
    "Smoothed by",
    "A cubic spline through",
)
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
    title = f"{understood.kind.capitalize()} {understood.figure.name}: how it was understood"
    page = Page(title, summary(understood), _sections(understood), answer_table(understood))
    return write_results(page, folder, "profile", to_dataset(understood))


def summary(understood: Understood) -> str:
    """Return what it is and its length, then notes on unit, axes and smoothing, or on the standard."""
    notes = understood.figure.notes
    said = notes[:1] if understood.is_exact else [note for note in notes if note.startswith(SAID)]
    return (
        f"{understood.kind.capitalize()}, {understood.source}: a curve {understood.length:.1f} mm long from "
        f"the gauge side to the field side. {' '.join(said)}"
    )


def doubts(understood: Understood) -> list[str]:
    """Return what looks like noise; a standard has none."""
    doubt = "" if understood.is_exact else noise(understood.figure)
    return [doubt] if doubt else []


def answer_table(understood: Understood) -> Table:
    """Return points, length, residual, least radii and the steepest place."""
    figure = understood.figure

    def place(k: int) -> list[str | Cell]:
        return [f"{figure.s[k]:.1f} mm", "{:.1f}, {:.1f} mm".format(*figure.curve[:, k])]

    points = [] if understood.is_exact else [Row("points", [f"{len(figure.places)}", "", ""])]
    rows = [*points, Row("length [mm]", [f"{understood.length:.2f}", "", ""])]
    if understood.is_smoothed:
        rms, k = np.sqrt(np.mean(figure.residual**2)), int(np.argmax(np.abs(figure.residual)))
        at = [f"{figure.places[k]:.1f} mm", "{:.1f}, {:.1f} mm".format(*figure.points[:, k])]
        rows.append(Row("residual, rms [µm]", [f"{UM * rms:.2g}", "", ""]))
        rows.append(Row("residual, largest [µm]", [f"{UM * abs(figure.residual[k]):.2g}", *at]))
    outwards = 1 if understood.kind == "rail" else -1  # sign of the curvature of a convex body
    for name, sign in (("convex", outwards), ("hollow", -outwards)):
        k = int(np.argmax(sign * figure.curvature))
        if sign * figure.curvature[k] > 0:
            rows.append(Row(f"least radius, {name} [mm]", [radius_text(figure, k), *place(k)]))
    k = int(np.argmax(np.abs(figure.inclination)))
    rows.append(Row("steepest [deg]", [f"{np.degrees(figure.inclination[k]):.2f}", *place(k)]))
    return Table("", numbers("value", "at s", "at y, z"), rows)


def _sections(understood: Understood) -> Iterator[Section | Folded]:
    figure = understood.figure
    if doubtful := doubts(understood):
        yield Section("", [Items(doubtful)])
    notes = [note for note in figure.notes if not note.startswith(SAID)]
    if notes and not understood.is_exact:
        yield Section("", [Items(notes)])
    band = [Note(NOISE)] if 0 < figure.curvature_noise < np.inf else []
    yield Section("", [section(understood), over_length(understood), Note(READING), *band])
    if not understood.is_exact:
        yield Folded("All that was done with the points, in this order", [Items(figure.notes)])


# --- charts ---------------------------------------------------------------------------------------------


POINTS = Look("#56b4e9", "", "circle")
CURVE = Look(INK, "solid", "", 1.6)
STEEPEST = 85.0  # deg, at which contours end
ALONG = "arc length s from the gauge side [mm]"


def section(understood: Understood) -> Chart:
    """Return the points and the curve to scale."""
    return simple_chart("section", _panels(understood)[:1], 1, 1.5)


def over_length(understood: Understood) -> Chart:
    """Return residual, inclination and curvature over the arc length."""
    panels = _panels(understood)[1:]
    return simple_chart("over_length", panels, len(panels))


def all_panels(understood: Understood) -> Chart:
    """Return all panels: the section to scale, residual, inclination and curvature over the arc length."""
    return simple_chart("profile", _panels(understood), 2)


def _panels(understood: Understood) -> list[Panel]:
    figure = understood.figure
    label = "smoothed curve" if understood.is_smoothed else "curve through the points"
    label = "exact curve" if understood.is_exact else label
    points_label = "ends of pieces" if understood.is_exact else "points"
    notes = []  # what hovering over the curve says
    rows: Array = np.stack([*figure.curve, figure.s, figure.inclination, figure.curvature])
    for y, z, s, slope, bend in rows.T:
        radius = f"radius {1 / bend:.4g} mm" if abs(bend) > 1e-6 else "straight"
        notes.append(f"y {y:.3f}, z {z:.3f} mm\ns {s:.2f} mm\n{np.degrees(slope):.2f}°, {radius}")
    (y_curve, z_curve), (y_points, z_points) = figure.curve, figure.points
    curves = [
        Curve(points_label, y_points, z_points, POINTS),
        Curve(label, y_curve, z_curve, CURVE, notes=notes),
    ]
    residual = Curve("points", figure.places, UM * figure.residual, POINTS)
    inclination = Curve(label, figure.s, np.degrees(figure.inclination), CURVE)
    band = figure.curvature_noise if 0 < figure.curvature_noise < np.inf else None
    curvature = Curve(label, figure.s, figure.curvature, CURVE, band)
    panels = [
        Panel("", "y [mm], to the field side", "z [mm], upwards", curves, to_scale=True),
        Panel("Residual", ALONG, "points above the curve [µm]", [residual], levels=(0.0,)),
        Panel("Inclination", ALONG, "inclination [deg]", [inclination], levels=(-STEEPEST, STEEPEST)),
        Panel("Curvature", ALONG, "curvature [1/mm]", [curvature], levels=(0.0,)),
    ]
    return panels if understood.is_smoothed else [panels[0], *panels[2:]]


# --- folders --------------------------------------------------------------------------------------------


def page_folders(profiles: Sequence[Understood], out: Path) -> list[Path]:
    """Return a folder in `out` for each profile: the first of its names that has no page of another file.

    Names are that of the file, with its ending, with its folders one after the other, and numbered.
    """
    result: list[Path] = []
    for one in profiles:
        path = Path(one.file)
        names = [one.figure.name, f"{one.figure.name}-{path.suffix.removeprefix('.') or 'profile'}"]
        for parent in path.parents[:-1]:
            names.append(f"{parent.name}-{names[-1]}")
        numbered = map(f"{names[-1]}-{{}}".format, count(2))
        for folder in (out / name for name in chain(names, numbered)):
            if folder not in result and _is_free(folder / "profile.nc", one):
                result.append(folder)
                break
    return result


def _is_free(page: Path, profile: Understood) -> bool:
    """Whether there is no dataset of a page, or one of this profile."""
    if not page.is_file():
        return True
    try:
        with xr.open_dataset(page, engine="h5netcdf") as dataset:
            return bool(dataset.attrs.get("file") == profile.file)
    except OSError:  # no dataset: left by an interrupted run
        return True
