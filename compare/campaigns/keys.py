"""The keys of a campaign file (TOML) with their limits."""

import math
from typing import Annotated, Any, Literal, TypeGuard

from pydantic import ConfigDict, Field, FilePath, model_validator

from femic.key_types import Finite, Several, Whole
from femic.scenes.scene_table import SceneTable

DIGITS = 12  # significant, of numbers in names, and of those between the ends of a range
LARGEST = 1e30  # finite number of a scene
OUT_OF_RANGE = f"not a number, or larger than {LARGEST:g}; give another one"


class AxisTable(SceneTable):
    """An axis: keys of a scene with the same value, or with multiples of it, and the values."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, populate_by_name=True)

    keys: Annotated[dict[str, float] | list[str], Field(min_length=1)] = Field(
        description="keys of a scene, such as lower.E, lines.0.s; with factors: { 'lower.E' = 1000 }"
    )
    label: str = Field("", description="name of the axis in figures; default: its name in the file")
    unit: str = Field("", description="its unit")
    values: Several[Any] = Field((), description="the values, or instead:")
    start: Finite | None = Field(None, alias="from", description="smallest value")
    to: Finite | None = Field(None, description="largest value")
    count: Annotated[Whole, Field(ge=2, le=1_000_000)] | None = Field(None, description="number of values")
    spacing: Literal["linear", "logarithmic", "inverse"] = Field(
        "linear", description="spacing of the values between from and to, also for interpolation in a map"
    )

    def between(self, share: float) -> float:
        """Return the value at a share of the way from `from` to `to`, rounded to `DIGITS`."""
        low, high = float(self.start or 0.0), float(self.to or 0.0)
        match self.spacing:
            case "linear":
                value = low + (high - low) * share
            case "logarithmic":
                value = low * (high / low) ** share
            case "inverse":
                value = 1 / (1 / low + (1 / high - 1 / low) * share)
        return float(f"{value:.{DIGITS}g}")

    @model_validator(mode="after")
    def _check(self) -> "AxisTable":
        ends = self.start is not None, self.to is not None
        if (self.values and any(ends)) or any(ends) != all(ends):
            raise ValueError("give either values, or both from and to")
        if self.start is not None and self.to is not None:
            if not self.start < self.to:
                raise ValueError(f"from = {self.start:g} is not below to = {self.to:g}")
            if self.spacing != "linear" and self.start <= 0:
                raise ValueError(f"from = {self.start:g}: must be positive where spacing is {self.spacing}")
            if not self.start < self.between(0.5) < self.to:
                raise ValueError(
                    f"from = {self.start:g}, to = {self.to:g}: no number of {DIGITS} digits half way between"
                )
        if isinstance(self.keys, dict):
            if not all(is_number(value) for value in self.values):
                raise ValueError("factors need values that are numbers; give keys as a list")
            if not all(0 < abs(factor) <= LARGEST for factor in self.keys.values()):
                raise ValueError(f"keys: a factor is 0, {OUT_OF_RANGE}")
        if any(map(is_out_of_range, self.values)):
            raise ValueError(f"values: {OUT_OF_RANGE}")
        if len({value_text(value) for value in self.values}) < len(self.values):
            raise ValueError(f"values: one is given twice (numbers count to {DIGITS} digits)")
        return self


class CampaignFile(SceneTable):
    """A campaign: a scene, the keys that are swept, and the kinds of results to keep."""

    title: str = Field("", description="heading of the page; default: the file's name")
    scene: str = Field(description="built-in name, or file relative to this one")
    keep: Several[str] = Field(
        ("errors",),
        min_length=1,
        description="results to keep from each scene: errors, ics, contact, stresses, ... "
        "(compare/campaigns/kinds.py)",
    )
    set: dict[str, Any] = Field({}, description="keys common to all scenes, as in a scene file")
    sweep: dict[str, AxisTable] = Field(min_length=1, description="the axes")
    points: Literal["all", "random"] | FilePath = Field(
        "all",
        description="all: every combination of values; random: `samples` random points in the ranges; or "
        "a CSV file with the names of the axes as columns",
    )
    samples: Annotated[Whole, Field(ge=1, le=10_000_000)] = Field(100, description="number of random points")
    seed: Annotated[Whole, Field(ge=0)] = Field(
        0,
        description="seed of the random points, 0 or more; a run with more samples and the same seed "
        "contains the points of a smaller one",
    )

    @model_validator(mode="after")
    def _check(self) -> "CampaignFile":
        for name, axis in self.sweep.items():
            is_range = axis.start is not None
            if self.points == "all" and not (is_range or axis.values):
                raise ValueError(f"sweep.{name}: give either values, or both from and to")
            if not name.isidentifier():
                raise ValueError(f"sweep.{name}: a name has letters, digits and _ only")
            if self.points == "random" and not is_range:
                raise ValueError(f"sweep.{name}: random points need from and to")
            if self.points == "all" and is_range and axis.count is None:
                raise ValueError(f"sweep.{name}: give count, the number of values")
        owners: dict[str, str] = {}
        for name, axis in self.sweep.items():
            for key in axis.keys:  # which may not be an earlier one, or the table that contains it
                others = [
                    f"{other} of sweep.{owner}"
                    for other, owner in owners.items()
                    if f"{other}.".startswith(f"{key}.")
                ]
                if others:
                    raise ValueError(
                        f"sweep.{name}: {key} and {others[0]}; a key can belong to one axis only"
                    )
            owners |= dict.fromkeys(axis.keys, name)
        return self


def is_out_of_range(value: Any) -> bool:
    """Whether a value is NaN, or finite and larger than `LARGEST`."""
    return is_number(value) and not (abs(value) <= LARGEST or abs(value) == math.inf)


def value_text(value: Any) -> str:
    """Return a value as in the name of a point: numbers with `DIGITS` digits, 0 without a sign."""
    return f"{value + 0.0:.{DIGITS}g}" if is_number(value) else str(value)


def is_number(value: Any) -> TypeGuard[int | float]:
    """Whether a value of a key is a number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)
