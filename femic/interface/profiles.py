"""Profiles of rails and wheels: read or standard, placed as contours, written; a wheelset on its track."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

import tomlkit
import xarray as xr

from femic.interface.arguments import check_fields, new_file, shown, with_checked_arguments
from femic.interface.bodies import checked, given, plain
from femic.interface.options import DEFAULT, Options, in_turn
from femic.results import wheelset
from femic.results.profiles import MakePoints, file_profile, package_profile
from femic.scenes.load import merged
from femic.scenes.profiles import ProfileTable, Reading, prepared_file
from femic.shifts.specification import parse_specification
from geometries.errors import WrongInput
from geometries.profiles import files
from geometries.profiles.profile import Kind
from geometries.profiles.sections import SectionChoice
from geometries.profiles.standards import NAMED


@dataclass(frozen=True)
class Profile:
    """A rail or a wheel: the smoothed profile of a `file`, or a built-in one, `standard`, such as "60E1".

    Give what the file does not show: its `kind`, "rail" or "wheel"; `axes`, the directions of y and z, such
    as "centre down"; its `unit`; and the number of the `surface`, if the file has several. For a list of
    sections (.slcs, .slcw), give the number `section`, counted from 1, or the position `section_at`.
    `tolerance` is the rms distance of the points from the curve [mm], or "cross-validation" to find it; with
    0 the curve passes through all points. Raises WrongInput.
    """

    file: str | Path | None = None
    standard: str | None = None
    kind: Kind | None = None
    axes: str | None = None
    unit: str | None = None
    surface: int | None = None
    section: int | None = None
    section_at: float | None = None
    tolerance: float | Literal["cross-validation"] = 0.0
    _read: tuple[xr.Dataset, MakePoints] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_fields(self)
        if (self.file is None) == (self.standard is None):
            raise WrongInput(
                f"file = {shown(self.file)}, standard = {shown(self.standard)}: give either, one of them"
            )
        if self.standard is None:
            path, section = Path(self.file or ""), SectionChoice(self.section, self.section_at)
            reading = Reading(self.kind, self.axes, self.unit, self.surface, self.tolerance, section)
            read = file_profile(prepared_file(path, reading), path)
        else:
            if self.standard not in NAMED:
                raise WrongInput(f"standard = {self.standard!r}: give one of {', '.join(NAMED)}, or a file")
            for key in fields(self):
                given_too = key.init and key.name != "standard" and getattr(self, key.name) != key.default
                if given_too:
                    raise WrongInput(
                        f"{key.name} = {shown(getattr(self, key.name))}: is of files, and standard = "
                        f"{self.standard!r} is of the package: leave it out"
                    )
            read = package_profile(self.standard)
        object.__setattr__(self, "_read", read)

    @property
    def keys(self) -> dict[str, Any]:
        """How the file is read, for scenes and wheelsets, with an absolute path; {} of a standard."""
        if self.file is None:
            return {}
        names = "axes", "unit", "surface", "section", "section_at", "tolerance"
        path = str(Path(self.file).absolute())
        return given({"file": path} | {name: getattr(self, name) for name in names})

    @property
    def data(self) -> xr.Dataset:
        """The curve over its arc length s [mm] from the gauge side, its points, and how the file was read.

        y points to the field side, z up. `residual` [mm] is the distance of the points from the curve.
        `inclination` [rad] is positive where the curve falls with increasing y. The attribute `notes`
        describes what was done.
        """
        return self._read[0].copy()

    @with_checked_arguments
    def at(
        self,
        y_centre: float | None = None,
        *,
        s_centre: float | None = None,
        rail_inclination: float = 0.0,
        turn_deg: float = 0.0,
        steepest_deg: float = 85.0,
    ) -> ProfileTable:
        """Return the contour with its contact centre at `y_centre` [mm], or at an arc length `s_centre` [mm].

        The section turns about the contact centre: by a `rail_inclination`, such as 0.025 for 1:40, and by
        `turn_deg` [degrees] from y to z. A wheel with a rolling radius cannot be turned. Where the contour is
        steeper than `steepest_deg` [degrees], it continues along its tangent. Raises WrongInput.
        """
        place = {"y_centre": y_centre, "s_centre": s_centre, "rail_inclination": rail_inclination}
        turn = {"turn_deg": turn_deg, "steepest_deg": steepest_deg}
        own = {"kind": "profile", "standard": self.standard, "profile_kind": self.kind} | self.keys
        contour = checked(ProfileTable, given(own | place | turn))
        contour.contour()  # raises for places that are not on the profile
        return contour


@with_checked_arguments
def write_profile(profile: Profile, path: str | Path) -> None:
    """Write a profile, smoothed if it has a tolerance, as a spline block in mm: .prr (rail), .prw (wheel).

    Reading the file gives the same points [mm]. Raises WrongInput.
    """
    _, make_points = profile._read
    files.write_profile(make_points(), new_file(path))


@with_checked_arguments
@in_turn
def compute_shifts(
    rail: Profile,
    wheel: Profile,
    shifts: Sequence[float],
    *,
    tables: Mapping[str, Any] | None = None,
    options: Options = DEFAULT,
) -> xr.Dataset:
    """Place a wheelset on its track at lateral `shifts` [mm] and solve the contacts of both wheels.

    `tables` takes further keys of a specification (docs/how-to/shifts.md): "track", "wheelset" and "contact",
    which has the load and the ICs, and keys of "rail" and "wheel" such as E and flange_back. Only workers,
    store and report of `options` have an effect.

    The variables of the result have units and meanings: contact points and rolling radii by shift and side;
    forces, pressures [MPa] and patches also by ICs. Impossible shifts are NaN, and the attribute `refused`
    gives the reasons. Raises WrongInput; raises Failure if no shift is possible.
    """
    keys: dict[str, Any] = {"shifts": shifts}
    for kind, profile in (("rail", rail), ("wheel", wheel)):
        if (seen := profile.data.attrs["kind"]) != kind:
            raise WrongInput(f"{kind} = {profile.standard or str(profile.file)!r}: the profile of a {seen}")
        own = profile.keys
        keys[kind] = {"profile": profile.standard or own.pop("file")} | own
    table = plain(merged(keys, tables or {}))
    return wheelset.compute_shifts(
        parse_specification(table, Path("shifts")), tomlkit.dumps(table), options.run
    )
