"""Every way to the ICs of a scene: the approximations, and both engines at several tolerances."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from approx.variants import VARIANTS
from compare.pages.styles import SYMBOLS
from compare.scenes.scene import Scene
from femic.engines import ENGINES, EngineName
from femic.solid.pardiso import available as direct_available
from femic.solid.record import SOLID

TOLERANCES: Mapping[EngineName, tuple[float, ...]] = {  # loose to tight
    "harmonic": (1e-1, 1e-2, 1e-3, 1e-4),
    "solid": (1e-1, 3e-2, 1e-2),
}
TIGHTEST = TOLERANCES["harmonic"][-1]

Kind = Literal["approximation", EngineName]


@dataclass(frozen=True)
class Way:
    """A variant, or an engine with its settings: keys of the table `engine` of a scene file."""

    name: str
    kind: Kind
    engine: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """As figures and tables call it."""
        return SYMBOLS.get(self.name, f"C, {self.name}")


def approximations(scene: Scene) -> Iterator[Way]:
    """All variants, B-hat-prime where one of the bodies compared has the properties for it."""
    for variant in VARIANTS:
        if variant != "Bhat_prime" or any(scene.pair.has_effective(name) for name in scene.compared):
            yield Way(variant, "approximation")


def harmonic(tightest: float = TIGHTEST) -> Iterator[Way]:
    """The harmonic engine, loose to tight, up to the first tolerance that is not above `tightest`."""
    for tolerance in TOLERANCES["harmonic"]:
        yield _way("harmonic", tolerance)
        if tolerance <= tightest:
            return


def by_engine(name: EngineName) -> Iterator[Way]:
    """An engine at several tolerances, the solid one by every solver that is installed."""
    for tolerance in TOLERANCES[name]:
        if ENGINES[name] is not SOLID:
            yield _way(name, tolerance)
            continue
        for solver in ("multigrid", "direct") if direct_available() else ("multigrid",):
            yield _way(name, tolerance, solver=solver)


def _way(name: EngineName, tolerance: float, **more: str) -> Way:
    engine = {"kind": name, "tolerance": tolerance, "check": False, **more}
    return Way(", ".join([f"{name} {tolerance:g}", *more.values()]), name, engine)
