"""Write the pages of docs/ whose numbers are computed: `make docs`.

    python tools/write_docs.py [--compute | --check]

With --compute, decisions, stresses, `femic validate`, `calibrate`, `frontier` and `extremes` are computed
first (models in out/ are not solved again); the numbers of each go to docs/numbers/ as soon as they are
there. Pages are rendered from these, the keys and commands that the program declares, and docs/templates/; a
test compares. Numbers carry the digest of the code that computed them: --check writes nothing, says which
pages have numbers of other code, and ends with 1 if any does. Tables of benchmarks (`make bench`, in
docs/numbers/benchmarks) name theirs on the page and are not checked: seconds change with every machine.
"""

import json
import re
import subprocess
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import contact_formulas
import decision_page
import decisions
import evidence_page
import numpy as np
import stress_numbers
import xarray as xr
from command_line import command_line
from jinja2 import Environment, FileSystemLoader, StrictUndefined, meta
from scene_keys import scene_keys

from compare.studies.frontier import Question, advise, front
from femic.cache.digests import STUDY_FOLDERS, results_digest
from geometries.errors import Failure

DOCS = Path(__file__).parents[1] / "docs"
NUMBERS, TEMPLATES = DOCS / "numbers", DOCS / "templates"
README = DOCS.parent / "README.md"
TABLE_BEGINS, TABLE_ENDS = "<!-- table by tools/write_docs.py -->", "<!-- end of the table -->"
OUT = Path("out")
GEOMETRIES = ("geometry1", "geometry2")
TOLERANCES = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.001)
CODE = r"(^```.*?^```$|`[^`\n]+`)"
TYPED = {  # no second empty lines; minus signs, not hyphens; a space before %
    r"\n{3,}": "\n\n",
    r"(?<=[ (])-(?=\d)": "−",
    r"(?<=\d)(?=%)": " ",
}
UNTYPED = re.compile("|".join([CODE, *(f"({pattern})" for pattern in TYPED)]), re.DOTALL | re.MULTILINE)
QUESTIONS = {"nn": ("nn",), "nn, ss, xx": ("nn", "ss", "xx"), "all six": ()}


def compute() -> None:
    """Run the commands that give the numbers, and save these."""
    save("decisions", decisions.compute())
    decision_page.draw(stored_numbers()["decisions"]).savefig(DOCS / "images" / "which_ics.png", dpi=130)
    run("validate")
    save_written("validation")
    save("stresses", stress_numbers.compute())
    contact_formulas.save(contact_formulas.compute())
    run("calibrate", *GEOMETRIES)
    frontiers = {}
    for name in GEOMETRIES:
        calibrated = str(OUT / name / f"{name}_calibrated.toml")
        run("frontier", calibrated, "--out", str(OUT / f"{name}_calibrated"))
        with xr.open_dataset(OUT / f"{name}_calibrated" / "frontier.nc", engine="h5netcdf") as dataset:
            frontiers[name] = numbers_of(dataset.load())
    save("frontier", frontiers)
    run("extremes")
    save_written("extremes")


def save_written(name: str) -> None:
    """Save the numbers that a command has written, as soon as it has."""
    save(name, json.loads((OUT / name / f"{name}.json").read_text(encoding="utf-8")))


def run(*arguments: str) -> None:
    """Run a command in a process of its own: its peak of memory is among the numbers."""
    if code := subprocess.run([sys.executable, "-m", "femic", *arguments], check=False).returncode:
        sys.exit(code)


def save(name: str, values: Any) -> None:
    NUMBERS.mkdir(exist_ok=True)
    text = json.dumps(rounded(values), indent=1, ensure_ascii=False, allow_nan=False)
    (NUMBERS / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def rounded(values: Any) -> Any:
    """Return values with numbers to five digits."""
    if isinstance(values, dict):
        return {key: rounded(value) for key, value in values.items()}
    if isinstance(values, list):
        return [rounded(value) for value in values]
    return float(f"{values:.5g}") if isinstance(values, float) else values


def numbers_of(dataset: xr.Dataset) -> dict[str, Any]:
    """Return a frontier: every way, and the advice for some tolerances."""
    body = str(dataset.body.values[0])
    of_best = dataset.estimate.sel(body=body, way=dataset.attrs["best"], drop=True)
    worst = np.maximum(dataset.error.sel(body=body), of_best).max("component")
    seconds = dataset.seconds.sel(body=body)
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
        "code": dataset.attrs["code"],
        "versions": json.loads(dataset.attrs["versions"]),
        "body": body,
        "best": str(dataset.attrs["best"]),
        "points": int(dataset.attrs["points"]),
        "skipped": json.loads(dataset.attrs["skipped"]),
        "components": [str(component) for component in dataset.component.values],
        "bodies": [str(name) for name in dataset.body.values],
        "vanishing": [name for name, gone in by_component(dataset.vanishes).items() if gone],
        "ways": ways,
        "advice": {
            question: [advice(dataset, tolerance, components, body) for tolerance in TOLERANCES]
            for question, components in QUESTIONS.items()
        },
    }


def by_component(values: xr.DataArray) -> dict[str, float | None]:
    """Return values of every body, by names such as "combined, xn"."""
    return {
        f"{body}, {component}": finite(values.sel(body=body, component=component).item())
        for body in values.body.values
        for component in values.component.values
    }


def finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def advice(dataset: xr.Dataset, tolerance: float, components: tuple[str, ...], body: str) -> dict[str, Any]:
    requested = components or tuple(str(component) for component in dataset.component.values)
    advised = None
    with suppress(Failure):
        advised = advise(dataset, Question(requested, tolerance, body))
    return {"tolerance": tolerance} | {
        key: getattr(advised, name, None)
        for key, name in (("label", "label"), ("error", "bound"), ("seconds", "seconds"))
    }


