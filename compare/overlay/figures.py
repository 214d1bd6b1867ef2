"""The chart of an overlay: components of several scenes, one by one."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product

import numpy as np
import xarray as xr

from compare.ics.curves import INVISIBLE, by_component, combined_first, minus_c, of_differences
from compare.overlay.curves import curves_of, is_mirrored
from compare.overlay.results import Overlay
from compare.report.charts import Chart, Curve, Panel
from compare.report.looks import Look, looks_of, symbol_of

Looks = Mapping[str, Mapping[str, Look]]  # by variant and scene

OVERLAID_VARIANTS = ("A", "B", "Bhat")  # drawn in charts; tables also have the others
DASHES = ("solid", "dash", "dot", "dashdot", "longdash")  # of the scenes
WIDE_LINE, NARROW_LINE = 3.2, 1.2  # line widths, rear to front: curves that coincide stay visible


def drawn_variants(overlay: Overlay) -> tuple[str, ...]:
    """Return C and the common variants among `OVERLAID_VARIANTS`, or all common variants if none is."""
    common = overlay.common.variants
    return ("C", *(tuple(variant for variant in common if variant in OVERLAID_VARIANTS) or common))


def chart(overlay: Overlay) -> Chart:
    """Return the ICs of all scenes, dimensionless: as `compare.ics.curves.chart` of one scene."""
    first, *others = combined_first(overlay.common.bodies)
    ics = {result.name: result.ics for result in overlay.results}
    differences = {name: minus_c(dataset) for name, dataset in ics.items()}
    halves = {line: is_mirrored(overlay, line) for line in overlay.common.lines}
    looks = _looks(overlay)
    steps = {
        component: [
            *_panels(ics, halves, looks, [first], component),
            *map(of_differences, _panels(differences, halves, looks, [first], component)),
            *_panels(ics, halves, looks, others, component),
        ]
        for component in overlay.common.components
    }
    return by_component(steps, len(halves))


def _looks(overlay: Overlay) -> Looks:
    """Return looks by variant and scene: variants have colours, scenes dashes; wide lines lie behind."""
    variants, names = drawn_variants(overlay), [result.name for result in overlay.results]
    widths = np.linspace(WIDE_LINE, NARROW_LINE, len(variants))
    return {
        variant: {
            name: Look(look.colour, dash, width=round(width, 2))
            for name, dash in zip(names, DASHES, strict=False)
        }
        for (variant, look), width in zip(looks_of(variants).items(), widths, strict=True)
    }


def _panels(
    ics: Mapping[str, xr.Dataset],
    halves: Mapping[str, bool],
    looks: Looks,
    bodies: Sequence[str],
    component: str,
) -> Iterator[Panel]:
    """Yield panels of bodies on lines with the curves of all scenes; `halves` are lines shown in part."""
    for body, (line, half) in product(bodies, halves.items()):
        parts = {name: curves_of(dataset, line, body, component) for name, dataset in ics.items()}
        shown = {
            name: part.isel(point=part["at"].values >= (0 if half else -np.inf))
            for name, part in parts.items()
        }
        curves = [
            Curve(
                f"{symbol_of(variant)}, {name}",
                shown[name]["at"].values,
                shown[name].ic.sel(variant=variant).values,
                look,
                shown[name].estimate.values if variant == "C" else None,
            )
            for variant, scene_looks in looks.items()
            for name, look in scene_looks.items()
        ]
        across = next(iter(parts.values())).across
        yield Panel(f"{body}, {line}", across, f"{component} · E · L  [-]", curves, least=INVISIBLE)
