"""Errors of approximate ICs in a studied scene, by ICs and number, with the names of `femic advise`."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from femic.advice.scenes import CREEPAGES
from femic.advice.study import NORMAL_ICS, NORMAL_NUMBERS, PERTURBED, ROLLING_ICS
from femic.contact.pairs.given_ics import C

MIX, SAME_NORMAL = "mix", "Bhat"  # the mix has the nn ICs of B-hat
PRESSURE_IN_ROLLING = "p_max in rolling"  # tangential tractions change pressures, too
ROLLING_NUMBERS = (
    *("F_x/limit", "F_x", "F_y/limit", "sliding_share", "zero_creepage", "slope"),
    PRESSURE_IN_ROLLING,
)
NUMBERS = (*NORMAL_NUMBERS, *ROLLING_NUMBERS)
AWAY = np.array(CREEPAGES) != 0  # creepages at which the force is not nearly none
LEAST_FORCE = 1e-3  # over friction times load: shares of smaller forces with C are shares of this

Errors = dict[str, dict[str, float]]  # by ICs and number


def errors_of(entry: Mapping[str, Any]) -> Errors:
    """Return the errors of all ICs of an entry against C, each a share as in docs/evidence/advice.md.

    Those without friction have a sign; of rolling, each is the largest over the creepages, without a sign.
    """
    of_normal = {name: _frictionless(entry, name) for name in NORMAL_ICS}
    of_normal[MIX] = of_normal[SAME_NORMAL]
    errors: Errors = {name: dict(row) for name, row in of_normal.items()}
    for name in ROLLING_ICS:
        if name in entry["rolling"]:
            errors[name] |= _rolling(entry, name)
    return errors


def estimates_of(entry: Mapping[str, Any]) -> dict[str, float]:
    """Return the estimated error of C by number, on the same scales; of rolling 0 where it is not known."""
    estimates = {name: abs(error) for name, error in _frictionless(entry, PERTURBED).items()}
    return estimates | (
        _rolling(entry, PERTURBED) if PERTURBED in entry["rolling"] else dict.fromkeys(ROLLING_NUMBERS, 0.0)
    )


def _frictionless(entry: Mapping[str, Any], name: str) -> dict[str, float]:
    own, reference = entry["frictionless"][name], entry["frictionless"][C]
    return {number: own[number] / reference[number] - 1 for number in NORMAL_NUMBERS}


def _rolling(entry: Mapping[str, Any], name: str) -> dict[str, float]:
    own, reference = entry["rolling"][name], entry["rolling"][C]
    away = {
        number: np.abs(np.array(own[number]) - np.array(reference[number]))
        for number in ("F_x", "F_y", "sliding_share")
    }
    shares = away["F_x"][AWAY] / np.maximum(np.abs(np.array(reference["F_x"]))[AWAY], LEAST_FORCE)
    pressures = np.abs(np.array(own["p_max"]) / np.array(reference["p_max"]) - 1)
    return {
        PRESSURE_IN_ROLLING: float(np.max(pressures)),
        "F_x/limit": float(np.max(away["F_x"])),
        "F_x": float(np.max(shares)),
        "F_y/limit": float(np.max(away["F_y"])),
        "sliding_share": float(np.max(away["sliding_share"])),
        "zero_creepage": abs(own["zero_creepage"] - reference["zero_creepage"]) * abs(reference["slope"]),
        "slope": abs(own["slope"] / reference["slope"] - 1),
    }
