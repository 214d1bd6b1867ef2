"""Sections of rails and wheels for the tests: closed forms, and smooth ones with a flange."""

from functools import cache

import numpy as np
from scipy.optimize import fsolve

from geometries.profiles.pieces import ArcPiece, Outline
from geometries.profiles.preparation import prepare
from geometries.profiles.profile import Profile
from geometries.track.layout import TrackDimensions, WheelsetDimensions, lay_out

GAUGE, DEPTH, BACKS = 1435.0, 14.0, 1360.0
TRACK = TrackDimensions(GAUGE, DEPTH, False)
WHEELSET = WheelsetDimensions(BACKS, 460.0, -70.0)


def rail_through(points):
    return prepare(Profile("rail", points))


def wheel_through(points):
    return prepare(Profile("wheel", points))


HALF_ANGLE = 0.35  # of arcs [rad]


def arc(radius):
    """An arc whose top is the origin, by arc length from its end at the gauge side."""
    y, z = -radius * np.sin(HALF_ANGLE), radius * (np.cos(HALF_ANGLE) - 1)
    return Outline((ArcPiece((y, z), -HALF_ANGLE, 1 / radius, 2 * HALF_ANGLE * radius),))


def rail_points(width=36.0, height=20.0, tilt=0.0, n=400):
    """An ellipse from an undercut gauge face to the field face, turned by `tilt`."""
    angle = np.linspace(np.pi + 0.15, 0.05, n)
    y, z = width * np.cos(angle), height * np.sin(angle)
    c, s = np.cos(tilt), np.sin(tilt)
    return np.stack([c * y - s * z, s * y + c * z])


def wheel_points(cone=0.05, hollow=1e-4, root=-44.0, width=11.0, *, n=800, end=58.0):
    """A tread with a flange 36 mm deep whose largest slope is near that of 59 degrees."""
    y = np.linspace(-69.0, end, n)
    return np.stack([y, cone * y + hollow * y**2 - 18 * (1 - np.tanh((y - root) / width))])


@cache
def flanged(rail_tilts=(0.0, 0.02), cones=(0.05, 0.04), offset=(0.0, 0.0, 0.0, 0.0)):
    """A layout of flanged wheels on round rails; `offset`: of the origins of rails and wheels (y, z)."""
    rail_offset, wheel_offset = np.array(offset[:2])[:, None], np.array(offset[2:])[:, None]
    rails = [rail_through(rail_points(tilt=tilt) + rail_offset) for tilt in rail_tilts]
    wheels = [wheel_through(wheel_points(cone) + wheel_offset) for cone in cones]
    wheelset = WheelsetDimensions(BACKS, 460.0, -70.0 + offset[2])
    return lay_out(tuple(rails), tuple(wheels), TRACK, wheelset)


def symmetric():
    return flanged((0.01, 0.01), (0.05, 0.05))


class Circles:
    """Arcs on arcs: every number of a small or large shift follows from the centres of the circles.

    The wheels touch the rails of radius R_r at half-distance b, at the angle gamma and the radius r_0.
    """

    def __init__(self, R_w=500.0, R_r=300.0, gamma=0.04, r_0=460.0):
        self.R_w, self.R_r, self.gamma, self.r_0 = R_w, R_r, gamma, r_0
        self.m = GAUGE / 2 + np.sqrt(2 * R_r * DEPTH - DEPTH**2)  # half-distance of the rails' centres
        self.b = self.m - R_r * np.sin(gamma)
        back = BACKS / 2 - self.b - R_w * np.sin(gamma)
        self.dimensions = WheelsetDimensions(BACKS, r_0, back, self.b - BACKS / 2)

    @cache  # noqa: B019
    def layout(self):
        rail, wheel = arc(self.R_r), arc(self.R_w)
        return lay_out((rail, rail), (wheel, wheel), TRACK, self.dimensions)

    def linkage(self, shift):
        """Roll, height and both contact angles from the distances of the centres: an independent route."""
        W = np.array([self.b + self.R_w * np.sin(self.gamma), -self.r_0 - self.R_w * np.cos(self.gamma)])

        def links(state):
            roll, height = state
            c, s = np.cos(roll), np.sin(roll)
            left = np.array([c * W[0] - s * W[1] + shift, s * W[0] + c * W[1] + height])
            right = np.array([-c * W[0] - s * W[1] + shift, -s * W[0] + c * W[1] + height])
            return [self.m, -self.R_r] - left, [-self.m, -self.R_r] - right

        def lengths(state):
            return [np.hypot(*link) - (self.R_w - self.R_r) for link in links(state)]

        state = fsolve(lengths, [0.0, self.r_0], xtol=1e-12)
        left, right = links(state)
        return (*state, np.arctan2(-left[0], left[1]), np.arctan2(right[0], right[1]))


class Cone:
    """Cones of the angle gamma on arcs of radius R_r; nominal radius r_0 on the tape circle."""

    def __init__(self, R_r=300.0, gamma=0.05, r_0=460.0):
        self.R_r, self.gamma, self.r_0 = R_r, gamma, r_0
        self.m = GAUGE / 2 + np.sqrt(2 * R_r * DEPTH - DEPTH**2)

    @cache  # noqa: B019
    def layout(self):
        y = np.linspace(-71.0, 60.0, 9)
        wheel = wheel_through(np.stack([y, np.tan(self.gamma) * y]))
        rail = arc(self.R_r)
        return lay_out((rail, rail), (wheel, wheel), TRACK, WHEELSET)


@cache
def polygon(curve, n):
    """Parameters (n,) and points (2, n) of a curve of a layout."""
    t = np.linspace(*curve.limits, n)
    return t, curve.position(t)


def brute_gaps(layout, position, side, n=30001):
    """y, vertical gaps between polygons of n points, and the points of the rail's polygon: (n,), (n,)."""
    sign, own = (1, layout.left) if side == "left" else (-1, layout.right)
    t_rail, (rail_y, rail_z) = polygon(own.rail, n)
    _, (y, z) = polygon(own.wheel, n)
    c, s = np.cos(sign * position.roll), np.sin(sign * position.roll)
    y, z = c * y - s * z + sign * position.shift, s * y + c * z + position.height
    return t_rail, np.interp(rail_y, y, z, left=np.inf, right=np.inf) - rail_z
