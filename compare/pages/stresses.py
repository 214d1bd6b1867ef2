"""`femic stresses` writes the file, figures and the page of stresses, wear and fatigue below a contact.

The page says whether both bodies yield, whether they ratchet, and how much a passage wears off.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from compare.pages.stress_figures import (
    SAME,
    bodies,
    depth_curves,
    estimate_chart,
    fatigue_chart,
    load_cycle,
    plane_chart,
    reference_symbol,
    section_chart,
    wear_chart,
    worn_chart,
)
from compare.pages.stress_tables import (
    answer_table,
    damage_table,
    exceeds,
    place_text,
    ratchets,
    stress_table,
    worn_table,
)
from compare.report.parts import Block, Folded, Note, Page, Section, Verbatim, write_results
from compare.report.tables import number_text, with_estimate
from compare.report.verdicts import NO, NOT_DECIDED, YES
from femic.results.damage import OF_DAMAGE
from femic.results.stresses import ACTUAL

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
STEEPEST = 1.0  # degrees by which wear may turn a surface before its ICs are doubtful


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
