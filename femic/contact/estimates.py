"""Estimates of errors of contact results, from the same contact on elements twice and four times as large.

As in Roache's grid convergence index (1994, Journal of Fluids Engineering 116, 405-413), the error of a
number q on elements of size h is taken as

    F d / (2^p - 1),    d = max(|q_h - q_2h|, |q_2h - q_4h| / 4),    p = log2(|q_2h - q_4h| / |q_h - q_2h|),

with his factor F = 1.25 for three grids, and p between 1 and 3/2: edges of the contact, and of where it
sticks, cut elements, and tractions rise from them like square roots, so that no order beyond 3/2 can be
relied on, even if differences show one. Without the third grid p is 1. These errors are partly random, as
edges move from element to element, and a difference may be small by luck. Therefore:

- Each number has a *scale*, of which its differences are shares: the number itself, the largest possible
  contribution of tractions to a force or a moment, or 1 for a share. A force near 0 has no error near 0.
- *Floors* are added: what elements that could be in another state contribute to the number
  (`femic.contact.error_floors`), and the accuracy of readings of edges. Where a number has a floor of its
  own, half of its change counts: both are parts of the same error.
- Where a number has none, the largest change of related numbers (a `group`) counts by a share.
- What is left is rounding: tractions are found to `ROUNDING` of the largest pressure. A number that is
  prescribed, or vanishes by symmetry, has nothing else: this is known from the problem (`Measured.exact`),
  never guessed from numbers that agree.

The shares in floors are such that estimates hold in 95 % of random contacts or more. They were found with one
set of these, and checked with another, by `benchmarks/contact_estimates.py`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

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
    shares = _pooled(errors, kinds, scales)
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
    pooled = _pooled(away, kinds, scales)
    largest = _largest({name: _share(away[name], scales[name].changes) for name in kinds}, kinds)
    shares = {name: max(pooled[name], largest.get(kind.follows, 0.0)) for name, kind in kinds.items()}
    return {
        name: away[name] if name in measured.exact else max(away[name], scales[name].changes * shares[name])
        for name in kinds
    }


def summed(parts: Sequence[Numbers]) -> dict[str, float]:
    """Return the sum of independent parts of estimates: none makes another one smaller."""
    return {name: float(sum(part[name] for part in parts)) for name in parts[0]}


def errors(
    kinds: Mapping[str, Kind],
    fine: Measured | None,
    larger: Sequence[Measured | None],
    others: Sequence[Numbers] = (),
) -> dict[str, float]:
    """Errors of numbers from elements twice and four times as large, and `others`, parts that are added.

    NaN where nothing is known of the contact, or of elements twice as large.
    """
    coarse, coarser = (*larger, None, None)[:2]
    if fine is None or coarse is None:
        return dict.fromkeys(kinds, np.nan)
    of_grids = estimates(fine, kinds, coarse.numbers, None if coarser is None else coarser.numbers)
    return summed([of_grids, *others])


def _pooled(errors: Numbers, kinds: Mapping[str, Kind], scales: Mapping[str, Scale]) -> dict[str, float]:
    """Errors as shares of their scales, or the part of the largest of related numbers that counts."""
    shares = {name: _share(error, scales[name].changes) for name, error in errors.items()}
    largest = _largest(shares, kinds)
    return {
        name: float(
            np.max(
                [shares[name] * kind.own] + [part * largest.get(group, 0.0) for group, part in kind.related]
            )
        )
        for name, kind in kinds.items()
    }


def _largest(shares: Numbers, kinds: Mapping[str, Kind]) -> dict[str, float]:
    """Return the largest share of each group."""
    return {
        group: float(np.max([shares[name] for name, kind in kinds.items() if kind.group == group]))
        for group in {kind.group for kind in kinds.values()}
    }


def _share(error: float, scale: float) -> float:
    """Return an error over its scale; 0 where there is nothing that could change."""
    return error / scale if scale != 0 else 0.0 * error
