"""Fit of effective properties to known ICs: the A' with which B-hat-prime comes closest to them."""

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

Key = tuple[str, str]  # of a parameter: property, parameter
Values = dict[Key, float]

PARAMETERS = ("far", "r_inf", "m", "n")
FAR_BOUNDS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"mismatch_k": (-5.0, 5.0), "G": (0.05, 20.0), "nu": (0.0, 0.5)}  # G as a multiple of the half-space's G
)
EXPONENTS: Mapping[str, tuple[float, float]] = MappingProxyType(  # n below 1: infinite slope at r_inf
    {"m": (0.2, 10.0), "n": (1.0, 50.0)}
)
R_INF_REACH = 2.0  # largest r_inf over the largest distance of the data; the least r_inf is the smallest
START_GRID = (24, 12, 12)  # numbers of values of r_inf, m, n on the grid of which the starts are chosen
STARTS = 12  # starts: so many of the best points of the grid, as many local minima, the best of each r_inf
ROUGH_OPTIONS = {"xtol": 1e-7, "ftol": 1e-7, "gtol": 1e-7, "max_nfev": 25}  # of the optimiser, for all starts
EXACT_OPTIONS = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15, "max_nfev": 300}  # for the finalists
FINALISTS = 5  # number of starts that are optimised to the end
INSIDE = 1e-3  # least distance of a start from the bounds, as a share of their distance
IC_ROUNDING = 1e-10  # deviations below this share of the largest IC are rounding
NO_WORSE = 4.0  # how much fixing a parameter may raise the sum of squares, in variances of a point
KNOWN_DEVIATION = 0.5  # standard deviation of log r_inf, log m, log n up to which the data determine them


@dataclass(frozen=True)
class Parameter:
    """A parameter with its standard deviation `deviation`, None if it was not fitted; `note` says why not."""

    name: str  # such as "mismatch_k.far"
    value: float
    deviation: float | None
    note: str = ""


@dataclass(frozen=True, eq=False)
class Fit:
    """The result of a fit.

    `covariance` (n_fitted, n_fitted) belongs to the fitted parameters in their order. It takes the deviations
    of the points as independent, and as large as the residual or, if larger, the error of the target. `rms`
    and `worst` (n_components,) are the root mean square and the largest deviation of each component, as
    shares of its largest IC.
    """

    effective: EffectiveProperties
    parameters: tuple[Parameter, ...]
    covariance: Array
    rms: Array
    worst: Array

    @property
    def full_covariance(self) -> Array:
        """The covariance of all parameters (n_parameters, n_parameters), NaN for fixed ones."""
        fitted = [k for k, parameter in enumerate(self.parameters) if parameter.deviation is not None]
        full = np.full((len(self.parameters),) * 2, np.nan)
        full[np.ix_(fitted, fitted)] = self.covariance
        return full


def fit(target: Target, properties: Sequence[str] = ("mismatch_k",)) -> Fit:
    """Fit transitions of properties by weighted least squares within their bounds.

    The bounds are `FAR_BOUNDS`, `EXPONENTS` and `R_INF_REACH`. Each component counts alike. Parameters that
    the data do not determine are fixed one after the other, the least known first: m, n at 1 (a linear
    transition), r_inf at the largest distance, far at the value of the half-space; or, where that would make
    the fit worse, at their fitted value. Raises WrongInput for unknown properties, for none, and for those
    that the components do not depend on.
    """
    data = _Data.of(target, tuple(properties))
    values, free = data.starting_values(), list(product(properties, PARAMETERS))
    notes: dict[Key, str] = {}
    values = data.best(values, free, data.starts(values))
    while undetermined := data.least_known(values, free):
        free.remove(undetermined)
        values, notes[undetermined] = data.without(values, free, undetermined)
    return data.result(values, free, notes)


