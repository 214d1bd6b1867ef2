"""Calibration: the effective properties (A') with which B-hat-prime comes closest to known ICs.

A `Target` holds ICs at points, with weights and errors; `fit` finds the transitions of the properties.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from operator import itemgetter
from types import MappingProxyType

import numpy as np
from scipy.ndimage import minimum_filter
from scipy.optimize import least_squares

from approx.effective import EffectiveProperties, Transition
from approx.pair import Pair, Solid
from geometries.arrays import Array, Mask
from geometries.errors import WrongInput
from geometries.patches import Patch, places

# --- the target ---

FEWEST = 8  # least number of points
SPREAD = 1.5  # least ratio of the largest to the smallest distance


@dataclass(frozen=True, eq=False)
class Target:
    """ICs that B-hat-prime is to reproduce.

    `ics` (n_components, n) are ICs per unit pressure [mm/MPa] of `components` such as "xn" at observers
    (x, s) [mm], (n,) each, with x from the load and s from the contact centre; `error` [mm/MPa] is their
    error, of a shape that broadcasts to theirs. Deviations are multiplied by `weights` (n,). `solid` is a
    body or a pair without effective properties.

    Raises WrongInput for shapes that do not fit, values that are not finite, weights below 0, fewer than
    `FEWEST` points that count, points at one distance only, and components that are 0 at all of them.
    """

    solid: Solid | Pair
    patch: Patch
    x: Array
    s: Array
    components: tuple[str, ...]
    ics: Array
    weights: Array
    error: Array

    def __post_init__(self) -> None:
        self._check_arrays()
        self._check_distances()
        for component, values in zip(self.components, self.ics, strict=True):
            if not np.any(values[self.weights > 0]):
                raise WrongInput(f"{component}: all ICs are 0; choose other points or components")

    def _check_arrays(self) -> None:
        """Raise WrongInput for shapes that do not fit and values that are not finite."""
        points_shape = np.shape(self.x)
        for name, shape in {
            "s": points_shape,
            "weights": points_shape,
            "ics": (len(self.components), *points_shape),
        }.items():
            actual_shape = np.shape(getattr(self, name))
            if actual_shape != shape:
                raise WrongInput(f"{name} of shape {actual_shape}: {shape} is needed")
        try:
            np.broadcast_to(self.error, np.shape(self.ics))
        except ValueError as error:
            raise WrongInput(
                f"error of shape {np.shape(self.error)}: {np.shape(self.ics)} is needed"
            ) from error
        for name in ("x", "s", "ics", "weights", "error"):
            values = np.asarray(getattr(self, name))
            if not np.all(np.isfinite(values)):
                raise WrongInput(f"{name}: {np.sum(~np.isfinite(values))} of {values.size} not finite")

    def _check_distances(self) -> None:
        """Raise WrongInput for weights below 0, too few points, and points at one distance only."""
        counted = int(np.sum(self.weights > 0))
        if np.any(self.weights < 0) or counted < FEWEST:
            raise WrongInput(f"weights: {counted} points count; give {FEWEST} or more, no weight below 0")
        distances = np.sort(self.r[self.weights > 0])
        nearest, eighth, furthest = distances[[0, FEWEST - 1, -1]]
        if nearest == 0 or eighth < (1 + 1e-6) * nearest or furthest < SPREAD * nearest:
            raise WrongInput(
                f"points lie {nearest:g} ... {furthest:g} mm from the load, {FEWEST} of them up to "
                f"{eighth:g} mm: a property that varies with the distance needs points at different "
                f"distances above 0, the furthest {SPREAD:g} times as far as the nearest or more"
            )

    @property
    def r(self) -> Array:
        """Distances from the load [mm], shape (n,)."""
        return np.hypot(self.x, self.s - self.patch.s)

    @property
    def scales(self) -> Array:
        """Largest |IC| of each component [mm/MPa], shape (n_components, 1)."""
        return np.max(np.abs(self.ics[:, self.weights > 0]), axis=1, keepdims=True)

    @property
    def apart(self) -> Array:
        """The part of B-hat-prime [mm/MPa] that effective properties leave alone, shape of `ics`.

        It is due to the curvature of wheels along x, or 0.
        """
        solid = self.solid
        if not (isinstance(solid, Pair) and solid.curvature_apart):
            return np.zeros(np.shape(self.ics))
        return self._components(solid.curvature(self.patch, (self.x, self.s)))

    def bhat_prime(self, effective: EffectiveProperties) -> Array:
        """B-hat-prime with effective properties at the same points [mm/MPa], shape of `ics`."""
        solid = replace(self.solid, effective=effective)
        return self._components(solid.approximate("Bhat_prime", self.patch, (self.x, self.s)))

    def approximate(self, variant: str) -> Array:
        """A variant without effective properties at the same points [mm/MPa], shape of `ics`."""
        return self._components(self.solid.approximate(variant, self.patch, (self.x, self.s)))

    def _components(self, ics: Array) -> Array:
        """The components of the target, (n_components, n), among all ICs (3, 3, n)."""
        return np.asarray(ics[places(self.components)])


def octave_weights(r: Array) -> Array:
    """Return weights (n,) [-] for which evenly spaced points count alike per octave of their distances (n,).

    Their squares are proportional to 1 / r; the weight of the nearest point is 1.
    """
    return np.asarray(np.sqrt(np.min(r) / r))


def pointwise_k(target: Target) -> Array:
    """K [-] with which B-hat-prime equals the target, (n_components, n); NaN where K has no effect."""
    r_min = float(np.min(target.r[target.r > 0]))

    def with_k(value: float) -> Array:
        return target.bhat_prime(EffectiveProperties(mismatch_k=Transition(value, r_min, 1.0, 1.0)))

    at_zero, slope = with_k(0.0), with_k(1.0) - with_k(0.0)
    return (target.ics - at_zero) / np.where(slope == 0, np.nan, slope)


# --- the fit ---

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
    data = _Data.prepare(target, tuple(properties))
    free = list(range(len(data.keys)))
    notes: dict[int, str] = {}
    values = data.best(data.neutral, free, data.starts())
    while (undetermined := data.least_known(values, free)) is not None:
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
    def linearise(cls, target: Target) -> "_Response":
        """Find the function from ICs with three constant pairs of nu and K."""
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

    Values of the parameters are arrays in the order of `keys`; `free` parameters are listed by their numbers.
    The optimiser works on variables: far in units of `unit`, and the logarithms of r_inf, m and n. So the fit
    does not depend on units.
    """

    target: Target
    response: _Response
    half_space: Mapping[str, float]  # values of all properties of the half-space
    keys: tuple[tuple[str, str], ...]  # property and name of each parameter
    is_far: Mask  # (n_parameters,) which parameters are far values
    unit: Array  # (n_parameters,) G of the half-space for the far value of G, else 1
    bounds: Array  # (2, n_parameters) of the variables
    neutral: Array  # (n_parameters,) values with which no property varies

    @classmethod
    def prepare(cls, target: Target, properties: tuple[str, ...]) -> "_Data":
        """Prepare the data of a fit: the points of a target whose weight is not 0."""
        weighted = np.flatnonzero(target.weights > 0)
        order = weighted[np.lexsort((target.s[weighted], target.x[weighted], target.r[weighted]))]
        sorted_target = replace(
            target,
            **{name: getattr(target, name)[..., order] for name in ("x", "s", "ics", "weights")},
            error=np.broadcast_to(target.error, target.ics.shape)[:, order],
        )
        unknown_names = [name for name in properties if name not in FAR_BOUNDS]
        if unknown_names or not properties:
            raise WrongInput(f"properties = {', '.join(unknown_names) or 'none'}: of {', '.join(FAR_BOUNDS)}")
        half_space = {name: float(getattr(target.solid.constants, name)) for name in FAR_BOUNDS}
        keys = tuple(product(properties, PARAMETERS))
        nearest, *_, furthest = sorted_target.r
        limits = {"r_inf": (nearest, R_INF_REACH * furthest), **EXPONENTS}
        bounds = [
            FAR_BOUNDS[name] if parameter == "far" else np.log(limits[parameter]).tolist()
            for name, parameter in keys
        ]
        neutral = [
            {"far": half_space[name], "r_inf": furthest}.get(parameter, 1.0) for name, parameter in keys
        ]
        return cls(
            sorted_target,
            _Response.linearise(sorted_target),
            half_space,
            keys,
            np.array([parameter == "far" for _, parameter in keys]),
            np.array([half_space["G"] if key == ("G", "far") else 1.0 for key in keys]),
            np.transpose(bounds),
            np.array(neutral),
        )

    def variables(self, values: Array) -> Array:
        """The variables that stand for the values of the parameters, shape (n_parameters,)."""
        return np.where(self.is_far, values / self.unit, np.log(np.where(self.is_far, 1.0, values)))

    def changed(self, values: Array, free: Sequence[int], variables: Array) -> Array:
        """The values in which free parameters have the values that their variables (n_free,) stand for."""
        new_values = values.copy()
        new_values[free] = np.where(self.is_far[free], variables * self.unit[free], np.exp(variables))
        return new_values

    def transitions(self, values: Array) -> dict[str, Transition]:
        """The transitions of the properties."""
        names = dict.fromkeys(name for name, _ in self.keys)
        rows = values.reshape(-1, len(PARAMETERS)).tolist()
        return {name: Transition(*row) for name, row in zip(names, rows, strict=True)}

    def deviations(self, values: Array) -> Array:
        """Weighted deviations of B-hat-prime from the target, as shares of each component's largest IC.

        Shape (n_components * n,).
        """
        target, constants = self.target, dict[str, float | Array](self.half_space)
        for name, transition in self.transitions(values).items():
            constants[name] = transition.at(target.r, self.half_space[name])
        ics = self.response(constants["G"] / self.half_space["G"], constants["nu"], constants["mismatch_k"])
        return np.asarray((target.weights * (ics - target.ics) / target.scales).ravel())

    def starts(self) -> list[Array]:
        """Values to start from: the best of a grid for each property, one property after the other."""
        starts = [self.neutral]
        for first in np.flatnonzero(self.is_far).tolist():
            starts = self._on_grid(first, starts[0])
        return starts

    def _on_grid(self, first: int, values: Array) -> list[Array]:
        """The best points of a grid of (r_inf, m, n), each with the best far value of ICs linear in it.

        They belong to the property whose first parameter is number `first`. Raises WrongInput where the ICs
        do not depend on it.
        """
        name, unit, f0 = self.keys[first][0], self.unit[first], self.neutral[first]

        def with_transition(*parameters: float) -> Array:
            new_values = values.copy()
            new_values[first : first + len(PARAMETERS)] = parameters
            return new_values

        step = 0.01 * unit
        base = self.deviations(values)
        slope = (self.deviations(with_transition(f0 + step, self.target.r[0], 1.0, 1.0)) - base) / step
        if not np.any(slope):
            raise WrongInput(f"properties: {', '.join(self.target.components)} do not depend on {name}")
        (lowest_far, highest_far), *axis_ends = self.bounds[:, first : first + len(PARAMETERS)].T.tolist()
        axes = [
            np.exp(np.linspace(low, high, count))
            for (low, high), count in zip(axis_ends, START_GRID, strict=True)
        ]
        candidates: list[Array] = []
        costs = np.empty(START_GRID)
        for index, (r_inf, m, n) in zip(np.ndindex(START_GRID), product(*axes), strict=True):
            share = Transition(1.0, r_inf, m, n).at(self.target.r, 0.0)
            effect = slope * np.tile(share, len(self.target.components))
            far = f0 - float(base @ effect) / max(float(effect @ effect), 1e-300)
            far = float(np.clip(far, lowest_far * unit, highest_far * unit))
            deviations = base + (far - f0) * effect
            candidates.append(with_transition(far, r_inf, m, n))
            costs[index] = deviations @ deviations
        ranked = np.argsort(costs, axis=None, kind="stable")
        is_minimum = (costs == minimum_filter(costs, 3)).ravel()[ranked]
        best_of_r_inf = (
            np.argmin(costs.reshape(START_GRID[0], -1), axis=1)
            + np.arange(START_GRID[0]) * START_GRID[1] * START_GRID[2]
        )
        start_numbers = dict.fromkeys([*ranked[:STARTS], *ranked[is_minimum][:STARTS], *best_of_r_inf])
        return [candidates[number] for number in start_numbers]

    def best(self, values: Array, free: Sequence[int], starts: Sequence[Array]) -> Array:
        """The values of least squares from several starts; other parameters stay as in `values`."""
        if not free:
            return values
        low, high = self.bounds[:, free]
        deviations = self._objective(values, free)

        def polished(start_variables: Array, options: Mapping[str, float]) -> tuple[float, Array]:
            inside = np.clip(start_variables, low + INSIDE * (high - low), high - INSIDE * (high - low))
            result = least_squares(deviations, inside, bounds=(low, high), jac="3-point", **options)
            return float(result.cost), result.x

        candidates = sorted(
            (polished(self.variables(start)[free], ROUGH_OPTIONS) for start in starts), key=itemgetter(0)
        )
        _, best_variables = min(
            (polished(variables, EXACT_OPTIONS) for _, variables in candidates[:FINALISTS]), key=itemgetter(0)
        )
        return self.changed(values, free, best_variables)

    def _objective(self, values: Array, free: Sequence[int]) -> Callable[[Array], Array]:
        """Deviations as a function of the variables of the free parameters."""
        return lambda variables: self.deviations(self.changed(values, free, variables))

    def without(self, values: Array, free: Sequence[int], undetermined: int) -> tuple[Array, str]:
        """Values with one parameter fixed, and a note on it.

        It is fixed at its neutral value if the other parameters can make up for that, else at its present
        one.
        """
        neutral = values.copy()
        neutral[undetermined] = self.neutral[undetermined]
        refitted = self.best(neutral, free, [values])
        allowed = self.cost(values) + NO_WORSE * self.variance(values, len(free) + 1)
        if self.cost(refitted) <= allowed:
            return refitted, "not determined by the data"
        return values, "not determined by the data, kept"

    def cost(self, values: Array) -> float:
        """Sum of squared deviations."""
        deviations = self.deviations(values)
        return float(deviations @ deviations)

    def at_bound(self, values: Array) -> Mask:
        """Which parameters lie on one of their bounds, (n_parameters,)."""
        low, high = self.bounds
        variables = self.variables(values)
        return np.asarray(np.minimum(variables - low, high - variables) < 1e-6 * (high - low))

    def covariance(self, values: Array, free: Sequence[int]) -> Array:
        """Covariance of the variables of the free parameters, shape (n_free, n_free).

        If the deviations do not depend on some variables at all, their entries on the diagonal are infinite
        and all other entries are 0.
        """
        start = np.clip(self.variables(values), *self.bounds)[free]
        deviations, bounds = self._objective(values, free), self.bounds[:, free]
        jacobian = least_squares(deviations, start, "3-point", bounds, max_nfev=1).jac
        lengths = np.linalg.norm(jacobian, axis=0)
        if not np.all(lengths > 0):
            return np.diag(np.where(lengths > 0, 0.0, np.inf))
        _, singular, rows = np.linalg.svd(jacobian / lengths, full_matrices=False)
        weighted = rows.T / np.maximum(singular, 1e-14) / lengths[:, None]
        return np.asarray(self.variance(values, len(free)) * (weighted @ weighted.T))

    def variance(self, values: Array, n_free: int) -> float:
        """Variance of the deviation of a point: the largest of residual, target error, and rounding."""
        target = self.target
        target_errors = (target.weights * target.error / target.scales).ravel()
        rounding = IC_ROUNDING * np.mean(target.weights)
        per_point = self.cost(values) / max(target.ics.size - n_free, 1)
        return float(np.max([per_point, np.mean(target_errors**2), rounding**2]))

    def least_known(self, values: Array, free: Sequence[int]) -> int | None:
        """The free parameter that is known worst, or None if the data determine all free parameters.

        Parameters at a bound are left out.
        """
        inside = self._inside(values, free)
        if not inside:
            return None
        far_limits = np.maximum(KNOWN_DEVIATION * np.abs(values - self.neutral) / self.unit, 1e-12)
        limits = np.where(self.is_far, far_limits, KNOWN_DEVIATION)[inside]
        ratios = np.sqrt(np.diag(self.covariance(values, inside))) / limits
        least_known = int(np.argmax(ratios))
        return inside[least_known] if ratios[least_known] > 1 else None

    def _inside(self, values: Array, free: Sequence[int]) -> list[int]:
        """The free parameters that do not lie on a bound."""
        at_bound = self.at_bound(values)
        return [number for number in free if not at_bound[number]]

    def result(self, values: Array, free: Sequence[int], notes: Mapping[int, str]) -> Fit:
        """The result of the fit: parameters at a bound have no standard deviation."""
        fitted = self._inside(values, free)
        # d value / d variable: far is linear, the others are exponentials
        slopes = np.where(self.is_far, self.unit, values)[fitted]
        covariance = np.zeros((0, 0))
        if fitted:
            covariance = self.covariance(values, fitted) * np.outer(slopes, slopes)
        spread = dict(zip(fitted, np.sqrt(np.diag(covariance)).tolist(), strict=True))
        all_notes = {**notes, **dict.fromkeys(set(free) - set(fitted), "at its bound")}
        parameters = tuple(
            Parameter(".".join(key), value, spread.get(number), all_notes.get(number, ""))
            for number, (key, value) in enumerate(zip(self.keys, values.tolist(), strict=True))
        )
        effective = EffectiveProperties(**self.transitions(values))
        shares = np.abs(self.target.bhat_prime(effective) - self.target.ics) / self.target.scales
        return Fit(
            effective,
            parameters,
            covariance,
            np.sqrt(np.mean(shares**2, axis=1)),
            np.max(shares, axis=1),
        )
