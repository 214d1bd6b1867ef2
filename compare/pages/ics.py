"""The page of ICs of one scene or of several: errors against C, curves, accuracy, cost and settings.

All is drawn from the datasets of `femic.results.ics_dataset`. One scene is shown in µm/kN over mm, several
ones dimensionless: per unit total load, times E of the lower body and the reference length L.
"""

import json
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, product
from typing import NamedTuple

import numpy as np
import xarray as xr

from compare.report.charts import MOST_MARKERS, Chart, Curve, Panel, mark_points, simple_chart
from compare.report.errors import COMPONENTS, ERRORS_HEADING, MEASURE, VANISHING, error_row, percent
from compare.report.looks import Look, drawing_order, ics_looks, ics_symbol
from compare.report.parts import Block, Folded, Note, Page, Picture, Section, Verbatim, join_words
from compare.report.tables import Cell, Row, Table, numbers, texts, with_estimate
from compare.report.thinning import thin_together
from compare.report.verdicts import NO, NOT_DECIDED, YES, verdict
from femic.ic_errors.error_measure import ROUNDING
from femic.scenes.file import SceneFile

# --- the page -------------------------------------------------------------------------------------------


class SceneICs(NamedTuple):
    """The ICs of a scene, as in `ics.nc`, and their errors, as in `errors.nc`."""

    ics: xr.Dataset
    errors: xr.Dataset


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


def combined_first(bodies: Iterable[str]) -> list[str]:
    """Return bodies in their order, but both together first."""
    return sorted(map(str, bodies), key=lambda body: body != "combined")


def main_body(bodies: Iterable[str]) -> str:
    """Return the body that pages speak of: both together, or else the first."""
    return combined_first(bodies)[0]


def components_in(ics: xr.Dataset) -> list[str]:
    """Return the components that a scene compares."""
    return list(json.loads(ics.attrs["components"]))


def lines_in(ics: xr.Dataset) -> list[str]:
    """Return the names of the lines in their order."""
    return list(dict.fromkeys(map(str, ics.line.values)))


def _first_component(components: Sequence[str]) -> str:
    return "nn" if "nn" in components else components[0]


# --- one scene in detail --------------------------------------------------------------------------------


SETUP = (
    "Unit loads act on a patch of {} × {} mm at s = {:g} mm. A body without an outline consists of its "
    "contour, straight flanks, and a far arc about the contact centre. The far arc and both ends are "
    "clamped (harmonic engine: the bodies are infinite along x); contour and flanks are free. This far "
    "shape is a convention of this program. A body with an outline has its own shape and supports; the "
    "far radius is its size. The rigid-body motion is subtracted."
)
ACCURACY = (
    "Largest estimated error of C over components and lines, on two scales. The first is relative to the "
    "component itself, as in the tables above. The second is the scale of refinement: the larger of max "
    "|C_ij| and 0.05 max |C_nn| on the line. The tolerance applies to the second scale, so that small "
    "components do not need arbitrarily many cells. The parts on the second scale come from the mesh, "
    "from the size of the domain (none if you give the far arc) and, for the harmonic engine, from the "
    "interpolation between wavenumbers. Each part is shown where it is largest."
)
AGREEMENT = (
    "Comparison with the solid engine, which shares only the contours with the harmonic engine. The table "
    "shows the difference between the two, and for the critical component the difference and the sum of "
    "both estimated errors. Values are relative to the component itself; where it vanishes (†), to 0.05 "
    "max |C_nn|."
)
COSTS = (
    "Memory: the peak of the worker process up to the end of the model. Seconds: measured in the run that "
    "solved the model; stored models are not solved again. Seconds for each of the ICs at all points ({} "
    "ICs; for C, the sum over its models): {}."
)
DISCOUNT = (
    "Rigid-body discount M [mm/N; 1/N; 1/(N mm)] per body, axes x, y, z, φ (rotation about x through the "
    "contact centre); chosen so that C_jj = A_jj three elements away along x, with the rotation read at "
    "|s| = {:g} mm:"
)
BODY_ROWS = {
    "E": "E [MPa]",
    "nu": "ν",
    "rolling_radius": "rolling radius [mm]",
    "hub_radius": "clamped at a hub of radius [mm]",
    "far_radius": "far radius [mm]",
    "domain_factor": "far radius / first far radius",
    "half_length": "half-length along x [mm]",
    "smallest_cell": "smallest cell, at the patch [mm]",
    "cells_factor": "smallest cell / first smallest cell",
    "has_outline": "outline given",
    "far_radius_given": "far radius given",
}
STAGES = "mesh", "assembly", "solution"


