"""Statements 14 and 15: whether both engines agree, and whether limits are met."""

from collections.abc import Callable, Mapping
from itertools import product

import numpy as np

from approx.cylinder import cavity_ics, half_plane_ics, solid_cylinder_ics
from approx.halfspace import HalfSpace
from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.curves import ACROSS, BESIDE, BODIES, INDEPENDENT, Curve
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.reference.job import component_of
from femic.results.ics import Results, engine_differences, ics_of, measure_of, reference_of
from geometries.arrays import Array
from geometries.materials import ElasticConstants, Material, one_body
from geometries.patches import COMPONENTS, Patch
from geometries.surfaces import LOWER, UPPER

TINY = 1e-9  # of a line's scale: smaller estimates count as this, as of what vanishes by symmetry
FAR_PATCHES = 1e5  # distance in patches at which A is compared with point loads
SAME_NUMBER = 1e-12  # relative difference of the same number computed in two ways
HALF_SPACE = 1e-9  # relative difference of A from point loads, with the first neglected term
NU = (0.0, 0.28, 0.5)
SIDES = {"cavity": UPPER, "solid cylinder": LOWER}


# --- 14 -------------------------------------------------------------------------------------------------


def agreements(runs: Runs) -> Mapping[str, float]:
    """Return differences of the engines over the sum of their estimates, by geometry, body and component."""
    return {
        f"{name}, {body}, {component}": ratio
        for name, body in product(GEOMETRIES, BODIES)
        for component, ratio in agreement(runs.with_both_engines(name), body).items()
    }


def agreement(results: Results, body: str) -> dict[str, float]:
    """Return the largest difference of the engines over the sum of their estimates, by component."""
    ratios = _largest_ratios(*engine_differences(results, body))
    return {component: component_of(ratios, component) for component in COMPONENTS}


def _largest_ratios(differences: Mapping[str, Array], estimates: Mapping[str, Array]) -> Array:
    """Return the largest ratios of differences to estimates (at least `TINY`) on a line, (3, 3)."""
    return np.max([differences[line] / np.maximum(estimates[line], TINY) for line in differences], axis=0)


def _estimates(runs: Runs) -> Mapping[str, float]:
    """Return the largest estimates and the largest differences of the engines, by geometry and body [-]."""
    details: dict[str, float] = {}
    for name, body in product(GEOMETRIES, BODIES):
        results = runs.with_both_engines(name)
        estimates = measure_of(results, body).shares(reference_of(results, body).estimate)
        details[f"estimate of C, harmonic: {name}, {body}"] = _worst(estimates)
        details[f"largest difference: {name}, {body}"] = _worst(engine_differences(results, body)[0])
    return details


def _worst(shares: Mapping[str, Array]) -> float:
    return float(np.max(list(shares.values())))


def _both_engines(runs: Runs) -> list[Panel]:
    return [
        Curve(results, "lower", component, line).panel("C_solid")
        for results in map(runs.with_both_engines, GEOMETRIES)
        for component, line in (("nn", ACROSS), ("sn", ACROSS), ("xn", BESIDE))
    ]


# --- 15 -------------------------------------------------------------------------------------------------


def variant_deviations(runs: Runs) -> Mapping[str, float]:
    """Return the largest deviation of each variant from A on the plane, as a share of the largest IC."""
    plane = runs.plane()
    return {
        symbol_of(variant): max(_deviation_from_a(plane, variant, body) for body in BODIES)
        for variant in plane.scene.variants
    }


def _deviation_from_a(results: Results, variant: str, body: str) -> float:
    a = ics_of(results, "A", body)
    return float(np.max(np.abs(ics_of(results, variant, body) - a)) / np.max(np.abs(a)))


def deviation_from_limit(results: Results, body: str) -> float:
    """Return the largest |C - A| on a line as a share of max |A_ij| there, or of max |A_nn| if A_ij is 0."""
    deviations = []
    for line, component in product(results.scene.lines, INDEPENDENT):
        curve, nn = (Curve(results, body, name, line.name) for name in (component, "nn"))
        deviations.append(curve.largest("A") / (curve.size("A") or nn.size("A")))
    return max(deviations)


