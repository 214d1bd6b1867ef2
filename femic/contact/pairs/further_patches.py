"""Places beyond a grid at which two bodies touch, too, under the approach that a contact on the grid has."""

import numpy as np

from femic.contact.exact.hertz import combined_modulus
from femic.contact.normal import NormalContact
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.resultants import centre_of_pressure
from femic.contact.undeformed import SAMPLES
from geometries.arrays import Array


def touching_beyond(on_grid: PairOnGrid, contact: NormalContact) -> Array:
    """Return arc lengths [mm] beyond the ends of a grid at which the bodies would overlap, (n,).

    There the undeformed distance at x = 0 is less than the approach and the displacement of both surfaces, as
    half-spaces have it at a distance from the load of the contact.
    """
    (start, end), grid = on_grid.undeformed.s_range, on_grid.grid
    s = np.linspace(start, end, SAMPLES)
    s = s[(s < grid.extent[0]) | (s > grid.extent[1])]
    if not s.size:
        return s
    extra = 0.0 if on_grid.extra_gap is None else on_grid.extra_gap.at(np.zeros(1), s)
    distance = on_grid.undeformed.distance(0.0, s) + extra
    cosine = np.cos(on_grid.undeformed.lower.contour.inclination(s))
    modulus = combined_modulus(on_grid.pair.upper.material, on_grid.pair.lower.material)
    away = np.abs(s - centre_of_pressure(contact.p, grid.strips))
    displacement = float(np.sum(contact.p)) * grid.area / (np.pi * modulus * away)
    return np.asarray(s[contact.approach * cosine - distance > displacement])
