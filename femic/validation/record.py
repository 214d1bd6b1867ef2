"""The results of a study as JSON, and a page of the same numbers."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from compare.report.parts import Page, write_page
from femic.cache.digests import results_digest, versions
from femic.cache.files import write_text


def write(
    folder: Path, study: str, module: str, numbers: dict[str, Any], page_of: Callable[[dict[str, Any]], Page]
) -> Path:
    """Write STUDY.json, with versions and code, and STUDY.html of the same; returns the path of the page.

    `module` computes the numbers, with all that it imports.
    """
    content = numbers | {"versions": versions(), "code": results_digest(module), "module": module}
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    write_text(text, folder / f"{study}.json")
    return write_page(page_of(content), folder / f"{study}.html")


def version_text(content: dict[str, Any]) -> str:
    """Return a list of the program and its libraries with their versions."""
    return ", ".join(f"{name} {version}" for name, version in content["versions"].items()) + "."