def details(scene: SceneICs, pictures: Sequence[Chart | Picture]) -> Iterator[Folded]:
    """Yield the bodies with their pictures, the accuracy of C, cost and settings."""
    attributes = scene.ics.attrs
    bodies, domain, models = (json.loads(attributes[name]) for name in ("bodies", "domain", "models"))
    solved = {name: bodies[name] | sizes for name, sizes in domain.items()}
    shown = {True: "yes", False: "no", None: "–"}
    rows = [
        Row(head, [shown[v] if v is None or isinstance(v, bool) else f"{v:.6g}" for v in values])
        for key, head in BODY_ROWS.items()
        for values in [[body[key] for body in solved.values()]]
    ]
    setup = SETUP.format(f"{2 * attributes['a']:g}", f"{2 * attributes['b']:g}", attributes["load_s"])
    yield Folded("The scene", [setup, Table("body", list(solved), rows, is_text=True), *pictures])
    checked: list[Block] = [AGREEMENT, agreement_table(scene)] if "estimate_solid" in scene.ics else []
    yield Folded("Accuracy of C", [ACCURACY, accuracy_table(scene), *checked])

    sizes = [
        Row(
            name,
            [
                *(Cell(cost[key], ",d") for key in ("cells", "unknowns")),
                *(Cell(cost["seconds"].get(stage, 0.0), ".1f") for stage in STAGES),
                Cell(cost["peak_memory"], ".0f"),
            ],
        )
        for name, cost in models.items()
    ]
    solvers = [
        Row(name, [cost["solver"], ", ".join(map(str, cost["iterations"])), Cell(cost["residual"], ".0e")])
        for name, cost in models.items()
    ]
    first = str(scene.ics.body.values[0])
    seconds = {name: value for (name, body), value in _seconds(scene.ics).items() if body == first}
    each = ", ".join(f"{ics_symbol(name)}: {value:.2g} s" for name, value in seconds.items())
    heads = ["cells", "unknowns", *(f"{stage} [s]" for stage in STAGES), "memory [MB]"]
    solver_heads = [*texts("solver", "iterations"), *numbers("residual")]
    tables = [Table("model", heads, sizes), Table("model", solver_heads, solvers)]
    costs = Note(COSTS.format(first, each))
    yield Folded("Cost", [*tables, costs])
    yield Folded("Settings", list(_settings(scene.ics)))


def _seconds(ics: xr.Dataset) -> dict[tuple[str, str], float]:
    """Return the seconds of the ICs that could be computed, by variant and body."""
    seconds = json.loads(ics.attrs["seconds"])
    computed = {
        (str(v), str(b)): seconds[f"{v} {b}"] for b, v in product(ics.body.values, ics.variant.values)
    }
    return {key: value for key, value in computed.items() if not np.isnan(value)}


def accuracy_table(scene: SceneICs) -> Table:
    """Return the estimated error of C of each solved body on both scales, and its parts."""
    components, lines, rows = components_in(scene.ics), lines_in(scene.ics), []
    for body in map(str, scene.errors.solved.values):
        known = scene.errors.sel(solved=body)
        shares = [known.solved_error.where(~known.solved_vanishes), *known.solved_refinement]
        cells = []
        for values in shares:
            places = [
                (values.sel(i=component[0], j=component[1], line=line).item(), component, line)
                for component, line in product(components, lines)
            ]
            known_places = [place for place in places if not np.isnan(place[0])]
            cells.append("{:.2%} ({} on {})".format(*max(known_places)) if known_places else "–")
        vanishing = [c for c in components if bool(known.solved_vanishes.sel(i=c[0], j=c[1]))]
        rows.append(Row(body, [*cells, ", ".join(vanishing) or "–"]))
    scales = "relative to the component itself", "on the scale of refinement"
    parts = [f"from the {part}" for part in map(str, scene.errors.part.values[1:])]
    return Table("body", [*scales, *parts, "vanishing"], rows, is_text=True)