@dataclass(frozen=True, eq=False)
class _Response:
    """B-hat-prime at the points of a target as an explicit function of the properties at each point.

    ICs = (fixed + nu by_nu + mismatch_k by_k) / (G / G of the half-space) + apart. All arrays are in mm/MPa
    and have the shape (n_components, n).
    """

    fixed: Array
    by_nu: Array
    by_k: Array
    apart: Array

    @classmethod
    def of(cls, target: Target) -> "_Response":
        """Return the function, from ICs with three constant pairs of nu and K."""
        r_min, nu_max = float(np.min(target.r)), 0.5

        def ics(nu: float, mismatch_k: float) -> Array:
            transitions = (Transition(value, r_min, 1.0, 1.0) for value in (nu, mismatch_k))
            return target.bhat_prime(EffectiveProperties(None, *transitions))

        at_zero = ics(0.0, 0.0)
        apart = target.apart
        return cls(at_zero - apart, (ics(nu_max, 0.0) - at_zero) / nu_max, ics(0.0, 1.0) - at_zero, apart)

    def __call__(self, G: float | Array, nu: float | Array, mismatch_k: float | Array) -> Array:
        """ICs [mm/MPa], shape (n_components, n); G is given as a multiple of the half-space's G."""
        return np.asarray((self.fixed + nu * self.by_nu + mismatch_k * self.by_k) / G + self.apart)


