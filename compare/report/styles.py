"""Symbols, styles and markers of the curves of variants; variants without own ones take further ones."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any, TypeVar

from matplotlib.figure import Figure

from approx.variants import VARIANTS
from femic.cache.files import replacing

Style = Mapping[str, Any]  # keywords of a line of matplotlib
Value = TypeVar("Value")

RC: Any = {"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.2, "figure.dpi": 110}

CHECK_STYLE: Style = {"color": "black", "marker": "o", "markersize": 4, "mfc": "white", "linestyle": "none"}

DASHES: tuple[Any, ...] = ("-", (0, (4, 1.5)), (0, (1.3, 1.2)), (0, (5, 1.2, 1, 1.2)), (0, (9, 2)))
COLOURS = ("tab:blue", "tab:red", "tab:green", "tab:purple", "tab:orange")
FURTHER: tuple[Style, ...] = (  # styles of curves that have none of their own
    {"color": "tab:cyan", "linewidth": 1.4},
    {"color": "tab:pink", "linewidth": 1.4, "linestyle": (0, (4, 1))},
    {"color": "tab:olive", "linewidth": 1.4, "linestyle": (0, (1, 1))},
    {"color": "tab:gray", "linewidth": 1.4, "linestyle": (0, (5, 1, 1, 1))},
    {"color": "black", "linewidth": 1.4},
    {"color": "tab:red", "linewidth": 1.4, "linestyle": (0, (3, 1))},
)
OWN: Mapping[str, tuple[str, Style]] = {  # marker and style; the first on top: mix coincides with others
    "mix": ("P", {"color": "tab:purple", "linestyle": (0, (1, 3)), "linewidth": 2.2}),
    "A": ("s", {"color": "tab:blue", "linestyle": (0, (5, 2))}),
    "B": ("o", {"color": "tab:orange", "linestyle": "-"}),
    "Bbar": ("^", {"color": "tab:green", "linestyle": (0, (3, 1, 1, 1))}),
    "Bhat": ("D", {"color": "tab:red", "linestyle": (0, (2, 1))}),
    "Bhat_prime": ("v", {"color": "tab:brown", "linestyle": (0, (6, 1))}),
    "C_solid": ("X", CHECK_STYLE),
    "C": ("*", {"color": "black", "linewidth": 1.8, "zorder": 1}),
}
FURTHER_MARKERS = "hpd<>8H"


def with_further(names: Iterable[str]) -> dict[str, tuple[str, Style]]:
    """Return marker and style of each name: its own, or further ones in turn, which come first."""
    further_looks = zip(cycle(FURTHER_MARKERS), cycle(FURTHER), strict=False)
    looks = {name: next(further_looks) for name in names if name not in OWN}
    return looks | dict(OWN)


@dataclass(frozen=True, eq=False)
class ByVariant(Mapping[str, Value]):
    """A mapping by names of variants and of C that reads the registry whenever it is used."""

    made: Callable[[], Mapping[str, Value]]

    def __getitem__(self, name: str) -> Value:
        return self.made()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.made())

    def __len__(self) -> int:
        return len(self.made())


SYMBOLS = ByVariant(
    lambda: {name: one.symbol for name, one in VARIANTS.items()} | {"C": "C", "C_solid": "C (solid)"}
)
STYLES = ByVariant(lambda: {name: style for name, (_, style) in with_further(VARIANTS).items()})
MARKERS = ByVariant(lambda: {name: marker for name, (marker, _) in with_further(VARIANTS).items()})


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG and return its path."""
    with replacing(path) as unfinished:
        figure.savefig(unfinished)
    return path
