"""Wheelsets of arcs and cones on arcs, in place on their tracks."""

from functools import cache

import numpy as np

from femic.shifts.specification import ProfileTable, WheelTable
from geometries.materials import Material
from geometries.profiles.pieces import ArcPiece, Outline, arc_above, line
from geometries.profiles.preparation import prepare
from geometries.profiles.profile import Profile
from geometries.track.layout import TrackDimensions, WheelsetDimensions, lay_out

R_R, R_W, R_0, GAMMA = 80.0, 110.0, 460.0, 0.06  # radii of rail, wheel and tape circle [mm]; angle [rad]
HALF = 0.5  # rad of the arcs
RAIL, WHEEL = ProfileTable(profile="60E1"), WheelTable(profile="S1002")  # for their materials alone
STEEL = Material(RAIL.E, RAIL.nu)


def arc_points(radius, n):
    """Points of an arc whose top is the origin."""
    angle = np.linspace(-HALF, HALF, n)
    return radius * np.stack([np.sin(angle), np.cos(angle) - 1])


@cache
def arcs_on_arcs(kind="points", n=400):
    """Arcs on arcs that touch at the angle GAMMA without shift."""
    m = 1435 / 2 + np.sqrt(2 * R_R * 8 - 8**2)  # half-distance of the rails' centres; gauge 8 mm deep
    b = m - R_R * np.sin(GAMMA)
    back = 680 - b - R_W * np.sin(GAMMA)
    if kind == "points":
        rail = prepare(Profile("rail", arc_points(R_R, n)))
        wheel = prepare(Profile("wheel", arc_points(R_W, n)))
    else:
        rail, wheel = (
            Outline((ArcPiece(tuple(arc_points(radius, 2)[:, 0]), -HALF, 1 / radius, 2 * HALF * radius),))
            for radius in (R_R, R_W)
        )
    wheelset = WheelsetDimensions(1360.0, R_0, back, b - 680)
    return lay_out((rail, rail), (wheel, wheel), TrackDimensions(1435.0, 8.0, False), wheelset)


@cache
def cones_on_arcs(rail_radius=300.0, slope=1 / 20):
    """Cones whose flange back is at y = -70 on rails of one arc."""
    rail = Outline((arc_above((0.0, -rail_radius), rail_radius, (-100.0, 100.0)),))
    wheel = Outline((line((-70.0, -70.0 * slope), (60.0, 60.0 * slope)),))
    wheelset = WheelsetDimensions(1360.0, R_0, -70.0)
    return lay_out((rail, rail), (wheel, wheel), TrackDimensions(1435.0, 14.0, False), wheelset)


def bumpy(lower):
    """A layout of cylinders on rails with two bumps; the second one is `lower` [mm] by so much."""
    y = np.linspace(-30, 30, 1201)
    bumps = 3 * np.exp(-(((y + 12) / 9) ** 2)) + (3 - lower) * np.exp(-(((y - 12) / 9) ** 2)) - 0.02 * y**2
    rail = prepare(Profile("rail", np.stack([y, bumps])))
    wheel = prepare(Profile("wheel", np.stack([np.linspace(-70, 60, 131), np.zeros(131)])))
    track = TrackDimensions(1435.0, 3.0, False)
    return lay_out((rail, rail), (wheel, wheel), track, WheelsetDimensions(1360.0, 460.0, -70.0, 72.0))