@dataclass(frozen=True, eq=False)
class _Data:
    """A target with its points in the order of their distances, and the function that gives B-hat-prime.

    The optimiser works on variables: far in `unit`s, and the logarithms of r_inf, m and n. So the fit does
    not depend on units.
    """

    target: Target
    response: _Response
    properties: tuple[str, ...]
    half_space: Mapping[str, float]  # values of all properties of the half-space

    @classmethod
    def of(cls, target: Target, properties: tuple[str, ...]) -> "_Data":
        """Return the data of a fit: the points of a target whose weight is not 0."""
        weighted = np.flatnonzero(target.weights > 0)
        order = weighted[np.lexsort((target.s[weighted], target.x[weighted], target.r[weighted]))]
        sorted_target = replace(
            target,
            **{name: getattr(target, name)[..., order] for name in ("x", "s", "ics", "weights")},
            error=np.broadcast_to(target.error, target.ics.shape)[:, order],
        )
        constants = target.solid.constants
        unknown_names = [name for name in properties if name not in FAR_BOUNDS]
        if unknown_names or not properties:
            raise WrongInput(f"properties = {', '.join(unknown_names) or 'none'}: of {', '.join(FAR_BOUNDS)}")
        half_space = {name: float(getattr(constants, name)) for name in FAR_BOUNDS}
        return cls(sorted_target, _Response.of(sorted_target), properties, half_space)

    def unit(self, name: str) -> float:
        """Unit of the variable of a property's far value: G of the half-space, or 1."""
        return self.half_space[name] if name == "G" else 1.0

    def bounds(self, name: str, parameter: str) -> tuple[float, float]:
        """Lower and upper bound of the variable of a parameter."""
        if parameter == "far":
            return FAR_BOUNDS[name]
        r = self.target.r
        low, high = (r[0], R_INF_REACH * r[-1]) if parameter == "r_inf" else EXPONENTS[parameter]
        return float(np.log(low)), float(np.log(high))

    def neutral(self, name: str, parameter: str) -> float:
        """The value at which a parameter without effect on the fit is fixed."""
        neutral_values = {"far": self.half_space[name], "r_inf": float(self.target.r[-1])}
        return neutral_values.get(parameter, 1.0)

    def to_variable(self, name: str, parameter: str, value: float) -> float:
        """The variable that stands for a value of a parameter."""
        return value / self.unit(name) if parameter == "far" else float(np.log(value))

    def to_value(self, name: str, parameter: str, variable: float) -> float:
        """The value of a parameter that a variable stands for."""
        return variable * self.unit(name) if parameter == "far" else float(np.exp(variable))

    def variables(self, values: Values, free: Sequence[Key]) -> Array:
        """The variables that stand for the values of the free parameters, shape (n_free,)."""
        return np.array([self.to_variable(*key, values[key]) for key in free])

    def starting_values(self) -> Values:
        """Values with which no property varies."""
        return {key: self.neutral(*key) for key in product(self.properties, PARAMETERS)}

    def deviations(self, ics: Array) -> Array:
        """Weighted deviations of ICs from the target, as shares of each component's largest IC.

        Shape (n_components * n,).
        """
        target = self.target
        return np.asarray((target.weights * (ics - target.ics) / target.scales).ravel())

    def ics(self, values: Values) -> Array:
        """B-hat-prime [mm/MPa], shape (n_components, n)."""
        r, constants = self.target.r, dict[str, float | Array](self.half_space)
        for name, transition in transitions(values).items():
            constants[name] = transition.at(r, self.half_space[name])
        return self.response(constants["G"] / self.half_space["G"], constants["nu"], constants["mismatch_k"])

    def starts(self, values: Values) -> list[Values]:
        """Values to start from: the best of a grid for each property, one property after the other."""
        starts = [values]
        for name in self.properties:
            starts = self._on_grid(name, starts[0])
        return starts

    def _on_grid(self, name: str, values: Values) -> list[Values]:
        """The best points of a grid of (r_inf, m, n), each with the best far value of ICs linear in it.

        Raises WrongInput where the ICs do not depend on the property.
        """
        step = 0.01 * self.unit(name)
        base = self.deviations(self.ics(values))
        constant = _of(name, self.half_space[name] + step, self.target.r[0], 1.0, 1.0)
        slope = (self.deviations(self.ics(values | constant)) - base) / step
        if not np.any(slope):
            raise WrongInput(f"properties: {', '.join(self.target.components)} do not depend on {name}")
        axes = [
            np.exp(np.linspace(*self.bounds(name, parameter), count))
            for parameter, count in zip(("r_inf", "m", "n"), START_GRID, strict=True)
        ]
        low, high = (bound * self.unit(name) for bound in FAR_BOUNDS[name])
        candidates: list[Values] = []
        costs = np.empty(START_GRID)
        for index, (r_inf, m, n) in zip(np.ndindex(START_GRID), product(*axes), strict=True):
            share = Transition(1.0, r_inf, m, n).at(self.target.r, 0.0)
            effect = slope * np.tile(share, len(self.target.components))
            far = self.half_space[name] - float(base @ effect) / max(float(effect @ effect), 1e-300)
            far = float(np.clip(far, low, high))
            deviations = base + (far - self.half_space[name]) * effect
            candidates.append(_of(name, far, r_inf, m, n))
            costs[index] = deviations @ deviations
        ranked = np.argsort(costs, axis=None, kind="stable")
        is_minimum = (costs == minimum_filter(costs, 3)).ravel()[ranked]
        best_of_r_inf = (
            np.argmin(costs.reshape(START_GRID[0], -1), axis=1)
            + np.arange(START_GRID[0]) * START_GRID[1] * START_GRID[2]
        )
        start_numbers = dict.fromkeys([*ranked[:STARTS], *ranked[is_minimum][:STARTS], *best_of_r_inf])
        return [values | candidates[number] for number in start_numbers]

    def best(self, values: Values, free: Sequence[Key], starts: Sequence[Values]) -> Values:
        """The values of least squares from several starts; other parameters stay as in `values`."""
        if not free:
            return values
        low, high = np.array([self.bounds(*key) for key in free]).T

        deviations = self._deviations_of(values, free)

        def polished(start_variables: Array, options: Mapping[str, float]) -> tuple[float, Array]:
            inside = np.clip(start_variables, low + INSIDE * (high - low), high - INSIDE * (high - low))
            result = least_squares(deviations, inside, bounds=(low, high), jac="3-point", **options)
            return float(result.cost), result.x

        candidates = sorted(
            (polished(self.variables(start, free), ROUGH_OPTIONS) for start in starts),
            key=lambda result: result[0],
        )
        best_variables = min(
            (polished(variables, EXACT_OPTIONS) for _, variables in candidates[:FINALISTS]),
            key=lambda result: result[0],
        )[1]
        return self._at(values, free, best_variables)

    def _at(self, values: Values, free: Sequence[Key], variables: Array) -> Values:
        """The values in which free parameters have the values that their variables stand for."""
        return values | {
            key: self.to_value(*key, float(variable)) for key, variable in zip(free, variables, strict=True)
        }

    def _deviations_of(self, values: Values, free: Sequence[Key]) -> Callable[[Array], Array]:
        """Deviations as a function of the variables of the free parameters."""
        return lambda variables: self.deviations(self.ics(self._at(values, free, variables)))

    def without(self, values: Values, free: Sequence[Key], undetermined: Key) -> tuple[Values, str]:
        """Values with one parameter fixed, and a note on it.

        It is fixed at its neutral value if the other parameters can make up for that, else at its present
        one.
        """
        refitted = self.best(values | {undetermined: self.neutral(*undetermined)}, free, [values])
        allowed = self.cost(values) + NO_WORSE * self.variance(values, len(free) + 1)
        if self.cost(refitted) <= allowed:
            return refitted, "not determined by the data"
        return values, "not determined by the data, kept"

    def cost(self, values: Values) -> float:
        """Sum of squared deviations."""
        deviations = self.deviations(self.ics(values))
        return float(deviations @ deviations)

    def at_bound(self, values: Values, key: Key) -> bool:
        """Whether a parameter lies on one of its bounds."""
        low, high = self.bounds(*key)
        variable = self.to_variable(*key, values[key])
        return min(variable - low, high - variable) < 1e-6 * (high - low)

    def covariance(self, values: Values, free: Sequence[Key]) -> Array:
        """Covariance of the variables of the free parameters, shape (n_free, n_free).

        If the deviations do not depend on some variables at all, their entries on the diagonal are infinite
        and all other entries are 0.
        """
        jacobian = self._jacobian(values, free)
        lengths = np.linalg.norm(jacobian, axis=0)
        if not np.all(lengths > 0):
            return np.diag(np.where(lengths > 0, 0.0, np.inf))
        _, singular, rows = np.linalg.svd(jacobian / lengths, full_matrices=False)
        weighted = rows.T / np.maximum(singular, 1e-14) / lengths[:, None]
        return np.asarray(self.variance(values, len(free)) * (weighted @ weighted.T))

    def variance(self, values: Values, n_free: int) -> float:
        """Variance of the deviation of a point: the largest of residual, target error, and rounding."""
        deviations = self.deviations(self.ics(values))
        target = self.target
        target_errors = (target.weights * target.error / target.scales).ravel()
        rounding = IC_ROUNDING * np.mean(target.weights)
        per_point = float(deviations @ deviations) / max(deviations.size - n_free, 1)
        return float(np.max([per_point, np.mean(target_errors**2), rounding**2]))

    def _jacobian(self, values: Values, free: Sequence[Key]) -> Array:
        """Derivatives of the deviations by the variables of the free parameters, (n_deviations, n_free)."""
        bounds = np.array([self.bounds(*key) for key in free]).T
        start = np.clip(self.variables(values, free), *bounds)
        result = least_squares(self._deviations_of(values, free), start, "3-point", bounds, max_nfev=1)
        return np.asarray(result.jac)

    def least_known(self, values: Values, free: Sequence[Key]) -> Key | None:
        """The free parameter that is known worst, or None if the data determine all free parameters.

        Parameters at a bound are left out.
        """
        inside = [key for key in free if not self.at_bound(values, key)]
        if not inside:
            return None
        deviations = np.sqrt(np.diag(self.covariance(values, inside)))
        limits = [self._limit(values, *key) for key in inside]
        ratios = deviations / np.array(limits)
        least_known = int(np.argmax(ratios))
        return inside[least_known] if ratios[least_known] > 1 else None

    def _limit(self, values: Values, name: str, parameter: str) -> float:
        """Standard deviation of a variable up to which the data determine it."""
        if parameter != "far":
            return KNOWN_DEVIATION
        return max(
            KNOWN_DEVIATION * abs(values[name, "far"] - self.half_space[name]) / self.unit(name), 1e-12
        )

    def result(self, values: Values, free: Sequence[Key], notes: Mapping[Key, str]) -> Fit:
        """The result of the fit: parameters at a bound have no standard deviation."""
        bounded = [key for key in free if self.at_bound(values, key)]
        fitted = [key for key in free if key not in bounded]
        # d value / d variable: far is linear, the others are exponentials
        slopes = [self.unit(key[0]) if key[1] == "far" else values[key] for key in fitted]
        covariance = np.zeros((0, 0))
        if fitted:
            covariance = self.covariance(values, fitted) * np.outer(slopes, slopes)
        spread = dict(zip(fitted, np.sqrt(np.diag(covariance)), strict=True))
        parameters = tuple(
            Parameter(
                ".".join(key),
                values[key],
                float(spread[key]) if key in spread else None,
                "at its bound" if key in bounded else notes.get(key, ""),
            )
            for key in product(self.properties, PARAMETERS)
        )
        effective = EffectiveProperties(**transitions(values))
        shares = np.abs(self.target.bhat_prime(effective) - self.target.ics) / self.target.scales
        return Fit(
            effective,
            parameters,
            covariance,
            np.sqrt(np.mean(shares**2, axis=1)),
            np.max(shares, axis=1),
        )


def _of(name: str, *values: float) -> Values:
    """The values of the parameters of one property, in the order of `PARAMETERS`."""
    return {(name, parameter): value for parameter, value in zip(PARAMETERS, values, strict=True)}


def transitions(values: Values) -> dict[str, Transition]:
    """The transitions of the properties with the given values of their parameters."""
    names = dict.fromkeys(name for name, _ in values)
    return {name: Transition(*(values[name, parameter] for parameter in PARAMETERS)) for name in names}
