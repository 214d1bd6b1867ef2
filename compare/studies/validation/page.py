"""`femic validate`: statements judged one by one, written as JSON and as one self-contained page."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from compare.pages.html import embedded, rendered
from compare.pages.styles import save
from compare.results import folders
from compare.results.compute import reference_of, shares_of, weights_of
from compare.results.provenance import results_digest
from compare.studies.validation import figures
from compare.studies.validation.changes import CHANGES
from compare.studies.validation.runs import Runs
from compare.studies.validation.verdicts import (
    DEPENDS,
    NOT_DECIDED,
    NOT_REPRODUCED,
    REPRODUCED,
    Judged,
    judge,
)
from femic.accuracy import component_of
from femic.work.provenance import versions

COLOURS = {
    REPRODUCED: "#d9f0d9",
    DEPENDS: "#fdf1cd",
    NOT_REPRODUCED: "#f9d9d6",
    NOT_DECIDED: "#dddddd",
}


def validate(numbers: Sequence[int], runs: Runs, folder: Path) -> Path:
    """Judge statements and write `validation.json`, figures, `validation.html`; returns the page's path."""
    at = folders.made(folder / "figures")
    start, judged = perf_counter(), []
    for number in numbers:
        runs.means.watch.on_stage(f"statement {number}")
        judged.append(judge(number, runs))
        runs.means.watch.on_stage(f"statement {number}: {judged[-1].verdict}")
    runs.means.watch.on_stage("  figures and report")
    found = record(judged, runs, perf_counter() - start)
    (folder / "validation.json").write_text(
        json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False), encoding="utf-8"
    )
    pictures = {one.number: _pictures(one, at) for one in judged}
    path = folder / "validation.html"
    page = rendered(
        "validation.html.j2", summary=summary(judged), found=found, pictures=pictures, colours=COLOURS
    )
    path.write_text(page, encoding="utf-8")
    return path


def summary(judged: Sequence[Judged]) -> str:
    """How many statements have which verdict."""
    parts = []
    for verdict in COLOURS:
        of = [str(one.number) for one in judged if one.verdict == verdict]
        if of:
            parts.append(f"{verdict}: {len(of)} ({', '.join(of)})")
    return f"Of {len(judged)} statements, {'; '.join(parts)}."


def record(judged: Sequence[Judged], runs: Runs, seconds: float) -> dict[str, Any]:
    """Everything as it goes into `validation.json`."""
    return {
        "statements": [_statement(one) for one in judged],
        "runs": {name: _known(runs, name) for name in runs.done},
        "changes": [asdict(change) for change in CHANGES],
        "tolerance": runs.tolerance,
        "seconds": round(seconds, 1),
        "versions": versions(),
        "code": results_digest(),
    }


def _statement(one: Judged) -> dict[str, Any]:
    return {
        "number": one.number,
        "claim": one.statement.claim,
        "verdict": one.verdict,
        "failed": one.failed,
        "unmet": [
            f"{criterion.says}: {case}: {value:.4g} (not {criterion.relation} {criterion.threshold:.3g}"
            f"{'; too close to tell' if criterion.close(value) else ''})"
            for criterion, case, value in one.unmet
        ],
        "criteria": [
            {
                "name": criterion.name,
                "says": criterion.says,
                "relation": criterion.relation,
                "threshold": criterion.threshold,
                "values": _finite(one.measured.values[criterion.name]),
                "met": {c: criterion.met(v) for c, v in one.measured.values[criterion.name].items()},
                "close": {c: criterion.close(v) for c, v in one.measured.values[criterion.name].items()},
            }
            for criterion in one.statement.criteria
            if not one.failed
        ],
        "details": _finite(one.measured.details),
    }


def _finite(values: Any) -> dict[str, float | None]:
    return {case: float(value) if np.isfinite(value) else None for case, value in values.items()}


def _known(runs: Runs, name: str) -> dict[str, float]:
    """How well C of a run is known, at worst (its own engine's), on both scales, and what it took."""
    results = runs.done[name]
    estimate, weight = (
        max(
            component_of(of_line, component)
            for body in results.scene.compared
            for of_line in of(results, body, reference_of(results, body).estimate).values()
            for component in results.scene.components
        )
        for of in (shares_of, weights_of)
    )
    return {
        "estimate": estimate,
        "weight": weight,
        "seconds": round(sum(sum(cost.seconds.values()) for cost in results.models.values()), 1),
        "unknowns": max(cost.unknowns for cost in results.models.values()),
    }


def _pictures(one: Judged, folder: Path) -> list[Any]:
    if one.failed:
        return []
    drawn = {"numbers": figures.numbers(one)}
    if one.measured.panels:
        drawn = {"curves": figures.curves(one)} | drawn
    return [
        embedded(save(figure, folder / f"statement{one.number}_{name}.png")) for name, figure in drawn.items()
    ]
