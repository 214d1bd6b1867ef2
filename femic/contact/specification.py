"""The specification of a contact: bodies, loads, ICs and motion, and how C is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from approx.pair import Pair, Solid
from femic.contact.extra_gap import ExtraGap
from femic.contact.loading import Loading
from femic.reference.harmonic.record import HARMONIC
from femic.reference.harmonic.tuned import FAR_RADIUS
from femic.reference.job import Settings
from femic.reference.matrix.job import Discount
from geometries.bodies import Body, common_extent
from geometries.grids import Grid

APPROACH_SHARE = 50.0  # reference length over the half-side of the load at which the approach is matched
DEFAULT_GRID = Grid(64, 32, 0.2, 0.2)
DEFAULT_SETTINGS = Settings(HARMONIC)


@dataclass(frozen=True)
class FrictionSpecification:
    """Which motion with friction is solved, of `femic.contact.motions`."""

    motion: str
    coefficients: tuple[float, ...]
    longitudinal: tuple[float, ...] = (-1e-3, 0.0, 1e-3)  # creepages of rolling, growing
    lateral: float = 0.0
    spin: float = 0.0  # 1/mm
    equal_force: float = 0.5  # F_x over friction times load at which tractions are compared


@dataclass(frozen=True)
class ContactSpecification:
    """Which contact is solved, with which ICs."""

    loads: tuple[float, ...] = ()  # N; with friction they grow
    approaches: tuple[float, ...] = ()  # mm, where no loads are given
    ics: tuple[str, ...] = ("Bhat",)  # "C", names of variants, or of ICs that are given
    shift: float = 0.0  # of the upper body along y [mm]
    flanks: bool = True  # whether the bodies may touch on the straight flanks
    exact: bool = False  # whether the undeformed distance follows the displaced body; else it is linearised
    extra_gap: ExtraGap | None = None  # added to the undeformed distance
    elements: int = 20  # across the smallest patch on an automatic grid
    automatic: bool = True  # whether grids are sized automatically; else the grid of the problem is taken
    shape_load: float | None = None  # load whose pressures are mapped onto all patches [N]
    lateral_force: float | None = None  # on the upper body [N]; None: its position is given
    supports: bool = True  # whether the effect of supports is computed
    friction: FrictionSpecification | None = None  # None: without friction

    @property
    def loadings(self) -> tuple[Loading, ...]:
        """The loads, then the approaches."""
        side = self.lateral_force
        loads = [Loading(load, None, side) for load in self.loads]
        return (*loads, *(Loading(None, approach, side) for approach in self.approaches))

    @property
    def motion(self) -> str:
        """The motion, of `femic.contact.motions`."""
        return self.friction.motion if self.friction else "none"


@dataclass(frozen=True)
class ContactProblem:
    """Two bodies whose contact is solved, as `specification` says, and how C of them is computed."""

    name: str  # at the beginning of messages
    bodies: Mapping[str, Body]  # "lower", "upper"
    pair: Pair  # the same as the approximations take them
    specification: ContactSpecification
    grid: Grid  # where the specification has no automatic grids
    settings: Settings  # of C
    discount: Discount
    support_radius: float  # of the far arc of the bodies [mm]
    reference_length: float  # mm

    @classmethod
    def of(
        cls,
        lower: Body,
        upper: Body,
        specification: ContactSpecification,
        *,
        grid: Grid = DEFAULT_GRID,
        settings: Settings = DEFAULT_SETTINGS,
    ) -> ContactProblem:
        """The contact of two bodies, of which C has the rigid part of the approach subtracted.

        Approximations have the elastic properties of the bodies. Where the specification has no automatic
        grids, `grid` is needed.
        """
        pair = Pair(Solid(upper.material, upper.surface), Solid(lower.material, lower.surface))
        bodies = {"lower": lower, "upper": upper}
        length = settings.approach_side * APPROACH_SHARE
        return cls("contact", bodies, pair, specification, grid, settings, "approach", FAR_RADIUS, length)

    @property
    def extent(self) -> tuple[float, float]:
        """Arc lengths [mm] as far as both contours go."""
        return common_extent(self.bodies)
