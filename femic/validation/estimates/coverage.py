"""Coverage of estimates: how often errors of random contacts are within them, and their ratios."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count, islice

import numpy as np

from femic.cache.digests import results_digest
from femic.cache.processes import in_processes
from femic.cache.store import Arrays
from femic.reference.run_options import RunOptions
from femic.validation.estimates.contacts import ICS, random_contact
from femic.validation.estimates.studies import STUDIES, GridComparison, Study
from geometries.errors import Failure

NOTHING = 1e-9  # of estimates: errors that are rounding
ROWS = "numbers", "finer", "larger", "estimates"  # of a comparison, by name of the number
SPARE = 1.25  # contacts to start with for one that has a solution on all grids


@dataclass(frozen=True)
class Coverage:
    """Share of errors within estimates, worst error over estimate, median of estimate over error."""

    held: float
    worst: float
    median: float


def coverage(
    comparisons: Sequence[GridComparison], name: str, *, differences: bool = False, factor: float = 1.0
) -> Coverage:
    """Return the coverage of a number's estimates, or differences to larger elements, times a factor.

    Contacts in which the number is exact do not count.
    """
    number, finer, larger, estimate = (
        np.array([getattr(comparison, kind)[name] for comparison in comparisons])
        for kind in ("numbers", "finer", "larger", "estimates")
    )
    known = np.isfinite(estimate)
    if not np.any(known):
        return Coverage(1.0, 0.0, np.nan)  # a number that is exact in all contacts
    error = np.abs(number - finer)[known]
    bound = factor * (np.abs(number - larger) if differences else estimate)[known]
    finite = error > NOTHING * np.maximum(bound, np.finfo(float).tiny)  # rounding would have any ratio
    with np.errstate(divide="ignore", invalid="ignore"):
        return Coverage(
            float(np.mean(error <= bound)),
            float(np.max(np.where(finite, error / bound, 0.0))),
            float(np.median(bound[finite] / error[finite])) if np.any(finite) else np.nan,
        )


def by_regime(comparisons: Iterable[GridComparison]) -> dict[str, list[GridComparison]]:
    """Return contacts by their regime."""
    regimes: dict[str, list[GridComparison]] = {}
    for comparison in comparisons:
        regimes.setdefault(comparison.regime, []).append(comparison)
    return regimes


def comparisons(study: Study, seed: int, ics: Sequence[str] = ICS) -> Iterator[GridComparison]:
    """Yield random contacts, endlessly; contacts without a solution on one of the grids are left out."""
    return (
        comparison for number in count() if (comparison := compared(study, seed, number, ics)) is not None
    )


def compared(study: Study, seed: int, number: int, ics: Sequence[str] = ICS) -> GridComparison | None:
    """Return the random contact of a number; None where it has no solution on one of the grids."""
    try:
        return study(random_contact(seed, number, ics))
    except Failure:
        return None


def stored_comparisons(name: str, seed: int, count: int, options: RunOptions) -> list[GridComparison]:
    """Return random contacts of a study, each stored; a quarter more are solved, since some have no solution.

    Raises Failure where fewer than `count` have one.
    """
    key = options.store.key("coverage", results_digest(__name__), name, seed)
    numbers = range(round(SPARE * count))
    parts = {number: options.store.part(key, _part(number)) for number in numbers}
    open_ = [number for number, part in parts.items() if part is None]
    solve = partial(_compared_by_number, name, seed)
    for done, (number, comparison) in enumerate(in_processes(solve, open_, options.workers), start=1):
        parts[number] = part = _arrays(comparison)
        options.store.put_part(key, _part(number), part)
        options.watch.on_stage(f"  {name}: {done} of {len(open_)} random contacts")
    solved = [comparison for part in parts.values() if part and (comparison := _comparison(part)) is not None]
    if len(solved) < count:
        raise Failure(f"{name}: only {len(solved)} of {len(numbers)} random contacts have a solution")
    return list(islice(solved, count))


def _part(number: int) -> str:
    return f"contact{number}"


def _compared_by_number(name: str, seed: int, number: int) -> tuple[int, GridComparison | None]:
    return number, compared(STUDIES[name], seed, number)


def _arrays(comparison: GridComparison | None) -> Arrays:
    """Return the arrays of a comparison for the store; a marker where there is none."""
    if comparison is None:
        return {"none": np.zeros(0)}
    names = np.array(list(comparison.numbers))
    rows = {key: np.array([getattr(comparison, key)[name] for name in names]) for key in ROWS}
    return {"names": names, "regime": np.array(comparison.regime), **rows}


def _comparison(part: Arrays) -> GridComparison | None:
    if "none" in part:
        return None
    names = [str(name) for name in part["names"]]
    rows = {key: dict(zip(names, map(float, part[key]), strict=True)) for key in ROWS}
    return GridComparison(**rows, regime=str(part["regime"]))
