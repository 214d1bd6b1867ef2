"""How often errors of random contacts are within their estimates, and how large the one is over the other."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import count, islice

import numpy as np

from femic.cache.digests import results_digest
from femic.cache.processes import in_processes
from femic.cache.store import Arrays
from femic.reference.run_options import RunOptions
from femic.validation.estimates.contacts import ICS, random_contact
from femic.validation.estimates.studies import STUDIES, Outcome, Study
from geometries.errors import Failure

NOTHING = 1e-9  # of estimates: errors that are rounding
SPARE = 1.25  # contacts that are tried for one that has a solution on all grids


@dataclass(frozen=True)
class Coverage:
    """How often errors are within estimates, their worst ratio, and the median of the opposite one."""

    held: float
    worst: float
    median: float


def coverage(
    found: Sequence[Outcome], name: str, *, differences: bool = False, factor: float = 1.0
) -> Coverage:
    """That of the estimates of a number times a factor, or of its differences to elements twice as large."""
    error = np.array([abs(one.numbers[name] - one.finer[name]) for one in found])
    known = np.array(
        [abs(one.numbers[name] - one.larger[name]) if differences else one.estimates[name] for one in found]
    )
    known = factor * known
    told = error > NOTHING * np.maximum(known, np.finfo(float).tiny)  # the others would have any ratio
    with np.errstate(divide="ignore", invalid="ignore"):
        return Coverage(
            float(np.mean(error <= known)),
            float(np.max(np.where(told, error / known, 0.0))),
            float(np.median(known[told] / error[told])) if np.any(told) else np.nan,
        )


def outcomes(study: Study, seed: int, ics: Sequence[str] = ICS) -> Iterator[Outcome]:
    """What random contacts give, without end; those without a solution on one of the grids are left out."""
    return (outcome for number in count() if (outcome := outcome_of(study, seed, number, ics)) is not None)


def outcome_of(study: Study, seed: int, number: int, ics: Sequence[str] = ICS) -> Outcome | None:
    """What the random contact of a number gives; None where it has no solution on one of the grids."""
    try:
        return study(random_contact(seed, number, ics))
    except Failure:
        return None


def kept_outcomes(name: str, seed: int, wanted: int, options: RunOptions) -> list[Outcome]:
    """What random contacts of a study give, each kept; of a quarter more than wanted some have no solution.

    Raises Failure where fewer than wanted have one.
    """
    key = options.store.key("coverage", results_digest(__name__), name, seed)
    numbers = range(round(SPARE * wanted))
    parts = {number: options.store.part(key, _part(number)) for number in numbers}
    open_ = [number for number, part in parts.items() if part is None]
    solve = partial(_outcome_by_number, name, seed)
    for done, (number, outcome) in enumerate(in_processes(solve, open_, options.workers), start=1):
        parts[number] = part = _arrays(outcome)
        options.store.put_part(key, _part(number), part)
        options.watch.on_stage(f"  {name}: {done} of {len(open_)} random contacts")
    found = [outcome for part in parts.values() if part and (outcome := _outcome(part)) is not None]
    if len(found) < wanted:
        raise Failure(f"{name}: only {len(found)} of {len(numbers)} random contacts have a solution")
    return list(islice(found, wanted))


def _part(number: int) -> str:
    return f"contact{number}"


def _outcome_by_number(name: str, seed: int, number: int) -> tuple[int, Outcome | None]:
    return number, outcome_of(STUDIES[name], seed, number)


def _arrays(outcome: Outcome | None) -> Arrays:
    """An outcome as the store keeps it; without any where there is none."""
    if outcome is None:
        return {"none": np.zeros(0)}
    names = np.array(list(outcome.numbers))
    rows = {key: np.array([row[name] for name in names]) for key, row in asdict(outcome).items()}
    return {"names": names, **rows}


def _outcome(part: Arrays) -> Outcome | None:
    if "none" in part:
        return None
    names = [str(name) for name in part["names"]]
    rows = {
        key: dict(zip(names, map(float, part[key]), strict=True))
        for key in ("numbers", "finer", "larger", "estimates")
    }
    return Outcome(**rows)
