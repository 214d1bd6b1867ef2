"""Statements 11, 12, 14, 15: materials, the mix, and whether this program can be trusted."""

import numpy as np
from numpy.typing import NDArray

from approx.cylinder import cavity_ics, half_plane_ics, solid_cylinder_ics
from approx.halfspace import HalfSpace
from compare.figures import SYMBOLS
from compare.pipeline import Results, apart, ics_of, reference_of, shares_of
from compare.validation.curves import BODIES, Measured, Panel, along, curve, deviation, error, panel
from compare.validation.runs import GEOMETRIES, NINE, OTHER_NU, Runs
from femic.accuracy import component_of
from geometries.materials import ElasticConstants, Material, one_body
from geometries.patches import Patch
from geometries.surfaces import LOWER, UPPER

Array = NDArray[np.float64]

SHOWN = ("nn", "ss", "xx", "xs", "xn", "sn")  # the others are their reciprocals
TINY = 1e-9  # of a line's scale: a component that vanishes by symmetry
FAR = 1e5  # patches away, where point loads are the limit
X, S, N = range(3)


def nu_matters(runs: Runs) -> Measured:
    """Statement 11."""
    change: dict[str, float] = {}
    panels = []
    for name in GEOMETRIES:
        one, other = runs.geometry(name), runs.other_nu(name)
        for body in BODIES:
            off = ics_of(other, "C", body) - ics_of(one, "C", body)
            change |= {f"{name}, {body}, {c}": deviation(one, off, body, c) for c in SHOWN}
        for body, component in (("combined", "nn"), ("combined", "xn"), ("lower", "sn")):
            line = along(one, "s" if component == "sn" else "x")[0]
            more = {f"C, ν = {OTHER_NU[name]:g}": curve(other, "C", body, component, [line])}
            panels.append(panel(one, (), (body, component), line, more))
    return Measured({"change": change}, tuple(panels), columns=3)


def mix_is_best(runs: Runs) -> Measured:
    """Statement 12."""
    worst, mean = {}, {}
    details: dict[str, float] = {}
    for name in GEOMETRIES:
        results = runs.fitted(name)
        for body in BODIES:
            errors = {
                variant: np.array([error(results, variant, body, c) for c in SHOWN])
                for variant in results.scene.variants
                if not np.any(np.isnan(ics_of(results, variant, body)))
            }
            single = [of for variant, of in errors.items() if variant != "mix"]
            case = f"{name}, {body}"
            worst[case] = float(np.max(errors["mix"]) / min(np.max(of) for of in single))
            mean[case] = float(np.mean(errors["mix"]) / min(np.mean(of) for of in single))
            details |= {f"mean error of {SYMBOLS[v]}: {case}": float(np.mean(of)) for v, of in errors.items()}
    of = runs.fitted(GEOMETRIES[0])
    panels = [
        panel(of, ("Bhat", "mix"), ("combined", c), along(of, "x" if c in ("xx", "xn") else "s")[0])
        for c in SHOWN
    ]
    return Measured({"worst": worst, "mean": mean}, tuple(panels), details, columns=3)


def engines_agree(runs: Runs) -> Measured:
    """Statement 14."""
    values: dict[str, float] = {}
    details: dict[str, float] = {}
    panels = []
    for name in GEOMETRIES:
        results = runs.checked(name)
        for body in BODIES:
            ratios = agreement(results, body)
            values |= {f"{name}, {body}, {c}": ratio for c, ratio in ratios.items()}
            known = shares_of(results, body, reference_of(results, body).estimate)
            details[f"estimate of C, harmonic: {name}, {body}"] = _worst(known)
            details[f"largest difference: {name}, {body}"] = _worst(apart(results, body)[0])
        for component, direction in (("nn", "s"), ("sn", "s"), ("xn", "x")):
            line = along(results, direction)[0]
            panels.append(panel(results, ("C_solid",), ("lower", component), line))
    return Measured({"apart": values}, tuple(panels), details, columns=3)


def _worst(shares: dict[str, Array]) -> float:
    return max(component_of(of_line, c) for of_line in shares.values() for c in NINE)


def agreement(results: Results, body: str) -> dict[str, float]:
    """Per component the largest difference of both engines over the sum of their estimates, of all lines."""
    off, known = apart(results, body)
    return {
        c: max(component_of(off[line], c) / max(component_of(known[line], c), TINY) for line in off)
        for c in NINE
    }


