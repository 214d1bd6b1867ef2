"""Figures of the stresses, wear and fatigue below a contact, and what is compared in them."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from compare.report.charts import Cell, Chart, Contours, Curve, Panel
from compare.report.looks import OWN, Look, ics_looks, ics_symbol
from compare.report.tables import number_text
from femic.results.stresses import ACTUAL, HALF_SPACE, HALF_SPACE_OF_A, MEASURES, OF_STRESS
from femic.stresses.field import von_mises
from geometries.arrays import Array

LOOKS = {ACTUAL: OWN["C"], HALF_SPACE: OWN["A"], HALF_SPACE_OF_A: OWN["B"]}
COMPONENTS = {  # of stresses: indices and looks
    "σ_xx": ((0, 0), Look("#0072b2")),
    "σ_ss": ((1, 1), Look("#e69f00")),
    "σ_nn": ((2, 2), Look("ink")),
    "σ_sn": ((1, 2), Look("#009e73", "dash")),
    "σ_xn": ((0, 2), Look("#d55e00", "dash")),
    "σ_xs": ((0, 1), Look("#cc79a7", "dash")),
}
SAME = 1e-9  # mm: places closer are the same
OUTLINES = {"lower": Look("ink"), "upper": Look("#d55e00")}
LARGEST = Look("#d62728", "", "x")
BETWEEN = 4  # intervals of a drawing in one of the lattice, into depth and along x
SIDE = {"lower": -1, "upper": 1}  # of a body along n


def reference_symbol(dataset: xr.Dataset) -> str:
    """Return the symbol of the ICs whose tractions load the bodies."""
    return ics_symbol(str(dataset.attrs["reference"]))


def source_label(dataset: xr.Dataset, source: str) -> str:
    """Return in words which body and which tractions stresses are of."""
    if source == HALF_SPACE_OF_A:
        return "half-space, tractions of A"
    return f"{source}, tractions of {reference_symbol(dataset)}"


def sources(dataset: xr.Dataset) -> list[str]:
    """Return the sources; half-spaces under A's tractions only where these are others."""
    names = [str(name) for name in dataset.source.values]
    return [name for name in names if name != HALF_SPACE_OF_A or dataset.attrs["reference"] != "A"]


def compared(dataset: xr.Dataset) -> tuple[str, str]:
    """Return the sources that answers and sections compare: the half-space is under the tractions of A.

    Where there are none of A it is under those of the reference.
    """
    return ACTUAL, sources(dataset)[-1]


def bodies(dataset: xr.Dataset) -> list[str]:
    """Return the names of the bodies, the lower one first."""
    return sorted(map(str, dataset.body.values))


def _by_body(
    dataset: xr.Dataset, name: str, alt: str, heights: float, cells: Callable[[str], Sequence[Cell]]
) -> Chart:
    """Return a chart with a step per body."""
    steps = {f"{body} body": cells(body) for body in bodies(dataset)}
    return Chart(name, steps, 3, "body", heights, next(iter(steps)), alt=alt)


def _body_fields(dataset: xr.Dataset, body: str) -> xr.Dataset:
    """Return the fields of a body: stress, estimate, perhaps dang_van, over x, s, depth."""
    names = {f"{name}_{body}": name for name in ("stress", "estimate", "dang_van")}
    places = {f"{name}_{body}": name for name in ("x", "s", "depth")}
    return dataset[[name for name in names if name in dataset]].rename(
        {name: short for name, short in (names | places).items() if name in dataset.variables}
    )


def _below(dataset: xr.Dataset, body: str, place: dict[str, float]) -> xr.Dataset:
    """Return the fields of a body over x and depth, at the s of a place.

    Below the middle of the patch they go down to the deepest point.
    """
    middle = float(dataset.middle.sel(body=body))
    if abs(place["s"] - middle) >= SAME:
        return _body_fields(dataset, body).sel(s=place["s"], method="nearest")
    names = {f"column_{name}_{body}": name for name in ("stress", "estimate")}
    column = dataset[list(names)].rename({**names, f"column_{body}": "depth", f"x_{body}": "x"})
    return column.assign_coords(s=middle)


def _worst(dataset: xr.Dataset, body: str) -> dict[str, float]:
    """Return the place of the largest von Mises stress in an actual body [mm]."""
    numbers = dataset.sel(body=body, source=ACTUAL)
    return {name: float(numbers[f"{name}_von_mises"]) for name in ("x", "s", "depth")}


def _mises(dataset: xr.Dataset, fields: xr.Dataset) -> dict[str, Array]:
    """Return von Mises stresses by source."""
    return {
        source: von_mises(np.asarray(fields.stress.sel(source=source), dtype=float))
        for source in sources(dataset)
    }


def _finer(at: Array) -> Array:
    """Return coordinates with further ones between them."""
    return np.interp(np.arange(BETWEEN * (len(at) - 1) + 1) / BETWEEN, np.arange(len(at)), at)


