"""Statements 11, 12, 14 and 15: what the comparison of ICs rests on.

Poisson's ratio, the choice of a variant for each component, the engine; and limits that are known exactly.
"""

from collections.abc import Callable, Iterator, Mapping
from itertools import product

import numpy as np

from approx.cylinder import cavity_ics, half_plane_ics, solid_cylinder_ics
from approx.halfspace import HalfSpace
from compare.report.charts import Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.curves import ACROSS, BESIDE, BODIES, INDEPENDENT, Curve, per_body
from compare.validation.statements.frame import SATISFACTORY, Statement, Values, below
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.reference.job import component_of
from femic.results.ics import Results, engine_differences, ics_measure, reference_ics, select_ics
from geometries.arrays import Array
from geometries.materials import ElasticConstants, Material, one_body
from geometries.patches import COMPONENTS, Patch
from geometries.surfaces import LOWER, UPPER

# --- 11: Poisson's ratio --------------------------------------------------------------------------------

COMPARED_VARIANTS = ("A", "B", "Bbar", "Bhat")


def _errors_by_nu(runs: Runs) -> Iterator[tuple[str, Array, Array]]:
    """Yield geometry, body and component, and errors of variants at the own and at the other ratio."""
    for name, body, component in product(GEOMETRIES, BODIES, INDEPENDENT):
        own, other = (
            np.array([Curve(results, body, component).error(v) for v in COMPARED_VARIANTS])
            for results in (runs.geometry(name), runs.other_nu(name))
        )
        yield f"{name}, {body}, {component}", own, other


@below(SATISFACTORY, "change", "largest change of the error of A, B, B̄ or B̂ with ν")
def _change(runs: Runs) -> Values:
    return {case: float(np.max(np.abs(other - own))) for case, own, other in _errors_by_nu(runs)}


@below(
    SATISFACTORY, "order", "error of the variant that is best at this ν, minus the best error, at the other ν"
)
def _order(runs: Runs) -> Values:
    return {case: float(other[np.argmin(own)] - np.min(other)) for case, own, other in _errors_by_nu(runs)}


def _nu_panels(runs: Runs) -> Iterator[Panel]:
    places = (("combined", "nn", BESIDE), ("combined", "xn", BESIDE), ("lower", "sn", ACROSS))
    for name, place in product(GEOMETRIES, places):
        other = Curve(runs.other_nu(name), *place)
        more = {f"{variant}, other ν": other.variant(variant) for variant in ("C", "B")}
        yield Curve(runs.geometry(name), *place).panel("B", more=more)


# --- 12: the mix ----------------------------------------------------------------------------------------


def variant_errors(results: Results, body: str) -> dict[str, Array]:
    """Return errors (6,) [-] of the components, by variant, of all variants that exist for a body."""
    return {
        variant: np.array([Curve(results, body, component).error(variant) for component in INDEPENDENT])
        for variant in results.scene.variants
        if not np.any(np.isnan(select_ics(results, variant, body)))
    }


def mix_over_best(pooled: Callable[[Array], float]) -> Callable[[Results, str], float]:
    """Measure the pooled error of the components of the mix over the same of the best single variant."""

    def ratio(results: Results, body: str) -> float:
        errors = {variant: pooled(errors) for variant, errors in variant_errors(results, body).items()}
        return float(errors.pop("mix") / min(errors.values()))

    return ratio


def mean_errors(runs: Runs) -> Values:
    """Return the mean error over the components of every variant, by geometry and body."""
    return {
        f"mean error of {ics_symbol(variant)}: {name}, {body}": float(np.mean(errors))
        for name, body in product(GEOMETRIES, BODIES)
        for variant, errors in variant_errors(runs.fitted(name), body).items()
    }


def _mix_panels(runs: Runs) -> list[Panel]:
    fitted = runs.fitted(GEOMETRIES[0])
    lines = {component: BESIDE if component in ("xx", "xn") else ACROSS for component in INDEPENDENT}
    return [Curve(fitted, "combined", c, line).panel("Bhat", "mix") for c, line in lines.items()]


# --- 14: engines ----------------------------------------------------------------------------------------

TINY = 1e-9  # of a line's scale: smaller estimates count as this, as of what vanishes by symmetry


def largest_ratios(deviations: Mapping[str, Array], estimates: Mapping[str, Array]) -> Array:
    """Return the largest ratios of deviations to estimates (at least `TINY`) on a line, (3, 3)."""
    return np.max([deviations[line] / np.maximum(estimates[line], TINY) for line in deviations], axis=0)


