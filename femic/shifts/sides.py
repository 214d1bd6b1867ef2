"""Profiles of a specification in their places on track and wheelset, and one wheel on its rail.

Profiles are curves (`Section`), laid out on the track (`lay_out_wheelset`). In a position of the wheelset
a wheel and its rail touch (`Place`); both sections are then seen from the touching point, in axes parallel to
the axle, y to the field side, z up: the rail is turned by its inclination and against the roll; the wheel, a
body of revolution, is not turned.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from approx.pair import Pair, Solid
from femic.contact.specification import APPROACH_SHARE, ContactProblem, ContactSpecification
from femic.reference.harmonic.request import FAR_RADIUS
from femic.reference.job import Settings
from femic.scenes.engine import EngineTable
from femic.scenes.profiles import Reading, prepared_file
from femic.shifts.specification import ContactTable, ProfileTable, ShiftsFile
from geometries.arrays import Array
from geometries.bodies import Body, common_extent
from geometries.materials import Material
from geometries.patches import Grid, Patch
from geometries.profiles.noise import noise, profile_figure
from geometries.profiles.placement import STEEPEST, Curve, contour_at
from geometries.profiles.profile import Kind
from geometries.profiles.sections import SectionChoice
from geometries.profiles.standards import named
from geometries.surfaces import LOWER, UPPER
from geometries.track.layout import Layout, SideName, TrackDimensions, WheelsetDimensions, lay_out
from geometries.track.wheelset import Position, Touch

# --- profiles in their places ---

SIDES: tuple[SideName, SideName] = ("left", "right")
NAMES = ("left rail", "right rail", "left wheel", "right wheel")


@dataclass(frozen=True, eq=False)
class Section:
    """A profile as a curve, sentences about how it was understood, and one on what looks like noise."""

    name: str
    curve: Curve
    notes: tuple[str, ...]
    doubt: str = ""


Sections = tuple[Section, Section, Section, Section]


def prepare_sections(specification: ShiftsFile) -> Sections:
    """Return left rail, right rail, left wheel, right wheel of a specification; raises WrongInput.

    They are profiles of the package, or prepared of files.
    """

    def prepare(table: ProfileTable, kind: Kind) -> Section:
        if table.is_standard:
            entry = named(table.profile)
            return Section(table.profile, entry.outline, (entry.origin,))
        choice = SectionChoice(table.section, table.section_at)
        how = Reading(kind, table.axes, table.unit, table.surface, table.tolerance, choice)
        prepared = prepared_file(Path(table.profile), how)
        return Section(prepared.name, prepared, prepared.notes, noise(profile_figure(prepared)))

    rails, wheels = specification.rails, specification.wheels
    left_rail = prepare(rails[0], "rail")
    right_rail = left_rail if rails[1] == rails[0] else prepare(rails[1], "rail")
    left_wheel = prepare(wheels[0], "wheel")
    right_wheel = left_wheel if wheels[1] == wheels[0] else prepare(wheels[1], "wheel")
    return left_rail, right_rail, left_wheel, right_wheel


def lay_out_wheelset(specification: ShiftsFile, sections: Sections | None = None) -> Layout:
    """Return rails and wheels in their places; raises WrongInput."""
    left_rail, right_rail, left_wheel, right_wheel = sections or prepare_sections(specification)
    track, wheelset = specification.track, specification.wheelset
    backs = specification.wheels[0].flange_back, specification.wheels[1].flange_back
    return lay_out(
        (left_rail.curve, right_rail.curve),
        (left_wheel.curve, right_wheel.curve),
        TrackDimensions(track.gauge, track.gauge_depth, track.rail_inclination),
        WheelsetDimensions(
            wheelset.flange_back_distance, wheelset.nominal_radius, backs, wheelset.tape_circle
        ),
    )


def understood(sections: Sections, layout: Layout) -> tuple[str, ...]:
    """Return sentences about the profiles and where they are."""
    own = [
        f"{name}, {section.name}: {note}"
        for name, section in zip(NAMES, sections, strict=True)
        for note in section.notes
    ]
    return (*own, *(f"{note[0].upper()}{note[1:]}." for note in layout.notes))


def doubts(sections: Sections) -> tuple[str, ...]:
    """Return sentences about what looks like noise in the profiles, one for each profile."""
    own = {
        section.name: f"{name}, {section.name}: {section.doubt}"
        for name, section in zip(NAMES[::-1], sections[::-1], strict=True)
        if section.doubt
    }
    return tuple(own.values())[::-1]


# --- one wheel on its rail ---

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


def bodies_at(
    place: Place, rail: ProfileTable, wheel: ProfileTable, steepest: float = STEEPEST
) -> dict[str, Body]:
    """Return rail and wheel seen from the touching point, with flanks where they are `steepest` [rad].

    Raises WrongInput where they are steeper at the touching point.
    """
    side, touch = place.layout.side(place.side), place.touch
    turn = side.rail.angle - place.roll
    lower = contour_at(side.rail.curve, touch.s_rail, turn=turn, steepest=steepest)
    upper = contour_at(side.wheel.curve, touch.s_wheel, steepest=steepest)
    domain = EngineTable().domain
    return {
        "lower": Body(LOWER, lower, Material(rail.E, rail.nu), domain),
        "upper": Body(UPPER, upper, Material(wheel.E, wheel.nu), domain, touch.radius),
    }


def contact_problem(
    bodies: dict[str, Body], contact: ContactTable, grid: Grid | None = None
) -> ContactProblem:
    """Return the contact of two bodies under a load perpendicular to the axle, on a grid if given.

    Settings of C are those of scenes with these bodies; the reference length [mm] is the rail's radius.
    """
    length, table = reference_length(float(bodies["lower"].contour.curvature(0.0))), EngineTable()
    extent, domain = common_extent(bodies), bodies["lower"].domain
    turn = 2 * np.pi * bodies["upper"].rolling_radius
    room = float(min(domain.far_radius / 8, turn / 6, -extent[0], extent[1]))
    reach = min(2 * length, room)
    settings = Settings(
        engine=table.engine,
        tolerance=table.tolerance,
        cells=table.cells(Patch(reach / 100, reach / 100)),
        most_unknowns=table.most_unknowns,
        rotation_reach=reach,
        moment_arm=min(length / 2, room / 2),
        approach_side=length / APPROACH_SHARE,
        solver=table.solver,
    )
    upper, lower = (Solid(bodies[name].material, bodies[name].surface) for name in ("upper", "lower"))
    specification = ContactSpecification(
        loads=(contact.load,),
        ics=tuple(dict.fromkeys(contact.ics)),
        elements=contact.elements,
        grid="scene" if grid else "automatic",
        supports=False,
    )
    grid = grid or Grid(8, 8, 1.0, 1.0)
    pair = Pair(upper, lower)
    return ContactProblem(
        "shift", bodies, pair, specification, grid, settings, "approach", FAR_RADIUS, length
    )


def reference_length(curvature: float) -> float:
    """Return the reference length [mm] of a rail by its curvature: its radius, within limits."""
    return float(np.clip(1 / max(abs(curvature), 1 / LARGEST_LENGTH), LEAST_LENGTH, LARGEST_LENGTH))
