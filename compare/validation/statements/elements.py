"""Statement 24: whether contact with C depends on the size of elements beyond its estimates."""

from collections.abc import Mapping
from itertools import pairwise

import xarray as xr

from compare.report.charts import Panel, curves_of
from compare.report.looks import symbol_of
from compare.validation.statements.criteria import Numbers, Statement
from compare.validation.statements.runs import Runs

SCENE, LOAD = "tall", 310e3  # N: a patch over 108 degrees
ELEMENTS = (8, 16, 32)  # across the patch
AGREES = 0.002  # of a number, beside both estimates
NUMBERS = ("approach", "p_max", "a", "b")


def by_element_count(runs: Runs) -> Mapping[int, xr.Dataset]:
    """Return the numbers of the contact with C by the number of elements across the patch."""
    return {
        n: runs.contact(SCENE, {"loads": [LOAD], "elements": n, "ics": ["Bhat", "C"]}).isel(case=0)
        for n in ELEMENTS
    }


def beyond_estimates(name: str) -> Numbers:
    """Measure the change of a number from grid to grid beyond both estimates, as a share of it."""

    def measure(runs: Runs) -> Mapping[str, float]:
        with_c = {n: dataset.sel(ics="C") for n, dataset in by_element_count(runs).items()}
        return {
            f"{few} and {many} elements, {name}": float(
                abs(coarse[name] - fine[name]) - coarse[f"estimate_{name}"] - fine[f"estimate_{name}"]
            )
            / float(fine[name])
            for (few, coarse), (many, fine) in pairwise(with_c.items())
        }

    return Numbers(measure)


def _details(runs: Runs) -> Mapping[str, float]:
    """Return the numbers with C."""
    return {
        f"{n} elements, {name} [{dataset[name].units}]": float(dataset[name].sel(ics="C"))
        for n, dataset in by_element_count(runs).items()
        for name in NUMBERS
    }


def _panels(runs: Runs) -> list[Panel]:
    """Return approaches with C and with B-hat over the number of elements, and the estimate with C."""
    names = ["approach", "estimate_approach"]
    contacts = xr.concat([dataset[names] for dataset in by_element_count(runs).values()], "n")
    approaches = {symbol_of(ics): contacts.approach.sel(ics=ics).values for ics in ("C", "Bhat")}
    curves = curves_of(ELEMENTS, approaches, contacts.estimate_approach.sel(ics="C").values)
    return [Panel(f"{SCENE}, {LOAD / 1e3:g} kN", "elements across the patch", "approach [mm]", curves)]


STATEMENTS = (
    Statement(
        24,
        "Contact with C does not depend on the size of elements beyond its estimates.",
        tuple(
            beyond_estimates(name).below(
                AGREES,
                name,
                f"{SCENE}, {LOAD:g} N: change of {name} from grid to grid minus both estimates, as a share",
            )
            for name in NUMBERS
        ),
        _panels,
        _details,
    ),
)
