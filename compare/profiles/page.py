"""The page of `femic profiles`: how a profile was understood."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from compare.profiles.figures import over_length, section
from compare.profiles.understood import UM, Understood, to_dataset
from compare.report.parts import Folded, Items, Note, Page, Section, write_results
from compare.report.tables import Cell, Row, Table, numbers
from geometries.arrays import Array
from geometries.profiles.noise import noise, radius_text
from geometries.profiles.preparation import ProfileFigure

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
    axes = "; ".join(_without_stop(note) for note in figure.notes if note.startswith((UNIT, Y, Z)))
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
                Row(f"least radius, {name} [mm]", [radius_text(figure, tightest), *_at(figure, tightest)])
            )
    steepest = int(np.argmax(np.abs(figure.inclination)))
    rows.append(
        Row("steepest [deg]", [f"{np.degrees(figure.inclination[steepest]):.2f}", *_at(figure, steepest)])
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


def _without_stop(note: str) -> str:
    return note.removesuffix(".")


def _at(figure: ProfileFigure, k: int) -> list[str | Cell]:
    return _place(figure.s[k], figure.curve[:, k])


def _place(s: float, point: Array) -> list[str | Cell]:
    return [f"{s:.1f} mm", f"{point[0]:.1f}, {point[1]:.1f} mm"]
