"""Statement 33 ([BVSV] section 6.1): approaches of finite elements and of ICs differ by a rigid part.

A rigid part moves each body as a whole in proportion to the load: one compliance for all loads. With C it is
M_zz of both bodies, which their ICs exclude.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from compare.pages.finite_elements import estimates
from compare.report.charts import Curve, Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import SATISFACTORY, Numbers, Statement
from compare.validation.statements.fe_contacts import AGREES, AT_ALL_ANGLES, CENTRED
from compare.validation.statements.runs import Runs
from femic.contact.pairs.ics import C
from femic.results.finite_elements import APPROACH, FE
from geometries.arrays import Array

SERIES = (CENTRED, AT_ALL_ANGLES)


def rigid_parts(dataset: xr.Dataset, ics: str = C) -> Array:
    """Return approaches of finite elements on their supports less those with ICs [mm], by load, (n,)."""
    with_ics = dataset[APPROACH].sel(ics=ics, drop=True)
    return np.asarray((dataset[f"fe_raw_{APPROACH}"] - with_ics).values, dtype=float)


def compliance(dataset: xr.Dataset, ics: str = C) -> float:
    """Return the one compliance [mm/N] that fits the rigid parts of all loads best (least squares)."""
    load = dataset["load"].values
    return float(rigid_parts(dataset, ics) @ load / (load @ load))


def off_rigid(dataset: xr.Dataset, ics: str = C) -> Array:
    """Return |rigid part less compliance times load| over the approach with ICs, by load, (n,).

    The compliance is that of the other loads, so that one load alone cannot decide it.
    """
    parts, load = rigid_parts(dataset, ics), dataset["load"].values
    others = [np.arange(len(load)) != k for k in range(len(load))]
    known = np.array([parts[other] @ load[other] / (load[other] @ load[other]) for other in others])
    return np.asarray(np.abs(parts - known * load) / dataset[APPROACH].sel(ics=ics).values)


def beyond_estimate(runs: Runs) -> Mapping[str, float]:
    """Measure what is not rigid in the differences with C, less the estimate of finite elements."""
    measured: dict[str, float] = {}
    for contacts in SERIES:
        dataset = runs.fe_contact(contacts)
        known = estimates(dataset, APPROACH).values / dataset[APPROACH].sel(ics=FE).values
        beyond = off_rigid(dataset) - np.abs(known)
        measured |= {
            f"{contacts.scene}, {load / 1e3:g} kN": float(v)
            for load, v in zip(contacts.loads, beyond, strict=True)
        }
    return measured


def off_mzz(runs: Runs) -> Mapping[str, float]:
    """Measure |compliance over M_zz of both bodies - 1|."""
    datasets = {contacts.scene: runs.fe_contact(contacts) for contacts in SERIES}
    return {
        scene: abs(compliance(dataset) / float(dataset.rigid_compliance) - 1)
        for scene, dataset in datasets.items()
    }


def details(runs: Runs) -> Mapping[str, float]:
    """Return the rigid parts by load, and compliances with all ICs."""
    numbers: dict[str, float] = {}
    for contacts in SERIES:
        dataset = runs.fe_contact(contacts)
        scene = contacts.scene
        numbers[f"{scene}: M_zz of both bodies [mm/MN]"] = 1e6 * float(dataset.rigid_compliance)
        for ics in (str(name) for name in dataset.ics.values if name != FE):
            symbol = symbol_of(ics)
            numbers[f"{scene}: compliance of the difference to {symbol} [mm/MN]"] = 1e6 * compliance(
                dataset, ics
            )
            numbers[f"{scene}: largest part with {symbol} that is not rigid, of its approach"] = float(
                np.max(off_rigid(dataset, ics))
            )
        parts = rigid_parts(dataset) / dataset[APPROACH].sel(ics=C).values
        numbers |= {
            f"{scene}, {load / 1e3:g} kN: difference over the approach with C": float(part)
            for load, part in zip(contacts.loads, parts, strict=True)
        }
    return numbers


def panels(runs: Runs) -> list[Panel]:
    """Return differences over the load with all ICs, and M_zz times the load, a panel per pair."""
    drawn = []
    for contacts in SERIES:
        dataset = runs.fe_contact(contacts)
        load = np.array(contacts.loads) / 1e3
        names = [str(name) for name in dataset.ics.values if name != FE]
        curves = curves_of(load, {symbol_of(name): rigid_parts(dataset, name) for name in names})
        rigid = Curve("M_zz · load", load, float(dataset.rigid_compliance) * 1e3 * load)
        drawn.append(
            Panel(
                f"{contacts.scene}: approach by finite elements less that with ICs",
                "load [kN]",
                "difference [mm]",
                [*curves, rigid],
            )
        )
    return drawn


STATEMENTS = (
    Statement(
        33,
        "Approaches by finite elements and with ICs differ by a rigid part (section 6.1).",
        (
            Numbers(beyond_estimate).below(
                AGREES,
                "proportional",
                "|difference of the approach with C less the compliance at the other loads times the load| "
                "over the approach, minus the estimate of finite elements",
            ),
            Numbers(off_mzz).below(
                SATISFACTORY, "rigid", "|compliance of all loads over M_zz of both bodies - 1|"
            ),
        ),
        panels,
        details,
    ),
)
