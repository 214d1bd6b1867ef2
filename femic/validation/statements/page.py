"""`femic validate` judges statements one by one and writes them as JSON and as one self-contained page."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

from compare.ics.compute import reference_of, seconds_of
from compare.ics.dataset import finite
from compare.ics.error_measure import Measure
from compare.ics.errors import measure_of
from compare.report.styles import save
from femic.cache import folders
from femic.reference.accuracy import component_of
from femic.validation import record
from femic.validation.statements import figures
from femic.validation.statements.changes import CHANGES
from femic.validation.statements.runs import Runs
from femic.validation.statements.verdicts import (
    DEPENDS,
    NOT_DECIDED,
    NOT_REPRODUCED,
    REPRODUCED,
    Judged,
    judge,
)

VERDICT_COLOURS = {
    REPRODUCED: "#d9f0d9",
    DEPENDS: "#fdf1cd",
    NOT_REPRODUCED: "#f9d9d6",
    NOT_DECIDED: "#dddddd",
}


def validate(numbers: Sequence[int], runs: Runs, folder: Path) -> Path:
    """Judge statements; write `validation.json`, figures and `validation.html`; return the page's path."""
    figures_folder = folders.make(folder / "figures")
    start, judged = perf_counter(), []
    for number in numbers:
        runs.options.watch.on_stage(f"statement {number}")
        judged.append(judge(number, runs))
        runs.options.watch.on_stage(f"statement {number}: {judged[-1].verdict}")
    runs.options.watch.on_stage("  figures and report")
    return record.write(
        folder,
        "validation",
        found_numbers(judged, runs, perf_counter() - start),
        summary=summary(judged),
        pictures={one.statement.number: _pictures(one, figures_folder) for one in judged},
        colours=VERDICT_COLOURS,
    )


def summary(judged: Sequence[Judged]) -> str:
    """The sentence that says how many statements have which verdict."""
    parts = []
    for verdict in VERDICT_COLOURS:
        numbers = [str(one.statement.number) for one in judged if one.verdict == verdict]
        if numbers:
            parts.append(f"{verdict}: {len(numbers)} ({', '.join(numbers)})")
    return f"Of {len(judged)} statements, {'; '.join(parts)}."


def found_numbers(judged: Sequence[Judged], runs: Runs, seconds: float) -> dict[str, Any]:
    """What was found, as `validation.json` has it; `seconds` is the time that all statements took."""
    return {
        "statements": [_statement(statement) for statement in judged],
        "runs": {name: _run_record(runs, name) for name in runs.done},
        "changes": [asdict(change) for change in CHANGES],
        "tolerance": runs.tolerance,
        "seconds": round(seconds, 1),
    }


def _statement(judged: Judged) -> dict[str, Any]:
    return {
        "number": judged.statement.number,
        "claim": judged.statement.claim,
        "verdict": judged.verdict,
        "failed": judged.failed,
        "unmet": [
            f"{criterion.says}: {case}: {value:.4g} (not {criterion.relation} {criterion.threshold:.3g}"
            f"{'; too close to tell' if criterion.close(value) else ''})"
            for criterion, case, value in judged.unmet
        ],
        "criteria": [
            {
                "name": criterion.name,
                "says": criterion.says,
                "relation": criterion.relation,
                "threshold": criterion.threshold,
                "values": {case: finite(value) for case, value in values.items()},
                "met": {case: criterion.met(value) for case, value in values.items()},
                "close": {case: criterion.close(value) for case, value in values.items()},
            }
            for criterion in judged.statement.criteria
            if not judged.failed
            for values in (judged.measured.values[criterion.name],)
        ],
        "details": {case: finite(value) for case, value in judged.measured.details.items()},
    }


def _run_record(runs: Runs, name: str) -> dict[str, float]:
    """The largest estimate of a run's C, by its own engine, on both scales [-]; its seconds and unknowns."""
    results = runs.done[name]
    estimate, weight = (
        max(
            component_of(line_shares, component)
            for body in results.scene.compared
            for line_shares in measured(
                measure_of(results, body), reference_of(results, body).estimate
            ).values()
            for component in results.scene.components
        )
        for measured in (Measure.shares, Measure.weights)
    )
    return {
        "estimate": estimate,
        "weight": weight,
        "seconds": round(seconds_of(results.models), 1),
        "unknowns": max(cost.unknowns for cost in results.models.values()),
    }


def _pictures(judged: Judged, folder: Path) -> list[Path]:
    if judged.failed:
        return []
    drawn = {"numbers": figures.numbers(judged)}
    if judged.measured.panels:
        drawn = {"curves": figures.curves(judged)} | drawn
    return [
        save(figure, folder / f"statement{judged.statement.number}_{name}.png")
        for name, figure in drawn.items()
    ]
