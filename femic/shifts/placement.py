"""The profiles of a specification as curves, in their places on track and wheelset."""

from dataclasses import dataclass
from pathlib import Path

from femic.scenes.profiles import Reading, prepared_file
from femic.shifts.specification import ProfileTable, ShiftsFile
from geometries.profiles.named import named
from geometries.profiles.noise import noise
from geometries.profiles.placement import Curve
from geometries.profiles.preparation import figure_of
from geometries.profiles.profile import Kind
from geometries.profiles.sections import SectionChoice
from geometries.track.layout import Layout, TrackDimensions, WheelsetDimensions, lay_out

NAMES = ("left rail", "right rail", "left wheel", "right wheel")


@dataclass(frozen=True, eq=False)
class Section:
    """A profile as a curve, sentences about how it was understood, and one on what looks like noise."""

    name: str
    curve: Curve
    notes: tuple[str, ...]
    doubt: str = ""


Sections = tuple[Section, Section, Section, Section]


def section_of(table: ProfileTable, kind: Kind) -> Section:
    """Return the curve of a table: of a profile of the package, or prepared of a file. Raises WrongInput."""
    if table.is_standard:
        entry = named(table.profile)
        return Section(table.profile, entry.outline, (entry.origin,))
    choice = SectionChoice(table.section, table.section_at)
    how = Reading(kind, table.axes, table.unit, table.surface, table.tolerance, choice)
    prepared = prepared_file(Path(table.profile), how)
    return Section(prepared.name, prepared, prepared.notes, noise(figure_of(prepared)))


def sections_of(specification: ShiftsFile) -> Sections:
    """Return left rail, right rail, left wheel, right wheel of a specification; raises WrongInput."""
    left_rail, right_rail = specification.rails
    left_wheel, right_wheel = specification.wheels
    rail, wheel = section_of(left_rail, "rail"), section_of(left_wheel, "wheel")
    return (
        rail,
        rail if right_rail == left_rail else section_of(right_rail, "rail"),
        wheel,
        wheel if right_wheel == left_wheel else section_of(right_wheel, "wheel"),
    )


def layout_of(specification: ShiftsFile, sections: Sections | None = None) -> Layout:
    """Return rails and wheels in their places; raises WrongInput."""
    left_rail, right_rail, left_wheel, right_wheel = sections or sections_of(specification)
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
