"""The file that specifies a wheelset on a track (TOML): its keys with units, defaults and meanings."""

import tomllib
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    Field,
    ValidationError,
    model_validator,
)

from approx.variants import VARIANTS, forms_of
from femic.contact.friction.motion import ByAngle
from femic.contact.specification import Creepage
from femic.key_types import Amount, EachDistinct, EachOnce, Length, Place, Several, TwoOf, Whole
from femic.scenes.errors import bad_scene
from femic.scenes.listing import as_toml
from femic.scenes.load import messages
from femic.scenes.scene_table import SceneTable
from geometries.errors import WrongInput
from geometries.profiles.standards import NAMED

Radius = Annotated[float, Field(ge=20, le=2000)]  # mm
BUILTIN = Path(__file__).parent / "builtin"
EXAMPLE = "s1002-on-60e1"
C = "C"


def _known(ics: str) -> str:
    """Return the name of C, or of approximations, perhaps with exchanged components; raise WrongInput."""
    if ics != C:
        forms_of(ics)
    return ics


def _positive(load: Any) -> Any:
    """Return a load [N]; raise ValueError where it is not positive."""
    if isinstance(load, int | float) and load <= 0:
        raise ValueError("must be positive [N]")
    return load


def _sorted(shifts: tuple[float, ...]) -> tuple[float, ...]:
    """Return shifts [mm]; raise ValueError with the first that is below the one before it."""
    for shift, after in pairwise(shifts):
        if after < shift:
            raise ValueError(f"{after:g} comes after {shift:g}: shifts must increase; sort them")
    return shifts


def _both_sides(radius: Any) -> Any:
    """Return a number as that of the left and the right side."""
    return (radius, radius) if isinstance(radius, int | float) else radius


class ProfileTable(SceneTable):
    """The profile of a rail, and its material."""

    profile: str = Field(
        description="name of a built-in profile (femic profiles lists them), or of a file relative to "
        "this one (docs/reference/profiles.md)"
    )
    axes: str | None = Field(
        None,
        description="directions of y and z in the file, such as 'centre', if the file does not show them",
    )
    unit: Literal["mm", "m", "inch"] | None = Field(
        None, description="unit of the file, if the file does not state it"
    )
    surface: Annotated[Whole, Field(ge=1)] | None = Field(
        None, description="number of the running surface, if the file has several: 1, 2, ..."
    )
    section: Annotated[Whole, Field(ge=1)] | None = Field(
        None, description="number of the section, counted from 1, for a list of sections (.slcs, .slcw)"
    )
    section_at: float | None = Field(
        None, description="position of the section instead of its number, in the unit of the list"
    )
    tolerance: Annotated[float, Field(ge=0, le=1)] | Literal["cross-validation"] = Field(
        0.0,
        description="smoothing of a file: rms distance of the curve from the points [mm], which should "
        "equal the rms error of the points; or cross-validation; 0: a curve through all points",
    )
    E: Amount = Field(210_000.0, description="Young's modulus [MPa]")
    nu: float = Field(0.28, ge=0, le=0.4999, description="Poisson's ratio, 0 ... 0.4999")

    @property
    def is_standard(self) -> bool:
        """Whether the profile is one of the package."""
        return self.profile in NAMED


class WheelTable(ProfileTable):
    """The profile of a wheel, and its material."""

    flange_back: Place | None = Field(
        None,
        description="y of the flange back in the axes of the profile [mm]; default: the smallest y, if "
        "the profile ends there in a face of at least 85 degrees",
    )


class TrackTable(SceneTable):
    """The track."""

    gauge: Length = Field(
        1435.0, description="track gauge, the smallest distance between the rails down to gauge_depth [mm]"
    )
    gauge_depth: Length = Field(
        14.0, description="depth below the rail tops to which the gauge is measured [mm]"
    )
    rail_inclination: Annotated[float, Field(gt=-0.5, lt=0.5)] = Field(
        0.025,
        description="inclination of the rails towards the middle of the track, 0.025 is 1:40; 0 if the "
        "profiles are already inclined",
    )


class WheelsetTable(SceneTable):
    """The wheelset."""

    flange_back_distance: Length = Field(1360.0, description="distance between the flange backs [mm]")
    nominal_radius: Annotated[TwoOf[Radius], BeforeValidator(_both_sides)] = Field(
        (460.0, 460.0),
        description="wheel radius on the tape circle [mm]: a number, or [left, right]; creepages refer to "
        "the mean; default: 460",
    )
    tape_circle: Length = Field(70.0, description="distance of the tape circle from the flange back [mm]")


