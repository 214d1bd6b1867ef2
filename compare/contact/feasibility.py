"""What is known of a contact before anything is solved: why it has no solution, and what to do about it."""

from collections.abc import Iterator

import numpy as np

from compare.contact.automatic_grid import Sizing
from compare.contact.pair_on_grid import Case, placed_on
from femic.contact.exact.creepage_coefficients import WIDEST, creepage_coefficients
from femic.contact.exact.hertz import combined_modulus
from femic.contact.extra_gap import Scattered
from femic.contact.specification import FrictionSpecification
from femic.contact.undeformed import SAMPLES
from femic.scenes.scene import Scene

PLACES = 9  # at which distances are the same where bodies touch all over,
ALIKE = 1e-9  # to this share of the reach
BEYOND = 3.0  # times the force without slip from which no curve reaches a force: patches are no ellipses


def impossible(scene: Scene) -> Iterator[str]:
    """Yield why the contact of a scene has no solution, as far as it is known without one."""
    wanted = scene.contact
    if np.isfinite(rolling_radius := scene.bodies["lower"].rolling_radius):
        yield (
            f"lower.rolling_radius = {rolling_radius:g}: a contact has a prismatic lower body: leave it "
            "out, or exchange the bodies"
        )
        return
    if np.isinf(scene.bodies["upper"].rolling_radius) and not isinstance(wanted.extra_gap, Scattered):
        yield (
            "upper.rolling_radius = inf: two prismatic bodies touch all along x, and contact per length "
            "(plane strain) is not solved: give upper.rolling_radius, such as 1e5 mm, or a "
            "contact.extra_gap over x and s that ends the contact"
        )
        return
    sizing = Sizing(placed_on(scene, scene.grid), wanted.elements)
    misfits = [*_of_place(sizing), *_of_size(scene, sizing), *_of_lateral_force(scene, sizing)]
    yield from misfits
    if not misfits and wanted.friction and wanted.motion == "rolling" and wanted.extra_gap is None:
        yield from _of_force(scene, wanted.friction, sizing)


def _of_place(sizing: Sizing) -> Iterator[str]:
    """Yield why bodies do not touch at one place between the ends of both contours."""
    (start, end), undeformed = sizing.extent, sizing.bodies.undeformed
    s, shift, width = undeformed.touching[0], f"contact.shift = {undeformed.shift:g}", end - start
    if abs(undeformed.shift) > width:
        yield f"{shift}: more than the {width:g} mm over which the bodies may touch: give a smaller one"
    elif sizing.bodies.extra_gap is not None:
        return
    elif np.ptp(undeformed.distance(0.0, np.linspace(start, end, PLACES))) < ALIKE * width:
        yield (
            "lower.contour, upper.contour: the bodies touch all over, from one end of the contours to the "
            "other: give contours that are not alike"
        )
    elif min(s - start, end - s) < sizing.nearby[0] or not np.all(np.isfinite(sizing.nearby[1])):
        yield (
            f"{shift}: the bodies touch first at the end of a contour, s = {s:g} of {start:g} ... {end:g} "
            "mm: give another shift, or contours of which one lies in the other"
        )


def _of_size(scene: Scene, sizing: Sizing) -> Iterator[str]:
    """Yield which loads and approaches are enormous: strains would be larger than 1."""
    width = sizing.extent[1] - sizing.extent[0]
    modulus = combined_modulus(*(scene.bodies[name].material for name in ("upper", "lower")))
    bearable, wanted = modulus * width**2, scene.contact
    told = f"the bodies may touch over {width:.3g} mm across"
    for number, load in enumerate(wanted.loads):
        if load > bearable:
            yield (
                f"contact.loads.{number} = {load:g}: strains would be larger than 1: {told}, and with E* = "
                f"{modulus:.3g} MPa that square bears {bearable:.3g} N: give a smaller load, or larger E"
            )
    for number, approach in enumerate(wanted.approaches):
        if approach > width:
            yield (
                f"contact.approaches.{number} = {approach:g}: strains would be larger than 1: {told}: give a "
                "smaller approach"
            )


def _of_lateral_force(scene: Scene, sizing: Sizing) -> Iterator[str]:
    """Yield which lateral force no pressures have: on the steepest flank it is the largest."""
    wanted, contour = scene.contact, scene.bodies["lower"].contour
    if wanted.lateral_force is None:
        return
    steepest = float(np.max(np.abs(contour.inclination(np.linspace(*sizing.extent, SAMPLES)))))
    for load in wanted.loads:
        if abs(wanted.lateral_force) > (largest := load * np.tan(steepest)):
            yield (
                f"contact.lateral_force = {wanted.lateral_force:g}: without friction it is at most "
                f"{largest:.4g} N at {load:g} N, the load times the tangent of the steepest inclination: "
                "give a smaller one"
            )


def _of_force(scene: Scene, wanted: FrictionSpecification, sizing: Sizing) -> Iterator[str]:
    """Yield with which friction the forces of rolling are beyond all creepages.

    Without slip forces are the largest. They are Kalker's, of the ellipse of Hertz, which is larger than the
    patch of bodies that fit each other; circles of other radii beside the crown add to the creepage.
    """
    (load,) = scene.contact.loads
    ellipse, combined = sizing.hertz(Case(load, None)), scene.pair.constants
    G, nu = float(combined.G), float(combined.nu)
    b = float(np.clip(ellipse.b, ellipse.a / WIDEST, ellipse.a * WIDEST))
    coefficients = creepage_coefficients(ellipse.a, b, nu)
    creepage = max(map(abs, wanted.longitudinal))
    rise = np.ptp(scene.bodies["lower"].contour.position(np.array([-1.0, 0.0, 1.0]) * ellipse.b)[1])
    beside = float(rise) / scene.bodies["upper"].rolling_radius
    reached, _, _ = coefficients.forces(G, creepage + abs(wanted.lateral) + beside, 0.0, 0.0)
    for number, friction in enumerate(wanted.coefficients):
        force = abs(wanted.equal_force) * friction * load
        if force > BEYOND * reached:
            yield (
                f"contact.friction.{number} = {friction:g}: tractions are compared at F_x = equal_force "
                f"friction load = {force:.3g} N, and creepages to {creepage:g} give about {reached:.2g} N "
                "even without slip: give larger ones in contact.longitudinal, less friction, or a smaller "
                "equal_force"
            )
