"""Wear and fatigue of a rolling contact with some ICs, as datasets.

Numbers of one passage; and both surfaces after many passages, which wear step by step.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from femic.contact.datasets import PREFIXES
from femic.contact.estimates import Numbers
from femic.damage.estimates import RollingSolution, estimate_errors
from femic.damage.fatigue import patch_aspect, shakedown_limit, surface_index, t_gamma, utilised_friction
from femic.damage.laws import depth, regime_shares
from femic.damage.specification import ENERGY, MOST_STEPS, DamageSpecification
from femic.damage.wear import UnstableSteps, WearSteps, WornContact, find_sliding, wear_contact
from geometries.errors import WrongInput
from geometries.patches import N


@dataclass(frozen=True)
class Number:
    """A number: its symbol, its unit, and what it is."""

    symbol: str
    unit: str
    meaning: str

    @property
    def title(self) -> str:
        """The symbol, and the unit in brackets."""
        return self.symbol if self.unit == "1" else f"{self.symbol} [{self.unit}]"


OF_DAMAGE = {
    "xi": Number("ξ", "1", "longitudinal creepage"),
    "p_max": Number("p_max", "MPa", "largest pressure"),
    "work": Number("W", "J/m", "work of friction per rolled distance"),
    "t_gamma": Number("Tγ", "N", "forces times creepages"),
    "t_gamma_with_spin": Number("Tγ + Mω", "N", "forces times creepages, including spin"),
    "utilised_friction": Number("μ_used", "1", "utilised friction: tangential force divided by normal force"),
    "largest_depth_energy": Number("depth, energy", "nm", "largest wear depth per passage, energy law"),
    "largest_depth_twin_disc": Number("depth, BRR", "nm", "largest wear depth per passage, T-gamma/area law"),
    "largest_depth_Archard": Number("depth, Archard", "nm", "largest wear depth per passage, Archard's law"),
    "pressure_ratio": Number("p_max/k", "1", "largest pressure divided by the yield stress in shear"),
    "shakedown_limit": Number("limit", "1", "shakedown limit of p_max/k, without residual shear along x"),
    "load_factor": Number("limit/(p_max/k)", "1", "shakedown factor; below 1 the material may ratchet"),
    "surface_index": Number("FI_surf", "1", "surface fatigue index; above 0 cracks can start"),
}
REGIMES = ["mild", "severe", "catastrophic"]
NANO, MICRO = 1e6, 1e3  # nm and µm per mm


def compute_damage(solution: RollingSolution, specification: DamageSpecification) -> xr.Dataset:
    """Return the wear and fatigue numbers of a contact in steady rolling, and what one passage wears where.

    The numbers of `OF_DAMAGE`, those of shakedown and fatigue only with a yield stress, have estimated errors
    `estimate_NUMBER`. `work_density` (x, s) [MPa] is the work of friction per area and rolled distance;
    `depth` (law, s) [nm] is worn off per passage; `regime_share` (regime) are shares of the work by regime of
    the law of twin discs. Aspects of patches beyond those of the shakedown map are taken at its ends.
    """
    laws, k = specification.laws, specification.yield_shear

    def compute(one: RollingSolution) -> Numbers:
        contact, sliding = one.contact, find_sliding(one.contact, specification.rolling_speed)
        longitudinal, lateral, spin = t_gamma(one.problem, one.rolling)
        p_max = float(np.max(contact.p[..., N]))
        utilised = utilised_friction(contact)
        numbers = {
            "xi": float(one.rolling.creepages.longitudinal),
            "p_max": p_max,
            "work": sliding.total_work,
            "t_gamma": longitudinal + lateral,
            "t_gamma_with_spin": longitudinal + lateral + spin,
            "utilised_friction": utilised,
        }
        for name, law in laws.items():
            numbers[f"largest_depth_{name.replace(' ', '_')}"] = NANO * float(np.max(depth(sliding, law)))
        if k is not None:
            limit = float(shakedown_limit(utilised, patch_aspect(contact)))
            numbers |= {
                "pressure_ratio": p_max / k,
                "shakedown_limit": limit,
                "load_factor": limit / (p_max / k),
                "surface_index": float(surface_index(p_max, utilised, k)),
            }
        return numbers

    numbers, errors = estimate_errors(solution, compute)
    sliding = find_sliding(solution.contact, specification.rolling_speed)
    grid, mm, depths = sliding.grid, {"units": "mm"}, [depth(sliding, law) for law in laws.values()]
    dataset = xr.Dataset(
        {
            "work_density": (("x", "s"), sliding.work, {"units": "MPa"}),
            "depth": (
                ("law", "s"),
                NANO * np.stack(depths),
                {"units": "nm", "long_name": "wear depth per passage (rail) or revolution (wheel)"},
            ),
            "regime_share": (
                "regime",
                regime_shares(sliding, specification.twin_disc.transitions),
                {"units": "1"},
            ),
        },
        coords={
            "law": list(laws),
            "regime": REGIMES,
            "x": ("x", solution.problem.rolling.x, mm),
            "s": ("s", grid.strips, mm),
        },
    )
    for name, number in numbers.items():
        for prefix, value in (("", number), ("estimate_", errors[name])):
            meaning = OF_DAMAGE[name].meaning + PREFIXES[prefix]
            attrs = {"units": OF_DAMAGE[name].unit, "long_name": meaning}
            dataset[prefix + name] = (), value, attrs
    return dataset


def compute_wear(solution: RollingSolution, specification: DamageSpecification) -> xr.Dataset:
    """Return what wear by the work of friction makes of a contact under its load and longitudinal force.

    Both bodies lose their share in each step, and the next contact has the gap of both. There are twice as
    many steps as are stable, so that those twice as large tell the error. `worn` (worn_body, s) [µm] are the
    depths in the end, `estimate_worn` (worn_body) [µm] the estimated errors of the largest ones by the size
    of steps. `worn_p_max` [MPa] and `worn_work` [J/m] over `state` are those of the new and of the worn
    contact. `turned` [deg] is the largest change of a surface's inclination: ICs are those of new surfaces.

    Raises WrongInput where more than `MOST_STEPS` are needed, Failure where a worn contact is not found.
    """

    def wear(count: int) -> list[WornContact]:
        per_step = specification.passages / count, specification.revolutions / count
        law, speed = specification.laws[ENERGY], specification.rolling_speed
        return list(wear_contact(solution, WearSteps(count, per_step, law, speed, specification.spread)))

    coarse = max(1, specification.steps // 2)
    while True:
        try:
            larger, fine = wear(coarse), wear(2 * coarse)
            break
        except UnstableSteps as error:
            coarse *= 2
            if 2 * coarse > MOST_STEPS:
                raise WrongInput(
                    f"damage: more than {MOST_STEPS} steps of wear are needed; {error}"
                ) from error
    first, last = fine[0], fine[-1]
    deepest = [np.max(contacts[-1].depths, axis=1) for contacts in (larger, fine)]
    meaning = "wear depth after all passages and revolutions"
    p_max = [float(np.max(one.rolling.contact.p[..., N])) for one in (first, last)]
    return xr.Dataset(
        {
            "worn": (
                ("worn_body", "s"),
                MICRO * last.depths,
                {"units": "µm", "long_name": meaning},
            ),
            "estimate_worn": (
                "worn_body",
                MICRO * np.abs(deepest[1] - deepest[0]),
                {"units": "µm", "long_name": meaning + PREFIXES["estimate_"]},
            ),
            "wear_steps": 2 * coarse,
            "turned": ((), np.degrees(max(contact.turned for contact in fine)), {"units": "deg"}),
            "worn_p_max": ("state", p_max, {"units": "MPa"}),
            "worn_work": ("state", [one.sliding.total_work for one in (first, last)], {"units": "J/m"}),
        },
        coords={
            "worn_body": ["lower", "upper"],
            "state": ["new", "worn"],
            "s": ("s", first.sliding.grid.strips, {"units": "mm"}),
        },
    )
