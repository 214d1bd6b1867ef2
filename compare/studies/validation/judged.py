"""Statement 22: whether contact by C is that of two meshed bodies, which use no ICs."""

from collections.abc import Mapping, Sequence

import numpy as np

from compare.pages.panels import Panel
from compare.pages.styles import SYMBOLS
from compare.results.judge.dataset import FE, OF_PATCH
from compare.results.judge.deviations import deviations, known
from compare.studies.validation.criteria import Criterion, Numbers, Statement
from compare.studies.validation.runs import Runs

JUDGED = "wide"  # the scene
LOADS = (660e3, 5300e3)  # N: patches over 39 and 77 degrees
AGREES = 0.02  # of a number, beside the estimate of finite elements
APPROACHES = "approach"


def apart(names: Sequence[str]) -> Numbers:
    """Measure how far numbers by C are from those by finite elements, beyond their estimate, by load."""

    def measure(runs: Runs) -> Mapping[str, float]:
        dataset = runs.judged(JUDGED, LOADS)
        return {
            f"{case}, {name}": float((abs(deviations(dataset, name)) - known(dataset, name)).sel(ics="C")[k])
            for name in names
            for k, case in enumerate(dataset.case.values)
        }

    return measure


def _details(runs: Runs) -> Mapping[str, float]:
    """Numbers by all ICs less those by finite elements, as shares of these, and what these are known to."""
    dataset = runs.judged(JUDGED, LOADS)
    by_ics = {
        f"{case}, {name} by {SYMBOLS[ics]}": float(deviations(dataset, name).sel(ics=ics)[k])
        for name in (*OF_PATCH, APPROACHES)
        for ics in map(str, deviations(dataset, name).ics.values)
        for k, case in enumerate(dataset.case.values)
    }
    estimates = {
        f"{case}, {name}: estimate of FE": float(known(dataset, name)[k])
        for name in OF_PATCH
        for k, case in enumerate(dataset.case.values)
    }
    return by_ics | estimates


def _panels(runs: Runs) -> list[Panel]:
    dataset = runs.judged(JUDGED, LOADS)
    return [_panel(runs, number) for number in range(dataset.sizes["case"])]


def _panel(runs: Runs, number: int) -> Panel:
    """Pressures across the patch by finite elements and by ICs."""
    dataset = runs.judged(JUDGED, LOADS)
    s = dataset[f"s_fe_{number}"].values
    p = dataset[f"p_{number}"].dropna("ics", how="all")
    by_ics = {
        SYMBOLS[str(name)]: np.interp(s, p[f"s_{number}"].values, p.sel(ics=name).values)
        for name in p.ics.values
    }
    return Panel(
        f"{JUDGED}, {dataset.case.values[number]}",
        "s [mm]",
        s,
        "pressure at x = 0 [MPa]",
        by_ics | {FE: dataset[f"p_fe_{number}"].values},
    )


STATEMENTS = (
    Statement(
        22,
        "Contact by C is that of two meshed bodies without ICs.",
        (
            Criterion(
                "patch",
                f"{JUDGED}: a, b, Δδ, p_max by C: deviation from finite elements less their estimate",
                "<",
                AGREES,
                apart(OF_PATCH),
            ),
            Criterion(
                "approach",
                f"{JUDGED}: approach by C, likewise, but for one compliance of the bodies",
                "<",
                AGREES,
                apart((APPROACHES,)),
            ),
        ),
        _panels,
        _details,
    ),
)
