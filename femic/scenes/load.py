"""Loads scenes: builds bodies, patch and lines from a built-in name, a TOML file or a table.

Errors of a scene are collected and raised together.
"""

from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from pydantic import ValidationError

from approx.effective import EffectiveProperties, Transition
from femic.contact.extra_gap import ExtraGap, extra_gap
from femic.contact.specification import ContactSpecification, FrictionSpecification
from femic.reference.engine import Engine
from femic.reference.engines import ENGINES
from femic.reference.harmonic.tuned import FAR_RADIUS
from femic.reference.job import Settings
from femic.reference.meshing.cell_size import Cells
from femic.reference.solid.record import SOLID
from femic.scenes import file as files
from femic.scenes.checks import calibration_misfits, grid_misfits, misfits
from femic.scenes.columns import columns
from femic.scenes.errors import BadScene, require_none
from femic.scenes.messages import messages
from femic.scenes.names import name_of
from femic.scenes.scene import Calibration, Scene
from femic.scenes.toml import NotToml, table_of
from geometries import contours
from geometries.bodies import Body, Domain, common_extent
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.materials import Material
from geometries.patches import OffsetLine, Patch, line_along_s, line_along_x
from geometries.surfaces import LOWER, UPPER

FLAT_REFERENCE_LENGTH = 10.0  # mm
APPROACH_SHARE = 50.0  # reference length over the half-side of the load at which the approach is matched
PATCHES_IN_REACH = 100.0  # rotation_reach over the half-sides of a patch that is not given
CHECK_ENGINE, CHECK_TOLERANCE = SOLID, 0.01  # the engine that checks others; its tightest tolerance for that


def builtin_names() -> list[str]:
    """Names of the scenes that come with the program."""
    return sorted(path.stem for path in files.BUILTIN.glob("*.toml"))


def load_scene(name_or_path: str, changes: Mapping[str, Any] | None = None) -> Scene:
    """The scene of a built-in name or a TOML file, with some keys changed; raises BadScene before any work.

    `changes` has the keys of a scene file. A table in it replaces only those keys that it names; one that
    names a `kind` replaces the whole table.
    """
    path = scene_path(name_or_path)
    text, table = read_scene(path)
    if changes:
        table = merged(table, changes)
        text = tomlkit.dumps(table)
    return build_scene(name_of(path), text, parse(table, path))


