"""Labelled arrays with dimensions and coordinates in any order: the same results, files and figures."""

from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from fuzz import outcome
from outcomes import Outcome

import femic
from femic.contact.specification import extra_gap

SOFT = femic.Material(E=70e3, nu=0.2)  # so that xn is not zero
PAIR = femic.Pair(
    upper=femic.Body(femic.arc(10.6, 60.0), SOFT, rolling_radius=500.0),
    lower=femic.Body(femic.arc(10.0, 60.0), femic.Material(E=210e3, nu=0.3)),
)
GRID = femic.Grid(n_x=14, n_s=15, dx=0.9, ds=0.45, s=0.4)
SETUP = femic.ContactSetup(elements=8, shift=0.01)
PRESSED, COMPRESSED = femic.Frictionless((500.0, 1e3)), femic.Compression((1.5e3,), 0.3)
LINES = [femic.line_along_x(1.6, 6.0, 9), femic.line_along_s(1.6, 6.0, 13)]
SAME_GAP = 1e-12  # mm, to which gaps of the same points are the same


def labels(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield matrices, ICs, contacts and gaps in random orders."""
    for number in range(count):
        use, chance = USES[number % len(USES)], np.random.default_rng([seed, number])
        yield outcome(f"{use.__name__} {number}", partial(_same, use, chance, folder))


def _same(use: Any, chance: np.random.Generator, folder: Path) -> str:
    try:
        short = use(chance, folder)
    except (femic.WrongInput, femic.Failure) as error:
        short = str(error)
    if short:
        raise AssertionError(short)
    return "the same"


def shuffled(labelled: Any, chance: np.random.Generator, *along: str) -> Any:
    """Return a labelled array with dimensions, and labels along some of them, in a random order."""
    for dim in along:
        labelled = labelled.isel({dim: chance.permutation(labelled.sizes[dim])})
    return labelled.transpose(*chance.permutation([str(dim) for dim in labelled.dims]))


def of_matrix(chance: np.random.Generator) -> xr.Dataset:
    """Return the matrix in a random order."""
    return shuffled(matrix(), chance, "lag", "observed", "loaded", "i", "j")


@cache
def matrix() -> xr.Dataset:
    """B-hat with an estimate, which has no symmetry."""
    b_hat = femic.compute_matrix(PAIR, GRID, "Bhat").ic.values
    estimate = np.abs(b_hat) * np.linspace(0.01, 0.03, GRID.n_s)[None, :, None, None, None]
    return femic.label_matrix(b_hat, GRID, "mine", estimate)


@cache
def contact(motion: Any) -> xr.Dataset:
    """Contacts with the matrix, and with A."""
    return femic.solve_contact(PAIR, motion, [matrix(), "A"], SETUP)


@cache
def ics() -> xr.Dataset:
    """ICs on two lines, with B-hat as C."""
    known = femic.compute_ics(PAIR, femic.Patch(0.3, 0.2), LINES, ["A", "B", "Bhat"])
    known = known.assign_coords(variant=["A", "B", "C"])
    return known.assign(estimate=0.02 * abs(known.ic.sel(variant="C", drop=True)))


# --- uses of labelled arrays: what differs, "" if nothing does -------------------------------------------


def labelled_again(chance: np.random.Generator, _: Path) -> str:
    other, estimate = of_matrix(chance).ic, of_matrix(chance).estimate
    again = femic.label_matrix(other, GRID, "mine", estimate)
    return "" if again.identical(matrix()) else f"{other.dims}: another matrix"


def solved(chance: np.random.Generator, _: Path) -> str:
    motion = (PRESSED, COMPRESSED)[int(chance.integers(2))]
    found = femic.solve_contact(PAIR, motion, [of_matrix(chance), "A"], SETUP)
    return _differences(found, contact(motion))


def written(chance: np.random.Generator, folder: Path) -> str:
    texts = []
    for name, one in (("one", matrix()), ("other", of_matrix(chance))):
        femic.write_for_contact(PAIR, one, folder / name)
        texts.append((folder / name).read_text(encoding="utf-8").split("\n\n")[-1])
    return "" if texts[0] == texts[1] else "another file"


def compared(chance: np.random.Generator, _: Path) -> str:
    errors = femic.compare_ics(shuffled(ics(), chance, "i", "j", "body", "variant", "point"))
    return _differences(errors, femic.compare_ics(ics()))


def drawn_ics(chance: np.random.Generator, _: Path) -> str:
    component = str(chance.choice(["nn", "xn", "ss"]))
    other = shuffled(ics(), chance, "i", "j", "point")
    return (
        ""
        if _curves(femic.plot_ics(other, component)) == _curves(femic.plot_ics(ics(), component))
        else "figure"
    )


def drawn_contact(chance: np.random.Generator, _: Path) -> str:
    motion = (PRESSED, COMPRESSED)[int(chance.integers(2))]
    other = shuffled(contact(motion), chance, "x", "s", "case" if motion is PRESSED else "load")
    return (
        "" if _curves(femic.plot_contact(other)) == _curves(femic.plot_contact(contact(motion))) else "figure"
    )


def gap(chance: np.random.Generator, _: Path) -> str:
    on_grid = np.stack(np.meshgrid(np.linspace(-4, 4, 6), np.linspace(-3, 3, 5)), axis=-1).reshape(-1, 2)
    places = on_grid if chance.random() < 0.5 else chance.uniform(-4, 4, (30, 2))
    columns = np.column_stack([places, chance.uniform(-0.02, 0.02, 30)])
    columns = columns[:, int(places is not on_grid and chance.integers(2)) :]
    x, s = np.linspace(-4, 4, 33)[:, None], np.linspace(-4, 4, 29)
    one, other = (
        extra_gap(femic.ContactSetup(extra_gap=rows).extra_gap).at(x, s)
        for rows in (columns, chance.permutation(columns))
    )
    return "" if np.max(np.abs(one - other)) < SAME_GAP else "another gap"


USES = (labelled_again, solved, written, compared, drawn_ics, drawn_contact, gap)


def _differences(found: xr.Dataset, expected: xr.Dataset) -> str:
    """Return the variables that differ, by their labels."""
    if {*found.data_vars} != {*expected.data_vars}:
        return f"other variables: {sorted(map(str, {*found.data_vars} ^ {*expected.data_vars}))}"
    found = found.reindex_like(expected)
    names = [name for name in expected.data_vars if not str(name).endswith("seconds")]
    return ", ".join(f"{name} differs" for name in names if not found[name].equals(expected[name]))


def _curves(figure: Any) -> list[Any]:
    """Return the curves and pictures of a figure, in an order of their own."""
    lines = [line.get_xydata().tolist() for axes in figure.axes for line in axes.get_lines()]
    pictures = [np.asarray(mesh.get_array()).tolist() for axes in figure.axes for mesh in axes.collections]
    return sorted(map(str, lines + pictures))
