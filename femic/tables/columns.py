"""Contacts at one position, under one load, with one coefficient of friction, at many creepages.

The approach is that under the load without friction, with the distance of the displaced body; it stays when
the wheel rolls with friction. So tangential tractions change pressures by elastic displacements alone, and
contacts on steep flanges have a solution at each creepage. Patches far from each other see one another's
pressures, but not what friction changes in them.

Forces are in the plane of the contact. Its normal is the direction of the resultant of pressures, at the
contact angle delta from z. Its size c is the radius of a circle of the area 9/8 (integral of p)^2 / integral
of p^2, that of an ellipse of Hertz: unlike the number of elements in contact it is a smooth function of load
and position. Linear theory for a circle (Kalker 1990; its coefficients vary little) gives the scale of
creepages: full sliding without spin at about xi_s = 3 friction N / (CREEP_COEFFICIENT G c^2), where G is the
mean modulus of both bodies.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from femic.contact.friction.motion import Creepages
from femic.contact.frictional import FrictionalContact
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs import grids
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.patch import Box
from femic.contact.rolling import RollingProblem
from femic.contact.small import is_small
from femic.contact.specification import ContactProblem
from femic.reference.run_options import RunOptions
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import N

CREEP_COEFFICIENT = 4.3  # of a circle with Poisson's ratio 0.28, mean of Kalker's C_11 and C_22
LIKE_HERTZ = 9 / 8  # (integral of p)^2 / integral of p^2 times this is the area of an ellipse of Hertz
BESIDE = 6  # strips beside a patch that is solved for itself
BEYOND = 0.999  # creepage over itself and saturation that stands for 1: 999 times that of full sliding
CONTACT = {  # of a contact without friction: unit, scale of interpolation, sign in a mirror, meaning
    "normal_force": ("N", "log", 1, "force along the contact normal"),
    "contact_angle": ("rad", "linear", -1, "contact angle: that of the resultant of pressures to z"),
    "creepage_scale": ("1", "log", 1, "creepage of full sliding over the coefficient of friction"),
    "half_size": ("mm", "log", 1, "radius of a circle of the area that Hertz's pressures would have"),
    "free_creepage": ("1", "linear", 1, "longitudinal creepage without slip along x at y, without spin"),
    "p_max": ("MPa", "log", 1, "largest pressure"),
    "approach": ("mm", "log", 1, "vertical approach"),
    "y": ("mm", "linear", -1, "lateral coordinate of the centre of pressures"),
    "z": ("mm", "linear", 1, "height of the centre of pressures"),
}
FORCES = {  # shares of a contact with friction: sign in a mirror, meaning
    "f_x": (1, "longitudinal force over friction times normal force"),
    "f_y": (-1, "lateral force in the plane of the contact over friction times normal force"),
    "f_n": (1, "force along the contact normal over that without friction"),
    "m_n": (
        -1,
        "moment about the normal through the contact centre over friction, normal force and half_size",
    ),
    "p": (1, "largest pressure over that without friction"),
    "w": (1, "work of friction over friction, normal force, saturation and 1 + creepage over saturation"),
}


class Place(NamedTuple):
    """Where and how strongly bodies are in contact: shift [mm], load [N], coefficient of friction."""

    shift: float
    load: float
    friction: float


class Slip(NamedTuple):
    """A creepage: spin over saturation, angle in turns, and magnitude m over saturation as m / (1 + m)."""

    spin: float
    turn: Fraction
    creepage: float


@dataclass(frozen=True, eq=False)
class Column:
    """Quantities of a contact without friction, by name, and shares (n, 6) at creepages."""

    contact: dict[str, float]
    shares: Array


def solve_column(
    problem: ContactProblem, place: Place, slips: Sequence[Slip], elements: int, options: RunOptions
) -> Column:
    """Return the contact of a problem of rolling, with one name of ICs, at a place and at all creepages.

    Raises Failure.
    """
    specification, friction = problem.specification, problem.specification.friction
    assert friction is not None
    specification = replace(
        specification,
        friction=replace(friction, coefficients=(place.friction,)),
        loads=(place.load,),
        shift=place.shift,
        elements=elements,
    )
    problem = replace(problem, specification=specification)

    def solve(on_grid: PairOnGrid) -> Column:
        in_motion = pair_in_motion(problem, on_grid, options)
        operator = in_motion.operator(specification.ics[0])
        pressed = on_grid.solve_in_place(operator.restricted((N,)), Loading(place.load), exact=True)
        displaced = on_grid.distance_at(pressed.approach) + pressed.approach * on_grid.cosine
        frictional = replace(in_motion.frictional(operator, place.friction), distance=displaced)
        contact = _quantities(on_grid, in_motion.rolling(frictional), pressed.p, pressed.approach)
        parts = {
            box: in_motion.rolling(part) for box, part in _patches(frictional, operator, pressed.p).items()
        }
        shares = []
        last: dict[Box, FrictionalContact | None] = dict.fromkeys(parts)
        for slip in slips:
            solved = {box: _rolls(part, place, contact, slip, last[box]) for box, part in parts.items()}
            shares.append(_shares(on_grid, contact, solved, place.friction, slip))
            last = {**solved}
        return Column(contact, np.reshape(shares, (-1, len(FORCES))))

    ((grid, _),) = grids.grids_of(problem)
    return grids.on_fitting_grid(problem, grid, solve)


def _patches(
    problem: FrictionalProblem, operator: FullOperator, pressures: Array
) -> dict[Box, FrictionalProblem]:
    """Return the parts of a problem about patches that are far from each other along s, each for itself.

    Each has the gap that the `pressures` without friction of the others open.
    """
    n_x, n_s = pressures.shape
    strips = np.flatnonzero(pressures.any(axis=0))
    groups = np.split(strips, np.flatnonzero(np.diff(strips) > 2 * BESIDE) + 1)
    if len(groups) == 1 and is_small(pressures.shape):
        return {Box.whole(pressures.shape): problem}
    parts = {}
    for group in groups:
        box = Box((0, n_x), (max(group[0] - BESIDE, 0), min(group[-1] + 1 + BESIDE, n_s)))
        others = pressures.copy()
        box.crop(others)[...] = 0.0
        opened = operator.restricted((N,))(others[..., None])[..., 0]
        part = problem.within(box)
        parts[box] = replace(part, distance=part.distance + box.crop(opened))
    return parts


def _quantities(on_grid: PairOnGrid, rolling: RollingProblem, p: Array, approach: float) -> dict[str, float]:
    """Return the quantities of a contact without friction."""
    tractions = np.stack([np.zeros_like(p), np.zeros_like(p), p], axis=-1)
    _, f_y, f_z = on_grid.resultant(tractions).force
    normal, angle = hypot(f_y, f_z), atan2(-f_y, f_z)
    along_s = p.sum(axis=0) / p.sum()
    y, z = (
        float(along_s @ place) for place in on_grid.undeformed.lower.contour.position(on_grid.grid.strips)
    )
    size = sqrt(LIKE_HERTZ * p.sum() ** 2 / np.sum(p * p) * on_grid.grid.area / pi)
    moduli = [body.material.G for body in (on_grid.pair.lower, on_grid.pair.upper)]
    modulus = 2 / sum(1 / each for each in moduli)
    kinematics = rolling.rolling
    height = float(along_s @ kinematics.height)
    return {
        "normal_force": normal,
        "contact_angle": angle,
        "creepage_scale": 3 * normal / (CREEP_COEFFICIENT * modulus * size**2),
        "half_size": size,
        "free_creepage": height / (kinematics.radius - height),
        "p_max": float(p.max()),
        "approach": approach,
        "y": y,
        "z": z,
    }


def creepages(contact: dict[str, float], friction: float, slip: Slip) -> Creepages:
    """Return the creepages of a wheel on a contact."""
    saturation, angle = friction * contact["creepage_scale"], 2 * pi * slip.turn
    share = min(slip.creepage, BEYOND)
    size = saturation * share / (1 - share)
    spin = slip.spin * saturation / contact["half_size"]
    along = contact["free_creepage"] - spin * contact["y"] + size * cos(angle)
    return Creepages(along, size * sin(angle) / cos(contact["contact_angle"]), spin)


def _rolls(
    rolling: RollingProblem,
    place: Place,
    contact: dict[str, float],
    slip: Slip,
    last: FrictionalContact | None,
) -> FrictionalContact:
    """Return the rolling contact; from the last one, or without it where that leads to none."""
    wanted = creepages(contact, place.friction, slip)
    loading = Loading(approach=contact["approach"])
    try:
        return rolling.contact(wanted, loading, start=last).contact
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        if last is not None:
            return _rolls(rolling, place, contact, slip, None)
        raise Failure(f"shift {place.shift:g} mm, {place.load:g} N, {wanted}: {failure}") from failure


def _shares(
    on_grid: PairOnGrid,
    contact: dict[str, float],
    solved: Mapping[Box, FrictionalContact],
    friction: float,
    slip: Slip,
) -> tuple[float, ...]:
    """Return the shares of a contact in rolling, in the order of FORCES."""
    shape = on_grid.distance.shape
    tractions = np.sum([box.embed(part.tractions, shape) for box, part in solved.items()], axis=0)
    total = on_grid.resultant(tractions)
    (f_x, f_y, f_z), (_, m_y, m_z) = total.force, total.moment
    sine, cosine = sin(contact["contact_angle"]), cos(contact["contact_angle"])
    unit = friction * contact["normal_force"]
    moment = (m_z + contact["y"] * f_x) * cosine - (m_y - contact["z"] * f_x) * sine
    saturation = friction * contact["creepage_scale"]
    work = sum(float(np.sum(part.dissipation)) for part in solved.values()) * on_grid.grid.area
    return (
        f_x / unit,
        (f_y * cosine + f_z * sine) / unit,
        (f_z * cosine - f_y * sine) / contact["normal_force"],
        moment / (unit * contact["half_size"]),
        max(float(part.pressures.max()) for part in solved.values()) / contact["p_max"],
        work * (1 - min(slip.creepage, BEYOND)) / (unit * saturation),
    )
