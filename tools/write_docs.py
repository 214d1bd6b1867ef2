"""Write the pages of docs/ whose numbers are computed: `make docs`.

    python tools/write_docs.py [--compute]

With --compute, `femic validate`, `extremes`, `calibrate` and `frontier` run first (half an hour on 2 cores;
what out/ keeps is not solved again) and their numbers go to docs/numbers/. Pages are made of these and
docs/templates/; a test compares.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from compare.cli import exit_code
from compare.frontier.advice import advise
from compare.frontier.trade import front, told_apart
from geometries.errors import Failure

DOCS = Path(__file__).parents[1] / "docs"
NUMBERS, TEMPLATES = DOCS / "numbers", DOCS / "templates"
GEOMETRIES = ("geometry1", "geometry2")
TOLERANCES = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.001)
QUESTIONS = {"nn": ("nn",), "nn, ss, xx": ("nn", "ss", "xx"), "all six": ()}


def compute() -> None:
    """Run what gives the numbers, and keep them."""
    out = Path("out")
    run("validate")
    run("extremes")
    run("calibrate", *GEOMETRIES)
    frontiers = {}
    for name in GEOMETRIES:
        calibrated = str(out / name / f"{name}_calibrated.toml")
        run("frontier", calibrated, "--out", str(out / f"{name}_calibrated"))
        with xr.open_dataset(out / f"{name}_calibrated" / "frontier.nc", engine="h5netcdf") as dataset:
            frontiers[name] = numbers_of(dataset.load())
    keep("frontier", frontiers)
    for name in ("validation", "extremes"):
        keep(name, json.loads((out / name / f"{name}.json").read_text(encoding="utf-8")))


def run(*arguments: str) -> None:
    if code := exit_code([*arguments]):
        sys.exit(code)


def keep(name: str, values: Any) -> None:
    NUMBERS.mkdir(exist_ok=True)
    text = json.dumps(rounded(values), indent=1, ensure_ascii=False, allow_nan=False)
    (NUMBERS / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def rounded(values: Any) -> Any:
    """Numbers to five digits."""
    if isinstance(values, dict):
        return {key: rounded(value) for key, value in values.items()}
    if isinstance(values, list):
        return [rounded(value) for value in values]
    return float(f"{values:.5g}") if isinstance(values, float) else values


def numbers_of(dataset: xr.Dataset) -> dict[str, Any]:
    """A frontier: every way, and the advice for some tolerances."""
    body = str(dataset.body.values[0])
    worst, seconds = told_apart(dataset, body).max("component"), dataset.seconds.sel(body=body)
    chosen = front(seconds.values, worst.values)
    ways = [
        {
            "label": str(dataset.label.values[k]),
            "kind": str(dataset.kind.values[k]),
            "seconds": float(seconds.values[k]),
            "unknowns": int(dataset.unknowns.values[k]),
            "memory": float(dataset.memory.values[k]),
            "front": bool(chosen[k]),
            "errors": by_component(dataset.error.sel(way=way)),
            "weights": by_component(dataset.weight.sel(way=way)),
        }
        for k, way in enumerate(dataset.way.values)
    ]
    return {
        "title": dataset.attrs["title"],
        "body": body,
        "best": str(dataset.attrs["best"]),
        "points": int(dataset.attrs["points"]),
        "skipped": json.loads(dataset.attrs["skipped"]),
        "components": [str(component) for component in dataset.component.values],
        "bodies": [str(one) for one in dataset.body.values],
        "vanishing": [name for name, gone in by_component(dataset.vanishes).items() if gone],
        "ways": ways,
        "advice": {
            question: [advice(dataset, tolerance, components, body) for tolerance in TOLERANCES]
            for question, components in QUESTIONS.items()
        },
    }


def by_component(values: xr.DataArray) -> dict[str, float | None]:
    """Of every body, as "combined, xn"."""
    return {
        f"{body}, {component}": finite(values.sel(body=body, component=component).item())
        for body in values.body.values
        for component in values.component.values
    }


def finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def advice(dataset: xr.Dataset, tolerance: float, components: tuple[str, ...], body: str) -> dict[str, Any]:
    asked = list(components) or [str(component) for component in dataset.component.values]
    try:
        found = advise(dataset, tolerance, asked, body)
    except Failure:
        return {"tolerance": tolerance, "label": None, "error": None, "seconds": None}
    return {
        "tolerance": tolerance,
        "label": found.label,
        "error": found.error,
        "seconds": found.seconds,
    }


def pages() -> dict[str, str]:
    """The text of every page, by its name."""
    numbers = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in NUMBERS.glob("*.json")}
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["percent"] = percent
    environment.filters["seconds"] = in_seconds
    environment.filters["short"] = lambda value: "–" if value is None else f"{value:.3g}"
    environment.filters["cell"] = lambda text: text.replace("|", "\\|")
    return {
        path.name.removesuffix(".j2"): environment.get_template(path.name).render(**numbers)
        for path in sorted(TEMPLATES.glob("*.md.j2"))
    }


def percent(share: float | None) -> str:
    if share is None:
        return "–"
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"


def in_seconds(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.0f} s" if value >= 10 else f"{value:.1f} s" if value >= 0.1 else f"{1000 * value:.0f} ms"


if __name__ == "__main__":
    if "--compute" in sys.argv[1:]:
        compute()
    for name, text in pages().items():
        (DOCS / name).write_text(text, encoding="utf-8")
