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
from compare.report.tables import Cell, Row, Table, number_text, numbers
from femic.results.profiles import UM
from geometries.profiles.noise import LEAST_RADIUS
from geometries.profiles.noise import SAID as TREAD_LIMIT

# --- the page -------------------------------------------------------------------------------------------


UNDERSTOOD = "1 unit of the file is", "In the file y", "In the file z"  # beginnings of notes in the summary
USUAL = (  # and of those that are nothing to check
    *UNDERSTOOD,
    "The file says",
    "The order of the points was reversed",
    "Smoothed by",
    "A cubic spline through",
    "Section ",
)
FITNESS = (
    "femic calls a profile fit for contact if the last decimals of its file change p_max on a tread by less "
    f"than {100 * TREAD_LIMIT:.0f} %, and if no radius is below {LEAST_RADIUS:g} mm. It does not know the "
    "errors of the measurement."
)
READING = (
    "For rails and wheels, y points to the field side and z up; the arc length s starts at the gauge "
    "side. The inclination is positive where the surface falls with increasing y. The curvature is "
    "positive where the surface bends down, on the head of a rail and in the flange root of a wheel. In "
    "scenes, contours end where they are steeper than 85 degrees (dotted)."
)
NOISE = (
    "The band of the curvature is the rms error that follows from the residual, if the residual is "
    "independent noise at each point. It does not include real shape that the smoothing removes."
)
OUTLYING = 4.5  # times the rms residual: of 1000 independent errors, fewer than 1 in 100 times one is larger


def write_profile_page(profile: xr.Dataset, folder: Path) -> Path:
    """Write `profile.nc` and `profile.html`; returns the path of the page."""
    title = f"{profile.kind.capitalize()} {profile.attrs['name']} as femic reads it"
    page = Page(title, summary(profile), _sections(profile), answer_table(profile), doubts(profile))
    return write_results(page, folder, "profile", profile)


def summary(profile: xr.Dataset) -> str:
    """Return whether it is fit for contact, what smoothing changed, and how unit and axes were read."""
    notes = profile.notes.splitlines()
    if profile.doubt:
        fit = "It looks noisy and is not fit for contact as it is."
    elif lost_shape(profile):
        fit = "It shows no noise, but smoothing may have removed some of its shape."
    else:
        fit = "It shows no noise and is fit for contact."
    changed = "Its points were not changed."
    if profile.smoothed:
        residual = abs(profile.residual.values)
        rms = float(np.sqrt(np.mean(residual**2)))
        changed = f"Smoothing moved its points by up to {np.max(residual):.2g} mm, {rms:.2g} mm rms."
    said = [*notes[:1]] if profile.exact else [changed, *(n for n in notes if n.startswith(UNDERSTOOD))]
    name = f"{profile.kind.capitalize()} {profile.source.removeprefix(f'{profile.kind} ')}"
    length = f"a curve {float(profile.s[-1]):.1f} mm long from the gauge side to the field side"
    return f"{name}: {length}. {' '.join([fit, *said])}"


def doubts(profile: xr.Dataset) -> list[str]:
    """Return what looks like noise, lost shape, and what is unusual in the file."""
    unusual = [note for note in profile.notes.splitlines() if not note.startswith(USUAL)]
    return [profile.doubt, lost_shape(profile), *([] if profile.exact else unusual)]


def lost_shape(profile: xr.Dataset) -> str:
    """Return where smoothing moves a point much further than noise would; empty if nowhere."""
    residual = abs(profile.residual.values)
    rms, k = float(np.sqrt(np.mean(residual**2))), int(np.argmax(residual))
    if not profile.smoothed or residual[k] <= OUTLYING * rms:
        return ""
    return (
        f"At s = {float(profile.point_s[k]):.1f} mm smoothing moves the points by {residual[k]:.2g} mm, "
        f"{residual[k] / rms:.1f} times the rms: the shape may be sharper there. Compare with a smaller "
        "tolerance."
    )


def answer_table(profile: xr.Dataset) -> Table:
    """Return the largest change by smoothing, the least radii and the steepest place."""

    def place(names: str, k: int) -> list[str | Cell]:
        s, y, z = (number_text(profile[name][k], ".1f") for name in names.split())
        return [f"{s} mm", f"{y}, {z} mm"]

    rows = []
    if profile.smoothed:
        residual = abs(profile.residual.values)
        k = int(np.argmax(residual))
        rows.append(
            Row("moved by smoothing [mm]", [f"{residual[k]:.2g}", *place("point_s point_y point_z", k)])
        )
    curvature, inclination = profile.curvature.values, profile.inclination.values
    outwards = 1 if profile.kind == "rail" else -1  # sign of the curvature of a convex body
    for name, sign in (("convex", outwards), ("hollow", -outwards)):
        k = int(np.argmax(sign * curvature))
        if sign * curvature[k] > 0:
            radius = f"{1 / abs(curvature[k]):.3g}"
            rows.append(Row(f"least radius, {name} [mm]", [radius, *place("s y z", k)]))
    k = int(np.argmax(np.abs(inclination)))
    steepest = number_text(float(np.degrees(inclination[k])), ".2f")
    rows.append(Row("steepest [deg]", [steepest, *place("s y z", k)]))
    return Table("", numbers("value", "at s", "at y, z"), rows)


