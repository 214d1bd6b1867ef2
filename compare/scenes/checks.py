"""Whether the parts of a scene fit together: every misfit as a line with field, value and remedy."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from compare.scenes.scene import Scene
from femic.engine import Engine
from femic.engines import ENGINES
from femic.solid.pardiso import available as direct_available
from geometries.bodies import Body, Domain
from geometries.patches import OffsetLine

ROUNDING = 1e-9
CLEAR_OF_PATCH = 6  # half-widths beside a moment load
LARGEST = 5e6  # radius of the far arc, likewise
INSTALL_DIRECT = "run .venv/bin/pip install -c constraints.txt -e '.[direct]'"


def misfits(scene: Scene, extent: tuple[float, float], domain: Domain) -> Iterator[str]:
    """What is wrong between the tables of a scene."""
    limits = scene.settings.engine.limits
    around = min(np.pi * body.rolling_radius for body in scene.bodies.values())
    size = min(domain.far_radius, domain.half_length, around)
    half_length = ", engine.half_length" if np.isfinite(domain.half_length) else ""
    far = f"half of the least of engine.far_radius{half_length} and half a turn ({size / 2:g} mm)"
    yield from _patch_misfits(scene, extent, size, far)
    yield from _line_misfits(scene, extent, size, far)
    reaches = [_reach(line, scene.patch.s) for line in scene.lines]
    labelled = [(f"lines.{k} ({name})", reach) for k, (name, reach) in enumerate(reaches)]
    of_patch = {"patch.a": scene.patch.a, "patch.b": scene.patch.b}
    yield from _ratio_misfits(of_patch, [*labelled, ("rotation_reach", scene.settings.rotation_reach)], scene)
    for name, body in scene.bodies.items():
        yield from _body_misfits(name, body, limits.inclination)
    yield from _limit_misfits(scene)
    if "Bhat_prime" in scene.variants and not any(scene.pair.has_effective(name) for name in scene.compared):
        yield (
            "variants: Bhat_prime needs effective properties of what is compared: add a table "
            "[effective.combined.mismatch_k] with far, r_inf, m, n (or of lower, upper; of G, nu)"
        )
    if scene.ics == "Bhat_prime" and not any(scene.pair.has_effective(name) for name in scene.compared):
        yield "ics = 'Bhat_prime': the scene has no effective properties; femic calibrate finds some"
    if scene.fields and not scene.settings.engine.has_fields:
        able = " or ".join(repr(name) for name, engine in ENGINES.items() if engine.has_fields)
        yield f"fields = true: only engine.kind = {able} has fields in 3D"
    if scene.settings.solver == "direct" and not direct_available():
        yield f"engine.solver = 'direct': not installed; {INSTALL_DIRECT}, or use 'auto'"


def grid_misfits(scene: Scene) -> Iterator[str]:
    """What is wrong with the grid of the IC matrix."""
    grid = scene.grid
    low, high = _extent(scene)
    if not low <= grid.extent[0] < grid.extent[1] <= high:
        start, end = grid.extent
        yield (
            f"grid: {grid.n_s} strips of {grid.ds:g} mm go from s = {start:g} to {end:g} mm, the contours "
            f"from {low:g} to {high:g} mm: give fewer (n_s) or narrower ones (ds)"
        )
    if not 0.01 <= grid.dx / grid.ds <= 100:
        yield f"grid.dx / grid.ds = {grid.dx / grid.ds:g} is outside 0.01 ... 100: bring them closer"
    around = min(np.pi * body.rolling_radius for body in scene.bodies.values())
    if 2 * grid.lags[-1] > around:
        yield f"grid: {grid.n_x} elements of {grid.dx:g} mm are more than half of half a turn ({around:g} mm)"
    of_element = {"grid.dx / 2": grid.dx / 2, "grid.ds / 2": grid.ds / 2}
    yield from _ratio_misfits(of_element, [("rotation_reach", scene.settings.rotation_reach)], scene)


def calibration_misfits(scene: Scene) -> Iterator[str]:
    """What is wrong with what effective properties are to be fitted to."""
    calibration, extent = scene.calibration, _extent(scene)
    if not calibration.x_min < calibration.x_max:
        yield "calibration.x_min, x_max: the furthest points must be further than the nearest"
    for line in calibration.lines:
        yield from _misfits_of_line(f"calibration ({line.name})", line, scene.bodies, extent)
        if line.along == "s" and line.x[0] <= calibration.x_min:
            yield f"calibration.x ({line.name}): not beyond x_min = {calibration.x_min:g} mm: move it away"
    if len({line.name for line in calibration.lines}) < len(calibration.lines):
        yield "calibration.s, calibration.x: two of the lines are the same: remove one"
    size = min(min(body.domain.far_radius, np.pi * body.rolling_radius) for body in scene.bodies.values())
    furthest = max(float(np.max(np.hypot(line.x, line.s))) for line in calibration.lines)
    if 2 * furthest > size:
        yield f"calibration.x_max: points {furthest:g} mm away, more than half of {size:g} mm: reduce it"
    of_patch = {"patch.a": scene.patch.a, "patch.b": scene.patch.b}
    reaches = [_reach(line, scene.patch.s) for line in calibration.lines]
    yield from _ratio_misfits(of_patch, [(f"calibration ({name})", r) for name, r in reaches], scene)
    if calibration.curvature_apart and "combined" not in calibration.bodies:
        yield "calibration.curvature = 'apart': only of the combined bodies; leave it out"
    missing = [name for name in calibration.bodies if name not in scene.compared]
    if missing:
        yield f"calibration.bodies: {', '.join(missing)} not in bodies = {', '.join(scene.compared)}: add it"


def _extent(scene: Scene) -> tuple[float, float]:
    """As far as both contours go [mm]."""
    starts, ends = zip(*(body.contour.extent for body in scene.bodies.values()), strict=True)
    return max(starts), min(ends)


def _patch_misfits(scene: Scene, extent: tuple[float, float], size: float, far: str) -> Iterator[str]:
    patch, smallest = scene.patch, scene.first_cells.smallest
    ends = f"the contours go from s = {extent[0]:g} to {extent[1]:g} mm"
    if not extent[0] <= patch.s - patch.b < patch.s + patch.b <= extent[1]:
        yield f"patch.s = {patch.s:g}, patch.b = {patch.b:g}: the patch reaches beyond the contour; {ends}"
    if 10 * max(patch.a, patch.b) > size / 2:
        yield f"patch.a = {patch.a:g}, patch.b = {patch.b:g}: each at most a tenth of {far}"
    if 2 * abs(patch.s) > size:
        yield f"patch.s = {patch.s:g}: beyond {far}"
    side = scene.settings.engine.least_side(patch)
    if smallest > side:
        yield f"engine.smallest_cell = {smallest:g}: at most {side:g}, half a side of the patch"
    for name in ("rotation_reach", *(["moment_arm"] if patch.s else [])):
        reach = getattr(scene.settings, name)
        if not extent[0] <= -reach < reach <= extent[1]:
            yield f"{name} = {reach:g}: beyond the contour; {ends}: give a smaller one"
        if 2 * reach > size:
            yield f"{name} = {reach:g}: at most {far}"
    if patch.s:
        yield from _moment_misfits(scene, extent, size, far)


def _moment_misfits(scene: Scene, extent: tuple[float, float], size: float, far: str) -> Iterator[str]:
    arm, reach, b = scene.settings.moment_arm, scene.settings.rotation_reach, scene.patch.b
    if 2 * (arm + reach) > size:
        yield f"moment_arm + rotation_reach = {arm + reach:g}: at most {far}"
    beside = min(reach, extent[1] - arm, -extent[0] - arm)
    if beside < CLEAR_OF_PATCH * b:
        yield (
            f"moment_arm = {arm:g}: displacements are compared {beside:.3g} mm beside a load there, as far "
            f"as the contour goes; at least {CLEAR_OF_PATCH:g} patch.b = {CLEAR_OF_PATCH * b:g} mm are "
            "needed: give a smaller moment_arm, a longer contour or a smaller patch"
        )


def _line_misfits(scene: Scene, extent: tuple[float, float], size: float, far: str) -> Iterator[str]:
    for k, line in enumerate(scene.lines):
        yield from _misfits_of_line(f"lines.{k} ({line.name})", line, scene.bodies, extent)
        if 2 * max(np.max(np.abs(line.x)), np.max(np.abs(line.s))) > size:
            yield f"lines.{k} ({line.name}): reaches beyond {far}: shorten it or enlarge both"
    if len({line.name for line in scene.lines}) < len(scene.lines):
        yield "lines: two of them are the same line: remove one"


def _ratio_misfits(
    sides: Mapping[str, float], reaches: Iterable[tuple[str, float]], scene: Scene
) -> Iterator[str]:
    """What is too large for a loaded element [mm]: cells and wavenumbers would go over too many decades.

    `sides`: its half-sides; `reaches`: how far from the load displacements are read. By name.
    """
    name, side = min(sides.items(), key=lambda one: one[1])
    least = f"{name} = {side:g}, the least half-side of the loaded element"
    engine = scene.settings.engine
    most = engine.limits.distance * side
    for label, reach in reaches:
        if reach > most * (1 + ROUNDING):
            yield (
                f"{label}: reaches {reach:g} mm, {reach / side:.3g} times {least}; at most {most / side:g} "
                f"times by engine.kind = {engine.name!r}: shorten it to {most:g} mm, or enlarge the element"
            )
    far_radius = max(body.domain.far_radius for body in scene.bodies.values())
    if far_radius > LARGEST * side * (1 + ROUNDING):
        yield (
            f"engine.far_radius = {far_radius:g}: {far_radius / side:.3g} times {least}; at most {LARGEST:g} "
            "times: give a smaller one, or enlarge the element"
        )


def _reach(line: OffsetLine, s: float) -> tuple[str, float]:
    """A line's name, and its furthest point from a load at s [mm]."""
    return line.name, float(np.max(np.hypot(line.x, line.s - s)))