def agreement_table(scene: SceneICs) -> Table:
    """Return the differences between C of both engines, and whether all are within their estimates."""
    rows = []
    for place, both in _both_engines(scene).items():
        closest = max(both, key=lambda c: both[c][0] / max(both[c][1], ROUNDING))
        largest = max(both, key=lambda c: (VANISHING not in c, both[c][0]))
        cells = [
            f"{both[largest][0]:.2%} ({largest})",
            f"{closest}: {both[closest][0]:.2%} of {both[closest][1]:.2%}",
            YES if all(_agree(*each) for each in both.values()) else NO,
        ]
        rows.append(Row(place, cells))
    heads = ["largest difference", "closest to the sum of the estimated errors", "within"]
    return Table("body, line", heads, rows, is_text=True)


def disagreements(scene: SceneICs) -> list[str]:
    """Return where C of both engines differs by more than both estimates: bodies, lines and components."""
    return [
        f"{place}, {component}"
        for place, both in _both_engines(scene).items()
        for component, each in both.items()
        if not _agree(*each)
    ]


def _both_engines(scene: SceneICs) -> dict[str, dict[str, tuple[float, float]]]:
    """Return differences between C of both engines and sums of their estimates [-].

    By body and line, and by component, marked where it vanishes; empty without a check.
    """
    if "estimate_both" not in scene.errors:
        return {}
    found = {}
    for body, line in product(map(str, scene.ics.body.values), lines_in(scene.ics)):
        errors = scene.errors.sel(body=body, line=line)
        values = errors.error.sel(variant="C_solid"), errors.estimate_both
        found[f"{body}, {line}"] = {
            component + (VANISHING if bool(errors.vanishes.sel(at)) else ""): tuple(
                each.sel(at).item() for each in values
            )
            for component in components_in(scene.ics)
            for at in [{"i": component[0], "j": component[1]}]
        }
    return found


def _agree(difference: float, estimate: float) -> bool:
    return difference <= max(estimate, ROUNDING)


def _settings(ics: xr.Dataset) -> Iterator[Block]:
    yield DISCOUNT.format(ics.rotation_reach)
    for body in map(str, ics.solved.values):
        entries = [
            f"M_{a}{b} = {value:.4g}"
            for (p, a), (q, b) in product(enumerate(ics.axis.values), enumerate(ics.axis_.values))
            if p <= q and (value := ics.discount.sel(solved=body, axis=a, axis_=b).item()) != 0
        ]
        yield Note(f"{body}: {'; '.join(entries)}")
    rows = [
        Row(name, [value if isinstance(value, str) else f"{value:.4g}"])
        for name, value in json.loads(ics.attrs["settings"]).items()
    ]
    yield Table("setting", ["value"], rows, is_text=True)
    yield Folded("Scene file", [Verbatim(ics.attrs["scene"])])
    yield Note(", ".join(f"{name} {version}" for name, version in json.loads(ics.attrs["versions"]).items()))


# --- curves along lines ---------------------------------------------------------------------------------


INVISIBLE = 1e-9  # dimensionless IC below which a curve is rounding
ESTIMATES = {"C": "estimate", "C_solid": "estimate_solid"}  # variables with the errors of both engines
RESOLUTION = 1000  # of the ordinates of a panel: finer details are not drawn
MIRRORED = 1e-6  # largest asymmetry of mirrored curves, as a share of the largest value on their line
OVERLAID_VARIANTS = ("A", "B", "Bhat")  # drawn of several scenes; tables also have the others
DASHES = ("solid", "dash", "dot", "dashdot", "longdash")  # of the scenes
WIDE_LINE, NARROW_LINE = 3.2, 1.2  # line widths, rear to front: curves that coincide stay visible


