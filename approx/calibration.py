"""Effective properties fitted to known ICs: the A' with which B-hat-prime comes closest to them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType

import numpy as np
from scipy.ndimage import minimum_filter
from scipy.optimize import least_squares

from approx.effective import EffectiveProperties, Transition
from approx.target import Target
from geometries.arrays import Array
from geometries.errors import WrongInput

Values = dict[str, dict[str, float]]  # by property and parameter

PARAMETERS = ("far", "r_inf", "m", "n")
FAR_BOUNDS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"mismatch_k": (-5.0, 5.0), "G": (0.05, 20.0), "nu": (0.0, 0.5)}  # G: over that of the half-space
)
EXPONENTS: Mapping[str, tuple[float, float]] = MappingProxyType(  # n below 1: infinite slope at r_inf
    {"m": (0.2, 10.0), "n": (1.0, 50.0)}
)
REACH = 2.0  # times the largest distance of the data: bound of r_inf, which is at least the smallest
GRID = (24, 12, 12)  # values of r_inf, m, n among which the starts are chosen
STARTS = 12  # the best of the grid, as many of its local minima, and one for each r_inf
ROUGH = {"xtol": 1e-7, "ftol": 1e-7, "gtol": 1e-7, "max_nfev": 25}  # of the optimiser
EXACT = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15, "max_nfev": 300}
FINALISTS = 5  # starts that are polished to the end
INSIDE = 1e-3  # of the width of the bounds, where the optimiser begins at least
ROUNDING = 1e-10  # of the largest IC: deviations below it are no deviations
NO_WORSE = 4.0  # variances of a point, by which fixing a parameter may raise the sum of squares
KNOWN = 0.5  # standard deviation of log r_inf, log m, log n up to which the data determine them


@dataclass(frozen=True)
class Parameter:
    """A parameter; `deviation` is its standard deviation, None where it was not fitted; `note` says why."""

    name: str  # such as "mismatch_k.far"
    value: float
    deviation: float | None
    note: str = ""


@dataclass(frozen=True, eq=False)
class Fit:
    """What a fit found.

    `covariance` is that of the fitted parameters in their order, as if the deviations of the points were
    independent and as large as the residual or, if larger, the error of the target. `rms` and `worst`
    deviation per component are shares of the component's largest IC.
    """

    effective: EffectiveProperties
    parameters: tuple[Parameter, ...]
    covariance: Array
    rms: Array
    worst: Array


def fit(target: Target, properties: Sequence[str] = ("mismatch_k",)) -> Fit:
    """Fit transitions of properties by weighted least squares within `FAR_BOUNDS`, `EXPONENTS`, `REACH`.

    Each component counts alike. Parameters that the data do not determine are fixed one after the other, the
    least known first: m, n at 1 (a linear transition), r_inf at the largest distance, far at the half-space's
    value, or, where the fit would be worse by that, at what was found. Raises WrongInput for properties that
    the components do not depend on.
    """
    data = _Data.of(target, tuple(properties))
    values, free = data.starting_values(), [(p, name) for p in properties for name in PARAMETERS]
    notes: dict[tuple[str, str], str] = {}
    values = data.best(values, free, data.starts(values))
    while unknown := data.least_known(values, free):
        free.remove(unknown)
        values, notes[unknown] = data.without(values, free, unknown)
    return data.result(values, free, notes)


@dataclass(frozen=True, eq=False)
class _Response:
    """B-hat-prime of a target as the simple function of the properties that it is at each point.

    ICs = (fixed + nu by_nu + mismatch_k by_k) / (G / G of the half-space) + apart, (n_components, n) each.
    """

    fixed: Array
    by_nu: Array
    by_k: Array
    apart: Array

    @classmethod
    def of(cls, target: Target) -> "_Response":
        """From ICs with three constant pairs of nu and K."""
        nearest, at_most = float(np.min(target.r)), 0.5

        def at(nu: float, mismatch_k: float) -> Array:
            both = (Transition(value, nearest, 1.0, 1.0) for value in (nu, mismatch_k))
            return target.of(EffectiveProperties(None, *both))

        base = at(0.0, 0.0)
        apart = target.apart
        return cls(base - apart, (at(at_most, 0.0) - base) / at_most, at(0.0, 1.0) - base, apart)

    def __call__(self, G: float | Array, nu: float | Array, mismatch_k: float | Array) -> Array:
        """ICs; G over that of the half-space."""
        return np.asarray((self.fixed + nu * self.by_nu + mismatch_k * self.by_k) / G + self.apart)


@dataclass(frozen=True, eq=False)
class _Data:
    """A target in the order of distances, and the scales that make the fit independent of units."""

    target: Target
    response: _Response
    properties: tuple[str, ...]
    half_space: Mapping[str, float]  # all properties' values there

    @classmethod
    def of(cls, target: Target, properties: tuple[str, ...]) -> "_Data":
        counted = np.flatnonzero(target.weights > 0)
        order = counted[np.lexsort((target.s[counted], target.x[counted], target.r[counted]))]
        sorted_target = replace(
            target,
            **{name: getattr(target, name)[..., order] for name in ("x", "s", "ics", "weights")},
            error=np.broadcast_to(target.error, target.ics.shape)[:, order],
        )
        constants = target.solid.constants
        unknown = [name for name in properties if name not in FAR_BOUNDS]
        if unknown or not properties:
            raise WrongInput(f"properties = {', '.join(unknown) or 'none'}: of {', '.join(FAR_BOUNDS)}")
        half_space = {name: float(getattr(constants, name)) for name in FAR_BOUNDS}
        return cls(sorted_target, _Response.of(sorted_target), properties, half_space)

    def unit(self, name: str) -> float:
        """Of the far value of a property."""
        return self.half_space[name] if name == "G" else 1.0

    def bounds(self, name: str, parameter: str) -> tuple[float, float]:
        """Of the variable that stands for a parameter: far in its unit, logarithms of the others."""
        if parameter == "far":
            return FAR_BOUNDS[name]
        r = self.target.r
        low, high = (r[0], REACH * r[-1]) if parameter == "r_inf" else EXPONENTS[parameter]
        return float(np.log(low)), float(np.log(high))

    def neutral(self, name: str, parameter: str) -> float:
        """What a parameter is fixed at."""
        of_parameter = {"far": self.half_space[name], "r_inf": float(self.target.r[-1])}
        return of_parameter.get(parameter, 1.0)

    def to_variable(self, name: str, parameter: str, value: float) -> float:
        """The variable of a parameter."""
        return value / self.unit(name) if parameter == "far" else float(np.log(value))

    def to_value(self, name: str, parameter: str, variable: float) -> float:
        """The parameter of a variable."""
        return variable * self.unit(name) if parameter == "far" else float(np.exp(variable))

    def starting_values(self) -> Values:
        """Nothing varies."""
        return {name: {p: self.neutral(name, p) for p in PARAMETERS} for name in self.properties}

    def deviations(self, ics: Array) -> Array:
        """Weighted deviations of ICs from the target, in shares of the largest, flat."""
        target = self.target
        return np.asarray((target.weights * (ics - target.ics) / target.scales).ravel())

    def ics(self, values: Values) -> Array:
        """ICs by B-hat-prime."""
        r, at = self.target.r, dict[str, float | Array](self.half_space)
        for name, parameters in values.items():
            at[name] = Transition(**parameters).at(r, self.half_space[name])
        return self.response(at["G"] / self.half_space["G"], at["nu"], at["mismatch_k"])

    def starts(self, values: Values) -> list[Values]:
        """Where to begin: the best values of each property on a grid, one property after the other."""
        starts = [values]
        for name in self.properties:
            starts = self._on_grid(name, starts[0])
        return starts

    def _on_grid(self, name: str, values: Values) -> list[Values]:
        """The best of a grid of (r_inf, m, n), each with its best far value if ICs were linear in it."""
        step = 0.01 * self.unit(name)
        base = self.deviations(self.ics(values))
        everywhere = {"far": self.half_space[name] + step, "r_inf": self.target.r[0], "m": 1.0, "n": 1.0}
        slope = (self.deviations(self.ics(values | {name: everywhere})) - base) / step
        if not np.any(slope):
            raise WrongInput(f"properties: {', '.join(self.target.components)} do not depend on {name}")
        axes = [
            np.exp(np.linspace(*self.bounds(name, parameter), count))
            for parameter, count in zip(("r_inf", "m", "n"), GRID, strict=True)
        ]
        low, high = (bound * self.unit(name) for bound in FAR_BOUNDS[name])
        found: list[dict[str, float]] = []
        costs = np.empty(GRID)
        for index, (r_inf, m, n) in zip(np.ndindex(GRID), product(*axes), strict=True):
            share = Transition(1.0, r_inf, m, n).at(self.target.r, 0.0)
            effect = slope * np.tile(share, len(self.target.components))
            far = self.half_space[name] - float(base @ effect) / max(float(effect @ effect), 1e-300)
            far = float(np.clip(far, low, high))
            rest = base + (far - self.half_space[name]) * effect
            found.append({"far": far, "r_inf": r_inf, "m": m, "n": n})
            costs[index] = rest @ rest
        ranked = np.argsort(costs, axis=None, kind="stable")
        lowest = (costs == minimum_filter(costs, 3)).ravel()[ranked]
        of_r_inf = np.argmin(costs.reshape(GRID[0], -1), axis=1) + np.arange(GRID[0]) * GRID[1] * GRID[2]
        chosen = dict.fromkeys([*ranked[:STARTS], *ranked[lowest][:STARTS], *of_r_inf])
        return [values | {name: found[k]} for k in chosen]

    def best(self, values: Values, free: Sequence[tuple[str, str]], starts: Sequence[Values]) -> Values:
        """The values of least squares from several starts; what is not free stays as in `values`."""
        if not free:
            return values
        low, high = np.array([self.bounds(*which) for which in free]).T

        deviations = self._deviations_of(values, free)

        def polished(first: Array, stop: Mapping[str, float]) -> tuple[float, Array]:
            inside = np.clip(first, low + INSIDE * (high - low), high - INSIDE * (high - low))
            one = least_squares(deviations, inside, bounds=(low, high), jac="3-point", **stop)
            return float(one.cost), one.x

        firsts = [
            np.array([self.to_variable(*which, start[which[0]][which[1]]) for which in free])
            for start in starts
        ]
        rough = sorted((polished(first, ROUGH) for first in firsts), key=lambda one: one[0])
        closest = min((polished(x, EXACT) for _, x in rough[:FINALISTS]), key=lambda one: one[0])[1]
        return self._at(values, free, closest)

    def _at(self, values: Values, free: Sequence[tuple[str, str]], variables: Array) -> Values:
        """Values with other ones of what is free, by its variables."""
        changed = {name: dict(parameters) for name, parameters in values.items()}
        for (name, parameter), variable in zip(free, variables, strict=True):
            changed[name][parameter] = self.to_value(name, parameter, float(variable))
        return changed

    def _deviations_of(self, values: Values, free: Sequence[tuple[str, str]]) -> Callable[[Array], Array]:
        """Deviations as a function of the variables of what is free."""
        return lambda variables: self.deviations(self.ics(self._at(values, free, variables)))

    def without(
        self, values: Values, free: Sequence[tuple[str, str]], unknown: tuple[str, str]
    ) -> tuple[Values, str]:
        """Values with one parameter fixed: neutral if the others can make up for that, else as it is."""
        name, parameter = unknown
        neutral = self.neutral(name, parameter)
        fixed = self.best(values | {name: values[name] | {parameter: neutral}}, free, [values])
        allowed = self.cost(values) + NO_WORSE * self.variance(values, len(free) + 1)
        if self.cost(fixed) <= allowed:
            return fixed, "not determined by the data"
        return values, "not determined by the data, kept"

    def cost(self, values: Values) -> float:
        """Sum of squares."""
        rest = self.deviations(self.ics(values))
        return float(rest @ rest)

    def at_bound(self, values: Values, which: tuple[str, str]) -> bool:
        """Whether a parameter lies on a bound."""
        low, high = self.bounds(*which)
        variable = self.to_variable(*which, values[which[0]][which[1]])
        return min(variable - low, high - variable) < 1e-6 * (high - low)

    def covariance(self, values: Values, free: Sequence[tuple[str, str]]) -> Array:
        """Covariance of the variables; on the diagonal infinite where the data do not determine one."""
        jacobian = self._jacobian(values, free)
        lengths = np.linalg.norm(jacobian, axis=0)
        if not np.all(lengths > 0):
            return np.diag(np.where(lengths > 0, 0.0, np.inf))
        _, singular, rows = np.linalg.svd(jacobian / lengths, full_matrices=False)
        weighted = rows.T / np.maximum(singular, 1e-14) / lengths[:, None]
        return np.asarray(self.variance(values, len(free)) * (weighted @ weighted.T))

    def variance(self, values: Values, n_free: int) -> float:
        """Of the deviation of a point: the residual's, or the target's error, or rounding."""
        rest = self.deviations(self.ics(values))
        target = self.target
        known = (target.weights * target.error / target.scales).ravel()
        rounding = ROUNDING * np.mean(target.weights)
        per_point = float(rest @ rest) / max(rest.size - n_free, 1)
        return float(np.max([per_point, np.mean(known**2), rounding**2]))

    def _jacobian(self, values: Values, free: Sequence[tuple[str, str]]) -> Array:
        """Of the deviations with respect to the variables of what is free, (n_deviations, n_free)."""
        bounds = np.array([self.bounds(*which) for which in free]).T
        variables = np.array([self.to_variable(*which, values[which[0]][which[1]]) for which in free])
        at_values = least_squares(
            self._deviations_of(values, free), np.clip(variables, *bounds), "3-point", bounds, max_nfev=1
        )
        return np.asarray(at_values.jac)

    def least_known(self, values: Values, free: Sequence[tuple[str, str]]) -> tuple[str, str] | None:
        """The free parameter that is known worst, if the data do not determine it."""
        inside = [which for which in free if not self.at_bound(values, which)]
        if not inside:
            return None
        deviations = np.sqrt(np.diag(self.covariance(values, inside)))
        limits = [self._limit(values, *which) for which in inside]
        ratios = deviations / np.array(limits)
        worst = int(np.argmax(ratios))
        return inside[worst] if ratios[worst] > 1 else None

    def _limit(self, values: Values, name: str, parameter: str) -> float:
        if parameter != "far":
            return KNOWN
        return max(KNOWN * abs(values[name]["far"] - self.half_space[name]) / self.unit(name), 1e-12)

    def result(
        self, values: Values, free: Sequence[tuple[str, str]], notes: Mapping[tuple[str, str], str]
    ) -> Fit:
        """The fit as others see it."""
        at_bounds = [which for which in free if self.at_bound(values, which)]
        fitted = [which for which in free if which not in at_bounds]
        # d value / d variable: far is linear, the others are exponentials
        slopes = [
            self.unit(name) if parameter == "far" else values[name][parameter] for name, parameter in fitted
        ]
        covariance = np.zeros((0, 0))
        if fitted:
            covariance = self.covariance(values, fitted) * np.outer(slopes, slopes)
        spread = dict(zip(fitted, np.sqrt(np.diag(covariance)), strict=True))
        parameters = tuple(
            Parameter(
                f"{name}.{parameter}",
                values[name][parameter],
                float(spread[name, parameter]) if (name, parameter) in spread else None,
                "at its bound" if (name, parameter) in at_bounds else notes.get((name, parameter), ""),
            )
            for name in self.properties
            for parameter in PARAMETERS
        )
        off = np.abs(self.target.of(properties_of(values)) - self.target.ics) / self.target.scales
        return Fit(
            properties_of(values),
            parameters,
            covariance,
            np.sqrt(np.mean(off**2, axis=1)),
            np.max(off, axis=1),
        )


def properties_of(values: Values) -> EffectiveProperties:
    """Effective properties with given parameters."""
    return EffectiveProperties(**{name: Transition(**of_one) for name, of_one in values.items()})