class ContactTable(SceneTable):
    """The contacts, without friction."""

    load: Annotated[Amount, BeforeValidator(_positive)] = Field(
        90_000.0, description="load on each wheel, perpendicular to the track plane [N]"
    )
    ics: Annotated[
        Several[Annotated[str, AfterValidator(_known)]],
        Field(
            min_length=1,
            description=f"ICs used for each contact: C, {', '.join(VARIANTS)}, or with components of "
            "others, such as Bhat+sn:B",
        ),
        EachOnce,
    ] = ("A", "Bhat")
    c_above_deg: Annotated[float, Field(ge=0, le=180)] | None = Field(
        None,
        description="also solve contacts with C if the inclination of the rail changes by more than this "
        "across the patch [deg], such as 20 (minutes per contact); without this key C is not used",
    )
    planar: bool = Field(
        True,
        description="also solve each contact as planar contact, with the elements of each patch in one "
        "plane, as other programs do",
    )
    elements: Annotated[Whole, Field(ge=8, le=64)] = Field(
        20, description="elements across the main patch, along x and s; other patches have half as many"
    )

    @property
    def may_need_c(self) -> bool:
        """Whether C may be used: its models take minutes and all workers."""
        return C in self.ics or self.c_above_deg is not None


class RollingTable(SceneTable):
    """Steady rolling of the wheelset, with friction."""

    friction: Annotated[float, Field(gt=0, le=2)] = Field(0.3, description="friction coefficient")
    by_angle: ByAngle = Field(
        (),
        description="friction that depends on the contact angle, for example on a lubricated flange: "
        "pairs [angle in degrees, factor from 0 to 10] such as [[20, 1], [40, 0.3]], linear between the "
        "angles and constant beyond them; default: factor 1",
    )
    longitudinal: Literal["free"] | Creepage = Field(
        "free",
        description="creepage of the wheelset at the nominal radius R_0, omega R_0 / V - 1; free: the "
        "creepage without torque on the axle",
    )
    lateral: Creepage = Field(
        0.0,
        description="velocity of the wheelset along the axle to the left, divided by V; a yaw angle to "
        "the left [rad] enters here with a minus sign, as slip only",
    )
    spin: Annotated[float, Field(ge=-1e-3, le=1e-3)] = Field(
        0.0, description="yaw rate to the left divided by V [1/mm]: 1/R in a left-hand curve of radius R"
    )


class ShiftsFile(SceneTable):
    """A wheelset on a track at several lateral shifts."""

    title: str = Field("", description="title of the report")
    shifts: Annotated[
        Several[Annotated[float, Field(ge=-50, le=50)]],
        Field(
            min_length=1,
            description="lateral shifts of the wheelset to the left, at rail level [mm]; default: -8 ... 8",
        ),
        EachDistinct,
        AfterValidator(_sorted),
    ] = tuple(float(shift) for shift in range(-8, 9))
    rolls: Annotated[
        Several[Annotated[float, Field(ge=-100, le=100)]],
        Field(
            description="measured roll of the wheelset at each shift [mrad], positive if the left wheel "
            "is higher; the shifts then refer to the middle of the axle, and each wheel settles "
            "separately under its load; default: both wheels touch"
        ),
    ] = ()
    conicity_amplitude: Length = Field(
        3.0, description="amplitude (half of the lateral motion) for the equivalent conicity [mm]"
    )
    rail: ProfileTable = Field(description="both rails, or the left rail if right_rail is given")
    wheel: WheelTable = Field(description="both wheels, or the left wheel if right_wheel is given")
    right_rail: ProfileTable | None = Field(
        None, description="the right rail; default: same as the left rail"
    )
    right_wheel: WheelTable | None = Field(
        None, description="the right wheel; default: same as the left wheel"
    )
    track: TrackTable = Field(TrackTable(), description="the track")
    wheelset: WheelsetTable = Field(WheelsetTable(), description="the wheelset")
    contact: ContactTable = Field(ContactTable(), description="frictionless contacts of the wheels")
    rolling: RollingTable | None = Field(
        None, description="steady rolling with friction; without this table femic computes no creep forces"
    )

    @model_validator(mode="after")
    def _rolled_at_each_shift(self) -> "ShiftsFile":
        if self.rolls and len(self.rolls) != len(self.shifts):
            raise ValueError(
                f"rolls: {len(self.rolls)} given for {len(self.shifts)} shifts; give one for each shift, "
                "or none"
            )
        return self

    def roll_at(self, shift: float) -> float | None:
        """Return the given roll [rad] at a shift; None where it follows."""
        return self.rolls[self.shifts.index(shift)] / 1000 if self.rolls else None

    @property
    def profiles(self) -> dict[str, ProfileTable]:
        """The profiles that the file names, by key."""
        tables = {key: getattr(self, key) for key in ("rail", "wheel", "right_rail", "right_wheel")}
        return {key: table for key, table in tables.items() if table is not None}

    @property
    def rails(self) -> tuple[ProfileTable, ProfileTable]:
        """The left and the right rail."""
        return self.rail, self.right_rail or self.rail

    @property
    def wheels(self) -> tuple[WheelTable, WheelTable]:
        """The left and the right wheel."""
        return self.wheel, self.right_wheel or self.wheel


