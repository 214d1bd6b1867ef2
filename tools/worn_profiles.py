"""Profiles worn by each other: Archard's law on a Winkler foundation, in the section through the axle.

By Archard (1953), Journal of Applied Physics 24, 981-988, the worn volume is proportional to load times
sliding distance. In each contact the bodies overlap rigidly; on a foundation of independent springs the
pressure, integrated along x, is proportional to the overlap e(s) (so, too, in the model of Piotrowski and
Kik (2008), Vehicle System Dynamics 46, 27-48). With equal sliding over the patch and in all contacts, the
depth worn off along the normal is

    d(s) = (V / N) sum_k w_k e_k(s) / O,  O = int e_k ds,

with the worn section V [mm^2] of a profile, N steps, and contacts k of the weights w_k, sum 1, under one
load: the area O of their overlap is the same. Contacts are sought again after each step.

`worn_pair` is the pair of the package: wheel S1002 and rail 60E1, inclined 1:40, worn by each other. Run as a
script, this writes it to the files of `geometries.profiles.standards`, or compares it with them (--check).
"""

import argparse
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import scipy

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.profiles.files import read_profile, write_profile
from geometries.profiles.preparation import prepare, sampled
from geometries.profiles.profile import Profile
from geometries.profiles.smoothing import chord_lengths
from geometries.profiles.standards import FOLDER, WORN, standard
from geometries.track.curves import Graph, Moved, Samples, graphs, turned
from geometries.track.layout import Layout, Side, TrackDimensions, WheelsetDimensions, lay_out

# --- the law ---

CUT_OFF = 2.0  # standard deviations of the shift on straight track
HEIGHT_STEPS, HEIGHT_ROUNDING = 60, 1e-10  # Newton's method for the height of a wheel [mm]
HALVINGS = 20  # of the shifts among which that of a lateral force lies
CLIMBING = 12.0  # mm: largest shift in a curve


@dataclass(frozen=True)
class WearLaw:
    """Contacts that wear a wheel and its rail, and how finely they are sampled.

    `overlap`: area [mm^2] by which both sections overlap in each contact. On straight track the wheelset's
    shift has a normal distribution about 0 of the standard deviation `deviation` [mm], cut off at twice that,
    before the flange. A share `curving` of
    the contacts is in curves, where the wheelset moves to this side until the lateral force of the
    foundation is a share of the vertical one, evenly distributed over `lateral`. `spread` [mm]: the depth is
    averaged along the section with a normal distribution of this standard deviation, as neighbouring springs
    of a foundation and scattered contacts would.
    """

    overlap: float = 0.4
    deviation: float = 2.5
    curving: float = 0.3
    lateral: tuple[float, float] = (0.1, 1.0)
    spread: float = 2.0
    straight_samples: int = 80
    curve_samples: int = 40
    steps: int = 90

    def __post_init__(self) -> None:
        for name in ("overlap", "deviation", "spread", "straight_samples", "curve_samples", "steps"):
            if not 0 < getattr(self, name) < np.inf:
                raise WrongInput(f"{name} = {getattr(self, name)!r}: must be positive")
        if not 0 <= self.curving <= 1:
            raise WrongInput(f"curving = {self.curving!r}: must be a share, 0 ... 1")

    @property
    def straight_shifts(self) -> Array:
        """Shifts [mm] on straight track, of equal probability, (straight_samples,)."""
        distribution = scipy.stats.truncnorm(-CUT_OFF, CUT_OFF, scale=self.deviation)
        return np.asarray(distribution.ppf(_middles(self.straight_samples)))

    @property
    def lateral_shares(self) -> Array:
        """Lateral over vertical forces in curves, (curve_samples,)."""
        return self.lateral[0] + (self.lateral[1] - self.lateral[0]) * _middles(self.curve_samples)

    @property
    def weights(self) -> Array:
        """Weights of the contacts on straight track, then in curves; their sum is 1."""
        return np.repeat(
            [(1 - self.curving) / self.straight_samples, self.curving / self.curve_samples],
            [self.straight_samples, self.curve_samples],
        )


# --- wear ---


