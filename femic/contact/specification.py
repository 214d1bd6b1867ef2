"""The specification of a contact: bodies, loads, ICs and motion, and how C is computed.

A gap [mm] may be added to the undeformed distance: a profile over s, or known at points of the surface. It is
linear between the points, and 0 beyond them.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
import scipy
from pydantic import Field

from approx.pair import Pair
from approx.variants import VARIANTS
from femic.contact.friction.motion import FactorsByAngle
from femic.contact.loading import Loading
from femic.key_types import Amount, EachDistinct, EachOnce, Length, Place, Several, Signed, Whole
from femic.reference.job import Settings
from femic.reference.matrix.job import Discount
from geometries.arrays import Array
from geometries.bodies import Body, common_extent
from geometries.errors import WrongInput
from geometries.patches import Grid

# --- extra gap ---

ON_A_LINE = 1e-9  # width of points over their length below which they lie on one line


@dataclass(frozen=True, eq=False)
class Profile:
    """A gap over s, the same at all x."""

    s: Array  # growing
    gap: Array

    def at(self, x: Array, s: Array) -> Array:
        """Return the gap at places (x, s) [mm], shape broadcast(x, s)."""
        return np.interp(
            np.broadcast_to(s, np.broadcast_shapes(x.shape, s.shape)), self.s, self.gap, 0.0, 0.0
        )


@dataclass(frozen=True, eq=False)
class Scattered:
    """A gap at points (x, s), which are not all on one line."""

    places: Array  # (n, 2)
    gap: Array

    def at(self, x: Array, s: Array) -> Array:
        """Return the gap at places (x, s) [mm], shape broadcast(x, s)."""
        middle = self.places.mean(axis=0)
        size = np.ptp(self.places, axis=0).max()  # triangles need lengths of about 1
        between = scipy.interpolate.LinearNDInterpolator(
            (self.places - middle) / size, self.gap, fill_value=0.0
        )
        return np.asarray(between((x - middle[0]) / size, (s - middle[1]) / size))


ExtraGap = Profile | Scattered


def extra_gap(columns: Array) -> ExtraGap:
    """Return the gap of columns s, gap or x, s, gap, shape (n, 2) or (n, 3) [mm].

    Points of one x are a profile: s and the gap alone matter. Raises WrongInput for points at the same place,
    for others on one line, and for too few.
    """
    places, gap = columns[:, :-1], columns[:, -1]
    widths = np.ptp(places, axis=0)
    if places.shape[1] == 1 or widths[0] <= ON_A_LINE * widths[1]:
        if len(places) < 2:
            raise WrongInput("one point: give two or more")
        _require_apart(places[:, -1:])
        order = np.argsort(places[:, -1])
        return Profile(places[order, -1], gap[order])
    _require_apart(places)
    across = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    if len(places) < 3 or across[1] <= ON_A_LINE * across[0]:
        raise WrongInput(
            f"{len(places)} points lie on one line that is not at a single x; add points beside the line, "
            "or give columns s, gap if the gap is the same at all x"
        )
    order = np.lexsort(places.T)  # triangles of points on a grid depend on their order
    return Scattered(places[order], gap[order])


def _require_apart(places: Array) -> None:
    """Raise WrongInput for two points at the same place."""
    order = np.lexsort(places.T)
    same = np.flatnonzero(np.all(np.diff(places[order], axis=0) == 0, axis=1))
    if len(same):
        first, second = sorted(int(k) + 1 for k in order[same[0] : same[0] + 2])
        where = ", ".join(f"{place:g}" for place in places[first - 1])
        raise WrongInput(f"points {first} and {second} are at the same place ({where}): remove one")


# --- what is solved ---

WITHOUT_FRICTION = "none"  # the name of the motion
APPROACH_SHARE = 50.0  # reference length over the half-side of the load at which the approach is matched
CREEPAGES = (0.0005, 0.001, 0.0015, 0.002, 0.003, 0.004, 0.006, 0.008, 0.012)  # and 0, and these below 0
Creepage = Annotated[float, Field(gt=-1, lt=1)]


@dataclass(frozen=True)
class FrictionSpecification:
    """The specification of a motion with friction."""

    coefficients: Annotated[
        Several[Annotated[float, Field(gt=0, le=1000)]],
        Field(min_length=1, description="friction coefficients, 0 ... 1000; the contact is solved with each"),
        EachOnce,
    ] = (0.2, 0.4, 0.6)
    longitudinal: Annotated[
        Several[Creepage],
        Field(
            min_length=2,
            description="steady rolling: longitudinal creepages omega R / V - 1 of the creep-force curve, "
            "in increasing order",
        ),
    ] = (*(-xi for xi in reversed(CREEPAGES)), 0.0, *CREEPAGES)
    creepage: Annotated[
        Creepage,
        Field(
            description="transient rolling: longitudinal creepage omega R / V - 1, constant from the start"
        ),
    ] = 0.002
    lateral: Annotated[
        Creepage, Field(description="steady or transient rolling: lateral velocity of the wheel divided by V")
    ] = 0.0
    spin: Annotated[
        float,
        Field(
            ge=-1,
            le=1,
            description="steady or transient rolling: angular velocity of the wheel about z divided by V "
            "[1/mm]",
        ),
    ] = 0.0
    distance: Annotated[
        Length | None,
        Field(
            description="transient rolling: rolled distance [mm], rounded up to a multiple of four "
            "elements; default: three patch lengths"
        ),
    ] = None
    equal_force: Annotated[
        float,
        Field(
            gt=-1,
            lt=1,
            description="steady rolling: F_x / (friction load) at which the tractions with all ICs are "
            "compared, -1 ... 1",
        ),
    ] = 0.5
    friction_by_angle: FactorsByAngle = ()


@dataclass(frozen=True)
class ContactSpecification:
    """Which contact is solved, with which ICs.

    Each key is declared here alone, with its unit, limits and default; the table [contact] of a scene file
    is made from these declarations.
    """

    motion: str = WITHOUT_FRICTION  # of `femic.contact.motions`
    loads: Annotated[
        Several[Amount],
        Field(description="vertical loads [N]; in increasing order for compression"),
        EachDistinct,
    ] = ()
    approaches: Annotated[
        Several[Length], Field(description="vertical approaches [mm], instead of loads"), EachDistinct
    ] = ()
    ics: Annotated[
        Several[str],
        Field(
            min_length=1,
            description=f"ICs to solve the contact with: C, {', '.join(VARIANTS)}, or one of these with "
            "components of another: Bhat+sn:B is Bhat with sn of B, and ns by reciprocity. map:FILE takes "
            "C from the file of a campaign with keep = matrix, on the grid of that campaign; with "
            "friction, its scenes have the same motion",
        ),
        EachOnce,
    ] = ("A", "B", "Bhat", "C")
    friction: FrictionSpecification | None = None  # None: without friction
    shift: Annotated[Place, Field(description="lateral shift of the upper body along y [mm]")] = 0.0
    flanks: Annotated[
        bool,
        Field(
            description="whether the bodies may touch on the straight flanks beyond the contours; use "
            "false if the flanks only represent the rest of a body"
        ),
    ] = True
    gap: Annotated[
        Literal["linear", "exact"],
        Field(
            description="undeformed distance. linear: distance at first touch minus approach times "
            "cos(delta); exact: distance of the displaced body"
        ),
    ] = "linear"
    extra_gap: Annotated[
        ExtraGap | None,
        Field(
            description="text file with an additional gap: columns x, s, gap, or s, gap for all x [mm]; "
            "linear between the points, 0 beyond them; # comments"
        ),
    ] = None
    elements: Annotated[
        Whole,
        Field(
            ge=8, le=64, description="elements across the smallest patch on an automatic grid, along x and s"
        ),
    ] = 20
    grid: Annotated[
        Literal["automatic", "scene"],
        Field(description="automatic: fits the patches; scene: the grid of [grid], centred at x = 0"),
    ] = "automatic"
    lateral_force: Annotated[
        Signed | None,
        Field(
            description="lateral force F_y on the upper body [N], without friction only; femic finds the "
            "lateral position, starting from `shift`"
        ),
    ] = None
    supports: Annotated[
        bool,
        Field(
            description="whether the page shows the effect of the supports on contact with C: far arc of "
            "half the radius and, for unsymmetric contacts, flanks 5 degrees flatter (C is computed "
            "again)"
        ),
    ] = True
    shape_load: Annotated[
        Amount | None,
        Field(
            description="load [N] whose B-hat pressures are applied to all patches, to show where A and "
            "B-hat differ; default: the largest"
        ),
    ] = None

    def __post_init__(self) -> None:
        """Raise WrongInput unless friction is specified for a motion that has it."""
        if (self.motion != WITHOUT_FRICTION) != (self.friction is not None):
            raise WrongInput(
                f"motion = {self.motion!r}: give `friction` for motions with friction, and only for those"
            )

    @property
    def exact(self) -> bool:
        """Whether the undeformed distance follows the displaced body; otherwise it is linearised."""
        return self.gap == "exact"

    @property
    def automatic(self) -> bool:
        """Whether grids are sized automatically; otherwise the grid of the problem is taken."""
        return self.grid == "automatic"

    @property
    def loadings(self) -> tuple[Loading, ...]:
        """The loads, then the approaches."""
        side = self.lateral_force
        loads = [Loading(load, None, side) for load in self.loads]
        return (*loads, *(Loading(None, approach, side) for approach in self.approaches))


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

    @property
    def extent(self) -> tuple[float, float]:
        """Arc lengths [mm] as far as both contours go."""
        return common_extent(self.bodies)
