"""What both studies of the program share: results as JSON with a page of them, and Kalker's coefficients."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from compare.report.parts import Page, write_page
from femic.cache.digests import STUDY_FOLDERS, results_digest, versions
from femic.cache.files import write_text
from femic.contact.exact.creepage_coefficients import CreepageCoefficients, creepage_coefficients
from femic.contact.exact.hertz import LoadedPoint


def write_study(
    folder: Path, study: str, numbers: dict[str, Any], make_page: Callable[[dict[str, Any]], Page]
) -> Path:
    """Write STUDY.json, with versions and code, and STUDY.html of the same; returns the path of the page."""
    content = numbers | {"versions": versions(), "code": results_digest(*STUDY_FOLDERS)}
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    write_text(text, folder / f"{study}.json")
    return write_page(make_page(content), folder / f"{study}.html")


def versions_text(content: dict[str, Any]) -> str:
    """Return a list of the program and its libraries with their versions."""
    return ", ".join(f"{name} {version}" for name, version in content["versions"].items()) + "."


DIGITS = 9  # of the aspect of an ellipse


def kalker_coefficients(patch: LoadedPoint, nu: float) -> CreepageCoefficients:
    """Return the coefficients of the ellipse of a contact of Hertz; nu is the combined one.

    They do not depend on its size: those of each aspect are computed once. Raises WrongInput as
    `creepage_coefficients`.
    """
    return replace(_unit_ellipse(float(f"{patch.a / patch.b:.{DIGITS}g}"), nu), a=patch.a, b=patch.b)


@cache
def _unit_ellipse(aspect: float, nu: float) -> CreepageCoefficients:
    return creepage_coefficients(float(np.sqrt(aspect)), float(1 / np.sqrt(aspect)), nu)
