"""The distance of wheel and rail beside their touching points, and where an approach closes it: strips."""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.quadrature import on_panels
from geometries.track.curves import Graph, Moved
from geometries.track.layout import Layout, Side, SideName
from geometries.track.touching import gap_minima, point_at, posed, wheel_graphs
from geometries.track.wheelset import Position, Touch, curves_in_place, make_touch

NEWTON_STEPS = 30
LENGTH_ROUNDING = 1e-11  # mm: arc lengths of the wheel
AREA_PANELS, AREA_POINTS = 40, 4  # Gauss quadrature of the overlap of a strip


@dataclass(frozen=True, eq=False)
class Strip:
    """A part of the rail that the wheel overlaps at an approach: where a patch may be.

    s_rail: arc lengths [mm] of its edges. y: theirs in the axes of the side. depth: largest vertical overlap
    [mm]. area: of the overlap in the section [mm^2]. touches: the touching points inside; more than one
    where the strips of several points have merged.
    """

    s_rail: tuple[float, float]
    y: tuple[float, float]
    depth: float
    area: float
    touches: tuple[Touch, ...]

    @property
    def merged(self) -> bool:
        """Whether several touching points share this strip."""
        return len(self.touches) > 1


def distances(layout: Layout, position: Position, side: SideName, s_rail: ArrayLike) -> Array:
    """Distances [mm] of the wheel along the normals of the rail at arc lengths of it; shape of s_rail.

    Nan where the normal passes beside the wheel's profile.
    """
    rail, wheel = curves_in_place(layout, position, side)
    s = np.asarray(s_rail, dtype=float)
    points, (ty, tz) = rail.position(s), rail.tangent(s)
    t = _nearest(layout.side(side), wheel, points)
    for _ in range(NEWTON_STEPS):
        apart, tangents = wheel.position(t) - points, wheel.tangent(t)
        step = (apart[0] * ty + apart[1] * tz) / (tangents[0] * ty + tangents[1] * tz)
        t = np.clip(t - step, *wheel.limits)
        if np.max(np.abs(step), initial=0.0) <= LENGTH_ROUNDING:
            break
    apart = wheel.position(t) - points
    on_normal = np.abs(apart[0] * ty + apart[1] * tz) <= 1e-9 * (1 + np.hypot(*apart))
    return np.where(on_normal, apart[1] * ty - apart[0] * tz, np.nan)


def strips(layout: Layout, position: Position, side: SideName, approach: float) -> tuple[Strip, ...]:
    """The strips of a side when the wheelset is lowered by `approach` [mm], from the gauge to the field side.

    Their edges are where both curves cross. Raises Failure where a strip reaches the end of a profile.
    """
    if not 0 < approach < np.inf:
        raise WrongInput(f"approach = {approach!r}: must be a positive length [mm]")
    both = layout.side(side)
    shift, roll, height = position.pose(side)
    minima = gap_minima(both, shift, roll, within=approach)
    touches = sorted((make_touch(both, m, height) for m in minima), key=lambda touch: touch.s_rail)
    gap_above = RailGap(both, shift, roll, height - approach)
    edges = _edges(gap_above, np.array([touch.s_rail for touch in touches if touch.gap < approach]))
    return tuple(_strip(gap_above, edge, touches, approach) for edge in edges)


class RailGap:
    """The vertical gap above points of a rail, in one position of the wheelset."""

    def __init__(self, side: Side, shift: float, roll: float, height: float) -> None:
        self.side = side
        self.wheel = posed(side, shift, roll, height)
        self.graphs = wheel_graphs(side, shift, roll, height)

    def gap(self, t: Array) -> Array:
        """Vertical gaps [mm] at arc lengths t of the rail; nan where no wheel is above; shape of t."""
        y, z = self.side.rail.position(t)
        above = [_height(self.wheel, graph, y) for graph in self.graphs]
        lowest = np.fmin.reduce([np.full_like(y, np.nan), *above])
        return np.asarray(lowest - z)

    def gap_at(self, t: float) -> float:
        """The vertical gap [mm] at one arc length of the rail; nan where no wheel is above."""
        rail = self.side.rail.at(t)
        above = [
            point_at(self.wheel, rail.y, float(np.interp(rail.y, graph.y, graph.t)))
            for graph in self.graphs
            if graph.y[0] <= rail.y <= graph.y[-1]
        ]
        return min((found[1].z - rail.z for found in above if found), default=np.nan)


