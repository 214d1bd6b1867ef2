"""The rigid-body discount: the rigid motion that a far support allows, and its subtraction.

Far from the contact a load moves the body rigidly. D[I, J], the displacement at I by the rigid motion that a
unit load at J causes, is subtracted from the displacements. M is the compliance of these motions, one
symmetric matrix per body: under forces along x, y, z and a moment about the x axis, all at the contact
centre. On a prismatic body D = Phi(I)^T M Phi(J), where Phi takes a unit load to these forces and this
moment.

The rigid motions of a body of revolution must look the same from all positions along x. Five of them do: a
translation in the plane of rolling, alike in x and z (M_zz); a spin about the axle, which moves each point
along x in proportion to its radius (M_xx - M_zz at the contact centre); a translation along y; a tilt of the
axle, alike about x and z (M_yphi / R_roll); a tilt that comes with the first translation (M_yz / R_roll).
With these, D is rigid for each load, reciprocal, and a function of the lag. M has two more entries, phi-phi
and z-phi. The tilts of the axle cover a part of them; the rest turns the load's section about its contact
centre. Seen from another position this turn is rigid except for a translation along y, the turn times the
height of the observer's contact centre over the load's. This translation is left out: with it, D would not be
reciprocal, or loads at the contact centre would depend on phi-phi. Source: [BVSV] section 5.1;
docs/theory/discount.md.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from femic.reference.models import Points
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.patches import Load, X

FX, FY, FZ, MOMENT = range(4)  # rows and columns of M; the first generalized forces
TURN, SPIN = 4, 5  # further generalized forces: a moment about z, a moment about the axle
Entry = tuple[int, int]
# entries of M that are not always 0
ENTRIES: tuple[Entry, ...] = (
    (FX, FX),
    (FY, FY),
    (FZ, FZ),
    (FY, MOMENT),
    (FY, FZ),
    (MOMENT, MOMENT),
    (FZ, MOMENT),
)
AXES = ("x", "y", "z", "phi")


@dataclass(frozen=True)
class Condition:
    """One equation for M: `measure` of the displacements (3, n_points) under `loads` must be `target`."""

    entry: Entry  # the entry of M that it determines
    loads: tuple[Load, ...]
    measure: Callable[..., float]
    target: float


class Rule(Protocol):
    """The observers and conditions that determine M (`discount_rules`)."""

    def points(self, body: Body) -> Points:
        """All observers that conditions may read."""
        ...

    def conditions(self, body: Body, loads: Sequence[Load]) -> list[Condition]:
        """The conditions that determine the entries of M for the given loads."""
        ...

    def observers(self, body: Body, fit: Sequence[Condition]) -> Points:
        """The first of `points`, as many as the given conditions read."""
        ...


def rigid_part(m: Array, body: Body, points: Points, load: Load) -> Array:
    """D [mm/N] of a unit load at the points, shape (3, n)."""
    return discount(m, motions(body, points, load.patch.s))[:, load.direction]


def discount(m: Array, unit: Array, entries: Sequence[Entry] = ENTRIES) -> Array:
    """D [mm/N] of a body whose compliance is M, from its `motions` (`unit`), shape (3, 3, n).

    Only some `entries` of M count.
    """
    return np.tensordot(np.array([m[entry] for entry in entries]), unit, axes=1)


def motions(body: Body, points: Points, s_load: float, entries: Sequence[Entry] = ENTRIES) -> Array:
    """D between points and a load at arc length s_load [mm], per unit of some entries of M.

    Shape (len(entries), 3, 3, n); x and s of the points may also have shapes that broadcast together.
    """
    surface = body.surface
    xi = surface.chart_x(points.x, points.s, s_load)
    s_loads = np.full_like(points.s, s_load, dtype=float)
    seen = generalized(body, xi / 2, points.s), generalized(body, -xi / 2, s_loads)  # seen from half way

    def product(a: int, b: int) -> Array:
        return _outer(seen[0][a], seen[1][b])

    def mutual(a: int, b: int) -> Array:
        return product(a, b) + product(b, a)

    @cache
    def turns() -> tuple[Array, Array]:
        return _section_turns(body, points.s, s_loads, xi / body.rolling_radius)

    def tilt() -> Array:
        return product(MOMENT, MOMENT) + product(TURN, TURN) - turns()[0]

    def tilt_with_z() -> Array:
        return mutual(FZ, MOMENT) - mutual(FX, TURN) - turns()[1]

    lean = body.side / body.rolling_radius
    by_entry: dict[Entry, Callable[[], Array]] = {
        (FX, FX): lambda: product(SPIN, SPIN),
        (FY, FY): lambda: product(FY, FY),
        (FZ, FZ): lambda: product(FX, FX) + product(FZ, FZ) - product(SPIN, SPIN),
        (FY, MOMENT): lambda: mutual(FY, MOMENT) + lean * tilt(),
        (FY, FZ): lambda: mutual(FY, FZ) + lean * tilt_with_z(),
        (MOMENT, MOMENT): lambda: turns()[0],
        (FZ, MOMENT): lambda: turns()[1],
    }
    unit = np.empty((len(entries), *product(FX, FX).shape))
    for motion, entry in zip(unit, entries, strict=True):
        motion[...] = by_entry[entry]()
    return unit


def generalized(body: Body, xi: ArrayLike, s: ArrayLike) -> Array:
    """Generalized forces of unit loads in the local directions at (xi, s) [mm], shape (6, 3, n).

    They are forces along x, y, z, moments [mm] about x and z through the contact centre at xi = 0, and the
    moment about the axle over the moment of a unit force along x at the contact centre.
    """
    surface = body.surface
    force = np.swapaxes(surface.axes(xi, s), 0, 1)  # (component, direction, n)
    moment = np.cross(surface.position(xi, s)[:, None], force, axis=0)
    spin = np.zeros_like(force[:1])
    spin[:, X] = 1 - body.side * body.contour.position(s)[1] / body.rolling_radius
    return np.concatenate([force, moment[:1], moment[2:], spin])


def _section_turns(body: Body, s: Array, s_load: Array, angle: Array) -> tuple[Array, Array]:
    """Displacements by turns of sections about their contact centres, shape (3, 3, n) each.

    The first turns are caused by moments about the contact centre, the second by forces along z. An observer
    at an angle about the axle [rad] sees the turn of the load's section as a turn about x and one about z.
    """
    observer, load = (_in_own_section(body, arc_length) for arc_length in (s, s_load))
    sin, cos = np.sin(angle), np.cos(angle)
    turned_moment = cos * observer.moment + sin * observer.lever
    load_moment_seen = cos * load.moment - sin * load.lever
    turned = _outer(turned_moment, load.moment) - _outer(observer.moment, sin * load.lever)
    return turned, _outer(turned_moment, load.radial) + _outer(observer.radial, load_moment_seen)


def _outer(of_observer: Array, of_load: Array) -> Array:
    """Products (3, 3, n) of values (3, n) at observers and at loads."""
    return of_observer[:, None] * of_load[None]


@dataclass(frozen=True)
class _InSection:
    """Unit loads x, s, n in their own section: moment about x at its contact centre and force along z.

    `lever` is y [mm] of a load along x, with the sign of the turn about z that it sees. Shapes: (3, n) each.
    """

    moment: Array
    radial: Array
    lever: Array


def _in_own_section(body: Body, s: Array) -> _InSection:
    """Moment, force and lever of unit loads at arc lengths s [mm]."""
    forces = generalized(replace(body, rolling_radius=np.inf, hub_radius=None), np.zeros_like(s), s)
    lever = np.zeros_like(forces[0])
    lever[X] = body.side * body.contour.position(s)[0]
    return _InSection(forces[MOMENT], forces[FZ], lever)


def fit_discount(body: Body, rule: Rule, fit: Sequence[Condition], u: Mapping[Load, Array]) -> Array:
    """M [mm/N, 1/N, 1/(N mm)], shape (4, 4), from displacements (3, n) [mm/N] at the observers.

    Entries that no condition determines are 0.
    """
    if not fit:
        return np.zeros((4, 4))
    points = rule.points(body)
    entry_matrices = [_symmetric_entry(condition.entry) for condition in fit]
    matrix = [
        [
            condition.measure(*(rigid_part(entry, body, points, load) for load in condition.loads))
            for entry in entry_matrices
        ]
        for condition in fit
    ]
    defects = [
        condition.measure(*(u[load] for load in condition.loads)) - condition.target for condition in fit
    ]
    return np.asarray(np.tensordot(np.linalg.solve(matrix, defects), entry_matrices, axes=1))


def _symmetric_entry(entry: Entry) -> Array:
    """The matrix (4, 4) with 1 at an entry and its transpose, 0 elsewhere."""
    m = np.zeros((4, 4))
    m[entry] = m[entry[::-1]] = 1.0
    return m
