"""What a comparison found, in one paragraph."""

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from compare.pages.html import percent
from compare.pages.styles import SYMBOLS
from compare.results.compute import Results
from compare.results.measure import ROUNDING
from femic.accuracy import component_of


def summary(results: Results, errors: xr.Dataset) -> str:
    """One paragraph, computed: worst error per variant, best variant per component, accuracy of C."""
    body = results.scene.compared[0]
    of_body, computed = errors.sel(body=body), _computed(results, body)
    gone = [c for c in results.scene.components if component_of(of_body.vanishes.values, c)]
    present = [c for c in results.scene.components if c not in gone]
    sentences = []
    if present:
        sentences += [
            f"Largest error of the {body} influence coefficients on the {len(results.lines)} lines, as a "
            f"share of the component itself: {', '.join(_worst(of_body, present, computed))}.",
            f"Closest to C: {'; '.join(_best(of_body, present, computed))}.",
        ]
    if gone:
        sentences.append(_on_zeros(of_body, gone, computed))
    return " ".join([*sentences, *_how_well(results, of_body, present)])


def _worst(of_body: xr.Dataset, components: Sequence[str], computed: Sequence[str]) -> Iterator[str]:
    """The largest error of each variant, and where it is."""
    for variant in computed:
        error, component, line = _worst_of(of_body.error.sel(variant=variant), components)
        yield f"{SYMBOLS[variant]} {percent(error)} ({component} on {line})"


def _best(of_body: xr.Dataset, components: Sequence[str], computed: Sequence[str]) -> Iterator[str]:
    """The variants with the least error of each component."""
    for component in components:
        worst = of_body.error.sel(i=component[0], j=component[1]).max("line")
        values = {v: worst.sel(variant=v).item() for v in computed}
        least = min(values.values())
        names = " = ".join(SYMBOLS[v] for v, value in values.items() if value <= least * (1 + 1e-6))
        yield f"{component}: {names} ({percent(least)})"


def _on_zeros(of_body: xr.Dataset, components: Sequence[str], computed: Sequence[str]) -> str:
    """What variants make of components that vanish."""
    found = [(*_worst_of(of_body.weight.sel(variant=v), components), v) for v in computed]
    weight, component, line, variant = max(found)
    vanish = f"{', '.join(components)} of C vanish{'es' if len(components) == 1 else ''}"
    if weight < ROUNDING:
        return f"{vanish}, and so do those of the variants."
    where = f"{SYMBOLS[variant]}, {component} on {line}"
    return f"{vanish}; there variants are off by up to {percent(weight)} of C_nn ({where})."


def _how_well(results: Results, of_body: xr.Dataset, present: Sequence[str]) -> Iterator[str]:
    """How well C is known, of itself and as refinement sees it, and what the other engine says."""
    if present:
        known, *where = _worst_of(of_body.error.sel(variant="C"), present)
        yield f"C itself is known to {known:.2%} of a component or better (least well: {' on '.join(where)})."
    known, *where = _worst_of(of_body.estimate_refinement, results.scene.components)
    yield f"On the scale of refinement it is known to {known:.2%} ({' on '.join(where)})."
    if results.checks and present:
        apart, *where = _worst_of(of_body.error.sel(variant="C_solid"), present)
        yield (
            f"The solid engine's C deviates from it by {apart:.2%} of a component at most "
            f"({' on '.join(where)})."
        )


def _computed(results: Results, body: str) -> list[str]:
    """The variants that could be computed."""
    seconds = results.seconds
    return [variant for variant in results.scene.variants if not np.isnan(seconds[variant, body])]


def _worst_of(errors: xr.DataArray, components: Sequence[str]) -> tuple[float, str, str]:
    """The largest of components on lines, and where it is."""
    return max(
        (errors.sel(i=c[0], j=c[1], line=line).item(), c, str(line))
        for c in components
        for line in errors.line.values
    )
