"""The ways to the ICs of a scene: the approximations, and both engines at several tolerances."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any, Literal

from approx.variants import VARIANTS
from femic.reference.engines import ENGINES, EngineName
from femic.reference.solid.pardiso import available as direct_available
from femic.reference.solid.record import SOLID
from femic.scenes.scene import Scene

TOLERANCES: Mapping[EngineName, tuple[float, ...]] = {  # loose to tight
    "harmonic": (1e-1, 1e-2, 1e-3, 1e-4),
    "solid": (1e-1, 3e-2, 1e-2),
}
TIGHTEST_HARMONIC = TOLERANCES["harmonic"][-1]

Kind = Literal["approximation", EngineName]


@dataclass(frozen=True)
class Way:
    """A variant, or an engine with its settings: keys of the table `engine` of a scene file."""

    name: str
    kind: Kind
    engine: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The label of this way in figures and tables."""
        return VARIANTS[self.name].symbol if self.name in VARIANTS else f"C, {self.name}"


def approximations(scene: Scene) -> Iterator[Way]:
    """Yield all variants; B-hat-prime only if one of the bodies compared has effective properties."""
    for variant in VARIANTS:
        if variant != "Bhat_prime" or scene.fitted:
            yield Way(variant, "approximation")


def harmonic(tightest: float = TIGHTEST_HARMONIC) -> Iterator[Way]:
    """Yield the harmonic engine, loose to tight, up to the first tolerance that is not above `tightest`."""
    for way in by_engine("harmonic"):
        yield way
        if way.engine["tolerance"] <= tightest:
            return


def by_engine(name: EngineName) -> Iterator[Way]:
    """Yield an engine at several tolerances, the solid engine with every solver that is installed."""
    solvers = ("multigrid", "direct") if direct_available() else ("multigrid",)
    choices = [{"solver": solver} for solver in solvers] if ENGINES[name] is SOLID else [{}]
    for tolerance, more in product(TOLERANCES[name], choices):
        engine = {"kind": name, "tolerance": tolerance, "check": False, **more}
        yield Way(", ".join([f"{name} {tolerance:g}", *more.values()]), name, engine)
