"""The table [engine] of a scene file: settings of the reference C."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from femic.key_types import Length, NameOf, Whole
from femic.reference.engine import Engine, SolverChoice
from femic.reference.engines import ENGINES, SOLID, kinds_that
from femic.reference.meshing import Cells
from femic.reference.solid.pardiso import available as direct_available
from femic.scenes.scene import Scene
from femic.scenes.scene_table import LIMIT_SLACK, SceneTable
from geometries.bodies import Domain
from geometries.patches import Patch

LARGEST_FAR_RADIUS = 5e6  # in half-sides of the loaded element
INSTALL_DIRECT = "run .venv/bin/pip install -c constraints.txt -e '.[direct]'"
CHECK_ENGINE, CHECK_TOLERANCE = SOLID, 0.01  # the engine that checks others; its tightest tolerance for that


class EngineTable(SceneTable):
    """How the reference C is computed."""

    kind: Annotated[str, AfterValidator(NameOf(lambda: ENGINES))] = Field(
        "harmonic",
        description="harmonic: one section problem per wavenumber along x, takes seconds (half_length, "
        "line_growth and solver have no effect); solid: 3D finite elements, takes minutes",
    )
    check: bool = Field(
        False,
        description="also compute and draw C of the solid engine, at tolerance 0.01 or at the tolerance "
        "of the scene if that is larger (takes minutes, once)",
    )
    tolerance: Annotated[float, Field(ge=1e-4, le=1)] = Field(
        0.01,
        description="largest estimated error of C, for each body and combined, on the scale of refinement "
        "(docs/theory/errors.md); it determines the cell sizes",
    )
    most_unknowns: Annotated[Whole, Field(ge=1000)] = Field(
        1_000_000, description="largest number of unknowns of a model"
    )
    smallest_cell: Length | None = Field(
        None,
        description="first cell size at the patch [mm]; default: b/8 (solid: min(a, b)/12 at tolerance 0.01)",
    )
    growth: Annotated[float, Field(ge=0.02, le=0.5)] | None = Field(
        None,
        description="first cell size divided by the distance from the edges of the patch; default: 0.5, "
        "less below tolerance 0.003 (solid: by the distance from the lines; 0.14 at tolerance 0.01)",
    )
    line_growth: Annotated[float, Field(ge=0.02, le=0.5)] | None = Field(
        None,
        description="first cell size on a line divided by the distance from the patch; default: "
        "0.05 at tolerance 0.01",
    )
    far_radius: Length | None = Field(
        None,
        description="radius of the clamped far arc [mm]. If given, it is a fixed support of the body. "
        "Default: 1280 (solid: 320), for a body without end, enlarged below tolerance 0.001 or as C needs",
    )
    half_length: Length = Field(
        320.0,
        description="extent along +x and -x to the clamped ends [mm]. If given, it is fixed; by default "
        "it is enlarged as C needs",
    )
    solver: SolverChoice = Field("auto", description="linear solver; direct needs the extra femic[direct]")

    @property
    def engine(self) -> Engine:
        """The engine of this kind."""
        return ENGINES[self.kind]

    @property
    def domain(self) -> Domain:
        """The domain of the first model; of all models where it is given."""
        far_radius = self.far_radius or self.engine.far_radius(self.tolerance)
        half_length = np.inf if self.engine.infinite_length else self.half_length
        length_given = "half_length" in self.model_fields_set
        return Domain(far_radius, half_length, self.far_radius is not None, length_given)

    def cells(self, patch: Patch) -> Cells:
        """Return the first cells: as given, else as the tolerance needs."""
        default = self.engine.first_cells(self.tolerance, patch)
        return Cells(
            self.smallest_cell or default.smallest,
            self.growth or default.growth,
            self.line_growth or default.line_growth,
        )

    @property
    def needs_check(self) -> bool:
        """Whether another engine checks this one."""
        return self.check and self.engine is not CHECK_ENGINE

    @property
    def check_engine(self) -> "EngineTable":
        """The settings of the engine that checks this one, with its own cells, in the domain of this one."""
        keys = {"far_radius", "half_length", "most_unknowns", "solver"}
        same = self.model_dump(include=keys, exclude_unset=True)
        tolerance = max(self.tolerance, CHECK_TOLERANCE)
        return EngineTable(kind=CHECK_ENGINE.name, tolerance=tolerance, **same)


def engine_misfits(scene: Scene) -> Iterator[str]:
    """Yield settings that the engine of a scene does not have."""
    if scene.fields and not scene.settings.engine.has_fields:
        yield f"fields = true: only {kinds_that(lambda engine: engine.has_fields)} has fields in 3D"
    if scene.settings.solver == "direct" and not direct_available():
        yield f"engine.solver = 'direct': not installed; {INSTALL_DIRECT}, or use 'auto'"


def matrix_engine_misfits(scene: Scene) -> Iterator[str]:
    """Yield why the engine has no C of these bodies on a grid, and so none for contact."""
    yield from body_limit_misfits(scene)
    engine = scene.settings.engine
    if not engine.has_matrices:
        yield (
            f"engine.kind = {engine.name!r}: this engine cannot compute C on a grid, which matrices and "
            f"contact need; use {kinds_that(lambda other: other.has_matrices)} (grid.check compares "
            "columns of a matrix with the solid engine)"
        )


def body_limit_misfits(scene: Scene) -> Iterator[str]:
    """Yield bodies beyond the limits of the engine: they have no C, and no stresses of its models."""
    limits = scene.settings.engine.limits
    for name, body in scene.bodies.items():
        contour = body.contour
        steepest = np.degrees(np.max(np.abs(contour.inclination(np.linspace(*contour.limits, 1001)))))
        if steepest > limits.inclination * (1 + LIMIT_SLACK):
            yield (
                f"{name}.contour: inclined up to {steepest:.1f} degrees; at most {limits.inclination:g}: cut "
                "it there"
            )
        nu, radius = body.material.nu, body.rolling_radius
        if nu > limits.nu:
            remedy = _use(other for other in ENGINES.values() if other.limits.nu >= nu)
            yield f"{name}.nu = {nu:g}: {remedy} above {limits.nu:g}, or give a smaller one"
        if radius < limits.rolling_radius:
            remedy = _use(other for other in ENGINES.values() if other.limits.rolling_radius <= radius)
            yield (
                f"{name}.rolling_radius = {radius:g}: {remedy} below {limits.rolling_radius:g}, or give a "
                "larger one"
            )
        if body.outline is not None and not scene.settings.engine.follows_outlines:
            remedy = _use(other for other in ENGINES.values() if other.follows_outlines)
            yield f"{name}.outline: {remedy}, or leave it out"


def aspect_misfits(scene: Scene) -> Iterator[str]:
    """Yield a patch that is more elongated than the engine allows."""
    limits, aspect = scene.settings.engine.limits, scene.patch.a / scene.patch.b
    elongation = max(aspect, 1 / aspect) * (1 - LIMIT_SLACK)
    if elongation > limits.aspect:
        remedy = _use(other for other in ENGINES.values() if other.limits.aspect >= elongation)
        yield (
            f"patch.a / patch.b = {aspect:g}: {remedy} outside {1 / limits.aspect:g} ... {limits.aspect:g}, "
            "or bring a and b closer"
        )


def _use(capable: Iterable[Engine]) -> str:
    """Return the remedy: use one of the engines that are capable of it."""
    names = [repr(engine.name) for engine in capable]
    if not names:
        return "use A, B or Bhat without stresses (no engine computes C or stresses)"
    return f"use engine.kind = {' or '.join(names)} (without check)"


def ratio_misfits(
    half_sides: Mapping[str, float], reaches: Mapping[str, float], scene: Scene
) -> Iterator[str]:
    """Yield distances that are too large beside the loaded element.

    With them, cells and wavenumbers would span too many decades. `half_sides`: those of the element by
    name; `reaches`: how far from the load displacements are read, by a label each. All in mm.
    """
    name, side = min(half_sides.items(), key=lambda named_side: named_side[1])
    element = f"{name} = {side:g}, the least half-side of the loaded element"
    engine = scene.settings.engine
    limit = engine.limits.distance * side
    for label, reach in reaches.items():
        if reach > limit * (1 + LIMIT_SLACK):
            yield (
                f"{label}: reaches {reach:g} mm, {reach / side:.3g} times {element}; at most "
                f"{limit / side:g} times by engine.kind = {engine.name!r}: shorten it to {limit:g} mm, or "
                "enlarge the element"
            )
    far_radius = max(body.domain.far_radius for body in scene.bodies.values())
    if far_radius > LARGEST_FAR_RADIUS * side * (1 + LIMIT_SLACK):
        yield (
            f"engine.far_radius = {far_radius:g}: {far_radius / side:.3g} times {element}; at most "
            f"{LARGEST_FAR_RADIUS:g} times: give a smaller one, or enlarge the element"
        )
