"""One wheel and its rail in a position of the wheelset: where they touch, their bodies, forces in the track.

Both sections are seen from the touching point, in axes parallel to the axle, y to the field side, z up: the
rail is turned by its inclination and against the roll; the wheel, a body of revolution, is not turned.
"""

from dataclasses import dataclass

import numpy as np

from approx.pair import Pair, Solid
from femic.contact.specification import APPROACH_SHARE, ContactProblem, ContactSpecification
from femic.reference.harmonic.tuned import FAR_RADIUS
from femic.reference.job import Settings
from femic.scenes.engine import EngineTable
from femic.shifts.specification import ProfileTable
from geometries.arrays import Array
from geometries.bodies import Body, common_extent
from geometries.grids import Grid
from geometries.materials import Material
from geometries.patches import Patch
from geometries.profiles.placement import STEEPEST, contour_at
from geometries.surfaces import LOWER, UPPER
from geometries.track.layout import Layout
from geometries.track.wheelset import Position, SideName, Touch, side_of

LEAST_LENGTH, LARGEST_LENGTH = 10.0, 300.0  # mm: the reference length is the rail's radius within these


@dataclass(frozen=True, eq=False)
class Place:
    """Where a contact is: a side of a layout in a position, its main touching point, the roll of the side."""

    layout: Layout
    position: Position
    side: SideName

    @property
    def touch(self) -> Touch:
        """The main touching point."""
        return self.position.left[0] if self.side == "left" else self.position.right[0]

    @property
    def roll(self) -> float:
        """Roll [rad] in the axes of the side."""
        return self.position.pose(self.side)[1]

    def in_track(self, force: Array) -> tuple[float, float]:
        """Return the lateral, to the field side, and the vertical part [N] of a force, in axes of the track.

        `force` is along x, y, z of axes parallel to the axle, shape (3,).
        """
        _, across, up = force
        cos, sin = np.cos(self.roll), np.sin(self.roll)
        return float(across * cos - up * sin), float(across * sin + up * cos)


@dataclass(frozen=True)
class ContactRequest:
    """What a contact is solved for: load [N], ICs, elements across the main patch, and from where on C.

    `planar`: whether also as planar contact.
    """

    load: float
    ics: tuple[str, ...]
    elements: int = 20
    c_above_deg: float | None = None
    planar: bool = False


def bodies_at(
    place: Place, rail: ProfileTable, wheel: ProfileTable, steepest: float = STEEPEST
) -> dict[str, Body]:
    """Return rail and wheel seen from the touching point, with flanks where they are `steepest` [rad].

    Raises WrongInput where they are steeper at the touching point.
    """
    side, touch = side_of(place.layout, place.side), place.touch
    turn = side.rail.angle - place.roll
    lower = contour_at(side.rail.curve, touch.s_rail, turn=turn, steepest=steepest)
    upper = contour_at(side.wheel.curve, touch.s_wheel, steepest=steepest)
    domain = EngineTable().domain
    return {
        "lower": Body(LOWER, lower, Material(rail.E, rail.nu), domain),
        "upper": Body(UPPER, upper, Material(wheel.E, wheel.nu), domain, touch.radius),
    }


def problem_of(
    bodies: dict[str, Body], request: ContactRequest, load: float, grid: Grid | None = None
) -> ContactProblem:
    """Return the contact of two bodies under a load perpendicular to the axle [N], on a grid if given."""
    curvature = abs(float(bodies["lower"].contour.curvature(0.0)))
    length = float(np.clip(1 / max(curvature, 1 / LARGEST_LENGTH), LEAST_LENGTH, LARGEST_LENGTH))
    solids = {name: Solid(body.material, body.surface) for name, body in bodies.items()}
    specification = ContactSpecification(
        loads=(load,),
        ics=tuple(dict.fromkeys(request.ics)),
        elements=request.elements,
        grid="scene" if grid else "automatic",
        supports=False,
    )
    return ContactProblem(
        "shift",
        bodies,
        Pair(solids["upper"], solids["lower"]),
        specification,
        grid or Grid(8, 8, 1.0, 1.0),
        _settings(bodies, length),
        "approach",
        FAR_RADIUS,
        length,
    )


def _settings(bodies: dict[str, Body], length: float) -> Settings:
    """Return settings of C as of scenes with these bodies and reference length [mm]."""
    extent, domain = common_extent(bodies), bodies["lower"].domain
    turn = 2 * np.pi * bodies["upper"].rolling_radius
    room = float(min(domain.far_radius / 8, turn / 6, -extent[0], extent[1]))
    reach, table = min(2 * length, room), EngineTable()
    return Settings(
        engine=table.engine,
        tolerance=table.tolerance,
        cells=table.cells(Patch(reach / 100, reach / 100)),
        most_unknowns=table.most_unknowns,
        rotation_reach=reach,
        moment_arm=min(length / 2, room / 2),
        approach_side=length / APPROACH_SHARE,
        solver=table.solver,
    )
