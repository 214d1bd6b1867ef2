"""Touching points of one wheel above one rail: all local minima of the vertical gap, refined to rounding."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from geometries.errors import Failure
from geometries.track.curves import Graph, Moved, Place, Samples, graphs, turned
from geometries.track.layout import Side

SAMPLED_ERROR = 1e-3  # mm: minima of the sampled gap within this of the least one may be the least one
HERMITE_ERROR = 1e-5  # mm: of sampled gaps; far above what smooth curves have
NEWTON_STEPS = 60  # of one touching point; bisection alone needs 40
Y_ROUNDING = 2e-12  # mm: equal y of rail and wheel, 760 mm from the middle
Y_STEP = 1e-5  # mm: of pieces of standards that do not meet, turned by inclination and roll
ANGLE_ROUNDING = 1e-13  # rad: parallel tangents
PARALLEL = 1e-10  # rad: what is left above this is no minimum but an end of its bracket, or a joint
JOINT = 5e-3  # rad: edges at joints of pieces up to this are touching points (EN 15302, wheel I: 3.6e-3)
SAME = 1e-6  # mm along the rail: two touching points nearer than this are one
FOLLOWED = 0.5  # mm along the rail
WIDER = 10  # times as wide a bracket, where the sampled gap is level to its error


@dataclass(frozen=True)
class Minimum:
    """A local minimum of the vertical gap: arc lengths on rail and wheel [mm], gap [mm], angle [rad].

    `angle` is that of the common tangent, positive where it rises to the field side. The gap is that of the
    wheel with its axle at the height 0.
    """

    t_rail: float
    t_wheel: float
    gap: float
    angle: float


def posed(side: Side, shift: float, roll: float, height: float = 0.0) -> Moved:
    """The wheel of a side, the axle turned by `roll`, its middle at (shift, height); axes of the side."""
    y, z = turned(np.array(side.wheel.offset), roll)
    offset = float(y + shift), float(z + height)
    return replace(side.wheel, angle=float(side.wheel.angle + roll), offset=offset)


def wheel_graphs(side: Side, shift: float, roll: float, height: float = 0.0) -> list[Graph]:
    """The parts of the wheel that can be seen from below, in a position of the wheelset."""
    samples = side.wheel_samples
    y, z = turned(samples.points, roll)
    points = np.stack([y + shift, z + height])
    return graphs(Samples(samples.t, points, turned(samples.tangents, roll)))


def gap_minima(side: Side, shift: float, roll: float, within: float = SAMPLED_ERROR) -> list[Minimum]:
    """Local minima of the vertical gap, least gap first, up to `within` [mm] above the least one.

    The middle of the axle is at (shift, 0). Raises Failure where the gap is least at an end of a profile.
    """
    wheel = posed(side, shift, roll)
    brackets, end = _sampled_minima(side, shift, roll)
    least = min([gap for *_, gap in brackets], default=np.inf)
    margin = max(within, 0.0) + SAMPLED_ERROR
    if end is None or end[2] < least:
        raise Failure(_no_touch(side, wheel, end))
    candidates = [(bracket, t_wheel) for bracket, t_wheel, gap in brackets if gap <= least + margin]
    minima = _without_repeats(refined_near(side.rail, wheel, *candidate) for candidate in candidates)
    if not minima or minima[0].gap > least + HERMITE_ERROR + side.step:
        raise Failure(
            f"touching points near arc lengths {[bracket for bracket, _ in candidates]} mm of the rail: "
            "not found on the curves, which may have kinks; smooth the profiles"
        )
    return [minimum for minimum in minima if minimum.gap <= minima[0].gap + within]


def followed_to(side: Side, minimum: Minimum, shift: float, roll: float) -> Minimum | None:
    """The minimum near one of another position; None where there is none within `FOLLOWED` of the rail."""
    rail, t = side.rail, minimum.t_rail
    ends = max(t - FOLLOWED, 0.0), min(t + FOLLOWED, rail.limits[1])
    return refined(rail, posed(side, shift, roll), ends, minimum.t_wheel)


def refined(rail: Moved, wheel: Moved, bracket: tuple[float, float], t_wheel: float) -> Minimum | None:
    """The minimum of the vertical gap between two arc lengths of the rail: Newton's method, confined to them.

    The gap is stationary where the tangents are parallel at equal y, or nearly so at a joint of pieces that
    do not meet exactly. None if it is least at an end.
    """
    low, high = bracket
    t, turn = (low + high) / 2, math.inf
    for _ in range(NEWTON_STEPS):
        on_rail = rail.at(t)
        below = point_at(wheel, on_rail.y, t_wheel)
        if below is None:
            return None
        t_wheel, on_wheel = below
        turn = math.atan2(
            on_rail.t_y * on_wheel.t_z - on_rail.t_z * on_wheel.t_y,
            on_rail.t_y * on_wheel.t_y + on_rail.t_z * on_wheel.t_z,
        )  # from the rail's tangent to the wheel's
        low, high = (t, high) if turn < 0 else (low, t)
        if abs(turn) <= ANGLE_ROUNDING or high - low <= Y_ROUNDING:
            break
        rate = on_rail.curvature - on_wheel.curvature * on_rail.t_y / on_wheel.t_y
        newton = t - turn / rate if rate > 0 else math.inf
        t = newton if low < newton < high else (low + high) / 2
    between = bracket[0] < low and high < bracket[1]  # the angle changes its sign there
    if abs(turn) > (JOINT if between else PARALLEL):
        return None
    on_rail, on_wheel = rail.at(t), wheel.at(t_wheel)
    beside = on_rail.y - on_wheel.y  # rounding, which counts where the tangent is steep
    gap = on_wheel.z + beside * on_wheel.t_z / on_wheel.t_y - on_rail.z
    return Minimum(t, t_wheel, gap, math.atan2(on_rail.t_z, on_rail.t_y))


def refined_near(rail: Moved, wheel: Moved, bracket: tuple[float, float], t_wheel: float) -> Minimum | None:
    """The minimum in a bracket or, if the samples were too level to bracket it, near it."""
    minimum = refined(rail, wheel, bracket, t_wheel)
    if minimum is not None:
        return minimum
    middle, half = sum(bracket) / 2, WIDER * (bracket[1] - bracket[0]) / 2
    low, high = np.clip([middle - half, middle + half], *rail.limits)
    return refined(rail, wheel, (float(low), float(high)), t_wheel)


def _without_repeats(found: Iterable[Minimum | None]) -> list[Minimum]:
    """Minima by growing gap, each once."""
    minima: list[Minimum] = []
    for minimum in sorted((m for m in found if m is not None), key=lambda m: m.gap):
        if all(abs(minimum.t_rail - other.t_rail) > SAME for other in minima):
            minima.append(minimum)
    return minima


def _sampled_minima(
    side: Side, shift: float, roll: float
) -> tuple[list[tuple[tuple[float, float], float, float]], tuple[float, float, float] | None]:
    """Local minima of the gap at samples of the rail: (bracket on the rail, t of the wheel, gap) of each.

    The second value is (t of the rail, y, gap) at the end of a graph where the gap is least; None if the
    wheel is nowhere above the rail.
    """
    minima, ends = [], []
    for wheel in wheel_graphs(side, shift, roll):
        for rail in side.rail_graphs:
            above = (rail.y >= wheel.y[0]) & (rail.y <= wheel.y[-1])
            t, y = rail.t[above], rail.y[above]
            if len(t) < 3:
                continue
            gaps = wheel.heights(y) - rail.z[above]
            middle = gaps[1:-1]
            for k in np.flatnonzero((middle <= gaps[:-2]) & (middle < gaps[2:])) + 1:
                bracket = (float(t[k - 1]), float(t[k + 1]))
                minima.append((bracket, float(np.interp(y[k], wheel.y, wheel.t)), float(gaps[k])))
            ends += [(float(t[k]), float(y[k]), float(gaps[k])) for k in (0, -1)]
    return minima, min(ends, key=lambda end: end[2], default=None)


def point_at(wheel: Moved, y: float, t: float) -> tuple[float, Place] | None:
    """Arc length and point of the wheel at y, by Newton's method from a near one; None where it is lost.

    Within `Y_STEP` of y where that falls between two pieces of a standard.
    """
    for _ in range(NEWTON_STEPS):
        place = wheel.at(t)
        apart = place.y - y
        if abs(apart) <= Y_ROUNDING:
            return t, place
        t -= apart / place.t_y
    return (t, place) if abs(apart) <= Y_STEP else None


def _no_touch(side: Side, wheel: Moved, end: tuple[float, float, float] | None) -> str:
    """Why a wheel does not touch with a common tangent."""
    y_rail = np.concatenate([graph.y for graph in side.rail_graphs])
    y_wheel = wheel.position(side.wheel_samples.t)[0]
    reach = (
        f"rail from y = {np.min(y_rail):.3f} to {np.max(y_rail):.3f} mm, "
        f"wheel from {np.min(y_wheel):.3f} to {np.max(y_wheel):.3f} mm"
    )
    if end is None:
        return f"the wheel does not lie above the rail: {reach}; check gauge, flange back and shift"
    return (
        f"the gap is least at y = {end[1]:.3f} mm, where a profile ends or is steeper than 85 degrees: "
        f"{reach}; extend the profiles or give a smaller shift"
    )