def _over_estimate(results: Results, body: str) -> float:
    """Return the largest |C - A| over the estimate of C (at least `TINY`) of a component on a line."""
    c, measure = reference_of(results, body), measure_of(results, body)
    differences = measure.shares(ics_of(results, "A", body) - c.ic)
    return float(np.max(_largest_ratios(differences, measure.shares(c.estimate))))


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
    zero = np.zeros_like(r)
    along = np.array([x, s, zero]) / r
    across = np.einsum("ip,jp->ijp", along, along)
    direct = np.eye(3)[..., None] * (1 - nu) / r + nu * across / r
    to_normal = np.einsum("ip,j->ijp", along / r, [0, 0, 1])
    return np.asarray(scale * (direct - k * to_normal + k * np.swapaxes(to_normal, 0, 1)))


def cylinder_error(side: int, nu: float) -> float:
    """Return the relative deviation of B of line loads with the factor from the cavity or the solid cylinder.

    The upper body is the cavity, the lower body the solid cylinder.
    """
    alpha = np.linspace(0.01, np.pi - 0.01, 200) * np.array([[1], [-1]])
    exact, b = _cylinder(side, nu, alpha)
    return float(np.max(np.abs(exact - b)) / np.max(np.abs(exact)))


def _cylinder(side: int, nu: float, alpha: Array, *, factor: bool = True) -> tuple[Array, Array]:
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


def _cylinder_panels() -> list[Panel]:
    alpha = np.linspace(0.02, np.pi - 0.02, 300)
    exact, with_factor = _cylinder(UPPER, 0.28, alpha)
    without = _cylinder(UPPER, 0.28, alpha, factor=False)[1]
    scale = np.pi * 210e3
    return [
        Panel(
            f"cylindrical cavity, line loads: {name}",
            "α  [rad]",
            "IC · π E  [-]",
            curves_of(
                alpha,
                {
                    "C": scale * exact[i, j],
                    "B": scale * without[i, j],
                    "B with the factor": scale * with_factor[i, j],
                },
            ),
        )
        for name, (i, j) in (("nn", (1, 1)), ("sn", (0, 1)))
    ]


def _limits(runs: Runs) -> list[Panel]:
    plane, nearly = runs.plane(), runs.nearly_plane()
    curves = [
        Curve(results, "lower", component, ACROSS)
        for results, component in ((plane, "nn"), (plane, "sn"), (nearly, "sn"))
    ]
    return [curve.panel("A", "B", "Bhat") for curve in curves] + _cylinder_panels()


def per_nu(number: Callable[[float], float]) -> Numbers:
    """Measure a number at each Poisson's ratio."""
    return Numbers(lambda _: {f"ν = {nu:g}": number(nu) for nu in NU})


def cylinder_errors(_: Runs) -> Mapping[str, float]:
    """Return the relative deviations of both cylinders at each Poisson's ratio."""
    return {f"{body}, ν = {nu:g}": cylinder_error(side, nu) for body, side in SIDES.items() for nu in NU}


STATEMENTS = (
    Statement(
        14,
        "Both engines agree within their estimates on every component, body and geometry.",
        (
            Numbers(agreements).below(
                1.0, "apart", "largest |difference| / (sum of both estimates) of a component"
            ),
        ),
        _both_engines,
        _estimates,
        columns=3,
    ),
    Statement(
        15,
        "Limits are met: the plane by every variant and by C, a nearly plane contour by C, point loads by A, "
        "the cylinder by B.",
        (
            Numbers(variant_deviations).below(
                SAME_NUMBER, "variants", "plane: largest error of a variant against A"
            ),
            Numbers(lambda runs: {body: _over_estimate(runs.plane(), body) for body in BODIES}).below(
                1.0, "plane", "plane: largest |C - A| / estimate of C"
            ),
            Numbers(
                lambda runs: {body: deviation_from_limit(runs.nearly_plane(), body) for body in BODIES}
            ).below(
                0.01,
                "nearly plane",
                "arc of 1000 reference lengths: |C - A| on a line, of max |A_ij|, of max |A_nn| if A_ij is 0",
            ),
            per_nu(far_field_error).below(
                HALF_SPACE, "point loads", "A at 1e5 patches: relative deviation from point loads"
            ),
            Numbers(cylinder_errors).below(
                SAME_NUMBER,
                "cylinder",
                "B of line loads with the factor (π - |α|) / π: relative deviation from cavity or cylinder",
            ),
        ),
        _limits,
        columns=3,
    ),
)
