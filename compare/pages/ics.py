"""The page of ICs of one scene or of several: errors against C, curves, accuracy, cost and settings.

All is drawn from the datasets of `femic.results.ics_dataset`. One scene is shown in µm/kN over mm, several
ones dimensionless: per unit total load, times E of the lower body and the reference length L.
"""

import json
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence

import xarray as xr

from compare.pages.ics_details import SceneICs, disagreements
from compare.pages.ics_figures import (
    chart,
    components_in,
    drawn_variants,
    further_chart,
    lines_in,
    main_body,
)
from compare.report.errors import COMPONENTS, ERRORS_HEADING, MEASURE, VANISHING, error_row, percent
from compare.report.looks import ics_symbol
from compare.report.parts import Block, Folded, Note, Page, Section, join_words
from compare.report.tables import Cell, Row, Table, numbers, texts, with_estimate
from compare.report.verdicts import NOT_DECIDED, YES, verdict
from femic.ic_errors.error_measure import ROUNDING
from femic.scenes.file import SceneFile

Scenes = Mapping[str, SceneICs]  # by name, with the same bodies, components, variants and lines

GROUPS = {  # components by kind, as the answer has them
    "nn": ("nn",),
    "tangential components": ("xx", "ss", "xs", "sx"),
    "cross terms": ("xn", "nx", "sn", "ns"),
}
LEAST_ESTIMATE = 1e-4  # share: smaller estimates are shown as this
ANSWER = (
    "Table: whether the errors of the {} ICs on the lines {} are within the tolerance of {} (ics_tolerance "
    "in the scene file). “Not decided”: ± leaves it open. Below: the largest error, relative to the largest "
    "value of the component in C, the component in which it occurs, and its weight: the same difference "
    "relative to C_nn. ± is the estimated error of C. Tangential components: xx, ss, xs, sx. Cross terms: "
    "xn, nx, sn, ns. †: the component vanishes in C; its error is relative to 0.05 max |C_nn|."
)
ONE_SCENE = (
    "Panels: ICs, and their differences from C. Band: ± the estimated error of C, often thinner than the "
    "line. Circles: C of the solid engine. Dotted: joint of arc and flank. Displacements per total load of "
    f"1 kN, without rigid-body motion. {COMPONENTS}"
)
SEVERAL_SCENES = (
    "Panels: ICs, and their differences from C. Colours show the ICs, dashes the scenes. ICs per unit total "
    "load are multiplied by E of the lower body and by L of the scene ({}). Band: ± the estimated error of "
    "C, often thinner than the line. If the curve of a scene seems to be missing, another scene's curve "
    f"covers it. {COMPONENTS}"
)


def page(title: str, scenes: Scenes, details: Iterable[Section | Folded]) -> Page:
    """Return the page of scenes: which ICs are close enough, curves, and on request errors and details."""
    sections = _sections(scenes, details)
    return Page(title, summary(scenes), sections, answer_table(scenes), list(doubts(scenes)))


def summary(scenes: Scenes) -> str:
    """Return the errors of nn (or what there is first), what is within the tolerance, and whether C is."""
    texts_of_scenes = []
    for name, scene in scenes.items():
        body, groups = main_body(scene.ics.body.values), largest_errors(scene)
        prefix = f"{name}: " if len(scenes) > 1 else ""
        sentences = [_errors_sentence(body, *next(iter(groups.items()))), _tolerance_sentence(scene, groups)]
        approximated = any(len(group.variant) for group in groups.values())
        texts_of_scenes.append(prefix + " ".join([*(sentences if approximated else ()), converged(scene)[1]]))
    return "\n".join(texts_of_scenes)


def _errors_sentence(body: str, words: str, group: xr.Dataset) -> str:
    """Return the largest errors in a group of components, the smallest first, and what is not decided."""
    group = group.sortby("error")
    by_text: dict[str, list[str]] = {}
    for name in map(str, group.variant.values):
        by_text.setdefault(_error_text(group.sel(variant=name)), []).append(ics_symbol(name))
    errors = "; ".join(f"{text} with {join_words(symbols)}" for text, symbols in by_text.items())
    best = group.isel(variant=0)
    close = [str(name) for name in group.variant.values[group.error - best.error <= best.estimate]]
    texts_of_close = {_error_text(group.sel(variant=name)) for name in close}
    open_text = (
        f" Which of {join_words(map(ics_symbol, close))} is closest to C is not decided."
        if len(texts_of_close) > 1
        else ""
    )
    return f"Largest error of the {body} ICs in {words}: {errors} (± is the estimated error of C).{open_text}"


