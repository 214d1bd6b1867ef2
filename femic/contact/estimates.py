"""Estimates of errors of contact results: from larger elements, and from elements in an uncertain state.

As in Roache's grid convergence index (1994, Journal of Fluids Engineering 116, 405-413), the error of a
number q on elements of size h is taken as

    F d / (2^p - 1),    d = max(|q_h - q_2h|, |q_2h - q_4h| / 4),    p = log2(|q_2h - q_4h| / |q_h - q_2h|),

with his factor F = 1.25 for three grids, and p between 1 and 3/2: edges of the contact, and of where it
sticks, cut elements, and tractions rise from them like square roots, so that no order beyond 3/2 can be
relied on, even if differences show one. Without the third grid p is 1. These errors are partly random, as
edges move from element to element, and a difference may be small by luck. Therefore:

- Each number has a *scale*, of which its differences are shares: the number itself, the largest possible
  contribution of tractions to a force or a moment, or 1 for a share. A force near 0 has no error near 0.
- *Floors* are added: what elements that could be in another state contribute to the number, and the accuracy
  of readings of edges. Where a number has a floor of its own, half of its change counts: both are parts of
  the same error.
- Where a number has none, the largest change of related numbers (a `group`) counts by a share.
- What is left is rounding: tractions are found to `ROUNDING` of the largest pressure. A number that is
  prescribed, or vanishes by symmetry, has nothing else: this is known from the problem (`Measured.exact`),
  never guessed from numbers that agree.

The floor of a quantity is what single elements contribute to it where they could be otherwise: those at the
edge of the contact, those at the border of stick and slip, and, at the leading edge, those that take the
direction of the traction behind them (`LeadingEdge`). Each has the quantity's own lever: an element that
matters to F_y may not matter to M_z. Elements at edges and borders are cut at random, and errors of single
ones add up like random numbers; the turn of the traction that a leading edge misses is the same in all rows,
and is added up with its sign.

Whether an element slides or sticks is uncertain where the deciding quantity could vanish within the element:
the slip of a sliding element, or the distance of a sticking one's traction from its bound, is less than its
change to a neighbour. Elements beside others in another state are always among them. Where elements slide and
none beside them sticks, all of them may be a place of sticking that the grid is too coarse to show. Less than
an element is never seen: where no element is uncertain, the sliding share is known to one of them.

The shares in floors are such that estimates hold in 95 % of random contacts or more. They were found with one
set of these, and checked with another, by `benchmarks/contact_estimates.py`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from femic.contact.patch import Extent
from geometries.arrays import Array, Indices, Mask
from geometries.patches import N

# --- errors from larger elements ---

LEAST_ORDER, MOST_ORDER = 1.0, 1.5
SAFETY = 1.25  # Roache's factor for three grids
RELATED = 0.5  # by which the largest change of related numbers counts
ROUNDING = 1e-6  # of scales, as of tractions over the largest pressure
BESIDE_FLOOR = 0.5  # by which a change counts of a number with a floor of its own

OWN, SHARE = "own", "share"  # scales: the number itself, and 1
Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Kind:
    """How the error of a number is estimated: its scale, by how much changes count, its floors.

    `own`: by which share its own change counts. `related` are groups and by which share of it their largest
    change counts, if that is more. `follows` is a group whose largest change by other ICs counts as well, ""
    for none: readings of edges may lie on the same elements while pressures change.
    """

    group: str
    scale: str = OWN
    related: tuple[tuple[str, float], ...] = ()
    floors: tuple[str, ...] = ()
    own: float = 1.0
    follows: str = ""


PRESSURE = Kind("pressure", floors=("peak",), own=BESIDE_FLOOR)
GIVEN = Kind("approach", floors=("approach",), own=BESIDE_FLOOR)  # load and approach: one is prescribed
# coarse grids have too few elements for readings of edges; these have an accuracy of their own
LENGTH = Kind("extent", floors=("length",), own=0.0, follows="pressure")
WIDTH = Kind("extent", floors=("width",), own=0.0, follows="pressure")
ASPECT = Kind("extent", floors=("length", "width"), own=0.0, follows="pressure")
AREA = Kind("area", floors=("area",), own=BESIDE_FLOOR)
STIFFNESS = Kind("stiffness", floors=("stiffness",), own=BESIDE_FLOOR)
LONGITUDINAL, LATERAL, ABOUT_X, ABOUT_Z, CENTRE = (
    Kind("force", scale, floors=(scale,), own=BESIDE_FLOOR)
    for scale in ("longitudinal", "lateral", "about_x", "about_z", "centre")
)
POSITION = Kind("position", "centre")  # given, or it follows a force
WORK = Kind("work", "work", floors=("work",))
SLIDING = Kind("sliding", SHARE, floors=("sliding",), own=BESIDE_FLOOR)
CREEPAGE = Kind("creepage", "creepage", (("creepage", RELATED),), ("force",))
SLOPE = Kind("slope", floors=("slope",))


@dataclass(frozen=True)
class Scale:
    """The scale on which a number changes, and that on which it is rounded, in its unit."""

    changes: float
    rounds: float


@dataclass(frozen=True)
class Measured:
    """Numbers of a contact, their scales by name of these, and floors, shares of scales, by name of these.

    `exact` are the names of numbers that are prescribed, or vanish by symmetry.
    """

    numbers: Numbers
    scales: Mapping[str, Scale]
    floors: Mapping[str, float]
    exact: Collection[str] = ()

    def scale(self, name: str, kind: Kind) -> Scale:
        """Return the scale of a number."""
        if kind.scale == OWN:
            return Scale(abs(self.numbers[name]), abs(self.numbers[name]))
        return Scale(1.0, 1.0) if kind.scale == SHARE else self.scales[kind.scale]

    def floor(self, name: str, kind: Kind) -> float:
        """Return the sum of the floors of a number, in its unit; 0 of one that is exact."""
        if name in self.exact:
            return 0.0
        return self.scale(name, kind).changes * sum(self.floors[floor] for floor in kind.floors)


def from_grids(fine: float, coarse: float, coarser: float = np.nan) -> float:
    """Return the error of a number on elements of size h, from that on 2h and on 4h; NaN: not known there."""
    near, far = abs(fine - coarse), abs(coarse - coarser)
    if not np.isfinite(far):
        return SAFETY * near / (2**LEAST_ORDER - 1)
    largest = max(near, far / 4)
    if largest == 0:
        return 0.0
    order = np.log2(far / near) if near > 0 and far > 0 else (MOST_ORDER if near == 0 else LEAST_ORDER)
    return float(SAFETY * largest / (2 ** np.clip(order, LEAST_ORDER, MOST_ORDER) - 1))


def estimates(
    measured: Measured, kinds: Mapping[str, Kind], coarse: Numbers, coarser: Numbers | None = None
) -> dict[str, float]:
    """Errors of numbers from those on elements twice and four times as large."""
    scales = {name: measured.scale(name, kind) for name, kind in kinds.items()}
    grids = [measured.numbers, coarse] + ([] if coarser is None else [coarser])
    rows = {name: [numbers[name] for numbers in grids] for name in kinds}
    errors = {name: from_grids(*row) for name, row in rows.items()}
    shares, _ = _pooled(errors, kinds, scales)
    return {
        name: scales[name].rounds * ROUNDING
        + (0.0 if name in measured.exact else scales[name].changes * shares[name])
        + measured.floor(name, kind)
        for name, kind in kinds.items()
    }


def changes(measured: Measured, kinds: Mapping[str, Kind], other: Numbers) -> dict[str, float]:
    """Return the differences to numbers found in another way; related ones count as in estimates."""
    scales = {name: measured.scale(name, kind) for name, kind in kinds.items()}
    away = {name: abs(measured.numbers[name] - other[name]) for name in kinds}
    pooled, largest = _pooled(away, kinds, scales)
    shares = {name: max(pooled[name], largest.get(kind.follows, 0.0)) for name, kind in kinds.items()}
    return {
        name: away[name] if name in measured.exact else max(away[name], scales[name].changes * shares[name])
        for name in kinds
    }


def errors(
    kinds: Mapping[str, Kind],
    fine: Measured | None,
    larger: Sequence[Measured | None],
    others: Sequence[Numbers] = (),
) -> dict[str, float]:
    """Errors of numbers from elements twice and four times as large, and `others`, parts that are added.

    No part makes another one smaller. NaN where nothing is known of the contact, or of elements twice as
    large.
    """
    coarse, coarser = (*larger, None, None)[:2]
    if fine is None or coarse is None:
        return dict.fromkeys(kinds, np.nan)
    by_grids = estimates(fine, kinds, coarse.numbers, None if coarser is None else coarser.numbers)
    return {name: float(sum(part[name] for part in (by_grids, *others))) for name in by_grids}


def _pooled(
    errors: Numbers, kinds: Mapping[str, Kind], scales: Mapping[str, Scale]
) -> tuple[dict[str, float], dict[str, float]]:
    """Return errors as shares of their scales, and the largest share of each group.

    A share is that of related numbers, as far as these count, if it is more; 0 where nothing could change.
    """
    shares = {
        name: error / scales[name].changes if scales[name].changes != 0 else 0.0 * error
        for name, error in errors.items()
    }
    largest = {
        group: float(np.max([shares[name] for name, kind in kinds.items() if kind.group == group]))
        for group in {kind.group for kind in kinds.values()}
    }
    pooled = {
        name: [shares[name] * kind.own, *(part * largest.get(group, 0.0) for group, part in kind.related)]
        for name, kind in kinds.items()
    }
    return {name: float(np.max(candidates)) for name, candidates in pooled.items()}, largest


# --- floors: elements in an uncertain state ---

OF_STATE, OF_WORK, OF_EDGE = 0.1, 0.15, 0.05  # part of tractions on open elements that all may lack
OF_CUT, OF_RUBBED = 0.1, 0.03  # part of the force on an element at the edge: of all of it, of its friction
OF_OPEN, ACROSS = 0.6, 0.2  # part of friction on an open element: of what it contributes, in any direction
OF_FOLLOWERS = 4.0  # turns of the traction from element to element that a leading edge misses
OF_LOAD = 0.03  # part of the load on elements at the edge, of the approach
OF_ACROSS = 0.2  # part of the accuracy of a reading that counts for that across it, if that is finer
OF_PEAK = 0.2  # part of the second differences of pressures at the largest one
OF_SLIDING, OF_TURNING = 1.0, 0.7  # part of the area of open elements in another state: at random, of turning
OF_AREA, OF_STIFFNESS = 0.2, 0.1  # part of the area of elements at the edge that may not be in contact
MIRRORED = 1e-5  # of the largest contribution of an element: as much as tractions are solved to
EDGE = "edge"  # name of the part of elements that are at the edge, beside the floors
NEIGHBOURS = ((1, 0), (-1, 0), (0, 1), (0, -1))
NEARLY = 1 + 1e-9  # beside an element of another state both are the same to rounding


@dataclass(frozen=True, eq=False)
class SlipState:
    """Tractions (n_x, n_s, 3) [MPa] on elements that stick (n_x, n_s) or slip (n_x, n_s, 2).

    `friction` are the coefficients of the strips, (n_s,), or that of all of them; `behind` (n_x, n_s) is how
    many elements behind it the one is whose traction an element follows, None: each has its own.
    """

    p: Array
    stick: Mask
    slip: Array
    friction: Array | float
    behind: Indices | None = None

    @cached_property
    def in_contact(self) -> Mask:
        """The elements in contact."""
        return self.p[..., N] > 0

    @cached_property
    def slides(self) -> Mask:
        """The elements that slide."""
        return self.in_contact & ~self.stick

    @cached_property
    def at_edge(self) -> Mask:
        """The elements at the edge of the contact."""
        return self.in_contact & _beside(~self.in_contact)

    @cached_property
    def open(self) -> Mask:
        """The elements that could be in the other state, of sliding and sticking."""
        size = np.linalg.norm(self.slip, axis=-1)
        inside = np.where(self.in_contact[..., None], self.slip, np.nan)  # no slip is known outside
        margin = self.friction * self.p[..., N] - np.linalg.norm(self.p[..., :N], axis=-1)
        margin = np.where(self.in_contact & self.stick, margin, 0.0)
        could_stick = self.slides & (size <= NEARLY * _change(inside))
        could_slide = self.in_contact & self.stick & (margin <= NEARLY * _change(margin[..., None]))
        return could_stick | could_slide

    @cached_property
    def bound(self) -> Array:
        """The largest tangential tractions [MPa], shape (n_x, n_s)."""
        return np.asarray(self.friction * self.p[..., N])

    @cached_property
    def bound_shares(self) -> Array:
        """Tangential tractions over their bounds, shape (n_x, n_s, 2); 0 where there is none."""
        bound = self.bound[..., None]
        return np.divide(self.p[..., :N], bound, out=np.zeros_like(self.p[..., :N]), where=bound > 0)

    @cached_property
    def missed_turn(self) -> Array:
        """By how much tractions [MPa] that follow others would turn on, shape (n_x, n_s, 2).

        From the element behind the followed one to this the direction turns as much as from there on.
        """
        if self.behind is None:
            return np.zeros_like(self.p[..., :N])
        followed = np.arange(len(self.p))[:, None] - self.behind
        shares, before = self.bound_shares, np.maximum(followed - 1, 0)
        at, earlier = (np.take_along_axis(shares, rows[..., None], axis=0) for rows in (followed, before))
        return (self.behind * self.bound)[..., None] * (at - earlier)

    @cached_property
    def turning(self) -> Mask:
        """Open elements that slide, with none beside them that sticks."""
        return self.open & self.slides & ~_beside(self.in_contact & self.stick)


def floors(tractions: SlipState) -> dict[str, float]:
    """Floors of estimates [shares of scales] of what rests on the state of elements."""
    pressures = tractions.p[..., N]
    area, load = max(int(np.count_nonzero(tractions.in_contact)), 1), max(float(np.sum(pressures)), 1e-300)

    def part(mask: Mask) -> float:
        return float(np.count_nonzero(mask)) / area

    def load_share(mask: Mask) -> float:
        return float(np.sum(pressures[mask])) / load

    could_differ = max(int(np.count_nonzero(tractions.open)), 1)  # less than an element is not seen
    rests_on_state = OF_STATE * load_share(tractions.open) if np.any(tractions.friction) else 0.0
    at_edge = tractions.at_edge
    peak = max(float(np.max(pressures)), 1e-300)
    return {
        "peak": OF_PEAK * _bend_at_peak(pressures) / peak,
        "approach": OF_LOAD * load_share(at_edge),
        "force": rests_on_state + OF_EDGE * load_share(at_edge),
        "work": OF_WORK * rests_on_state / OF_STATE + OF_EDGE * load_share(at_edge),
        "sliding": OF_SLIDING * np.sqrt(could_differ) / area + OF_TURNING * part(tractions.turning),
        "area": OF_AREA * part(at_edge),
        EDGE: part(at_edge),
        "stiffness": OF_STIFFNESS * part(at_edge),  # it grows like the square root of the area
        "slope": OF_STIFFNESS * part(at_edge) + rests_on_state,  # so does the slope of a curve
    }


def _bend_at_peak(pressures: Array) -> float:
    """Return the sum of the second differences along x and s at the largest pressure [MPa]."""
    i, j = np.unravel_index(int(np.argmax(pressures)), pressures.shape)
    around = np.pad(pressures, 1)[i : i + 3, j : j + 3]
    largest = around[1, 1]
    return float(
        abs(2 * largest - around[0, 1] - around[2, 1]) + abs(2 * largest - around[1, 0] - around[1, 2])
    )


def readings(patch: Extent) -> dict[str, float]:
    """Floors of the lengths of a patch along x and s.

    Elements that are coarse along one direction move edges along the other one, too: pressures are theirs.
    """
    half_x, half_s = ((high - low) / 2 for low, high in (patch.x, patch.s))
    along_x, along_s = patch.accuracy_x / max(half_x, 0.5), patch.accuracy_s / max(half_s, 0.5)
    return {
        "length": max(along_x, OF_ACROSS * along_s),
        "width": max(along_s, OF_ACROSS * along_x),
    }


# --- floors and scales of forces and moments ---


@dataclass(frozen=True, eq=False)
class Places:
    """Elements: x (n_x,), y, z (n_s,) [mm], their normals' sine and cosine (n_s,), and area [mm^2]."""

    x: Array
    y: Array
    z: Array
    sin: Array
    cos: Array
    area: float

    @cached_property
    def levers(self) -> Mapping[str, Array]:
        """What tractions contribute to forces and moments, by scale, (n_x, n_s, 3) [mm^2 or mm^3]."""
        x, y, z, sin, cos = self.x[:, None], self.y, self.z, self.sin, self.cos
        components: dict[str, tuple[Array | float, ...]] = {
            "longitudinal": (1.0, 0.0, 0.0),
            "lateral": (0.0, cos, sin),
            "about_x": (0.0, -y * sin - z * cos, y * cos - z * sin),
            "about_z": (-y, x * cos, x * sin),
        }
        shape = len(self.x), len(self.y)
        return {
            name: self.area * np.stack([np.broadcast_to(part, shape) for part in parts], axis=-1)
            for name, parts in components.items()
        }


