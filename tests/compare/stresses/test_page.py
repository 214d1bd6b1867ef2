"""The page of stresses, wear and fatigue below a contact."""

import numpy as np

from compare.pages.stresses import damage_table, stress_table, write_stresses
from tests.femic.results.solved_stresses import rolling_stresses


def test_page_has_sentences_tables_and_figures(tmp_path):
    page = write_stresses(rolling_stresses().dataset, tmp_path).read_text(encoding="utf-8")
    for text in (
        "Largest von Mises stress at",
        "half-space, tractions of A",
        "T-gamma",
        "FI_surf",
        "wear depth per passage: Archard",
        "depth [mm]",
    ):
        assert text in page


def test_ratios_to_nothing_are_none():
    given = rolling_stresses().dataset
    changed = {name: 0 * given[name] for name in ("t_gamma", "work")}
    nothing = given.assign(changed | {"difference_dang_van": np.nan * given.difference_dang_van})
    tables = damage_table(nothing), stress_table(nothing)
    shown = [cell.below for table in tables for row in table.rows for cell in row.filled]
    assert not any("nan" in below or "inf" in below for below in shown)
