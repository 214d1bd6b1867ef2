"""`femic stresses` writes the file, figures and the page of stresses below a contact."""

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from compare.pages import stress_figures as figures
from compare.pages.stress_answers import damage_table, reference_symbol, stress_table, summary, worn_table
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, write_results

SECTION = (
    "“true” and “half-space” have the tractions of the reference, “half-space of A” those of A. "
    "Von Mises stresses over arc length s (of the lower contour) and depth below each surface, at the x of "
    "the largest one. Beside the true body: the estimated error of the largest stress component; beside "
    "half-spaces: their difference to the true body."
)
WEAR = (
    "Per passage of the contact the rail, per revolution the wheel, loses these depths. Energy: Krause and "
    "Poll; twin disc: the BRR function of T-gamma over area; Archard: the wear map of KTH. Coefficients are "
    "those of dry steel in laboratories: ratios between ICs are surer than depths."
)
WORN = (
    "{:g} passages of such wheels wear the rail, {:g} revolutions the wheel, in {} steps or less, by the law "
    "of energy: after each the contact is solved again with the gap that both have lost. ± is the error by "
    "the size of steps alone. ICs are those of the new surfaces: once a surface has turned by more than 1°, "
    "components that vanish on new ones may be off by that angle times C_nn."
)
SHAKEDOWN = (
    " The limit of p_max/k is that of residual stresses without shear along x: exact for lines, a lower "
    "bound for a patch on one track."
)
FATIGUE = (
    "Dang Van's equivalent stress (c = {:.3g} in tension, {:.3g} in compression) over the cycle from no "
    "stress through all x. Fatigue is to be expected where it exceeds the fatigue limit in shear."
)


def write_stresses(dataset: xr.Dataset, out: Path) -> Path:
    """Write `stresses.nc`, figures and `stresses.html`; return the path of the page."""
    page = Page(
        str(dataset.attrs["title"]), summary(dataset), list(_sections(dataset)), stress_table(dataset)
    )
    return write_results(page, out, "stresses", dataset)


def _sections(dataset: xr.Dataset) -> Iterator[Section | Folded]:
    yield Section("", [figures.section_maps(dataset), Note(SECTION)])
    bands = Note("Bands: the estimated error of the largest stress component in the true body.")
    yield Section("Into depth", [figures.depth_curves(dataset), bands])
    yield Section("Along the rolling direction", [figures.plane_maps(dataset)])
    cycle = Note("Stresses along x, s, n of the surface above, at the place of the largest von Mises stress.")
    yield Section("The load cycle", [figures.load_cycle(dataset), cycle])
    if "dang_van" in dataset:
        yield Section("Fatigue below the surface", [figures.fatigue_maps(dataset), Note(_fatigue(dataset))])
    if "ics" in dataset.dims:
        yield Section("Wear and surface fatigue by ICs", list(_wear(dataset)))
    if "worn" in dataset:
        yield Section("After all passages", list(_worn(dataset)))
    yield Folded("How these numbers are computed", list(_method(dataset)))
    yield Folded("Scene file", [Verbatim(str(dataset.attrs["scene"]))])


def _fatigue(dataset: xr.Dataset) -> str:
    c = float(dataset.attrs["dang_van_hydrostatic"])
    return FATIGUE.format(c, c * float(dataset.attrs["dang_van_compression"]))


def _wear(dataset: xr.Dataset) -> Iterator[Block]:
    yield damage_table(dataset)
    small = f"Small, below each number: its difference to that with {reference_symbol(dataset)}."
    without = (
        ""
        if "speed" in dataset.attrs
        else " Without damage.speed (--speed) wear by energy is mild everywhere."
    )
    unknown = (
        SHAKEDOWN
        if "yield_stress" in dataset.attrs
        else " With damage.yield_stress (--yield-stress): shakedown and surface index."
    )
    yield Note(small + without + unknown)
    yield figures.wear_chart(dataset)
    yield Note(WEAR)


def _worn(dataset: xr.Dataset) -> Iterator[Block]:
    yield worn_table(dataset)
    yield figures.worn_chart(dataset)
    yield Note(
        WORN.format(dataset.attrs["passages"], dataset.attrs["revolutions"], int(dataset.wear_steps.max()))
    )


def _method(dataset: xr.Dataset) -> Iterator[Block]:
    seconds = float(dataset.attrs["seconds"])
    lattice = " × ".join(str(dataset.sizes[f"{name}_lower"]) for name in ("x", "s", "depth"))
    yield (
        f"Tractions of {reference_symbol(dataset)} load both true bodies (harmonic engine) and half-spaces "
        f"that are unrolled by arc length, at {lattice} points; largest values are those on these points. "
        f"All of it took {seconds:.0f} s."
    )