def _interpolated(values: Array, at: tuple[Array, Array], finer: tuple[Array, Array]) -> Array:
    """Return values (n, m) on a finer lattice, which stay between those of neighbours on the given one."""
    for axis in (0, 1):
        values = np.asarray(PchipInterpolator(at[axis], values, axis=axis)(finer[axis]))
    return values


def _region(dataset: xr.Dataset, body: str, values: Array) -> tuple[Array, Array]:
    """Return points below the outline of a body (2, n, m) [mm], and values over s and depth there."""
    s, depth, outline_s = (dataset[f"{name}_{body}"].values for name in ("s", "depth", "outline_s"))
    own = (outline_s >= s[0]) & (outline_s <= s[-1])
    outline, inward = (dataset[f"{name}_{body}"].values[:, own, None] for name in ("outline", "inward"))
    finer = outline_s[own], _finer(depth)
    return outline + finer[1] * inward, _interpolated(values, (s, depth), finer)


def _section(dataset: xr.Dataset, title: str, fields: dict[str, Array]) -> Contours:
    """Return contours of values over s and depth, by bodies, below their outlines."""
    regions = [_region(dataset, body, values) for body, values in fields.items()]
    outlines = [
        Curve(f"{body} body", outline[0], outline[1], OUTLINES[body])
        for body, outline in ((body, dataset[f"outline_{body}"].values) for body in bodies(dataset))
    ]
    return Contours(title, "y [mm]", "z [mm]", regions, "MPa", curves=outlines, stride=BETWEEN)


def _place(dataset: xr.Dataset, body: str) -> Array:
    """Return where the von Mises stress in an actual body is largest, y and z [mm], (2,)."""
    place, outline_s = _worst(dataset, body), dataset[f"outline_s_{body}"].values

    def at_place(name: str) -> Array:
        return np.array([np.interp(place["s"], outline_s, one) for one in dataset[f"{name}_{body}"].values])

    return at_place("outline") + place["depth"] * at_place("inward")


def section_chart(dataset: xr.Dataset) -> Chart:
    """Return von Mises stresses in the actual bodies, in half-spaces, and their differences.

    The section of each body is that through its largest stress.
    """
    mises = {}
    for body in bodies(dataset):
        section = _body_fields(dataset, body).sel(x=_worst(dataset, body)["x"], method="nearest")
        mises[body] = _mises(dataset, section)
    limits = 0.0, max(float(np.max(one)) for by_source in mises.values() for one in by_source.values())
    places = np.transpose([_place(dataset, body) for body in bodies(dataset)])
    marks = Curve("largest in the actual body", places[0], places[1], LARGEST)

    def stresses(source: str) -> Contours:
        fields = {body: by_source[source] for body, by_source in mises.items()}
        drawn = _section(dataset, source_label(dataset, source), fields)
        return replace(drawn, limits=limits, curves=[*drawn.curves, marks])

    half = compared(dataset)[1]
    away = {body: by_source[half] - by_source[ACTUAL] for body, by_source in mises.items()}
    difference = replace(_section(dataset, "half-space minus actual body", away), scale="diverging")
    alt = "von Mises stresses on the section of both bodies, and differences of half-spaces from them"
    cells = [stresses(ACTUAL), stresses(half), difference]
    return Chart("section", {"": cells}, 3, alt=alt)


def estimate_chart(dataset: xr.Dataset) -> Chart:
    """Return the estimated errors of stresses on the section through the largest one of each body."""
    estimates = {}
    for body in bodies(dataset):
        estimate = _body_fields(dataset, body).estimate
        at_x = estimate.sel(x=_worst(dataset, body)["x"], method="nearest")
        estimates[body] = np.asarray(at_x, dtype=float)
    alt = "estimated errors of stresses on the section of both actual bodies"
    return Chart("estimate", {"": [_section(dataset, "estimated error", estimates)]}, 2, alt=alt)


def plane_chart(dataset: xr.Dataset) -> Chart:
    """Return von Mises stresses on the planes along x through the largest one of each body."""
    planes = {body: _below(dataset, body, _worst(dataset, body)) for body in bodies(dataset)}
    mises = {body: _mises(dataset, plane) for body, plane in planes.items()}
    limits = 0.0, max(float(np.max(one)) for by_source in mises.values() for one in by_source.values())
    cells = []
    for source in compared(dataset):
        regions = []
        for body, plane in planes.items():
            at = plane.x.values, plane.depth.values
            finer = _finer(at[0]), _finer(at[1])
            points = np.stack(np.meshgrid(finer[0], SIDE[body] * finer[1], indexing="ij"))
            regions.append((points, _interpolated(mises[body][source], at, finer)))
        title = source_label(dataset, source)
        cells.append(Contours(title, "x [mm]", "n [mm]", regions, "MPa", limits=limits, stride=BETWEEN))
    alt = "von Mises stresses along the rolling direction"
    return Chart("plane", {"": cells}, 2, heights=0.8, alt=alt)


