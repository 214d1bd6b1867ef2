"""Tables of the stresses, wear and fatigue below a contact, and the verdicts in them."""

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from compare.pages.stress_figures import bodies, compared, largest_depth, source_label, sources
from compare.report.looks import ics_symbol
from compare.report.tables import Cell, Column, Row, Table, number_text, with_estimate
from compare.report.verdicts import NO, YES, verdict
from femic.results.damage import OF_DAMAGE
from femic.results.stresses import ACTUAL, HALF_SPACE_OF_A, OF_STRESS

SURFACE = 1e-9  # mm: depths below are the surface
PASSES = {"lower": "passages", "upper": "revolutions"}  # attributes: what wears a body


def exceeds(value: float | xr.DataArray, estimate: float | xr.DataArray, limit: float) -> str:
    """Return whether a value exceeds a limit, which is whether it is not within it."""
    within = verdict(value, estimate, limit)
    return {YES: NO, NO: YES}.get(within, within)


def ratchets(damage: xr.Dataset) -> str:
    """Return whether p_max/k of a contact exceeds the shakedown limit: a load factor below 1."""
    return exceeds(-damage.load_factor, damage.estimate_load_factor, -1.0)


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
        depths = numbers(largest_depth(law))
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
