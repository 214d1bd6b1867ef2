"""The ways to the ICs of a scene: the approximations, and every engine at several tolerances."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from approx.variants import VARIANTS, needs_effective
from femic.reference.engines import ENGINES
from femic.scenes.scene import Scene

APPROXIMATION = "approximation"  # the kind of ways that are no engines


@dataclass(frozen=True)
class Way:
    """A variant, or an engine with settings: keys of the table `engine` of a scene file."""

    name: str
    kind: str  # `APPROXIMATION`, or the name of an engine
    engine: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The label of this way in figures and tables."""
        return VARIANTS[self.name].symbol if self.name in VARIANTS else f"C, {self.name}"


def approximations(scene: Scene) -> Iterator[Way]:
    """Yield all variants; B-hat-prime only if one of the bodies compared has effective properties."""
    for variant in VARIANTS:
        if scene.fitted or not needs_effective(variant):
            yield Way(variant, APPROXIMATION)


def engine_ways(name: str, tightest: float = 0.0) -> Iterator[Way]:
    """Yield an engine at its tolerances, loose to tight, with all of its options at each.

    The last tolerance is the first that is not above `tightest`.
    """
    comparison = ENGINES[name].comparison
    looser = [tolerance for tolerance in comparison.tolerances if tolerance > tightest]
    for tolerance, options in product(comparison.tolerances[: len(looser) + 1], comparison.options()):
        engine = {"kind": name, "tolerance": tolerance, "check": False, **options}
        yield Way(", ".join([f"{name} {tolerance:g}", *options.values()]), name, engine)


def styles() -> dict[str, tuple[str, str]]:
    """Return the colour and the marker of each kind of ways."""
    engines = {name: (engine.comparison.colour, engine.comparison.marker) for name, engine in ENGINES.items()}
    return {APPROXIMATION: ("tab:blue", "o")} | engines