def depth_curves(dataset: xr.Dataset) -> Chart:
    """Return stresses along the line into depth below the largest von Mises stress, a step per body."""

    def panels(body: str) -> list[Panel]:
        place, drawn = _worst(dataset, body), []
        line = _below(dataset, body, place).sel(x=place["x"], method="nearest")
        for name, measure in MEASURES.items():
            symbol = OF_STRESS[name].symbol
            curves = [
                Curve(
                    source_label(dataset, source),
                    line.depth.values,
                    measure(np.asarray(line.stress.sel(source=source), dtype=float)),
                    LOOKS[source],
                    line.estimate.values if source == ACTUAL else None,
                )
                for source in reversed(sources(dataset))
            ]
            title = (
                f"{symbol} at x = {number_text(place['x'], '.2g')}, s = {number_text(place['s'], '.2g')} mm"
            )
            drawn.append(Panel(title, "depth [mm]", f"{symbol} [MPa]", curves))
        return drawn

    alt = "stresses against depth in the actual body and in half-spaces; bands are estimated errors"
    return _by_body(dataset, "depth", alt, 1.0, panels)


def load_cycle(dataset: xr.Dataset) -> Chart:
    """Return stress components along x at the worst place of each body, in actual bodies and half-spaces."""

    def panels(body: str) -> list[Panel]:
        place, drawn = _worst(dataset, body), []
        line = _below(dataset, body, place).sel(depth=place["depth"], method="nearest")
        for source in sources(dataset):
            stress = line.stress.sel(source=source).values
            band = line.estimate.values if source == ACTUAL else None
            curves = [
                Curve(name, line.x.values, stress[:, i, j], look, band)
                for name, ((i, j), look) in COMPONENTS.items()
            ]
            title = f"{source_label(dataset, source)}"
            drawn.append(Panel(title, "x [mm]", "stress [MPa]", curves))
        return drawn

    alt = "stress components along x: the load cycle of a material point as the contact passes"
    return _by_body(dataset, "cycle", alt, 1.0, panels)


def fatigue_chart(dataset: xr.Dataset) -> Chart:
    """Return Dang Van's equivalent stress on the sections of actual bodies and half-spaces."""
    fields = {body: _body_fields(dataset, body).dang_van for body in bodies(dataset)}
    ends = [float(end(one)) for one in fields.values() for end in (np.min, np.max)]
    cells = [
        replace(
            _section(
                dataset,
                source_label(dataset, source),
                {body: np.asarray(one.sel(source=source)) for body, one in fields.items()},
            ),
            limits=(min(0.0, *ends), max(ends)),
        )
        for source in compared(dataset)
    ]
    return Chart("fatigue", {"": cells}, 2, alt="equivalent stress of Dang Van on the section of both bodies")


def wear_chart(dataset: xr.Dataset) -> Chart:
    """Return the depths worn along s by each law, with all ICs, and the work of friction along s."""
    worn = dataset.isel(s=(dataset.depth.max(["ics", "law"]) > 0).values)
    energy = worn.work_density.sum("x") * float(dataset.x[1] - dataset.x[0])
    panels = [
        *(
            _along_s(
                f"wear depth: {law}",
                "depth [nm]",
                worn.depth.sel(law=law),
                dataset[f"estimate_{largest_depth(law)}"],
            )
            for law in map(str, dataset.law.values)
        ),
        _along_s("work of friction along s", "energy [mJ/mm²]", energy),
    ]
    return Chart(
        "wear", {"": panels}, 2, heights=0.9, alt="wear depths per passage along s with each of the ICs"
    )


def worn_chart(dataset: xr.Dataset) -> Chart:
    """Return the depths worn off both bodies along s after all passages, with all ICs."""
    worn = dataset.worn.isel(s=(dataset.worn.max(["ics", "worn_body"]) > 0).values)
    panels = [
        _along_s(
            f"wear depth of the {body} body",
            "depth [µm]",
            worn.sel(worn_body=body),
            dataset.estimate_worn.sel(worn_body=body),
        )
        for body in map(str, dataset.worn_body.values)
        if float(worn.sel(worn_body=body).max()) > 0
    ]
    return Chart(
        "worn",
        {"": panels},
        2,
        heights=0.9,
        alt="wear depths along s after all passages with each of the ICs",
    )


def largest_depth(law: str) -> str:
    """Return the name of the largest depth that a law wears off."""
    return f"largest_depth_{law.replace(' ', '_')}"


def _along_s(title: str, up: str, values: xr.DataArray, estimate: xr.DataArray | None = None) -> Panel:
    """Return curves over s by ICs; the largest values have bars of their estimated errors."""
    curves = []
    for name, look in ics_looks(map(str, values.ics.values)).items():
        one, symbol = values.sel(ics=name), ics_symbol(name)
        if estimate is not None and np.isfinite(known := float(estimate.sel(ics=name))):
            at = [int(one.argmax("s"))]
            bar = replace(look, dash="")
            curves.append(Curve(symbol, one.s.values[at], one.values[at], bar, [known], bars=True))
        curves.append(Curve(symbol, one.s.values, one.values, look))
    return Panel(title, "s [mm]", up, curves)
