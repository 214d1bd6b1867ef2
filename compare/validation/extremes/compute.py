"""The results of `femic extremes`: all cases of some parts, and what they amount to."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from compare.validation.extremes import analytic, friction, frictionless
from compare.validation.extremes import analytic as exact
from compare.validation.extremes.cases import (
    ANALYTIC,
    CONTACT,
    FRICTION,
    Limit,
    LimitResult,
    WithinLimit,
    results_of,
)
from compare.validation.extremes.engines import Engines
from femic.results.ics_dataset import finite


def compute(parts: Sequence[str], engines: Engines) -> list[LimitResult]:
    """Run the cases of some parts."""
    limits = [limit for part in parts for limit in _limits(part, engines)]
    return list(results_of(limits, engines.options.watch.on_stage))


def _limits(part: str, engines: Engines) -> list[Limit]:
    """Return the limits of a part."""
    of_contact = {CONTACT: frictionless.limits, FRICTION: friction.limits}
    if part in of_contact:
        return of_contact[part](engines.options)
    return analytic.limits() if part == ANALYTIC else engines.limits(part)


def numbers(results: Sequence[LimitResult]) -> dict[str, Any]:
    """Return the content of `extremes.json`."""
    return {
        "rows": [
            {
                "engine": result.limit.engine,
                "parameter": result.limit.name,
                "range": result.limit.range,
                "reached": [_case(case) for case in result.reached],
                "beyond": [asdict(case) for case in result.beyond],
            }
            for result in results
        ],
        "summary": summary(results),
        "digits": exact.DIGITS,
        "seconds": round(sum(case.seconds for result in results for case in result.reached), 1),
    }


def _case(case: WithinLimit) -> dict[str, Any]:
    """Return a case with None for numbers that JSON lacks, and whether its estimates hold."""
    values = asdict(case).items()
    return {key: finite(v) if isinstance(v, float) else v for key, v in values} | {"honest": case.honest}


def summary(results: Sequence[LimitResult]) -> str:
    """Return how many estimates hold, which do not, and how femic answers beyond the limits."""
    return " ".join([*_within([*_cases(results)]), *_beyond(results)])


def _cases(results: Sequence[LimitResult]) -> Iterator[tuple[str, WithinLimit]]:
    """Yield cases within the limits under their labels."""
    for result in results:
        for case in result.reached:
            yield f"{result.limit.engine}, {_label(result.limit, case)}", case


def _label(limit: Limit, case: WithinLimit) -> str:
    """Return the label of a case; of contacts with the name of the parameter."""
    if not case.finished:
        return limit.name
    return f"{limit.name}: {case.at}" if limit.engine in {CONTACT, FRICTION} else case.at


def _within(cases: Sequence[tuple[str, WithinLimit]]) -> Iterator[str]:
    estimated = [(label, case.used) for label, case in cases if case.finished and case.used is not None]
    exceeded = [f"{used:.1f} ({label})" for label, used in estimated if used > 1]
    failed = [label for label, case in cases if not case.finished]
    yield (
        f"{len(cases)} cases within the limits"
        + (f", {len(failed)} failed ({'; '.join(failed)})" if failed else "")
        + (
            f": in {len(estimated) - len(exceeded)} of the {len(estimated)} that have estimates, these bound "
            "every error"
            if estimated
            else ""
        )
        + "."
    )
    if exceeded:
        yield f"Elsewhere the largest error over its own estimate is {' and '.join(exceeded)}."


def _beyond(results: Sequence[LimitResult]) -> Iterator[str]:
    cases = [case for result in results for case in result.beyond]
    silent = [case.at for case in cases if not (case.says or case.failed)]
    failed = [case.at for case in cases if case.failed]
    computed = sum(case.computed for case in cases)
    refused = len(cases) - len(silent) - len(failed) - computed
    if cases:
        yield (
            f"Of {len(cases)} cases beyond them femic refuses {refused} with a message"
            + (f" and computes {computed} all the same" if computed else "")
            + (f"; it says nothing at {', '.join(silent)}" if silent else "")
            + (f"; it fails instead at {', '.join(failed)}" if failed else "")
            + "."
        )
