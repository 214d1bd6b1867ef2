"""Warnings about scenes that can be computed but may not mean what their author intends."""

from collections.abc import Iterator

import numpy as np

from femic.reference.engines import SOLID
from femic.scenes.scene import Scene
from geometries.bodies import Body

LARGE_RADIUS = 10  # radius over patch.b from which flat elements are accurate to about 1 %
CLEAR = 3  # least number of patches between a patch and an end of its contour
THIN_WEDGE = 40  # degrees of material between the flanks below which a body is slender
HUB_PROBLEM = 300  # mm of rolling radius below which the hub shapes the result (docs/theory/reference.md)
LARGE_ROLLING_RADIUS = 20  # over the longest line along x, from which the surface hardly turns along it
DOMAIN_OVER_LINE = 6  # size of the domain over reach of a line from which truncation is below about 1 %
STIFFEST = 2e6  # MPa; diamond has 1.2e6
NEARLY_INCOMPRESSIBLE = 0.45  # Poisson's ratio
UNLIKE_MODULI = 1e3  # ratio of the moduli beyond which only the softer body counts
CONFORMAL = 10  # largest angle between conformal contours at equal s [degrees]
SLENDER = 4  # aspect of a patch beyond which the estimate on it is least reliable


def warnings(scene: Scene) -> list[str]:
    """Return what a user should know before trusting the ICs of a scene, one sentence each.

    There is none about bodies that the scene does not compare: they are neither solved nor approximated.
    """
    per_body = [
        text
        for name in scene.solved
        for of_body in (_patch_warnings, _body_warnings, _turning_warnings)
        for text in of_body(scene, name, scene.bodies[name])
    ]
    of_pair = _moduli_warnings, _pairing_warnings
    both = [text for of in of_pair for text in of(scene) if "combined" in scene.compared]
    return [*per_body, *_domain_warnings(scene), *both]


def pair_warnings(scene: Scene) -> list[str]:
    """Return the same of contacts and IC matrices, which use neither the patch nor the lines of a scene."""
    per_body = [text for name, body in scene.bodies.items() for text in _body_warnings(scene, name, body)]
    return [*per_body, *_moduli_warnings(scene)]


def modulus_warnings(E: float, of: str = "") -> Iterator[str]:
    """Yield what a Young's modulus [MPa] that no material has may mean; `of` goes before its key."""
    if E > STIFFEST:
        yield (
            f"{of}E = {E:g}: no material is this stiff (diamond: 1.2e6 MPa), so the body is practically "
            "rigid. E is in MPa: 210e3 for steel, not 210e9"
        )


def _patch_warnings(scene: Scene, name: str, body: Body) -> Iterator[str]:
    patch, contour = scene.patch, body.contour
    patch_size = max(patch.a, patch.b)
    s = patch.s + np.linspace(-patch.b, patch.b, 201)
    curvature = np.abs(np.gradient(contour.inclination(s), s)).max()
    if curvature * patch.b * LARGE_RADIUS > 1:
        yield (
            f"{name}.contour: radius {1 / curvature:.3g} mm at the patch, {1 / curvature / patch.b:.2g} "
            f"times patch.b = {patch.b:g}: the elements are not nearly flat, so A and the B family are "
            "inaccurate"
        )
    for end in contour.extent:
        if abs(end - patch.s) < patch.b + 2 * CLEAR * patch_size:
            yield (
                f"patch.s = {patch.s:g}: {abs(end - patch.s) - patch.b:.3g} mm from the end of "
                f"{name}.contour; the straight continuation there influences C"
            )
    for joint in contour.joints:
        if abs(joint - patch.s) < patch.b and joint not in contour.extent:
            yield (
                f"patch.s = {patch.s:g}: the patch lies on the joint of arc and flank of {name}.contour "
                f"(s = {joint:.4g} mm), where the curvature jumps"
            )