def chart(scenes: Mapping[str, xr.Dataset]) -> Chart:
    """Return ICs of scenes on the main line, and their differences from C, a step per component.

    Halves of lines that repeat the other half in all scenes are left out.
    """
    ics = next(iter(scenes.values()))
    body, line = main_body(ics.body.values), main_line(ics)
    steps = {component: _with_differences(scenes, body, line, component) for component in components_in(ics)}
    return Chart("curves", steps, 2, "component", start=_first_component(components_in(ics)))


def further_chart(scenes: Mapping[str, xr.Dataset]) -> Chart:
    """Return the same on the other lines, and the ICs of the other bodies on the main line."""
    ics = next(iter(scenes.values()))
    (body, *others), line = combined_first(ics.body.values), main_line(ics)
    steps = {}
    for component in components_in(ics):
        on_others = [_with_differences(scenes, body, one, component) for one in lines_in(ics) if one != line]
        of_others = [
            _panel(f"{other}, {line}", _parts(scenes, other, line, component), _looks(scenes))
            for other in others
        ]
        steps[component] = [*chain.from_iterable(on_others), *of_others]
    return Chart(
        "further_curves", steps, 2, "component", heights=0.75, start=_first_component(components_in(ics))
    )


def main_line(ics: xr.Dataset) -> str:
    """Return the line that pages show first: the first one across the bodies, or else the first."""
    across = [line for line in lines_in(ics) if np.ptp(ics.s.values[ics.line.values == line]) > 0]
    return [*across, *lines_in(ics)][0]


def _with_differences(scenes: Mapping[str, xr.Dataset], body: str, line: str, component: str) -> list[Panel]:
    """Return the panel of ICs of scenes on a line, and that of their differences from C."""
    parts, looks, title = _parts(scenes, body, line, component), _looks(scenes), f"{body}, {line}"
    minus_c = {n: one.assign(ic=one.ic - one.ic.sel(variant="C", drop=True)) for n, one in parts.items()}
    differences = _panel(f"{title}: minus C", minus_c, looks)
    return [_panel(title, parts, looks), replace(differences, up=f"Δ{differences.up}")]


def _parts(scenes: Mapping[str, xr.Dataset], body: str, line: str, component: str) -> dict[str, xr.Dataset]:
    """Return a component of a body on a line by scene; the half of it where the other half repeats it."""
    parts = {n: along_line(one, line, body, component, len(scenes) > 1) for n, one in scenes.items()}
    if all(is_mirrored(one, line) for one in scenes.values()):
        return {n: part.isel(point=part["at"].values >= 0) for n, part in parts.items()}
    return parts


def component_chart(ics: xr.Dataset, component: str) -> Chart:
    """Return one component of labelled ICs, dimensionless: a row per body, a column per line."""
    lines, length = lines_in(ics), f",  L = {ics.reference_length:g} mm"
    looks = _looks({"": ics})
    panels = [
        _panel(f"{component}, {body}, {line}", {"": along_line(ics, line, body, component, True)}, looks)
        for body, line in product(map(str, ics.body.values), lines)
    ]
    return simple_chart(
        "curves", [replace(panel, across=panel.across + length) for panel in panels], len(lines)
    )


def along_line(ics: xr.Dataset, line: str, body: str, component: str, dimensionless: bool) -> xr.Dataset:
    """Return a component of a body along a line, and its estimates, over the coordinate `at`.

    Attributes name the axes and have the value that is rounding. Units: mm and µm/kN, or dimensionless.
    """
    scale = ics.reference_E * ics.reference_length
    unit, length = (scale, ics.reference_length) if dimensionless else (1e6, 1.0)
    on_line = ics.isel(point=np.flatnonzero(ics.line.values == line))
    along = "x" if np.ptp(on_line.s.values) == 0 else "s"
    names = [name for name in ("ic", *ESTIMATES.values()) if name in ics]
    part = on_line[names].sel(body=body, i=component[0], j=component[1]) * unit
    at = on_line[along].values / length
    bodies = json.loads(ics.attrs.get("bodies", "{}")).values() if along == "s" and not dimensionless else ()
    return part.assign_coords(at=("point", at)).assign_attrs(
        across=f"{along} / L  [-]" if dimensionless else f"{along} [mm]",
        up=f"{component} · E · L  [-]" if dimensionless else f"{component} [µm/kN]",
        least=INVISIBLE * unit / scale,
        marks=sorted({round(s, 9) for body in bodies for s in body["joints"]}),
    )


