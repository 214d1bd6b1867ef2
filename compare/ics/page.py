"""The page of a scene: errors of its ICs against C, figures, accuracy of C, cost, settings."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from compare.ics.agreement import agreement
from compare.ics.compute import Results, reference_of
from compare.ics.dataset import settings
from compare.ics.errors import measure_of, refinement_scales_of
from compare.ics.figures import COST, CURVES, SCENE, RunOutput, pictures
from compare.ics.summary import summary
from compare.report.errors import COMPONENTS, ERRORS_HEADING, MEASURE, error_row
from compare.report.parts import Block, Folded, Items, Note, Page, Section, Verbatim
from compare.report.styles import SYMBOLS
from compare.report.tables import Cell, Row, Table, cell, numbers, texts
from femic.cache.digests import versions
from femic.reference.accuracy import component_of
from femic.reference.discount import AXES
from femic.reference.level import factors
from femic.reference.models import Cost
from femic.reference.result import worst
from femic.scenes.plausibility import warnings
from geometries.bodies import Body

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


def page_of(output: RunOutput) -> Page:
    """Return the page of a scene."""
    return Page(output.results.scene.title, summary(output.results, output.errors), _sections(output))


def _sections(output: RunOutput) -> Iterator[Section]:
    results = output.results
    if notes := warnings(results.scene):
        yield Section("", [Note("Before relying on these numbers, note:"), Items(notes)])
    yield from _errors(results, output.errors)
    yield Section(SCENE, [_setup(results), *pictures(output, SCENE)])
    yield Section(CURVES, [_curves_text(results), *pictures(output, CURVES)])
    yield Section("Accuracy of C", list(_accuracy(results)))
    yield Section(COST, [*pictures(output, COST), _cost_table(results), Note(_cost_text(results))])
    yield Section("Settings", list(_settings(results)))


def _errors(results: Results, errors: xr.Dataset) -> Iterator[Section]:
    """Yield the tables of the largest errors, a section per body, and the root mean squares."""
    solid = "; rows “C (solid)”: the difference of the solid engine's C from it" if results.checks else ""
    text = f"{MEASURE} Rows “C”: the estimated error of C itself{solid}. {COMPONENTS}"
    for number, body in enumerate(results.scene.compared):
        notes = [] if number else [Note(text)]
        yield Section(ERRORS_HEADING.format(body), [_error_table(results, errors, body), *notes])
    rms = errors.assign(error=errors.rms, weight=np.nan)
    tables = [Section(body, [_error_table(results, rms, body)]) for body in results.scene.compared]
    note = Note("Root mean squares over a line, shares of the same scale as the errors above.")
    yield Section("", [Folded("RMS errors along the lines", [note, *tables])])


def _error_table(results: Results, errors: xr.Dataset, body: str) -> Table:
    components = results.scene.components
    rows = [
        error_row(
            "" if number else SYMBOLS[variant],
            errors.sel(body=body, variant=variant, line=line),
            components,
            is_estimate=variant == "C",
            place=line,
        )
        for variant in results.variants
        for number, line in enumerate(results.lines)
    ]
    return Table("variant", [*texts("line"), *numbers(*components)], rows)


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
        "Each body is its contour, continued by straight flanks and closed by a far arc about the contact "
        f"centre, which is clamped{ends}; contour and flanks are free. The resulting rigid-body "
        "motion is discounted. The shape of the body far away is a convention of this program."
    )


def _shape(body: Body) -> str:
    if np.isinf(body.rolling_radius):
        return "extruded"
    hub = f", clamped at a hub of radius {body.rolling_radius - body.depth:g} mm" if body.reaches_hub else ""
    return f"revolved, rolling radius {body.rolling_radius:g} mm{hub}"


def _curves_text(results: Results) -> str:
    scene = results.scene
    circles = "Circles: C of the solid engine ± its estimated error. " if results.checks else ""
    return (
        f"Per unit total load, times E = {scene.reference_E:g} MPa and L = {scene.reference_length:g} mm. "
        f"Grey band: C ± its estimated error (often thinner than the line). {circles}Dotted: where arc and "
        "flank join."
    )


def _accuracy(results: Results) -> Iterator[Block]:
    """Yield the accuracy of C of each solved body, and differences between both engines."""
    columns = [
        *texts("share of the component itself", "on the scale of refinement"),
        *numbers("mesh", "domain", "wavenumbers"),
        *texts("cells", "size"),
    ]
    yield ACCURACY
    yield Table("body", columns, [_accuracy_row(results, name) for name in results.jobs])
    if results.checks:
        yield AGREEMENT
        yield _agreement_table(results)


def _accuracy_row(results: Results, name: str) -> Row:
    """Return the accuracy of C of a solved body, on both scales, with its cells and domain."""
    job, reference, scale = results.jobs[name], results.references[name], refinement_scales_of(results, name)
    error, component, line = worst(job, reference.c.estimate, scale)
    parts = (reference.c.mesh_error, reference.c.truncation_error, reference.c.waves_error)
    cells, domain = factors(reference.level)
    return Row(
        name,
        [
            _largest_estimate(results, name),
            f"{error:.2%} ({component} on {line})",
            *(Cell(worst(job, part, scale)[0], ".2%") for part in parts),
            f"{reference.cells.smallest:.3g} mm at the patch (first × {cells:.3g})",
            f"far arc {reference.body.domain.far_radius:g} mm, {_length(reference.body)} "
            f"(first × {domain:.3g})",
        ],
    )


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


def _agreement_table(results: Results) -> Table:
    heads = ("largest difference", "closest to the sum of the estimates", "within")
    rows = [
        Row(row.body, [row.line, row.largest, row.closest, "yes" if row.within else "no"])
        for row in agreement(results)
    ]
    return Table("body", ["line", *heads], rows, is_text=True)


def _length(body: Body) -> str:
    """Return a text on the extent of a model along x."""
    if body.closed:
        return "all the way round"
    return "infinite along x" if np.isinf(body.xi_end) else f"half-length {body.xi_end:.4g} mm"


def _cost_table(results: Results) -> Table:
    columns = [
        *numbers("unknowns", "cells"),
        *texts("solver"),
        *numbers("iterations", "residual"),
        *numbers("mesh", "assembly", "solution", unit="s"),
        *numbers("peak memory", unit="MB"),
    ]
    rows = [Row(name, _cost_cells(cost)) for name, cost in results.models.items()]
    return Table("model", columns, rows)


def _cost_cells(cost: Cost) -> list[Cell | str]:
    return [
        *(Cell(number, ",d") for number in (cost.unknowns, cost.cells)),
        cost.solver,
        ", ".join(map(str, cost.iterations)),
        Cell(cost.residual, ".0e"),
        *(Cell(cost.seconds.get(stage, 0.0), ".1f") for stage in ("mesh", "assembly", "solution")),
        Cell(cost.peak_memory, ".0f"),
    ]


def _cost_text(results: Results) -> str:
    first = results.scene.compared[0]
    each = ", ".join(
        f"{SYMBOLS[name]}: {results.seconds[name, first]:.2g} s" for name in results.computed(first)
    )
    return (
        "Peak memory: of the worker process up to the end of the model. Seconds: of the run that solved the "
        "model; stored models are not solved again. Seconds of each variant on "
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
        Row(name, [value if isinstance(value, str) else cell(value)])
        for name, value in settings(scene).items()
    ]
    yield Table("setting", ["value"], rows)
    yield Folded("Scene file", [Verbatim(scene.text)])
    yield Note(", ".join(f"{name} {version}" for name, version in versions().items()))


def _entries(discount: np.ndarray) -> list[str]:
    return [
        f"M_{AXES[a]}{AXES[b]} = {discount[a, b]:.4g}"
        for a in range(4)
        for b in range(a, 4)
        if discount[a, b] != 0
    ]
