"""The estimated errors of several bodies' ICs, and of their sum, as shares of the scale of refinement."""

from collections.abc import Callable, Mapping, Sequence
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

    def meets(self, tolerances: Mapping[str, float]) -> bool:
        """Whether the bodies meet their tolerances, and their sum that of the first body."""
        of_sum = next(iter(tolerances.values()))
        return all(errors.total <= tolerances[body] for body, errors in self.own.items()) and (
            self.combined is None or self.combined.total <= of_sum
        )


@dataclass(frozen=True)
class Batch:
    """ICs of bodies that share a scale of refinement: at all points, or due to loads on one strip.

    `measure` takes names of bodies and the sum of their ICs, and returns the measure on the scale of this
    sum.
    """

    ics: Mapping[str, EstimatedICs]
    measure: Callable[[Sequence[str], Array], Measure]


def assessed(batch: Batch, *, combined: bool) -> Assessment:
    """Return the errors of a batch: of each body and, with `combined`, of the sum of all bodies."""
    own = {body: batch.measure([body], ics.ic)(body, ics) for body, ics in batch.ics.items()}
    if not combined:
        return Assessment(own)
    bodies, c = list(batch.ics), total(list(batch.ics.values()))
    measure = batch.measure(bodies, c.ic)
    in_combined = {body: measure(body, ics) for body, ics in batch.ics.items()}
    return Assessment(own, measure(bodies[0], c), in_combined)


def worst_assessment(assessments: Sequence[Assessment]) -> Assessment:
    """Return the worst errors of several assessments of the same bodies."""
    first = assessments[0]
    combined = [assessment.combined for assessment in assessments if assessment.combined is not None]
    return Assessment(
        {body: worst_of([assessment.own[body] for assessment in assessments]) for body in first.own},
        worst_of(combined) if combined else None,
        {
            body: worst_of([assessment.in_combined[body] for assessment in assessments])
            for body in first.in_combined
        },
    )


def worst_of(shares: Sequence[Shares]) -> Shares:
    """Return the worst of several shares, with the largest of each part."""
    worst = max(shares, key=lambda row: row.total)
    parts = {part: max(getattr(row, part) for row in shares) for part in ("mesh", "truncation", "waves")}
    return replace(worst, **parts)