def engine_agreement(runs: Runs) -> Values:
    """Return differences of the engines over the sum of their estimates, by geometry, body and component."""
    ratios: dict[str, float] = {}
    for name, body in product(GEOMETRIES, BODIES):
        largest = largest_ratios(*engine_differences(runs.with_both_engines(name), body))
        ratios |= {f"{name}, {body}, {c}": component_of(largest, c) for c in COMPONENTS}
    return ratios


def engine_details(runs: Runs) -> Values:
    """Return the largest estimates and the largest differences of the engines, by geometry and body [-]."""
    details = {}
    for name, body in product(GEOMETRIES, BODIES):
        results = runs.with_both_engines(name)
        estimates = ics_measure(results, body).shares(reference_ics(results, body).estimate)
        differences, _ = engine_differences(results, body)
        details[f"estimate of C, harmonic: {name}, {body}"] = float(np.max(list(estimates.values())))
        details[f"largest difference: {name}, {body}"] = float(np.max(list(differences.values())))
    return details


def _engine_panels(runs: Runs) -> list[Panel]:
    places = (("nn", ACROSS), ("sn", ACROSS), ("xn", BESIDE))
    return [
        Curve(runs.with_both_engines(name), "lower", *place).panel("C_solid")
        for name, place in product(GEOMETRIES, places)
    ]


# --- 15: limits -----------------------------------------------------------------------------------------

FAR_PATCHES = 1e5  # distance in patches at which A is compared with point loads
SAME_NUMBER = 1e-12  # relative difference of the same number computed in two ways
HALF_SPACE = 1e-9  # relative difference of A from point loads, with the first neglected term
NU = (0.0, 0.28, 0.5)
CYLINDERS = {"cavity": UPPER, "solid cylinder": LOWER}


def variant_deviations(runs: Runs) -> Values:
    """Return the largest deviation of each variant from A on the plane, as a share of the largest IC."""
    plane = runs.plane()

    def deviation(variant: str, body: str) -> float:
        a = select_ics(plane, "A", body)
        return float(np.max(np.abs(select_ics(plane, variant, body) - a)) / np.max(np.abs(a)))

    return {ics_symbol(v): max(deviation(v, body) for body in BODIES) for v in plane.scene.variants}


def error_over_estimate(results: Results, body: str) -> float:
    """Return the largest |C - A| over the estimate of C (at least `TINY`) of a component on a line."""
    c, measure = reference_ics(results, body), ics_measure(results, body)
    deviations = measure.shares(select_ics(results, "A", body) - c.ic)
    return float(np.max(largest_ratios(deviations, measure.shares(c.estimate))))


def deviation_from_limit(results: Results, body: str) -> float:
    """Return the largest |C - A| on a line as a share of max |A_ij| there, or of max |A_nn| if A_ij is 0."""
    deviations = []
    for line, component in product(results.scene.lines, INDEPENDENT):
        curve, nn = (Curve(results, body, name, line.name) for name in (component, "nn"))
        deviations.append(curve.largest("A") / (curve.size("A") or nn.size("A")))
    return max(deviations)


def far_field_error(nu: float) -> float:
    """Return the relative deviation of A, far from a patch, from point loads (Boussinesq, Cerruti)."""
    constants, patch = one_body(Material(210e3, nu), UPPER), Patch(0.2, 0.3)
    angle = np.linspace(0, 2 * np.pi, 65)[:-1] + 0.01
    x, s = FAR_PATCHES * patch.b * np.array([np.cos(angle), np.sin(angle)])
    a, limit = HalfSpace(constants).ics(patch, x, s) / patch.area, point_load(constants, x, s)
    return float(np.max(np.abs(a - limit)) / np.max(np.abs(limit)))


def point_load(constants: ElasticConstants, x: Array, s: Array) -> Array:
    """Return displacements of a half-space under unit point loads [mm/N], (3, 3, n), at x, s (n,) [mm]."""
    r = np.hypot(x, s)
    nu, k = constants.nu, constants.mismatch_k
    scale = constants.factor / (2 * np.pi * constants.G)
    along = np.array([x, s, np.zeros_like(r)]) / r
    across = np.einsum("ip,jp->ijp", along, along)
    direct = np.eye(3)[..., None] * (1 - nu) / r + nu * across / r
    to_normal = np.einsum("ip,j->ijp", along / r, [0, 0, 1])
    return np.asarray(scale * (direct - k * to_normal + k * np.swapaxes(to_normal, 0, 1)))