def merged(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A table with some keys changed, as of `load_scene`."""
    changed = dict(table)
    for key, value in changes.items():
        old = table.get(key)
        if isinstance(value, Mapping) and isinstance(old, Mapping) and "kind" not in value:
            changed[key] = merged(old, value)
        else:
            changed[key] = deepcopy(value)
    return changed


def load_solid_scene(name_or_path: str) -> Scene:
    """The scene of a name or TOML file by an engine that has fields in 3D: its own, or the solid engine.

    Raises BadScene.
    """
    path = scene_path(name_or_path)
    text, table = read_scene(path)
    scene = parse(table, path)
    build = build_scene if ENGINES[scene.engine.kind].fields else _by_solid_engine
    return build(name_of(path), text, scene)


def scene_from_table(table: dict[str, Any], name: str) -> Scene:
    """The scene of a table with the keys of a scene file, for use from Python; raises BadScene.

    Names of files in it are relative to the working directory.
    """
    return build_scene(name, tomlkit.dumps(table), parse(deepcopy(table), Path(name)))


def read_scene(path: Path) -> tuple[str, dict[str, Any]]:
    """Text and table of a TOML file; raises BadScene if it is not TOML."""
    try:
        text = path.read_text(encoding="utf-8")
        return text, table_of(text)
    except (NotToml, UnicodeDecodeError) as error:
        raise BadScene(f"{path}: not TOML: {error}. Compare with `femic scenes --show flat`") from error


def scene_path(name_or_path: str) -> Path:
    """Path of the scene file of a built-in name or of a path; raises BadScene if there is none."""
    builtin = files.BUILTIN / f"{name_or_path}.toml"
    path = builtin if name_or_path in builtin_names() else Path(name_or_path)
    if not path.is_file():
        similar = get_close_matches(name_or_path, builtin_names(), cutoff=0.7)
        hint = f"did you mean {' or '.join(map(repr, sorted(similar)))}? " if similar else ""
        raise BadScene(
            f"scene {name_or_path!r}: no such file and no built-in scene; {hint}"
            f"Built-in: {', '.join(builtin_names())}"
        )
    return path


def parse(table: dict[str, Any], path: Path) -> files.SceneFile:
    """Validate the keys and values of a scene table; raises BadScene.

    Names of files in it are relative to the scene file, `path`.
    """
    resolve_files(table, path.parent)
    try:
        return files.SceneFile.model_validate(table)
    except ValidationError as error:
        lines = messages(error.errors())
        raise BadScene(f"{path}: {len(lines)} error(s)\n  " + "\n  ".join(lines)) from error


def resolve_files(table: dict[str, Any], folder: Path) -> None:
    """Let names of files in a scene table begin at a folder instead of the working directory."""
    places = [(table.get(body, {}), "contour", "file") for body in ("lower", "upper")]
    for of_body, *keys in [*places, (table, "contact", "extra_gap")]:
        inner = of_body.get(keys[0], {}) if isinstance(of_body, dict) else {}
        if isinstance(inner, dict) and isinstance(inner.get(keys[1]), str):
            inner[keys[1]] = str(folder / inner[keys[1]])
    contact = table.get("contact", {})
    ics = contact.get("ics") if isinstance(contact, dict) else None
    if isinstance(ics, list):
        contact["ics"] = [_with_folder(name, folder) for name in ics]


def _with_folder(ics: Any, folder: Path) -> Any:
    """The name of ICs; of a map with its folder."""
    if not (isinstance(ics, str) and files.is_map(ics)):
        return ics
    return files.MAP + str(folder / ics.removeprefix(files.MAP))


def _files(scene: files.SceneFile) -> dict[str, Path]:
    contours = {"lower": scene.lower.contour, "upper": scene.upper.contour}
    return {
        name: contour.file
        for name, contour in contours.items()
        if isinstance(contour, files.PointsFile) and contour.file is not None
    }


def build_scene(name: str, text: str, scene: files.SceneFile) -> Scene:
    """Build a scene from a valid file; raises BadScene where its parts do not fit together."""
    table, engine = scene.engine, ENGINES[scene.engine.kind]
    far_radius = table.far_radius or engine.far_radius(table.tolerance)
    domain = Domain(far_radius, np.inf if engine.infinite_length else table.half_length)
    bodies = {
        body_name: _body(body_name, side, body_table, domain)
        for body_name, side, body_table in (("lower", LOWER, scene.lower), ("upper", UPPER, scene.upper))
    }
    reference_length = scene.reference_length or _crown_radius(bodies["lower"].contour)
    extent = common_extent(bodies)
    turn = min(2 * np.pi * body.rolling_radius for body in bodies.values())
    of_domain = min(domain.far_radius, domain.half_length) / 8
    room = min(of_domain, turn / 6, -extent[0], extent[1])  # of the discount [mm]
    rotation_reach = scene.rotation_reach or min(2 * reference_length, room)
    patch = _patch(scene.patch, rotation_reach)
    built = Scene(
        name=name,
        title=scene.title or name,
        text=text,
        files=_files(scene),
        bodies=bodies,
        compared=scene.bodies,
        components=scene.components,
        variants=scene.variants,
        effective=_effective(scene.effective),
        curvature_apart=scene.effective.combined is not None
        and scene.effective.combined.curvature == "apart",
        calibration=_calibration(scene.calibration, patch, reference_length, extent),
        patch=patch,
        lines=tuple(_line(line, extent) for line in scene.lines or files.default_lines(patch.s)),
        grid=_grid(scene.grid, patch),
        checked_strips=scene.grid.check,
        contact=_contact(scene.contact),
        discount=scene.discount,
        support_radius=table.far_radius or FAR_RADIUS,
        settings=Settings(
            engine,
            table.tolerance,
            _cells(engine, table, patch),
            table.most_unknowns,
            rotation_reach,
            scene.moment_arm or min(reference_length / 2, room / 2),
            reference_length / APPROACH_SHARE,
            table.solver,
        ),
        reference_length=reference_length,
        fields=scene.fields,
        ics=scene.ics,
        ics_tolerance=scene.ics_tolerance,
        check=_by_solid_engine(name, text, scene) if table.check and engine is not CHECK_ENGINE else None,
    )
    require_none(name, list(_misfits_of_given(built, scene.model_fields_set)))
    return built


def _misfits_of_given(built: Scene, given: set[str]) -> Iterator[str]:
    """Yield what does not fit between the tables of a scene; of some tables only where they are given."""
    yield from misfits(built)
    if "grid" in given:
        yield from grid_misfits(built)
    if "calibration" in given:
        yield from calibration_misfits(built)


def _by_solid_engine(name: str, text: str, scene: files.SceneFile) -> Scene:
    """The scene by the solid engine, with cells of that engine's own.

    Its domain is that of the scene where one is given, else the engine's own.
    """
    of_scene = {
        key: getattr(scene.engine, key) for key in ("far_radius", "half_length", "most_unknowns", "solver")
    }
    tolerance = max(scene.engine.tolerance, CHECK_TOLERANCE)
    engine = files.EngineTable.model_validate(of_scene | {"kind": CHECK_ENGINE.name, "tolerance": tolerance})
    return build_scene(name, text, scene.model_copy(update={"engine": engine}))


def _effective(table: files.EffectiveTable) -> dict[str, EffectiveProperties]:
    """Effective properties by "combined", "lower", "upper", where given; raises BadScene."""
    effective = {}
    for name, properties in table:
        if properties is not None:
            tables = {key: getattr(properties, key) for key in files.PropertiesTable.model_fields}
            transitions = {
                key: Transition(**dict(value)) for key, value in tables.items() if value is not None
            }
            if not transitions:
                raise BadScene(
                    f"effective.{name}: names no property; give one of {', '.join(tables)}, or leave it out"
                )
            try:
                effective[name] = EffectiveProperties(**transitions)
            except WrongInput as error:
                raise BadScene(f"effective.{name}: {error}") from error
    return effective


def _calibration(
    table: files.CalibrationTable, patch: Patch, reference_length: float, extent: tuple[float, float]
) -> Calibration:
    nearest, furthest = table.x_min or 2 * patch.a, table.x_max or 2.5 * reference_length
    x = np.linspace(nearest, furthest, table.points + 1)[1:]
    along_x = [
        OffsetLine(f"fit s = {s:g} mm", "x", x, np.full_like(x, s))
        for s in ((patch.s, patch.s + 1.6) if table.s is None else table.s)
    ]
    s_range = max(extent[0], patch.s - furthest), min(extent[1], patch.s + furthest)
    along_s = [
        replace(line_along_s(distance, s_range, table.points), name=f"fit x = {distance:g} mm")
        for distance in table.x
    ]
    return Calibration(
        table.bodies,
        table.properties,
        table.components,
        table.curvature == "apart",
        nearest,
        furthest,
        (*along_x, *along_s),
        table.weights == "logarithmic",
    )


def _body(name: str, side: int, table: files.BodyTable, domain: Domain) -> Body:
    try:
        return Body(
            side,
            _contour(name, table.contour),
            Material(table.E, table.nu),
            domain,
            table.rolling_radius,
            table.hub_radius,
        )
    except BadScene:
        raise
    except WrongInput as error:
        raise BadScene(f"{name}.{error}") from error


def _patch(table: files.PatchTable | None, rotation_reach: float) -> Patch:
    """The loaded element; by default small beside the distances at which displacements are compared."""
    if table is None:
        return Patch(rotation_reach / PATCHES_IN_REACH, rotation_reach / PATCHES_IN_REACH)
    return Patch(table.a, table.b, table.s)


def _grid(table: files.GridTable, patch: Patch) -> Grid:
    return Grid(table.n_x, table.n_s, table.dx or 2 * patch.a, table.ds or 2 * patch.b, table.s)


def _cells(engine: Engine, table: files.EngineTable, patch: Patch) -> Cells:
    """The first cells: as the scene says, else as the tolerance needs."""
    default = engine.tuned.cells_for(table.tolerance, patch)
    return Cells(
        table.smallest_cell or default.smallest,
        table.growth or default.growth,
        table.line_growth or default.line_growth,
    )


def _contact(table: files.ContactTable) -> ContactSpecification:
    return ContactSpecification(
        table.loads,
        table.approaches,
        table.ics,
        table.shift,
        table.flanks,
        table.gap == "exact",
        _extra_gap(table.extra_gap),
        table.elements,
        table.grid == "automatic",
        table.shape_load,
        table.lateral_force,
        table.supports,
        None if table.motion == "none" else _friction(table),
    )


def _friction(table: files.ContactTable) -> FrictionSpecification:
    return FrictionSpecification(
        table.motion, table.friction, table.longitudinal, table.lateral, table.spin, table.equal_force
    )


def _extra_gap(path: Path | None) -> ExtraGap | None:
    """The gap of a file; raises BadScene for other files."""
    if path is None:
        return None
    try:
        return extra_gap(columns(path, ("s, gap", "x, s, gap")))
    except WrongInput as error:
        raise BadScene(f"contact.extra_gap = {path}: {error}") from error


def _contour(body: str, table: files.Plane | files.Arc | files.Ellipse | files.PointsFile) -> Contour:
    match table:
        case files.Plane():
            return contours.plane()
        case files.Arc():
            return contours.arc(table.radius, *_flanks(table.flank_inclination_deg))
        case files.Ellipse():
            return contours.ellipse(table.b_el, table.d_el, *_flanks(table.flank_inclination_deg))
    source = f"{body}.contour.points" if table.file is None else f"{body}.contour.file = {table.file}"
    try:
        y, z = np.transpose(table.points if table.file is None else columns(table.file, ("y, z",)))
        return contours.through_points(y, z, table.y_centre)
    except WrongInput as error:
        raise BadScene(f"{source}: {error}") from error


def _flanks(degrees: float | tuple[float, float]) -> tuple[float, float]:
    left, right = degrees if isinstance(degrees, tuple) else (degrees, degrees)
    return float(np.radians(left)), float(np.radians(right))


def _crown_radius(contour: Contour) -> float:
    """Radius of curvature at s = 0 [mm]; `FLAT_REFERENCE_LENGTH` where the contour is flat there."""
    step = 1e-4
    inclinations = contour.core.inclination(np.array([-step, step]))
    curvature = float(np.ptp(inclinations)) / (2 * step)
    return 1 / abs(curvature) if abs(curvature) > 1e-6 else FLAT_REFERENCE_LENGTH


def _line(line: files.LineAlongX | files.LineAlongS, extent: tuple[float, float]) -> OffsetLine:
    if isinstance(line, files.LineAlongX):
        return line_along_x(line.s, line.reach, line.points)
    s_range = max(-line.reach, extent[0]), min(line.reach, extent[1])
    return line_along_s(line.x, s_range, line.points)
