"""Wear and fatigue numbers of a rolling contact with some ICs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from compare.stresses.contacts import RollingSolution
from femic.contact.frictional import FrictionalContact
from femic.damage.fatigue import surface_index
from femic.damage.laws import WearLaw
from femic.damage.shakedown import LONGEST, SHORTEST, shakedown
from femic.damage.sliding import Sliding, sliding_of, utilised_friction, work_error
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


def damage_of(solution: RollingSolution, specification: DamageSpecification) -> Damage:
    """Return the wear and fatigue numbers of a contact in steady rolling."""
    contact = solution.contact
    sliding = _sliding(contact, specification)
    depths = {name: depth(sliding, law) for name, law in specification.laws.items()}
    shares = t_gamma(solution.problem, solution.rolling)
    by_regime = regimes(replace(sliding, speed=NO_SPEED), specification.twin_disc.transitions)
    numbers = {
        "xi": float(solution.rolling.creepages.longitudinal),
        "p_max": float(np.max(contact.p[..., N])),
        "work": sliding.total_work,
        "t_gamma": shares.without_spin,
        "t_gamma_with_spin": shares.with_spin,
        "utilised_friction": utilised_friction(contact),
        **{f"depth_{name}": float(np.max(worn)) for name, worn in depths.items()},
        **_limits(contact, specification),
    }
    return Damage(
        numbers,
        _errors(solution, specification),
        sliding.work,
        depths,
        dict(zip(REGIMES, map(float, by_regime), strict=True)),
    )


def _errors(solution: RollingSolution, specification: DamageSpecification) -> dict[str, float]:
    """Estimated errors of the numbers that follow from the work of friction; of the others there are none."""

    def deepest(law: WearLaw) -> Callable[[FrictionalContact], float]:
        return lambda contact: float(np.max(depth(_sliding(contact, specification), law)))

    of_work = {"work": lambda contact: _sliding(contact, specification).total_work}
    of_laws = {f"depth_{name}": deepest(law) for name, law in specification.laws.items()}
    return {
        name: work_error(solution.problem, solution.rolling, number)
        for name, number in {**of_work, **of_laws}.items()
    }


def _sliding(contact: FrictionalContact, specification: DamageSpecification) -> Sliding:
    return sliding_of(contact, specification.rolling_speed)


def _limits(contact: FrictionalContact, specification: DamageSpecification) -> dict[str, float]:
    """Place in the shakedown map and index of surface fatigue; empty without a yield stress.

    Aspects of patches beyond those of the map are taken at its ends.
    """
    k = specification.yield_shear
    if k is None:
        return {}
    pressed, grid = contact.p[..., N] > 0, contact.problem.grid
    half_length = np.count_nonzero(pressed.any(axis=1)) * grid.dx
    half_width = np.count_nonzero(pressed.any(axis=0)) * grid.ds
    aspect = float(np.clip(half_length / half_width, SHORTEST, LONGEST))
    p_max, utilised = float(np.max(contact.p[..., N])), utilised_friction(contact)
    at = shakedown(p_max, k, utilised, aspect)
    return {
        "pressure_ratio": at.pressure_ratio,
        "shakedown_limit": at.limit,
        "load_factor": at.load_factor,
        "surface_index": float(surface_index(p_max, utilised, k)),
    }