def _height(wheel: Moved, graph: Graph, y: Array) -> Array:
    """Heights of the wheel's curve at y, on one of its graphs; nan beside it."""
    t = np.interp(y, graph.y, graph.t)
    for _ in range(NEWTON_STEPS):
        step = (wheel.position(t)[0] - y) / wheel.tangent(t)[0]
        t = np.clip(t - step, graph.t[0], graph.t[-1])
        if np.max(np.abs(step[(y > graph.y[0]) & (y < graph.y[-1])]), initial=0.0) <= LENGTH_ROUNDING:
            break
    return np.where((y >= graph.y[0]) & (y <= graph.y[-1]), wheel.position(t)[1], np.nan)


def _edges(gap_above: RailGap, touching: Array) -> list[tuple[float, float]]:
    """Arc lengths of the rail between which the gap is negative, refined on the curves.

    Touching points are samples too, so that a strip narrower than the samples is not missed.
    """
    edges = []
    for graph in gap_above.side.rail_graphs:
        inside = touching[(touching > graph.t[0]) & (touching < graph.t[-1])]
        t = np.union1d(graph.t, inside)
        gaps = gap_above.gap(t)
        closed = np.concatenate([[False], gaps < 0, [False]])
        starts, ends = (np.flatnonzero(np.diff(closed.astype(int)) == sign) for sign in (1, -1))
        for first, after in zip(starts, ends, strict=True):
            if first == 0 or after == len(t) or np.isnan(gaps[[first - 1, after]]).any():
                raise Failure(
                    f"approach: a strip reaches the end of a profile at arc length {t[first]:.3f} or "
                    f"{t[after - 1]:.3f} mm of the rail; take a smaller approach or more of the profiles"
                )
            edges.append((_zero(gap_above, t[first - 1], t[first]), _zero(gap_above, t[after - 1], t[after])))
    return edges


def _zero(gap_above: RailGap, low: float, high: float) -> float:
    """Arc length of the rail where the gap is zero."""
    return float(scipy.optimize.brentq(gap_above.gap_at, low, high, xtol=LENGTH_ROUNDING))


def _strip(gap_above: RailGap, edge: tuple[float, float], touches: list[Touch], approach: float) -> Strip:
    """A strip between its edges."""
    inside = tuple(touch for touch in touches if edge[0] < touch.s_rail < edge[1] and touch.gap < approach)
    ends = np.linspace(*edge, AREA_PANELS + 1)
    t, weights = on_panels(ends[:-1], ends[1:], AREA_POINTS)
    overlap = -gap_above.gap(t.ravel()).reshape(t.shape)
    area = float(np.sum(weights * overlap * gap_above.side.rail.tangent(t)[0]))
    y = gap_above.side.rail.position(np.array(edge))[0]
    return Strip(
        s_rail=edge,
        y=(float(y[0]), float(y[1])),
        depth=max([float(np.max(overlap)), *(approach - touch.gap for touch in inside)]),
        area=area,
        touches=inside,
    )


def _nearest(side: Side, wheel: Moved, points: Array) -> Array:
    """Arc lengths of the wheel's samples nearest to points (2, ...); shape of one coordinate."""
    t = side.wheel_samples.t
    tree = scipy.spatial.cKDTree(wheel.position(t).T)
    return np.asarray(t[tree.query(np.moveaxis(points, 0, -1))[1]])
