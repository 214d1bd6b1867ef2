"""The result of a comparison in three sentences."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import xarray as xr

from compare.ics.compute import Results
from compare.ics.curves import main_body
from compare.report.errors import percent
from compare.report.looks import symbol_of
from compare.report.parts import join_words

COUNTS = 0.01  # share of max |C_nn|; smaller errors do not count


def worst_errors(results: Results, errors: xr.Dataset) -> xr.Dataset:
    """Return the errors of the first body, the worst over the lines."""
    return errors.sel(body=main_body(results.scene.compared)).max("line", skipna=False)


def body_name(body: str) -> str:
    """Return a body as texts name it."""
    return "of both bodies together" if body == "combined" else f"of the {body} body"


def computed(results: Results) -> list[str]:
    """Return the approximations that could be computed for the first body."""
    names = results.computed(main_body(results.scene.compared))
    return [name for name in names if name in results.scene.variants]


def summary(results: Results, errors: xr.Dataset) -> str:
    """Return how far the approximations are from C in nn and elsewhere, by weight, and how good C is."""
    worst, components = worst_errors(results, errors), results.scene.components
    variants, others = computed(results), [component for component in components if component != "nn"]
    sentences = []
    if variants and "nn" in components:
        sentences.append(_nn_sentence(worst, variants, body_name(main_body(results.scene.compared))))
    if variants and others:
        other = "other " if sentences else ""
        sentences.append(_others_sentence(worst, variants, others, other))
    return " ".join([*sentences, _accuracy_sentence(results, worst)])


def _nn_sentence(worst: xr.Dataset, variants: Sequence[str], body: str) -> str:
    """Return which variants are closest to C in nn, and how far the others are off."""
    nn = worst.error.sel(i="n", j="n")
    errors = {variant: nn.sel(variant=variant).item() for variant in variants}
    closest = _least(errors, known=nn.sel(variant="C").item())
    others = [f"{symbol_of(v)} {percent(errors[v])}" for v in variants if v not in closest]
    largest = max(errors[variant] for variant in closest)
    if not others:
        return f"In nn {body}, every approximation is within {within(largest)} of C."
    names, verb = join_words(map(symbol_of, closest)), "are" if len(closest) > 1 else "is"
    return f"In nn {body}, {names} {verb} closest to C: {percent(largest)} off at most ({', '.join(others)})."


def _least(values: Mapping[str, float], known: float) -> list[str]:
    """Return the names of the least value, and of those that are no larger as far as is known."""
    least = min(values.values())
    shown = percent(least)
    return [name for name, value in values.items() if value - least <= known or percent(value) == shown]


@dataclass(frozen=True, order=True)
class Weighted:
    """The error of a component: its weight and the error [-]."""

    weight: float
    error: float
    component: str
    vanishes: bool

    @property
    def text(self) -> str:
        """The error as a share of its component and of C_nn."""
        if self.vanishes:
            return f"{percent(self.weight)} of C_nn in {self.component}, which vanishes in C"
        return f"{percent(self.error)} of {self.component} ({percent(self.weight)} of C_nn)"


def _others_sentence(
    worst: xr.Dataset, variants: Sequence[str], components: Sequence[str], other: str
) -> str:
    """Return the errors with the largest weight in other components: of the best variants, and the worst."""
    weighted = {variant: heaviest(worst, variant, components) for variant in variants}
    best, last = min(weighted.values()), max(weighted.values())
    if last.weight < COUNTS:
        return f"No {other}component is off by more than {within(last.weight)} of C_nn."
    weights = {variant: error.weight for variant, error in weighted.items()}
    closest = _least(weights, known=heaviest(worst, "C", components).weight)
    names = join_words(map(symbol_of, closest))
    sentence = f"Among the {other}components, the heaviest error is {best.text} with {names}"
    if len(closest) == len(variants):
        return f"{sentence}."
    furthest = [symbol_of(variant) for variant in variants if weighted[variant] == last]
    return f"{sentence}; with {join_words(furthest)} it is {last.text}."


def heaviest(worst: xr.Dataset, variant: str, components: Sequence[str]) -> Weighted:
    """Return the error of a variant with the largest weight, of errors of a body, the worst over lines."""
    by_component = {c: worst.sel(variant=variant, i=c[0], j=c[1]) for c in components}
    return max(
        Weighted(at.weight.item(), at.error.item(), component, bool(at.vanishes))
        for component, at in by_component.items()
    )


def _accuracy_sentence(results: Results, worst: xr.Dataset) -> str:
    """Return how well C is known, and how far C of the solid engine is from it, as shares of C_nn."""
    names = ["C", *(["C_solid"] if results.checks else [])]
    known, *solid = (within(heaviest(worst, name, results.scene.components).weight) for name in names)
    check = f"; C of the solid engine is within {solid[0]}" if solid else ""
    return f"C is known to {known} of C_nn in every component{check}."


def within(share: float) -> str:
    """Return a limit that a share does not exceed, in percent."""
    return percent(share).removeprefix("< ")


def closest(results: Results, errors: xr.Dataset) -> Iterator[str]:
    """Yield the variants closest to C in each component that does not vanish, with their error."""
    worst, variants = worst_errors(results, errors), computed(results)
    for component in results.scene.components if variants else ():
        at = worst.sel(i=component[0], j=component[1])
        if not at.vanishes:
            values = {variant: at.error.sel(variant=variant).item() for variant in variants}
            names = " = ".join(map(symbol_of, _least(values, known=at.error.sel(variant="C").item())))
            yield f"{component}: {names} ({percent(min(values.values()))})"
