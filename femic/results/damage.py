"""Wear and fatigue of a rolling contact with some ICs.

Numbers of one passage; and both surfaces after many passages, which wear step by step.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from femic.contact.frictional import FrictionalContact
from femic.contact.loading import Loading
from femic.damage.estimates import RollingSolution, Solved, estimated_errors
from femic.damage.fatigue import aspect_of, shakedown, surface_index, t_gamma
from femic.damage.specification import ENERGY, MOST_STEPS, NO_SPEED, DamageSpecification
from femic.damage.wear import depth, regimes, sliding_of, utilised_friction
from femic.damage.worn import BodyWear, Operation, UnstableSteps, WearSteps, WornContact, worn_contacts
from femic.results.stressed_contact import EstimatedRolling
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import N

REGIMES = "mild", "severe", "catastrophic"


# --- one passage ----------------------------------------------------------------------------------------


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


def compute_damage(rolling: EstimatedRolling, specification: DamageSpecification) -> Damage:
    """Return the wear and fatigue numbers of a contact in steady rolling, with their estimated errors."""
    own = _solve(rolling.own, specification)
    others = [
        [None if one is None else _solve(one, specification) for one in ones]
        for ones in (rolling.larger, rolling.changed)
    ]
    sliding = sliding_of(rolling.own.contact, specification.rolling_speed)
    by_regime = regimes(replace(sliding, speed=NO_SPEED), specification.twin_disc.transitions)
    return Damage(
        own.numbers,
        estimated_errors(own, *others),
        sliding.work,
        {name: depth(sliding, law) for name, law in specification.laws.items()},
        dict(zip(REGIMES, map(float, by_regime), strict=True)),
    )


def _solve(solution: RollingSolution, specification: DamageSpecification) -> Solved:
    """Return a contact with its wear and fatigue numbers."""
    contact = solution.contact
    sliding = sliding_of(contact, specification.rolling_speed)
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


# --- many passages --------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Wear:
    """Depths [mm] worn off the lower and the upper body, (2, n_s), and what becomes of the contact.

    `estimates` [mm], (2,), are estimated errors of the largest depths by the size of steps. `p_max` [MPa] and
    `work` [N] are those of the new and of the worn contact. `turned` [rad] is the largest change of a
    surface's inclination: ICs are those of new surfaces. `steps` have been made.
    """

    depths: Array
    estimates: Array
    p_max: tuple[float, float]
    work: tuple[float, float]
    turned: float
    steps: int


def compute_wear(solution: RollingSolution, specification: DamageSpecification) -> Wear:
    """Return what wear by the work of friction makes of a contact under its load and longitudinal force.

    Both bodies lose their share in each step, and the next contact has the gap of both. There are twice as
    many steps as are stable, so that those twice as large tell the error. Raises WrongInput where these are
    more than `MOST_STEPS`, Failure where a worn contact is not found.
    """
    coarse = max(1, specification.steps // 2)
    while True:
        try:
            larger, fine = (_contacts(solution, specification, count) for count in (coarse, 2 * coarse))
        except UnstableSteps as error:
            coarse *= 2
            if 2 * coarse > MOST_STEPS:
                raise WrongInput(
                    f"damage: more than {MOST_STEPS} steps of wear are needed; {error}"
                ) from error
            continue
        break
    first, last = fine[0], fine[-1]
    deepest = [np.max(_depths(contacts), axis=1) for contacts in (larger, fine)]
    return Wear(
        _depths(fine),
        np.asarray(np.abs(deepest[1] - deepest[0])),
        (_p_max(first), _p_max(last)),
        (first.sliding.total_work, last.sliding.total_work),
        max(contact.turned for contact in fine),
        2 * coarse,
    )


def _contacts(
    solution: RollingSolution, specification: DamageSpecification, number: int
) -> list[WornContact]:
    """Return the contact before each step of wear, and the worn one; raises UnstableSteps."""
    operation = Operation(
        Loading(solution.load),
        solution.rolling.creepages,
        specification.rolling_speed,
        {"longitudinal": float(solution.contact.force[0])},
    )
    law = specification.laws[ENERGY]
    lower, upper = (
        BodyWear(law, passages / number) for passages in (specification.passages, specification.revolutions)
    )
    steps = WearSteps(number, lower, upper, spread=specification.spread)
    return list(worn_contacts(solution.problem, operation, steps))


def _depths(contacts: Sequence[WornContact]) -> Array:
    surfaces = contacts[-1].surfaces
    return np.stack([surfaces.lower, surfaces.upper])


def _p_max(contact: WornContact) -> float:
    return float(np.max(contact.rolling.contact.p[..., N]))
