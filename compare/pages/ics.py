"""The page of ICs of one scene or of several: errors against C, curves, accuracy, cost and settings.

All is drawn from the datasets of `femic.results.ics_dataset`. One scene is shown in µm/kN over mm, several
ones dimensionless: per unit total load, times E of the lower body and the reference length L.
"""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from compare.report.charts import Chart, Curve, Panel, mark_points, simple_chart
from compare.report.errors import COMPONENTS, ERRORS_HEADING, MEASURE, VANISHING, component_cell, error_row
from compare.report.looks import Look, drawing_order, ics_looks, ics_symbol
from compare.report.parts import Block, Folded, Items, Note, Page, Picture, Section, Verbatim
from compare.report.tables import Cell, Row, Table, numbers, texts
from femic.ic_errors.error_measure import ROUNDING

# --- the page -------------------------------------------------------------------------------------------


class SceneICs(NamedTuple):
    """The ICs of a scene, as in `ics.nc`, and their errors, as in `errors.nc`."""

    ics: xr.Dataset
    errors: xr.Dataset


Scenes = Mapping[str, SceneICs]  # by name, with the same bodies, components, variants and lines

ANSWER = (
    "Largest difference of the {} ICs from C over {}, relative to the component itself; small: relative "
    "to C_nn of the same scene. C ±: the estimated error of C. †: the component vanishes in C."
)
ONE_SCENE = (
    "A component names the displacement, then the traction: sn is the displacement along s under a normal "
    "load. Displacements per total load of 1 kN, without rigid-body motion. Band: C ± its estimated "
    "error, often thinner than the line. Circles: C of the solid engine. Dotted: joint of arc and flank."
)
SEVERAL_SCENES = (
    "Colours show the ICs, dashes the scenes. ICs per unit total load are multiplied by E of the lower "
    "body and by L of the scene ({}). Band: C ± its estimated error, often thinner than the line. If the "
    "curve of a scene seems to be missing, another scene's curve covers it."
)


def page(title: str, scenes: Scenes, details: Iterable[Section | Folded]) -> Page:
    """Return the page of scenes: the largest errors, curves, and on request errors by line and details."""
    ics = next(iter(scenes.values())).ics
    worst = {name: worst_errors(scene.errors, main_body(ics.body.values)) for name, scene in scenes.items()}
    answer = error_table("error", worst, components_in(ics), drawn_variants(ics, several=len(scenes) > 1))
    return Page(title, summary(scenes), _sections(scenes, details), answer)


def summary(scenes: Scenes) -> str:
    """Return the largest errors of nn, or else of the first component, and the estimate of C, by scene."""
    ics = next(iter(scenes.values())).ics
    body, component = main_body(ics.body.values), _first_component(components_in(ics))
    variants = drawn_variants(ics, several=len(scenes) > 1)
    texts_of_scenes = []
    for name, scene in scenes.items():
        worst = worst_errors(scene.errors, body).sel(i=component[0], j=component[1])
        cells = {v: component_cell(worst.sel(variant=v), is_estimate=v == "C") for v in variants}
        errors = ", ".join(f"{row_name(v)} {cell.text}" for v, cell in cells.items() if cell.text != "–")
        texts_of_scenes.append(f"{name}: {errors}" if len(scenes) > 1 else errors)
    return f"{body.capitalize()} C_{component}, largest differences from C: {'; '.join(texts_of_scenes)}."


