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
- The largest change of related numbers (a `group`) counts by half, where it is larger.
- *Floors* are added for elements that could be in another state, each with its area and its tractions
  (`femic.contact.error_floors`), and for readings of edges.
- What is left is rounding: tractions are found to `ROUNDING` of the largest pressure.

The shares in floors are such that estimates hold in 95 % of random contacts or more. They were found with one
set of these, and checked with another, by `benchmarks/contact_estimates.py`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

LEAST_ORDER, MOST_ORDER = 1.0, 1.5
SAFETY = 1.25  # Roache's factor for three grids
RELATED = 0.5  # by which the largest change of related numbers counts
ROUNDING = 1e-6  # of scales, as of tractions over the largest pressure
SAME = 1e-5  # of scales: numbers that differ less on all grids are prescribed, or vanish by symmetry

OWN, SHARE = "own", "share"  # scales: the number itself, and 1
Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Kind:
    """How the error of a number is estimated: its scale, the numbers to which it is related, its floors.

    `related` are groups and by which share of it their largest change counts. `own`: whether its own change
    counts. `exact`: whether it may be prescribed, or vanish by symmetry; then it is the same on all grids.
    """

    group: str
    scale: str = OWN
    related: tuple[tuple[str, float], ...] = ()
    floors: tuple[str, ...] = ()
    own: bool = True
    exact: bool = False


_PRESSURE, _FORCE = ("pressure", RELATED), ("force", RELATED)
PRESSURE = Kind("pressure", related=(_PRESSURE,))
GIVEN = Kind("pressure", related=(_PRESSURE,), exact=True)  # load and approach: one is prescribed
# coarse grids have too few elements for readings of edges; these have an accuracy of their own
LENGTH = Kind("extent", related=(("pressure", 1.0),), floors=("length",), own=False)
WIDTH = Kind("extent", related=(("pressure", 1.0),), floors=("width",), own=False)
ASPECT = Kind("extent", related=(("pressure", 1.0),), floors=("length", "width"), own=False)
AREA = Kind("area", floors=("area",))
STIFFNESS = Kind("stiffness", related=(_PRESSURE,), floors=("stiffness",))
LONGITUDINAL, LATERAL, ABOUT_X, ABOUT_Z, CENTRE = (
    Kind("force", scale, (_FORCE,), ("force",), exact=True)
    for scale in ("longitudinal", "lateral", "about_x", "about_z", "centre")
)
POSITION = Kind("position", "centre", exact=True)  # given, or it follows a force
WORK = Kind("work", "work", (_FORCE,), ("work",))
SLIDING = Kind("sliding", SHARE, floors=("sliding",))
CREEPAGE = Kind("creepage", "creepage", (("creepage", RELATED),), ("force",))
SLOPE = Kind("slope", floors=("slope",))


@dataclass(frozen=True)
class Scale:
    """The scale on which a number changes, and that on which it is rounded, in its unit."""

    changes: float
    rounds: float


@dataclass(frozen=True)
class Measured:
    """Numbers of a contact, their scales by name of these, and floors, shares of scales, by name of these."""

    numbers: Numbers
    scales: Mapping[str, Scale]
    floors: Mapping[str, float]

    def scale(self, name: str, kind: Kind) -> Scale:
        """Return the scale of a number."""
        if kind.scale == OWN:
            return Scale(abs(self.numbers[name]), abs(self.numbers[name]))
        return Scale(1.0, 1.0) if kind.scale == SHARE else self.scales[kind.scale]


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
        + (
            0.0
            if kind.exact and _same(rows[name], scales[name])
            else scales[name].changes * (shares[name] + sum(measured.floors[floor] for floor in kind.floors))
        )
        for name, kind in kinds.items()
    }


def changes(measured: Measured, kinds: Mapping[str, Kind], other: Numbers) -> dict[str, float]:
    """Return the differences to numbers found in another way; related ones count as in estimates."""
    scales = {name: measured.scale(name, kind) for name, kind in kinds.items()}
    away = {name: abs(measured.numbers[name] - other[name]) for name in kinds}
    pooled = _pooled(away, kinds, scales)
    return {
        name: away[name]
        if kind.exact and _same([measured.numbers[name], other[name]], scales[name])
        else max(away[name], scales[name].changes * pooled[name])
        for name, kind in kinds.items()
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
    largest = {
        group: np.max([shares[name] for name, kind in kinds.items() if kind.group == group])
        for group in {kind.group for kind in kinds.values()}
    }
    return {
        name: float(
            np.max(
                [shares[name] * kind.own] + [part * largest.get(group, 0.0) for group, part in kind.related]
            )
        )
        for name, kind in kinds.items()
    }


def _share(error: float, scale: float) -> float:
    """Return an error over its scale; 0 where there is nothing that could change."""
    return error / scale if scale != 0 else 0.0 * error


def _same(row: Sequence[float], scale: Scale) -> bool:
    """Return whether numbers are the same; two of them, which may be so by luck, to rounding."""
    allowed = SAME if len(row) > 2 else ROUNDING
    return bool(np.nanmax(row) - np.nanmin(row) <= allowed * scale.rounds)
