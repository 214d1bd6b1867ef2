"""The tables [lower] and [upper] of a scene file: material and surface of a body."""

from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from femic.key_types import LARGEST_LENGTH, LEAST_LENGTH, Amount, Length
from femic.scenes.contours import AnyContour
from femic.scenes.errors import BadScene
from femic.scenes.outlines import OutlineTable
from femic.scenes.profiles import ProfileTable
from femic.scenes.scene_table import SceneTable
from geometries.bodies import Body, Domain
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.surfaces import LOWER


def _finite_or_prismatic(value: float) -> float:
    """Return a rolling radius; raise ValueError for one that is neither a length nor infinite."""
    if not (value <= LARGEST_LENGTH or value == float("inf")):
        raise ValueError(f"should be at most {LARGEST_LENGTH:g}, or inf for a prismatic body")
    return value


class BodyTable(SceneTable):
    """A body."""

    E: Amount = Field(description="Young's modulus [MPa]")
    nu: float = Field(ge=0, le=0.4999, description="Poisson's ratio, 0 ... 0.4999 (solid engine: 0.49)")
    contour: AnyContour = Field(description="contact contour in (y, z)")
    rolling_radius: Annotated[float, Field(ge=LEAST_LENGTH), AfterValidator(_finite_or_prismatic)] = Field(
        np.inf,
        description="radius of the circle through the contact centre [mm]; for C and stresses 20 ... inf "
        "(solid engine: 50); inf: prismatic",
    )
    hub_radius: Length | None = Field(
        None, description="radius of the clamped hub [mm]; default: 0.2 rolling_radius, the least allowed"
    )
    outline: OutlineTable | None = Field(
        None, description="a table: the shape and the supports of the body; default: far arc or hub"
    )


def body_of(table: BodyTable, name: str, side: int, domain: Domain) -> Body:
    """Return the body of a table by its name; raise BadScene where its keys do not fit together."""
    try:
        material = Material(table.E, table.nu)
        if isinstance(table.contour, ProfileTable):
            _check_profile(table.contour, side, table.rolling_radius)
        return Body(
            side,
            table.contour.contour(),
            material,
            domain,
            table.rolling_radius,
            table.hub_radius,
            table.outline.outline(table.contour) if table.outline else None,
        )
    except WrongInput as error:
        raise BadScene(f"{name}.{error}") from error


def _check_profile(profile: ProfileTable, side: int, rolling_radius: float) -> None:
    """Raise WrongInput for a profile of the other body, and for a turned one of a body of revolution."""
    kind, own = profile.of_kind(), "rail" if side == LOWER else "wheel"
    if kind != own:
        raise WrongInput(f"contour: profile of a {kind}, but this body is the {own}: exchange the profiles")
    if profile.turn and np.isfinite(rolling_radius):
        raise WrongInput(
            f"contour: turned by {np.degrees(profile.turn):.4g} degrees; the axis of a body of revolution "
            "stays along y: leave out rail_inclination and turn_deg, and turn the other body"
        )