def floors_of_forces(tractions: SlipState, at: Places) -> dict[str, float]:
    """Floors of forces [N], moments [N mm] and the centre of pressure [mm], by the names of their scales."""
    p, load = tractions.p[..., N], max(float(np.sum(tractions.p[..., N])), 1e-300)
    lever = np.broadcast_to(at.y, p.shape)
    from_centre = (lever - float(np.sum(p * lever)) / load) / load
    centre_lever = np.stack([0 * p, 0 * p, from_centre], axis=-1)
    return {name: _floor(tractions, w, at.cos) for name, w in {**at.levers, "centre": centre_lever}.items()}


def _floor(tractions: SlipState, lever: Array, cos: Array) -> float:
    """Return the floor of the sum of levers times tractions; the load, and so the rest of it, stays."""

    def at_random(parts: Array) -> float:
        """Return the size of a sum of parts with random signs."""
        return float(np.linalg.norm(parts))

    p, at_edge, is_open = tractions.p, tractions.at_edge, tractions.open
    borne = cos * p[..., N]
    force = np.sum(lever * p, axis=-1)
    moved = force - borne * float(np.sum(force)) / max(float(np.sum(borne)), 1e-300)
    rubbed = np.linalg.norm(lever[..., :N], axis=-1) * np.linalg.norm(p[..., :N], axis=-1)
    along = np.abs(np.sum(lever[..., :N] * p[..., :N], axis=-1))
    filled = np.linalg.norm(tractions.bound_shares[is_open], axis=-1)
    return (
        OF_CUT * at_random(moved[at_edge])
        + OF_RUBBED * at_random(rubbed[at_edge])
        + OF_OPEN * at_random(along[is_open] * filled)
        + ACROSS * at_random(rubbed[is_open] * filled)
        + OF_FOLLOWERS * abs(float(np.sum(lever[..., :N] * tractions.missed_turn)))
    )


