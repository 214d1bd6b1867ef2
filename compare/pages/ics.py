"""`femic run` computes a scene and writes its results, figures and page into a folder.

The page has its ICs against C: the result in three sentences; errors, accuracy of C, cost and settings on
request.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages.fields import write_fields
from compare.pages.ics_figures import COST, CURVES, SCENE, RunOutput, figures, main_body
from compare.report.errors import COMPONENTS, ERRORS_HEADING, MEASURE, VANISHING, error_row, percent
from compare.report.looks import symbol_of
from compare.report.parts import Block, Folded, Items, Note, Page, Section, Verbatim, join_words, write_page
from compare.report.tables import Cell, Row, Table, numbers, texts
from femic.cache import folders
from femic.cache.digests import PAGE_FOLDERS, results_digest, versions
from femic.cache.files import write_dataset, write_text
from femic.ic_errors.error_measure import ROUNDING
from femic.reference.discount import AXES
from femic.reference.engine import Cost
from femic.reference.job import component_of
from femic.reference.result import worst
from femic.reference.run_options import DEFAULT, RunOptions, factors
from femic.results import ics_dataset as data
from femic.results.ics import (
    Results,
    compute,
    engine_differences,
    measure_of,
    reference_of,
    refinement_scales_of,
)
from femic.results.ics_dataset import settings
from femic.scenes import receipts
from femic.scenes.plausibility import warnings
from femic.scenes.scene import Scene
from geometries.bodies import Body

# --- the run --------------------------------------------------------------------------------------------


COMMAND = "run"
FILES = ("ics.nc", "errors.nc", "report.html")


def run_scene(scene: Scene, out: Path, options: RunOptions = DEFAULT) -> Path:
    """Compute the scene; write `ics.nc`, `errors.nc`, CSV files, figures and `report.html`; return its path.

    Solved models are stored, so that an interrupted run continues after the last of them.
    """
    with receipts.renewed(out, COMMAND, key_of(scene), FILES):
        results = compute(scene, options)
        dataset = data.to_dataset(results)
        errors = data.errors(results, dataset)
        write_dataset(dataset, out / "ics.nc")
        write_dataset(errors, out / "errors.nc")
        data.write_curves(dataset, scene.components, out)
        write_text(scene.text, out / "scene.toml")
        output = RunOutput(results, dataset, errors, folders.make(out / "figures"))
        path = write_page(page_of(output), out / "report.html")
        if scene.fields:
            write_fields(results, out / "fields", options.watch)
    return path


def key_of(scene: Scene) -> str:
    """Return the key of all inputs of the ICs and errors of a scene."""
    return receipts.key_of(scene, results_digest(*PAGE_FOLDERS))


# --- the page -------------------------------------------------------------------------------------------


ACCURACY = (
    "Estimated error of C, worst over components and lines, on two scales: as a share of the component "
    "itself, as in the tables above; and on the scale of refinement, the larger of max |C_ij| and 0.05 max "
    "|C_nn| on the line, to which the tolerance applies, so that small components do not require arbitrarily "
    "many cells. Its parts on the latter: from the mesh, from the size of the domain and (harmonic engine) "
    "from the interpolation between wavenumbers, each at its worst place. Then cells and domain of the model."
)
AGREEMENT = (
    "The same computed with the solid engine, which shares only the contours with the harmonic one: the "
    "difference of its C from C, and whether it is within the sum of both estimates (the component closest "
    "to the sum). Shares of the component itself; with † of 0.05 max |C_nn|, where it vanishes."
)
HOLLOW = "A mark per component; hollow: C vanishes, share of 0.05 max |C_nn|. Marks of C: its estimate."
STAGES = "mesh", "assembly", "solution"


def page_of(output: RunOutput) -> Page:
    """Return the page of a scene."""
    results, errors = output.results, output.errors
    answer = _error_table("error", results, worst_errors(results, errors))
    return Page(results.scene.title, summary(results, errors), _sections(output), answer)


def _error_table(caption: str, results: Results, errors: xr.Dataset) -> Table:
    """Return errors of one body, a row per variant."""
    components = results.scene.components
    rows = [
        error_row(row_name(name), errors.sel(variant=name), components, is_estimate=name == "C")
        for name in results.variants
    ]
    return Table(caption, numbers(*components), rows)


def row_name(variant: str) -> str:
    """Return the name of a variant's row in tables of errors: that of C has its estimate."""
    return "C ±" if variant == "C" else symbol_of(variant)