def _body_warnings(_: Scene, name: str, body: Body) -> Iterator[str]:
    contour = body.contour
    yield from modulus_warnings(body.material.E, f"{name}.")
    if body.material.nu > NEARLY_INCOMPRESSIBLE:
        yield (
            f"{name}.nu = {body.material.nu:g}: nearly incompressible. xn and sn nearly vanish, and C "
            "needs smaller cells for the same accuracy (solid engine: also two to four times as many "
            "iterations)"
        )
    left, right = contour.inclination(np.array(contour.limits))
    wedge = 180 + body.side * np.degrees(right - left)
    if wedge < THIN_WEDGE and body.outline is None:
        yield (
            f"{name}.contour: {wedge:.0f} degrees of material between the flanks. The body is slender, and "
            "its bending remains in C after the rigid motion is subtracted"
        )
    is_round = np.isfinite(body.rolling_radius)
    if is_round and body.outline is None and body.reaches_hub and body.rolling_radius < HUB_PROBLEM:
        yield (
            f"{name}.rolling_radius = {body.rolling_radius:g}: below {HUB_PROBLEM} mm the hub (radius "
            f"{body.rolling_radius - body.depth:g} mm, clamped) influences the result"
        )


def _turning_warnings(scene: Scene, name: str, body: Body) -> Iterator[str]:
    reach = max(np.max(np.abs(line.x)) for line in scene.lines)
    if body.rolling_radius < LARGE_ROLLING_RADIUS * reach:
        yield (
            f"{name}.rolling_radius = {body.rolling_radius:g}: {body.rolling_radius / reach:.2g} times the "
            f"longest line along x ({reach:g} mm): at its end the surface has turned by "
            f"{np.degrees(reach / body.rolling_radius):.1f} degrees, which A and the B family ignore"
        )


def _domain_warnings(scene: Scene) -> Iterator[str]:
    if scene.bodies["lower"].outline is not None:
        return
    domain = scene.bodies["lower"].domain
    domain_size = min(domain.far_radius, domain.half_length)
    for line in scene.lines:
        reach = max(np.max(np.abs(line.x)), np.max(np.abs(line.s)))
        if reach * DOMAIN_OVER_LINE > domain_size:
            what = (
                "truncation errors grow"
                if scene.bodies["lower"].truncated
                else ("the effect of the supports grows")
            )
            yield (
                f"line {line.name}: reaches {reach:g} mm, {reach / domain_size:.0%} of the domain "
                f"({domain_size:g} mm); {what} like the square of that: enlarge "
                "engine.far_radius (solid engine: half_length, too)"
            )
    aspect = max(scene.patch.a / scene.patch.b, scene.patch.b / scene.patch.a)
    lines_through_patch = [
        line.name
        for line in scene.lines
        if line.along == "x" and abs(line.s[0] - scene.patch.s) < scene.patch.b
    ]
    if scene.settings.engine is SOLID and aspect > SLENDER and lines_through_patch:
        yield (
            f"patch of aspect {aspect:.3g}: on the line {lines_through_patch[0]}, which passes through the "
            "patch, the error next to the load can be twice the estimated error"
        )


def _moduli_warnings(scene: Scene) -> Iterator[str]:
    ratio = scene.bodies["upper"].material.E / scene.bodies["lower"].material.E
    if not 1 / UNLIKE_MODULI < ratio < UNLIKE_MODULI:
        softer = "lower" if ratio > 1 else "upper"
        yield (
            f"upper.E / lower.E = {ratio:.3g}: the combined ICs are practically those of the {softer} body"
        )


def _pairing_warnings(scene: Scene) -> Iterator[str]:
    lower, upper = (scene.bodies[name] for name in ("lower", "upper"))
    s = np.concatenate([line.s for line in scene.lines])
    angles = np.degrees(np.abs(upper.contour.inclination(s) - lower.contour.inclination(s)))
    if np.max(angles) > CONFORMAL:
        yield (
            f"the contours differ by {np.max(angles):.1f} degrees at s = {s[np.argmax(angles)]:.3g} mm. "
            "Combined ICs pair points of equal s, and these points do not lie opposite each other there"
        )