def _sections(profile: xr.Dataset) -> Iterator[Section | Folded]:
    band = [Note(NOISE)] if 0 < profile.curvature_noise < np.inf else []
    fitness = [] if profile.exact else [Note(FITNESS)]
    yield Section("", [section(profile), over_length(profile), *fitness, Note(READING), *band])
    if not profile.exact:
        heading = f"How the {profile.sizes['point']} points became the curve, in this order"
        yield Folded(heading, [Items(profile.notes.splitlines())])


# --- charts ---------------------------------------------------------------------------------------------


POINTS = Look("#56b4e9", "", "circle")
CURVE = Look(INK, "solid", "", 1.6)
STEEPEST = 85.0  # deg, at which contours end
ALONG = "arc length s from the gauge side [mm]"


def section(profile: xr.Dataset) -> Chart:
    """Return the points and the curve to scale."""
    return simple_chart("section", _panels(profile)[:1], 1, 1.5)


def over_length(profile: xr.Dataset) -> Chart:
    """Return residual, inclination and curvature over the arc length."""
    panels = _panels(profile)[1:]
    return simple_chart("over_length", panels, len(panels))


def all_panels(profile: xr.Dataset) -> Chart:
    """Return all panels: the section to scale, residual, inclination and curvature over the arc length."""
    return simple_chart("profile", _panels(profile), 2)


def _panels(profile: xr.Dataset) -> list[Panel]:
    label, points_label = "exact curve", "ends of pieces"
    if not profile.exact:
        label = "smoothed curve" if profile.smoothed else "curve through the points"
        points_label = "points"
    y, z, s, slope, bend = (profile[name].values for name in ("y", "z", "s", "inclination", "curvature"))
    notes = []  # what hovering over the curve says
    for at_y, at_z, at, angle, curvature in zip(y, z, s, np.degrees(slope), bend, strict=True):
        radius = f"radius {1 / curvature:.4g} mm" if abs(curvature) > 1e-6 else "straight"
        notes.append(f"y {at_y:.3f}, z {at_z:.3f} mm\ns {at:.2f} mm\n{angle:.2f}°, {radius}")
    curves = [
        Curve(points_label, profile.point_y, profile.point_z, POINTS),
        Curve(label, y, z, CURVE, notes=notes),
    ]
    residual = Curve("points", profile.point_s, UM * profile.residual, POINTS)
    band = profile.curvature_noise if 0 < profile.curvature_noise < np.inf else None
    panels = [
        Panel("", "y [mm], to the field side", "z [mm], upwards", curves, to_scale=True),
        Panel("Residual", ALONG, "points minus curve [µm]", [residual], levels=(0.0,)),
        Panel(
            "Inclination",
            ALONG,
            "inclination [deg]",
            [Curve(label, s, np.degrees(slope), CURVE)],
            levels=(-STEEPEST, STEEPEST),
        ),
        Panel("Curvature", ALONG, "curvature [1/mm]", [Curve(label, s, bend, CURVE, band)], levels=(0.0,)),
    ]
    return panels if profile.smoothed else [panels[0], *panels[2:]]


# --- folders --------------------------------------------------------------------------------------------


def page_folders(profiles: Sequence[xr.Dataset], out: Path) -> list[Path]:
    """Return a folder in `out` for each profile: the first of its names that has no page of another file.

    Names are that of the file, with its ending, with its folders one after the other, and numbered.
    """
    result: list[Path] = []
    for profile in profiles:
        name, path = profile.attrs["name"], Path(profile.file)
        names = [name, f"{name}-{path.suffix.removeprefix('.') or 'profile'}"]
        for parent in path.parents[:-1]:
            names.append(f"{parent.name}-{names[-1]}")
        numbered = map(f"{names[-1]}-{{}}".format, count(2))
        for folder in (out / name for name in chain(names, numbered)):
            if folder not in result and _is_free(folder / "profile.nc", profile.file):
                result.append(folder)
                break
    return result


def _is_free(page: Path, file: str) -> bool:
    """Whether there is no dataset of a page, or one of the profile of a file."""
    if not page.is_file():
        return True
    try:
        with xr.open_dataset(page, engine="h5netcdf") as dataset:
            return bool(dataset.attrs.get("file") == file)
    except OSError:  # no dataset: left by an interrupted run
        return True
