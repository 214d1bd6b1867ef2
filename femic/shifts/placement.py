"""The profiles of a specification as curves, in their places on track and wheelset."""

from dataclasses import dataclass
from pathlib import Path

from femic.scenes.profiles import Reading, prepared_file
from femic.shifts.specification import ProfileTable, ShiftsFile
from geometries.profiles.named import named
from geometries.profiles.placement import Curve
from geometries.profiles.profile import Kind
from geometries.profiles.sections import SectionChoice
from geometries.track.layout import Layout, TrackDimensions, WheelsetDimensions, lay_out


@dataclass(frozen=True, eq=False)
class Section:
    """A profile as a curve, and sentences about how it was understood."""

    name: str
    curve: Curve
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Placed:
    """A wheelset above its track: rails and wheels, (left, right) each, and both sides in place."""

    rails: tuple[Section, Section]
    wheels: tuple[Section, Section]
    layout: Layout

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about the profiles."""
        names = ("left rail", "right rail", "left wheel", "right wheel")
        sections = (*self.rails, *self.wheels)
        own = [
            f"{name}, {section.name}: {note}"
            for name, section in zip(names, sections, strict=True)
            for note in section.notes
        ]
        return (*own, *(f"{note[0].upper()}{note[1:]}." for note in self.layout.notes))


def section_of(table: ProfileTable, kind: Kind) -> Section:
    """Return the curve of a table: of a profile of the package, or prepared of a file. Raises WrongInput."""
    if table.is_standard:
        entry = named(table.profile)
        return Section(table.profile, entry.outline, (entry.origin,))
    choice = SectionChoice(table.section, table.section_at)
    how = Reading(kind, table.axes, table.unit, table.surface, table.smoothing, choice)
    prepared = prepared_file(Path(table.profile), how)
    return Section(prepared.name, prepared, prepared.notes)


def place(specification: ShiftsFile) -> Placed:
    """Return rails and wheels in their places; raises WrongInput."""
    left_rail, right_rail = specification.rails
    left_wheel, right_wheel = specification.wheels
    rail, wheel = section_of(left_rail, "rail"), section_of(left_wheel, "wheel")
    rails = rail, rail if right_rail == left_rail else section_of(right_rail, "rail")
    wheels = wheel, wheel if right_wheel == left_wheel else section_of(right_wheel, "wheel")
    return Placed(rails, wheels, _layout(specification, rails, wheels))


def _layout(
    specification: ShiftsFile, rails: tuple[Section, Section], wheels: tuple[Section, Section]
) -> Layout:
    track, wheelset = specification.track, specification.wheelset
    left_wheel, right_wheel = specification.wheels
    backs = left_wheel.flange_back, right_wheel.flange_back
    return lay_out(
        (rails[0].curve, rails[1].curve),
        (wheels[0].curve, wheels[1].curve),
        TrackDimensions(track.gauge, track.gauge_depth, track.rail_inclination),
        WheelsetDimensions(
            wheelset.flange_back_distance, wheelset.nominal_radius, backs, wheelset.tape_circle
        ),
    )
