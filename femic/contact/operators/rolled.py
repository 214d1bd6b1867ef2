"""ICs of a wheel for the slip of rolling: displacements along x as they are seen by the rail.

The local directions of a wheel turn with its surface. A particle that is raised by u_z is nearer to the axle
and passes the contact more slowly, by u_z over the radius R of its rolling circle: in local directions the
slip along x is w_x - du_x/dx + u_z / R. So u_x less the integral of u_z / R along x takes the place of u_x. A
wheel that is moved vertically as a rigid body, for which u_x = u_z x / R, slips as before then. Without that
the slip depends on the rigid-body discount, by M_zz times load over R.
"""

import numpy as np
from scipy.integrate import cumulative_trapezoid

from geometries.arrays import Array
from geometries.grids import Grid
from geometries.patches import N, S, X
from geometries.surfaces import Surface


def rolled(ics: Array, surface: Surface, grid: Grid) -> Array:
    """ICs (n_x, n_s, n_s, 3, 3) at lags >= 0 with which a wheel rolls; those of a prismatic body as they are.

    `surface` is that of the wheel; the strips of `grid` are its own arc lengths. In directions 0 of
    displacements the integral is taken by trapezoids.
    """
    if np.isinf(surface.rolling_radius):
        return ics
    sin, cos = surface.contour.normal(grid.strips)
    radius = surface.circle_radius(grid.strips)
    raised = cos[:, None, None] * ics[..., N, :] - sin[:, None, None] * ics[..., S, :]
    along_x = cumulative_trapezoid(raised / radius[:, None, None], dx=grid.dx, axis=0, initial=0)
    seen = ics.copy()
    seen[..., X, :] -= along_x
    return seen