def cylinder_error(side: int, nu: float) -> float:
    """Return the relative deviation of B of line loads with the factor from the cavity or the solid cylinder.

    The upper body is the cavity, the lower body the solid cylinder.
    """
    alpha = np.linspace(0.01, np.pi - 0.01, 200) * np.array([[1], [-1]])
    exact, b = cylinder_ics(side, nu, alpha)
    return float(np.max(np.abs(exact - b)) / np.max(np.abs(exact)))


def cylinder_ics(side: int, nu: float, alpha: Array, *, factor: bool = True) -> tuple[Array, Array]:
    """Return exact ICs (2, 2, ...) of a cylinder of radius 1, without uniform radial displacement, and B."""
    material = Material(210e3, nu)
    exact = (cavity_ics if side == UPPER else solid_cylinder_ics)(material, alpha)
    if side == LOWER:
        exact[1, 1] += (1 - nu) / (2 * np.pi * material.G)
    a = half_plane_ics(material, side, 2 * np.sin(alpha / 2), 1.0)
    if factor:
        a[[0, 1], [1, 0]] *= (np.pi - np.abs(alpha)) / np.pi
    rotation = np.array([[np.cos(alpha), -np.sin(alpha)], [np.sin(alpha), np.cos(alpha)]])
    return exact, np.einsum("ik...,kj...->ij...", a, rotation)


@below(1.0, "plane", "plane: largest |C - A| / estimate of C")
def _plane(runs: Runs) -> Values:
    return {body: error_over_estimate(runs.plane(), body) for body in BODIES}


@below(
    0.01,
    "nearly plane",
    "arc of 1000 reference lengths: |C - A| on a line, of max |A_ij|, of max |A_nn| if A_ij is 0",
)
def _nearly_plane(runs: Runs) -> Values:
    return {body: deviation_from_limit(runs.nearly_plane(), body) for body in BODIES}


@below(HALF_SPACE, "point loads", "A at 1e5 patches: relative deviation from point loads")
def _point_loads(_: Runs) -> Values:
    return {f"ν = {nu:g}": far_field_error(nu) for nu in NU}


@below(
    SAME_NUMBER,
    "cylinder",
    "B of line loads with the factor (π - |α|) / π: relative deviation from cavity or cylinder",
)
def _cylinder(_: Runs) -> Values:
    return {f"{body}, ν = {nu:g}": cylinder_error(side, nu) for body, side in CYLINDERS.items() for nu in NU}


def _limit_panels(runs: Runs) -> Iterator[Panel]:
    plane, nearly = runs.plane(), runs.nearly_plane()
    for results, component in ((plane, "nn"), (plane, "sn"), (nearly, "sn")):
        yield Curve(results, "lower", component, ACROSS).panel("A", "B", "Bhat")
    alpha, scale = np.linspace(0.02, np.pi - 0.02, 300), np.pi * 210e3
    exact, with_factor = cylinder_ics(UPPER, 0.28, alpha)
    _, without = cylinder_ics(UPPER, 0.28, alpha, factor=False)
    for name, at in (("nn", (1, 1)), ("sn", (0, 1))):
        curves = {"C": exact, "B": without, "B with the factor": with_factor}
        yield Panel(
            f"cylindrical cavity, line loads: {name}",
            "α  [rad]",
            "IC · π E  [-]",
            make_curves(alpha, {label: scale * ics[at] for label, ics in curves.items()}),
        )


STATEMENTS = (
    Statement(
        11,
        "Changing ν from 0.28 to 0.30 does not change the comparison noticeably.",
        (_change, _order),
        _nu_panels,
        columns=3,
    ),
    Statement(
        12,
        "The mix is more accurate than each single approximation.",
        (
            below(1.0, "worst", "largest error of a component: mix divided by the best single approximation")(
                per_body(mix_over_best(np.max), fitted=True)
            ),
            below(
                1.0, "mean", "mean error over the components: mix divided by the best single approximation"
            )(per_body(mix_over_best(np.mean), fitted=True)),
        ),
        _mix_panels,
        mean_errors,
        columns=3,
    ),
    Statement(
        14,
        "Both engines agree within their estimated errors for every component, body and geometry.",
        [
            below(1.0, "apart", "largest |difference| / (sum of both estimates) of a component")(
                engine_agreement
            )
        ],
        _engine_panels,
        engine_details,
        columns=3,
    ),
    Statement(
        15,
        "Limiting cases are reproduced: the plane by every approximation and by C, a nearly plane contour "
        "by C, point loads by A, the cylinder by B.",
        (
            below(SAME_NUMBER, "variants", "plane: largest error of a variant against A")(variant_deviations),
            *(_plane, _nearly_plane, _point_loads, _cylinder),
        ),
        _limit_panels,
        columns=3,
    ),
)
