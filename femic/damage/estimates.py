"""Estimated errors of wear and fatigue numbers of a contact in steady rolling at a prescribed force.

As those of the contact itself (`femic.contact.estimates`): from the same contact on elements twice and four
times as large, from what ICs changed by their own estimates and the distance of the displaced bodies make of
it, and from elements whose state is uncertain. In addition

- numbers in proportion to the work of friction are known to the share by which the work on slip differs from
  that of the rigid motion: where little of a contact slides, grids miss much of its slip, and changes from
  grid to grid do not show that;
- the creepage is known to what the force is known to, over the slope of the creep-force curve there;
- the shakedown limit is known to what utilised friction and the aspect of the patch are known to, by how much
  it changes with each: these are independent, so squares are added. Of an aspect large elements tell nothing,
  as readings of edges have an accuracy of their own.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from femic.contact.estimates import (
    GIVEN,
    LATERAL,
    LONGITUDINAL,
    RELATED,
    ROUNDING,
    WORK,
    Kind,
    Measured,
    Numbers,
    Scale,
    changes,
    errors,
    floors,
    readings,
)
from femic.contact.frictional import FrictionalContact
from femic.contact.pairs.quantities import main_patch
from femic.contact.rolling import RollingContact, RollingProblem
from femic.damage.fatigue import nearest_aspect, patch_aspect, shakedown_limit
from geometries.patches import N, S, X

_FORCES = ("force", RELATED)
OF_CONTACT = {  # what other numbers are related to
    "F_x": replace(LONGITUDINAL, floors=("force",)),
    "F_s": replace(LATERAL, floors=("force",)),
    "approach": GIVEN,
}
T_GAMMA = Kind("creepage", "t_gamma", (_FORCES,), ("force",))
KINDS: Mapping[str, Kind] = {
    "work": WORK,
    "xi": Kind("creepage", "xi", (_FORCES,), ("force",)),
    "t_gamma": T_GAMMA,
    "t_gamma_with_spin": T_GAMMA,
    "p_max": Kind("pressure", related=(("pressure", 1.0),)),  # it and the approach are all of this group
    "shakedown_limit": Kind("limit", floors=("aspect",), own=False),
}
FOLLOW = "utilised_friction", "pressure_ratio", "load_factor", "surface_index"  # from those and from forces
WORN = Kind("worn", "worn", (_FORCES,), ("work",))  # all other numbers are in proportion to the work


@dataclass(frozen=True, eq=False)
class RollingSolution:
    """A contact in steady rolling under a load [N], its problem, and the slope of its creep-force curve.

    `slope` is dF_x/dxi [N], infinite where the creepage is prescribed. `larger` and `changed` are solutions
    of the same for its estimates, None: there is no such contact. The former are those on elements twice and
    four times as large; the latter that with the distance of the displaced bodies, and that with ICs plus
    their estimated errors where errors of ICs are known.
    """

    problem: RollingProblem
    rolling: RollingContact
    load: float
    slope: float = np.inf
    larger: "tuple[RollingSolution | None, ...]" = ()
    changed: "tuple[RollingSolution | None, ...]" = ()

    @property
    def contact(self) -> FrictionalContact:
        """The contact."""
        return self.rolling.contact


def estimate_errors(
    solution: RollingSolution, compute: Callable[[RollingSolution], Numbers]
) -> tuple[Numbers, dict[str, float]]:
    """Return the numbers of a contact and their estimated errors, both by name.

    `compute` returns the numbers of a solution: of `KINDS`, of `FOLLOW`, by other names worn depths. Errors
    are nan where the contact on elements twice as large is not known, or a changed one; and for numbers in
    proportion to the work where the grid has none, but the rigid motion does.
    """
    own = compute(solution)
    kinds = {name: KINDS.get(name, replace(WORN, scale=name)) for name in own if name not in FOLLOW}
    kinds |= OF_CONTACT
    fine = _measure(solution, own)
    parts = [
        changes(fine, kinds, _measure(one, compute(one)).numbers) if one else dict.fromkeys(kinds, np.nan)
        for one in solution.changed
    ]
    larger = [_measure(one, compute(one)) if one else None for one in solution.larger]
    known = errors(kinds, fine, larger, parts)
    known |= _derive_errors(solution, fine, known)
    return own, {name: known[name] for name in own}


def _derive_errors(solution: RollingSolution, fine: Measured, known: Numbers) -> dict[str, float]:
    """Return the errors of the numbers of `FOLLOW` that there are, and of the shakedown limit."""
    errors, numbers = {}, fine.numbers
    F_x, F_s, load = abs(numbers["F_x"]), abs(numbers["F_s"]), fine.scales["longitudinal"].rounds
    if "utilised_friction" in numbers:
        most = np.hypot(F_x + known["F_x"], F_s + known["F_s"])
        errors["utilised_friction"] = float(most - np.hypot(F_x, F_s)) / load
    if "shakedown_limit" in numbers:
        by_friction, error = np.nan, errors["utilised_friction"]
        if np.isfinite(error):
            least = max(numbers["utilised_friction"] - error, 0.0)
            limits = shakedown_limit([least, least + 2 * error], patch_aspect(solution.contact))
            by_friction = float(np.max(np.abs(limits - numbers["shakedown_limit"])))
        errors["shakedown_limit"] = float(np.hypot(known["shakedown_limit"], by_friction))
    if "pressure_ratio" in numbers:
        relative_pressure = known["p_max"] / numbers["p_max"]
        relative_limit = errors["shakedown_limit"] / numbers["shakedown_limit"]
        errors["pressure_ratio"] = numbers["pressure_ratio"] * relative_pressure
        errors["load_factor"] = numbers["load_factor"] * (relative_limit + relative_pressure)
    if "surface_index" in numbers:  # utilised friction less a share in inverse proportion to p_max
        share = abs(numbers["utilised_friction"] - numbers["surface_index"])
        errors["surface_index"] = errors["utilised_friction"] + share * known["p_max"] / numbers["p_max"]
    return errors


def _measure(solution: RollingSolution, numbers: Numbers) -> Measured:
    """Return the numbers and the forces of a contact, with their scales and floors."""
    contact, area = solution.contact, solution.problem.problem.grid.area
    F_x, F_s = (float(np.sum(contact.p[..., direction])) * area for direction in (X, S))
    friction_limit = float(np.sum(contact.problem.bound(contact.p[..., N]))) * area
    load = float(np.sum(contact.p[..., N])) * area
    largest = contact.largest_work  # that of full sliding
    missed = solution.problem.missed_work(solution.rolling) / largest if largest > 0 else 0.0

    creepages = solution.rolling.creepages
    moved = abs(friction_limit / solution.slope)  # an uncertain force moves the creepage along its curve
    others = np.hypot(creepages.longitudinal, creepages.lateral) * friction_limit
    sizes = {"work": largest, "xi": moved, "t_gamma": abs(F_x) * moved + others}
    own = float(np.sum(contact.dissipation)) * contact.problem.grid.area
    nothing = 0.0 if missed <= ROUNDING else np.nan
    whole = largest / own if own > 0 else nothing  # worn depths are in proportion to the work
    sizes |= {name: abs(number) * whole for name, number in numbers.items() if name not in (*KINDS, *FOLLOW)}
    scales = {name: Scale(size, size) for name, size in sizes.items()}
    scales |= {"longitudinal": Scale(friction_limit, load), "lateral": Scale(friction_limit, load)}

    state_floors = floors(contact.slip_state)
    other_floors = {
        "work": max(state_floors["work"], missed),
        "aspect": _change_with_aspect(contact, numbers),
    }
    contact_numbers = {"F_x": F_x, "F_s": F_s, "approach": contact.approach}
    exact = ("F_x",) if np.isfinite(solution.slope) else ()  # prescribed
    return Measured({**numbers, **contact_numbers}, scales, state_floors | other_floors, exact)


def _change_with_aspect(contact: FrictionalContact, numbers: Numbers) -> float:
    """Return the largest change of the shakedown limit by the accuracy of edges, as a share of it."""
    if "shakedown_limit" not in numbers:
        return 0.0
    share = float(np.linalg.norm(list(readings(main_patch(contact)).values())))
    aspects = [nearest_aspect(patch_aspect(contact) * factor) for factor in (1 + share, 1 / (1 + share))]
    limits = [float(shakedown_limit(numbers["utilised_friction"], aspect)) for aspect in aspects]
    return max(abs(limit / numbers["shakedown_limit"] - 1) for limit in limits)
