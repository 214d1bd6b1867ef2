"""The self-contained HTML report of an overlay, its figures and its CSV files."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import xarray as xr

from compare.ics.curves import main_body
from compare.ics.page import row_name
from compare.ics.summary import COUNTS, Weighted, body_name, heaviest, within
from compare.overlay.curves import write_curves
from compare.overlay.differences import differences
from compare.overlay.figures import chart, drawn_variants
from compare.overlay.results import Overlay, worst
from compare.overlay.sources import Source
from compare.report.errors import COMPONENTS, ERRORS_HEADING, MEASURE, cell_of, percent
from compare.report.looks import symbol_of
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, join_words, write_page
from compare.report.tables import Row, Table, numbers, texts
from femic.cache import folders
from femic.ic_errors.error_measure import ROUNDING
from geometries.errors import WrongInput

SUMMARISED = ("A", "Bhat")  # variants in the summary
ANSWER = (
    "Largest difference from C {} over {}: as a share of the component; small: of C_nn of the same scene. "
    "C ±: the estimated error of C. †: vanishes in C. Shown: {}; the others are in the tables below."
)
CURVES = (
    "Colours distinguish variants, dashes scenes. Per unit total load, times E of the lower body and L of "
    "the scene ({}). Band: C ± its estimated error, often thinner than the line. Where a scene's curve seems "
    "missing, it coincides with the curve of another scene."
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
    body = main_body(overlay.common.bodies)
    page = Page(title, summary(overlay), _sections(overlay), answer_table(overlay, body))
    return write_page(page, folder / "report.html")


def _sections(overlay: Overlay) -> Iterator[Section | Folded]:
    common, results = overlay.common, overlay.results
    titles = Items([f"{result.name}: {result.ics.attrs['title']}" for result in results])
    lengths = ", ".join(f"{result.name}: {result.ics.reference_length:g} mm" for result in results)
    shown = join_words(decisive_components(overlay))
    answer = ANSWER.format(body_name(main_body(common.bodies)), join_words(common.lines), shown)
    yield Section("", [Note(answer), chart(overlay), Note(CURVES.format(lengths)), titles])
    ranks = Items([f"C deviates from {sentence}" for sentence in rankings(overlay)])
    tables = [
        Section(ERRORS_HEADING.format(body), [_table(overlay, body, (*common.variants, "C"))])
        for body in common.bodies
    ]
    yield Folded("Errors of all variants", [Note(_measure(overlay)), ranks, *tables])
    yield Folded("Differences between the scenes", [_differences_table(overlay)])
    scene_files = [Folded(result.name, [Verbatim(result.ics.attrs["scene"])]) for result in results]
    yield Folded("Scene files", scene_files)


def _measure(overlay: Overlay) -> str:
    return (
        f"{MEASURE} Shown: the largest over {', '.join(overlay.common.lines)}; shares of C of the same "
        f"scene. Rows “C ±”: the estimated error of C itself. {COMPONENTS}"
    )


def decisive_components(overlay: Overlay) -> list[str]:
    """Return nn and the other component with the heaviest error, among the common ones."""
    components, variants = overlay.common.components, _summarised(overlay) or overlay.common.variants
    others = [component for component in components if component != "nn"]
    is_any = bool(others and variants)
    heavy = [_heaviest_of_all(worst_errors(overlay), variants, others)[2].component] if is_any else []
    return [component for component in ("nn", *heavy) if component in components]


def answer_table(overlay: Overlay, body: str) -> Table:
    """Return the errors of the variants drawn in each scene, in the components that decide."""
    variants = [variant for variant in drawn_variants(overlay) if variant != "C"] + ["C"]
    rows = []
    for component in decisive_components(overlay):
        for k, result in enumerate(overlay.results):
            errors = worst(overlay, result, body, component)
            cells = [cell_of(errors.sel(variant=name), is_estimate=name == "C") for name in variants]
            rows.append(Row("" if k else component, [result.name, *cells]))
    return Table("component", [*texts("scene"), *numbers(*map(row_name, variants))], rows)


def _table(overlay: Overlay, body: str, variants: Sequence[str]) -> Table:
    columns = numbers("scene", *overlay.common.components)
    return Table("variant", columns, list(_rows(overlay, body, variants)))


def _rows(overlay: Overlay, body: str, variants: Sequence[str]) -> Iterator[Row]:
    for variant in (*(variant for variant in variants if variant != "C"), "C"):
        for k, result in enumerate(overlay.results):
            errors = [worst(overlay, result, body, component) for component in overlay.common.components]
            cells = [cell_of(error.sel(variant=variant), is_estimate=variant == "C") for error in errors]
            yield Row("" if k else row_name(variant), [result.name, *cells])


def _differences_table(overlay: Overlay) -> Table:
    rows = [
        Row("" if k else ": ".join(filter(None, (difference.key, difference.meaning))), [result.name, value])
        for difference in differences(overlay)
        for k, (result, value) in enumerate(zip(overlay.results, difference.values, strict=True))
    ]
    return Table("key" if rows else "key (nothing differs)", texts("scene", "value"), rows)


def _summarised(overlay: Overlay) -> list[str]:
    return [variant for variant in SUMMARISED if variant in overlay.common.variants]


def worst_errors(overlay: Overlay) -> dict[str, xr.Dataset]:
    """Return the errors of the first body by scene, the worst over the lines."""
    body, lines = main_body(overlay.common.bodies), list(overlay.common.lines)
    return {
        result.name: result.errors.sel(body=body, line=lines).max("line", skipna=False)
        for result in overlay.results
    }


def summary(overlay: Overlay) -> str:
    """Return how far A and B-hat are from C in nn and, by weight, elsewhere, and how good C is."""
    body, components = main_body(overlay.common.bodies), overlay.common.components
    variants, errors = _summarised(overlay), worst_errors(overlay)
    sentences = []
    if variants and "nn" in components:
        sentences.append(_nn_sentence(errors, variants, body))
    others = [component for component in components if component != "nn"]
    if variants and others:
        sentences.append(_others_sentence(errors, variants, others))
    known = max(heaviest(of_scene, "C", components).weight for of_scene in errors.values())
    return " ".join([*sentences, f"C is known to {within(known)} of C_nn in every component of every scene."])


def _nn_sentence(errors: Mapping[str, xr.Dataset], variants: Sequence[str], body: str) -> str:
    """Return the errors of variants in nn in each scene."""
    off = []
    for variant in variants:
        shares = {
            name: percent(of_scene.error.sel(variant=variant, i="n", j="n").item())
            for name, of_scene in errors.items()
        }
        in_scenes = join_words(f"{text} in {name}" for name, text in shares.items())
        off.append(f"{symbol_of(variant)} is off by {in_scenes}")
    return f"In nn {body_name(body)}, {'; '.join(off)}."


def _others_sentence(
    errors: Mapping[str, xr.Dataset], variants: Sequence[str], components: Sequence[str]
) -> str:
    """Return the heaviest error in other components, and the same in all scenes."""
    _, variant, largest = _heaviest_of_all(errors, variants, components)
    if largest.weight < COUNTS:
        return f"No other component is off by more than {within(largest.weight)} of C_nn."
    component = largest.component
    weights = {
        name: percent(of_scene.weight.sel(variant=variant, i=component[0], j=component[1]).item())
        for name, of_scene in errors.items()
    }
    in_scenes = join_words(f"{text} of C_nn in {name}" for name, text in weights.items())
    where = f"{symbol_of(variant)} in {component}"
    return f"Among the other components, the heaviest error is that of {where}: {in_scenes}."


def _heaviest_of_all(
    errors: Mapping[str, xr.Dataset], variants: Sequence[str], components: Sequence[str]
) -> tuple[str, str, Weighted]:
    """Return the scene, the variant and the error with the largest weight in some components."""
    weighted = [
        (name, variant, heaviest(of_scene, variant, components))
        for name, of_scene in errors.items()
        for variant in variants
    ]
    return max(weighted, key=lambda item: item[2])


def rankings(overlay: Overlay) -> Iterator[str]:
    """Yield for A and B-hat in which scene C deviates most from it, with the factors."""
    body = main_body(overlay.common.bodies)
    for variant in SUMMARISED:
        if variant in overlay.common.variants:
            yield f"{symbol_of(variant)} {_ranking(overlay, body, variant)}."


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
