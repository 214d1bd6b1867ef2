"""Wear and fatigue numbers of a rolling contact with some ICs."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from compare.stresses.contacts import EstimatedRolling
from femic.contact.frictional import FrictionalContact
from femic.damage.estimates import RollingSolution, Solved, estimated_errors
from femic.damage.fatigue import surface_index
from femic.damage.shakedown import aspect_of, shakedown
from femic.damage.sliding import Sliding, sliding_of, utilised_friction
from femic.damage.specification import NO_SPEED, DamageSpecification
from femic.damage.t_gamma import t_gamma
from femic.damage.wear import depth, regimes
from geometries.arrays import Array
from geometries.patches import N

REGIMES = "mild", "severe", "catastrophic"


@dataclass(frozen=True, eq=False)
class Damage:
    """Numbers of a rolling contact by name, their estimated errors, and what wears where.

    `power_density` is the work of friction per area and rolled distance [N/mm^2], (n_x, n_s); `depths` [mm],
    (n_s,) each, are worn off per passage, by law; `regimes` are shares of the work by regime of the law of
    twin discs.
    """

    numbers: Mapping[str, float]
    errors: Mapping[str, float]
    power_density: Array
    depths: Mapping[str, Array]
    regimes: Mapping[str, float]


def damage_of(rolling: EstimatedRolling, specification: DamageSpecification) -> Damage:
    """Return the wear and fatigue numbers of a contact in steady rolling, with their estimated errors."""
    own = _solved(rolling.own, specification)
    others = [
        [None if one is None else _solved(one, specification) for one in ones]
        for ones in (rolling.larger, rolling.changed)
    ]
    sliding = _sliding(rolling.own.contact, specification)
    by_regime = regimes(replace(sliding, speed=NO_SPEED), specification.twin_disc.transitions)
    return Damage(
        own.numbers,
        estimated_errors(own, *others),
        sliding.work,
        {name: depth(sliding, law) for name, law in specification.laws.items()},
        dict(zip(REGIMES, map(float, by_regime), strict=True)),
    )


def _solved(solution: RollingSolution, specification: DamageSpecification) -> Solved:
    """Return a contact with its wear and fatigue numbers."""
    contact = solution.contact
    sliding = _sliding(contact, specification)
    shares = t_gamma(solution.problem, solution.rolling)
    numbers = {
        "xi": float(solution.rolling.creepages.longitudinal),
        "p_max": float(np.max(contact.p[..., N])),
        "work": sliding.total_work,
        "t_gamma": shares.without_spin,
        "t_gamma_with_spin": shares.with_spin,
        "utilised_friction": utilised_friction(contact),
        **{f"depth_{name}": float(np.max(depth(sliding, law))) for name, law in specification.laws.items()},
        **_limits(contact, specification),
    }
    return Solved(solution, numbers)


def _sliding(contact: FrictionalContact, specification: DamageSpecification) -> Sliding:
    return sliding_of(contact, specification.rolling_speed)


def _limits(contact: FrictionalContact, specification: DamageSpecification) -> dict[str, float]:
    """Place in the shakedown map and index of surface fatigue; empty without a yield stress.

    Aspects of patches beyond those of the map are taken at its ends.
    """
    k = specification.yield_shear
    if k is None:
        return {}
    p_max, utilised = float(np.max(contact.p[..., N])), utilised_friction(contact)
    at = shakedown(p_max, k, utilised, aspect_of(contact))
    return {
        "pressure_ratio": at.pressure_ratio,
        "shakedown_limit": at.limit,
        "load_factor": at.load_factor,
        "surface_index": float(surface_index(p_max, utilised, k)),
    }
