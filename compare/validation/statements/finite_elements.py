"""Statements 22 to 24, 33 and 43: contact with C beside contact of two meshed bodies, without ICs.

Both have the same supports, and nothing is fitted between them. Their patches turn by 39 to 109 degrees;
`wide` under 18 000 kN, where the linearised distance decides (statement 30), is not among them.

Approaches differ by a rigid part ([BVSV] section 6.1), which moves each body as a whole in proportion to the
load: one compliance for all loads. With C it is M_zz of both bodies, which their ICs exclude.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise

import numpy as np
import xarray as xr

from compare.pages.finite_elements import deviations, differences, estimates, relative_estimates
from compare.report.charts import Curve, Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.frame import SATISFACTORY, Measure, Statement, Values, below
from compare.validation.statements.runs import Contacts, Runs
from femic.contact.finite_elements import FEWEST
from femic.contact.pairs.ics import C
from femic.results.contact import case_names, pressures
from femic.results.finite_elements import APPROACH, FE, OF_PATCH, OF_PLACE
from geometries.arrays import Array

AGREES = 0.02  # of a number, beside the estimate of finite elements
AGREES_FORCE, AGREES_CENTRE = 0.02, 0.2  # lateral force over load; centre of pressure [mm]

CENTRED = Contacts("wide", (660e3, 5300e3))  # patches over 39 and 77 degrees
AT_ALL_ANGLES = Contacts("tall", (7.4e3, 58e3, 310e3), cells=FEWEST)  # over 46, 79 and 109 degrees
# touching first where the rail inclines by 61 deg
BESIDE = Contacts("tall", (58e3,), shift=0.1, cells=FEWEST)
SERIES = AT_ALL_ANGLES, CENTRED

# --- 22, 23, 43: numbers of contacts --------------------------------------------------------------------


def beyond_estimate(contacts: Contacts, *names: str, over: str = "number") -> Measure:
    """Measure deviations of numbers with C from finite elements, less the estimate of the latter.

    As shares of the "number"; of one that vanishes by symmetry, of the "load", or in its "unit".
    """

    def measure(runs: Runs) -> Values:
        dataset, measured = runs.fe_contact(contacts), dict[str, float]()
        for name in names:
            if over == "number":
                beyond = abs(deviations(dataset, name)) - relative_estimates(dataset, name)
            else:
                beyond = abs(differences(dataset, name)) - estimates(dataset, name)
            with_c = (beyond / dataset["load"] if over == "load" else beyond).sel(ics="C")
            measured |= {f"{case}, {name}": float(with_c[k]) for k, case in enumerate(case_names(dataset))}
        return measured

    return measure


def beyond_estimate_everywhere(*names: str) -> Measure:
    """Measure the same of both pairs."""
    return lambda runs: {
        f"{contacts.scene}, {case}": value
        for contacts in SERIES
        for case, value in beyond_estimate(contacts, *names)(runs).items()
    }


def deviation_details(contacts: Contacts) -> Measure:
    """Measure deviations of all ICs from finite elements, and the estimates of the latter.

    They are shares of the numbers by finite elements, except for numbers that vanish by symmetry.
    """

    def measure(runs: Runs) -> Values:
        dataset, details = runs.fe_contact(contacts), dict[str, float]()
        for name in (*OF_PATCH, APPROACH, *(OF_PLACE if contacts.shift else ())):
            in_unit = name in OF_PLACE
            deviation = (differences if in_unit else deviations)(dataset, name)
            estimate = (estimates if in_unit else relative_estimates)(dataset, name)
            for k, case in enumerate(case_names(dataset)):
                for ics in map(str, deviation.ics.values):
                    details[f"{case}, {name} by {ics_symbol(ics)}"] = float(deviation.sel(ics=ics)[k])
                details[f"{case}, {name}: estimate of FE"] = float(estimate[k])
        return details

    return measure


def _angle_details(runs: Runs) -> Values:
    """Return deviations of all ICs, the angle by finite elements, and how much an edge off by 1 % turns.

    On a sharply curved part of a contour a small error of the edge is a large one of the angle: the last
    number is the relative change of the angle over that of the half-length b.
    """
    details: dict[str, float] = {}
    for contacts in SERIES:
        scene, dataset = contacts.scene, runs.fe_contact(contacts)
        details |= {f"{scene}, {case}": v for case, v in deviation_details(contacts)(runs).items()}
        for k, case in enumerate(case_names(dataset)):
            angle, b = (dataset[name].isel(case=k) for name in ("angle", "b"))
            details[f"{scene}, {case}: Δδ by FE [rad]"] = float(angle.sel(ics=FE))
            turned, moved = (float(one.sel(ics="C") / one.sel(ics=FE)) - 1 for one in (angle, b))
            details[f"{scene}, {case}: relative deviation of Δδ over that of b, C"] = turned / moved
    return details


def pressure_panels(contacts: Contacts) -> Callable[[Runs], Iterable[Panel]]:
    """Draw pressures across the patch by finite elements and with ICs, a panel per load."""

    def panels(runs: Runs) -> Iterator[Panel]:
        dataset = runs.fe_contact(contacts)
        for number, case in enumerate(case_names(dataset)):
            p = pressures(dataset, number).dropna("ics", how="all")
            p_fe = dataset.p_fe.isel(case=number).dropna("s_fe")
            s = p_fe.s_fe.values
            curves = {
                ics_symbol(str(name)): np.interp(s, p.s.values, p.sel(ics=name).values)
                for name in p.ics.values
            } | {FE: p_fe.values}
            title = f"{contacts.scene}, {case}"
            yield Panel(title, "s [mm]", "pressure at x = 0 [MPa]", make_curves(s, curves))

    return panels


def _angle_panels(runs: Runs) -> Iterator[Panel]:
    """Yield deviations of p_max over the angle, and pressures across the patches."""
    for contacts in SERIES:
        dataset = runs.fe_contact(contacts)
        deviation, angle = deviations(dataset, "p_max"), dataset["angle"].sel(ics=FE).values
        by_ics = {ics_symbol(ics): deviation.sel(ics=ics).values for ics in map(str, deviation.ics.values)}
        label = "p_max over that by finite elements, less 1 [-]"
        yield Panel(contacts.scene, "Δδ by finite elements [rad]", label, make_curves(angle, by_ics))
    for contacts in SERIES:
        yield from pressure_panels(contacts)(runs)


# --- 24: size of elements -------------------------------------------------------------------------------

SCENE, LOAD = "tall", 310e3  # N: a patch over 108 degrees
ELEMENTS = (8, 16, 32)  # across the patch
SAME = 0.002  # of a number, beside both estimates
NUMBERS = ("approach", "p_max", "a", "b")


def on_elements(runs: Runs) -> Mapping[int, xr.Dataset]:
    """Return the numbers of the contact by the number of elements across the patch."""
    changes = {"loads": [LOAD], "ics": ["Bhat", "C"]}
    return {n: runs.contact(SCENE, {**changes, "elements": n}).isel(case=0) for n in ELEMENTS}


def change_beyond_estimates(name: str) -> Measure:
    """Measure the change of a number from grid to grid beyond both estimates, as a share of it."""

    def measure(runs: Runs) -> Values:
        with_c = {n: dataset.sel(ics="C") for n, dataset in on_elements(runs).items()}
        estimate, measured = f"estimate_{name}", dict[str, float]()
        for (few, coarse), (many, fine) in pairwise(with_c.items()):
            beyond = abs(coarse[name] - fine[name]) - coarse[estimate] - fine[estimate]
            measured[f"{few} and {many} elements, {name}"] = float(beyond) / float(fine[name])
        return measured

    return measure


def _element_details(runs: Runs) -> Values:
    return {
        f"{n} elements, {name} [{dataset[name].units}]": float(dataset[name].sel(ics="C"))
        for n, dataset in on_elements(runs).items()
        for name in NUMBERS
    }


def _element_panels(runs: Runs) -> list[Panel]:
    """Return approaches with C and with B-hat over the number of elements, and the estimate with C."""
    names = ["approach", "estimate_approach"]
    contacts = xr.concat([dataset[names] for dataset in on_elements(runs).values()], "n")
    approaches = {ics_symbol(ics): contacts.approach.sel(ics=ics).values for ics in ("C", "Bhat")}
    curves = make_curves(ELEMENTS, approaches, contacts.estimate_approach.sel(ics="C").values)
    return [Panel(f"{SCENE}, {LOAD / 1e3:g} kN", "elements across the patch", "approach [mm]", curves)]


# --- 33: the rigid part of approaches -------------------------------------------------------------------


def rigid_parts(dataset: xr.Dataset, ics: str = C) -> Array:
    """Return approaches of finite elements on their supports less those with ICs [mm], by load, (n,)."""
    with_ics = dataset[APPROACH].sel(ics=ics, drop=True)
    return np.asarray((dataset[f"fe_raw_{APPROACH}"] - with_ics).values, dtype=float)


def rigid_compliance(dataset: xr.Dataset, ics: str = C) -> float:
    """Return the one compliance [mm/N] that fits the rigid parts of all loads best (least squares)."""
    load = dataset["load"].values
    return float(rigid_parts(dataset, ics) @ load / (load @ load))


def non_rigid_share(dataset: xr.Dataset, ics: str = C) -> Array:
    """Return |rigid part less compliance times load| over the approach with ICs, by load, (n,).

    The compliance is that of the other loads, so that one load alone cannot decide it.
    """
    parts, load = rigid_parts(dataset, ics), dataset["load"].values
    others = [np.arange(len(load)) != k for k in range(len(load))]
    known = np.array([parts[other] @ load[other] / (load[other] @ load[other]) for other in others])
    return np.asarray(np.abs(parts - known * load) / dataset[APPROACH].sel(ics=ics).values)


@below(
    AGREES,
    "proportional",
    "|difference of the approach with C less the compliance at the other loads times the load| "
    "over the approach, minus the estimate of finite elements",
)
def _proportional(runs: Runs) -> Values:
    measured: dict[str, float] = {}
    for contacts in reversed(SERIES):
        dataset = runs.fe_contact(contacts)
        known = estimates(dataset, APPROACH).values / dataset[APPROACH].sel(ics=FE).values
        beyond = zip(contacts.loads, non_rigid_share(dataset) - np.abs(known), strict=True)
        measured |= {f"{contacts.scene}, {load / 1e3:g} kN": float(value) for load, value in beyond}
    return measured


@below(SATISFACTORY, "rigid", "|compliance of all loads over M_zz of both bodies - 1|")
def _rigid(runs: Runs) -> Values:
    datasets = {contacts.scene: runs.fe_contact(contacts) for contacts in reversed(SERIES)}
    return {
        scene: abs(rigid_compliance(dataset) / float(dataset.rigid_compliance) - 1)
        for scene, dataset in datasets.items()
    }


def _rigid_details(runs: Runs) -> Values:
    """Return the rigid parts by load, and compliances with all ICs."""
    details: dict[str, float] = {}
    for contacts in reversed(SERIES):
        scene, dataset = contacts.scene, runs.fe_contact(contacts)
        details[f"{scene}: M_zz of both bodies [mm/MN]"] = 1e6 * float(dataset.rigid_compliance)
        for ics in (str(name) for name in dataset.ics.values if name != FE):
            difference = f"{scene}: compliance of the difference to {ics_symbol(ics)} [mm/MN]"
            details[difference] = 1e6 * rigid_compliance(dataset, ics)
            rest = f"{scene}: largest part with {ics_symbol(ics)} that is not rigid, of its approach"
            details[rest] = float(np.max(non_rigid_share(dataset, ics)))
        parts = zip(contacts.loads, rigid_parts(dataset) / dataset[APPROACH].sel(ics=C).values, strict=True)
        for load, part in parts:
            details[f"{scene}, {load / 1e3:g} kN: difference over the approach with C"] = float(part)
    return details


def _rigid_panels(runs: Runs) -> Iterator[Panel]:
    """Yield differences over the load with all ICs, and M_zz times the load, a panel per pair."""
    for contacts in reversed(SERIES):
        dataset, load = runs.fe_contact(contacts), np.array(contacts.loads) / 1e3
        names = [str(name) for name in dataset.ics.values if name != FE]
        curves = make_curves(load, {ics_symbol(name): rigid_parts(dataset, name) for name in names})
        rigid = Curve("M_zz · load", load, float(dataset.rigid_compliance) * 1e3 * load)
        title = f"{contacts.scene}: approach by finite elements less that with ICs"
        yield Panel(title, "load [kN]", "difference [mm]", [*curves, rigid])


STATEMENTS = (
    Statement(
        22,
        "Contact with C agrees with finite-element contact of two meshed bodies.",
        (
            below(
                AGREES,
                "patch",
                "wide: a, b, Δδ, p_max with C: deviation from finite elements minus their estimate",
            )(beyond_estimate(CENTRED, *OF_PATCH)),
            below(
                AGREES,
                "approach",
                "wide: the same for the approach with C, without M_zz of both bodies; nothing is fitted",
            )(beyond_estimate(CENTRED, APPROACH)),
        ),
        pressure_panels(CENTRED),
        deviation_details(CENTRED),
    ),
    Statement(
        23,
        "Contact with C also agrees with finite-element contact of two meshed bodies away from the crown.",
        (
            below(
                AGREES,
                "pressure",
                f"{BESIDE.scene}, upper body moved by {BESIDE.shift:g} mm: p_max with C: deviation from "
                "finite elements minus their estimate",
            )(beyond_estimate(BESIDE, "p_max")),
            below(AGREES_FORCE, "force", "the same for the lateral force with C, divided by the load")(
                beyond_estimate(BESIDE, "F_y", over="load")
            ),
            below(AGREES_CENTRE, "centre", "the same for the centre of pressure with C [mm]")(
                beyond_estimate(BESIDE, "s_centre", over="unit")
            ),
            below(
                AGREES,
                "approach",
                "the same for the approach with C, relative, without M_zz of both bodies; nothing is fitted",
            )(beyond_estimate(BESIDE, APPROACH)),
        ),
        pressure_panels(BESIDE),
        deviation_details(BESIDE),
    ),
    Statement(
        24,
        "The size of elements changes contact with C by no more than its estimated errors.",
        [
            below(
                SAME,
                name,
                f"{SCENE}, {LOAD:g} N: change of {name} from grid to grid minus both estimates, as a share",
            )(change_beyond_estimates(name))
            for name in NUMBERS
        ],
        _element_panels,
        _element_details,
    ),
    Statement(
        33,
        "The approaches by finite elements and with ICs differ by a rigid part (section 6.1).",
        (_proportional, _rigid),
        _rigid_panels,
        _rigid_details,
    ),
    Statement(
        43,
        "Contact with C agrees with finite-element contact at all angles on both pairs.",
        (
            below(
                AGREES, "patch", "a, b, Δδ, p_max with C: deviation from finite elements minus their estimate"
            )(beyond_estimate_everywhere(*OF_PATCH)),
            below(AGREES, "approach", "the same for the approach with C, without M_zz of both bodies")(
                beyond_estimate_everywhere(APPROACH)
            ),
        ),
        _angle_panels,
        _angle_details,
    ),
)
