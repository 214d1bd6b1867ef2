"""The estimated errors of several bodies' ICs, and of their sum, as shares of the scale of refinement."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from femic.reference.accuracy import Shares
from femic.reference.estimate import EstimatedICs, total
from geometries.arrays import Array

Measure = Callable[[str, EstimatedICs], Shares]  # the estimated errors of a body's ICs on some scale


@dataclass(frozen=True)
class Assessment:
    """Estimated errors of the bodies and, where their sum is compared, of the sum and of each body in it."""

    own: Mapping[str, Shares]
    combined: Shares | None = None
    in_combined: Mapping[str, Shares] = field(default_factory=dict)


@dataclass(frozen=True)
class Batch:
    """ICs of bodies that share a scale of refinement: at all points, or due to loads on one strip.

    `measure` takes names of bodies and the sum of their ICs, and returns the measure on the scale of this
    sum.
    """

    ics: Mapping[str, EstimatedICs]
    measure: Callable[[Sequence[str], Array], Measure]


def assess(batches: Iterable[Batch], *, combined: bool) -> Assessment:
    """Return the worst errors over batches: of each body and, with `combined`, of the sum of all bodies."""
    own: defaultdict[str, list[Shares]] = defaultdict(list)
    body_in_sum: defaultdict[str, list[Shares]] = defaultdict(list)
    combined_shares: list[Shares] = []
    for batch in batches:
        for body, ics in batch.ics.items():
            own[body].append(batch.measure([body], ics.ic)(body, ics))
        if combined:
            bodies, c = list(batch.ics), total(list(batch.ics.values()))
            measure = batch.measure(bodies, c.ic)
            combined_shares.append(measure(bodies[0], c))
            for body, ics in batch.ics.items():
                body_in_sum[body].append(measure(body, ics))
    return Assessment(
        {body: worst_of(shares) for body, shares in own.items()},
        worst_of(combined_shares) if combined else None,
        {body: worst_of(shares) for body, shares in body_in_sum.items()},
    )


def worst_of(shares: Sequence[Shares]) -> Shares:
    """Return the worst of several shares, with the largest of each part."""
    worst = max(shares, key=lambda row: row.total)
    parts = {part: max(getattr(row, part) for row in shares) for part in ("mesh", "truncation", "waves")}
    return replace(worst, **parts)