def _sections(output: RunOutput) -> Iterator[Section | Folded]:
    results = output.results
    if notes := warnings(results.scene):
        yield Section("", [Note("Before relying on these numbers, note:"), Items(notes)])
    yield Section("", [Note(_answer_text(results)), *figures(output, CURVES), Note(_curves_text(results))])
    yield Folded("Errors of each body on each line", list(_errors(results, output.errors)))
    yield Folded(SCENE, [_setup(results), *figures(output, SCENE)])
    yield Folded("Accuracy of C", list(_accuracy(results)))
    yield Folded(COST, [*figures(output, COST), HOLLOW, *_cost_tables(results), Note(_cost_text(results))])
    yield Folded("Settings", list(_settings(results)))


def _answer_text(results: Results) -> str:
    return (
        f"Largest difference from C {_main_body_name(results)} over all lines: as a share of the component; "
        "small: of C_nn. C ±: the estimated error of C. †: vanishes in C."
    )


def _main_body_name(results: Results) -> str:
    return body_name(main_body(results.scene.compared))


def _errors(results: Results, errors: xr.Dataset) -> Iterator[Block]:
    """Yield the measure, and tables of the largest errors and of root mean squares by body and line."""
    solid = "; rows “C (solid)”: the difference of the solid engine's C from it" if results.checks else ""
    yield Note(f"{MEASURE} Rows “C ±”: the estimated error of C itself{solid}. {COMPONENTS}")
    if best := "; ".join(closest(results, errors)):
        yield f"Closest to C {_main_body_name(results)}: {best}."
    for body in results.scene.compared:
        yield Section(ERRORS_HEADING.format(body), list(_line_tables(results, errors.sel(body=body))))
    rms = errors.assign(error=errors.rms, weight=np.nan)
    tables = [
        Section(body, list(_line_tables(results, rms.sel(body=body)))) for body in results.scene.compared
    ]
    note = Note("Root mean squares over a line, shares of the same scale as the errors above.")
    yield Folded("RMS errors along the lines", [note, *tables])


def _line_tables(results: Results, body_errors: xr.Dataset) -> Iterator[Table]:
    for line in results.lines:
        yield _error_table(line, results, body_errors.sel(line=line))


def _setup(results: Results) -> str:
    scene = results.scene
    bodies = "; ".join(
        f"{name} body: E = {body.material.E:g} MPa, ν = {body.material.nu:g}, {_shape(body)}"
        for name, body in scene.bodies.items()
    )
    ends = (
        " (the bodies are infinite along x)" if scene.settings.engine.infinite_length else " as both ends are"
    )
    place = "the contact centre" if scene.patch.s == 0 else f"s = {scene.patch.s:g} mm"
    return (
        f"{bodies}. Unit loads on a patch of {2 * scene.patch.a:g} × {2 * scene.patch.b:g} mm at {place}. "
        f"{_closure_text(scene, ends)} The resulting rigid-body motion is discounted."
    )


def _closure_text(scene: Scene, ends: str) -> str:
    """Return sentences on the shape and the supports of the bodies, by how they are closed."""
    outlines = [name for name, body in scene.bodies.items() if body.outline is not None]
    given = f"The {' and the '.join(outlines)} body has the shape and the supports of its outline."
    arcs = (
        f"{'The other' if outlines else 'Each'} body is its contour, continued by straight flanks and closed "
        f"by a far arc about the contact centre, which is clamped{ends}; contour and flanks are free. The "
        "shape of the body far away is a convention of this program."
    )
    if scene.bodies["lower"].domain.radius_given:
        arcs += (
            " The far arc is where the scene puts it, a support of the body: the estimate has no part of its "
            "distance."
        )
    return " ".join([*([given] if outlines else []), *([arcs] if len(outlines) < len(scene.bodies) else [])])


