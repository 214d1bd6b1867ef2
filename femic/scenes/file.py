"""The keys of a scene file (TOML) with their units, defaults and limits."""

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    FilePath,
    Strict,
    field_validator,
    model_validator,
)

from approx.variants import VARIANTS
from femic.contact.loading import DISTINCT_DIGITS
from femic.contact.operators.approximations import require_operator
from femic.reference.engines import EngineName
from femic.reference.models import SolverChoice


def _whole(value: Any) -> Any:
    """A whole number as an integer, where it is one: multiples in campaigns are not."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


Entry = TypeVar("Entry")
Several = Annotated[tuple[Entry, ...], Strict(False)]  # lists in TOML
TwoOf = Annotated[tuple[Entry, Entry], Strict(False)]
Whole = Annotated[int, BeforeValidator(_whole)]
ExistingFile = Annotated[FilePath, Strict(False)]
LEAST_LENGTH, LARGEST_LENGTH = 1e-12, 1e12  # mm
LARGEST = 1e15  # of moduli [MPa] and forces [N]


def _radius(value: float) -> float:
    """A radius of an arc; raises ValueError for one that is no length."""
    if not LEAST_LENGTH <= abs(value) <= LARGEST_LENGTH:
        raise ValueError(f"its amount should be {LEAST_LENGTH:g} ... {LARGEST_LENGTH:g}")
    return value


def _finite_or_prismatic(value: float) -> float:
    """A rolling radius; raises ValueError for one that is neither a length nor infinite."""
    if not (value <= LARGEST_LENGTH or value == float("inf")):
        raise ValueError(f"should be at most {LARGEST_LENGTH:g}, or inf for a prismatic body")
    return value


Length = Annotated[float, Field(ge=LEAST_LENGTH, le=LARGEST_LENGTH)]  # mm
Place = Annotated[float, Field(ge=-LARGEST_LENGTH, le=LARGEST_LENGTH)]  # mm
Amount = Annotated[float, Field(ge=1 / LARGEST, le=LARGEST)]  # of a modulus or a force
Signed = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]  # likewise
Flank = Annotated[float, Field(ge=0, le=85)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Exponent = Annotated[float, Field(gt=0, le=1000)]
Creepage = Annotated[float, Field(gt=-1, lt=1)]
ArcRadius = Annotated[float, AfterValidator(_radius)]
BodyName = Literal["combined", "lower", "upper"]
Component = Literal["xx", "xs", "xn", "sx", "ss", "sn", "nx", "ns", "nn"]
PropertyName = Literal["mismatch_k", "G", "nu"]
if TYPE_CHECKING:
    VariantName = str
    ICName = str
else:  # the names of the registry: a new variant is registered there alone
    VariantName = Literal[*VARIANTS]
    ICName = Literal["auto", "C", *VARIANTS]


MAP = "map:"  # before the name of the file of a campaign, whose map of C stands for C


def is_map(ics: str) -> bool:
    """Whether ICs are those of a map of C."""
    return ics.startswith(MAP)


def _known(ics: str) -> str:
    """The name of C, of a map, or of approximations, perhaps with exchanged components; raises WrongInput."""
    if ics != "C" and not is_map(ics):
        require_operator(ics)
    return ics


ContactICName = Annotated[str, AfterValidator(_known)]


class Section(BaseModel):
    """A table of a scene file: unknown keys are errors, and texts and true are no numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Plane(Section):
    """A flat surface."""

    kind: Literal["plane"] = Field(description="a plane")


class Arc(Section):
    """A circular arc continued by its tangents."""

    kind: Literal["arc"] = Field(description="circular arc + straight flanks")
    radius: ArcRadius = Field(description="radius of the arc [mm]; negative: a groove")
    flank_inclination_deg: Flank | TwoOf[Flank] = Field(
        description="inclination of both flanks, or [left, right] [deg]"
    )


class Ellipse(Section):
    """An elliptic arc continued by its tangents."""

    kind: Literal["ellipse"] = Field(description="ellipse + straight flanks")
    b_el: Length = Field(description="lateral semi-axis [mm]")
    d_el: Length = Field(description="vertical semi-axis [mm]")
    flank_inclination_deg: Flank | TwoOf[Flank] = Field(
        75.0, description="inclination of both flanks, or [left, right] [deg]"
    )