def vanishing_by_symmetry(p: Array, at: Places) -> set[str]:
    """Return the scales whose numbers vanish because tractions (n_x, n_s, 3) [MPa] are symmetric.

    Then each element contributes the opposite of its mirror image along x, s, or both: this holds for all
    elements, where a sum may be small by chance.
    """
    centre_lever = np.broadcast_to(at.area * at.y, p.shape[:2])[..., None] * [0.0, 0.0, 1.0]
    levers, symmetric = {**at.levers, "centre": centre_lever}, set[str]()
    for name, lever in levers.items():
        parts = np.sum(lever * p, axis=-1)
        largest = float(np.max(np.linalg.norm(lever, axis=-1) * np.linalg.norm(p, axis=-1), initial=0.0))
        mirrored = parts[::-1], parts[:, ::-1], parts[::-1, ::-1]
        if any(np.all(np.abs(parts + other) <= MIRRORED * largest) for other in mirrored):
            symmetric.add(name)
    return symmetric


def scales(pressures: Array, friction: Array | float, at: Places) -> dict[str, Scale]:
    """Scales of forces [N], moments [N mm] and centres [mm] of pressures (n_x, n_s) [MPa].

    `friction` are the coefficients of the strips, (n_s,), or that of all of them.
    Those of changes: friction in any direction on all elements, and pressures as far as their normals and
    levers differ, because the load stays. Rounding is a share of the load, times the largest lever.
    """
    forces = at.area * pressures
    load, x = max(float(np.sum(forces)), 1e-300), at.x[:, None]
    in_contact = forces > 0

    def apart(lever: Array) -> float:
        return float(np.sum(forces * np.abs(lever - np.sum(forces * lever) / load)))

    def frictional(lever: Array | float) -> float:
        return float(np.sum(friction * forces * lever))

    def reach(lever: Array) -> float:
        return float(np.max(np.where(in_contact, lever, 0.0), initial=0.0))

    xs, ys, zs = np.broadcast_arrays(x, at.y, at.z)
    tilt = np.broadcast_to(at.sin, forces.shape)
    about_x, about_z = np.hypot(ys, zs), np.hypot(xs, ys)
    return {
        "longitudinal": Scale(frictional(1.0), load),
        "lateral": Scale(frictional(1.0) + apart(tilt), load),
        "about_x": Scale(frictional(about_x) + apart(at.y * at.cos - at.z * at.sin), load * reach(about_x)),
        "about_z": Scale(frictional(about_z) + apart(x * tilt), load * reach(about_z)),
        "centre": Scale(apart(ys) / load, reach(np.abs(ys))),
    }


# --- neighbours of elements ---


def _beside(mask: Mask) -> Mask:
    """Return elements with a neighbour that is in a mask; outside the grid none is."""
    return np.any([_moved(mask, side, fill=False) for side in NEIGHBOURS], axis=0)


def _change(values: Array) -> Array:
    """Return the largest distance of vectors (n_x, n_s, k) to those of neighbours; NaN ones do not count."""
    away = [np.linalg.norm(values - _moved(values, side, fill=np.nan), axis=-1) for side in NEIGHBOURS]
    return np.asarray(np.max(np.nan_to_num(away), axis=0))


def _moved(values: Array | Mask, side: tuple[int, int], fill: float) -> Array:
    """Return the values of neighbours on one side, shape as of `values`."""
    padded = np.pad(values, [(1, 1), (1, 1), *[(0, 0)] * (values.ndim - 2)], constant_values=fill)
    n_x, n_s = values.shape[:2]
    return np.asarray(padded[1 + side[0] : 1 + side[0] + n_x, 1 + side[1] : 1 + side[1] + n_s])