def _misfits_of_line(
    label: str, line: OffsetLine, bodies: Mapping[str, Body], extent: tuple[float, float]
) -> Iterator[str]:
    if np.min(line.s) < extent[0] or np.max(line.s) > extent[1]:
        yield f"{label}: beyond the contour, s = {extent[0]:g} to {extent[1]:g} mm"
        return
    for name, body in bodies.items():
        if np.any(2 * body.side * body.contour.position(line.s)[1] > body.depth):
            yield (
                f"{label}: reaches beyond half the height of the hub of the {name} body "
                f"({body.depth / 2:g} mm): shorten it, or enlarge {name}.rolling_radius"
            )


def _limit_misfits(scene: Scene) -> Iterator[str]:
    """What only another engine can do; what none can, the limits of the keys themselves say."""
    engine, patch = scene.settings.engine, scene.patch
    limits = engine.limits
    for name, body in scene.bodies.items():
        nu, radius = body.material.nu, body.rolling_radius
        if nu > limits.nu:
            others = _others(engine, [other for other in ENGINES.values() if other.limits.nu >= nu])
            yield f"{name}.nu = {nu:g}: {others} above {limits.nu:g}, or give a smaller one"
        if radius < limits.rolling_radius:
            able = [other for other in ENGINES.values() if other.limits.rolling_radius <= radius]
            others = _others(engine, able)
            yield (
                f"{name}.rolling_radius = {radius:g}: {others} below {limits.rolling_radius:g}, or give a "
                "larger one"
            )
    aspect = patch.a / patch.b
    if not 1 / limits.aspect * (1 - ROUNDING) <= aspect <= limits.aspect * (1 + ROUNDING):
        longer = max(aspect, 1 / aspect) * (1 - ROUNDING)
        others = _others(engine, [other for other in ENGINES.values() if other.limits.aspect >= longer])
        yield (
            f"patch.a / patch.b = {aspect:g}: {others} outside {1 / limits.aspect:g} ... {limits.aspect:g}, "
            "or bring a and b closer"
        )


def _others(engine: Engine, able: Iterable[Engine]) -> str:
    """Which other engines are able, as a remedy."""
    names = [repr(other.name) for other in able if other is not engine]
    return f"use engine.kind = {' or '.join(names)} (without check)" if names else "no engine goes"


def _body_misfits(name: str, body: Body, most: float) -> Iterator[str]:
    contour = body.contour
    steepest = np.degrees(np.max(np.abs(contour.inclination(np.linspace(*contour.limits, 1001)))))
    if steepest > most * (1 + ROUNDING):
        yield f"{name}.contour: inclined up to {steepest:.1f} degrees; at most {most}: cut it there"
