"""The axes of the points of a file, and its running surfaces.

To which side y grows and where z points: as it was said, by the format, or from the shape. A running surface
shows where z points: a rail's head is level and wide, its faces hang down from it; a wheel's flange is round
and sticks out of the level tread, at the gauge side. To which side of a rail y grows does not show.

A file may have more than one running surface: a rail beside its guard rail, a grooved rail. Two surfaces are
separated by a groove, or by a wide gap between points.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from geometries.arrays import Array, Indices
from geometries.errors import WrongInput
from geometries.profiles.profile import Content, Height, Kind, Side
from geometries.profiles.text import Rows, Source

# --- running surfaces ---

GROOVE = 20.0  # depth [mm] from which on a groove separates surfaces, below the lower of both
OPENING = 25.0  # step in y [mm] without points that separates surfaces
MOST = 6  # number of surfaces that are described
DEEPEST = 80.0  # [mm] of grooves beside rails; a head is higher above its foot
FACE_DEPTH = 5.0  # [mm] of a head below its top that are not its faces
UNDERCUT = 5.0  # [mm] of the faces of a groove, at most; a head reaches farther beyond its web
HEAD = 10.0  # least width [mm] on both sides of such a step, and of a running surface


def one_surface(source: Source, rows: Rows, up: float, surface: int | None) -> tuple[Rows, list[str]]:
    """The surface with number `surface`, in the order of the file; a note if there are several.

    `up` is 1 where z of the rows points up, -1 where it points down.
    """
    parts = surfaces(np.stack([rows.points[0], up * rows.points[1]]))
    if surface is None and len(parts) == 1:
        return rows, []
    described = []
    for number, part in enumerate(parts[:MOST], 1):
        first, last, y = rows.lines[part[0]], rows.lines[part[-1]], rows.points[0, part]
        described.append(f"{number}: lines {first} to {last}, y = {y.min():.4g} to {y.max():.4g} mm")
    listed = "; ".join([*described, *["..."] * (len(parts) > MOST)])
    if surface is None:
        raise source.refused(f"surface: there are {len(parts)} ({listed}); give surface = 1 ... {len(parts)}")
    if isinstance(surface, bool) or not isinstance(surface, int) or not 1 <= surface <= len(parts):
        raise WrongInput(f"surface = {surface!r}: {source.path} has {len(parts)} ({listed})")
    chosen = rows.only(parts[surface - 1])
    if (width := float(np.ptp(chosen.points[0]))) < HEAD:
        raise source.refused(
            f"surface = {surface}: {width:.3g} mm wide, too narrow for a running surface ({listed}). "
            "Choose another surface, or correct axes: an inverted rail looks like a groove between its "
            "faces"
        )
    return chosen, [f"Surface {surface} of {len(parts)} ({listed})."] * (len(parts) > 1)


def surfaces(points: Array) -> list[Indices]:
    """Indices of the points of each surface of points (2, n) with z up [mm]."""
    z = points[1]
    before, behind = np.maximum.accumulate(z), np.maximum.accumulate(z[::-1])[::-1]
    in_groove = np.minimum(before, behind) - z >= GROOVE
    outside = np.flatnonzero(~in_groove)
    steps = np.abs(np.diff(points[0]))
    way = np.cumsum(steps)
    opens = (steps > OPENING) & (way - steps >= HEAD) & (way[-1] - way >= HEAD)
    ends = (np.diff(outside) > 1) | opens[outside[:-1]]
    return np.split(outside, np.flatnonzero(ends) + 1)


def is_groove(points: Array) -> bool:
    """Whether points (2, n) with z up [mm] are a groove between two running surfaces and nothing else."""
    tops = [
        points[:, part[points[1, part] >= np.max(points[1, part]) - FACE_DEPTH]] for part in surfaces(points)
    ]
    heads = sum(np.ptp(top[0]) >= 2 * HEAD for top in tops)
    y = points[0] * np.sign(points[0, -1] - points[0, 0])
    undercut = np.max(np.maximum.accumulate(y) - y)
    return heads > 1 and bool(np.ptp(points[1]) <= DEEPEST and undercut <= UNDERCUT)


# --- axes ---

CHOICES: Mapping[str, str] = MappingProxyType(
    {
        "field": "y points to the field side",
        "centre": "y points to the track centre",
        "up": "z points up",
        "down": "z points down",
    }
)
LEVEL = 0.2  # share of the height of a rail that belongs to its top
RATIO = 2.0  # of the widths at top and bottom from which on a rail's top differs from its ends
BULGE = 0.1  # least area between a rail and the chord of its ends, as a share of width times height
FLANGE = 10.0  # least height [mm] of a flange over the tread
TIP = 0.15  # share of the height of a flange that belongs to its tip
TIP_WIDTH = 3.0  # least width [mm] of the tip
FACES = 10.0  # depth [mm] of both ends below the top from which on it is no wheel: outer faces go up
ASIDE = 0.15  # least distance of the tip from the middle of the wheel, as a share of its width


@dataclass(frozen=True)
class Axes:
    """Side to which y grows and where z points; None: not known."""

    y: Side | None = None
    z: Height | None = None

    def or_else(self, other: "Axes") -> "Axes":
        """These axes, completed by others."""
        return Axes(self.y or other.y, self.z or other.z)

    def contradicts(self, other: "Axes") -> bool:
        """Whether an axis is known to both, and differs."""
        return any(a and b and a != b for a, b in ((self.y, other.y), (self.z, other.z)))

    def __str__(self) -> str:
        return " ".join(word for word in (self.y, self.z) if word) or "nothing"


def parse_axes(axes: str | None) -> Axes:
    """Axes from one or two of the words of `CHOICES`, such as "centre down"."""
    words = [] if axes is None else str(axes).lower().split()
    known = {word for word in words if word in CHOICES}
    y: list[Side] = [side for side in ("field", "centre") if side in known]
    z: list[Height] = [height for height in ("up", "down") if height in known]
    if len(known) < len(words) or len(y) > 1 or len(z) > 1 or (axes is not None and not words):
        raise WrongInput(
            f"axes = {axes!r}: must be 'field' or 'centre', 'up' or 'down', or one of each, as 'centre down' "
            f"({', '.join(f'{word}: {meaning}' for word, meaning in CHOICES.items())})"
        )
    return Axes(y[0] if y else None, z[0] if z else None)


def find_axes(source: Source, content: Content, kind: Kind, given: Axes) -> tuple[Axes, list[str]]:
    """Axes of points in mm, and notes on where they come from. Raises WrongInput for what is missing.

    The argument counts first, then the format, then the shape. What contradicts a wheel's flange or a rail's
    head is refused, and so is a format that contradicts the shape: the argument decides. A rail with the
    flange of a wheel and a wheel with the faces of a rail are refused, too.
    """
    shape, stated = axes_by_shape(kind, content.rows.points), Axes(content.y, content.z)
    if shape.contradicts(given):
        mark, other = ("flange", "a rail") if kind == "wheel" else ("head", "a wheel")
        raise source.refused(
            f"axes = '{given}': the {mark} of this {kind} shows '{shape}'; correct axes, or give kind for "
            f"{other}"
        )
    by_format = Axes(None if given.y else stated.y, None if given.z else stated.z)
    if shape.contradicts(by_format):
        raise source.refused(
            f"axes: '{stated}' by the format, but the shape looks like '{shape}'; "
            f"give axes, such as '{shape.or_else(stated)}'"
        )
    axes = given.or_else(stated).or_else(shape)
    missing = [
        " or ".join(f"'{word}' ({CHOICES[word]})" for word in pair)
        for pair, known in ((("field", "centre"), axes.y), (("up", "down"), axes.z))
        if known is None
    ]
    if missing:
        raise source.refused(
            f"axes: the file and the shape do not show all directions; give axes = {' and '.join(missing)}"
        )
    _check_kind(source, content.rows.points, kind, axes)
    notes = []
    for word, said, format_has in ((axes.y, given.y, stated.y), (axes.z, given.z, stated.z)):
        shown = "its head" if kind == "rail" else "its flange"
        origin = "as given" if said else "by the format" if format_has else f"as {shown} shows"
        notes.append(f"In the file {CHOICES[str(word)]}, {origin}.")
    return axes, notes


def _check_kind(source: Source, points: Array, kind: Kind, axes: Axes) -> None:
    """Raise WrongInput for a wheel that is said to be a rail, and the other way round."""
    up = points[1] if axes.z == "up" else -points[1]
    if kind == "wheel" and np.max(up) - max(up[0], up[-1]) >= FACES:
        raise source.refused(
            f"kind = 'wheel': both ends lie {np.max(up) - max(up[0], up[-1]):.3g} mm or more below the top, "
            "as the faces of a rail do; correct kind or axes"
        )
    heads = [part for part in surfaces(np.stack([points[0], up])) if np.ptp(points[0, part]) >= HEAD]
    if kind == "rail" and len(heads) == 1:
        wheel = axes_of_wheel(points)
        if wheel.y and wheel.z:
            raise source.refused(
                "kind = 'rail': it has the flange of a wheel; correct kind, or leave out the points beyond "
                "the groove of a rail"
            )
        if is_groove(np.stack([points[0], -up])):
            raise source.refused(
                f"axes: with z {axes.z} it is a ridge {np.ptp(up):.3g} mm high between level parts; turned "
                "over, two rails with a groove between them: correct axes, or leave out the points beside "
                "the head"
            )


# --- the shape ---


def axes_by_shape(kind: Kind, points: Array) -> Axes:
    """What the shape of points (2, n) [mm] shows for sure.

    The wide end of a rail is its top, and the points lie on its side of the chord of the ends.
    """
    if kind == "wheel":
        return axes_of_wheel(points)
    y, z = points
    low, height, width = np.min(z), np.ptp(z), np.ptp(y)
    top = covered(points, low + (1 - LEVEL) * height, np.inf)
    bottom = covered(points, -np.inf, low + LEVEL * height)
    rise = z - (z[0] + (z[-1] - z[0]) * (y - y[0]) / (y[-1] - y[0])) if y[-1] != y[0] else z - z[0]
    area = np.sum((rise[1:] + rise[:-1]) / 2 * np.diff(y)) * np.sign(y[-1] - y[0])
    if top >= RATIO * bottom and area > BULGE * width * height:
        return Axes(None, "up")
    return Axes(None, "down") if bottom >= RATIO * top and area < -BULGE * width * height else Axes()


def axes_of_wheel(points: Array) -> Axes:
    """Both axes by the tip of the flange, which lies off the tread, is round, and no end of the points.

    The tread is more than half of a wheel: its height is the one that halves the width covered.
    """
    y, z = points
    order = np.argsort(middles := (z[1:] + z[:-1]) / 2)
    widths = np.cumsum(np.abs(np.diff(y))[order])
    tread = float(middles[order][np.searchsorted(widths, widths[-1] / 2)])
    tips = [side for side in (1, -1) if _is_tip(np.stack([y, side * (z - tread)]))]
    if len(tips) != 1:
        return Axes()
    tip = y[np.argmax(tips[0] * z)]
    middle = (np.max(y) + np.min(y)) / 2
    z_points: Height = "down" if tips[0] > 0 else "up"
    if abs(tip - middle) < ASIDE * np.ptp(y):
        return Axes(None, z_points)
    return Axes("field" if tip < middle else "centre", z_points)


def _is_tip(points: Array) -> bool:
    """Whether the largest height over the tread is that of a flange."""
    height = np.max(points[1])
    is_end = np.argmax(points[1]) in (0, points.shape[1] - 1)
    return bool(height >= FLANGE and not is_end and covered(points, (1 - TIP) * height, np.inf) >= TIP_WIDTH)


def covered(points: Array, low: float, high: float) -> float:
    """Sum of the widths [mm] of the segments with their middle between two heights."""
    middles = (points[1, 1:] + points[1, :-1]) / 2
    return float(np.sum(np.abs(np.diff(points[0]))[(middles >= low) & (middles <= high)]))


def turned(rows: Rows, axes: Axes) -> tuple[Rows, list[str]]:
    """The points with y to the field side and z up, from the gauge side to the field side, and a note."""
    signs = np.array([1.0 if axes.y == "field" else -1.0, 1.0 if axes.z == "up" else -1.0])
    rows = rows.moved(rows.points * signs[:, None] + 0.0)  # no -0
    if rows.points[0, -1] >= rows.points[0, 0]:
        return rows, []
    return rows.only(slice(None, None, -1)), [
        "The order of the points was reversed: from gauge to field side."
    ]
