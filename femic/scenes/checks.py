"""Checks that the parts of a scene fit together; each misfit is a line with field, value and remedy."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from femic.reference.engine import Engine
from femic.reference.engines import ENGINES, kinds_that
from femic.reference.solid.pardiso import available as direct_available
from femic.scenes.scene import Scene
from geometries.bodies import Body
from geometries.patches import OffsetLine

LIMIT_SLACK = 1e-9  # share by which rounding may exceed a limit
CLEAR_OF_PATCH = 6  # least distance of displacements compared beside a moment load, in half-widths patch.b
GAPS_IN_LENGTH = 10  # reference lengths over the largest gap that raises a surface
LARGEST_FAR_RADIUS = 5e6  # in half-sides of the loaded element
INSTALL_DIRECT = "run .venv/bin/pip install -c constraints.txt -e '.[direct]'"


def misfits(scene: Scene) -> Iterator[str]:
    """Yield what does not fit between the tables of a scene."""
    limits, domain = scene.settings.engine.limits, scene.bodies["lower"].domain
    domain_size = min(domain.far_radius, domain.half_length, _half_turn(scene))
    or_half_length = ", engine.half_length" if np.isfinite(domain.half_length) else ""
    half_domain = (
        f"half of the least of engine.far_radius{or_half_length} and half a turn ({domain_size / 2:g} mm)"
    )
    yield from _patch_misfits(scene, domain_size, half_domain)
    yield from _line_misfits(scene, domain_size, half_domain)
    reaches = [(f"lines.{k} ({line.name})", _reach(line, scene)) for k, line in enumerate(scene.lines)]
    reaches.append(("rotation_reach", scene.settings.rotation_reach))
    yield from _ratio_misfits(_half_sides(scene), reaches, scene)
    for name, body in scene.bodies.items():
        yield from _body_misfits(name, body, limits.inclination)
    yield from _limit_misfits(scene)
    yield from _gap_misfits(scene)
    yield from _friction_misfits(scene)
    if "Bhat_prime" in scene.variants and not scene.fitted:
        yield (
            "variants: Bhat_prime needs effective properties of what is compared: add a table "
            "[effective.combined.mismatch_k] with far, r_inf, m, n (or of lower, upper; of G, nu)"
        )
    if scene.ics == "Bhat_prime" and not scene.fitted:
        yield "ics = 'Bhat_prime': the scene has no effective properties; femic calibrate finds some"
    if scene.fields and not scene.settings.engine.fields:
        yield f"fields = true: only {kinds_that(lambda engine: engine.fields)} has fields in 3D"
    if scene.settings.solver == "direct" and not direct_available():
        yield f"engine.solver = 'direct': not installed; {INSTALL_DIRECT}, or use 'auto'"


def _gap_misfits(scene: Scene) -> Iterator[str]:
    """Yield what is wrong with the extra gap: it has to be small beside the bodies where it raises them."""
    gap, limit = scene.contact.extra_gap, scene.reference_length / GAPS_IN_LENGTH
    if gap is not None and (least := float(np.min(gap.gap))) < -limit * (1 + LIMIT_SLACK):
        yield (
            f"contact.extra_gap: {least:g} mm raises the surface along its normals by more than "
            f"{1 / GAPS_IN_LENGTH:.0%} of reference_length, {limit:g} mm: add a constant to all gaps, or "
            "change the contours"
        )


def _friction_misfits(scene: Scene) -> Iterator[str]:
    """Yield what is wrong with the bodies and loads of a contact with friction."""
    wanted, motion = scene.contact, scene.contact.motion
    if motion == "none":
        return
    if not wanted.loads:
        yield f"contact.loads = []: motion = {motion!r} needs a load: give loads = [...] in N"
    if motion != "rolling":
        return
    if len(wanted.loads) > 1:
        yield (
            f"contact.loads = {list(wanted.loads)}: motion = 'rolling' has one load: give one, and a scene "
            "each for others"
        )
    if np.isinf(scene.bodies["upper"].rolling_radius):
        yield (
            "upper.rolling_radius = inf: motion = 'rolling' needs a wheel: give upper.rolling_radius in mm, "
            "or motion = 'compression'"
        )


def grid_misfits(scene: Scene) -> Iterator[str]:
    """Yield what is wrong with the grid of the IC matrix."""
    grid = scene.grid
    low, high = scene.extent
    if not low <= grid.extent[0] < grid.extent[1] <= high:
        start, end = grid.extent
        yield (
            f"grid: {grid.n_s} strips of {grid.ds:g} mm go from s = {start:g} to {end:g} mm, the contours "
            f"from {low:g} to {high:g} mm: give fewer (n_s) or narrower ones (ds)"
        )
    if not 0.01 <= grid.dx / grid.ds <= 100:
        yield f"grid.dx / grid.ds = {grid.dx / grid.ds:g} is outside 0.01 ... 100: bring them closer"
    if 2 * grid.lags[-1] > (half_turn := _half_turn(scene)):
        yield (
            f"grid: {grid.n_x} elements of {grid.dx:g} mm are more than half of half a turn "
            f"({half_turn:g} mm)"
        )
    half_sides = {"grid.dx / 2": grid.dx / 2, "grid.ds / 2": grid.ds / 2}
    yield from _ratio_misfits(half_sides, [("rotation_reach", scene.settings.rotation_reach)], scene)


def matrix_engine_misfits(scene: Scene) -> Iterator[str]:
    """Yield the misfit of an engine that has no IC matrices, and so no C for contact."""
    engine = scene.settings.engine
    if engine.matrices is None:
        yield (
            f"engine.kind = {engine.name!r}: has no C on a grid, as matrices and contact need it: use "
            f"{kinds_that(lambda other: other.matrices)} (grid.check compares columns of a matrix with the "
            "solid engine)"
        )


def calibration_misfits(scene: Scene) -> Iterator[str]:
    """Yield what is wrong with the points and components that effective properties are fitted to."""
    calibration, extent = scene.calibration, scene.extent
    if not calibration.x_min < calibration.x_max:
        yield "calibration.x_min, x_max: the furthest points must be further than the nearest"
    for line in calibration.lines:
        yield from _misfits_of_line(f"calibration ({line.name})", line, scene.bodies, extent)
        if line.along == "s" and line.x[0] <= calibration.x_min:
            yield f"calibration.x ({line.name}): not beyond x_min = {calibration.x_min:g} mm: move it away"
    if len({line.name for line in calibration.lines}) < len(calibration.lines):
        yield "calibration.s, calibration.x: two of the lines are the same: remove one"
    domain_size = min(_half_turn(scene), *(body.domain.far_radius for body in scene.bodies.values()))
    furthest = max(float(np.max(np.hypot(line.x, line.s))) for line in calibration.lines)
    if 2 * furthest > domain_size:
        yield (
            f"calibration.x_max: points {furthest:g} mm away, more than half of {domain_size:g} mm: reduce it"
        )
    reaches = [(f"calibration ({line.name})", _reach(line, scene)) for line in calibration.lines]
    yield from _ratio_misfits(_half_sides(scene), reaches, scene)
    if calibration.curvature_apart and "combined" not in calibration.bodies:
        yield "calibration.curvature = 'apart': only of the combined bodies; leave it out"
    missing = [name for name in calibration.bodies if name not in scene.compared]
    if missing:
        yield f"calibration.bodies: {', '.join(missing)} not in bodies = {', '.join(scene.compared)}: add it"


def _patch_misfits(scene: Scene, domain_size: float, half_domain: str) -> Iterator[str]:
    """Yield what is wrong with the patch and the points of the discount.

    `domain_size`: least size of the domain [mm]; `half_domain`: half of it in words.
    """
    patch, smallest = scene.patch, scene.first_cells.smallest
    ends = f"the contours go from s = {scene.extent[0]:g} to {scene.extent[1]:g} mm"
    if not scene.extent[0] <= patch.s - patch.b < patch.s + patch.b <= scene.extent[1]:
        yield f"patch.s = {patch.s:g}, patch.b = {patch.b:g}: the patch reaches beyond the contour; {ends}"
    if 10 * max(patch.a, patch.b) > domain_size / 2:
        yield f"patch.a = {patch.a:g}, patch.b = {patch.b:g}: each at most a tenth of {half_domain}"
    if 2 * abs(patch.s) > domain_size:
        yield f"patch.s = {patch.s:g}: beyond {half_domain}"
    largest_cell = scene.settings.engine.least_side(patch)
    if smallest > largest_cell:
        yield f"engine.smallest_cell = {smallest:g}: at most {largest_cell:g}, half a side of the patch"
    for name in ("rotation_reach", *(["moment_arm"] if patch.s else [])):
        reach = getattr(scene.settings, name)
        if not scene.extent[0] <= -reach < reach <= scene.extent[1]:
            yield f"{name} = {reach:g}: beyond the contour; {ends}: give a smaller one"
        if 2 * reach > domain_size:
            yield f"{name} = {reach:g}: at most {half_domain}"
    if patch.s:
        yield from _moment_misfits(scene, domain_size, half_domain)


def _moment_misfits(scene: Scene, domain_size: float, half_domain: str) -> Iterator[str]:
    arm, reach, b = scene.settings.moment_arm, scene.settings.rotation_reach, scene.patch.b
    if 2 * (arm + reach) > domain_size:
        yield f"moment_arm + rotation_reach = {arm + reach:g}: at most {half_domain}"
    clearance = min(reach, scene.extent[1] - arm, -scene.extent[0] - arm)
    if clearance < CLEAR_OF_PATCH * b:
        yield (
            f"moment_arm = {arm:g}: displacements are compared {clearance:.3g} mm beside a load there, as "
            f"far as the contour goes; at least {CLEAR_OF_PATCH:g} patch.b = {CLEAR_OF_PATCH * b:g} mm are "
            "needed: give a smaller moment_arm, a longer contour or a smaller patch"
        )


def _line_misfits(scene: Scene, domain_size: float, half_domain: str) -> Iterator[str]:
    for k, line in enumerate(scene.lines):
        yield from _misfits_of_line(f"lines.{k} ({line.name})", line, scene.bodies, scene.extent)
        if 2 * max(np.max(np.abs(line.x)), np.max(np.abs(line.s))) > domain_size:
            yield f"lines.{k} ({line.name}): reaches beyond {half_domain}: shorten it or enlarge both"
    if len({line.name for line in scene.lines}) < len(scene.lines):
        yield "lines: two of them are the same line: remove one"


def _ratio_misfits(
    half_sides: Mapping[str, float], reaches: Iterable[tuple[str, float]], scene: Scene
) -> Iterator[str]:
    """Yield distances that are too large beside the loaded element.

    With them, cells and wavenumbers would span too many decades. `half_sides`: those of the element by
    name; `reaches`: how far from the load displacements are read, with a label each. All in mm.
    """
    name, side = min(half_sides.items(), key=lambda named_side: named_side[1])
    element = f"{name} = {side:g}, the least half-side of the loaded element"
    engine = scene.settings.engine
    limit = engine.limits.distance * side
    for label, reach in reaches:
        if reach > limit * (1 + LIMIT_SLACK):
            yield (
                f"{label}: reaches {reach:g} mm, {reach / side:.3g} times {element}; at most "
                f"{limit / side:g} times by engine.kind = {engine.name!r}: shorten it to {limit:g} mm, or "
                "enlarge the element"
            )
    far_radius = max(body.domain.far_radius for body in scene.bodies.values())
    if far_radius > LARGEST_FAR_RADIUS * side * (1 + LIMIT_SLACK):
        yield (
            f"engine.far_radius = {far_radius:g}: {far_radius / side:.3g} times {element}; at most "
            f"{LARGEST_FAR_RADIUS:g} times: give a smaller one, or enlarge the element"
        )


def _reach(line: OffsetLine, scene: Scene) -> float:
    """The distance of the furthest point of a line from the patch [mm]."""
    return float(np.max(np.hypot(line.x, line.s - scene.patch.s)))


def _half_sides(scene: Scene) -> dict[str, float]:
    """The half-sides of the patch [mm] by their keys."""
    return {"patch.a": scene.patch.a, "patch.b": scene.patch.b}


def _half_turn(scene: Scene) -> float:
    """Half of the shortest circumference of a rolling circle [mm]; infinite if both bodies are prismatic."""
    return min(np.pi * body.rolling_radius for body in scene.bodies.values())


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
    """Yield what only another engine can do.

    What no engine can do is excluded by the limits of the keys in `femic.scenes.file`.
    """
    limits, patch = scene.settings.engine.limits, scene.patch
    for name, body in scene.bodies.items():
        nu, radius = body.material.nu, body.rolling_radius
        if nu > limits.nu:
            remedy = _use(other for other in ENGINES.values() if other.limits.nu >= nu)
            yield f"{name}.nu = {nu:g}: {remedy} above {limits.nu:g}, or give a smaller one"
        if radius < limits.rolling_radius:
            remedy = _use(other for other in ENGINES.values() if other.limits.rolling_radius <= radius)
            yield (
                f"{name}.rolling_radius = {radius:g}: {remedy} below {limits.rolling_radius:g}, or give a "
                "larger one"
            )
    aspect = patch.a / patch.b
    elongation = max(aspect, 1 / aspect) * (1 - LIMIT_SLACK)
    if elongation > limits.aspect:
        remedy = _use(other for other in ENGINES.values() if other.limits.aspect >= elongation)
        yield (
            f"patch.a / patch.b = {aspect:g}: {remedy} outside {1 / limits.aspect:g} ... {limits.aspect:g}, "
            "or bring a and b closer"
        )


def _use(capable: Iterable[Engine]) -> str:
    """The remedy: use one of the engines that are capable of it."""
    names = [repr(engine.name) for engine in capable]
    return f"use engine.kind = {' or '.join(names)} (without check)" if names else "no engine goes"


def _body_misfits(name: str, body: Body, limit: float) -> Iterator[str]:
    contour = body.contour
    steepest = np.degrees(np.max(np.abs(contour.inclination(np.linspace(*contour.limits, 1001)))))
    if steepest > limit * (1 + LIMIT_SLACK):
        yield f"{name}.contour: inclined up to {steepest:.1f} degrees; at most {limit:g}: cut it there"
