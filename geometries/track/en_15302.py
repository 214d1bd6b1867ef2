"""The reference cases of EN 15302: profiles of wheels and of a rail, and their equivalent conicities.

The norm gives the profiles as arcs and lines (2021, annex I; z downwards there, upwards here), and the
conicities of nine pairs, without roll of the wheelset (annexes J, K). Pieces do not all meet: wheels have
edges of 45 degrees at y = 60 mm, of 10 degrees in the grooves of H, and of 0.2 degrees at y = -29.9 mm of I.
"""

from dataclasses import dataclass
from math import sqrt
from typing import Literal

import numpy as np

from geometries.arrays import Array
from geometries.profiles.pieces import ArcPiece, Outline, arc_above, arc_below, line
from geometries.track.layout import Layout, TrackDimensions, WheelsetDimensions, lay_out
from geometries.track.wheelset import RollRule, over_shifts

TRACK = TrackDimensions(gauge=1435.16, gauge_depth=14.0, rail_inclination=False)
FLANGE_BACKS, FLANGE_BACK = 1360.0, -70.0  # mm
RADII, UNEQUAL = (460.0, 460.0), (459.0, 460.0)  # mm: left, right

Letter = Literal["A", "B", "H", "I"]


def crown(y: tuple[float, float], y_centre: float, z_centre: float, radius: float) -> ArcPiece:
    """An arc z = z_centre - sqrt(radius^2 - (y - y_centre)^2) of the norm [mm]: its centre lies below."""
    return arc_above((y_centre, -z_centre), radius, y)


def groove(y: tuple[float, float], y_centre: float, z_centre: float, radius: float) -> ArcPiece:
    """An arc z = z_centre + sqrt(radius^2 - (y - y_centre)^2) of the norm [mm]: its centre lies above."""
    return arc_below((y_centre, -z_centre), radius, y)


def straight(y: tuple[float, float], z_0: float, slope: float) -> ArcPiece:
    """A line z = z_0 + slope y of the norm [mm]."""
    return line((y[0], -z_0 - slope * y[0]), (y[1], -z_0 - slope * y[1]))


RAIL = Outline(
    (
        crown((-32.6340, -23.2401), -19.63949, 15.899044, 13.0),
        crown((-23.2401, -7.8749), -1.0825, 80.277908, 80.0),
        crown((-7.8749, 13.0989), 17.5966, 299.48349, 300.0),
        crown((13.0989, 28.6709), 14.29829, 79.508225, 80.0),
        crown((28.6709, 39.2705), 26.33535, 13.598369, 13.0),
    )
)
WHEELS: dict[Letter, Outline] = {
    "A": Outline(
        (
            groove((-70.0, -62.7647), -49.5, 9.51926, 20.5),
            groove((-62.7647, -49.6625), -55.0, 16.00065, 12.0),
            groove((-49.6625, -39.7645), -58.5583, 8.83556, 20.0),
            straight((-39.7645, -38.7372), -93.57685, -2.7475),
            crown((-38.7372, -29.4591), -25.5816, 17.64215, 14.0),
            crown((-29.4591, -10.8749), -2.6594, 97.16493, 96.76055),
            crown((-10.8749, 18.4173), 18.4173, 344.50806, 345.0),
            straight((18.4173, 30.0), -0.49194, 0.0),
            straight((30.0, 60.0), 1.50804, -0.066666),
            straight((60.0, 65.0), 57.50808, -1.0),
        )
    ),
    "B": Outline(
        (
            groove((-70.0, -62.7647), -49.5, 9.5193, 20.5),
            groove((-62.7647, -49.6625), -55.0, 16.0, 12.0),
            groove((-49.6625, -39.7640), -58.5583, 8.8349, 20.0),
            straight((-39.7640, -38.7879), -93.5767, -2.7475),
            crown((-38.7879, -29.3505), -25.6322, 17.7814, 14.0),
            crown((-29.3505, -0.4787), 2.5204, 119.9745, 120.0),
            straight((-0.4787, 30.0), 0.0, -0.025),
            straight((30.0, 60.0), 0.75, -0.05),
            straight((60.0, 65.0), 57.75, -1.0),
        )
    ),
    "H": Outline(
        (
            groove((-70.0, -62.7647), -49.5, 9.5193, 20.5),
            groove((-62.7647, -49.6625), -55.0, 16.0, 12.0),
            groove((-49.6625, -39.7645), -58.5583, 8.8349, 20.0),
            straight((-39.7645, -38.7220), -93.5767, -2.7475),
            crown((-38.7220, -28.3119), -25.5663, 17.6003, 14.0),
            straight((-28.3119, -10.2297), -1.7902, -0.2),
            straight((-10.2297, 30.0), 0.0, -0.025),
            straight((30.0, 60.0), 1.251, -0.0667),
            straight((60.0, 65.0), 57.249, -1.0),
        )
    ),
    "I": Outline(
        (
            groove((-70.0, -62.7647), -49.5, 9.51929, 20.5),
            groove((-62.7647, -49.6625), -55.0, 16.00054, 12.0),
            groove((-49.6625, -39.7640), -58.5583, 8.83545, 20.0),
            straight((-39.7640, -39.0486), -93.5767, -2.7475),
            crown((-39.0486, -29.9231), -25.8929, 18.49733, 14.0),
            crown((-29.9231, 5.0), 5.0, sqrt(14375), 120.0),
            straight((5.0, 30.0), sqrt(14375) - 120, 0.0),
            straight((30.0, 60.0), 1.89679, -0.0667),
            straight((60.0, 65.0), 57.89479, -1.0),
        )
    ),
}


