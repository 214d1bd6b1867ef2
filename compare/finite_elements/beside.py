"""Finite elements on the page of a contact: a section, and a row in the table of each case."""

import numpy as np
import xarray as xr

from compare.contact.compute import ContactResults
from compare.contact.dataset import reference_of, to_dataset
from compare.contact.page import FurtherSolution
from compare.finite_elements.compute import stored_fe_contact
from compare.finite_elements.dataset import FE, NUMBERS, OF_PLACE
from compare.finite_elements.page import approach_note, over_angle, summary
from compare.report.parts import Picture, Section
from compare.report.tables import Cell, Row
from femic.cache.store import Store
from femic.contact.pairs.quantities import OF_FRICTIONLESS


def stored_solution(results: ContactResults, store: Store) -> FurtherSolution | None:
    """Return stored contacts of a scene by finite elements; None where there are none."""
    dataset = to_dataset(results)
    fe_contacts = stored_fe_contact(results.scene, dataset, store)
    if fe_contacts is None:
        return None
    pictures = [Picture("fe", over_angle(fe_contacts))]
    rows = {
        number: _row(dataset.isel(case=number), fe_contacts.isel(case=number))
        for number in map(int, np.flatnonzero(fe_contacts.a.sel(ics=FE).notnull()))
    }
    return FurtherSolution(
        Section("Comparison with finite elements without ICs (FE)", [summary(fe_contacts), *pictures]),
        rows,
        "FE: the bodies have the same supports as with C; estimates are differences to cells twice as "
        f"large. {approach_note(fe_contacts)}",
    )


def _row(case: xr.Dataset, fe_contacts: xr.Dataset) -> Row:
    """Return the row of finite elements in a case; they have some of the numbers."""
    reference, of_fe = case.sel(ics=reference_of(case)), fe_contacts.sel(ics=FE)
    cells = [_cell(of_fe, reference, key) if key in NUMBERS else Cell("–") for key in OF_FRICTIONLESS]
    return Row(FE, [*cells, Cell("–"), Cell("–"), Cell(float(fe_contacts.fe_seconds.sum()), ".0f")])


def _cell(of_fe: xr.Dataset, reference: xr.Dataset, key: str) -> Cell:
    ratio = "" if key in OF_PLACE else f"; {float(of_fe[key] / reference[key]):.4f}"
    return Cell(float(of_fe[key]), ".5g", f"± {float(of_fe[f'estimate_{key}']):.2g}{ratio}")
