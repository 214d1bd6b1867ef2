"""Whether a contact can have a solution, before anything is solved: why it has none, and the remedy."""

from collections.abc import Iterator, Sequence

import numpy as np

from femic.contact.exact.hertz import combined_modulus
from femic.contact.motions import find_motion
from femic.contact.operators.approximations import approximate_operator
from femic.contact.pairs.grids import Sizing, distances_nearby
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.specification import ContactProblem, Scattered
from femic.contact.undeformed import SAMPLES
from geometries.errors import WrongInput
from geometries.patches import Grid

PLACES = 9  # at which distances are the same where bodies touch all over,
ALIKE = 1e-9  # to this share of the reach


def impossible(problem: ContactProblem) -> Iterator[str]:
    """Yield why the contact of a scene has no solution, as far as it is known without one."""
    specification = problem.specification
    if np.isfinite(rolling_radius := problem.bodies["lower"].rolling_radius):
        yield (
            f"lower.rolling_radius = {rolling_radius:g}: in contact the lower body must be prismatic; "
            "leave this key out, or exchange the bodies"
        )
        return
    if np.isinf(problem.bodies["upper"].rolling_radius) and not isinstance(
        specification.extra_gap, Scattered
    ):
        yield (
            "upper.rolling_radius = inf: two prismatic bodies touch along their whole length, and femic "
            "does not solve plane-strain contact; give upper.rolling_radius, such as 1e5 mm, or a "
            "contact.extra_gap over x and s that limits the contact"
        )
        return
    sizing = Sizing(pair_on_grid(problem, problem.grid), specification.elements)
    misfits = [
        *_place_misfits(sizing),
        *_size_misfits(problem, sizing),
        *_lateral_force_misfits(problem, sizing),
    ]
    yield from misfits
    if not misfits:
        yield from find_motion(specification).misfits(problem, sizing)


def without_operator(problem: ContactProblem, variants: Sequence[str]) -> Iterator[str]:
    """Yield which approximations have no operator: a few elements show it."""
    few = Grid(2, 2, problem.grid.dx, problem.grid.ds, problem.grid.s)
    for variant in variants:
        try:
            approximate_operator(variant, problem.pair, few)
        except WrongInput as refusal:
            yield f"contact.ics: {refusal}: leave it out"


def _place_misfits(sizing: Sizing) -> Iterator[str]:
    """Yield why bodies do not touch at one place between the ends of both contours."""
    (start, end), undeformed = sizing.extent, sizing.bodies.undeformed
    step, nearby = distances_nearby(sizing.bodies)
    s, shift, width = undeformed.touching[0], f"contact.shift = {undeformed.shift:g}", end - start
    if abs(undeformed.shift) > width:
        yield f"{shift}: more than the {width:g} mm over which the bodies may touch; give a smaller shift"
    elif sizing.bodies.extra_gap is not None:
        return
    elif np.ptp(undeformed.distance(0.0, np.linspace(start, end, PLACES))) < ALIKE * width:
        yield (
            "lower.contour, upper.contour: the bodies touch everywhere, from one end of the contours to "
            "the other; give contours of different shape"
        )
    elif min(s - start, end - s) < step or not np.all(np.isfinite(nearby)):
        yield (
            f"{shift}: the bodies touch first at the end of a contour, s = {s:g} of {start:g} ... {end:g} "
            "mm: give another shift, or contours that fit into each other"
        )


def _size_misfits(problem: ContactProblem, sizing: Sizing) -> Iterator[str]:
    """Yield which loads and approaches are enormous: strains would be larger than 1."""
    width = sizing.extent[1] - sizing.extent[0]
    modulus = combined_modulus(*(problem.bodies[name].material for name in ("upper", "lower")))
    largest_load, specification = modulus * width**2, problem.specification
    reach = f"the bodies may touch over {width:.3g} mm across"
    for number, load in enumerate(specification.loads):
        if load > largest_load:
            yield (
                f"contact.loads.{number} = {load:g}: strains would be larger than 1: {reach}, and with E* = "
                f"{modulus:.3g} MPa that square bears {largest_load:.3g} N: give a smaller load, or larger E"
            )
    for number, approach in enumerate(specification.approaches):
        if approach > width:
            yield (
                f"contact.approaches.{number} = {approach:g}: strains would exceed 1 ({reach}); give a "
                "smaller approach"
            )


def _lateral_force_misfits(problem: ContactProblem, sizing: Sizing) -> Iterator[str]:
    """Yield which lateral force no pressures have: on the steepest flank it is the largest."""
    specification, contour = problem.specification, problem.bodies["lower"].contour
    if specification.lateral_force is None:
        return
    steepest = float(np.max(np.abs(contour.inclination(np.linspace(*sizing.extent, SAMPLES)))))
    for load in specification.loads:
        if abs(specification.lateral_force) > (largest := load * np.tan(steepest)):
            yield (
                f"contact.lateral_force = {specification.lateral_force:g}: without friction it is at most "
                f"{largest:.4g} N at {load:g} N, the load times the tangent of the steepest inclination: "
                "give a smaller one"
            )
