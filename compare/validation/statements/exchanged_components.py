"""Statements 38 to 40: which components matter in contact with friction ([BVSV] section 6.2)."""

from collections.abc import Callable, Mapping
from itertools import product

import numpy as np
import xarray as xr

from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.contact_series import estimate_of, ratio
from compare.validation.statements.criteria import SATISFACTORY, Numbers, Statement
from compare.validation.statements.friction_contacts import (
    FEW_CREEPAGES,
    FRICTIONS,
    LOADS,
    SINGLE,
    WITHOUT_FIT,
    against,
    case,
    compression,
    curve_distance,
    grid_of,
    line_distance,
    on_grid_of,
    pressure_distance,
    rolling,
    rolling_on_same_grid,
    traction_distance,
)
from compare.validation.statements.runs import Runs
from femic.contact.motions.rolling import scaled_force
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.pairs.ics import GivenICs
from femic.results.contact import ics_of
from femic.scenes.load import load_scene
from geometries.patches import Grid, indices

BASE = "Bhat"
ALONE = tuple(product(("ns", "nx"), ("B", "Bhat_prime")))  # components and the variants they are taken from
AT = (FRICTIONS[0], FRICTIONS[-1])  # coefficients of friction at which single components are exchanged
OF_PATCH = ("p_max", "a", "b")


# --- 38 -------------------------------------------------------------------------------------------------


def exchanged_alone(pair_of: str, grid: Grid) -> dict[str, GivenICs]:
    """Return B-hat with one component of another variant, and nothing else changed, by their names.

    In the names of `approx.variants` the transposed component follows by reciprocity; it does not here.
    """
    pair = load_scene(pair_of).pair
    base, given = approximate_matrix(BASE, pair, grid), {}
    for component, variant in ALONE:
        ics, at = base.copy(), indices(component)
        ics[(..., *at)] = approximate_matrix(variant, pair, grid)[(..., *at)]
        given[f"{BASE}+{component}:{variant}"] = GivenICs(grid, ics)
    return given


def _given(dataset: xr.Dataset) -> dict[str, GivenICs]:
    return exchanged_alone("rolling", grid_of(dataset))


def exchanged_rolling(runs: Runs) -> xr.Dataset:
    """Return steady rolling with B-hat and with ns or nx exchanged alone."""
    given = _given(rolling(runs))
    contact = {"ics": [BASE, *given], "friction": list(AT), "longitudinal": list(FEW_CREEPAGES)}
    return rolling_on_same_grid(runs, {"contact": contact}, given)


def exchanged_compression(runs: Runs) -> xr.Dataset:
    """Return static compression with B-hat and with ns or nx exchanged alone."""
    contacts = compression(runs)
    given = _given(contacts)
    contact = {"grid": "scene", "ics": [BASE, *given], "friction": list(AT), "loads": list(LOADS)}
    return runs.friction("compression", {"grid": on_grid_of(contacts), "contact": contact}, given)


Change = Callable[[xr.Dataset, float, str], float]


def changes(contacts: Callable[[Runs], xr.Dataset], change: Change) -> Numbers:
    """Measure what exchanging ns or nx changes, at each coefficient of friction."""

    def measure(runs: Runs) -> Mapping[str, float]:
        dataset = contacts(runs)
        return {
            case(friction, name): change(dataset, friction, name)
            for friction in AT
            for name in ics_of(dataset)
            if name != BASE
        }

    return Numbers(measure)