def _far(body: Body) -> str:
    """Return what the far radius of a body is."""
    arc = "given far arc" if body.domain.radius_given else "far arc"
    return arc if body.outline is None else "outline up to"


def _shape(body: Body) -> str:
    if np.isinf(body.rolling_radius):
        return "extruded"
    if body.outline is not None:
        return f"revolved, rolling radius {body.rolling_radius:g} mm"
    hub = f", clamped at a hub of radius {body.rolling_radius - body.depth:g} mm" if body.reaches_hub else ""
    return f"revolved, rolling radius {body.rolling_radius:g} mm{hub}"


def _curves_text(results: Results) -> str:
    circles = " Circles: C of the solid engine, with its band." if results.checks else ""
    return (
        "Components: displacement, then traction, such as sn: the displacement along s under a normal load. "
        "Displacements per total load of 1 kN without rigid-body motion; band: C ± its estimated error, "
        f"often thinner than the line.{circles} Dotted: where arc and flank join."
    )


def _accuracy(results: Results) -> Iterator[Block]:
    """Yield the accuracy of C of each solved body, and differences between both engines."""
    yield ACCURACY
    columns = [_accuracy_texts(results, name) for name in results.jobs]
    rows = [Row(name, [column[name] for column in columns]) for name in columns[0]]
    yield Table("body", list(results.jobs), rows, is_text=True)
    if results.checks:
        yield AGREEMENT
        yield agreement_table(results)


def _accuracy_texts(results: Results, name: str) -> dict[str, str]:
    """Return the accuracy of C of a solved body, on both scales, with its cells and domain."""
    job, reference, scale = results.jobs[name], results.references[name], refinement_scales_of(results, name)
    error, component, line = worst(job, reference.c.estimate, scale)
    c, (cells, domain) = reference.c, factors(reference.level)
    parts = {"mesh": c.mesh_error, "domain": c.truncation_error, "wavenumbers": c.waves_error}
    return {
        "share of the component itself": _largest_estimate(results, name),
        "on the scale of refinement": f"{error:.2%} ({component} on {line})",
        **{f"from the {part}": f"{worst(job, values, scale)[0]:.2%}" for part, values in parts.items()},
        "cells": f"{reference.cells.smallest:.3g} mm at the patch (first × {cells:.3g})",
        "size": f"{_far(reference.body)} {reference.body.domain.far_radius:g} mm, {_length(reference.body)} "
        f"(first × {domain:.3g})",
    }


def _largest_estimate(results: Results, body: str) -> str:
    """Return the largest estimate of C as a share of the component itself, and the components that vanish."""
    measure, components = measure_of(results, body), results.scene.components
    vanishing = [component for component in components if component_of(measure.vanishing, component)]
    errors = [
        (component_of(line_shares, component), component, line)
        for line, line_shares in measure.shares(reference_of(results, body).estimate).items()
        for component in components
        if component not in vanishing
    ]
    largest = "{:.2%} ({} on {})".format(*max(errors)) if errors else "–"
    return largest + (f"; vanishing: {', '.join(vanishing)}" if vanishing else "")


def agreement_table(results: Results) -> Table:
    """Return the differences between C of both engines, and whether all are within their estimates."""
    heads, rows = ["largest difference", "closest to the sum of the estimates", "within"], []
    for body in results.scene.compared:
        differences, allowed = engine_differences(results, body)
        vanishing = measure_of(results, body).vanishing
        marks = {c: VANISHING if component_of(vanishing, c) else "" for c in results.scene.components}
        for line in results.lines:
            both = {c: tuple(component_of(of[line], c) for of in (differences, allowed)) for c in marks}
            closest = max(both, key=lambda c: both[c][0] / max(both[c][1], ROUNDING))
            largest = max(both, key=lambda c: (not marks[c], both[c][0]))
            within = all(difference <= max(estimate, ROUNDING) for difference, estimate in both.values())
            cells = [
                f"{both[largest][0]:.2%} ({largest}{marks[largest]})",
                f"{closest}{marks[closest]}: {both[closest][0]:.2%} of {both[closest][1]:.2%}",
                "yes" if within else "no",
            ]
            rows.append(Row(f"{body}, {line}", cells))
    return Table("body, line", heads, rows, is_text=True)