def stored_numbers() -> dict[str, Any]:
    """Return the numbers in docs/numbers, by the name of their file."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in NUMBERS.glob("*.json")}


def environment() -> Environment:
    made = Environment(
        loader=FileSystemLoader(TEMPLATES), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    made.filters["percent"] = percent
    made.filters |= {
        "crossing": decision_page.crossing_text,
        "error": decision_page.error_text,
        "load_of": decision_page.load_of,
        "kilonewton": decision_page.kilonewton,
        "nearest": decision_page.nearest,
        "decision_rows": decision_page.decision_rows,
        "force_rows": decision_page.force_rows,
    }
    made.filters |= {
        name: getattr(evidence_page, name)
        for name in (
            *("changed_verdicts", "computed", "counts", "origin", "refused"),
            *("unmet", "worst_rows", "wrapped"),
        )
    }
    made.filters["columns"] = evidence_page.columns_of
    made.filters["seconds"] = in_seconds
    made.filters["signed"] = lambda share: f"{100 * share:+.0f} %".replace("-", "−")
    made.filters["short"] = lambda value: "–" if value is None else f"{value:.3g}"
    made.filters["cell"] = lambda text: text.replace("|", "\\|")
    made.filters["sentence"] = lambda text: f"{text[:1].upper()}{text[1:]}."
    return made


def templates() -> dict[str, Path]:
    """Return the template of every page, by the page's path below docs/."""
    return {place(path).removesuffix(".j2"): path for path in sorted(TEMPLATES.rglob("*.md.j2"))}


def place(template: Path) -> str:
    return template.relative_to(TEMPLATES).as_posix()


def pages() -> dict[str, str]:
    """Return the text of every page, by its name; last of all, what its numbers were computed with."""
    numbers, made = stored_numbers(), environment()
    known = numbers | declared() | {"benchmarks": evidence_page.recorded(NUMBERS / "benchmarks")}
    texts = {
        page: set_in_type(made.get_template(place(path)).render(**known)).rstrip() + "\n"
        for page, path in templates().items()
    }
    return {page: text + computed_with(templates()[page], numbers) for page, text in texts.items()}


def set_in_type(text: str) -> str:
    """Return a text without second empty lines, with minus signs and spaces before %; code stays as it is."""
    better = [None, *TYPED.values()]
    return UNTYPED.sub(lambda found: better[found.lastindex - 1] or found[0], text)


def readme() -> str:
    """Return README with its table of errors, between two comments."""
    before, rest = README.read_text(encoding="utf-8").split(TABLE_BEGINS)
    _, after = rest.split(TABLE_ENDS)
    table = decision_page.readme_table(stored_numbers()["decisions"])
    return f"{before}{TABLE_BEGINS}\n{table}\n{TABLE_ENDS}{after}"


@cache
def declared() -> dict[str, Any]:
    """Return what the program declares: the keys of its files, its commands."""
    return scene_keys() | command_line()


def used(template: Path, numbers: dict[str, Any]) -> list[str]:
    """Return the numbers that a page is made of."""
    tree = environment().parse(template.read_text(encoding="utf-8"))
    return sorted(meta.find_undeclared_variables(tree) & numbers.keys())


def programs(values: dict[str, Any]) -> dict[str, str]:
    """Return what computed some numbers: digests of the code, versions."""
    parts = parts_of(values)
    by_code = sorted({part.get("code", "unknown") for part in parts})
    versions: dict[str, str] = next((part["versions"] for part in parts if "versions" in part), {})
    return {"code": " and ".join(by_code)} | versions


def computed_with(template: Path, numbers: dict[str, Any]) -> str:
    sentences = [
        f"{name} by " + ", ".join(f"{what} {version}" for what, version in programs(numbers[name]).items())
        for name in used(template, numbers)
    ]
    return f"\n*Numbers of this page were computed with: {'; '.join(sentences)}.*\n" if sentences else ""


def outdated() -> dict[str, list[str]]:
    """Return pages whose numbers other code has computed: which numbers, by which code."""
    numbers = stored_numbers()
    outdated_pages = {
        page: [
            f"docs/numbers/{name}.json by code {code}, now {now}"
            for name in used(path, numbers)
            for code, now in codes(numbers[name])
            if code != now
        ]
        for page, path in templates().items()
    }
    return {page: reasons for page, reasons in outdated_pages.items() if reasons}


def codes(values: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the digests of the code that computed some numbers, and of today's; none of samples."""
    parts = [part for part in parts_of(values) if not part.get("is_sample")]
    return [(part.get("code", "unknown"), results_digest(*STUDY_FOLDERS)) for part in parts]


def parts_of(values: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the parts of numbers that have been computed by one command each."""
    return [values] if "code" in values else [part for part in values.values() if isinstance(part, dict)]


def percent(share: float | None) -> str:
    if share is None:
        return "–"
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"


def in_seconds(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.0f} s" if value >= 10 else f"{value:.1f} s" if value >= 0.1 else f"{1000 * value:.0f} ms"


def checked() -> int:
    """Report which pages are out of date; return the exit code."""
    outdated_pages = outdated()
    for page, reasons in outdated_pages.items():
        sys.stderr.write(f"docs/{page}: {'; '.join(reasons)}: run make docs\n")
    return 1 if outdated_pages else 0


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        sys.exit(checked())
    if "--compute" in sys.argv[1:]:
        compute()
    for name, text in pages().items():
        (DOCS / name).write_text(text, encoding="utf-8")
    README.write_text(readme(), encoding="utf-8")
