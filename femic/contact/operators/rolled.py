"""ICs of a wheel for the slip of rolling: displacements along x as the rail sees them.

The local directions of a wheel rotate with its surface. A particle that is raised by u_z is nearer to the
axle and passes the contact more slowly, by u_z over the radius R of its rolling circle: in local directions
the slip along x is w_x - du_x/dx + u_z / R. So u_x less the integral of u_z / R along x takes the place of
u_x. Then a rigid vertical motion of the wheel, for which u_x = u_z x / R, does not change the slip; otherwise
the slip would depend on the rigid-body discount, by M_zz times load over R.
"""

import numpy as np
from scipy.integrate import cumulative_trapezoid

from geometries.arrays import Array
from geometries.grids import Grid
from geometries.patches import N, S, X
from geometries.surfaces import Surface


def rolled(ics: Array, surface: Surface, grid: Grid) -> Array:
    """Return ICs (n_x, n_s, n_s, 3, 3) at lags >= 0 as the slip needs them; prismatic bodies keep theirs.

    `surface` belongs to the wheel; the strips of `grid` are its own arc lengths. The integral along x is
    computed by the trapezoidal rule.
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
