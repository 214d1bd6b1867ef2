"""The self-contained HTML report of an overlay, its figures and CSV files."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from compare.pages.html import Cell, embedded, error_cell, known_cell, rendered
from compare.pages.styles import SYMBOLS, save
from compare.reports.overlay import figures as overlay_figures
from compare.reports.overlay.curves import Overlay, Result, vanishes, worst, write_curves
from compare.reports.overlay.differences import differences
from compare.reports.overlay.sources import Source
from compare.results import folders
from compare.results.measure import ROUNDING
from geometries.errors import WrongInput

JUDGED = ("A", "Bhat")  # variants of the summary
ALIKE = "alike within the accuracy of C"


@dataclass(frozen=True)
class Row:
    """The worst errors of one variant in one scene, a cell per component."""

    symbol: str
    scene: str
    cells: list[Cell]
    first: bool


def folder_of(found: Sequence[Source], out: Path | None, results: Path) -> Path:
    """Where the overlay goes; raises WrongInput where that would overwrite something else."""
    folder = folders.checked(out or results / "_".join(source.name for source in found))
    if (folder / "ics.nc").exists() or folder.resolve() in [source.folder.resolve() for source in found]:
        raise WrongInput(f"--out {folder}: has the results of a scene; name another folder")
    return folder


def write(overlay: Overlay, folder: Path) -> Path:
    """Write figures, CSV files and `report.html` into a folder; returns the report's path."""
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    write_curves(overlay, folder)
    figures = [
        save(overlay_figures.curves(overlay, component), folder / "figures" / f"curves_{component}.png")
        for component in overlay.common.components
    ]
    path = folder / "report.html"
    path.write_text(render(overlay, figures), encoding="utf-8")
    return path


def render(overlay: Overlay, figures: Sequence[Path]) -> str:
    """The report as HTML with the PNG figures in it."""
    return rendered(
        "overlay.html.j2",
        title=", ".join(result.name for result in overlay.results),
        scenes=[(result.name, result.ics.attrs["title"]) for result in overlay.results],
        summary=summary(overlay),
        common=overlay.common,
        tables=[{"body": body, "rows": list(_rows(overlay, body))} for body in overlay.common.bodies],
        differences=list(differences(overlay)),
        drawn=", ".join(SYMBOLS[variant] for variant in overlay_figures.drawn_variants(overlay)),
        figures=[embedded(path) for path in figures],
        texts=[(result.name, result.ics.attrs["scene"]) for result in overlay.results],
    )


def _rows(overlay: Overlay, body: str) -> Iterator[Row]:
    cells = {
        (result.name, component): _cells(overlay, result, body, component)
        for result in overlay.results
        for component in overlay.common.components
    }
    for variant in (*overlay.common.variants, "C"):
        for k, result in enumerate(overlay.results):
            of_row = [cells[result.name, component][variant] for component in overlay.common.components]
            yield Row(SYMBOLS[variant] if k == 0 else "", result.name, of_row, k == 0)


def _cells(overlay: Overlay, result: Result, body: str, component: str) -> dict[str, Cell]:
    """Of a component in a scene, by variant."""
    errors = worst(overlay, result, (body, component))
    weights = worst(overlay, result, (body, component), "weight")
    gone = vanishes(result, body, component)
    return {
        variant: (known_cell if variant == "C" else error_cell)(error, weights[variant], vanishes=gone)
        for variant, error in errors.items()
    }


def summary(overlay: Overlay) -> str:
    """One paragraph, computed: in which scene C is further from A and from B-hat, and by what factor."""
    body, lines = overlay.common.bodies[0], len(overlay.common.lines)
    judged = [variant for variant in JUDGED if variant in overlay.common.variants]
    if not judged:
        return f"The scenes have neither {' nor '.join(SYMBOLS[variant] for variant in JUDGED)} in common."
    where = f"{body} influence coefficients, worst of {lines} line{'s' if lines > 1 else ''}"
    sentences = (
        f"C deviates from {SYMBOLS[variant]} {_ranking(overlay, body, variant)}." for variant in judged
    )
    return f"Worst errors compared ({where}). {' '.join(sentences)}"


def _ranking(overlay: Overlay, body: str, variant: str) -> str:
    """The components by the scene that has the largest error, with the factor to the smallest."""
    most = "more" if len(overlay.results) == 2 else "most"
    ranks: dict[str, list[str]] = {}
    for component in overlay.common.components:
        gone = [result.name for result in overlay.results if vanishes(result, body, component)]
        if gone:  # errors there are shares of something else
            ranks.setdefault(f"vanishing in {', '.join(gone)}", []).append(component)
            continue
        errors = [(worst(overlay, result, (body, component)), result.name) for result in overlay.results]
        scene, factor = _rank([(error[variant], error["C"], name) for error, name in errors])
        ranks.setdefault(f"{most} in {scene}" if scene else ALIKE, []).append(component + factor)
    last = {rank: ranks.pop(rank) for rank in list(ranks) if not rank.startswith(most)}
    return "; ".join(f"{rank}: {', '.join(components)}" for rank, components in (ranks | last).items())


def _rank(errors: Sequence[tuple[float, float, str]]) -> tuple[str, str]:
    """Scene and factor of the largest error, of (error, accuracy of C, scene); "" within the accuracy."""
    (least, known, _), (largest, known_there, scene) = min(errors), max(errors)
    if largest - least <= known + known_there:
        return "", ""
    if max(least, known) < ROUNDING:
        return scene, " (0 elsewhere)"
    factor = largest / max(least, known)
    over = "over " if least < known else ""
    return scene, f" {over}{factor:.2f} ×" if factor < 10 else f" {over}{factor:.0f} ×"
