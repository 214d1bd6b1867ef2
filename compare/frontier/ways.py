"""Every way to the ICs of a scene: the approximations, and both engines at several tolerances."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from approx.variants import VARIANTS
from compare.figures import SYMBOLS
from compare.scenes.scene import Scene
from femic.solid.pardiso import available as direct_available

HARMONIC = (1e-1, 1e-2, 1e-3, 1e-4)  # tolerances
SOLID = (1e-1, 3e-2, 1e-2)

Kind = Literal["approximation", "harmonic", "solid"]


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


def harmonic(tightest: float = HARMONIC[-1]) -> Iterator[Way]:
    """The harmonic engine, loose to tight, up to the first tolerance that is not above `tightest`."""
    for tolerance in HARMONIC:
        yield Way(f"harmonic {tolerance:g}", "harmonic", _engine("harmonic", tolerance))
        if tolerance <= tightest:
            return


def solid() -> Iterator[Way]:
    """The solid engine at several meshes, by every solver that is installed."""
    solvers = ("multigrid", "direct") if direct_available() else ("multigrid",)
    for tolerance in SOLID:
        for solver in solvers:
            engine = _engine("solid", tolerance) | {"solver": solver}
            yield Way(f"solid {tolerance:g}, {solver}", "solid", engine)


def _engine(kind: Kind, tolerance: float) -> dict[str, Any]:
    return {"kind": kind, "tolerance": tolerance, "check": False}
