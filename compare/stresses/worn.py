"""A rolling contact that wears: both surfaces after many passages, step by step, with some ICs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from femic.contact.loading import Loading
from femic.damage.estimates import RollingSolution
from femic.damage.specification import ENERGY, MOST_STEPS, DamageSpecification
from femic.damage.worn import BodyWear, Operation, UnstableSteps, WearSteps, WornContact, worn_contacts
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import N


@dataclass(frozen=True, eq=False)
class Worn:
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


def worn_of(solution: RollingSolution, specification: DamageSpecification) -> Worn:
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
    return Worn(
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
    return list(worn_contacts(solution.problem, operation, _steps_of(specification, number)))


def _steps_of(specification: DamageSpecification, number: int) -> WearSteps:
    law = specification.laws[ENERGY]
    lower, upper = (
        BodyWear(law, passages / number) for passages in (specification.passages, specification.revolutions)
    )
    return WearSteps(number, lower, upper, spread=specification.spread)


def _depths(contacts: Sequence[WornContact]) -> Array:
    surfaces = contacts[-1].surfaces
    return np.stack([surfaces.lower, surfaces.upper])


def _p_max(contact: WornContact) -> float:
    return float(np.max(contact.rolling.contact.p[..., N]))