@dataclass(frozen=True, eq=False)
class Section:
    """Points (y, z) [mm] of a rail or wheel in the axes of the side, (2, n), equally spaced before wear.

    The wheel's axle is at the height 0, the wheelset neither shifted nor rolled. `graph` is the largest part
    that is a function z(y), and its t are numbers of points.
    """

    points: Array
    spacing: float
    normals: Array = field(init=False)  # upwards, (2, n)
    graph: Graph = field(init=False)

    def __post_init__(self) -> None:
        curve = scipy.interpolate.CubicSpline(chord_lengths(self.points), self.points.T)
        slopes = np.moveaxis(curve(curve.x, 1), -1, 0)
        tangents = slopes / np.hypot(*slopes)
        samples = Samples(np.arange(len(curve.x), dtype=float), self.points, tangents)
        largest = max(graphs(samples), key=lambda graph: len(graph.t))
        object.__setattr__(self, "normals", np.stack([-tangents[1], tangents[0]]))
        object.__setattr__(self, "graph", largest)

    @property
    def cosine(self) -> Array:
        """Cosine of the inclination at the points of the graph."""
        return np.asarray(1 / np.hypot(1, self.graph.slope))

    def worn(self, depth: Array, spread: float) -> "Section":
        """Return the section without a layer of a depth [mm] at the points of the graph, spread [mm].

        Positive depths are worn downwards, negative ones upwards.
        """
        everywhere = np.zeros(self.points.shape[1])
        everywhere[self.graph.t.astype(int)] = depth
        spread_out = scipy.ndimage.gaussian_filter1d(everywhere, spread / self.spacing, mode="constant")
        return replace(self, points=self.points - spread_out * self.normals)


@dataclass(frozen=True, eq=False)
class Contacts:
    """A wheel in its rail at shifts [mm], (n,), at heights [mm] at which the overlaps have one area.

    `on_rail` and `on_wheel` are vertical overlaps [mm] at the points of the graphs, (n, n_points).
    """

    rail: Section
    wheel: Section
    shifts: Array
    heights: Array
    on_rail: Array
    on_wheel: Array

    @property
    def lateral_shares(self) -> Array:
        """Lateral force over vertical force of the foundation, (n,)."""
        cosine, width = self.rail.cosine, np.gradient(self.rail.graph.y)
        sine = cosine * self.rail.graph.slope
        return np.asarray((self.on_rail @ (sine * width)) / (self.on_rail @ (cosine * width)))

    @property
    def turns(self) -> Array:
        """Change of the rail's inclination over each overlap [rad], (n,)."""
        inclination = np.arctan(self.rail.graph.slope)
        inside = [inclination[np.flatnonzero(overlap > 0)] for overlap in self.on_rail]
        return np.array([part[0] - part[-1] for part in inside])


@dataclass(frozen=True, eq=False)
class WornPair:
    """Rail and wheel worn by each other, in the axes of their profiles, and depths [mm] along the normals."""

    rail: Profile
    wheel: Profile
    rail_depth: Array
    wheel_depth: Array


def wear(side: Side, law: WearLaw, worn_area: tuple[float, float], spacing: float = 0.2) -> WornPair:
    """Return rail and wheel of a side after areas of their sections [mm^2] (rail, wheel) are worn off.

    `spacing` [mm] is that of the points. The wheelset does not roll about its long axis. Raises Failure where
    an overlap reaches the end of a profile, or no shift gives the lateral force of a curve.
    """
    before = sample_sections(side, spacing)
    rail, wheel = before
    for _ in range(law.steps):
        contacts = all_contacts(rail, wheel, law)
        layers = law.weights @ contacts.on_rail, law.weights @ contacts.on_wheel
        shares = [area / law.steps / law.overlap for area in worn_area]
        rail = rail.worn(shares[0] * layers[0] * rail.cosine, law.spread)
        wheel = wheel.worn(-shares[1] * layers[1] * wheel.cosine, law.spread)
    depths = [np.hypot(*(now.points - then.points)) for now, then in zip((rail, wheel), before, strict=True)]
    return WornPair(
        Profile("rail", _back(side.rail, rail.points)),
        Profile("wheel", _back(side.wheel, wheel.points)),
        *depths,
    )


def sample_sections(side: Side, spacing: float) -> tuple[Section, Section]:
    """Return rail and wheel of a side as points at most `spacing` [mm] apart."""
    if not 0 < spacing < np.inf:
        raise WrongInput(f"spacing = {spacing!r}: must be a positive length [mm]")
    rail, wheel = (_section(curve, spacing) for curve in (side.rail, side.wheel))
    return rail, wheel


def all_contacts(rail: Section, wheel: Section, law: WearLaw) -> Contacts:
    """Return the contacts of a law: on straight track, then in curves."""
    curves = shifts_in_curves(rail, wheel, law.lateral_shares, law.overlap)
    return contacts_at(rail, wheel, np.concatenate([law.straight_shifts, curves]), law.overlap)


def shifts_in_curves(rail: Section, wheel: Section, lateral_shares: Array, overlap: float) -> Array:
    """Return the shifts [mm] at which lateral over vertical forces are given shares, (n,).

    The least ones, by halving, if the share grows with the shift up to there. Raises Failure.
    """
    low, high = np.zeros_like(lateral_shares), np.full_like(lateral_shares, _largest(rail, wheel, overlap))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        beyond = contacts_at(rail, wheel, middle, overlap).lateral_shares > lateral_shares
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    reached = contacts_at(rail, wheel, high, overlap).lateral_shares
    if np.any(reached <= lateral_shares):
        raise Failure(
            f"lateral forces up to {np.max(lateral_shares):.2f} of the vertical one: the flange gives "
            f"{np.max(reached):.2f}; take a smaller range `lateral`"
        )
    return (low + high) / 2


