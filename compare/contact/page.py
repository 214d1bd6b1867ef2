"""`femic contact` solves the contact of a scene with several ICs and writes the file, figures and report."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
import xarray as xr

from compare.contact import figures, sensitivity
from compare.contact.compute import ContactResults, reference_name
from compare.contact.dataset import ics_of, others_of, reference_of, to_dataset, with_supports
from compare.matrix.compute import discounted
from compare.report import views
from compare.report.parts import (
    Block,
    Page,
    Picture,
    Section,
    Verbatim,
    extreme,
    join_words,
    onset,
    range_text,
    write_page,
    write_results,
)
from compare.report.styles import symbol_of
from compare.report.tables import Cell, Row, Table, changes_table, columns_of, numbers
from femic.cache import folders
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.scenes.scene import Scene
from geometries.patches import N

RELIEF = 0.2  # drawn height of the largest pressure over the grid's width
LIFTED = 0.02  # drawn height of pressures of 0 over the height of the largest
NO_OTHERS: Mapping[str, Mapping[str, float]] = MappingProxyType({})
GRIDS = (
    "Estimate: largest estimated error of C_nn over the largest C_nn. Asymmetry: largest |C(I, J) − C(J, I)|"
    "; contact takes the mean of both. Smallest eigenvalue over the least IC of an element on itself: for "
    "given loads, of pressures without vertical load; for given approaches, of all pressures. It must be "
    "positive, or contacts are not unique."
)
MAPS = (
    "Pressures computed with B̂ in one scene (row) on the patch of another (column), at the same x / a and "
    "s / b. Colours: normal displacement with A minus B̂, over the largest with B̂. A uniform difference "
    "changes the approach only; a varying one changes the pressures."
)
SIDEWAYS = 1e-3  # lateral force over load from which the summary mentions it
FAILS = 0.05  # deviation of the largest pressure from which the summary says that ICs fail


@dataclass(frozen=True)
class FurtherSolution:
    """A further solution of the same contacts: a section, rows by number of the case, and a note."""

    section: Section
    rows: Mapping[int, Row]
    note: str


def write_contact(
    results: ContactResults,
    out: Path,
    supports: Mapping[str, Mapping[str, float]] = NO_OTHERS,
    further: FurtherSolution | None = None,
) -> Path:
    """Write `contact.nc`, figures and `contact.html` into a folder; returns the path of the page.

    `supports` has the numbers of the largest contact with other supports, by change.
    """
    dataset = with_supports(to_dataset(results), supports)
    sections = _sections(results, dataset, further, folders.make(out / "figures"))
    return write_results(
        Page(str(dataset.attrs["title"]), summary(dataset), sections), out, "contact", dataset
    )


def _sections(
    results: ContactResults, dataset: xr.Dataset, further: FurtherSolution | None, folder: Path
) -> Iterator[Section]:
    drawn = [
        Picture("numbers", figures.over_angle(dataset)),
        Picture("profiles", figures.profiles(dataset)),
        Picture("surfaces", figures.surfaces(dataset)),
        *(_pictures_in_3d(results, folder) if views.can_render() else ()),
    ]
    yield Section("Numbers over the angle of the patch", drawn)
    if further:
        yield further.section
    yield Section("Numbers by case", [_explanation(dataset, further), *_tables(dataset, further)])
    yield Section("Rigid motions and supports of the bodies", list(_supports(results.scene, dataset)))
    seconds = f"Total: {results.solved.seconds:.1f} s."
    yield Section("Grids, and C on them", [GRIDS, _grids_table(results), seconds])
    yield Section("The scene", [Verbatim(results.scene.text)])


def _explanation(dataset: xr.Dataset, further: FurtherSolution | None) -> str:
    text = (
        "Of the patch with the largest load. Small, below each number: its estimated error (from elements "
        "twice and four times as large; of C also from C plus its own estimate), and its ratio to the number "
        f"with {symbol_of(reference_of(dataset))}. “p_max, displaced”: with the distance of the displaced "
        "body instead of the linearised one; a dash where that contact exceeds the grid, or has no "
        "solution. Seconds: pressures alone; the seconds of C itself are below."
    )
    return f"{text} {further.note}" if further else text


def _pictures_in_3d(results: ContactResults, folder: Path) -> Iterator[Picture]:
    """Draw pressures of the reference on the lower surface, as heights and colours, a picture per case."""
    name = reference_name(results.solved.ics)
    for number, loading in enumerate(results.solved.loadings):
        contact = results.solved.contacts[loading, name]
        surface, grid = contact.on_grid.undeformed.lower, contact.on_grid.grid
        p = np.where(contact.normal.in_contact, contact.normal.p, np.nan)
        x = np.linspace(contact.on_grid.x[0], contact.on_grid.x[-1], 2)
        s = np.linspace(*surface.contour.limits, 200)
        path = folder / f"contact_3d_{number}.png"
        rail, patch = (
            np.reshape(surface.position(*map(np.ravel, np.meshgrid(*at, indexing="ij"))), (3, *map(len, at)))
            for at in ((x, s), (contact.on_grid.x, grid.strips))
        )
        heights = RELIEF * grid.n_s * grid.ds * (contact.normal.p / contact.normal.p.max() + LIFTED)
        raised = patch + heights * surface.axes(0.0, grid.strips)[N][:, None]
        views.draw_pressures(rail, raised, p, path, title=f"{loading}, pressures with {name}")
        yield Picture(path.stem, path)


def write_sensitivity(results: Mapping[str, ContactResults], out: Path) -> Path:
    """Write maps of where A and B-hat differ, of two or more scenes, and their page; returns its path."""
    maps = Picture("sensitivity", sensitivity.maps(results))
    title = f"Where A and B̂ differ: {', '.join(results)}"
    page = Page(title, sensitivity.summary(results), [Section("", [MAPS, maps])])
    return write_page(page, folders.make(out) / "contact.html")


def summary(dataset: xr.Dataset) -> str:
    """Return sentences computed from the numbers: deviations of each of the ICs, and their onset."""
    reference, cases = reference_of(dataset), dataset.sizes["case"]
    symbol, angle = symbol_of(reference), dataset.angle.sel(ics=reference)
    patches = "One case, a patch" if cases == 1 else f"{cases} cases, patches"
    sentences = [f"{patches} over {range_text(angle, '.0f')} degrees with {symbol}."]
    for name in others_of(dataset):
        p_max, b, approach = (
            dataset[key].sel(ics=name) / dataset[key].sel(ics=reference) - 1
            for key in ("p_max", "b", "approach")
        )
        failing = onset(angle.values, (abs(p_max) > FAILS).values)
        fails = f"off by more than {FAILS:.0%} {failing}" if failing else f"within {FAILS:.0%} everywhere"
        sentences.append(
            f"{symbol_of(name)}: p_max {extreme(p_max):+.1%}, b {extreme(b):+.1%}, approach "
            f"{extreme(approach):+.1%} of {symbol}'s at worst; p_max is {fails}."
        )
    sentences += _lateral_force_sentence(dataset)
    seconds = dataset.seconds.values
    sentences.append(
        f"Pressures took {seconds.min():.2g} ... {seconds.max():.2g} s a case"
        + (f", C on its grids {_seconds_of_c(dataset):.0f} s." if "C" in dataset.ics else ".")
    )
    displaced = abs(dataset.displaced_p_max / dataset.p_max - 1).sel(ics=reference)
    if displaced.notnull().any():
        sentences.append(
            f"The exact distance of the displaced body instead of the linearised one changes p_max by up to "
            f"{float(displaced.max()):.1%}."
        )
    return " ".join(sentences)


def _lateral_force_sentence(dataset: xr.Dataset) -> Iterator[str]:
    """Yield a sentence on the lateral force, where the contact is not symmetric."""
    shares, reference = dataset.F_y / dataset["load"], reference_of(dataset)
    shares = shares.isel(case=int(np.argmax(abs(shares.sel(ics=reference)).values)))
    share = float(shares.sel(ics=reference))
    if abs(share) < SIDEWAYS:
        return
    others = join_words(
        f"{float(shares.sel(ics=name)):+.3f} with {symbol_of(name)}" for name in others_of(dataset)
    )
    yield (
        f"The lateral force on the upper body is {share:+.3f} of the load with "
        f"{symbol_of(reference)} at {shares.case.item()}"
        + (f", {others}: approximations lack the bending of the sections." if others else ".")
    )


def _seconds_of_c(dataset: xr.Dataset) -> float:
    return sum(float(of_grid["seconds"]) for of_grid in json.loads(dataset.attrs["references"]).values())


def _tables(dataset: xr.Dataset, further: FurtherSolution | None) -> Iterator[Table]:
    """Yield a table per case: each number with its estimate, its ratio to the reference, and the cost."""
    columns = [*columns_of(OF_FRICTIONLESS.values()), *numbers("p_max, displaced", "iterations", "s")]
    for number, name in enumerate(dataset.case.values):
        case = dataset.isel(case=number)
        rows = [_row(case, ics) for ics in ics_of(case)]
        if further and number in further.rows:
            rows.append(further.rows[number])
        yield Table(str(name), columns, rows)


def _row(case: xr.Dataset, name: str) -> Row:
    selected, reference = case.sel(ics=name), case.sel(ics=reference_of(case))
    ratios = selected / reference
    estimates = {key: selected[f"estimate_{key}"] for key in OF_FRICTIONLESS}
    cells = [
        Cell(float(selected[key]), ".5g", f"± {float(estimates[key]):.2g}; {float(ratios[key]):.4f}")
        for key in OF_FRICTIONLESS
    ]
    cost = Cell(int(selected.iterations)), Cell(float(selected.seconds), ".2f")
    return Row(symbol_of(name), [*cells, Cell(float(selected.displaced_p_max), ".5g"), *cost])


def _supports(scene: Scene, dataset: xr.Dataset) -> Iterator[Block]:
    """Yield the rigid motions subtracted from C, and the effect of other supports on the largest contact."""
    if "supports" not in dataset.coords:
        yield discounted(scene)
        return
    yield f"{discounted(scene)} How other supports change the largest contact computed with C:"
    with_c = dataset.sel(ics="C").isel(case=int(dataset.attrs["supported_case"]))
    yield changes_table("supports", OF_FRICTIONLESS, with_c, dataset, "supported_")


def _grids_table(results: ContactResults) -> Table:
    """Return the table of grids, with the estimate of C on each."""
    rows = []
    for grid in dict.fromkeys(contact.on_grid.grid for contact in results.solved.contacts.values()):
        name = f"{grid.n_x} x {grid.n_s} elements of {grid.dx:.4g} x {grid.ds:.4g} mm"
        cells = ["–"] * 4
        if c := results.solved.references.get(grid):
            cells = [
                f"{c.estimate:.2%}",
                f"{c.asymmetry.share:.1e}",
                f"{c.eigenvalue:.3f}",
                f"{c.seconds:.1f}",
            ]
        rows.append(Row(name, cells))
    return Table("grid", ["estimate", "asymmetry", "smallest eigenvalue", "s for C"], rows)
