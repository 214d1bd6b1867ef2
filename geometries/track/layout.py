"""Rails at their gauge and wheels on their axle: both sides of a track in axes of their own."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy

from geometries.arrays import Mask
from geometries.errors import WrongInput
from geometries.profiles.pieces import Outline
from geometries.profiles.placement import Curve
from geometries.profiles.preparation import Prepared
from geometries.profiles.profile import Kind
from geometries.track.curves import STEEPEST, Graph, Moved, Samples, graphs, sampled

SAMPLE_SPACING = 0.04  # mm along a curve: narrower minima of the gap may be missed
FLANGE_PLATEAU = 1e-3  # rad below the largest inclination of a wheel that still count as its steepest part


SideName = Literal["left", "right"]


@dataclass(frozen=True)
class TrackDimensions:
    """Gauge [mm], the depth [mm] below the rail top down to which it is measured, and the rails' inclination.

    `rail_inclination` is the slope, such as 1/40, by which the profiles are to be turned towards the middle
    of the track; False where they are already inclined.
    """

    gauge: float
    gauge_depth: float
    rail_inclination: float | Literal[False]

    def __post_init__(self) -> None:
        _check_positive("gauge", self.gauge, "mm")
        _check_positive("gauge_depth", self.gauge_depth, "mm")
        if self.rail_inclination is not False and not abs(float(self.rail_inclination)) < 0.5:
            raise WrongInput(f"rail_inclination = {self.rail_inclination!r}: must be a slope such as 1/40")
        if self.rail_inclination is True:
            raise WrongInput("rail_inclination = True: give the slope, such as 1/40; False if it is inclined")


@dataclass(frozen=True)
class WheelsetDimensions:
    """Distance of the flange backs [mm], nominal radii [mm], and where on the profiles they belong.

    `nominal_radius` is that of both wheels or (left, right), on the tape circle, `tape_circle` [mm] from the
    flange back. `flange_back` is the y of the flange back in the axes of the profile, for both or (left,
    right), or None for one or both: the least y of the profile, if it is there at least 85 degrees steep.
    """

    flange_back_distance: float
    nominal_radius: float | tuple[float, float]
    flange_back: float | tuple[float | None, float | None] | None = None
    tape_circle: float = 70.0

    def __post_init__(self) -> None:
        _check_positive("flange_back_distance", self.flange_back_distance, "mm")
        for radius in _both(self.nominal_radius):
            _check_positive("nominal_radius", radius, "mm")
        _check_positive("tape_circle", self.tape_circle, "mm")


@dataclass(frozen=True, eq=False)
class Side:
    """One rail and one wheel: y to the field side, z up; the right side is mirrored into these axes.

    The rail's origin is the middle of the track at the height of the rail tops, the wheel's the middle of
    the axle. `steepest` is the arc length on the wheel at which, towards the tip of the flange, its steepest
    part ends, `tape` the lowest point of its tape circle, y and z from the middle of the axle [mm]. `step`
    [mm] is by how much pieces of a standard do not meet.
    """

    rail: Moved
    wheel: Moved
    rail_graphs: list[Graph]
    wheel_samples: Samples
    steepest: float
    tape: tuple[float, float]
    notes: tuple[str, ...] = ()
    step: float = 0.0


@dataclass(frozen=True, eq=False)
class PlacedWheel:
    """A wheel in its place, the arc length of its tape circle [mm], and notes."""

    curve: Moved
    t_tape: float
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Layout:
    """Both sides, and the nominal radii (left, right) [mm]."""

    left: Side
    right: Side
    nominal_radius: tuple[float, float]

    def side(self, name: SideName) -> Side:
        """The side of a name; raises WrongInput for another one."""
        if name not in {"left", "right"}:
            raise WrongInput(f"side = {name!r}: must be 'left' or 'right'")
        return self.left if name == "left" else self.right

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about what was determined from the profiles."""
        return tuple(
            f"{name}: {note}"
            for name, side in (("left", self.left), ("right", self.right))
            for note in side.notes
        )