def limits(runs: Runs) -> Measured:
    """Statement 15."""
    plane, nearly = runs.plane(), runs.nearly_plane()
    a = {body: ics_of(plane, "A", body) for body in BODIES}
    variants = {
        SYMBOLS[variant]: max(
            float(np.max(np.abs(ics_of(plane, variant, body) - a[body])) / np.max(np.abs(a[body])))
            for body in BODIES
        )
        for variant in plane.scene.variants
    }
    values = {
        "variants": variants,
        "plane": {body: _over_estimate(plane, body) for body in BODIES},
        "nearly plane": {body: max(error(nearly, "A", body, c) for c in SHOWN) for body in BODIES},
        "point loads": {f"ν = {nu:g}": far_field_error(nu) for nu in (0.0, 0.28, 0.5)},
        "cylinder": {
            f"{body}, ν = {nu:g}": cylinder_error(side, nu)
            for body, side in (("cavity", UPPER), ("solid cylinder", LOWER))
            for nu in (0.0, 0.28, 0.5)
        },
    }
    panels = (
        panel(plane, ("A", "B", "Bhat"), ("lower", "nn"), along(plane, "s")[0]),
        panel(plane, ("A", "B", "Bhat"), ("lower", "sn"), along(plane, "s")[0]),
        panel(nearly, ("A", "B", "Bhat"), ("lower", "sn"), along(nearly, "s")[0]),
        *_cylinder_panels(),
    )
    return Measured(values, panels, columns=3)


def _over_estimate(results: Results, body: str) -> float:
    """Largest |C - A| over the estimate of C (at least `TINY`) of a component on a line."""
    off = shares_of(results, body, ics_of(results, "A", body) - reference_of(results, body).ic)
    known = shares_of(results, body, reference_of(results, body).estimate)
    return max(
        component_of(off[line], c) / max(component_of(known[line], c), TINY) for line in off for c in NINE
    )


def far_field_error(nu: float) -> float:
    """Relative deviation of A far from a patch from a point load's displacements (Boussinesq, Cerruti)."""
    constants, patch = one_body(Material(210e3, nu), UPPER), Patch(0.2, 0.3)
    angle = np.linspace(0, 2 * np.pi, 65)[:-1] + 0.01
    x, s = FAR * patch.b * np.array([np.cos(angle), np.sin(angle)])
    a, limit = HalfSpace(constants).ics(patch, x, s) / patch.area, point_load(constants, x, s)
    return float(np.max(np.abs(a - limit)) / np.max(np.abs(limit)))


def point_load(constants: ElasticConstants, x: Array, s: Array) -> Array:
    """Displacements of a half-space under unit point loads [mm/N], (3, 3, n)."""
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
    """B of line loads with the factor against the cavity (upper body) or the solid cylinder (lower)."""
    alpha = np.linspace(0.01, np.pi - 0.01, 200) * np.array([[1], [-1]])
    exact, b = _cylinder(side, nu, alpha)
    return float(np.max(np.abs(exact - b)) / np.max(np.abs(exact)))


def _cylinder(side: int, nu: float, alpha: Array, *, factor: bool = True) -> tuple[Array, Array]:
    """Exact ICs (2, 2, ...) of a cylinder of radius 1 without uniform radial displacement, and B's."""
    material = Material(210e3, nu)
    exact = (cavity_ics if side == UPPER else solid_cylinder_ics)(material, alpha)
    if side == LOWER:
        exact[1, 1] += (1 - nu) / (2 * np.pi * material.G)
    a = half_plane_ics(material, side, 2 * np.sin(alpha / 2), 1.0)
    if factor:
        a[[0, 1], [1, 0]] *= (np.pi - np.abs(alpha)) / np.pi
    turn = np.array([[np.cos(alpha), -np.sin(alpha)], [np.sin(alpha), np.cos(alpha)]])
    return exact, np.einsum("ik...,kj...->ij...", a, turn)


def _cylinder_panels() -> list[Panel]:
    alpha = np.linspace(0.02, np.pi - 0.02, 300)
    exact, with_factor = _cylinder(UPPER, 0.28, alpha)
    without = _cylinder(UPPER, 0.28, alpha, factor=False)[1]
    scale = np.pi * 210e3
    return [
        Panel(
            f"cylindrical cavity, line loads: {name}",
            "α  [rad]",
            alpha,
            "IC · π E  [-]",
            {
                "C": scale * exact[i, j],
                "B": scale * without[i, j],
                "B with the factor": scale * with_factor[i, j],
            },
        )
        for name, (i, j) in (("nn", (1, 1)), ("sn", (0, 1)))
    ]
