"""Sentences and tables on stresses below a contact, and on wear and fatigue."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from compare.report.parts import extreme, join_words
from compare.report.tables import Cell, Column, Row, Table, number_text, with_estimate
from femic.results.damage import OF_DAMAGE, Number
from femic.results.stresses import HALF_SPACE, HALF_SPACE_OF_A, OF_STRESS, TRUE

SURFACE = 1e-9  # mm: depths below are the surface
PASSES = {"lower": "passages", "upper": "revolutions"}  # attributes: what wears a body


def reference_symbol(dataset: xr.Dataset) -> str:
    """Return the symbol of the ICs whose tractions load the bodies."""
    return symbol_of(str(dataset.attrs["reference"]))


def source_label(dataset: xr.Dataset, source: str) -> str:
    """Return in words which body and which tractions stresses are of."""
    if source == HALF_SPACE_OF_A:
        return "half-space, tractions of A"
    return f"{source}, tractions of {reference_symbol(dataset)}"


def sources(dataset: xr.Dataset) -> list[str]:
    """Return the sources; half-spaces under A's tractions only where these are others."""
    names = [str(name) for name in dataset.source.values]
    return [name for name in names if name != HALF_SPACE_OF_A or dataset.attrs["reference"] != "A"]


def bodies(dataset: xr.Dataset) -> list[str]:
    """Return the names of the bodies."""
    return [str(name) for name in dataset.body.values]


def summary(dataset: xr.Dataset) -> str:
    """Return the answer in at most three sentences: where bodies are loaded most, half-spaces, damage."""
    return " ".join([_most_loaded(dataset), _half_spaces(dataset), *_damage(dataset)])


def _most_loaded(dataset: xr.Dataset) -> str:
    """Return where the von Mises stress of each body is largest."""
    texts = []
    for body in bodies(dataset):
        true = dataset.sel(body=body, source=TRUE)
        number = with_estimate(true.von_mises, true.estimate_von_mises)
        texts.append(f"the {body} body has {number} MPa {place_text(true, 'von_mises')}")
    motion = f", friction {dataset.attrs['friction']:g}" if dataset.attrs["friction"] else ""
    p_max = f"p_max {dataset.attrs['p_max_of_reference']:.0f} MPa"
    begun = f"At {dataset.attrs['load']}{motion} (tractions of {reference_symbol(dataset)}, {p_max})"
    return f"{begun} von Mises stresses are largest so: {join_words(texts)}."


def place_text(numbers: xr.Dataset, name: str) -> str:
    """Return where a number is largest."""
    s, depth = float(numbers[f"s_{name}"]), float(numbers[f"depth_{name}"])
    x = f"x = {float(numbers[f'x_{name}']):.2g}, " if f"x_{name}" in numbers else ""
    edge = " (as deep as was computed)" if bool(numbers[f"deepest_{name}"]) else ""
    where = "on the surface" if depth < SURFACE else f"{depth:.2g} mm deep{edge}"
    return f"{where} at {x}s = {s:.2g} mm"


def _half_spaces(dataset: xr.Dataset) -> str:
    """Return how far stresses in half-spaces are off."""
    texts = []
    for source in sources(dataset)[1:]:
        values = dataset.sel(source=source)
        off = join_words(
            f"{number_text(float(values.difference_von_mises.sel(body=body)), '+.0%')} in the {body} body"
            for body in bodies(dataset)
        )
        most = float(values.section_difference.max())
        whose = "the same tractions" if source == HALF_SPACE else "the tractions of A"
        texts.append(f"with {whose} by {off} (up to {most:.0%} of it elsewhere on the section)")
    return f"In half-spaces the largest one is off {join_words(texts)}."


def _damage(dataset: xr.Dataset) -> Iterator[str]:
    """Yield what half-spaces, and ICs of half-spaces, do to fatigue and wear."""
    texts = []
    if "dang_van" in dataset:
        last = sources(dataset)[-1]
        off = extreme(dataset.difference_dang_van.sel(source=last))
        known = f"off by {number_text(off, '+.0%')}" if np.isfinite(off) else "none"
        texts.append(f"Dang Van's stress is {known} ({source_label(dataset, last)})")
    if "ics" in dataset.dims and dataset.attrs["reference"] != "A" and "A" in dataset.ics.values:
        by_a, reference = dataset.sel(ics="A"), dataset.sel(ics=dataset.attrs["reference"])
        named = {
            "work": "the work of friction",
            "t_gamma": "T-gamma",
            "largest_depth_energy": "the worn depth",
        }
        for name, words in named.items():
            if of_reference := float(reference[name]):
                texts.append(f"{words} with A by {number_text(float(by_a[name]) / of_reference - 1, '+.1%')}")
            else:
                texts.append(f"{words} with {reference_symbol(dataset)} is none")
    if texts:
        yield f"So {join_words(texts)}."


