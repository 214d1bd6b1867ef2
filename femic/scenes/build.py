"""The scene of a file's tables: bodies, patch, lines, and settings of C."""

from collections.abc import Iterator

import numpy as np

from femic.contact.specification import APPROACH_SHARE
from femic.reference.harmonic.tuned import FAR_RADIUS
from femic.reference.job import Settings
from femic.scenes.bodies import body_of
from femic.scenes.calibration import calibration_misfits, calibration_of
from femic.scenes.contact import contact_misfits, contact_of
from femic.scenes.effective import effective_misfits, effective_properties
from femic.scenes.engine import engine_misfits
from femic.scenes.errors import require_none
from femic.scenes.file import SceneFile
from femic.scenes.grid import figure_grid, grid_misfits
from femic.scenes.lines import (
    default_lines,
    line_of,
    patch_of,
    single_load_misfits,
)
from femic.scenes.scene import Scene
from femic.scenes.scene_table import shared
from femic.scenes.stresses import damage_misfits, damage_of, stress_misfits, stresses_of
from femic.scenes.wants import want_misfits
from geometries.bodies import Body, common_extent
from geometries.contours import Contour
from geometries.surfaces import LOWER, UPPER

SIDES = {"lower": LOWER, "upper": UPPER}
FLAT_REFERENCE_LENGTH = 10.0  # mm


def build_scene(name: str, text: str, file: SceneFile) -> Scene:
    """Return the scene of a valid file; raise BadScene where its parts do not fit together."""
    bodies = {
        body: body_of(getattr(file, body), body, side, file.engine.domain) for body, side in SIDES.items()
    }
    reference_length = file.reference_length or _crown_radius(bodies["lower"].contour)
    extent, room = common_extent(bodies), _discount_room(bodies)
    rotation_reach = file.rotation_reach or min(2 * reference_length, room)
    patch = patch_of(file.patch, rotation_reach)
    settings = Settings(
        engine=file.engine.engine,
        cells=file.engine.cells(patch),
        rotation_reach=rotation_reach,
        moment_arm=file.moment_arm or min(reference_length / 2, room / 2),
        approach_side=reference_length / APPROACH_SHARE,
        **shared(file.engine, Settings),
    )
    resolved = {
        "name": name,
        "title": file.title or name,
        "text": text,
        "bodies": bodies,
        "compared": file.bodies,
        "effective": effective_properties(file.effective),
        "curvature_apart": file.effective.curvature_apart,
        "calibration": calibration_of(file.calibration, patch, reference_length, extent),
        "patch": patch,
        "lines": tuple(line_of(line, extent) for line in file.lines or default_lines(patch.s)),
        "grid": figure_grid(file.grid, patch),
        "checked_strips": file.grid.check,
        "contact": contact_of(file.contact),
        "stresses": stresses_of(file.stresses),
        "damage": damage_of(file.damage),
        "support_radius": file.engine.far_radius or FAR_RADIUS,
        "settings": settings,
        "reference_length": reference_length,
        "check": check_scene(name, text, file) if file.engine.needs_check else None,
    }
    scene = Scene(**shared(file, Scene) | resolved)
    require_none(name, list(_table_misfits(scene, file)))
    return scene


def check_scene(name: str, text: str, file: SceneFile) -> Scene:
    """Return the scene with the engine that checks others."""
    return build_scene(name, text, file.model_copy(update={"engine": file.engine.check_engine}))


def misfits(scene: Scene) -> Iterator[str]:
    """Yield what does not fit between the tables of a scene that each scene has."""
    yield from engine_misfits(scene)
    yield from contact_misfits(scene)
    yield from stress_misfits(scene)
    yield from want_misfits(scene)
    yield from effective_misfits(scene)


def _table_misfits(scene: Scene, file: SceneFile) -> Iterator[str]:
    """Yield what does not fit between the tables of a scene; of some tables only where they are given.

    A contact without C has no use for the patch and the lines.
    """
    yield from misfits(scene)
    contact = scene.contact
    if {"patch", "lines"} & file.model_fields_set or "C" in contact.ics or not contact.loadings:
        yield from single_load_misfits(scene)
    yield from damage_misfits(scene, file.damage)
    if "grid" in file.model_fields_set:
        yield from grid_misfits(scene)
    if "calibration" in file.model_fields_set:
        yield from calibration_misfits(scene)


def _discount_room(bodies: dict[str, Body]) -> float:
    """Return the distance from the contact centre within which the discount has room [mm]."""
    domain, extent = bodies["lower"].domain, common_extent(bodies)
    turn = min(2 * np.pi * body.rolling_radius for body in bodies.values())
    return float(min(domain.far_radius / 8, domain.half_length / 8, turn / 6, -extent[0], extent[1]))


def _crown_radius(contour: Contour) -> float:
    """Return the radius of curvature at s = 0 [mm]; `FLAT_REFERENCE_LENGTH` where the contour is flat."""
    step = 1e-4
    inclinations = contour.core.inclination(np.array([-step, step]))
    curvature = float(np.ptp(inclinations)) / (2 * step)
    return 1 / abs(curvature) if abs(curvature) > 1e-6 else FLAT_REFERENCE_LENGTH
