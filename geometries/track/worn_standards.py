"""The worn pair of the package: wheel S1002 and rail 60E1, inclined 1:40, worn by each other.

`tools/worn_profiles.py` writes it to the files of `geometries.profiles.named`.
"""

import numpy as np

from geometries.profiles.preparation import prepare, sampled
from geometries.profiles.profile import Profile
from geometries.profiles.standards import standard
from geometries.track.layout import Layout, TrackDimensions, WheelsetDimensions, lay_out
from geometries.track.wear import WearLaw, wear

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