def stress_table(dataset: xr.Dataset) -> Table:
    """Return the largest stresses of each body and source: value, over p_max, place, difference."""
    names = [name for name in OF_STRESS if name in dataset]
    heads = [Column(OF_STRESS[name].symbol, OF_STRESS[name].unit) for name in names]
    share = Column("largest difference on the section", "% of largest σ_Mises")
    rows = []
    for body in bodies(dataset):
        for source in sources(dataset):
            numbers = dataset.sel(body=body, source=source)
            cells = [_stress_cell(numbers, name, source) for name in names]
            off = Cell("" if source == TRUE else f"{100 * float(numbers.section_difference):.0f}")
            rows.append(Row(f"{body} body: {source_label(dataset, source)}", [*cells, off]))
    return Table("body, stresses", [*heads, share], rows)


def _stress_cell(numbers: xr.Dataset, name: str, source: str) -> Cell:
    """Return a stress with its estimate or its difference to the true body, and below it over p_max."""
    known = numbers.get(f"estimate_{name}", np.nan)
    text = with_estimate(numbers[name], known) if source == TRUE else f"{float(numbers[name]):.0f}"
    if source == TRUE and np.isnan(float(known)):
        text = f"{float(numbers[name]):.0f}"
    difference = "" if source == TRUE else f"{number_text(float(numbers[f'difference_{name}']), '+.1%')}; "
    over = "" if source == HALF_SPACE_OF_A else f"{float(numbers[f'{name}_over_p_max']):.3f} p_max; "
    return Cell(text, below=f"{difference}{over}{place_text(numbers, name)}")


def damage_table(dataset: xr.Dataset) -> Table:
    """Return wear and fatigue numbers, a column per ICs; below each number its difference."""
    names = [str(name) for name in dataset.ics.values]
    reference = dataset.sel(ics=dataset.attrs["reference"])
    rows = []
    for variable, number in damage_numbers(dataset).items():
        cells = [_damage_cell(dataset.sel(ics=name), reference, variable) for name in names]
        rows.append(Row(f"{number.title}: {number.meaning}", cells))
    return Table("number", [Column(symbol_of(name)) for name in names], rows)


def worn_table(dataset: xr.Dataset) -> Table:
    """Return what all passages wear off and make of the contact, a column per ICs."""
    names = [str(name) for name in dataset.ics.values]
    reference = dataset.sel(ics=dataset.attrs["reference"])
    rows = []
    for body in map(str, dataset.worn_body.values):
        if dataset.attrs[PASSES[body]] > 0:
            cells = [_worn_cell(dataset.sel(ics=name), reference, body) for name in names]
            rows.append(Row(f"largest depth worn off the {body} body [µm]", cells))
    for variable, symbol in (("worn_p_max", "p_max [MPa]"), ("worn_work", "W [J/m]")):
        cells = [
            Cell(" → ".join(f"{float(value):.4g}" for value in dataset[variable].sel(ics=name)))
            for name in names
        ]
        rows.append(Row(f"{symbol}, new → worn", cells))
    turned = [Cell(f"{float(dataset.turned.sel(ics=name)):.2g}") for name in names]
    rows.append(Row("largest change of a surface's inclination [°]", turned))
    return Table("worn contact", [Column(symbol_of(name)) for name in names], rows)


def _worn_cell(numbers: xr.Dataset, reference: xr.Dataset, body: str) -> Cell:
    value, estimate = numbers.worn.sel(worn_body=body).max(), numbers.estimate_worn.sel(worn_body=body)
    of_reference = float(reference.worn.sel(worn_body=body).max())
    same = str(numbers.ics.values) == str(reference.ics.values)
    below = "" if same or not of_reference else f"{number_text(float(value) / of_reference - 1, '+.1%')}"
    return Cell(with_estimate(value, estimate), below=below)


def damage_numbers(dataset: xr.Dataset) -> dict[str, Number]:
    """Return the numbers of wear and fatigue in a dataset by the names of their variables."""
    return {name: number for name, number in OF_DAMAGE.items() if name in dataset}


def _damage_cell(numbers: xr.Dataset, reference: xr.Dataset, name: str) -> Cell:
    value, estimate = numbers[name], numbers[f"estimate_{name}"]
    text = f"{float(value):.4g}" if np.isnan(float(estimate)) else with_estimate(value, estimate)
    if str(numbers.ics.values) == str(reference.ics.values):
        return Cell(text)
    if name == "surface_index":  # it may vanish
        return Cell(text, below=f"{number_text(float(value - reference[name]), '+.3f')}")
    return Cell(
        text,
        below=f"{number_text(float(value / reference[name]) - 1, '+.1%')}" if float(reference[name]) else "",
    )