def _tolerance_sentence(scene: SceneICs, groups: Mapping[str, xr.Dataset]) -> str:
    """Return which ICs are within the tolerance, by group of components; groups of the same ICs together."""
    words_by_ics: dict[str, list[str]] = {}
    for words, group in groups.items():
        good, unknown = (
            [ics_symbol(str(name)) for name in group.variant.values[group.verdict == word]]
            for word in (YES, NOT_DECIDED)
        )
        text = join_words(good) or "only C"
        words_by_ics.setdefault(
            f"{text} (not decided: {join_words(unknown)})" if unknown else text, []
        ).append(words)
    shown = "; ".join(f"in {join_words(words)}, {ics}" for ics, words in words_by_ics.items())
    return f"Within the tolerance of {share_text(tolerance(scene.ics))}: {shown}."


def converged(scene: SceneICs) -> tuple[bool, str]:
    """Return whether the estimate of C meets the tolerance of the engine, and a sentence that says so."""
    errors = scene.errors.solved_refinement.sel(part="all")
    worst = max(errors.sel(i=c[0], j=c[1]).max().item() for c in components_in(scene.ics))
    allowed = float(json.loads(scene.ics.attrs["settings"])["tolerance"])
    known = f"its largest estimated error is {percent(worst)}, the tolerance is {share_text(allowed)}"
    return worst <= allowed, f"C is {'' if worst <= allowed else 'not '}converged: {known}."


def tolerance(ics: xr.Dataset) -> float:
    """Return the largest error [-] of approximations that a scene allows."""
    default = SceneFile.model_fields["ics_tolerance"].default
    return float(tomllib.loads(ics.attrs["scene"]).get("ics_tolerance", default))


def share_text(share: float) -> str:
    """Return a share that was given, such as a tolerance, in percent."""
    return f"{100 * share:.6g} %"


def doubts(scenes: Scenes) -> Iterator[str]:
    """Yield what is unusual in scenes, and what may be wrong with their C."""
    for name, scene in scenes.items():
        found = [*json.loads(scene.ics.attrs["warnings"])]
        is_converged, text = converged(scene)
        if not is_converged:
            found.append(text)
        apart = disagreements(scene)
        if apart:
            where = "; ".join(apart)
            found.append(f"C of the solid engine differs from C by more than both estimated errors: {where}.")
        yield from (f"{name}: {text}" if len(scenes) > 1 else text for text in found)


def largest_errors(scene: SceneICs) -> dict[str, xr.Dataset]:
    """Return the largest errors of the approximations of the main body, by group of components, over variant.

    Variables: `error` with its `estimate` and `weight`, the `component` where it is largest, whether this one
    `vanishes`, and the `verdict` of all components of the group. ICs that were not computed are left out.
    """
    errors = worst_errors(scene.errors, main_body(scene.ics.body.values))[["error", "weight", "vanishes"]]
    errors = errors.assign(estimate=errors.error.sel(variant="C", drop=True))
    variants = [name for name in map(str, errors.variant.values) if not name.startswith("C")]
    allowed, groups = tolerance(scene.ics), {}
    for words, members in GROUPS.items():
        names = [component for component in members if component in components_in(scene.ics)]
        if not names:
            continue
        parts = [errors.sel(i=name[0], j=name[1], drop=True) for name in names]
        each = xr.concat(parts, xr.Variable("component", names)).sel(variant=variants)
        each = each.dropna("variant", subset=["error"])
        by_ics = [each.sel(variant=name) for name in each.variant.values]
        verdicts = [verdict(one.error, one.estimate, allowed) for one in by_ics]
        worst = each.isel(component=each.error.argmax("component"))
        groups[words] = worst.assign(verdict=("variant", verdicts))
    return groups


