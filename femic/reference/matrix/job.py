"""The job of an IC matrix: a body, a grid, and the accuracy."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from approx.pair import Solid
from femic.reference.discount import ApproachRule, Condition, Rule
from femic.reference.engine import Points, Request
from femic.reference.engines import kinds_that
from femic.reference.job import FLOOR, Settings, load_directions
from femic.reference.meshing import Cells
from femic.reference.run_options import Level, factors
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import WrongInput
from geometries.patches import COMPONENTS, Grid, Load, N

MERGED = 2  # strips that one strip of a later, coarser grid may consist of

Discount = Literal["approach", "source", "none"]  # the rules of `femic.reference.discount`


@dataclass(frozen=True)
class MatrixJob:
    """The IC matrix of one body.

    It is refined on the scale of `femic.reference.matrix.reference.column_scale`. Only loads in the
    directions that `components` need are solved, and the loads that M needs for them. C is the response after
    the first of the `discounts`; the same model also gives C after the others. With "source" the far arc
    approximates a body without end, unless it is given, and is moved away until it does not matter. With
    "approach" and "none" the supports are part of the body, and so of C.
    """

    body: Body
    grid: Grid
    settings: Settings
    components: tuple[str, ...] = COMPONENTS
    discounts: tuple[Discount, ...] = ("approach",)

    def __post_init__(self) -> None:
        """Raise WrongInput for an engine without IC matrices."""
        if not self.settings.engine.has_matrices:
            raise WrongInput(
                f"`engine`: the {self.settings.engine.name} engine has no IC matrices: use one with "
                f"{kinds_that(lambda engine: engine.has_matrices)}"
            )

    @property
    def first_cells(self) -> Cells:
        """The cells of the first model."""
        settings, element = self.settings, self.grid.patch(0)
        return settings.cells or settings.engine.first_cells(settings.tolerance, element, on_strips=True)

    @property
    def solved(self) -> tuple[str, ...]:
        """The components that are solved."""
        return self.settings.solved(self.components)

    @property
    def strip_loads(self) -> tuple[Load, ...]:
        """Unit loads on every strip in the directions of the components that are solved."""
        patches = [self.grid.patch(strip) for strip in range(self.grid.n_s)]
        return tuple(
            Load(patch, direction) for patch in patches for direction in load_directions(self.solved)
        )

    @cached_property
    def rules(self) -> Mapping[Discount, Rule]:
        """The rules by which M is fitted, by discount."""
        return self._rules(1)

    def _rules(self, merged: int) -> dict[Discount, Rule]:
        """The rules of a grid whose elements are this number of times as long and as wide."""
        a, b = merged * self.grid.dx / 2, merged * self.grid.ds / 2
        every: dict[Discount, Rule] = {
            "approach": ApproachRule(self.settings.approach_side),
            "source": self.settings.source_rule(a, b),
            "none": Rule(),
        }
        return {name: every[name] for name in self.discounts}

    @cached_property
    def fits(self) -> Mapping[Discount, list[Condition]]:
        """The conditions that determine M, by discount."""
        return {name: rule.conditions(self.body, self.strip_loads) for name, rule in self.rules.items()}

    @cached_property
    def fit_loads(self) -> tuple[Load, ...]:
        """The loads of these conditions."""
        return _collect_loads(self.fits.values())

    @cached_property
    def merged_fit_loads(self) -> tuple[Load, ...]:
        """The loads that determine M where strips and their lengths are `MERGED` times as large."""
        rules = self._rules(MERGED).values()
        return _collect_loads([rule.conditions(self.body, self.strip_loads) for rule in rules])

    def fit_points(self, discount: Discount) -> Points:
        """The points at which the conditions of a discount read displacements."""
        return self.rules[discount].observers(self.body, self.fits[discount])

    @property
    def given_domain(self) -> bool:
        """Whether the far arc of the body is a part of C, and not an approximation of a body without end."""
        return not self.truncated(self.discounts[0])

    def truncated(self, discount: Discount) -> bool:
        """Whether the far arc truncates a body without end, with a discount of the job."""
        return discount == "source" and discount in self.discounts and self.body.truncated

    def request(self, level: Level) -> Any:
        """Return the engine's request for the model at a level.

        It has loads and observers on all strips, and those that M needs. It also serves later grids of strips
        `MERGED` times as wide, from the left end of the grid (`femic.reference.harmonic.stored`).
        """
        (cells, domain), strips, n_s = factors(level), self.grid.strips, self.grid.n_s
        merged = np.mean(strips[: n_s - n_s % MERGED].reshape(-1, MERGED), axis=1)
        s = np.concatenate([strips, merged])
        fitted = [self.fit_points(name) for name in self.discounts]
        points = Points(
            np.concatenate([np.full_like(s, self.grid.lags[-1]), *(at.x for at in fitted)]),
            np.concatenate([s, *(at.s for at in fitted)]),
        )
        own_loads = dict.fromkeys([*self.strip_loads, *self.fit_loads])
        loads = tuple(dict.fromkeys([*own_loads, *self.merged_fit_loads]))
        model = Request(
            self.body.enlarged(domain),
            loads,
            points,
            self.first_cells.scaled(cells),
            self.settings.solver,
            self.settings.tolerance,
            self._least_scales(loads, np.unique(points.s)),
            level.waves,
            on_strips=True,
            fit_patches=tuple(dict.fromkeys(load.patch for load in self.fit_loads)),
            spare_loads=loads[len(own_loads) :],
            spare_s=tuple(np.setdiff1d(merged, [*strips, *self._fit_s]).tolist()),
            given_domain=self.given_domain,
        )
        return self.settings.engine.request(model)

    @property
    def _fit_s(self) -> Array:
        """Arc lengths [mm] at which conditions read displacements."""
        return np.concatenate([self.fit_points(name).s for name in self.discounts])

    @cached_property
    def half_space_column(self) -> Array:
        """A_nn per unit load [mm/N] at all lags and numbers of strips apart, shape (n_x, n_s)."""
        return self.half_space_nn(self.grid.lags[:, None], self.grid.ds * np.arange(self.grid.n_s))

    def half_space_nn(self, x: ArrayLike, s: ArrayLike) -> Array:
        """A_nn per unit load [mm/N] at distances x, s [mm], of their common shape."""
        patch = self.grid.element
        return Solid(self.body.material, self.body.surface).approximate("A", patch, (x, s))[N, N] / patch.area

    def _least_scales(self, loads: Sequence[Load], s: Array) -> Array:
        """Least scale of refinement [mm/N] per load and arc length, shape (load, 1, len(s)).

        Where the conditions of M read, it is the least A_nn of all.
        """
        load_s = np.array([load.patch.s for load in loads])
        scales = FLOOR * self.half_space_nn(0.0, s - load_s[:, None])
        fit_loads = {*self.fit_loads, *self.merged_fit_loads}
        is_fit_load = np.array([load in fit_loads for load in loads])
        fitted = np.ix_(is_fit_load, np.isin(s, self._fit_s))
        scales[fitted] = np.min(scales) / FLOOR
        return scales[:, None]


def _collect_loads(fits: Iterable[Sequence[Condition]]) -> tuple[Load, ...]:
    """The loads of conditions, each once."""
    return tuple(dict.fromkeys(load for fit in fits for condition in fit for load in condition.loads))
