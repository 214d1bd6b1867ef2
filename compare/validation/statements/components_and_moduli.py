"""Statements 38 to 41 ([BVSV] section 6.2): components and moduli that matter in contact with friction.

Single components are exchanged, mixes compared with single variants, and one body made softer: 1 / E_upper
+ 1 / E_lower stays the same, so that load, patch and A_nn do.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import product

import numpy as np
import xarray as xr

from compare.report.charts import Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.frame import (
    SATISFACTORY,
    Measure,
    Statement,
    above,
    below,
    estimated_error,
    ratio,
)
from compare.validation.statements.friction_contacts import (
    FEW_CREEPAGES,
    FRICTIONS,
    LOADS,
    SINGLE,
    WITHOUT_FIT,
    Distance,
    case,
    compared,
    compression,
    curve_distance,
    distances,
    find_grid,
    line_distance,
    measured,
    on_same_grid,
    pressure_distance,
    rolling,
    traction_distance,
)
from compare.validation.statements.runs import Runs
from femic.contact.motions.rolling import scaled_force
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.pairs.ics import GivenICs
from femic.scenes.load import load_scene
from geometries.patches import Grid, indices

# --- 38: components exchanged alone ---------------------------------------------------------------------

BASE = "Bhat"
EXCHANGED = {  # names of ICs by the component and the variant it is taken from
    (component, variant): f"{BASE}+{component}:{variant}"
    for component, variant in product(("ns", "nx"), ("B", "Bhat_prime"))
}
AT = (FRICTIONS[0], FRICTIONS[-1])  # coefficients of friction at which single components are exchanged


def exchanged_alone(grid: Grid) -> dict[str, GivenICs]:
    """Return B-hat with one component of another variant, and nothing else changed, by their names.

    In the names of `approx.variants` the transposed component follows by reciprocity; it does not here.
    """
    pair = load_scene("rolling").pair
    base, given = approximate_matrix(BASE, pair, grid), {}
    for (component, variant), name in EXCHANGED.items():
        ics, at = base.copy(), indices(component)
        ics[(..., *at)] = approximate_matrix(variant, pair, grid)[(..., *at)]
        given[name] = GivenICs(grid, ics)
    return given


def exchanged(motion: str, runs: Runs) -> xr.Dataset:
    """Return "rolling" or "compression" with B-hat and with ns or nx exchanged alone."""
    given = exchanged_alone(find_grid((rolling if motion == "rolling" else compression)(runs)))
    steps = {"rolling": {"longitudinal": list(FEW_CREEPAGES)}, "compression": {"loads": list(LOADS)}}
    contact = {"ics": [BASE, *given], "friction": list(AT), **steps[motion]}
    return on_same_grid(runs, motion, {"contact": contact}, given)


def curve_change(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the largest distance of the creep-force curve from B-hat's over friction times load."""
    force = scaled_force(dataset).sel(friction=friction)
    return float(abs(force.sel(ics=ics) - force.sel(ics=BASE)).max())