def answer_table(scenes: Scenes) -> Table:
    """Return the largest errors by group of components, a row for each of the ICs and scenes."""
    found = {name: largest_errors(scene) for name, scene in scenes.items()}
    several, groups = len(scenes) > 1, next(iter(found.values()))
    rows = []
    for variant in drawn_variants(next(iter(scenes.values())).ics, several=several):
        if variant.startswith("C"):
            continue
        for k, (name, errors) in enumerate(found.items()):
            cells = [
                _answer_cell(group.sel(variant=variant)) if variant in group.variant else Cell("–")
                for group in errors.values()
            ]
            rows.append(Row("" if k else ics_symbol(variant), [name, *cells] if several else cells))
    return Table("ICs", [*(texts("scene") if several else ()), *numbers(*groups)], rows)


def _answer_cell(worst: xr.Dataset) -> Cell:
    """Return whether an error is within the tolerance; below, the error with its component and weight."""
    component, mark = worst.component.item(), VANISHING if worst.vanishes.item() else ""
    place = "" if component == "nn" else f" ({component}{mark})"
    below = _error_text(worst) + place
    if worst.weight.item() > ROUNDING and component != "nn":
        below = f"{below}; weight {percent(worst.weight.item())}"
    return Cell(worst.verdict.item(), below=below)


def _error_text(worst: xr.Dataset) -> str:
    """Return an error with its estimate in percent."""
    return f"{with_estimate(100 * worst.error, 100 * max(worst.estimate.item(), LEAST_ESTIMATE))} %"


def _sections(scenes: Scenes, details: Iterable[Section | Folded]) -> Iterator[Section | Folded]:
    ics, several = next(iter(scenes.values())).ics, len(scenes) > 1
    lengths = ", ".join(f"{name}: {scene.ics.reference_length:g} mm" for name, scene in scenes.items())
    shown = {name: scene.ics for name, scene in scenes.items()}
    allowed = join_words(dict.fromkeys(share_text(tolerance(one)) for one in shown.values()))
    answer = ANSWER.format(main_body(ics.body.values), ", ".join(lines_in(ics)), allowed)
    reading = SEVERAL_SCENES.format(lengths) if several else ONE_SCENE
    yield Section("", [Note(answer), chart(shown), Note(reading)])
    if (further := further_chart(shown)).cells:
        yield Folded("ICs on the other lines, and of each body", [further])
    yield Folded("Errors of each body on each line", list(_error_tables(scenes)))
    yield from details


def _error_tables(scenes: Scenes) -> Iterator[Block]:
    """Yield the measure, and tables of the largest errors and of root mean squares by body and line."""
    yield Note(
        f"{MEASURE} Rows “C ±”: the estimated error of C. Rows “C (solid)”: C of the solid engine minus C. "
        f"{COMPONENTS}"
    )
    ics = next(iter(scenes.values())).ics
    largest = {name: scene.errors for name, scene in scenes.items()}
    rms = {name: errors.assign(error=errors.rms).drop_vars("weight") for name, errors in largest.items()}

    def tables(errors: Mapping[str, xr.Dataset], heading: str) -> Iterator[Section]:
        for body in map(str, ics.body.values):
            by_line = {
                line: {name: part.sel(body=body, line=line) for name, part in errors.items()}
                for line in lines_in(ics)
            }
            components, variants = components_in(ics), [*map(str, ics.variant.values)]
            yield Section(
                heading.format(body),
                [error_table(line, part, components, variants) for line, part in by_line.items()],
            )

    yield from tables(largest, ERRORS_HEADING)
    note = Note("Root mean square error over a line, relative to the same scale as the errors above.")
    yield Folded("RMS errors along the lines", [note, *tables(rms, "{}")])


def error_table(
    caption: str, errors: Mapping[str, xr.Dataset], components: Sequence[str], variants: Sequence[str]
) -> Table:
    """Return errors of one body by scene, with the dims variant, i and j; a row per variant and scene."""
    several = len(errors) > 1
    rows = [
        error_row(
            "" if k else row_name(variant),
            part.sel(variant=variant),
            components,
            is_estimate=variant == "C",
            place=name if several else "",
        )
        for variant in variants
        for k, (name, part) in enumerate(errors.items())
    ]
    return Table(caption, [*(texts("scene") if several else ()), *numbers(*components)], rows)


def worst_errors(errors: xr.Dataset, body: str) -> xr.Dataset:
    """Return the errors of a body, the worst over the lines."""
    return errors.sel(body=body).max("line", skipna=False)


def row_name(variant: str) -> str:
    """Return the name of a variant's row in tables of errors: that of C has its estimate."""
    return "C ±" if variant == "C" else ics_symbol(variant)
