"""The job of C at points: a body, a loaded patch, components, points, and the accuracy.

A tolerance is a share of the scale of refinement. The error of a component on a line is max |error of C|,
divided by the larger of max |C_ij| and 0.05 max |C_nn| on that line, body by body. Without the floor,
components that vanish or nearly vanish would be refined without end. Errors of approximations are not
measured on this scale but as shares of C itself, however small C is, see `femic.ic_errors.error_measure`.
Theory: docs/theory/errors.md.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from approx.pair import Solid
from femic.reference.discount import Condition, SourceRule
from femic.reference.engine import Engine, Points, Request, SolverChoice
from femic.reference.meshing import Cells
from femic.reference.run_options import Level, factors
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import Failure
from geometries.patches import Load, N, Patch, indices

# --- the scale of refinement ---

FLOOR = 0.05  # least scale as a share of max |C_nn| on the line


class NotConverged(Failure):
    """A result does not reach its accuracy; the message has the numbers and the remedies."""


def line_scale(c_line: Array, nn_line: Array) -> Array:
    """Return the scale of refinement [mm/N] on a line, (3, 3), from the ICs (3, 3, n) and C_nn (n,) there."""
    return np.maximum(np.max(np.abs(c_line), axis=-1), FLOOR * np.max(np.abs(nn_line)))


def component_of(values: NDArray[Any], component: str) -> float:
    """Return the entry of (3, 3) values for a component: "xn" is displacement x due to traction n."""
    return float(values[indices(component)])


@dataclass(frozen=True)
class Shares:
    """Largest estimated errors on the scale of refinement: each part, and their sum."""

    mesh: float
    truncation: float
    waves: float
    total: float
    component: str  # the component whose sum is worst
    line: str  # its line


# --- the job ---


@dataclass(frozen=True)
class Settings:
    """How C is computed: the engine, the accuracy, and where M is fitted (`SourceRule`) [mm].

    `cells` belong to the first model; the default depends on the tolerance. No model may have more than
    `most_unknowns`. `solver` is the linear solver of the solid engine.
    """

    engine: Engine
    tolerance: float = 0.01
    cells: Cells | None = None
    most_unknowns: int = 1_000_000
    rotation_reach: float = 20.0
    moment_arm: float = 5.0
    approach_side: float = 0.2
    solver: SolverChoice = "auto"

    def source_rule(self, a: float, b: float) -> SourceRule:
        """Return the rule of [BVSV] for M, with loads on patches of half-sides a, b [mm]."""
        return SourceRule(a, b, self.rotation_reach, self.moment_arm)

    def solved(self, components: Iterable[str]) -> tuple[str, ...]:
        """Return the components that are solved: the given ones and, with some engines, their transposes.

        In these engines loads share a factorisation, and the error of C_ji also estimates the error of C_ij
        (`femic.reference.result.pooled`). So the estimate does not depend on which other components are
        requested.
        """
        given = tuple(components)
        transposed = [component[::-1] for component in given] if self.engine.solves_transposes else []
        return tuple(dict.fromkeys([*given, *transposed]))

    def first_cells(self, patch: Patch) -> Cells:
        """Return the cells of the first model."""
        return self.cells or self.engine.first_cells(self.tolerance, patch)


@dataclass(frozen=True)
class Job:
    """The reference ICs of one body.

    `lines` assigns the points to lines: tolerance and estimates refer to the scale of refinement of a line.
    """

    body: Body
    patch: Patch
    components: tuple[str, ...]
    points: Points
    lines: Mapping[str, slice]
    settings: Settings

    @property
    def first_cells(self) -> Cells:
        """The cells to start with."""
        return self.settings.first_cells(self.patch)

    @property
    def loads(self) -> tuple[Load, ...]:
        """The loads of the components that are solved."""
        solved = self.settings.solved(self.components)
        return tuple(Load(self.patch, direction) for direction in load_directions(solved))

    @property
    def rule(self) -> SourceRule:
        """The rule to fit M: C of single loads is compared with ICs of half-spaces."""
        return self.settings.source_rule(self.patch.a, self.patch.b)

    @property
    def half_space_nn(self) -> Array:
        """A_nn at the points per unit total load [mm/N], shape (n,)."""
        solid, points = Solid(self.body.material, self.body.surface), (self.points.x, self.points.s)
        return solid.approximate("A", self.patch, points)[N, N] / self.patch.area

    @cached_property
    def fit(self) -> list[Condition]:
        """The conditions that determine M."""
        return self.rule.conditions(self.body, self.loads)

    @property
    def solved_loads(self) -> tuple[Load, ...]:
        """The loads of the job, then the further loads that M needs."""
        fit_loads = (load for condition in self.fit for load in condition.loads)
        return tuple(dict.fromkeys([*self.loads, *fit_loads]))

    def request(self, level: Level) -> Any:
        """Return the engine's request for the model at a level.

        Its points are first those of the job, then those where M is fitted.
        """
        fit_points = self.rule.observers(self.body, self.fit)
        (cells, domain), settings, a_nn = factors(level), self.settings, self.half_space_nn
        model = Request(
            self.body.enlarged(domain),
            self.solved_loads,
            Points(np.append(self.points.x, fit_points.x), np.append(self.points.s, fit_points.s)),
            self.first_cells.scaled(cells),
            settings.solver,
            settings.tolerance,
            FLOOR * min(float(np.max(a_nn[line])) for line in self.lines.values()),
            level.waves,
        )
        return settings.engine.request(model)


def load_directions(components: Iterable[str]) -> tuple[int, ...]:
    """Return the load directions of components ("xn": displacement x due to traction n)."""
    return tuple(sorted({indices(component)[1] for component in components}))
