"""The specification of a contact: bodies, loads, ICs and motion, and how C is computed."""

from collections.abc import Mapping
from dataclasses import dataclass

from approx.pair import Pair
from femic.contact.extra_gap import ExtraGap
from femic.contact.loading import Loading
from femic.reference.job import Settings
from femic.reference.matrix.job import Discount
from geometries.bodies import Body, common_extent
from geometries.grids import Grid


@dataclass(frozen=True)
class FrictionSpecification:
    """Which motion with friction is solved."""

    motion: str  # "rolling" or "compression"
    coefficients: tuple[float, ...]
    longitudinal: tuple[float, ...]  # creepages, growing
    lateral: float
    spin: float  # 1/mm
    equal_force: float  # F_x over friction times load at which tractions are compared


@dataclass(frozen=True)
class ContactSpecification:
    """Which contact is solved, with which ICs."""

    loads: tuple[float, ...]  # N
    approaches: tuple[float, ...]  # mm, where no loads are given
    ics: tuple[str, ...]  # "C", names of variants, or of ICs that are given
    shift: float  # of the upper body along y [mm]
    flanks: bool  # whether the bodies may touch on the straight flanks
    exact: bool  # whether the undeformed distance follows the displaced body; otherwise it is linearised
    extra_gap: ExtraGap | None  # added to the undeformed distance
    elements: int  # across the smallest patch on an automatic grid
    automatic: bool  # whether grids are sized automatically; otherwise the grid of the problem is taken
    shape_load: float | None  # load whose pressures are mapped onto all patches [N]
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
        """The motion: none, rolling or compression."""
        return self.friction.motion if self.friction else "none"


@dataclass(frozen=True)
class ContactProblem:
    """Two bodies whose contact is solved, as `specification` says, and how C of them is computed."""

    name: str  # that messages begin with
    bodies: Mapping[str, Body]  # "lower", "upper"
    pair: Pair  # the same as the approximations take them
    specification: ContactSpecification
    grid: Grid  # where the specification has no automatic grids
    settings: Settings  # of C
    discount: Discount
    support_radius: float  # of the far arc of the bodies [mm]
    reference_length: float  # mm

    @property
    def extent(self) -> tuple[float, float]:
        """Arc lengths [mm] as far as both contours go."""
        return common_extent(self.bodies)