@dataclass(frozen=True)
class Case:
    """Wheels (left, right) on the rail, their radii [mm], and the norm's conicity by amplitude [mm]."""

    wheels: tuple[Letter, Letter]
    radii: tuple[float, float]
    conicity: dict[float, float]

    @property
    def layout(self) -> Layout:
        """The wheelset on its track."""
        left, right = self.wheels
        wheelset = WheelsetDimensions(FLANGE_BACKS, self.radii, FLANGE_BACK)
        return lay_out((RAIL, RAIL), (WHEELS[left], WHEELS[right]), TRACK, wheelset)

    def differences(self, roll: float | RollRule = 0.0) -> tuple[Array, Array]:
        """Rolling-radius differences at shifts [mm] 0.1 mm apart, the norm's largest step, and at jumps."""
        reach = 7.3 if self.radii == RADII else 8.4  # unequal wheels run about a shift of their own
        count = round(reach / 0.1)
        return over_shifts(
            self.layout, np.linspace(-reach, reach, 2 * count + 1), roll=roll
        ).rolling_radius_differences()


def _by_amplitude(*values: float) -> dict[float, float]:
    """Conicities at 1, 2, ..., 7 mm."""
    return dict(zip(map(float, range(1, 8)), values, strict=True))


CASES = {
    "E1": Case(("A", "A"), RADII, _by_amplitude(0.125, 0.155, 0.188, 0.216, 0.254, 0.303, 0.505)),
    "E2": Case(("B", "B"), RADII, _by_amplitude(0.025, 0.025, 0.030, 0.236, 0.280, 0.300, 0.484)),
    "E3": Case(("H", "H"), RADII, _by_amplitude(0.025, 0.025, 0.260, 0.323, 0.307, 0.284, 0.448)),
    "E4": Case(("I", "I"), RADII, _by_amplitude(0.0, 0.301, 0.493, 0.488, 0.476, 0.448, 0.490)),
    "E5": Case(("A", "A"), UNEQUAL, _by_amplitude(0.280, 0.272, 0.261, 0.269, 0.307, 0.395, 0.491)),
    "E6": Case(("B", "B"), UNEQUAL, _by_amplitude(0.667, 0.377, 0.278, 0.228, 0.289, 0.407, 0.472)),
    "E7": Case(("H", "H"), UNEQUAL, _by_amplitude(0.713, 0.380, 0.270, 0.223, 0.278, 0.423, 0.443)),
    "E8": Case(("I", "I"), UNEQUAL, _by_amplitude(0.781, 0.418, 0.454, 0.481, 0.459, 0.498, 0.564)),
    "E9": Case(("B", "A"), RADII, _by_amplitude(0.136, 0.104, 0.124, 0.222, 0.270, 0.306, 0.490)),
}


def tolerance(conicity: float) -> float:
    """The norm's tolerance of a conicity."""
    return min(0.05, conicity / 2)
