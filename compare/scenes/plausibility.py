"""Scenes that can be computed but may not mean what their author thinks: warnings with numbers."""

from collections.abc import Iterator

import numpy as np

from compare.scenes.scene import Scene
from femic.solid.record import SOLID
from geometries.bodies import Body

LARGE_RADIUS = 10  # times the patch: flat elements are then good to about 1 %
CLEAR = 3  # patches between a patch and an end or a joint of its contour
THIN_WEDGE = 40  # degrees of material between the flanks
HUB_PROBLEM = 300  # mm of rolling radius below which the hub shapes the result (design section 4)
LARGE_ROLLING_RADIUS = 20  # times the longest line along x
FAR = 6  # times the longest line: beyond it truncation is below about 1 %
NEARLY_INCOMPRESSIBLE = 0.45
UNLIKE = 1e3  # ratio of the moduli
CONFORMAL = 10  # degrees between the two contours at equal s
SLENDER = 4  # of a patch; on it the estimate is least reliable


def warnings(scene: Scene) -> list[str]:
    """What a user should know before trusting the results of a scene, one sentence each.

    Bodies that are neither solved nor approximated, since the scene does not compare them, give none.
    """
    per_body = [text for name in scene.solved for text in _of_body(scene, name, scene.bodies[name])]
    return [*per_body, *_of_domain(scene), *_of_pair(scene)]


def _of_body(scene: Scene, name: str, body: Body) -> Iterator[str]:
    yield from _of_contour(scene, name, body)
    yield from _of_shape(scene, name, body)
    if body.material.nu > NEARLY_INCOMPRESSIBLE:
        yield (
            f"{name}.nu = {body.material.nu:g}: nearly incompressible; xn and sn nearly vanish, and C takes "
            "smaller cells (solid engine: and two to four times the iterations) for the same accuracy"
        )


def _of_contour(scene: Scene, name: str, body: Body) -> Iterator[str]:
    patch, contour = scene.patch, body.contour
    size = max(patch.a, patch.b)
    s = patch.s + np.linspace(-patch.b, patch.b, 201)
    curvature = np.abs(np.gradient(contour.inclination(s), s)).max()
    if curvature * patch.b * LARGE_RADIUS > 1:
        yield (
            f"{name}.contour: radius {1 / curvature:.3g} mm at the patch, {1 / curvature / patch.b:.2g} "
            f"times patch.b = {patch.b:g}: its elements are not nearly flat, so A and the B family cannot be "
            "accurate"
        )
    for end in contour.extent:
        if abs(end - patch.s) < patch.b + 2 * CLEAR * size:
            yield (
                f"patch.s = {patch.s:g}: {abs(end - patch.s) - patch.b:.3g} mm from the end of "
                f"{name}.contour, whose continuation by its tangent then shapes C"
            )
    for joint in contour.joints:
        if abs(joint - patch.s) < patch.b and joint not in contour.extent:
            yield (
                f"patch.s = {patch.s:g}: the patch lies on the joint of arc and flank of {name}.contour "
                f"(s = {joint:.4g} mm), where the curvature jumps"
            )


def _of_shape(scene: Scene, name: str, body: Body) -> Iterator[str]:
    left, right = body.contour.inclination(np.array(body.contour.limits))
    wedge = 180 + body.side * np.degrees(right - left)
    if wedge < THIN_WEDGE:
        yield (
            f"{name}.contour: {wedge:.0f} degrees of material between the flanks: a slender body, whose "
            "bending is part of C beyond the rigid motion that is discounted"
        )
    if np.isinf(body.rolling_radius):
        return
    reach = max(np.max(np.abs(line.x)) for line in scene.lines)
    if body.reaches_hub and body.rolling_radius < HUB_PROBLEM:
        yield (
            f"{name}.rolling_radius = {body.rolling_radius:g}: below {HUB_PROBLEM} mm the hub (radius "
            f"{body.rolling_radius - body.depth:g} mm, clamped) is part of the answer"
        )
    if body.rolling_radius < LARGE_ROLLING_RADIUS * reach:
        yield (
            f"{name}.rolling_radius = {body.rolling_radius:g}: {body.rolling_radius / reach:.2g} times the "
            f"longest line along x ({reach:g} mm): at its end the surface has turned by "
            f"{np.degrees(reach / body.rolling_radius):.1f} degrees, which A and the B family leave out"
        )


def _of_domain(scene: Scene) -> Iterator[str]:
    domain = scene.bodies["lower"].domain
    size = min(domain.far_radius, domain.half_length)
    for line in scene.lines:
        reach = max(np.max(np.abs(line.x)), np.max(np.abs(line.s)))
        if reach * FAR > size:
            yield (
                f"line {line.name}: reaches {reach:g} mm, {reach / size:.0%} of the domain ({size:g} mm); "
                "truncation errors grow like the square of that: enlarge engine.far_radius (solid engine: "
                "half_length, too)"
            )
    aspect = max(scene.patch.a / scene.patch.b, scene.patch.b / scene.patch.a)
    through = [
        line.name
        for line in scene.lines
        if line.along == "x" and abs(line.s[0] - scene.patch.s) < scene.patch.b
    ]
    if scene.settings.engine is SOLID and aspect > SLENDER and through:
        yield (
            f"patch of aspect {aspect:.3g}: on the line {through[0]}, which runs through it, the error next "
            "to the load can be twice the estimate"
        )


def _of_pair(scene: Scene) -> Iterator[str]:
    lower, upper = (scene.bodies[name] for name in ("lower", "upper"))
    ratio = upper.material.E / lower.material.E
    if "combined" not in scene.compared:
        return
    if not 1 / UNLIKE < ratio < UNLIKE:
        soft = "lower" if ratio > 1 else "upper"
        yield f"upper.E / lower.E = {ratio:.3g}: the combined ICs are those of the {soft} body alone"
    s = np.concatenate([line.s for line in scene.lines])
    apart = np.degrees(np.abs(upper.contour.inclination(s) - lower.contour.inclination(s)))
    if np.max(apart) > CONFORMAL:
        yield (
            f"the contours differ by {np.max(apart):.1f} degrees at s = {s[np.argmax(apart)]:.3g} mm: "
            "combined ICs join points of equal s, which do not lie opposite each other there"
        )
