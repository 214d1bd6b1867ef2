"""What studies write: their numbers as JSON, and one self-contained page of them."""

import json
from pathlib import Path
from typing import Any

from compare.report.html import write_page
from femic.cache.digests import results_digest, versions
from femic.cache.files import write_text


def write(folder: Path, study: str, numbers: dict[str, Any], **values: object) -> Path:
    """Write STUDY.json, with versions and code, and STUDY.html of the same; returns the path of the page."""
    module = f"femic.validation.{study}.page"
    found = numbers | {"versions": versions(), "code": results_digest(module), "module": module}
    text = json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False)
    write_text(text, folder / f"{study}.json")
    return write_page(folder / f"{study}.html", f"{study}.html.j2", found=found, **values)
