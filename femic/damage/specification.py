"""What wear and fatigue numbers of a contact depend on beside it: the material, the speed, coefficients."""

from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from pydantic import Field

from femic.damage.dang_van import DangVan
from femic.damage.laws import ArchardMap, EnergyLaw, TwinDiscLaw, WearLaw
from femic.key_types import LARGEST, LARGEST_LENGTH, Amount, Whole
from geometries.errors import WrongInput

NO_SPEED = 1.0  # m/s, where no number depends on the speed
ENERGY, TWIN_DISC, ARCHARD = "energy", "twin disc", "Archard"
CONSTANTS = "yield_stress", "hardness", "speed"
MOST_STEPS = 1000
Count = Annotated[float, Field(ge=0, le=LARGEST)]  # of passages


@dataclass(frozen=True)
class DamageSpecification:
    """Constants of the surfaces and the rolling speed, None: not given, and coefficients of the laws.

    Each key is declared here alone, with its unit, limits and default; the table [damage] of a scene file is
    made from these declarations. Raises WrongInput for constants that are not positive, and for a hardness
    without speed. The hardness of `archard` is not used: it is that of both.
    """

    yield_stress: Annotated[
        Amount | None,
        Field(description="yield stress in tension [MPa], for yield, shakedown and surface fatigue"),
    ] = None
    hardness: Annotated[
        Amount | None,
        Field(description="hardness of the softer surface [MPa], for Archard wear; needs speed"),
    ] = None
    speed: Annotated[
        Amount | None, Field(description="rolling speed [m/s], for wear laws that depend on it")
    ] = None
    passages: Annotated[Count, Field(description="number of wheel passages that wear the rail; 0: none")] = (
        0.0
    )
    revolutions: Annotated[Count, Field(description="number of revolutions that wear the wheel; 0: none")] = (
        0.0
    )
    steps: Annotated[
        Whole,
        Field(
            ge=1,
            le=MOST_STEPS,
            description="least number of wear steps; the contact is solved again after each",
        ),
    ] = 10
    spread: Annotated[
        float,
        Field(
            ge=0,
            le=LARGEST_LENGTH,
            description="standard deviation of the lateral position of the wheels along s [mm]",
        ),
    ] = 0.0
    energy: EnergyLaw = field(default_factory=EnergyLaw)
    twin_disc: TwinDiscLaw = field(default_factory=TwinDiscLaw)
    archard: ArchardMap = field(default_factory=ArchardMap)
    dang_van: DangVan = field(default_factory=DangVan)

    def __post_init__(self) -> None:
        for name in CONSTANTS:
            value = getattr(self, name)
            if value is not None and not 0 < value < np.inf:
                raise WrongInput(f"{name} = {value!r}: must be positive and finite")
        if self.hardness is not None and self.speed is None:
            raise WrongInput(
                f"hardness = {self.hardness:g}: Archard's coefficients depend on the sliding velocity; "
                "also give speed [m/s]"
            )

    @property
    def wears(self) -> bool:
        """Whether the contact is solved again as it wears."""
        return self.passages > 0 or self.revolutions > 0

    @property
    def yield_shear(self) -> float | None:
        """Yield stress in shear by Mises [MPa]."""
        return None if self.yield_stress is None else self.yield_stress / np.sqrt(3)

    @property
    def rolling_speed(self) -> float:
        """The speed [m/s], `NO_SPEED` where none is given: then no number depends on it."""
        return self.speed or NO_SPEED

    @property
    def laws(self) -> dict[str, WearLaw]:
        """Wear laws by name; without a speed the law by energy is mild everywhere."""
        energy = self.energy if self.speed else replace(self.energy, severe=self.energy.mild)
        laws: dict[str, WearLaw] = {ENERGY: energy, TWIN_DISC: self.twin_disc}
        if self.hardness is not None:
            laws[ARCHARD] = replace(self.archard, hardness=self.hardness)
        return laws
