"""The ways to the numbers of a contact: ICs, elements across the patch, and the tolerance of C."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from approx.variants import VARIANTS, needs_effective
from compare.contact.compute import map_names
from femic.contact.pairs.given_ics import C
from femic.contact.specification import ContactSpecification
from femic.reference.engines import ENGINES
from femic.scenes.ic_names import is_map
from femic.scenes.scene import Scene

APPROXIMATION, MAP_OF_C = "approximation", "map"  # kinds of ways without C, beside the names of engines
FEWEST, MOST = 8, 64  # elements across the smallest patch, as a specification may have them
TIGHTEST = 0.001  # tolerance of C: estimates of contacts come from their elements long before


@dataclass(frozen=True)
class Way:
    """ICs by name, the elements across the smallest patch, and the engine and the tolerance of C.

    `elements` is None where the scene gives the grid, or a map of C does.
    """

    ics: str
    elements: int | None
    kind: str  # `APPROXIMATION`, `MAP_OF_C`, or the name of an engine
    tolerance: float | None = None

    @property
    def name(self) -> str:
        """The name of this way in files: Bhat, 20 elements; C 0.01, 40 elements."""
        ics = self.ics if self.tolerance is None else f"{self.ics} {self.tolerance:g}"
        return ics if self.elements is None else f"{ics}, {self.elements} elements"

    @property
    def changes(self) -> dict[str, Any]:
        """The keys of a scene file that this way changes."""
        contact: dict[str, Any] = {"ics": [self.ics]}
        if self.elements is not None:
            contact["elements"] = self.elements
        engine = {} if self.tolerance is None else {"engine": {"tolerance": self.tolerance, "check": False}}
        return {"contact": contact} | engine


def fineness(specification: ContactSpecification) -> Sequence[int | None]:
    """Return the elements across the smallest patch that are tried: half, as many, and twice as many."""
    if not specification.automatic:
        return [None]
    as_given = specification.elements
    return sorted({max(as_given // 2, FEWEST), as_given, min(2 * as_given, MOST)})


def approximations(scene: Scene) -> list[str]:
    """Return the approximations that are tried: all variants, and exchanged ones that the scene names.

    B-hat-prime needs effective properties of both bodies.
    """
    named = [name for name in scene.contact.ics if name != C and not is_map(name)]
    fitted = scene.pair.has_effective("combined")
    return [name for name in dict.fromkeys([*VARIANTS, *named]) if fitted or not needs_effective(name)]


def ways_of(scene: Scene, tightest: float = TIGHTEST) -> Iterator[Way]:
    """Yield all ways to the contact of a scene; of C down to the first tolerance not above `tightest`.

    On coarser grids C has the loosest tolerance, since errors of these grids are larger; on finer ones it has
    the first two, for the same reason.
    """
    numbers_of_elements = fineness(scene.contact)
    for elements in numbers_of_elements:
        for name in approximations(scene):
            yield Way(name, elements, APPROXIMATION)
        for tolerance in _tolerances(scene, elements, tightest):
            yield Way(C, elements, scene.settings.engine.name, tolerance)
    for name in map_names(scene.contact.ics):
        yield Way(name, None, MAP_OF_C)


def _tolerances(scene: Scene, elements: int | None, tightest: float) -> Sequence[float]:
    ladder = ENGINES[scene.settings.engine.name].comparison.tolerances
    looser = [tolerance for tolerance in ladder if tolerance > tightest]
    tolerances = ladder[: len(looser) + 1]
    if elements is None or elements == scene.contact.elements:
        return tolerances
    return tolerances[:1] if elements < scene.contact.elements else tolerances[:2]