def patch_change(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the largest relative change of p_max, a and b, at all creepages or loads."""
    at = dataset.sel(friction=friction)[["p_max", "a", "b"]]
    return float(abs(at.sel(ics=ics) / at.sel(ics=BASE) - 1).to_array().max())


def traction_change(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the change of tangential tractions over friction times pressure; root mean squares."""
    p = dataset.p.sel(friction=friction).transpose("ics", "x", "s", "direction")
    before = p.sel(ics=BASE).values
    apart = p.sel(ics=ics).values - before
    return float(np.linalg.norm(apart[..., :2]) / (friction * np.linalg.norm(before[..., 2])))


def change_by_exchange(motion: str, change: Distance) -> Measure:
    """Measure a change by exchanging ns or nx alone, in rolling or compression."""
    return distances(partial(exchanged, motion), change, tuple(EXCHANGED.values()), AT)


def _exchange_details(runs: Runs) -> Mapping[str, float]:
    """Return changes of the curve by exchanging xn or sn with its transposed, and sliding shares."""
    contacts, pressed, details = rolling(runs), exchanged("compression", runs), dict[str, float]()
    for friction in AT:
        by_sn = curve_change(contacts, friction, WITHOUT_FIT["Bhat"])
        details[f"curve by sn and ns of B: friction {friction:g}"] = by_sn
        by_fit = curve_change(contacts, friction, "Bhat_prime")
        details[f"curve by B̂′ instead of B̂: friction {friction:g}"] = by_fit
    for friction in AT:
        share = pressed.sliding_share.sel(friction=friction).isel(load=-1)
        for name in (BASE, *EXCHANGED.values()):
            details[f"sliding share: {case(friction, name)}"] = float(share.sel(ics=name))
    return details


def _exchange_panels(runs: Runs) -> Iterator[Panel]:
    contacts, pressed = exchanged("rolling", runs), exchanged("compression", runs)
    labels = {f"{component} of {ics_symbol(v)}": name for (component, v), name in EXCHANGED.items()}
    for friction in AT:
        force = scaled_force(contacts).sel(friction=friction)
        away = {label: (force.sel(ics=ics) - force.sel(ics=BASE)).values for label, ics in labels.items()}
        axes = "longitudinal creepage [1e-3]", "F_x minus F_x with B̂, over friction load [-]"
        yield Panel(f"friction {friction:g}", *axes, make_curves(1e3 * contacts.xi.values, away))
    for friction in AT:
        p = pressed.p.sel(friction=friction, direction="s").interp(x=0.0)
        curves = {label: p.sel(ics=ics).values for label, ics in ({ics_symbol(BASE): BASE} | labels).items()}
        title = f"compression, friction {friction:g}"
        yield Panel(title, "s [mm]", "p_s at x = 0 [MPa]", make_curves(pressed.s.values, curves))


# --- 39, 40: mixes --------------------------------------------------------------------------------------

MEASURES = {  # by the name of the criterion: contacts, distance, what it is
    "curve": (rolling, curve_distance, "rms distance of the creep-force curve from C's"),
    "p_x": (rolling, line_distance, "rms distance of p_x from C's at s = 0 at equal F_x over friction load"),
    "pressure": (rolling, pressure_distance, "|p_max / p_max with C - 1| without creepage"),
    "compression": (compression, traction_distance, "distance of tangential tractions in compression"),
}


def mix_over_best(name: str) -> Measure:
    """Measure the distance of the mix from C over the least one of all single variants."""
    contacts, distance, _ = MEASURES[name]
    return measured(
        contacts,
        lambda dataset, friction: ratio(
            distance(dataset, friction, "mix"), min(distance(dataset, friction, single) for single in SINGLE)
        ),
        {f"friction {friction:g}": (friction,) for friction in FRICTIONS},
    )


def mix_details(runs: Runs) -> Mapping[str, float]:
    """Return the distances from C of the mix and of all single variants, and what some are known to."""
    details = {
        f"{name}: {at}": value
        for name, (contacts, distance, _) in MEASURES.items()
        for at, value in distances(contacts, distance, (*SINGLE, "mix"), FRICTIONS)(runs).items()
    }
    for friction, ics, name in product(FRICTIONS, ("Bhat_prime", "mix"), ("curve", "pressure")):
        at = case(friction, ics)
        details[f"estimate of {name}: {at}"] = estimated_error(details[f"{name}: {at}"])
    return details


def _distance_panel(runs: Runs, name: str, ics: Mapping[str, str]) -> Panel:
    """Return distances from C over the coefficient of friction, of ICs by their labels."""
    contacts, distance, meaning = MEASURES[name]
    dataset = contacts(runs)
    by_label = {
        label: np.array([distance(dataset, friction, one) for friction in FRICTIONS])
        for label, one in ics.items()
    }
    return Panel(name, "friction [-]", f"{meaning} [-]", make_curves(FRICTIONS, by_label))


def _fitless_details(runs: Runs) -> Mapping[str, float]:
    dataset, details = rolling(runs), dict[str, float]()
    for friction in FRICTIONS:
        zero = dataset.zero_creepage.sel(friction=friction)
        for ics in (*WITHOUT_FIT.values(), "C"):
            details[f"creepage without force [1e-3]: {case(friction, ics)}"] = 1e3 * float(zero.sel(ics=ics))
        for ics in WITHOUT_FIT.values():
            details[f"curve: {case(friction, ics)}"] = curve_distance(dataset, friction, ics)
    return details


# --- 41: moduli -----------------------------------------------------------------------------------------

FRICTION = 0.4
STEEL_E = 210e3  # MPa, of both bodies
UNFITTED = ("A", "B", "Bhat")  # a fit would belong to one ratio
CONVEX, CONCAVE = 10.0, 0.1  # E_upper / E_lower with a softer convex, lower body, and a softer concave one
RATIOS = (CONCAVE, 1.0, CONVEX)


def moduli(upper_over_lower: float) -> dict[str, float]:
    """Return Young's moduli [MPa] of both bodies with this ratio and the compliance of two of steel."""
    lower = STEEL_E * (1 + 1 / upper_over_lower) / 2
    return {"upper": upper_over_lower * lower, "lower": lower}


def with_moduli(runs: Runs, upper_over_lower: float) -> xr.Dataset:
    """Return rolling of bodies with this ratio of moduli, on the grid of all other rolling."""
    contact = {"friction": [FRICTION], "ics": [*UNFITTED, "C"], "longitudinal": list(FEW_CREEPAGES)}
    bodies = {body: {"E": E} for body, E in moduli(upper_over_lower).items()}
    return on_same_grid(runs, "rolling", {**bodies, "contact": contact})


def over_equal(distance: Distance, upper_over_lower: float) -> Measure:
    """Measure distances from C with unequal bodies over those with equal ones."""

    def measure(runs: Runs) -> Mapping[str, float]:
        unequal, equal = with_moduli(runs, upper_over_lower), with_moduli(runs, 1.0)
        return {
            ics_symbol(name): ratio(distance(unequal, FRICTION, name), distance(equal, FRICTION, name))
            for name in UNFITTED
        }

    return measure


def _moduli_details(runs: Runs) -> Mapping[str, float]:
    """Return distances of curves and signed errors of pressures by the ratio of moduli."""
    details = {}
    for modulus_ratio in RATIOS:
        contacts = with_moduli(runs, modulus_ratio)
        p_max = contacts.p_max.sel(friction=FRICTION, xi=0.0)
        zero = contacts.zero_creepage.sel(friction=FRICTION)
        for name in UNFITTED:
            at = f"E_upper/E_lower = {modulus_ratio:.3g}, {ics_symbol(name)}"
            details[f"curve: {at}"] = curve_distance(contacts, FRICTION, name)
            relative = float(p_max.sel(ics=name) / p_max.sel(ics="C") - 1)
            details[f"p_max over p_max with C - 1: {at}"] = relative
            apart = 1e3 * float(zero.sel(ics=name) - zero.sel(ics="C"))
            details[f"creepage without force minus C's [1e-3]: {at}"] = apart
    return details


def _moduli_panels(runs: Runs) -> Iterator[Panel]:
    """Return distances of curves and errors of pressures over the ratio of moduli."""
    by_ratio = [with_moduli(runs, modulus_ratio) for modulus_ratio in RATIOS]
    for title, label, distance in (
        ("creep-force curve", "rms distance from C over friction load [-]", curve_distance),
        ("pressure", "|p_max / p_max with C - 1| [-]", pressure_distance),
    ):
        curves = {
            ics_symbol(name): np.array([distance(contacts, FRICTION, name) for contacts in by_ratio])
            for name in UNFITTED
        }
        at = "E of the concave body over E of the convex body [-]"
        yield Panel(title, at, label, make_curves(RATIOS, curves), log_x=True)


STATEMENTS = (
    Statement(
        38,
        "ns and nx have little effect on contact with friction: exchanging one of them changes the "
        "results little.",
        (
            below(
                SATISFACTORY,
                "curve",
                "rolling, ns or nx of B or B̂′ in B̂: largest change of F_x / friction load",
            )(change_by_exchange("rolling", curve_change)),
            below(SATISFACTORY, "patch", "rolling: largest relative change of p_max, a, b")(
                change_by_exchange("rolling", patch_change)
            ),
            below(
                SATISFACTORY,
                "tractions",
                "compression: change of tangential tractions over friction times pressure, rms",
            )(change_by_exchange("compression", traction_change)),
            below(SATISFACTORY, "pressed patch", "compression: largest relative change of p_max, a, b")(
                change_by_exchange("compression", patch_change)
            ),
        ),
        _exchange_panels,
        _exchange_details,
    ),
    Statement(
        39,
        "The mix is also more accurate than each single approximation in contact.",
        [
            below(1.0, name, f"{meaning}: mix over the best of A, B, B̂, B̂′")(mix_over_best(name))
            for name, (_, _, meaning) in MEASURES.items()
        ],
        lambda runs: [
            _distance_panel(runs, name, {ics_symbol(ics): ics for ics in (*SINGLE, "mix")})
            for name in MEASURES
        ],
        mix_details,
    ),
    Statement(
        40,
        "Without a fit, A_xn is also more accurate than B_xn and B̂_xn in contact.",
        [
            below(1.0, name, f"{meaning}: B̂ with sn of B and xn of A over the same with xn of B or B̂")(
                compared(
                    contacts, distance, WITHOUT_FIT["A"], (WITHOUT_FIT["B"], WITHOUT_FIT["Bhat"]), FRICTIONS
                )
            )
            for name, (contacts, distance, meaning) in MEASURES.items()
            if name in ("curve", "p_x")
        ],
        lambda runs: [
            _distance_panel(runs, name, {f"xn of {ics_symbol(xn)}": ics for xn, ics in WITHOUT_FIT.items()})
            for name in ("curve", "p_x")
        ],
        _fitless_details,
    ),
    Statement(
        41,
        "Approximations are less accurate if the convex body is softer, and more accurate if the concave "
        "body is softer.",
        [
            decide(1.0, f"{side} {kind}", f"{meaning}: {side} body ten times softer over equal bodies")(
                over_equal(distance, modulus_ratio)
            )
            for kind, distance, meaning in (
                ("curve", curve_distance, "rms distance of the creep-force curve from C's"),
                ("pressure", pressure_distance, "|p_max / p_max with C - 1|"),
            )
            for decide, side, modulus_ratio in ((above, "convex", CONVEX), (below, "concave", CONCAVE))
        ],
        _moduli_panels,
        _moduli_details,
    ),
)
