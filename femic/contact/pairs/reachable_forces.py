"""Whether creepages reach the force at which ICs are compared, as far as it is known before."""

from collections.abc import Iterator

import numpy as np

from femic.contact.exact.creepage_coefficients import WIDEST, creepage_coefficients
from femic.contact.friction.by_angle import largest_factor
from femic.contact.loading import Loading
from femic.contact.pairs.first_touch import hertz
from femic.contact.pairs.sizing import Sizing
from femic.contact.specification import CREEPAGES, ContactProblem, FrictionSpecification

BEYOND = 3.0  # times the force without slip from which no curve reaches a force: patches are no ellipses


def forces_beyond_creepages(problem: ContactProblem, sizing: Sizing) -> Iterator[str]:
    """Yield with which friction the force at which ICs are compared is beyond all creepages.

    It need not be within those of the scene: it is found up to the default ones at least. Without slip forces
    are the largest. They are Kalker's, of the ellipse of Hertz, which is larger than the patch of bodies that
    fit each other; circles of other radii beside the crown add to the creepage.
    """
    friction = problem.specification.friction
    if friction is None or problem.specification.extra_gap is not None:
        return
    yield from _beyond_factors(friction)
    (load,) = problem.specification.loads
    ellipse, combined = hertz(sizing.bodies, Loading(load)), problem.pair.constants
    G, nu = float(combined.G), float(combined.nu)
    b = float(np.clip(ellipse.b, ellipse.a / WIDEST, ellipse.a * WIDEST))
    coefficients = creepage_coefficients(ellipse.a, b, nu)
    creepage = max(*map(abs, friction.longitudinal), *CREEPAGES)
    rise = np.ptp(problem.bodies["lower"].contour.position(np.array([-1.0, 0.0, 1.0]) * ellipse.b)[1])
    beside = float(rise) / problem.bodies["upper"].rolling_radius
    reached, _, _ = coefficients.forces(G, creepage + abs(friction.lateral) + beside, 0.0, 0.0)
    for number, coefficient in enumerate(friction.coefficients):
        force = abs(friction.equal_force) * coefficient * load
        if force > BEYOND * reached:
            yield (
                f"contact.friction.{number} = {coefficient:g}: tractions are compared at F_x = equal_force "
                f"friction load = {force:.3g} N, and creepages to {creepage:g} give about {reached:.2g} N "
                "even without slip: give larger ones in contact.longitudinal, less friction, or a smaller "
                "equal_force"
            )


def _beyond_factors(friction: FrictionSpecification) -> Iterator[str]:
    """Yield whether friction that depends on the contact angle is too small for the force everywhere."""
    largest = largest_factor(friction.friction_by_angle)
    if abs(friction.equal_force) > BEYOND * largest:
        yield (
            f"contact.equal_force = {friction.equal_force:g}: tractions are compared at F_x = equal_force "
            f"friction load, and the factors of friction_by_angle are at most {largest:g}: give a smaller "
            "equal_force, or larger factors"
        )
