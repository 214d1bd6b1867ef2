"""Where a contact slides, and local wear laws: how deep a surface is worn on an element, per rolled distance.

Per unit of rolled distance friction takes q = -p_t . s from each unit of area, s the slip per unit of rolled
distance: N/mm^2, or J per metre rolled and mm^2. With the rolling speed V in m/s, q V is the friction power
density in W/mm^2. The sum of q over the contact is the work of friction per rolled distance, in N or J/m: the
exact T-gamma.

A law has one function, `rate`, of a `Sliding`: the worn depth [mm] over the rolled distance [mm], (n_x, n_s).
A particle of either surface passes all elements of its strip, each in the rolled distance dx, so where laws
are the same a contact wears the same `depth` off both surfaces: the sum over x of rate dx. It is the depth
that the rail loses by one passage of a wheel, and the wheel in one revolution, since each place of its
circumference passes once. The rail loses it over all of the rolled length; per metre rolled a wheel loses
depth / (2 pi R(s)). Volumes per rolled distance are the same for both. Particles of the wheel pass in 1 + xi
times the distance; this is left out.

Coefficients were measured dry, in laboratories, on few pairs of steels: on lubricated or wet track wear is
several times less, and laws of different sources differ by ten where all are mild
(docs/theory/wear-and-fatigue.md). They are keys of scene files, too, in tables that are made from these
declarations: nothing here imports contacts.
"""

from dataclasses import dataclass, fields
from typing import Annotated, Any, Protocol

import numpy as np
from pydantic import Field

from femic.contact.exact.hertz import require_positive
from femic.key_types import Amount, TwoOf
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import Grid

Density = Annotated[Amount, Field(description="density of the worn material [kg/m^3]")]
STEEL_DENSITY = 7850.0  # kg/m^3, which is µg/mm^3
PER_METRE = 1e-3  # mm per m


@dataclass(frozen=True, eq=False)
class Sliding:
    """Pressures [MPa], (n_x, n_s), tangential tractions [MPa] and slip [-], (n_x, n_s, 2), of a contact.

    Slip is that of the upper over the lower surface per unit of rolled distance; `speed` [m/s] is the rolling
    speed. Raises WrongInput for a speed that is not positive, and for other shapes.
    """

    grid: Grid
    pressure: Array
    traction: Array
    slip: Array
    speed: float

    def __post_init__(self) -> None:
        require_positive("speed", self.speed)
        elements = self.grid.n_x, self.grid.n_s
        expected = {"pressure": elements, "traction": (*elements, 2), "slip": (*elements, 2)}
        for name, shape in expected.items():
            if np.shape(getattr(self, name)) != shape:
                raise WrongInput(
                    f"{name}: shape {np.shape(getattr(self, name))}, but the grid needs {shape}; give one "
                    "value per element"
                )

    @property
    def work(self) -> Array:
        """Work of friction per area and rolled distance [N/mm^2], (n_x, n_s).

        Tractions of leading edges follow those behind them: the work of a few elements there, which the
        solver leaves negative, is 0.
        """
        return np.maximum(-np.sum(self.traction * self.slip, axis=-1), 0.0)

    @property
    def power_density(self) -> Array:
        """Friction power density [W/mm^2], (n_x, n_s)."""
        return self.speed * self.work

    @property
    def velocity(self) -> Array:
        """Size of the sliding velocity [m/s], (n_x, n_s)."""
        return np.asarray(self.speed * np.linalg.norm(self.slip, axis=-1))

    @property
    def total_work(self) -> float:
        """Work of friction per rolled distance [N], which is J/m."""
        return float(np.sum(self.work) * self.grid.area)


class WearLaw(Protocol):
    """A local wear law."""

    def rate(self, sliding: Sliding) -> Array:
        """Return the worn depth per rolled distance [mm/mm], shape (n_x, n_s)."""
        ...


def depth(sliding: Sliding, law: WearLaw) -> Array:
    """Return the depth [mm] that strips lose per passage (rail) or revolution (wheel), shape (n_s,)."""
    return np.asarray(np.sum(law.rate(sliding), axis=0) * sliding.grid.dx)