def curve_change(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the largest distance of the creep-force curve from B-hat's over friction times load."""
    force = scaled_force(dataset).sel(friction=friction)
    return float(abs(force.sel(ics=ics) - force.sel(ics=BASE)).max())


def number_change(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the largest relative change of p_max, a and b, at all creepages or loads."""
    at = dataset.sel(friction=friction)
    return max(float(abs(at[name].sel(ics=ics) / at[name].sel(ics=BASE) - 1).max()) for name in OF_PATCH)


def traction_change(dataset: xr.Dataset, friction: float, ics: str) -> float:
    """Return the change of tangential tractions over friction times pressure; root mean squares."""
    p = dataset.p.sel(friction=friction).transpose("ics", "x", "s", "direction")
    before = p.sel(ics=BASE).values
    apart = p.sel(ics=ics).values - before
    return float(np.linalg.norm(apart[..., :2]) / (friction * np.linalg.norm(before[..., 2])))


def _exchange_details(runs: Runs) -> Mapping[str, float]:
    """Return changes of the curve by exchanging ns and nx, and by exchanging xn or sn with its transposed."""
    contacts, details = rolling(runs), dict[str, float]()
    force = scaled_force(contacts)
    for friction in AT:
        at = force.sel(friction=friction)
        apart = at.sel(ics=WITHOUT_FIT["Bhat"]) - at.sel(ics=BASE)
        details[f"curve by sn and ns of B: friction {friction:g}"] = float(abs(apart).max())
        apart = at.sel(ics="Bhat_prime") - at.sel(ics=BASE)
        details[f"curve by B̂′ instead of B̂: friction {friction:g}"] = float(abs(apart).max())
    pressed = exchanged_compression(runs)
    for friction in AT:
        share = pressed.sliding_share.sel(friction=friction).isel(load=-1)
        for name in ics_of(pressed):
            details[f"sliding share: {case(friction, name)}"] = float(share.sel(ics=name))
    return details


def _label(ics: str) -> str:
    """Return the label of a curve: what the last exchanged component is taken from, or the symbol."""
    if "+" not in ics:
        return symbol_of(ics)
    component, variant = ics.rsplit("+", maxsplit=1)[-1].split(":")
    return f"{component} of {symbol_of(variant)}"


def _exchange_panels(runs: Runs) -> list[Panel]:
    contacts, pressed = exchanged_rolling(runs), exchanged_compression(runs)
    force, panels = scaled_force(contacts), []
    for friction in AT:
        at = force.sel(friction=friction)
        away = {
            _label(name): (at.sel(ics=name) - at.sel(ics=BASE)).values
            for name in ics_of(contacts)
            if name != BASE
        }
        panels.append(
            Panel(
                f"friction {friction:g}",
                "longitudinal creepage [1e-3]",
                "F_x minus F_x with B̂, over friction load [-]",
                curves_of(1e3 * contacts.xi.values, away),
            )
        )
    for friction in AT:
        p = pressed.p.sel(friction=friction, direction="s").interp(x=0.0)
        curves = {_label(name): p.sel(ics=name).values for name in ics_of(pressed)}
        panels.append(
            Panel(
                f"compression, friction {friction:g}",
                "s [mm]",
                "p_s at x = 0 [MPa]",
                curves_of(pressed.s.values, curves),
            )
        )
    return panels


# --- 39, 40 ---------------------------------------------------------------------------------------------

MEASURES = {  # by the name of the criterion: contacts, distance, what it is
    "curve": (rolling, curve_distance, "rms distance of the creep-force curve from C's"),
    "p_x": (rolling, line_distance, "rms distance of p_x from C's at s = 0 at equal F_x over friction load"),
    "pressure": (rolling, pressure_distance, "|p_max / p_max with C - 1| without creepage"),
    "compression": (compression, traction_distance, "distance of tangential tractions in compression"),
}


def mix_over_best(name: str) -> Numbers:
    """Measure the distance of the mix from C over the least one of all single variants."""
    contacts, distance, _ = MEASURES[name]

    def measure(runs: Runs) -> Mapping[str, float]:
        dataset = contacts(runs)
        return {
            f"friction {friction:g}": ratio(
                distance(dataset, friction, "mix"),
                min(distance(dataset, friction, single) for single in SINGLE),
            )
            for friction in FRICTIONS
        }

    return Numbers(measure)


def _all_distances(runs: Runs) -> Mapping[str, float]:
    """Return the distances from C of the mix and of all single variants, and what some are known to."""
    details = {
        f"{name}: {case(friction, ics)}": distance(contacts(runs), friction, ics)
        for name, (contacts, distance, _) in MEASURES.items()
        for friction in FRICTIONS
        for ics in (*SINGLE, "mix")
    }
    return details | _known_to(rolling(runs))


def _known_to(contacts: xr.Dataset) -> dict[str, float]:
    """Return the estimates of distances of curves and pressures from those with C."""
    return {
        f"estimate of {name}: {case(friction, ics)}": estimate_of(distance(contacts, friction, ics))
        for friction in FRICTIONS
        for ics in ("Bhat_prime", "mix")
        for name, distance in (("curve", curve_distance), ("pressure", pressure_distance))
    }


def _mix_panels(runs: Runs) -> list[Panel]:
    """Return distances from C over the coefficient of friction."""
    labels = {symbol_of(ics): ics for ics in (*SINGLE, "mix")}
    return [_distance_panel(runs, name, labels) for name in MEASURES]


def _distance_panel(runs: Runs, name: str, ics: Mapping[str, str]) -> Panel:
    """Return distances from C over the coefficient of friction, of ICs by their labels."""
    contacts, distance, meaning = MEASURES[name]
    dataset = contacts(runs)
    by_label = {
        label: np.array([distance(dataset, friction, one) for friction in FRICTIONS])
        for label, one in ics.items()
    }
    return Panel(name, "friction [-]", f"{meaning} [-]", curves_of(FRICTIONS, by_label))


def _fitless_panels(runs: Runs) -> list[Panel]:
    labels = {f"xn of {symbol_of(xn)}": ics for xn, ics in WITHOUT_FIT.items()}
    return [_distance_panel(runs, name, labels) for name in ("curve", "p_x")]


def _fitless_details(runs: Runs) -> Mapping[str, float]:
    """Return distances from C of the mixes without a fit, and shifts in creepage."""
    dataset, details = rolling(runs), dict[str, float]()
    for friction in FRICTIONS:
        zero = dataset.zero_creepage.sel(friction=friction)
        for ics in (*WITHOUT_FIT.values(), "C"):
            details[f"creepage without force [1e-3]: {case(friction, ics)}"] = 1e3 * float(zero.sel(ics=ics))
        for ics in WITHOUT_FIT.values():
            details[f"curve: {case(friction, ics)}"] = curve_distance(dataset, friction, ics)
    return details


FITLESS_OTHERS = (WITHOUT_FIT["B"], WITHOUT_FIT["Bhat"])

STATEMENTS = (
    Statement(
        38,
        "ns and nx matter little in contact with friction: exchanging one of them alone changes little.",
        (
            changes(exchanged_rolling, curve_change).below(
                SATISFACTORY,
                "curve",
                "rolling, ns or nx of B or B̂′ in B̂: largest change of F_x / friction load",
            ),
            changes(exchanged_rolling, number_change).below(
                SATISFACTORY, "patch", "rolling: largest relative change of p_max, a, b"
            ),
            changes(exchanged_compression, traction_change).below(
                SATISFACTORY,
                "tractions",
                "compression: change of tangential tractions over friction times pressure, rms",
            ),
            changes(exchanged_compression, number_change).below(
                SATISFACTORY, "pressed patch", "compression: largest relative change of p_max, a, b"
            ),
        ),
        _exchange_panels,
        _exchange_details,
    ),
    Statement(
        39,
        "In contact, too, the mix beats each single variant.",
        tuple(
            mix_over_best(name).below(1.0, name, f"{meaning}: mix over the best of A, B, B̂, B̂′")
            for name, (_, _, meaning) in MEASURES.items()
        ),
        _mix_panels,
        _all_distances,
    ),
    Statement(
        40,
        "Without a fit A_xn beats B_xn and B̂_xn in contact, too.",
        tuple(
            against(contacts, distance, (WITHOUT_FIT["A"],), FITLESS_OTHERS, FRICTIONS).below(
                1.0, name, f"{meaning}: B̂ with sn of B and xn of A over the same with xn of B or B̂"
            )
            for name, (contacts, distance, meaning) in MEASURES.items()
            if name in ("curve", "p_x")
        ),
        _fitless_panels,
        _fitless_details,
    ),
)