class PointsFile(Section):
    """A smooth curve through points, continued by its end tangents."""

    kind: Literal["points"] = Field(description="smooth curve through points")
    file: ExistingFile | None = Field(
        None, description="text file of two columns y, z [mm], y growing; # comments"
    )
    points: Several[TwoOf[Place]] = Field((), description="instead of a file: [[y, z], ...] [mm], y growing")
    y_centre: Place = Field(0.0, description="y of the contact centre [mm]")

    @model_validator(mode="after")
    def _one_source(self) -> "PointsFile":
        if (self.file is None) == (not self.points):
            raise ValueError("give either file or points")
        return self


AnyContour = Annotated[Plane | Arc | Ellipse | PointsFile, Field(discriminator="kind")]
CONTOURS: dict[str, type[Section]] = {  # the table of each kind
    get_args(table.model_fields["kind"].annotation)[0]: table for table in get_args(get_args(AnyContour)[0])
}


class BodyTable(Section):
    """One body."""

    E: Amount = Field(description="Young's modulus [MPa]")
    nu: float = Field(ge=0, le=0.4999, description="Poisson's ratio, 0 ... 0.4999 (solid engine: 0.49)")
    contour: AnyContour = Field(description="contact contour in (y, z)")
    rolling_radius: Annotated[float, Field(ge=20), AfterValidator(_finite_or_prismatic)] = Field(
        float("inf"),
        description="radius of the circle through the contact centre [mm], 20 ... inf (solid engine: 50); "
        "inf: prismatic",
    )
    hub_radius: Length | None = Field(
        None, description="radius of the clamped hub [mm]; default: 0.2 rolling_radius, the least allowed"
    )


class PatchTable(Section):
    """The loaded element, centred at x = 0."""

    a: Length = Field(description="half-side along x [mm]")
    b: Length = Field(description="half-side along s [mm]")
    s: Place = Field(0.0, description="arc length of its centre [mm]")

    @model_validator(mode="after")
    def _aspect(self) -> "PatchTable":
        if not 0.01 * (1 - 1e-9) <= self.a / self.b <= 100 * (1 + 1e-9):
            raise ValueError(f"a / b = {self.a / self.b:g} is outside 0.01 ... 100: bring a and b closer")
        return self


class LineAlongX(Section):
    """A line along x at a fixed arc length."""

    along: Literal["x"] = Field(description="direction of the line")
    s: Place = Field(description="arc length of the line [mm]")
    reach: Length = Field(25.0, description="half-length of the line [mm]")
    points: Whole = Field(401, ge=2, le=5000, description="number of points")


class LineAlongS(Section):
    """A line along s at a fixed longitudinal distance."""

    along: Literal["s"] = Field(description="direction of the line")
    x: Place = Field(description="longitudinal distance of the line [mm]")
    reach: Length = Field(25.0, description="half-length of the line [mm]")
    points: Whole = Field(401, ge=2, le=5000, description="number of points")


def _each_once(names: tuple[object, ...]) -> tuple[object, ...]:
    repeated = sorted({str(name) for name in names if names.count(name) > 1})
    if repeated:
        raise ValueError(f"{', '.join(repeated)} given twice: name each once")
    return names


Line = Annotated[LineAlongX | LineAlongS, Field(discriminator="along")]


def default_lines(s_patch: float) -> tuple[LineAlongX | LineAlongS, ...]:
    """The default lines: along x beside the patch and through it, along s in front of it."""
    return (
        LineAlongX.model_construct(along="x", s=s_patch + 1.6),
        LineAlongX.model_construct(along="x", s=s_patch),
        LineAlongS.model_construct(along="s", x=1.6),
    )


class GridTable(Section):
    """The grid of elements whose IC matrix `femic matrix` computes."""

    n_x: Annotated[Whole, Field(ge=1, le=4096)] = Field(64, description="number of elements along x: lags")
    n_s: Annotated[Whole, Field(ge=1, le=512)] = Field(32, description="number of strips")
    dx: Length | None = Field(None, description="length of an element [mm]; default: 2 x patch.a")
    ds: Length | None = Field(None, description="width of a strip [mm]; default: 2 x patch.b")
    s: Place = Field(0.0, description="arc length of its middle [mm]")
    check: Annotated[Whole, Field(ge=0, le=9)] = Field(
        0, description="strips whose columns the solid engine computes, too, as a check (minutes each)"
    )


