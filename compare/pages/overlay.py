"""ICs of several scenes along the lines that they have in common, dimensionless: page and CSV files."""

import csv
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages.ics import COUNTS, WeightedError, body_name, heaviest, row_name, within
from compare.pages.ics_figures import (
    INVISIBLE,
    along_line,
    by_component,
    combined_first,
    dimensionless,
    main_body,
    minus_c,
    of_differences,
)
from compare.pages.overlay_sources import Overlay, Source, differences, worst
from compare.report.charts import Chart, Curve, Panel
from compare.report.errors import COMPONENTS, ERRORS_HEADING, MEASURE, cell_of, percent
from compare.report.looks import Look, looks_of, symbol_of
from compare.report.parts import Folded, Items, Note, Page, Section, Verbatim, join_words, write_page
from compare.report.tables import Row, Table, numbers, texts
from femic.cache import folders
from femic.cache.files import replacing
from femic.ic_errors.error_measure import ROUNDING
from femic.results.ics_dataset import curves_file
from geometries.errors import WrongInput

# --- the page -------------------------------------------------------------------------------------------


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
    components, variants = overlay.common.components, _summarised_variants(overlay) or overlay.common.variants
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


def _summarised_variants(overlay: Overlay) -> list[str]:
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
    variants, errors = _summarised_variants(overlay), worst_errors(overlay)
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
) -> tuple[str, str, WeightedError]:
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


# --- the chart ------------------------------------------------------------------------------------------


Looks = Mapping[str, Mapping[str, Look]]  # by variant and scene

OVERLAID_VARIANTS = ("A", "B", "Bhat")  # drawn in charts; tables also have the others
DASHES = ("solid", "dash", "dot", "dashdot", "longdash")  # of the scenes
WIDE_LINE, NARROW_LINE = 3.2, 1.2  # line widths, rear to front: curves that coincide stay visible


def drawn_variants(overlay: Overlay) -> tuple[str, ...]:
    """Return C and the common variants among `OVERLAID_VARIANTS`, or all common variants if none is."""
    common = overlay.common.variants
    return ("C", *(tuple(variant for variant in common if variant in OVERLAID_VARIANTS) or common))


def chart(overlay: Overlay) -> Chart:
    """Return the ICs of all scenes, dimensionless: as `compare.pages.ics_figures.chart` of one scene."""
    first, *others = combined_first(overlay.common.bodies)
    ics = {result.name: result.ics for result in overlay.results}
    differences = {name: minus_c(dataset) for name, dataset in ics.items()}
    halves = {line: is_mirrored(overlay, line) for line in overlay.common.lines}
    looks = _looks(overlay)
    steps = {
        component: [
            *_panels(ics, halves, looks, [first], component),
            *map(of_differences, _panels(differences, halves, looks, [first], component)),
            *_panels(ics, halves, looks, others, component),
        ]
        for component in overlay.common.components
    }
    return by_component(steps, len(halves))


def _looks(overlay: Overlay) -> Looks:
    """Return looks by variant and scene: variants have colours, scenes dashes; wide lines lie behind."""
    variants, names = drawn_variants(overlay), [result.name for result in overlay.results]
    widths = np.linspace(WIDE_LINE, NARROW_LINE, len(variants))
    return {
        variant: {
            name: Look(look.colour, dash, width=round(width, 2))
            for name, dash in zip(names, DASHES, strict=False)
        }
        for (variant, look), width in zip(looks_of(variants).items(), widths, strict=True)
    }


def _panels(
    ics: Mapping[str, xr.Dataset],
    halves: Mapping[str, bool],
    looks: Looks,
    bodies: Sequence[str],
    component: str,
) -> Iterator[Panel]:
    """Yield panels of bodies on lines with the curves of all scenes; `halves` are lines shown in part."""
    for body, (line, half) in product(bodies, halves.items()):
        parts = {name: curves_of(dataset, line, body, component) for name, dataset in ics.items()}
        shown = {
            name: part.isel(point=part["at"].values >= (0 if half else -np.inf))
            for name, part in parts.items()
        }
        curves = [
            Curve(
                f"{symbol_of(variant)}, {name}",
                shown[name]["at"].values,
                shown[name].ic.sel(variant=variant).values,
                look,
                shown[name].estimate.values if variant == "C" else None,
            )
            for variant, scene_looks in looks.items()
            for name, look in scene_looks.items()
        ]
        across = next(iter(parts.values())).across
        yield Panel(f"{body}, {line}", across, f"{component} · E · L  [-]", curves, least=INVISIBLE)


# --- curves ---------------------------------------------------------------------------------------------


MIRRORED = 1e-6  # largest asymmetry of a mirrored curve, as a share of the largest value on its line


def curves_of(ics: xr.Dataset, line: str, body: str, component: str) -> xr.Dataset:
    """Return a component of a body of a scene along a line over `at`, dimensionless."""
    return along_line(ics, line, body, component, dimensionless(ics))


def is_mirrored(overlay: Overlay, line: str) -> bool:
    """Whether the two halves of a line have the same values, up to the sign, in all curves of all scenes."""
    return all(
        _repeats(curves_of(result.ics, line, body, component))
        for result, body, component in product(
            overlay.results, overlay.common.bodies, overlay.common.components
        )
    )


def _repeats(curves: xr.Dataset) -> bool:
    if curves.across.startswith("x"):
        return True  # every body and every load is symmetric in x
    at, sizes = curves["at"].values, np.abs(curves.ic.values)
    asymmetry = np.max(np.abs(sizes - sizes[:, ::-1]))
    return np.allclose(at, -at[::-1]) and bool(asymmetry <= MIRRORED * np.max(sizes))


def write_curves(overlay: Overlay, folder: Path) -> None:
    """Write one CSV file per line, with a row per scene, body, component and point.

    Each variant has a column; all values are dimensionless.
    """
    common, variants = overlay.common, [*overlay.common.variants, "C"]
    for line in common.lines:
        across = curves_of(overlay.results[0].ics, line, common.bodies[0], common.components[0]).across
        with (
            replacing(folder / curves_file(line)) as unfinished,
            unfinished.open("w", newline="", encoding="utf-8") as file,
        ):
            table = csv.writer(file)
            table.writerow(["scene", "body", "component", f"{across[0]}/L", *variants, "estimate"])
            for result, body, component in product(overlay.results, common.bodies, common.components):
                curves = curves_of(result.ics, line, body, component)
                values = [
                    curves["at"].values,
                    *curves.ic.sel(variant=variants).values,
                    curves.estimate.values,
                ]
                for row in np.column_stack(values):
                    table.writerow([result.name, body, component, *(f"{value:.8g}" for value in row)])
