"""Opposite points of both surfaces, also where they are farther apart than the lower one is curved."""

import numpy as np
import pytest

from femic.contact.finite_elements.coupling import on_lower, on_upper
from femic.contact.undeformed import Undeformed
from geometries.contours import ellipse
from geometries.surfaces import LOWER, UPPER, Surface

FLANK = 1.3  # rad; the lower contour has a radius of 3.5 mm where its flanks begin


@pytest.mark.parametrize("shift", [0.0, 0.4])
def test_opposite_points_are_opposite_in_both_directions(shift):
    """The wheel rises by 0 to 87 mm above the rail, so distances are up to 25 radii of curvature."""
    wheel = Surface(UPPER, ellipse(13.7, 6.49, FLANK, FLANK), rolling_radius=650.0)
    rail = Surface(LOWER, ellipse(12.97, 6.485, FLANK, FLANK))
    undeformed = Undeformed(wheel, rail, (-14.8, 14.8), shift)
    xi, t = (grid.ravel() for grid in np.meshgrid([0.0, 40.0, 160.0, 340.0], np.linspace(-20, 20, 41)))
    opposite = on_lower(undeformed, np.stack([xi, t]))
    back = on_upper(undeformed, opposite, undeformed.distance(*opposite))
    np.testing.assert_allclose(back, [xi, t], rtol=0, atol=1e-9)