def regime_shares(sliding: Sliding, limits: tuple[float, float]) -> Array:
    """Return the shares of the work of friction below, between and beyond two values of it [N/mm^2], (3,).

    Their sum is 1, without work 0. They say how much of a result depends on the coefficient of which regime.
    """
    regime = np.digitize(sliding.work, limits)
    work = np.bincount(regime.ravel(), sliding.work.ravel(), len(limits) + 1)
    total = float(work.sum())
    return np.asarray(work / total if total > 0 else work)


@dataclass(frozen=True)
class EnergyLaw:
    """Worn mass proportional to the work of friction, mild or severe by the friction power density.

    By Krause and Poll (1986), Wear 113, 103-122: worn volume is proportional to the work of friction, with a
    factor that rises where friction power over contact area passes a transition, since surfaces become hot.
    They state it for a contact as a whole; here it holds on each element, as in Zobory (1997), Vehicle System
    Dynamics 28, 221-259. `mild` and `severe` [µg/J] are worn masses over work, `transition` [W/mm^2]
    the power density from which on wear is severe, `density` [kg/m^3] that of the material.

    The defaults, 7e-10 and 21e-10 kg/J, and 4 W/mm^2, are those of Zobory, from memory of secondary sources:
    verify them. At the transition the depth jumps by their ratio. Limits: dry steel on steel; at power
    densities far beyond those of rails a contact has temperatures that no factor of two covers.
    """

    mild: Annotated[Amount, Field(description="worn mass per work in the mild regime [µg/J]")] = 0.7
    severe: Annotated[
        Amount, Field(description="worn mass per work in the severe regime [µg/J]; needs damage.speed")
    ] = 2.1
    transition: Annotated[
        Amount,
        Field(description="friction power density at which wear becomes severe [W/mm^2]; needs damage.speed"),
    ] = 4.0
    density: Density = STEEL_DENSITY

    def __post_init__(self) -> None:
        _require_positive(self)

    def rate(self, sliding: Sliding) -> Array:
        """Return the worn depth per rolled distance [mm/mm], shape (n_x, n_s)."""
        coefficient = np.where(sliding.power_density < self.transition, self.mild, self.severe)
        return coefficient * sliding.work / self.density * PER_METRE


@dataclass(frozen=True)
class TwinDiscLaw:
    """Worn mass as a function of T-gamma over area, in three regimes: mild, severe, catastrophic.

    By Lewis and Dwyer-Joyce (2004), Journal of Engineering Tribology 218, 467-478, and Braghin, Lewis,
    Dwyer-Joyce and Bruni (2006), Wear 261, 1253-1264: twin discs of wheel steel R8T on rail steel 900A. With
    T = T-gamma/A [N/mm^2] the worn mass per rolled distance and area [µg/m/mm^2] is `mild` T below the
    first of `transitions`, `severe` up to the second, and rises by `catastrophic` times T from there on.
    `density` [kg/m^3].

    At the first transition the source jumps, from 55.1 to 55.0. Beyond the second one published forms differ:
    slope times T less a constant, which is printed so that it either goes on from 55 or falls to 0, or
    without any, a jump to 4779. Here it is continuous. T is taken element by element, as by Braghin. Limits:
    discs have 900 to 1500 MPa and slide by up to 20 %; rails hardly reach the catastrophic regime.
    """

    mild: Annotated[
        Amount,
        Field(
            description="mild regime: worn mass per rolled distance and area, divided by T-gamma/A [µg/m/N]"
        ),
    ] = 5.3
    severe: Annotated[
        Amount, Field(description="severe regime: worn mass per rolled distance and area [µg/m/mm^2]")
    ] = 55.0
    catastrophic: Annotated[
        Amount, Field(description="catastrophic regime: slope over T-gamma/A [µg/m/N]")
    ] = 61.9
    transitions: Annotated[
        TwoOf[Amount], Field(description="T-gamma/A at which wear becomes severe and catastrophic [N/mm^2]")
    ] = (10.4, 77.2)
    density: Density = STEEL_DENSITY

    def __post_init__(self) -> None:
        _require_positive(self)
        _require_growing("transitions", self.transitions)

    def mass(self, t_gamma_per_area: Array) -> Array:
        """Return the worn mass [µg/m/mm^2] at T-gamma over area [N/mm^2], shape of these."""
        t = np.asarray(t_gamma_per_area, dtype=float)
        beyond = self.severe + self.catastrophic * (t - self.transitions[1])
        return np.where(
            t < self.transitions[0], self.mild * t, np.where(t <= self.transitions[1], self.severe, beyond)
        )

    def rate(self, sliding: Sliding) -> Array:
        """Return the worn depth per rolled distance [mm/mm], shape (n_x, n_s)."""
        return self.mass(sliding.work) / self.density * PER_METRE