class TransitionTable(Section):
    """A property that changes with the distance from the load until it has its far value at r_inf."""

    far: Signed = Field(description="its value at r_inf and beyond")
    r_inf: Length = Field(description="distance from the load [mm]")
    m: Exponent = Field(description="exponent near the load")
    n: Exponent = Field(description="exponent near r_inf")


class PropertiesTable(Section):
    """Effective properties of one body, or of both."""

    G: TransitionTable | None = Field(None, description="shear modulus [MPa]")
    nu: TransitionTable | None = Field(None, description="Poisson's ratio")
    mismatch_k: TransitionTable | None = Field(None, description="mismatch constant K")


class CombinedTable(PropertiesTable):
    """Effective properties of both bodies together."""

    curvature: Literal["contained", "apart"] = Field(
        "contained",
        description="of wheels along x. contained: in the properties; apart: added as B-hat has it",
    )


class EffectiveTable(Section):
    """The effective properties that Bhat_prime uses."""

    combined: CombinedTable | None = Field(None, description="of both bodies together")
    lower: PropertiesTable | None = Field(None, description="of the lower body")
    upper: PropertiesTable | None = Field(None, description="of the upper body")


class CalibrationTable(Section):
    """What `femic calibrate` fits: Bhat_prime to C at the points of lines with x_min < x <= x_max."""

    bodies: Several[BodyName] = Field(("combined",), min_length=1, description="whose properties to fit")
    properties: Several[PropertyName] = Field(
        ("mismatch_k",), min_length=1, description="which properties vary with the distance"
    )
    components: Several[Component] = Field(
        ("xn",), min_length=1, description="components to fit to, each counts alike"
    )
    curvature: Literal["contained", "apart"] = Field(
        "contained",
        description="of wheels along x, combined bodies. contained: the fit makes up for it; apart: "
        "subtracted before, and added by Bhat_prime as B-hat has it",
    )
    s: Several[Place] | None = Field(
        None, description="arc lengths of lines along x [mm]; default: patch.s and patch.s + 1.6"
    )
    x: Several[Length] = Field((), description="distances of lines along s [mm]")
    x_min: Length | None = Field(None, description="nearest points [mm]; default: 2 patch.a")
    x_max: Length | None = Field(
        None, description="furthest points [mm], also along s; default: 2.5 reference_length"
    )
    points: Annotated[Whole, Field(ge=8, le=5000)] = Field(200, description="number of points of a line")
    weights: Literal["uniform", "logarithmic"] = Field(
        "uniform", description="uniform: each point counts alike; logarithmic: each octave of the distance"
    )

    _distinct = field_validator("bodies", "properties", "components")(_each_once)

    @model_validator(mode="after")
    def _some_line(self) -> "CalibrationTable":
        if self.s == () and not self.x:
            raise ValueError("s and x: no line at all; give one")
        return self


class EngineTable(Section):
    """How the reference C is computed."""

    kind: EngineName = Field(
        "harmonic",
        description="harmonic: one section problem per wavenumber along x, seconds (half_length, "
        "line_growth and solver do not matter); solid: 3D finite elements, minutes",
    )
    check: bool = Field(
        False,
        description="draw C of the solid engine, too, at tolerance 0.01 or that of the scene (minutes, once)",
    )
    tolerance: Annotated[float, Field(ge=1e-4, le=1)] = Field(
        0.01,
        description="estimated error of C that is good enough, each body and combined, on the scale of "
        "refinement (docs/conventions.md); sets the cells",
    )
    most_unknowns: Annotated[Whole, Field(ge=1000)] = Field(
        1_000_000, description="largest model that refinement may lead to"
    )
    smallest_cell: Length | None = Field(
        None,
        description="first cell size at the patch [mm]; default: b/8 (solid: min(a, b)/12 at tolerance 0.01)",
    )
    growth: Annotated[float, Field(ge=0.02, le=0.5)] | None = Field(
        None,
        description="first cell size over distance from the patch's edges; default: 0.5, less below "
        "tolerance 0.003 (solid: over distance from the lines; 0.14 at tolerance 0.01)",
    )
    line_growth: Annotated[float, Field(ge=0.02, le=0.5)] | None = Field(
        None, description="first cell size on a line over distance from the patch; default: 0.05, likewise"
    )
    far_radius: Length | None = Field(
        None,
        description="first radius of the clamped far arc [mm]; default: 1280, more below tolerance 0.001 "
        "(solid: 320)",
    )
    half_length: Length = Field(320.0, description="first extent along +x and -x, clamped ends [mm]")
    solver: SolverChoice = Field("auto", description="linear solver; direct needs the extra femic[direct]")


