"""Statement 24: whether contact by C depends on the size of elements beyond its estimates."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import xarray as xr

from compare.report.panels import Panel
from femic.validation.statements.criteria import Criterion, Numbers, Statement
from femic.validation.statements.runs import Runs

SCENE, LOAD = "tall", 310e3  # N: a patch over 108 degrees
ELEMENTS = (8, 16, 32)  # across the patch
AGREES = 0.002  # of a number, beside both estimates
NUMBERS = ("approach", "p_max", "a", "b")


def on_elements(runs: Runs) -> Mapping[int, xr.Dataset]:
    """The numbers of the contact by C by the number of elements across the patch."""
    return {
        n: runs.contact(SCENE, {"loads": [LOAD], "elements": n, "ics": ["Bhat", "C"]}).isel(case=0)
        for n in ELEMENTS
    }


def beyond_estimates(name: str) -> Numbers:
    """Measure by how much a number changes beyond both estimates, as a share of it, from grid to grid."""

    def measure(runs: Runs) -> Mapping[str, float]:
        by_c = {n: dataset.sel(ics="C") for n, dataset in on_elements(runs).items()}
        return {
            f"{few} and {many} elements, {name}": float(
                abs(one[name] - other[name]) - one[f"estimate_{name}"] - other[f"estimate_{name}"]
            )
            / float(other[name])
            for (few, one), (many, other) in pairwise(by_c.items())
        }

    return measure


def _details(runs: Runs) -> Mapping[str, float]:
    """The numbers by C."""
    return {
        f"{n} elements, {name} [{dataset[name].units}]": float(dataset[name].sel(ics="C"))
        for n, dataset in on_elements(runs).items()
        for name in NUMBERS
    }


def _panels(runs: Runs) -> list[Panel]:
    """Approaches by C and by B-hat over the number of elements."""
    found = on_elements(runs)
    curves = {
        symbol: xr.concat([dataset.approach.sel(ics=ics) for dataset in found.values()], "n").values
        for ics, symbol in (("C", "C"), ("Bhat", "B̂"))
    }
    return [
        Panel(SCENE, "elements across the patch", np.array(ELEMENTS, dtype=float), "approach [mm]", curves)
    ]


STATEMENTS = (
    Statement(
        24,
        "Contact by C does not depend on the size of elements beyond its estimates.",
        tuple(
            Criterion(
                name,
                f"{SCENE}, {LOAD:g} N: change of {name} from grid to grid less both estimates, as a share",
                "<",
                AGREES,
                beyond_estimates(name),
            )
            for name in NUMBERS
        ),
        _panels,
        _details,
    ),
)
