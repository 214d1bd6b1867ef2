"""Dang Van's criterion of high-cycle fatigue, by its coefficients.

The equivalent stress is tau_eq = max over t of tau_a(t) + c sigma_h(t), with the shear amplitude tau_a and
the hydrostatic stress sigma_h (`femic.damage.equivalent_stress`).

c follows from limits in torsion tau_e and bending sigma_e of one steel, c = 3 (tau_e / sigma_e - 1/2); 1/3 is
common for steels of wheels and rails. Limits: no crack growth, endless life, small plastic strains of grains
only; under large hydrostatic pressure, as below contacts, the linear term forgives much, and authors differ
on how far it holds (Desimone, Bernasconi and Beretta 2006, Wear 260, 567-572, take none of it in compression:
`compression` 0).

Coefficients are keys of scene files, too: nothing that computes with them is here.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from geometries.errors import WrongInput


@dataclass(frozen=True)
class DangVan:
    """Weights of hydrostatic stress, c of tension, and of compression the share `compression` of c."""

    hydrostatic: Annotated[
        float, Field(ge=0, allow_inf_nan=False, description="weight c of tension; default: 1/3")
    ] = 1 / 3
    compression: Annotated[float, Field(ge=0, le=1, description="weight of compression, as a share of c")] = (
        1.0
    )

    def __post_init__(self) -> None:
        if not (self.hydrostatic >= 0 and np.isfinite(self.hydrostatic)):
            raise WrongInput(f"hydrostatic = {self.hydrostatic!r}: must be zero or positive, and finite")
        if not 0 <= self.compression <= 1:
            raise WrongInput(f"compression = {self.compression!r}: a share of the weight in tension, 0 ... 1")

    @classmethod
    def of_limits(cls, torsion: float, bending: float) -> "DangVan":
        """Return the criterion of a steel by its fatigue limits [MPa] in torsion and bending, reversed."""
        if not 0 < bending / 2 <= torsion < np.inf:
            raise WrongInput(
                f"fatigue limits {torsion!r} in torsion, {bending!r} MPa in bending: both positive, torsion "
                "half of bending or more"
            )
        return cls(3 * (torsion / bending - 0.5))