def _largest(rail: Section, wheel: Section, overlap: float) -> float:
    """Return the least of some shifts [mm] in a curve from which on the share grows no more."""
    shifts = np.linspace(0, CLIMBING, 25)
    shares = contacts_at(rail, wheel, shifts, overlap).lateral_shares
    return float(shifts[np.argmax(shares)])


def contacts_at(rail: Section, wheel: Section, shifts: Array, overlap: float) -> Contacts:
    """Return the contacts at shifts [mm], (n,), in which both sections overlap by an area [mm^2]."""
    below, above = rail.graph, wheel.graph
    gaps = _heights(above, below.y - shifts[:, None], np.inf) - below.z
    width = np.gradient(below.y)
    heights = np.min(gaps, axis=1) + overlap / width.sum()
    for _ in range(HEIGHT_STEPS):  # of the surplus area, which is convex in the height
        depth = np.maximum(heights[:, None] - gaps, 0)
        step = (depth @ width - overlap) / ((depth > 0) @ width)
        heights = heights - step
        if np.max(np.abs(step)) <= HEIGHT_ROUNDING:
            break
    on_rail = np.maximum(heights[:, None] - gaps, 0)
    rail_there = _heights(below, above.y + shifts[:, None], -np.inf)
    on_wheel = np.maximum(heights[:, None] - (above.z - rail_there), 0)
    if np.any(on_rail[:, -1] > 0) or np.any(on_wheel[:, [0, -1]] > 0):
        raise Failure(
            f"shifts of {np.min(shifts):.2f} to {np.max(shifts):.2f} mm: wheel and rail overlap at the end "
            "of a profile; take more of the profiles, smaller shifts or a smaller overlap"
        )
    return Contacts(rail, wheel, shifts, heights, on_rail, on_wheel)


def _heights(graph: Graph, y: Array, beside: float) -> Array:
    """Return heights [mm] of a graph at y, and another value beside it; shape of y."""
    return np.where((y >= graph.y[0]) & (y <= graph.y[-1]), graph.heights(y), beside)


def _middles(count: int) -> Array:
    """Return the middles of equal parts of 0 ... 1, (count,)."""
    return (np.arange(count) + 0.5) / count


def _section(curve: Moved, spacing: float) -> Section:
    count = int(np.ceil(curve.limits[1] / spacing))
    return Section(curve.position(np.linspace(*curve.limits, count + 1)), curve.limits[1] / count)


def _back(curve: Moved, points: Array) -> Array:
    """Return points of a side in the axes of the profile, (2, n)."""
    return turned(points - np.array(curve.offset)[:, None], -curve.angle)


# --- the worn pair of the package ---

TRACK = TrackDimensions(gauge=1435.0, gauge_depth=14.0, rail_inclination=1 / 40)
WHEELSET = WheelsetDimensions(flange_back_distance=1360.0, nominal_radius=460.0, flange_back=-70.0)
WORN_AREA = (60.0, 60.0)  # mm^2, of the sections of rail and wheel
TOLERANCE = 0.003  # mm: rms distance of the smoothed curves from the worn points
SPACING = 0.2  # mm
DECIMALS = 9  # of coordinates [mm]


def unworn() -> Layout:
    """Return the pair before it is worn."""
    rail, wheel = standard("60E1").outline, standard("S1002").outline
    return lay_out((rail, rail), (wheel, wheel), TRACK, WHEELSET)


def worn_pair(law: WearLaw | None = None) -> tuple[Profile, Profile]:
    """Return rail and wheel as points of smoothed curves, worn by a law; by default that of the package."""
    pair = wear(unworn().left, law or WearLaw(), WORN_AREA, SPACING)
    return _smoothed(pair.rail, "60E1-worn"), _smoothed(pair.wheel, "S1002-worn")


def _smoothed(worn: Profile, name: str) -> Profile:
    """Return points of the smoothed curve."""
    points = sampled(prepare(worn, TOLERANCE), SPACING).points
    return Profile(worn.kind, np.round(points, DECIMALS), name)


# --- the files of the package ---

ROUNDING = 1e-6  # mm: between computers


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="compare with the files, write nothing")
    check = parser.parse_args().check
    profiles = {profile.kind: profile for profile in worn_pair()}
    differing = []
    for entry in WORN.values():
        if not check:
            write_profile(profiles[entry.kind], entry.path)
        elif not same(entry.path, profiles[entry.kind].points):
            differing.append(entry.file)
    if differing:
        sys.stderr.write(f"{FOLDER}: {', '.join(differing)}: not by the law; run tools/worn_profiles.py\n")
    return 1 if differing else 0


def same(path: Path, points: np.ndarray) -> bool:
    stored = read_profile(path).points
    return stored.shape == points.shape and bool(np.allclose(stored, points, rtol=0, atol=ROUNDING))


if __name__ == "__main__":
    sys.exit(main())