@dataclass(frozen=True)
class ArchardMap:
    """Archard's law with coefficients by sliding velocity and pressure: the wear map of KTH.

    Worn volume = k times load times sliding distance over hardness (Archard 1953, Journal of Applied Physics
    24, 981-988). By Jendel (2002), Wear 253, 89-99, k is `seizure` where the pressure exceeds the share
    `pressure_share` of `hardness` [MPa], else `slow`, `middle` or `fast` below, between and above the two
    `velocities` [m/s]. His ranges, from memory, so verify them: slow and fast 1e-4 ... 10e-4, middle 30e-4
    ... 40e-4, seizure 300e-4 ... 400e-4; the defaults are about their middles. The map jumps at each border.

    Limits: pins on discs, dry; for track that weather or lubricators lubricate Jendel takes a share of these
    k. Hardness is that of the softer surface.
    """

    slow: Annotated[Amount, Field(description="Archard's k below the first sliding velocity")] = 5e-4
    middle: Annotated[Amount, Field(description="Archard's k between both sliding velocities")] = 35e-4
    fast: Annotated[Amount, Field(description="Archard's k above the second sliding velocity")] = 5e-4
    seizure: Annotated[
        Amount, Field(description="Archard's k where the pressure exceeds pressure_share x hardness")
    ] = 350e-4
    hardness: Annotated[Amount, Field(description="hardness of the softer surface [MPa]")] = 3000.0
    velocities: Annotated[
        TwoOf[Amount], Field(description="sliding velocities at which Archard's k changes [m/s]")
    ] = (0.2, 0.7)
    pressure_share: Annotated[
        Amount, Field(description="pressure divided by hardness above which the surfaces seize")
    ] = 0.8

    def __post_init__(self) -> None:
        _require_positive(self)
        _require_growing("velocities", self.velocities)

    def coefficient(self, velocity: Array, pressure: Array) -> Array:
        """Return Archard's k [-] at sliding velocities [m/s] and pressures [MPa], of their joint shape."""
        by_velocity = np.select(
            [velocity < self.velocities[0], velocity <= self.velocities[1]],
            [self.slow, self.middle],
            self.fast,
        )
        return np.where(pressure > self.pressure_share * self.hardness, self.seizure, by_velocity)

    def rate(self, sliding: Sliding) -> Array:
        """Return the worn depth per rolled distance [mm/mm], shape (n_x, n_s)."""
        k = self.coefficient(sliding.velocity, sliding.pressure)
        return np.asarray(k * sliding.pressure * np.linalg.norm(sliding.slip, axis=-1) / self.hardness)


def _require_positive(law: Any) -> None:
    """Raise WrongInput for a coefficient of a law that is not positive."""
    for field in fields(law):
        value = getattr(law, field.name)
        for one in value if isinstance(value, tuple) else (value,):
            require_positive(field.name, one)


def _require_growing(name: str, limits: tuple[float, float]) -> None:
    """Raise WrongInput for two limits of which the first is not the smaller one."""
    if not limits[0] < limits[1]:
        raise WrongInput(f"{name} = {limits!r}: two limits, the smaller one first")