def _each_distinct(values: tuple[float, ...]) -> tuple[float, ...]:
    _each_once(tuple(f"{value:.{DISTINCT_DIGITS}g}" for value in values))
    return values


CREEPAGES = (0.0005, 0.001, 0.0015, 0.002, 0.003, 0.004, 0.006, 0.008, 0.012)  # and 0, and these below 0
OF_MOTIONS = {  # keys that only some motions have
    "friction": ("rolling", "compression"),
    "longitudinal": ("rolling",),
    "lateral": ("rolling",),
    "spin": ("rolling",),
    "equal_force": ("rolling",),
    "approaches": ("none",),
    "gap": ("none",),
    "shape_load": ("none",),
    "lateral_force": ("none",),
}


class ContactTable(Section):
    """Contact of both bodies (femic contact)."""

    motion: Literal["none", "rolling", "compression"] = Field(
        "none",
        description="none: frictionless; rolling: steady rolling along x with friction, at one load; "
        "compression: with friction, loaded in steps",
    )
    loads: Several[Amount] = Field((), description="vertical loads [N]; of a compression they grow")
    approaches: Several[Length] = Field((), description="instead of loads: vertical approaches [mm]")
    ics: Several[ContactICName] = Field(
        ("A", "B", "Bhat", "C"),
        min_length=1,
        description=f"ICs to solve it with: C, {', '.join(VARIANTS)}, or one of these with components of "
        "others: Bhat+sn:B is Bhat with sn of B, and ns by reciprocity; map:FILE is C from the file of a "
        "campaign that kept matrix, without friction, on the grid of that",
    )
    friction: Several[Annotated[float, Field(gt=0, le=1000)]] = Field(
        (0.2, 0.4, 0.6), min_length=1, description="coefficients of friction, each solved, 0 ... 1000"
    )
    longitudinal: Several[Creepage] = Field(
        (*(-xi for xi in reversed(CREEPAGES)), 0.0, *CREEPAGES),
        min_length=2,
        description="of rolling: longitudinal creepages omega R / V - 1, growing, for the creep-force curve",
    )
    lateral: Creepage = Field(0.0, description="of rolling: lateral velocity of the wheel over V")
    spin: Annotated[float, Field(ge=-1, le=1)] = Field(
        0.0, description="of rolling: angular velocity of the wheel about z over V [1/mm]"
    )
    equal_force: Annotated[float, Field(gt=-1, lt=1)] = Field(
        0.5,
        description="of rolling: F_x / (friction load) at which tractions by all ICs are compared, -1 ... 1",
    )
    shift: Place = Field(0.0, description="the upper body is moved by this along y [mm]")
    flanks: bool = Field(
        True,
        description="whether the bodies may touch on the straight flanks beyond the contours; false where "
        "flanks only stand for the rest of a body",
    )
    gap: Literal["linear", "exact"] = Field(
        "linear",
        description="undeformed distance. linear: at first touch, less approach times cos(delta); exact: of "
        "the displaced body",
    )
    extra_gap: ExistingFile | None = Field(
        None,
        description="text file of columns x, s, gap, or of s, gap for all x [mm]: a gap that is added, "
        "linear between the points, 0 beyond; # comments",
    )
    elements: Annotated[Whole, Field(ge=8, le=64)] = Field(
        20, description="elements across the smallest patch on an automatic grid, along x and s"
    )
    grid: Literal["automatic", "scene"] = Field(
        "automatic", description="automatic: as large as the patches; scene: that of [grid], centred at x = 0"
    )
    lateral_force: Signed | None = Field(
        None,
        description="without friction: lateral force F_y on the upper body [N]; its lateral position "
        "follows, and `shift` is where it is sought first",
    )
    supports: bool = Field(
        True,
        description="whether the page shows what supports do to the contact by C: far arc of half the radius "
        "and, where the contact is not symmetric, flanks 5 degrees flatter (C once more)",
    )
    shape_load: Amount | None = Field(
        None,
        description="load whose B-hat pressures are mapped onto all patches, to see where A and B-hat differ "
        "[N]; default: the largest",
    )

    _distinct = field_validator("ics", "friction")(_each_once)
    _distinct_cases = field_validator("loads", "approaches")(_each_distinct)

    @model_validator(mode="after")
    def _loads_or_approaches(self) -> "ContactTable":
        if self.loads and self.approaches:
            raise ValueError("give either loads or approaches")
        return self

    @model_validator(mode="after")
    def _of_this_motion(self) -> "ContactTable":
        for key, motions in OF_MOTIONS.items():
            if key in self.model_fields_set and self.motion not in motions:
                of = " or ".join(map(repr, motions))
                raise ValueError(f"{key} is only of motion = {of}, not {self.motion!r}: leave it out")
        return self

    @model_validator(mode="after")
    def _growing(self) -> "ContactTable":
        for key in ("longitudinal", *(["loads"] if self.motion == "compression" else [])):
            values = getattr(self, key)
            if any(after <= before for before, after in pairwise(values)):
                raise ValueError(f"{key} must grow: sort them, each once")
        return self


