"""What tractions that are uniform on elements add to stresses below the centres of elements.

Uniform elements are a staircase, where tractions in truth grow steadily along y by g per length. The
difference is a sawtooth, the sum over n = 1, 2, ... of g h (-1)^n / (pi n) sin(2 pi n y / h), h the side of
elements, y from the centre of an element. Below the centre, at depth z, the half-space's stresses of these
waves add up to, with q = exp(-2 pi z / h), C = 2 g z q / (1 + q), L = (g h / pi) ln(1 + q),

    traction along y:  yy: C - 2 L,  zz: -C,  xx: -2 nu L
    along z: yz: -C;    along x: xy: -L

At the surface that is 0.44 g h in yy: an error that falls only like h. Without it stresses are of second
order. Waves of tractions on a half-plane: Johnson (1985), Contact Mechanics, section 13.2.
"""

import numpy as np

from femic.stresses.points import InnerPoints
from femic.stresses.tractions import SurfaceTractions
from geometries.arrays import Array
from geometries.bodies import Body

Z = 2


def staircase(
    body: Body, tractions: SurfaceTractions, centres: InnerPoints, *, along_x: bool = True
) -> Array:
    """Stresses (n, 3, 3) along x, s, n of the staircase less the steady tractions, below centres (n,).

    Without `along_x` only the steps from strip to strip count.
    """
    to_depth = np.array([1.0, 1.0, body.side])
    grid, p = tractions.grid, np.pad(body.side * tractions.p * to_depth, ((2, 2), (2, 2), (0, 0)))
    i = np.clip(np.rint((centres.x - tractions.x[0]) / grid.dx).astype(int) + 2, 1, grid.n_x + 2)
    j = np.clip(np.rint((centres.s - grid.strips[0]) / grid.ds).astype(int) + 2, 1, grid.n_s + 2)
    steps_x, steps_s = (p[i + 1, j] - p[i - 1, j]) / 2, (p[i, j + 1] - p[i, j - 1]) / 2  # g h, (n, 3)
    stress = np.zeros((len(i), 3, 3))
    for y, x, h, rise in ((0, 1, grid.dx, along_x * steps_x), (1, 0, grid.ds, steps_s)):
        ratio = centres.depth / h
        q = np.exp(-2 * np.pi * ratio)
        C, L = rise * (2 * ratio * q / (1 + q))[:, None], rise * (np.log1p(q) / np.pi)[:, None]
        stress[:, y, y] += C[:, y] - 2 * L[:, y]
        stress[:, x, x] -= 2 * body.material.nu * L[:, y]
        stress[:, Z, Z] -= C[:, y]
        for a, b, value in ((y, Z, C[:, Z]), (x, y, L[:, x])):
            stress[:, a, b] -= value
            stress[:, b, a] -= value
    return np.asarray(stress * np.outer(to_depth, to_depth))
