"""`femic extremes` tries all cases and writes `extremes.json` and `extremes.html`."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from compare.ics.dataset import finite
from femic.validation import record
from femic.validation.extremes import analytic, exact
from femic.validation.extremes.engines import Engines
from femic.validation.extremes.found import ANALYTIC, Found, Parameter, Reached, tried


def try_all(parts: Sequence[str], engines: Engines, folder: Path) -> Path:
    """Try the parts and write the results; returns the path of the page."""
    findings = list(
        tried([row for part in parts for row in rows(part, engines)], engines.options.watch.on_stage)
    )
    return record.write(folder, "extremes", numbers(findings), summary=summary(findings))


def rows(part: str, engines: Engines) -> list[Parameter]:
    """The parameters of a part: of the analytic ICs or of an engine."""
    return analytic.parameters() if part == ANALYTIC else engines.parameters(part)


def summary(findings: Sequence[Found]) -> str:
    """One paragraph: how many estimates hold, and whether all cases beyond the limits have a message."""
    cases = [case for finding in findings for case in finding.reached]
    judged = [case for case in cases if case.used is not None]
    held = sum(case.honest for case in judged)
    beyond = [case for finding in findings for case in finding.beyond]
    silent = [case.at for case in beyond if not case.says]
    answered = "all of them are answered" if not silent else f"nothing is said at {', '.join(silent)}"
    estimates = (
        f"In {held} of {len(judged)} cases with estimates all of them are at least the error. "
        if judged
        else ""
    )
    return f"{len(cases)} cases within the limits. {estimates}{len(beyond)} beyond: {answered}."


def numbers(findings: Sequence[Found]) -> dict[str, Any]:
    """What was found, as `extremes.json` has it."""
    return {
        "rows": [
            {
                "engine": finding.parameter.engine,
                "parameter": finding.parameter.name,
                "range": finding.parameter.range,
                "reached": [_case(case) for case in finding.reached],
                "beyond": [asdict(case) for case in finding.beyond],
            }
            for finding in findings
        ],
        "summary": summary(findings),
        "digits": exact.DIGITS,
        "seconds": round(sum(case.seconds for finding in findings for case in finding.reached), 1),
    }


def _case(case: Reached) -> dict[str, Any]:
    """A case with None for numbers that JSON does not have, and whether its estimates hold."""
    values = asdict(case).items()
    return {key: finite(v) if isinstance(v, float) else v for key, v in values} | {"honest": case.honest}