def builtin_names() -> list[str]:
    """Return the names of the built-in specifications."""
    return sorted(path.stem for path in BUILTIN.glob("*.toml"))


def load_shifts(name_or_path: str) -> tuple[str, str, ShiftsFile]:
    """Return name, text and specification of a built-in name or a TOML file; raise WrongInput.

    Names of profile files are made relative to the working directory.
    """
    is_builtin = name_or_path in builtin_names()
    path = BUILTIN / f"{name_or_path}.toml" if is_builtin else Path(name_or_path)
    if not path.is_file():
        raise WrongInput(
            f"SPECIFICATION {name_or_path!r}: no such file, no built-in one "
            f"({', '.join(builtin_names())}); "
            "`femic shifts --show` prints one with every key"
        )
    try:
        text = path.read_text(encoding="utf-8-sig")
        table = tomllib.loads(text)
    except ValueError as error:
        raise WrongInput(f"{path}: not TOML: {error}; compare with `femic shifts --show`") from error
    return path.stem, text, parse_specification(table, path)


def parse_specification(table: Mapping[str, Any], path: Path) -> ShiftsFile:
    """Return the specification of a table; raise WrongInput with all errors. `path` is that of its file."""
    try:
        file = ShiftsFile.model_validate(table)
    except ValidationError as error:
        raise bad_scene(path, messages(error.errors())) from error
    placed = {key: _placed(key, profile, path.parent) for key, profile in file.profiles.items()}
    return file.model_copy(update=placed)


def _placed(key: str, table: ProfileTable, folder: Path) -> ProfileTable:
    """Return the table with its file's path relative to the working directory; raise WrongInput."""
    kind = "wheel" if isinstance(table, WheelTable) else "rail"
    if table.is_standard:
        if NAMED[table.profile].kind != kind:
            raise WrongInput(f"{key}.profile = {table.profile!r}: is no {kind}; name another profile")
        file_keys = sorted(
            {"axes", "unit", "surface", "section", "section_at", "tolerance"} & table.model_fields_set
        )
        if file_keys:
            raise WrongInput(
                f"{key}.{file_keys[0]}: only for files, but {table.profile} is a built-in profile; leave "
                "this key out"
            )
        return table
    path = folder / table.profile
    if not path.is_file():
        raise WrongInput(
            f"{key}.profile = {table.profile!r}: neither a file relative to the specification nor a "
            f"built-in profile ({', '.join(NAMED)})"
        )
    return table.model_copy(update={"profile": str(path)})


def example(name: str = EXAMPLE) -> str:
    """Return a built-in specification with every key and its meaning."""
    table = tomllib.loads((BUILTIN / f"{name}.toml").read_text(encoding="utf-8"))
    lines = [*_entries(ShiftsFile, table)]
    for key, field in ShiftsFile.model_fields.items():
        model = _find_table(field.annotation)
        if model is None:
            continue
        is_optional = field.default is None and key not in table
        lines += ["", f"# {field.description}", f"{'# ' if is_optional else ''}[{key}]"]
        lines += [] if is_optional else _entries(model, table.get(key, {}))
    return "\n".join(lines) + "\n"


def _entries(model: type[BaseModel], table: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of a table that are no tables: as in the file, or their defaults as comments."""
    for key, field in model.model_fields.items():
        if _find_table(field.annotation) is not None:
            continue
        if key in table:
            yield f"{key} = {as_toml(table[key])}  # {field.description}"
        else:
            value = "..." if field.is_required() or field.default is None else as_toml(field.default)
            yield f"# {key} = {value}  # {field.description}"


def _find_table(annotation: Any) -> type[BaseModel] | None:
    """Return the table of an annotation, also of an optional one; None of others."""
    kinds = [annotation, *getattr(annotation, "__args__", ())]
    return next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, SceneTable)), None)
