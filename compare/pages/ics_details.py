"""The ICs of one scene in detail: bodies, accuracy of C, both engines, cost and settings."""

import json
from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from compare.pages.ics_figures import components_in, lines_in
from compare.report.charts import Chart
from compare.report.errors import VANISHING
from compare.report.looks import ics_symbol
from compare.report.parts import Block, Folded, Note, Picture, Verbatim
from compare.report.tables import Cell, Row, Table, numbers, texts
from compare.report.verdicts import NO, YES
from femic.ic_errors.error_measure import ROUNDING

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


class SceneICs(NamedTuple):
    """The ICs of a scene, as in `ics.nc`, and their errors, as in `errors.nc`."""

    ics: xr.Dataset
    errors: xr.Dataset


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
