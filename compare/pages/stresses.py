"""`femic stresses` writes the file, figures and the page of stresses, wear and fatigue below a contact.

The page says whether both bodies yield, whether they ratchet, and how much a passage wears off.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from compare.report.charts import Cell as ChartCell
from compare.report.charts import Chart, Contours, Curve, Panel
from compare.report.looks import OWN, Look, ics_looks, ics_symbol
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, write_results
from compare.report.tables import Cell, Column, Row, Table, number_text, with_estimate
from compare.report.verdicts import NO, NOT_DECIDED, YES, verdict
from femic.results.damage import OF_DAMAGE
from femic.results.stresses import ACTUAL, HALF_SPACE, HALF_SPACE_OF_A, MEASURES, OF_STRESS
from femic.stresses.field import von_mises
from geometries.arrays import Array

# --- the page -------------------------------------------------------------------------------------------


YIELDS = {
    YES: "The {} body yields: its largest von Mises stress, {} MPa ({}), exceeds the yield stress of {:g} "
    "MPa.",
    NO: "The {} body does not yield: its largest von Mises stress, {} MPa ({}), stays below the yield stress "
    "of {:g} MPa.",
    NOT_DECIDED: "It is not decided whether the {} body yields: its largest von Mises stress is {} MPa ({}), "
    "and the yield stress {:g} MPa.",
}
WOULD_YIELD = "The {} body yields if its yield stress is below {} MPa, its largest von Mises stress ({})."
RATCHETS = {
    YES: "The material can ratchet: p_max/k, {}, exceeds the shakedown limit, {}.",
    NO: "The material does not ratchet: p_max/k, {}, stays below the shakedown limit, {}.",
    NOT_DECIDED: "It is not decided whether the material ratchets: p_max/k is {}, the shakedown limit {}.",
}
WEARS = (
    "By the energy law, a passage wears up to {} nm off the lower body and a revolution as much off the "
    "upper body, at s = {} mm."
)
NO_WEAR = "Nothing slides, so nothing is worn off."
LOADED = (
    "Load {}, friction coefficient {:g}{}; contact solved with {}: p_max {:.0f} MPa. ± is the estimated "
    "error{}."
)
OF_LAW = ", of wear without that of the law"
SECTION = (
    "Von Mises stress on the section of both bodies, seen along the track; s is the arc length of the lower "
    "contour. × marks the largest stress of each actual body; the section is at its x. Stresses of "
    "half-spaces are drawn at the same arc length and depth."
)
DEEPER = (
    "The contours end where normals of the surface come close to each other. The curves below go "
    "deeper, under the middle of the patch."
)
BANDS = "Bands: estimated error of the largest stress component in the actual body."
WEAR = (
    "Depth that a passage wears off the lower body, and a revolution off the upper body. {} Bars: estimated "
    "error of the largest depth."
)
LAWS = {
    "energy": "Energy: law of Krause and Poll.",
    "twin disc": "Twin disc: function of T-gamma over area by British Rail Research (BRR).",
    "Archard": "Archard: wear map of the Royal Institute of Technology, Stockholm (KTH).",
}
WORK = (
    "W is the work of friction per rolled distance. Tγ, forces times creepages, leaves out that slip varies "
    "over a curved patch."
)
WORN = (
    "The lower body wears in {:g} passages and the upper body in {:g} revolutions, by the energy law, in {} "
    "steps. After each step the contact is solved again with the material that both bodies have lost. ± is "
    "the estimated error from the size of the steps only."
)
SHAKEDOWN = (
    "The limit of p_max/k, with the yield stress in shear k, assumes residual stresses without shear along "
    "x. It is exact for line contact and a lower bound for a patch that runs on one track."
)
FATIGUE = (
    "Equivalent stress of Dang Van for the load cycle of one passage, without residual stresses; the "
    "hydrostatic stress has the weight c = {:.3g} in tension and {:.3g} in compression. Expect fatigue where "
    "it exceeds the fatigue limit in shear. Its error is not estimated."
)
CYCLE = (
    "Stress components along x, s and n of the surface above, at the point of the largest von Mises stress: "
    "the load cycle of a material point as the contact passes."
)
SURFACE = 1e-9  # mm: depths below are the surface
STEEPEST = 1.0  # degrees by which wear may turn a surface before its ICs are doubtful
PASSES = {"lower": "passages", "upper": "revolutions"}  # attributes: what wears a body


def write_stresses(dataset: xr.Dataset, out: Path) -> Path:
    """Write `stresses.nc`, figures and `stresses.html`; return the path of the page."""
    page = Page(
        str(dataset.attrs["title"]),
        summary(dataset),
        _sections(dataset),
        answer_table(dataset),
        doubts=doubts(dataset),
    )
    return write_results(page, out, "stresses", dataset)


def exceeds(value: float | xr.DataArray, estimate: float | xr.DataArray, limit: float) -> str:
    """Return whether a value exceeds a limit, which is whether it is not within it."""
    within = verdict(value, estimate, limit)
    return {YES: NO, NO: YES}.get(within, within)


def summary(dataset: xr.Dataset) -> str:
    """Return whether the bodies yield and ratchet, and what a passage wears off, in a sentence each."""
    attributes, sentences = dataset.attrs, []
    for body in bodies(dataset):
        actual = dataset.sel(body=body, source=ACTUAL)
        estimate = actual.estimate_von_mises
        number, place = with_estimate(actual.von_mises, estimate), place_text(actual, "von_mises")
        if "yield_stress" in attributes:
            limit = float(attributes["yield_stress"])
            sentence = YIELDS[exceeds(actual.von_mises, estimate, limit)]
            sentences.append(sentence.format(body, number, place, limit))
        else:
            sentences.append(WOULD_YIELD.format(body, number, place))
    if "ics" in dataset.dims:
        damage = dataset.sel(ics=attributes["reference"])
        if "load_factor" in dataset:
            both = (
                with_estimate(damage[name], damage[f"estimate_{name}"])
                for name in ("pressure_ratio", "shakedown_limit")
            )
            sentences.append(RATCHETS[ratchets(damage)].format(*both))
        depth = damage.depth.sel(law="energy")
        number = with_estimate(damage.largest_depth_energy, damage.estimate_largest_depth_energy)
        deepest = float(depth.s[int(depth.argmax("s"))])
        sentences.append(
            WEARS.format(number, number_text(deepest, ".2g")) if float(depth.max()) > 0 else NO_WEAR
        )
    p_max = float(attributes["p_max_of_reference"])
    symbol = reference_symbol(dataset)
    rolls = "xi" in dataset
    creepage = (
        f", longitudinal creepage {float(dataset.xi.sel(ics=attributes['reference'])):.2g}" if rolls else ""
    )
    law = OF_LAW if "ics" in dataset.dims else ""
    sentences.append(
        LOADED.format(attributes["load"], float(attributes["friction"]), creepage, symbol, p_max, law)
    )
    return "\n".join(sentences)


def ratchets(damage: xr.Dataset) -> str:
    """Return whether p_max/k of a contact exceeds the shakedown limit: a load factor below 1."""
    return exceeds(-damage.load_factor, damage.estimate_load_factor, -1.0)


def doubts(dataset: xr.Dataset) -> list[str]:
    """Return what may be wrong with the numbers of the page, a sentence or two each."""
    attributes, found = dataset.attrs, []
    if attributes["reference"] != "C":
        found.append(
            f"The stresses and the verdicts use the tractions of {reference_symbol(dataset)}, an "
            "approximation. Add C to the ICs for those of the reference."
        )
    if attributes["fineness"] < 1:
        found.append(
            f"The models are coarser than usual (fineness = {attributes['fineness']:g}). The estimated "
            "errors contain this; for final numbers use 1 or more."
        )
    for body in bodies(dataset):
        actual = dataset.sel(body=body, source=ACTUAL)
        largest = f"The largest von Mises stress of the {body} body"
        if bool(actual.deepest_von_mises):
            found.append(f"{largest} lies at the deepest computed point. Larger ones may lie deeper.")
        ends = {name: dataset[f"{name}_{body}"].values[[0, -1]] for name in ("x", "s")}
        if any(np.any(np.abs(float(actual[f"{name}_von_mises"]) - end) < SAME) for name, end in ends.items()):
            found.append(f"{largest} lies at an outermost computed point. Larger ones may lie beside it.")
        if np.isnan(float(actual.estimate_von_mises)):
            found.append(f"{largest} has no estimated error, so whether the body yields is not decided.")
    limit = float(attributes.get("yield_stress", np.inf))
    if float(dataset.von_mises.sel(source=ACTUAL).max()) > limit:
        found.append(
            "The stresses are elastic. Where a body yields, the real ones are lower, and the contact patch "
            "is larger."
        )
    if "ics" in dataset.dims:
        if "speed" not in attributes:
            found.append("Without damage.speed (--speed), the energy law assumes mild wear everywhere.")
        found.append(
            "Wear laws come from laboratory tests of dry steel. Depths may be wrong by a factor of up to "
            "ten; ratios between ICs are more reliable."
        )
        unknown = [
            number.symbol
            for name, number in OF_DAMAGE.items()
            if name in dataset and bool(dataset[f"estimate_{name}"].isnull().any())
        ]
        if unknown:
            found.append(f"Estimated errors are not known for: {', '.join(unknown)}.")
    if "worn" in dataset and float(dataset.turned.max()) > STEEPEST:
        found.append(
            f"Wear turns a surface by up to {float(dataset.turned.max()):.2g}°, and the ICs are those of the "
            "new surfaces. Components that vanish on new surfaces may be wrong by that angle times C_nn."
        )
    return found


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    attributes, symbol = dataset.attrs, reference_symbol(dataset)
    deeper = any(dataset.sizes[f"column_{name}"] > dataset.sizes[f"depth_{name}"] for name in bodies(dataset))
    notes = [SECTION, DEEPER] if deeper else [SECTION]
    yield Section("Where the stresses are", [section_chart(dataset), Note(" ".join(notes))])
    yield Section("How deep they go", [depth_curves(dataset), Note(BANDS)])
    if "ics" in dataset.dims:
        yield Section(
            "What a passage wears off",
            [
                wear_chart(dataset),
                Note(WEAR.format(" ".join(LAWS[law] for law in map(str, dataset.law.values)))),
            ],
        )
    if "worn" in dataset:
        counts = attributes["passages"], attributes["revolutions"], int(dataset.wear_steps.max())
        blocks: list[Block] = [worn_table(dataset), worn_chart(dataset), Note(WORN.format(*counts))]
        yield Folded("Wear and contact after all passages", blocks)
    yield Folded("Largest stresses in the actual bodies and in half-spaces", [stress_table(dataset)])
    if all(bool(np.isfinite(dataset[f"estimate_{body}"]).all()) for body in bodies(dataset)):
        yield Folded("Estimated errors of the stresses", [estimate_chart(dataset)])
    if "ics" in dataset.dims:
        further = "load_factor" in dataset or "surface_index" in dataset
        yield Folded(
            f"Wear{', shakedown and surface fatigue' * further} with each of the ICs", _by_ics(dataset)
        )
    if "dang_van" in dataset:
        c = float(attributes["dang_van_hydrostatic"])
        note = Note(FATIGUE.format(c, c * float(attributes["dang_van_compression"])))
        yield Folded("Fatigue below the surface (Dang Van)", [fatigue_chart(dataset), note])
    yield Folded("Stress along the rolling direction", [plane_chart(dataset)])
    yield Folded("Load cycle at the point of the largest stress", [load_cycle(dataset), Note(CYCLE)])
    lattice = " × ".join(str(dataset.sizes[f"{name}_lower"]) for name in ("x", "s", "depth"))
    method = (
        f"The tractions of {symbol} load the two actual bodies (harmonic engine) and half-spaces unrolled "
        f"along the arc length. Stresses are computed at {lattice} points in x, s and depth; the largest "
        "values are the largest at these points, and their estimated errors include what may lie between "
        "neighbours. Contours are interpolated and never exceed the values at the points. The whole run took "
        f"{float(attributes['seconds']):.0f} s."
    )
    yield Folded("How these numbers are computed", [method])
    yield Folded("Scene file", [Verbatim(str(attributes["scene"]))])


def _by_ics(dataset: xr.Dataset) -> list[Block]:
    further = [WORK] * ("t_gamma" in dataset) + [SHAKEDOWN] * ("yield_stress" in dataset.attrs)
    below = f"The small number is the difference from the number with {reference_symbol(dataset)}."
    return [damage_table(dataset), Note(" ".join((below, *further)))]


# --- tables ---------------------------------------------------------------------------------------------


def place_text(numbers: xr.Dataset, name: str) -> str:
    """Return where a number is largest."""
    s, depth = float(numbers[f"s_{name}"]), float(numbers[f"depth_{name}"])
    where = "on the surface" if depth < SURFACE else f"{depth:.2g} mm deep"
    return f"{where} at s = {number_text(s, '.2g')} mm"


def answer_table(dataset: xr.Dataset) -> Table:
    """Return the answers in the actual bodies and in half-spaces, and how far these differ.

    Half-spaces have no estimates: those of the actual bodies take their place.
    """
    attributes, rows = dataset.attrs, []
    for body in bodies(dataset):
        both = [dataset.sel(body=body, source=one) for one in compared(dataset)]
        known = float(both[0].estimate_von_mises)
        values = [(float(one.von_mises), known) for one in both]
        texts = [with_estimate(*values[0]), f"{values[1][0]:.4g}"]
        places = [place_text(one, "von_mises") for one in both]
        if "yield_stress" in attributes:
            limit = float(attributes["yield_stress"])
            question = f"Does the {body} body yield (yield stress {limit:g} MPa)?"
            below = [f"{text} MPa, {place}" for text, place in zip(texts, places, strict=True)]
            cells = [Cell(exceeds(*one, limit), below=more) for one, more in zip(values, below, strict=True)]
        else:
            question = f"Yield stress below which the {body} body yields"
            cells = [Cell(f"{one} MPa", below=place) for one, place in zip(texts, places, strict=True)]
        rows.append(Row(question, [*cells, _difference(values, known)]))
    if "ics" in dataset.dims:
        rows += _damage_rows(dataset, ["A"] if HALF_SPACE_OF_A in compared(dataset) else [])
    if "dang_van" in dataset:
        for body in bodies(dataset):
            both = [dataset.sel(body=body, source=one) for one in compared(dataset)]
            cells = [
                Cell(f"{with_estimate(one.dang_van, np.nan)} MPa", below=place_text(one, "dang_van"))
                for one in both
            ]
            question = f"Fatigue limit in shear below which the {body} body fatigues (Dang Van)"
            values = [(float(one.dang_van), np.nan) for one in both]
            rows.append(Row(question, [*cells, _difference(values, np.nan)]))
    heads = [*(source_label(dataset, one) for one in compared(dataset)), "second relative to first column"]
    return Table("result", heads, rows)


def _damage_rows(dataset: xr.Dataset, others: Sequence[str]) -> Iterator[Row]:
    """Yield the answers of the reference, and of other ICs, on ratcheting, wear and cracks at the surface."""
    contacts = [dataset.sel(ics=name) for name in (dataset.attrs["reference"], *others)]

    def numbers(name: str) -> list[tuple[float, float]]:
        return [(float(one[name]), float(one[f"estimate_{name}"])) for one in contacts]

    def row(question: str, cells: Sequence[Cell], values: Sequence[tuple[float, float]]) -> Row:
        compared = [_difference(values, values[0][1] + values[1][1])] if others else [Cell("–"), Cell("–")]
        return Row(question, [*cells, *compared])

    if "load_factor" in dataset:
        both = zip(numbers("pressure_ratio"), numbers("shakedown_limit"), strict=True)
        below = [f"p_max/k {with_estimate(*ratio)}, limit {with_estimate(*limit)}" for ratio, limit in both]
        cells = [Cell(ratchets(one), below=more) for one, more in zip(contacts, below, strict=True)]
        yield row("Does the material ratchet?", cells, numbers("pressure_ratio"))
    for law in map(str, dataset.law.values):
        depths = numbers(_largest(law))
        question = f"Wear of the lower body per passage, of the upper per revolution ({law} law)"
        yield row(question, [Cell(f"{with_estimate(*one)} nm") for one in depths], depths)
    if "worn" in dataset:
        for body in (body for body, passes in PASSES.items() if dataset.attrs[passes] > 0):
            deepest = [_after_all(one.sel(worn_body=body)) for one in contacts]
            count = f"{float(dataset.attrs[PASSES[body]]):g} {PASSES[body]}"
            cells = [Cell(f"{with_estimate(*one)} µm") for one in deepest]
            yield row(f"Wear of the {body} body after {count} (energy law)", cells, deepest)
    if "surface_index" in dataset:
        indices = numbers("surface_index")
        cells = [Cell(exceeds(*one, 0.0), below=f"fatigue index {with_estimate(*one)}") for one in indices]
        yield row("Can cracks start at the surface?", cells, indices)


def _after_all(worn: xr.Dataset) -> tuple[float, float]:
    """Return the largest depth after all passages [µm], and its estimated error.

    Besides the size of the steps this has the share by which the depth of one passage may be wrong.
    """
    depth, share = float(worn.worn.max()), worn.estimate_largest_depth_energy / worn.largest_depth_energy
    return depth, float(worn.estimate_worn + share * depth)


def _largest(law: str) -> str:
    """Return the name of the largest depth that a law wears off."""
    return f"largest_depth_{law.replace(' ', '_')}"


def _difference(both: Sequence[tuple[float, float]], estimate: float) -> Cell:
    """Return how far a number of a half-space differs from that of the actual body [%], with an estimate."""
    value, other = both[0][0], both[1][0]
    if value == 0:
        return Cell("–")
    share, estimate = 100 * (other - value) / abs(value), 100 * estimate / abs(value)
    if np.isnan(estimate):
        return Cell(f"{number_text(share, '+.2g')} %")
    return Cell(f"{with_estimate(share, estimate, signed=True)} %")


def stress_table(dataset: xr.Dataset) -> Table:
    """Return the largest stresses in the actual bodies with their places, and how far half-spaces differ."""
    others = [source for source in sources(dataset) if source != ACTUAL]
    heads = [
        Column("largest", "MPa"),
        Column("over p_max"),
        *(Column(name, "mm") for name in ("x", "s", "depth")),
    ]
    heads += [Column(f"{source_label(dataset, source)}: differs by", "%") for source in others]
    rows = []
    for body in bodies(dataset):
        values = dataset.sel(body=body)
        actual = values.sel(source=ACTUAL)
        for name in (name for name in OF_STRESS if name in dataset):
            known = float(actual.get(f"estimate_{name}", np.nan))
            text = f"{float(actual[name]):.4g}" if np.isnan(known) else with_estimate(actual[name], known)
            places = [float(actual.get(f"{place}_{name}", np.nan)) for place in ("x", "s", "depth")]
            shares = [100 * float(values[f"difference_{name}"].sel(source=source)) for source in others]
            rows.append(
                Row(
                    f"{body} body, {OF_STRESS[name].meaning} {OF_STRESS[name].symbol}",
                    [
                        *(Cell(text), Cell(float(actual[f"{name}_over_p_max"]), ".3f")),
                        *(Cell(place, ".2g") for place in places),
                        *(Cell(share, "+.1f") for share in shares),
                    ],
                )
            )
        away = [100 * float(values.section_difference.sel(source=source)) for source in others]
        cells = [*(Cell("") for _ in range(5)), *(Cell(share, ".0f") for share in away)]
        rows.append(
            Row(
                f"{body} body, largest difference of σ_Mises on the section, in % of its largest value", cells
            )
        )
    return Table("stress", heads, rows)


def damage_table(dataset: xr.Dataset) -> Table:
    """Return wear and fatigue numbers, a column per ICs; below each number its difference."""
    names, reference = list(map(str, dataset.ics.values)), dataset.sel(ics=dataset.attrs["reference"])
    rows = []
    for variable, number in OF_DAMAGE.items():
        if variable in dataset:
            cells = []
            for name in names:
                value, estimate = (dataset[one].sel(ics=name) for one in (variable, f"estimate_{variable}"))
                text = f"{float(value):.4g}" if np.isnan(float(estimate)) else with_estimate(value, estimate)
                if name == dataset.attrs["reference"]:
                    below = ""
                elif variable == "surface_index":  # it may vanish
                    below = number_text(float(value - reference[variable]), "+.3f")
                else:
                    below = _change(value / reference[variable] - 1)
                cells.append(Cell(text, below=below))
            rows.append(Row(f"{number.title}: {number.meaning}", cells))
    return Table("number", [Column(ics_symbol(name)) for name in names], rows)


def worn_table(dataset: xr.Dataset) -> Table:
    """Return what all passages wear off and make of the contact, a column per ICs."""
    names, reference, rows = list(map(str, dataset.ics.values)), dataset.attrs["reference"], []
    for body in map(str, dataset.worn_body.values):
        if dataset.attrs[PASSES[body]] > 0:
            worn = dataset.worn.sel(worn_body=body).max("s")
            cells = []
            for name in names:
                value, estimate = worn.sel(ics=name), dataset.estimate_worn.sel(worn_body=body, ics=name)
                below = "" if name == reference else _change(value / worn.sel(ics=reference) - 1)
                cells.append(Cell(with_estimate(value, estimate), below=below))
            rows.append(Row(f"largest wear depth of the {body} body [µm]", cells))
    for variable, symbol in (("worn_p_max", "p_max [MPa]"), ("worn_work", "W [J/m]")):
        values = [dataset[variable].sel(ics=name).values for name in names]
        rows.append(Row(f"{symbol}, new → worn", [" → ".join(f"{v:.4g}" for v in both) for both in values]))
    turned = [f"{float(dataset.turned.sel(ics=name)):.2g}" for name in names]
    rows.append(Row("largest change of a surface's inclination [°]", turned))
    return Table("worn contact", [Column(ics_symbol(name)) for name in names], rows)


def _change(share: xr.DataArray) -> str:
    """Return a difference as a share, nothing where there is nothing to compare with."""
    return number_text(float(share), "+.1%") if np.isfinite(float(share)) else ""


# --- charts ---------------------------------------------------------------------------------------------


LOOKS = {ACTUAL: OWN["C"], HALF_SPACE: OWN["A"], HALF_SPACE_OF_A: OWN["B"]}
COMPONENTS = {  # of stresses: indices and looks
    "σ_xx": ((0, 0), Look("#0072b2")),
    "σ_ss": ((1, 1), Look("#e69f00")),
    "σ_nn": ((2, 2), Look("ink")),
    "σ_sn": ((1, 2), Look("#009e73", "dash")),
    "σ_xn": ((0, 2), Look("#d55e00", "dash")),
    "σ_xs": ((0, 1), Look("#cc79a7", "dash")),
}
SAME = 1e-9  # mm
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
    dataset: xr.Dataset, name: str, alt: str, heights: float, cells: Callable[[str], Sequence[ChartCell]]
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
    """Return the place of the largest von Mises stress in a actual body [mm]."""
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
                dataset[f"estimate_{_largest(law)}"],
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
