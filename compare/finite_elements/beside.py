"""Finite elements on the page of a contact: a section, and a column in the table of each case."""

import numpy as np

from compare.contact.compute import ContactResults
from compare.contact.dataset import to_dataset
from compare.contact.figures import MAIN
from compare.contact.page import FurtherSolution
from compare.finite_elements.compute import stored_fe_contact
from compare.finite_elements.dataset import FE, NUMBERS
from compare.finite_elements.page import FURTHER, approach_note, details, numbers_chart, summary
from compare.report.parts import Folded
from femic.cache.store import Store


def stored_solution(results: ContactResults, store: Store) -> FurtherSolution | None:
    """Return stored contacts of a scene by finite elements; None where there are none."""
    fe_contacts = stored_fe_contact(results.scene, to_dataset(results), store)
    if fe_contacts is None:
        return None
    named = [prefix + name for name in NUMBERS for prefix in ("", "estimate_")]
    with_fe = fe_contacts[named].sel(ics=FE)
    chart = numbers_chart(fe_contacts, (*MAIN, *FURTHER), "fe")
    return FurtherSolution(
        FE,
        Folded(
            "Comparison with finite elements without ICs (FE)",
            [summary(fe_contacts), *details(fe_contacts), chart],
        ),
        {number: with_fe.isel(case=number) for number in map(int, np.flatnonzero(with_fe.a.notnull()))},
        "FE: the bodies have the same supports as with C; estimates are differences to cells twice as "
        f"large. {approach_note(fe_contacts)}",
    )
