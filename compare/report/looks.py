"""Looks of the curves of ICs: colours that the colour-blind can tell apart, dashes, markers, and symbols."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import cycle
from pathlib import Path
from types import MappingProxyType

from approx.variants import VARIANTS, exchanged_symbol
from femic.scenes.ic_names import is_map

INK = "ink"  # black on light pages, white on dark ones


@dataclass(frozen=True)
class Look:
    """How a curve is drawn: colour, dash and marker in Plotly's words, width [px]; no line without a dash."""

    colour: str = INK
    dash: str = "solid"
    marker: str = ""
    width: float = 1.6


# Colours of Okabe and Ito. B-hat and mix may coincide with others: those listed first are drawn on top.
OWN: Mapping[str, Look] = MappingProxyType(
    {
        "mix": Look("#56b4e9", "dot", "cross", 2.6),
        "A": Look("#0072b2", "dash", "square"),
        "B": Look("#e69f00", "solid", "circle"),
        "Bbar": Look("#009e73", "dashdot", "triangle-up"),
        "Bhat": Look("#d55e00", "dash", "diamond"),
        "Bhat_prime": Look("#cc79a7", "longdash", "triangle-down"),
        "C_solid": Look(INK, "", "circle-open"),
        "FE": Look(INK, "", "circle-open"),
        "planar": Look("#808080", "dot", "x"),
        "C": Look(INK, "solid", "star", 2.2),
    }
)
FURTHER = (
    Look("#7f6d00", "solid", "hexagon"),
    Look("#8c564b", "dash", "pentagon"),
    Look("#7a5fd0", "dot", "diamond-tall"),
    Look("#808080", "longdashdot", "triangle-left"),
    Look("#17a2a2", "dashdot", "triangle-right"),
    Look("#b03060", "longdash", "octagon"),
)
ENGINE_LOOKS = {"harmonic": Look(INK, "", "square"), "solid": Look("#d55e00", "", "triangle-up")}
OTHER_ENGINE = Look("#009e73", "", "diamond")


def ics_symbol(name: str) -> str:
    """Return the symbol of C, a map of it, FE, planar contact, a half-space, or of one or several forms."""
    if is_map(name):
        path = Path(name)
        return f"C from {path.stem if path.stem != 'sweep' else path.parent.name}"
    fixed = {"C": "C", "C_solid": "C (solid)", "FE": "FE", "planar": "planar", "half-space": "Half-space"} | {
        key: form.symbol for key, form in VARIANTS.items()
    }
    return fixed[name] if name in fixed else exchanged_symbol(name)


def ics_looks(names: Iterable[str]) -> dict[str, Look]:
    """Return the look of each of some ICs: its own, or a further one in turn."""
    further = cycle(FURTHER)
    return {name: OWN[name] if name in OWN else next(further) for name in names}


def label_looks(labels: Iterable[str]) -> dict[str, Look]:
    """Return the look of each of some labels: that of its ICs, or a further one in turn.

    Where more is said of ICs, as in "B, not revolved" or "B with the factor", their line has more gaps.
    """
    by_symbol, further = {ics_symbol(name): look for name, look in OWN.items()}, cycle(FURTHER)
    looks = {}
    for label in labels:
        symbol = re.split("[ ,]", label)[0]
        if label in by_symbol:
            looks[label] = by_symbol[label]
        elif symbol in by_symbol:
            look = by_symbol[symbol]
            looks[label] = replace(look, dash="dot" if look.dash == "solid" else "dashdot")
        else:
            looks[label] = next(further)
    return looks


def drawing_order(names: Iterable[str]) -> list[str]:
    """Return names from the curve at the bottom to the one on top."""
    order = list(OWN)
    return sorted(names, key=lambda name: -order.index(name) if name in OWN else 1)


def without_marker(look: Look) -> Look:
    """Return a look of a line alone."""
    return replace(look, marker="") if look.dash else look
