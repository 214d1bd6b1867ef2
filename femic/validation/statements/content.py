"""The content of `validation.json`: statements with their numbers, the runs, changes of criteria."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from compare.ics.compute import reference_of, seconds_of
from compare.ics.dataset import finite
from compare.ics.errors import measure_of
from femic.ic_errors.error_measure import Measure
from femic.validation.statements.changes import CHANGES
from femic.validation.statements.estimated import estimate_of
from femic.validation.statements.runs import Runs
from femic.validation.statements.verdicts import Finding


def content_of(findings: Sequence[Finding], runs: Runs, seconds: float) -> dict[str, Any]:
    """Return the content of `validation.json`; `seconds` is the time of all statements together."""
    return {
        "statements": [entry(finding) for finding in findings],
        "runs": {name: _run_record(runs, name) for name in runs.done},
        "changes": [asdict(change) for change in CHANGES],
        "tolerance": runs.tolerance,
        "seconds": round(seconds, 1),
    }


def entry(finding: Finding) -> dict[str, Any]:
    """Return a statement with its verdict and its numbers."""
    return {
        "number": finding.statement.number,
        "claim": finding.statement.claim,
        "verdict": finding.verdict,
        "failed": finding.failed,
        "unmet": [
            f"{criterion.description}: {case}: {value:.4g} (not {criterion.relation} "
            f"{criterion.threshold:.3g}{'; too close to decide' if criterion.close(value) else ''})"
            for criterion, case, value in finding.unmet
        ],
        "criteria": [
            {
                "name": criterion.name,
                "says": criterion.description,
                "relation": criterion.relation,
                "threshold": criterion.threshold,
                "values": {case: finite(value) for case, value in values.items()},
                "estimates": {case: finite(estimate_of(value)) for case, value in values.items()},
                "met": {case: criterion.met(value) for case, value in values.items()},
                "close": {case: criterion.close(value) for case, value in values.items()},
            }
            for criterion in finding.statement.criteria
            if (values := finding.values.get(criterion.name))
        ],
        "details": {case: finite(value) for case, value in finding.details.items()},
    }


def _run_record(runs: Runs, name: str) -> dict[str, float]:
    """Return the largest estimate of a run's C on both scales [-], its seconds and its unknowns."""
    results = runs.done[name]
    estimate, weight = (
        max(
            float(np.max(line_shares))
            for body in results.scene.compared
            for line_shares in shares(
                measure_of(results, body), reference_of(results, body).estimate
            ).values()
        )
        for shares in (Measure.shares, Measure.weights)
    )
    return {
        "estimate": estimate,
        "weight": weight,
        "seconds": round(seconds_of(results.models), 1),
        "unknowns": max(cost.unknowns for cost in results.models.values()),
    }
