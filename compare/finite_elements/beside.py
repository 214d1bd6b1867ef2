"""Finite elements on the page of a contact: a section, and a row beside those of ICs in each case."""

import numpy as np
import xarray as xr

from compare.contact.compute import ContactResults
from compare.contact.dataset import to_dataset
from compare.contact.figures import reference_of
from compare.contact.page import Beside
from compare.finite_elements.compute import kept_fe_contact
from compare.finite_elements.dataset import FE, NUMBERS, OF_PLACE
from compare.finite_elements.page import of_approaches, over_angle, summary
from compare.report.parts import Picture, Section
from compare.report.tables import Cell, Row
from femic.cache.store import Store
from femic.contact.pairs.quantities import OF_FRICTIONLESS


def beside_of(results: ContactResults, store: Store) -> Beside | None:
    """The contacts of a scene by finite elements, as far as the store has them; None where it has none."""
    dataset = to_dataset(results)
    by_fe = kept_fe_contact(results.scene, dataset, store)
    if by_fe is None:
        return None
    pictures = [Picture("fe", over_angle(by_fe))]
    rows = {
        number: _row(dataset.isel(case=number), by_fe.isel(case=number))
        for number in map(int, np.flatnonzero(by_fe.a.sel(ics=FE).notnull()))
    }
    return Beside(
        Section("Beside finite elements without ICs (FE)", [summary(by_fe), *pictures]),
        rows,
        "FE: the bodies have the supports that C gives them; estimates are differences to cells twice as "
        f"large. {of_approaches(by_fe)}",
    )


def _row(case: xr.Dataset, by_fe: xr.Dataset) -> Row:
    """The row of finite elements in a case; they know some of the numbers."""
    reference, of_fe = case.sel(ics=reference_of(case)), by_fe.sel(ics=FE)
    cells = [_cell(of_fe, reference, key) if key in NUMBERS else Cell("–") for key in OF_FRICTIONLESS]
    return Row(FE, [*cells, Cell("–"), Cell("–"), Cell(float(by_fe.fe_seconds.sum()), ".0f")])


def _cell(of_fe: xr.Dataset, reference: xr.Dataset, key: str) -> Cell:
    ratio = "" if key in OF_PLACE else f"; {float(of_fe[key] / reference[key]):.4f}"
    return Cell(float(of_fe[key]), ".5g", f"± {float(of_fe[f'estimate_{key}']):.2g}{ratio}")
