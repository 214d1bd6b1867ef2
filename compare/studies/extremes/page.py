"""`femic extremes`: try all, and write `extremes.json` and `extremes.html`."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from compare.pages.html import rendered
from compare.results import folders
from compare.results.provenance import results_digest
from compare.studies.extremes import analytic, exact
from compare.studies.extremes.engines import Engines
from compare.studies.extremes.found import ANALYTIC, Found, Parameter, tried
from femic.work.provenance import versions


def try_all(of: Sequence[str], engines: Engines, folder: Path) -> Path:
    """Try the parts and write what was found; returns the path of the page."""
    folders.made(folder)
    found = list(tried([row for part in of for row in rows(part, engines)], engines.means.watch.on_stage))
    values = record(found)
    text = json.dumps(values, indent=1, ensure_ascii=False, allow_nan=False)
    (folder / "extremes.json").write_text(text, encoding="utf-8")
    path = folder / "extremes.html"
    path.write_text(rendered("extremes.html.j2", found=values, summary=summary(found)), encoding="utf-8")
    return path


def rows(part: str, engines: Engines) -> list[Parameter]:
    """The parameters of a part."""
    return analytic.parameters() if part == ANALYTIC else engines.parameters(part)


def summary(found: Sequence[Found]) -> str:
    """One paragraph: whether all estimates hold, and whether everything beyond the limits is answered."""
    cases = [case for one in found for case in one.reached]
    judged = [case for case in cases if case.used is not None]
    held = sum(case.honest for case in judged)
    beyond = [case for one in found for case in one.beyond]
    silent = [case.at for case in beyond if not case.says]
    answered = "all of them are answered" if not silent else f"nothing is said at {', '.join(silent)}"
    estimates = (
        f"In {held} of {len(judged)} cases with estimates all of them are at least the error. "
        if judged
        else ""
    )
    return f"{len(cases)} cases within the limits. {estimates}{len(beyond)} beyond: {answered}."


def _finite(values: dict[str, Any]) -> dict[str, Any]:
    """Without what JSON does not know: infinite is null."""
    return {
        key: None if isinstance(value, float) and not np.isfinite(value) else value
        for key, value in values.items()
    }


def record(found: Sequence[Found]) -> dict[str, Any]:
    """Everything as it goes into `extremes.json`."""
    return {
        "rows": [
            {
                "engine": one.parameter.engine,
                "parameter": one.parameter.name,
                "range": one.parameter.range,
                "reached": [_finite(asdict(case)) | {"honest": case.honest} for case in one.reached],
                "beyond": [asdict(case) for case in one.beyond],
            }
            for one in found
        ],
        "summary": summary(found),
        "digits": exact.DIGITS,
        "seconds": round(sum(case.seconds for one in found for case in one.reached), 1),
        "versions": versions(),
        "code": results_digest(),
    }