def is_mirrored(ics: xr.Dataset, line: str) -> bool:
    """Whether the two halves of a line have the same values, up to the sign, in all curves of a scene."""
    on_line = ics.isel(point=np.flatnonzero(ics.line.values == line))
    if np.ptp(on_line.s.values) == 0:
        return True  # every body and every load is symmetric in x
    s = on_line.s.values
    sizes = np.stack([abs(on_line.ic.sel(i=c[0], j=c[1]).values) for c in components_in(ics)])
    asymmetry = np.nanmax(np.abs(sizes - sizes[..., ::-1]))
    return np.allclose(s, -s[::-1]) and bool(asymmetry <= MIRRORED * np.nanmax(sizes))


def drawn_variants(ics: xr.Dataset, *, several: bool) -> list[str]:
    """Return the variants of a scene; of several those of `OVERLAID_VARIANTS`, if there are any, and C."""
    names = [str(name) for name in ics.variant.values]
    overlaid = [name for name in names if name in OVERLAID_VARIANTS]
    return [*overlaid, "C"] if overlaid and several else names


def _looks(scenes: Mapping[str, xr.Dataset]) -> dict[tuple[str, str], Look]:
    """Return looks by variant and scene, from the curves at the bottom to those on top.

    Variants have colours; of several scenes, these have dashes, and wide lines lie behind narrow ones.
    """
    variants = drawn_variants(next(iter(scenes.values())), several=len(scenes) > 1)
    looks = ics_looks(variants)
    if len(scenes) == 1:
        return {(variant, name): looks[variant] for name in scenes for variant in drawing_order(variants)}
    widths = np.linspace(WIDE_LINE, NARROW_LINE, len(variants))
    return {
        (variant, name): Look(looks[variant].colour, dash, width=round(width, 2))
        for variant, width in zip(["C", *(v for v in variants if v != "C")], widths, strict=True)
        for name, dash in zip(scenes, DASHES, strict=False)
    }


def _panel(title: str, parts: Mapping[str, xr.Dataset], looks: Mapping[tuple[str, str], Look]) -> Panel:
    """Return the panel of ICs of `along_line` by scene; those that were not computed are left out.

    Lines have the points that one sees.
    """
    curves, part = [], next(iter(parts.values()))
    span = max(float(one.ic.max() - one.ic.min()) for one in parts.values())
    chosen = {name: _visible_points(one, max(span, part.least) / RESOLUTION) for name, one in parts.items()}
    for (variant, name), look in looks.items():
        part = parts[name].isel(point=chosen[name]) if look.dash else parts[name]
        values, estimate = part.ic.sel(variant=variant).values, ESTIMATES.get(variant)
        if not np.all(np.isnan(values)):
            band = part[estimate].values if estimate in part else None
            symbol = ics_symbol(variant)
            label = f"{symbol}, {name}" if len(parts) > 1 else symbol
            curves.append(mark_points(Curve(label, part["at"].values, values, look, band)))
    at = part["at"].values
    marks = [mark for mark in part.attrs.get("marks", ()) if at[0] <= mark <= at[-1]]
    return Panel(title, part.across, part.up, curves, marks=marks, least=part.least)


def _visible_points(part: xr.Dataset, resolution: float) -> list[int]:
    """Return the points that all curves and bands need; where each point has a marker, all of them."""
    if part.sizes["point"] <= MOST_MARKERS:
        return list(range(part.sizes["point"]))
    bands = [part[name].values for name in ESTIMATES.values() if name in part]
    return thin_together(
        part["at"].values, np.vstack([part.ic.transpose("variant", "point"), *bands]), resolution
    )
