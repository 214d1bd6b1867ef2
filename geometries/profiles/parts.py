"""Files with more than one running surface: a rail beside its guard rail, a grooved rail.

Two surfaces are separated by a groove, or by a wide gap between points.
"""

import numpy as np

from geometries.arrays import Array, Indices
from geometries.errors import WrongInput
from geometries.profiles.rows import Rows
from geometries.profiles.text import Source

GROOVE = 20.0  # depth [mm] from which on a groove separates surfaces, below the lower of both
OPENING = 25.0  # step in y [mm] without points that separates surfaces
MOST = 6  # number of surfaces that are described
DEEPEST = 80.0  # [mm] of grooves beside rails; a head is higher above its foot
LEVEL = 5.0  # [mm] of a head below its top that are not its faces
UNDERCUT = 5.0  # [mm] of the faces of a groove, at most; a head reaches farther beyond its web
HEAD = 10.0  # least width [mm] on both sides of such a step, and of a running surface


def one_surface(source: Source, rows: Rows, up: float, surface: int | None) -> tuple[Rows, list[str]]:
    """The surface with number `surface`, in the order of the file; a note if there are several.

    `up` is 1 where z of the rows points up, -1 where it points down.
    """
    parts = surfaces(np.stack([rows.points[0], up * rows.points[1]]))
    if surface is None and len(parts) == 1:
        return rows, []
    listed = "; ".join(f"{number}: {_described(rows, part)}" for number, part in enumerate(parts[:MOST], 1))
    listed += "; ..." * (len(parts) > MOST)
    if surface is None:
        raise source.refused(f"surface: there are {len(parts)} ({listed}); give surface = 1 ... {len(parts)}")
    if isinstance(surface, bool) or not isinstance(surface, int) or not 1 <= surface <= len(parts):
        raise WrongInput(f"surface = {surface!r}: {source.path} has {len(parts)} ({listed})")
    chosen = rows.only(parts[surface - 1])
    if (width := float(np.ptp(chosen.points[0]))) < HEAD:
        raise source.refused(
            f"surface = {surface}: {width:.3g} mm wide, no running surface ({listed}); name another one, or "
            "correct axes: a rail upside down is a groove between its faces"
        )
    return chosen, [f"Surface {surface} of {len(parts)} ({listed})."] * (len(parts) > 1)


def _described(rows: Rows, part: Indices) -> str:
    """Where a surface lies, in the file and in y."""
    y = rows.points[0, part]
    return f"lines {rows.lines[part[0]]} to {rows.lines[part[-1]]}, y = {y.min():.4g} to {y.max():.4g} mm"


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
    tops = [points[:, part[points[1, part] >= np.max(points[1, part]) - LEVEL]] for part in surfaces(points)]
    heads = sum(np.ptp(top[0]) >= 2 * HEAD for top in tops)
    y = points[0] * np.sign(points[0, -1] - points[0, 0])
    undercut = np.max(np.maximum.accumulate(y) - y)
    return heads > 1 and bool(np.ptp(points[1]) <= DEEPEST and undercut <= UNDERCUT)