class SceneFile(Section):
    """A scene: two bodies, a loaded patch, the lines where displacements are read."""

    title: str = Field("", description="heading of the report")
    bodies: Several[BodyName] = Field(
        ("combined", "lower", "upper"), min_length=1, description="whose ICs to compute and compare"
    )
    components: Several[Component] = Field(
        ("nn", "ss", "xx", "xs", "xn", "sn"),
        min_length=1,
        description="displacement direction, then traction direction",
    )
    variants: Several[VariantName] = Field(
        ("A", "B", "Bbar", "Bhat", "mix"), min_length=1, description="approximations to compare with C"
    )
    reference_length: Length | None = Field(
        None,
        description="unit of length of the plots [mm]; default: crown radius of the lower body, 10 if flat",
    )
    rotation_reach: Length | None = Field(
        None,
        description="|s| where the rigid rotation is discounted [mm]; default: 2 x reference_length, "
        "at most an eighth of the domain and a sixth of a turn",
    )
    moment_arm: Length | None = Field(
        None,
        description="s of the normal load that fixes M in rotation [mm], needed if patch.s is not 0; "
        "default: reference_length / 2",
    )
    discount: Literal["approach", "source", "none"] = Field(
        "approach",
        description="what femic matrix, contact and export take away from C. approach: the rigid part of "
        "the normal approach alone; source: all that [BVSV] discounts to compare single loads with "
        "half-spaces, bending of the section included; none: nothing, so that approaches depend on the "
        "supports, too",
    )
    ics: ICName = Field(
        "C",
        description="ICs to use where one has to be chosen (femic export): C, an approximation, or auto: the "
        "cheapest that is good enough, as femic advise finds it",
    )
    ics_tolerance: Annotated[float, Field(gt=0, le=1)] = Field(
        0.02, description="largest error, share of the component itself, that is good enough for ics = 'auto'"
    )
    fields: bool = Field(
        False,
        description="write the displacement and stress fields of the finest model as .vtu, "
        "one per body and load",
    )
    lower: BodyTable = Field(description="lower body (rail), fills n < 0")
    upper: BodyTable = Field(description="upper body (wheel), fills n > 0")
    patch: PatchTable | None = Field(
        None,
        description="loaded element at x = 0; contact needs none; default: half-sides of a hundredth of "
        "rotation_reach",
    )
    grid: GridTable = Field(GridTable(), description="elements of the IC matrix (femic matrix)")
    lines: Annotated[Several[Line], Field(min_length=1)] | None = Field(
        None, description="offset lines; default: s = patch.s + 1.6, s = patch.s, x = 1.6 mm"
    )
    effective: EffectiveTable = Field(
        EffectiveTable(), description="properties that vary with the distance from the load, for Bhat_prime"
    )
    calibration: CalibrationTable = Field(
        CalibrationTable(), description="which properties femic calibrate fits to which points"
    )
    contact: ContactTable = Field(
        ContactTable(), description="contact of both bodies, without or with friction (femic contact)"
    )
    engine: EngineTable = Field(EngineTable(), description="how the reference C is computed")

    _distinct = field_validator("bodies", "components", "variants")(_each_once)


BUILTIN = Path(__file__).parent / "builtin"