def lay_out(
    rails: tuple[Curve, Curve],
    wheels: tuple[Curve, Curve],
    track: TrackDimensions,
    wheelset: WheelsetDimensions,
) -> Layout:
    """Rails and wheels, (left, right) each, in their places. Their own axes: y to the field side, z up.

    Curves are those of `geometries.profiles`: outlines of standards, and prepared profiles. Raises WrongInput
    for a wheel as a rail and the reverse.
    """
    kinds: tuple[Kind, Kind] = ("rail", "wheel")
    for curves, kind in zip((rails, wheels), kinds, strict=True):
        for curve in curves:
            _check_kind(curve, kind)
    radii = _both(wheelset.nominal_radius)
    backs = wheelset.flange_back
    backs = backs if isinstance(backs, tuple) else (backs, backs)
    sides = list(zip(rails, wheels, radii, backs, strict=True))
    placed = [
        _side(place_rail(rail, track), place_wheel(wheel, wheelset, radius, back))
        for rail, wheel, radius, back in (sides if sides[0] != sides[1] else sides[:1])
    ]
    return Layout(placed[0], placed[-1], radii)


def place_rail(rail: Curve, track: TrackDimensions) -> Moved:
    """A rail inclined, its top at z = 0, and its gauge point at y = gauge/2.

    The gauge point is the least y between the top and the depth of the gauge (EN 13848-1).
    """
    inclined = Moved(rail, float(np.arctan(float(track.rail_inclination))), (0.0, 0.0))
    samples = sampled(inclined, SAMPLE_SPACING)
    t_top, top = _extreme(inclined, samples, axis=1, sign=1)
    gauge_side = _part(samples, samples.t < t_top)
    depth = top - gauge_side.points[1]
    deeper = np.flatnonzero(depth > track.gauge_depth)
    if not len(deeper):
        raise WrongInput(
            f"gauge_depth = {track.gauge_depth:g} mm, but the rail profile ends "
            f"{np.max(depth, initial=0.0):.3f} mm below its top on the gauge side; take more of the "
            "profile or a smaller depth"
        )
    lowest = int(deeper[-1])
    t_depth = _crossing(inclined, 1, top - track.gauge_depth, (gauge_side.t[lowest], samples.t[lowest + 1]))
    face = _part(samples, (samples.t >= t_depth) & (samples.t <= t_top))
    y_gauge = min(float(inclined.position(t_depth)[0]), _extreme(inclined, face, axis=0, sign=-1)[1])
    return replace(inclined, offset=(track.gauge / 2 - y_gauge, -top))


def place_wheel(
    curve: Curve, wheelset: WheelsetDimensions, radius: float, flange_back: float | None
) -> PlacedWheel:
    """A wheel about the middle of its axle, with the nominal radius on its tape circle."""
    wheel = Moved(curve, 0.0, (0.0, 0.0))
    samples = sampled(wheel, SAMPLE_SPACING)
    notes: tuple[str, ...] = ()
    if flange_back is None:
        flange_back = _flange_back(samples)
        notes = (f"the flange back is the least y of the profile, {flange_back:.4f} mm",)
    y = flange_back + wheelset.tape_circle
    above = np.flatnonzero(samples.points[0] > y)
    if not len(above) or above[0] == 0:
        least, largest = np.min(samples.points[0]), np.max(samples.points[0])
        raise WrongInput(
            f"tape circle at y = {y:g} mm (flange back {flange_back:g} + {wheelset.tape_circle:g}): the "
            f"wheel profile goes from y = {least:g} to {largest:g} mm; check flange_back and tape_circle"
        )
    k = int(above[0])
    t_tape = _crossing(wheel, 0, y, (samples.t[k - 1], samples.t[k]))
    z = float(wheel.position(t_tape)[1])
    offset = (wheelset.flange_back_distance / 2 - flange_back, -radius - z)
    return PlacedWheel(replace(wheel, offset=offset), t_tape, notes)


