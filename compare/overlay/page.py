"""The self-contained HTML report of an overlay, its figures and its CSV files."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from compare.overlay import figures as overlay_figures
from compare.overlay.curves import write_curves
from compare.overlay.differences import differences
from compare.overlay.results import Overlay, worst
from compare.overlay.sources import Source
from compare.report.errors import COMPONENTS, ERRORS_HEADING, MEASURE, cell_of
from compare.report.parts import Folded, Items, Note, Page, Picture, Section, Verbatim, write_page
from compare.report.styles import SYMBOLS
from compare.report.tables import Row, Table, numbers, texts
from femic.cache import folders
from femic.ic_errors.error_measure import ROUNDING
from geometries.errors import WrongInput

SUMMARISED = ("A", "Bhat")  # variants in the summary
CURVES = (
    "of all scenes; colours distinguish variants, line styles scenes. Per unit total load, times E of the "
    "lower body and L of the scene. Grey band: C ± its estimated error (often thinner than the line). Where "
    "a scene's curve seems missing, it coincides with the curve of an earlier scene."
)
WITHIN_ACCURACY = "alike within the accuracy of C"


def folder_of(sources: Sequence[Source], out: Path | None, results: Path) -> Path:
    """Return the folder of the overlay; raises WrongInput if it holds the results of a scene."""
    folder = folders.check(out or results / "_".join(source.name for source in sources))
    if (folder / "ics.nc").exists() or folder.resolve() in [source.folder.resolve() for source in sources]:
        raise WrongInput(f"--out {folder}: has the results of a scene; name another folder")
    return folder


def write(overlay: Overlay, folder: Path) -> Path:
    """Write figures, CSV files and `report.html` into a folder; returns the report's path."""
    folders.make(folder)
    write_curves(overlay, folder)
    title = ", ".join(result.name for result in overlay.results)
    return write_page(Page(title, summary(overlay), _sections(overlay)), folder / "report.html")


def _sections(overlay: Overlay) -> Iterator[Section]:
    common, results = overlay.common, overlay.results
    titles = Items([f"{result.name}: {result.ics.attrs['title']}" for result in results])
    yield Section("", [titles])
    for body in common.bodies:
        notes = [Note(_measure(overlay))] if body == common.bodies[0] else []
        yield Section(ERRORS_HEADING.format(body), [_table(overlay, body), *notes])
    yield Section("Differences between the scenes", [_differences_table(overlay)])
    pictures = (
        Picture(f"curves_{component}", overlay_figures.curves(overlay, component))
        for component in common.components
    )
    drawn = ", ".join(SYMBOLS[variant] for variant in overlay_figures.drawn_variants(overlay))
    yield Section("Influence coefficients along the lines", [f"{drawn} {CURVES}", *pictures])
    texts = [Folded(result.name, [Verbatim(result.ics.attrs["scene"])]) for result in results]
    yield Section("Scene files", texts)


def _measure(overlay: Overlay) -> str:
    return (
        f"{MEASURE} Shown: the largest over {', '.join(overlay.common.lines)}; shares of C of the same "
        f"scene. Rows “C”: the estimated error of C itself. {COMPONENTS}"
    )


def _table(overlay: Overlay, body: str) -> Table:
    columns = [*texts("scene"), *numbers(*overlay.common.components)]
    return Table("variant", columns, list(_rows(overlay, body)))


def _rows(overlay: Overlay, body: str) -> Iterator[Row]:
    for variant in (*overlay.common.variants, "C"):
        for k, result in enumerate(overlay.results):
            errors = [worst(overlay, result, body, component) for component in overlay.common.components]
            cells = [cell_of(error.sel(variant=variant), is_estimate=variant == "C") for error in errors]
            yield Row("" if k else SYMBOLS[variant], [result.name, *cells])


def _differences_table(overlay: Overlay) -> Table:
    rows = [
        Row(difference.key, [difference.meaning, *difference.values]) for difference in differences(overlay)
    ]
    heads = ["meaning", *(result.name for result in overlay.results)]
    return Table("key" if rows else "key (nothing differs)", heads, rows, is_text=True)


def summary(overlay: Overlay) -> str:
    """Return a computed paragraph: where C deviates most from A and from B-hat, with the factors."""
    body, lines = overlay.common.bodies[0], len(overlay.common.lines)
    variants = [variant for variant in SUMMARISED if variant in overlay.common.variants]
    if not variants:
        return (
            f"The scenes have neither {' nor '.join(SYMBOLS[variant] for variant in SUMMARISED)} in common."
        )
    where = f"{body} influence coefficients, worst of {lines} line{'s' if lines > 1 else ''}"
    sentences = (
        f"C deviates from {SYMBOLS[variant]} {_ranking(overlay, body, variant)}." for variant in variants
    )
    return f"Worst errors compared ({where}). {' '.join(sentences)}"


def _ranking(overlay: Overlay, body: str, variant: str) -> str:
    """Return the components by the scene with the largest error, each with its factor to the smallest."""
    most = "more" if len(overlay.results) == 2 else "most"
    ranks: dict[str, list[str]] = {}
    for component in overlay.common.components:
        errors = {result.name: worst(overlay, result, body, component) for result in overlay.results}
        vanishing_in = [name for name, scene_errors in errors.items() if scene_errors.vanishes]
        if vanishing_in:  # the errors there are shares of 0.05 max |C_nn|, not of the component
            ranks.setdefault(f"vanishing in {', '.join(vanishing_in)}", []).append(component)
            continue
        pairs = {
            name: scene_errors.error.sel(variant=[variant, "C"]) for name, scene_errors in errors.items()
        }
        scene, factor = _rank([(*pair.values.tolist(), name) for name, pair in pairs.items()])
        ranks.setdefault(f"{most} in {scene}" if scene else WITHIN_ACCURACY, []).append(component + factor)
    unranked = {rank: ranks.pop(rank) for rank in list(ranks) if not rank.startswith(most)}
    return "; ".join(f"{rank}: {', '.join(components)}" for rank, components in (ranks | unranked).items())


def _rank(errors: Sequence[tuple[float, float, str]]) -> tuple[str, str]:
    """Return the scene with the largest error, and the text of its factor to the smallest; errors are [-].

    Each entry of `errors` is (error, accuracy of C, scene). Both texts are empty if the difference is within
    the accuracies.
    """
    (least, accuracy_at_least, _), (largest, accuracy_at_largest, scene) = min(errors), max(errors)
    if largest - least <= accuracy_at_least + accuracy_at_largest:
        return "", ""
    if max(least, accuracy_at_least) < ROUNDING:
        return scene, " (0 elsewhere)"
    factor = largest / max(least, accuracy_at_least)
    over = "over " if least < accuracy_at_least else ""
    return scene, f" {over}{factor:.2f} ×" if factor < 10 else f" {over}{factor:.0f} ×"