def _length(body: Body) -> str:
    """Return a text on the extent of a model along x."""
    if body.closed:
        return "all the way round"
    return "infinite along x" if np.isinf(body.xi_end) else f"half-length {body.xi_end:.4g} mm"


def _cost_tables(results: Results) -> list[Table]:
    """Return the size and the seconds of every model, and what its solver did."""
    heads = ["cells", "unknowns", *(f"{stage} [s]" for stage in STAGES), "memory [MB]"]
    models = results.models.items()
    solvers = [
        Row(name, [cost.solver, ", ".join(map(str, cost.iterations)), Cell(cost.residual, ".0e")])
        for name, cost in models
    ]
    return [
        Table("model", heads, [Row(name, _size_cells(cost)) for name, cost in models]),
        Table("model", [*texts("solver", "iterations"), *numbers("residual")], solvers),
    ]


def _size_cells(cost: Cost) -> list[Cell]:
    return [
        *(Cell(number, ",d") for number in (cost.cells, cost.unknowns)),
        *(Cell(cost.seconds.get(stage, 0.0), ".1f") for stage in STAGES),
        Cell(cost.peak_memory, ".0f"),
    ]


def _cost_text(results: Results) -> str:
    first = results.scene.compared[0]
    each = ", ".join(
        f"{symbol_of(name)}: {results.seconds[name, first]:.2g} s" for name in results.computed(first)
    )
    return (
        "Memory: the peak of the worker process up to the end of the model. Seconds: of the run that solved "
        "the model; stored models are not solved again. Seconds of each variant on "
        f"all points ({first} ICs; C: the sum over its models): {each}."
    )


def _settings(results: Results) -> Iterator[Block]:
    scene = results.scene
    yield (
        "Rigid-body discount M [mm/N; 1/N; 1/(N mm)] per body, axes x, y, z, φ (rotation about x through "
        "the contact centre); discounted so that C_jj = A_jj three elements away along x, and the rotation "
        f"at |s| = {scene.settings.rotation_reach:g} mm:"
    )
    for name, reference in results.references.items():
        yield Note(f"{name}: {'; '.join(_entries(reference.discount))}")
    rows = [
        Row(name, [value if isinstance(value, str) else f"{value:.4g}"])
        for name, value in settings(scene).items()
    ]
    yield Table("setting", ["value"], rows, is_text=True)
    yield Folded("Scene file", [Verbatim(scene.text)])
    yield Note(", ".join(f"{name} {version}" for name, version in versions().items()))


def _entries(discount: np.ndarray) -> list[str]:
    return [
        f"M_{AXES[a]}{AXES[b]} = {discount[a, b]:.4g}"
        for a in range(4)
        for b in range(a, 4)
        if discount[a, b] != 0
    ]


# --- the result in three sentences ----------------------------------------------------------------------


COUNTS = 0.01  # share of max |C_nn|; smaller errors do not count


def worst_errors(results: Results, errors: xr.Dataset) -> xr.Dataset:
    """Return the errors of the first body, the worst over the lines."""
    return errors.sel(body=main_body(results.scene.compared)).max("line", skipna=False)


def body_name(body: str) -> str:
    """Return a body as texts name it."""
    return "of both bodies together" if body == "combined" else f"of the {body} body"


def computed_variants(results: Results) -> list[str]:
    """Return the approximations that could be computed for the first body."""
    names = results.computed(main_body(results.scene.compared))
    return [name for name in names if name in results.scene.variants]


def summary(results: Results, errors: xr.Dataset) -> str:
    """Return how far the approximations are from C in nn and elsewhere, by weight, and how good C is."""
    worst, components = worst_errors(results, errors), results.scene.components
    variants, others = (
        computed_variants(results),
        [component for component in components if component != "nn"],
    )
    sentences = []
    if variants and "nn" in components:
        sentences.append(_nn_sentence(worst, variants, body_name(main_body(results.scene.compared))))
    if variants and others:
        other = "other " if sentences else ""
        sentences.append(_others_sentence(worst, variants, others, other))
    return " ".join([*sentences, _accuracy_sentence(results, worst)])