def _sections(scenes: Scenes, details: Iterable[Section | Folded]) -> Iterator[Section | Folded]:
    ics, several = next(iter(scenes.values())).ics, len(scenes) > 1
    notes = [
        f"{name}: {note}" if several else note
        for name, scene in scenes.items()
        for note in json.loads(scene.ics.attrs["warnings"])
    ]
    if notes:
        yield Section("", [Note("Note before you use these numbers:"), Items(notes)])
    lengths = ", ".join(f"{name}: {scene.ics.reference_length:g} mm" for name, scene in scenes.items())
    curves = chart({name: scene.ics for name, scene in scenes.items()})
    answer = ANSWER.format(main_body(ics.body.values), ", ".join(lines_in(ics)))
    yield Section("", [Note(answer), curves, Note(SEVERAL_SCENES.format(lengths) if several else ONE_SCENE)])
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
    rms = {name: errors.assign(error=errors.rms, weight=np.nan) for name, errors in largest.items()}

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
HOLLOW = (
    "One mark per component. Hollow: C vanishes, and the error is relative to 0.05 max |C_nn|. Marks "
    "of C: its estimated error."
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
LEAST_DRAWN = 1e-6  # error: smaller errors are rounding and are drawn here


def details(scene: SceneICs, pictures: Sequence[Picture]) -> Iterator[Folded]:
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
    yield Folded("Cost", [error_against_seconds(scene), HOLLOW, *tables, costs])
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
    components, rows = components_in(scene.ics), []
    for body, line in product(map(str, scene.ics.body.values), lines_in(scene.ics)):
        errors = scene.errors.sel(body=body, line=line)
        difference, allowed = errors.error.sel(variant="C_solid"), errors.estimate_both
        both = {c: tuple(v.sel(i=c[0], j=c[1]).item() for v in (difference, allowed)) for c in components}
        marks = {c: VANISHING if bool(errors.vanishes.sel(i=c[0], j=c[1])) else "" for c in components}
        closest = max(both, key=lambda c: both[c][0] / max(both[c][1], ROUNDING))
        largest = max(both, key=lambda c: (not marks[c], both[c][0]))
        within = all(difference <= max(estimate, ROUNDING) for difference, estimate in both.values())
        cells = [
            f"{both[largest][0]:.2%} ({largest}{marks[largest]})",
            f"{closest}{marks[closest]}: {both[closest][0]:.2%} of {both[closest][1]:.2%}",
            "yes" if within else "no",
        ]
        rows.append(Row(f"{body}, {line}", cells))
    heads = ["largest difference", "closest to the sum of the estimated errors", "within"]
    return Table("body, line", heads, rows, is_text=True)


def error_against_seconds(scene: SceneICs) -> Chart:
    """Return the worst error of each variant over all lines against its seconds, a panel per body.

    A mark per component, hollow where it vanishes in C: the error is a share of 0.05 max |C_nn|.
    """
    seconds, components = _seconds(scene.ics), components_in(scene.ics)
    looks = ics_looks(map(str, scene.ics.variant.values))
    panels = []
    for body in map(str, scene.ics.body.values):
        marks = []
        for name in (variant for variant, other in seconds if other == body):
            worst = scene.errors.sel(body=body, variant=name).max("line")
            look = replace(looks[name], dash="")
            hollow_look = replace(look, marker=f"{look.marker.removesuffix('-open')}-open")
            for hollow, mark in ((True, hollow_look), (False, look)):
                parts = [worst.sel(i=c[0], j=c[1]) for c in components]
                values = [max(at.error.item(), LEAST_DRAWN) for at in parts if bool(at.vanishes) == hollow]
                if values:
                    at = [seconds[name, body]] * len(values)
                    marks.append(Curve(ics_symbol(name), at, values, mark))
        across = f"seconds for {scene.ics.sizes['point']} points [s]"
        panels.append(Panel(body, across, "worst error [-]", marks, log_x=True, log_y=True))
    return simple_chart("error_against_seconds", panels, max(2, len(panels)))


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
MOST_COLUMNS = 4
MIRRORED = 1e-6  # largest asymmetry of mirrored curves, as a share of the largest value on their line
OVERLAID_VARIANTS = ("A", "B", "Bhat")  # drawn of several scenes; tables also have the others
DASHES = ("solid", "dash", "dot", "dashdot", "longdash")  # of the scenes
WIDE_LINE, NARROW_LINE = 3.2, 1.2  # line widths, rear to front: curves that coincide stay visible


def chart(scenes: Mapping[str, xr.Dataset]) -> Chart:
    """Return ICs of scenes, a step per component: curves and differences from C, then other bodies.

    Halves of lines that repeat the other half in all scenes are left out.
    """
    ics = next(iter(scenes.values()))
    (first, *others), lines = combined_first(ics.body.values), lines_in(ics)
    components, several = components_in(ics), len(scenes) > 1
    minus_c = {n: one.assign(ic=one.ic - one.ic.sel(variant="C", drop=True)) for n, one in scenes.items()}
    halves = {line: all(is_mirrored(one, line) for one in scenes.values()) for line in lines}
    looks = _looks(scenes)

    def panels(shown: Mapping[str, xr.Dataset], bodies: Sequence[str], component: str) -> Iterator[Panel]:
        for body, line in product(bodies, lines):
            parts = {n: along_line(one, line, body, component, several) for n, one in shown.items()}
            if halves[line]:
                parts = {n: part.isel(point=part["at"].values >= 0) for n, part in parts.items()}
            yield _panel(f"{body}, {line}", parts, looks)

    steps = {}
    for component in components:
        differences = [
            replace(panel, title=f"{panel.title}: minus C", up=f"Δ{panel.up}")
            for panel in panels(minus_c, [first], component)
        ]
        curves = panels(scenes, [first], component)
        steps[component] = [*curves, *differences, *panels(scenes, others, component)]
    columns = min(max(2, len(lines)), MOST_COLUMNS)
    return Chart("curves", steps, columns, "component", heights=0.75, start=_first_component(components))


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
    """Return the panel of ICs of `along_line` by scene; those that were not computed are left out."""
    curves = []
    for (variant, name), look in looks.items():
        part, estimate = parts[name], ESTIMATES.get(variant, "")
        values, label = part.ic.sel(variant=variant).values, ics_symbol(variant)
        if not np.all(np.isnan(values)):
            band = part[estimate].values if estimate in part else None
            label = f"{label}, {name}" if len(parts) > 1 else label
            curves.append(mark_points(Curve(label, part["at"].values, values, look, band)))
    part = next(iter(parts.values()))
    at = part["at"].values
    marks = [mark for mark in part.attrs.get("marks", ()) if at[0] <= mark <= at[-1]]
    return Panel(title, part.across, part.up, curves, marks=marks, least=part.least)
