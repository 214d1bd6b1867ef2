"""Bodies and pairs: contours with their materials.

Each is made of the keys that scene files have, declared and checked in `femic.scenes`.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError

from approx.effective import EffectiveProperties
from femic.interface.arguments import MADE_BY, array, check_fields, shown, with_checked_arguments
from femic.scenes import bodies as contours
from femic.scenes.bodies import BodyTable
from femic.scenes.input_files import make_files_absolute
from femic.scenes.load import messages, parse, read_scene, scene_path
from femic.scenes.plausibility import modulus_warnings
from femic.scenes.scene_table import SceneTable
from geometries import bodies
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.surfaces import LOWER

Flanks = float | tuple[float, float]
ANY_DOMAIN = bodies.Domain(np.inf, np.inf)  # of bodies whose keys are checked
Table = TypeVar("Table", bound=SceneTable)


def plain(value: Any) -> Any:
    """Return a value as TOML has it: numbers and lists of NumPy as those of Python.

    Tables stay as they are.
    """
    if isinstance(value, Mapping):
        return {name: plain(inner) for name, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(inner) for inner in value]
    return value


def checked(table: type[Table], keys: Mapping[str, Any], names: Mapping[Any, str] | None = None) -> Table:
    """Return a table of a scene file; raise WrongInput for keys that it does not take.

    `names` are arguments by the places of their values in the table, where these have other names.
    """
    try:
        return table.model_validate(plain(keys))
    except ValidationError as error:
        details = error.errors()
        for detail in details:
            for place, name in (names or {}).items():
                if detail["loc"][: len(place)] == place:
                    detail["loc"] = (name, *detail["loc"][len(place) :])
        raise WrongInput("; ".join(messages(details))) from error


def given(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys that have a value."""
    return {name: value for name, value in keys.items() if value is not None}


def plane() -> contours.PlaneTable:
    """Return a plane, the contour z = 0."""
    return checked(contours.PlaneTable, {"kind": "plane"})


@with_checked_arguments
def arc(radius: float, flank_inclination_deg: Flanks) -> contours.ArcTable:
    """Return a circular arc that continues in straight flanks.

    `radius` [mm] is negative for a groove. Give one inclination [degrees] for both flanks, or a pair (left,
    right). Raises WrongInput.
    """
    keys = {"radius": radius, "flank_inclination_deg": flank_inclination_deg}
    return checked(contours.ArcTable, {"kind": "arc"} | keys)


@with_checked_arguments
def ellipse(b_el: float, d_el: float, flank_inclination_deg: Flanks = 75.0) -> contours.EllipseTable:
    """Return an ellipse that continues in straight flanks.

    The semi-axes are `b_el` along y and `d_el` along z [mm]. Inclinations [degrees] are given as for `arc`.
    Raises WrongInput.
    """
    keys = {"b_el": b_el, "d_el": d_el, "flank_inclination_deg": flank_inclination_deg}
    return checked(contours.EllipseTable, {"kind": "ellipse"} | keys)


@with_checked_arguments
def through_points(y: ArrayLike, z: ArrayLike, y_centre: float = 0.0) -> contours.PointsTable:
    """Return a smooth curve through points (y, z) [mm], (n,) each, y increasing; s = 0 is at `y_centre` [mm].

    Raises WrongInput.
    """
    y, z = array("y", y), array("z", z)
    if y.ndim != 1 or y.shape != z.shape:
        raise WrongInput(f"y and z of shapes {y.shape} and {z.shape}: give two lists of equal length")
    points = np.column_stack([y, z]).tolist()
    curve = checked(contours.PointsTable, {"kind": "points", "points": points, "y_centre": y_centre})
    curve.contour()  # raises for points that have no curve through them
    return curve


@dataclass(frozen=True)
class Body:
    """A body, given by its contour, its material and its shape along x.

    Without a `rolling_radius` the body is prismatic along x. With a `rolling_radius` [mm], measured at the
    contact centre, it is a body of revolution with a clamped hub of `hub_radius` [mm], by default a fifth of
    the rolling radius. `outline` takes the keys of the table of that name in a scene file, such as
    {"standard": "60E1"}. Raises WrongInput; warns if no material is as stiff as E.
    """

    contour: SceneTable
    material: Material
    rolling_radius: float = np.inf
    hub_radius: float | None = None
    outline: Mapping[str, Any] | None = field(default=None, hash=False)

    def __post_init__(self) -> None:
        check_fields(self)
        if not hasattr(self.contour, "contour"):  # another table, such as that of a line
            raise WrongInput(
                f"contour = {shown(self.contour)}: give what is made with {MADE_BY['SceneTable']}"
            )
        table = self.table
        bodies.Body(
            LOWER, table.contour.contour(), self.material, ANY_DOMAIN, self.rolling_radius, self.hub_radius
        )
        if table.outline is not None:
            table.outline.outline(table.contour)
        for text in modulus_warnings(self.material.E):
            warnings.warn(text, stacklevel=3)

    @property
    def table(self) -> BodyTable:
        """The body as a scene has it."""
        keys = asdict(self.material) | {
            "contour": self.contour,
            "rolling_radius": None if self.rolling_radius == np.inf else self.rolling_radius,
            "hub_radius": self.hub_radius,
            "outline": plain(self.outline) or None,
        }
        make_files_absolute(keys, BodyTable)
        return checked(BodyTable, given(keys))


@dataclass(frozen=True)
class Pair:
    """Two bodies in contact: the `upper` one, a wheel, and the `lower` one, a rail.

    `effective` holds the properties of B-hat-prime for "combined", "lower" or "upper", as returned by
    `fit_bhat_prime`; with `curvature_apart`, those of "combined" exclude the curvature of wheels.
    `reference_length` [mm] makes ICs dimensionless and determines where rigid motions are read; the default
    is the crown radius of the lower body, or 10 mm if it is flat. Raises WrongInput.
    """

    upper: Body
    lower: Body
    effective: Mapping[str, EffectiveProperties] = field(default_factory=dict, hash=False)
    curvature_apart: bool = False
    reference_length: float | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        if self.curvature_apart and "combined" not in self.effective:
            raise WrongInput(
                "curvature_apart = True: only where effective properties of 'combined' are given"
            )
        if self.reference_length is not None and self.reference_length <= 0:
            raise WrongInput(f"reference_length = {self.reference_length!r}: must be positive [mm]")

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of a scene that describe the pair."""
        effective = {name: given(asdict(properties)) for name, properties in self.effective.items()}
        if self.curvature_apart:
            effective["combined"]["curvature"] = "apart"
        bodies = {"upper": self.upper.table, "lower": self.lower.table}
        return given({"reference_length": self.reference_length, **bodies, "effective": effective})


@with_checked_arguments
def load_pair(name_or_path: str | Path) -> Pair:
    """Return the bodies of a built-in scene, such as "geometry1", or of a scene file; raise WrongInput."""
    path = scene_path(str(name_or_path))
    file = parse(read_scene(path)[1], path)
    upper, lower = (
        Body(
            contour=table.contour,  # type: ignore[arg-type]  # each kind of contour is a table
            material=Material(table.E, table.nu),
            rolling_radius=table.rolling_radius,
            hub_radius=table.hub_radius,
            outline=table.outline.model_dump(mode="json", exclude_defaults=True) if table.outline else None,
        )
        for table in (file.upper, file.lower)
    )
    effective = file.effective
    return Pair(upper, lower, effective.properties, effective.curvature_apart, file.reference_length)