def _nn_sentence(worst: xr.Dataset, variants: Sequence[str], body: str) -> str:
    """Return which variants are closest to C in nn, and how far the others are off."""
    nn = worst.error.sel(i="n", j="n")
    errors = {variant: nn.sel(variant=variant).item() for variant in variants}
    closest = _least(errors, known=nn.sel(variant="C").item())
    others = [f"{symbol_of(v)} {percent(errors[v])}" for v in variants if v not in closest]
    largest = max(errors[variant] for variant in closest)
    if not others:
        return f"In nn {body}, every approximation is within {within(largest)} of C."
    names, verb = join_words(map(symbol_of, closest)), "are" if len(closest) > 1 else "is"
    return f"In nn {body}, {names} {verb} closest to C: {percent(largest)} off at most ({', '.join(others)})."


def _least(values: Mapping[str, float], known: float) -> list[str]:
    """Return the names of the least value, and of those that are no larger as far as is known."""
    least = min(values.values())
    shown = percent(least)
    return [name for name, value in values.items() if value - least <= known or percent(value) == shown]


@dataclass(frozen=True, order=True)
class WeightedError:
    """The error of a component: its weight and the error [-]."""

    weight: float
    error: float
    component: str
    vanishes: bool

    @property
    def text(self) -> str:
        """The error as a share of its component and of C_nn."""
        if self.vanishes:
            return f"{percent(self.weight)} of C_nn in {self.component}, which vanishes in C"
        return f"{percent(self.error)} of {self.component} ({percent(self.weight)} of C_nn)"


def _others_sentence(
    worst: xr.Dataset, variants: Sequence[str], components: Sequence[str], other: str
) -> str:
    """Return the errors with the largest weight in other components: of the best variants, and the worst."""
    weighted = {variant: heaviest(worst, variant, components) for variant in variants}
    best, last = min(weighted.values()), max(weighted.values())
    if last.weight < COUNTS:
        return f"No {other}component is off by more than {within(last.weight)} of C_nn."
    weights = {variant: error.weight for variant, error in weighted.items()}
    closest = _least(weights, known=heaviest(worst, "C", components).weight)
    names = join_words(map(symbol_of, closest))
    sentence = f"Among the {other}components, the heaviest error is {best.text} with {names}"
    if len(closest) == len(variants):
        return f"{sentence}."
    furthest = [symbol_of(variant) for variant in variants if weighted[variant] == last]
    return f"{sentence}; with {join_words(furthest)} it is {last.text}."


def heaviest(worst: xr.Dataset, variant: str, components: Sequence[str]) -> WeightedError:
    """Return the error of a variant with the largest weight, of errors of a body, the worst over lines."""
    by_component = {c: worst.sel(variant=variant, i=c[0], j=c[1]) for c in components}
    return max(
        WeightedError(at.weight.item(), at.error.item(), component, bool(at.vanishes))
        for component, at in by_component.items()
    )


def _accuracy_sentence(results: Results, worst: xr.Dataset) -> str:
    """Return how well C is known, and how far C of the solid engine is from it, as shares of C_nn."""
    names = ["C", *(["C_solid"] if results.checks else [])]
    known, *solid = (within(heaviest(worst, name, results.scene.components).weight) for name in names)
    check = f"; C of the solid engine is within {solid[0]}" if solid else ""
    return f"C is known to {known} of C_nn in every component{check}."


def within(share: float) -> str:
    """Return a limit that a share does not exceed, in percent."""
    return percent(share).removeprefix("< ")


def closest(results: Results, errors: xr.Dataset) -> Iterator[str]:
    """Yield the variants closest to C in each component that does not vanish, with their error."""
    worst, variants = worst_errors(results, errors), computed_variants(results)
    for component in results.scene.components if variants else ():
        at = worst.sel(i=component[0], j=component[1])
        if not at.vanishes:
            values = {variant: at.error.sel(variant=variant).item() for variant in variants}
            names = " = ".join(map(symbol_of, _least(values, known=at.error.sel(variant="C").item())))
            yield f"{component}: {names} ({percent(min(values.values()))})"
