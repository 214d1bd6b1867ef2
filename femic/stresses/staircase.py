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

    Without `along_x` only the steps from strip to strip count, and points may lie anywhere along x.
    """
    to_depth, grid = np.array([1.0, 1.0, body.side]), tractions.grid
    steps_x, steps_s = _steps(tractions, centres)
    stress = np.zeros((len(centres.x), 3, 3))
    for y, x, h, steps in ((0, 1, grid.dx, along_x * steps_x), (1, 0, grid.ds, steps_s)):
        rise = body.side * steps * to_depth  # g h
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


def _steps(tractions: SurfaceTractions, centres: InnerPoints) -> tuple[Array, Array]:
    """Mean steps to the next elements along x and along s [MPa], (n, 3) each; 0 beyond the grid."""
    grid, p = tractions.grid, np.pad(tractions.p, ((3, 4), (3, 3), (0, 0)))
    place = np.clip((centres.x - tractions.x[0]) / grid.dx + 3, 1, grid.n_x + 4)
    i = np.floor(place).astype(int)
    share = (place - i)[:, None]
    j = np.clip(np.rint((centres.s - grid.strips[0]) / grid.ds).astype(int) + 3, 1, grid.n_s + 4)

    def at(along_x: int, along_s: int) -> Array:
        return (1 - share) * p[i + along_x, j + along_s] + share * p[i + 1 + along_x, j + along_s]

    return (at(1, 0) - at(-1, 0)) / 2, (at(0, 1) - at(0, -1)) / 2
