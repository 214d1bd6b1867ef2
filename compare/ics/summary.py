"""The result of a comparison in one paragraph."""

from collections.abc import Iterator, Sequence

import xarray as xr

from compare.ics.compute import Results
from compare.report.errors import percent
from compare.report.styles import SYMBOLS
from femic.ic_errors.error_measure import ROUNDING
from femic.reference.accuracy import component_of


def summary(results: Results, errors: xr.Dataset) -> str:
    """Return a paragraph on each variant's worst error, each component's best variant, and C's accuracy."""
    body = results.scene.compared[0]
    body_errors = errors.sel(body=body)
    computed = [variant for variant in results.computed(body) if variant in results.scene.variants]
    vanishing = [c for c in results.scene.components if component_of(body_errors.vanishes.values, c)]
    present = [c for c in results.scene.components if c not in vanishing]
    sentences = []
    if present:
        sentences += [
            f"Largest error of the {body} influence coefficients on the {len(results.lines)} lines, as a "
            f"share of the component itself: {', '.join(_worst(body_errors, present, computed))}.",
            f"Closest to C: {'; '.join(_best(body_errors, present, computed))}.",
        ]
    if vanishing:
        sentences.append(_vanishing_sentence(body_errors, vanishing, computed))
    return " ".join([*sentences, *_accuracy_sentences(results, body_errors, present)])


def _worst(body_errors: xr.Dataset, components: Sequence[str], computed: Sequence[str]) -> Iterator[str]:
    """Yield the largest error of each variant, and the component and line that have it."""
    for variant in computed:
        error, component, line = _worst_of(body_errors.error.sel(variant=variant), components)
        yield f"{SYMBOLS[variant]} {percent(error)} ({component} on {line})"


def _best(body_errors: xr.Dataset, components: Sequence[str], computed: Sequence[str]) -> Iterator[str]:
    """Yield, for each component, the variants with the smallest error."""
    for component in components:
        worst = body_errors.error.sel(i=component[0], j=component[1]).max("line")
        values = {variant: worst.sel(variant=variant).item() for variant in computed}
        least = min(values.values())
        names = " = ".join(
            SYMBOLS[variant] for variant, value in values.items() if value <= least * (1 + 1e-6)
        )
        yield f"{component}: {names} ({percent(least)})"


def _vanishing_sentence(body_errors: xr.Dataset, components: Sequence[str], computed: Sequence[str]) -> str:
    """Return a sentence on deviations of variants in components that vanish in C."""
    largest_weights = [(*_worst_of(body_errors.weight.sel(variant=v), components), v) for v in computed]
    weight, component, line, variant = max(largest_weights)
    vanish = f"{', '.join(components)} of C vanish{'es' if len(components) == 1 else ''}"
    if weight < ROUNDING:
        return f"{vanish}, and so do the variants."
    where = f"{SYMBOLS[variant]}, {component} on {line}"
    return f"{vanish}; there variants are off by up to {percent(weight)} of C_nn ({where})."


def _accuracy_sentences(results: Results, body_errors: xr.Dataset, present: Sequence[str]) -> Iterator[str]:
    """Yield the accuracy of C on both scales, and the deviation of the solid engine's C from it."""
    if present:
        error, *where = _worst_of(body_errors.error.sel(variant="C"), present)
        yield f"The estimated error of C is at most {error:.2%} of a component ({' on '.join(where)})."
    error, *where = _worst_of(body_errors.estimate_refinement, results.scene.components)
    yield f"On the scale of refinement it is at most {error:.2%} ({' on '.join(where)})."
    if results.checks and present:
        deviation, *where = _worst_of(body_errors.error.sel(variant="C_solid"), present)
        yield (
            f"The solid engine's C deviates from it by {deviation:.2%} of a component at most "
            f"({' on '.join(where)})."
        )


def _worst_of(errors: xr.DataArray, components: Sequence[str]) -> tuple[float, str, str]:
    """Return the largest error of components over all lines [-], with its component and line."""
    return max(
        (errors.sel(i=component[0], j=component[1], line=line).item(), component, str(line))
        for component in components
        for line in errors.line.values
    )
