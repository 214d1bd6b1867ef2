"""The rigid-body discount: what a far support adds to the displacements, and its subtraction.

Far from the contact a body moves rigidly, by a symmetric compliance. D[I, J] = Phi(I)^T M Phi(J) is
subtracted: Phi(J) carries a unit load at J to its wrench (forces along x, y, z and the moment about
the x axis through the contact centre), Phi(I)^T a rigid motion to the local displacement at I. M is
one symmetric matrix per body, so reciprocity is kept. Source: [BVSV] section 5.1, design section 4.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from approx.variants import approximate
from femic.solid import Points, local_axes
from femic.symmetry import N, S, X
from geometries.bodies import PrismaticBody
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.materials import one_body
from geometries.patches import Patch

Array = NDArray[np.float64]

FX, FY, FZ, MOMENT = range(4)
AXES = ("x", "y", "z", "phi")
ELEMENTS_AWAY = 3  # centre to centre, where C_jj must equal A_jj


@dataclass(frozen=True)
class Condition:
    """One equation for M: `measure` of the discounted ICs (3, 3, 3) must equal `target`."""

    entry: tuple[int, int]  # the entry of M that it determines
    load: int
    measure: Callable[[Array], float]
    target: float


def discount_points(patch: Patch, rotation_reach: float) -> Points:
    """Where the raw ICs must be known to fit M: three elements along x, and s = +-reach at x = 0."""
    x = np.array([ELEMENTS_AWAY * 2 * patch.a, 0.0, 0.0])
    return Points(x, np.array([0.0, rotation_reach, -rotation_reach]))


def wrench(contour: Contour, s: Array) -> Array:
    """Phi: wrench of unit loads in the local directions at arc length s, shape (4, 3, *s.shape)."""
    s = np.asarray(s, dtype=float)
    y, z = contour.position(s)
    force = np.swapaxes(local_axes(contour, s), 0, 1)  # (component, direction, ...)
    return np.concatenate([force, (y * force[2] - z * force[1])[None]])


def rigid_part(m: Array, contour: Contour, s_observer: Array, s_load: float) -> Array:
    """D = Phi(I)^T M Phi(J) [mm/N] at observers s_observer (n,), shape (3, 3, n)."""
    observer = wrench(contour, s_observer)
    return np.einsum("aip,ab,bj->ijp", observer, m, wrench(contour, np.array(s_load)))


def loads_needed(contour: Contour, directions: tuple[int, ...]) -> tuple[int, ...]:
    """Load directions to solve: where the section has no symmetry, s and n are discounted together."""
    if contour.symmetric or not set(directions) & {S, N}:
        return directions
    return tuple(sorted({*directions, S, N}))


def fit_discount(
    body: PrismaticBody, patch: Patch, points: Points, raw: Array, directions: tuple[int, ...]
) -> Array:
    """M [mm/N, 1/N, 1/(N mm)], shape (4, 4), from raw ICs (3, 3, 3) per unit load at s = 0.

    `points` are those of `discount_points`. C_jj = A_jj three elements away; under the lateral load
    u_z(reach) - u_z(-reach) equals that of A_ns on a plane. In sections without symmetry also: the
    same difference vanishes under the normal load, and C_sn + C_ns does three elements away. Entries
    that concern loads which were not solved are 0.
    """
    if patch.s != 0:
        raise WrongInput(f"patch.s = {patch.s:g} mm: the discount is fitted to loads at s = 0 only")
    conditions = [c for c in _conditions(body, patch, points) if c.load in directions]
    entries = [_symmetric_entry(c.entry) for c in conditions]
    rigid = [rigid_part(entry, body.contour, points.s, 0.0) for entry in entries]
    matrix = np.array([[c.measure(d) for d in rigid] for c in conditions])
    defects = np.array([c.measure(raw) - c.target for c in conditions])
    return np.asarray(np.tensordot(np.linalg.solve(matrix, defects), entries, axes=1))


def _conditions(body: PrismaticBody, patch: Patch, points: Points) -> list[Condition]:
    constants = one_body(body.material, body.side)
    a = approximate("A", constants, body.contour, patch, (points.x, points.s)) / patch.area
    to_vertical = local_axes(body.contour, points.s)[:, FZ]  # (3 directions, 3 points)

    def tilt(ic: Array, load: int) -> float:
        """u_z(reach) - u_z(-reach) at x = 0."""
        u_z = np.sum(to_vertical * ic[:, load], axis=0)
        return float(u_z[1] - u_z[2])

    def coupling(ic: Array) -> float:
        return float(ic[S, N, 0] + ic[N, S, 0])

    conditions = [
        Condition((FX, FX), X, lambda ic: float(ic[X, X, 0]), float(a[X, X, 0])),
        Condition((FY, FY), S, lambda ic: float(ic[S, S, 0]), float(a[S, S, 0])),
        Condition((FZ, FZ), N, lambda ic: float(ic[N, N, 0]), float(a[N, N, 0])),
        Condition((FY, MOMENT), S, lambda ic: tilt(ic, S), float(a[N, S, 1] - a[N, S, 2])),
    ]
    if not body.contour.symmetric:
        conditions += [
            Condition((FZ, MOMENT), N, lambda ic: tilt(ic, N), 0.0),
            Condition((FY, FZ), N, coupling, 0.0),
        ]
    return conditions


def _symmetric_entry(entry: tuple[int, int]) -> Array:
    m = np.zeros((4, 4))
    m[entry] = m[entry[::-1]] = 1.0
    return m