def _side(rail: Moved, wheel: PlacedWheel) -> Side:
    """A side with samples of its curves. The flange is sought between flange back and tape circle."""
    samples = sampled(wheel.curve, SAMPLE_SPACING)
    slopes = np.arctan2(samples.tangents[1], samples.tangents[0])[samples.t <= wheel.t_tape]
    steep = np.flatnonzero(slopes > np.max(slopes) - FLANGE_PLATEAU)
    steepest = float(samples.t[steep[0]])
    at_tape = wheel.curve.at(wheel.t_tape)
    tape = (at_tape.y, at_tape.z)
    rail_graphs = graphs(sampled(rail, SAMPLE_SPACING))
    outlines = (moved.curve for moved in (rail, wheel.curve) if isinstance(moved.curve, Outline))
    step = max((float(np.max(outline.gaps[0], initial=0.0)) for outline in outlines), default=0.0)
    return Side(rail, wheel.curve, rail_graphs, samples, steepest, tape, wheel.notes, step)


def _check_kind(curve: Curve, kind: Kind) -> None:
    """Raise WrongInput for a prepared wheel as a rail and the reverse; other curves do not say it."""
    if isinstance(curve, Prepared) and curve.kind != kind:
        raise WrongInput(f"{curve.name or 'profile'}: is a {curve.kind}, but a {kind} is needed here")


def _flange_back(samples: Samples) -> float:
    """The least y of a wheel; raises WrongInput if its face is there less steep than 85 degrees."""
    k = int(np.argmin(samples.points[0]))
    ty, tz = samples.tangents[:, k]
    slope = float(np.arctan2(abs(tz), ty))
    if slope < STEEPEST:
        raise WrongInput(
            "wheel.flange_back is not given, and the profile of the wheel begins at y = "
            f"{samples.points[0, k]:g} mm with an inclination of {np.degrees(slope):.1f} degrees, which is "
            "not a flange back. Give the y of the flange back [mm] in the axes of the profile; for a "
            "wheel measured from its tape circle this is -70, if the tape circle is 70 mm from the flange "
            "back"
        )
    return float(samples.points[0, k])


def _extreme(curve: Moved, samples: Samples, axis: int, sign: int) -> tuple[float, float]:
    """Arc length and value of the largest sign*(y or z) among samples, refined on the curve."""
    k = int(np.argmax(sign * samples.points[axis]))
    if 0 < k < len(samples.t) - 1:
        ends = samples.t[k - 1], samples.t[k + 1]
        before, after = (curve.tangent(t)[axis] for t in ends)
        if before * after < 0:
            t = float(scipy.optimize.brentq(lambda t: float(curve.tangent(t)[axis]), *ends, xtol=1e-13))
            return t, float(curve.position(t)[axis])
    return float(samples.t[k]), float(samples.points[axis, k])


def _crossing(curve: Moved, axis: int, value: float, ends: tuple[float, float]) -> float:
    """Arc length between `ends` at which y (axis 0) or z (axis 1) has a value."""
    return float(scipy.optimize.brentq(lambda t: float(curve.position(t)[axis]) - value, *ends, xtol=1e-13))


def _part(samples: Samples, mask: Mask) -> Samples:
    """The samples where `mask` holds."""
    return Samples(samples.t[mask], samples.points[:, mask], samples.tangents[:, mask])


def _both(value: float | tuple[float, float]) -> tuple[float, float]:
    """A pair from one value for both sides, or the pair itself."""
    if isinstance(value, tuple):
        return value
    return value, value


def _check_positive(name: str, value: float, unit: str) -> None:
    """Raise WrongInput for what is not a positive number."""
    if not 0 < value < np.inf:
        raise WrongInput(f"{name} = {value!r}: must be positive [{unit}]")
