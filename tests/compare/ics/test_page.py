"""The page of a scene, drawn from its datasets alone: errors, curves by component, agreement of engines."""

import json
import re

import numpy as np
import pytest
import xarray as xr

from compare.pages.ics import SceneICs, accuracy_table, agreement_table, chart, components_in, details, page
from compare.report.charts import Chart
from compare.report.parts import Folded, Section
from femic.cli.main import DONE, exit_code
from geometries.patches import COMPONENTS
from tests.compare.conftest import on_line
from tests.compare.pages import read_chart, read_traces, require_room


@pytest.fixture(scope="module")
def scene(small):
    """The datasets of a coarse scene with unlike bodies."""
    _, dataset, errors = small
    return SceneICs(dataset, errors)


@pytest.fixture(scope="module")
def shown(scene):
    return page("small", {"small": scene}, details(scene, []))


def test_summary_has_the_errors_of_the_answer(shown):
    errors = [f"{row.name} {row.filled[0].text}" for row in shown.answer.rows]
    assert shown.summary == f"Combined C_nn, largest differences from C: {', '.join(errors)}."


def test_accuracy_has_the_largest_estimate_on_both_scales_and_parts_that_add_up(scene):
    for row in accuracy_table(scene).rows:
        known = scene.errors.sel(solved=row.name)
        shares = known.solved_error.where(~known.solved_vanishes), known.solved_refinement.sel(part="all")
        component, refinement, *parts = (
            float(cell.text.split("%")[0]) for cell in row.filled[:-1] if cell.text != "–"
        )
        for shown, values in zip((component, refinement), shares, strict=True):
            largest = max(values.sel(i=c[0], j=c[1]).max().item() for c in components_in(scene.ics))
            assert shown == pytest.approx(100 * largest, abs=0.006)
        assert max(parts) <= refinement + 0.006 <= sum(parts) + 0.03


def test_answer_has_the_worst_errors_of_both_bodies_and_their_weights(scene, shown, small):
    results, errors, answer = small[0], scene.errors.sel(body="combined"), shown.answer
    assert [column.head for column in answer.heads] == list(results.scene.components)
    assert [row.name for row in answer.rows][-1] == "C ±"
    for variant, row in zip(results.variants, answer.rows, strict=True):
        for component, cell in zip(results.scene.components, row.filled, strict=True):
            at = errors.sel(variant=variant, i=component[0], j=component[1])
            for text, shares in ((cell.text, at.error), (cell.below, at.weight)):
                if re.fullmatch(r"[\d.]+ %", text):
                    assert float(text[:-2]) == pytest.approx(100 * shares.max().item(), abs=0.05)
                else:
                    assert text in {"0", ""} if shares.max() < 1e-9 else text in {"< 0.01 %", "vanishes"}


def test_curves_come_first_and_all_else_is_folded(scene):
    blocks = list(page("small", {"small": scene}, details(scene, [])).sections)
    charts = [block for section in blocks if isinstance(section, Section) for block in section.blocks]
    assert [block.name for block in charts if isinstance(block, Chart)] == ["curves"]
    headings = [block.heading for block in blocks if isinstance(block, Folded)]
    assert headings == ["Errors of each body on each line", "The scene", "Accuracy of C", "Cost", "Settings"]


def test_curves_on_the_page_are_the_ics_and_their_differences_from_c(scene):
    """[µm/kN] over [mm]; the bodies together come first, below them the differences."""
    dataset = scene.ics
    content = read_chart(chart({"small": dataset}))
    assert content["labels"] == json.loads(dataset.components)
    assert content["labels"][content["start"]] == "nn"
    cells = {cell["title"]: cell for cell in content["steps"][content["labels"].index("sn")]}
    assert list(cells)[:3] == [
        "combined, s = 1.6 mm",
        "combined, x = 1.6 mm",
        "combined, s = 1.6 mm: minus C",
    ]
    sn = on_line(dataset, "x = 1.6 mm").sel(i="s", j="n")
    sn = sn.isel(point=np.flatnonzero(sn.s.values >= 0))
    for body, title in (("combined", ""), ("combined", ": minus C"), ("lower", "")):
        ic = sn.ic.sel(body=body)
        expected = 1e6 * (ic - ic.sel(variant="C")) if title else 1e6 * ic
        cell = cells[f"{body}, x = 1.6 mm{title}"]
        drawn = read_traces(cell)
        np.testing.assert_allclose(drawn["B̂"]["x"], sn.s, rtol=1e-5)
        for variant, name in (("A", "A"), ("Bhat", "B̂"), ("C", "C")):
            values = expected.sel(variant=variant).values
            np.testing.assert_allclose(drawn[name]["y"], values, rtol=1e-5, atol=1e-12)
        (band,) = (trace for trace in cell["traces"] if trace.get("fill"))
        half = len(sn.s)
        size = np.subtract(band["y"][:half], band["y"][half:][::-1])
        np.testing.assert_allclose(size, 2e6 * sn.estimate.sel(body=body), rtol=1e-4, atol=1e-5)


def test_component_that_vanishes_by_symmetry_is_zero_on_the_page(scene):
    dataset = scene.ics.assign(ic=scene.ics.ic * 1e-12)
    content = read_chart(chart({"small": dataset}))
    assert all("annotations" in cell["layout"] for cells in content["steps"] for cell in cells)


@pytest.mark.slow
def test_page_of_all_components_is_not_wider_than_the_window(write_scene, tmp_path, browser):
    components = ", ".join(f'"{component}"' for component in COMPONENTS)
    path = write_scene(f"components = [{components}]")
    out = tmp_path / "out"
    assert exit_code(["run", str(path), "--out", str(out), "--workers", "1"]) == DONE
    require_room(browser, out / "report.html")


@pytest.mark.parametrize(("allowed", "verdict"), [(0.04, "yes"), (0.02, "no")])
def test_engines_agree_within_the_sum_of_their_estimates(allowed, verdict):
    """C_sn of the solid engine is 3 % off, all else 1 %."""
    places = {"body": ["lower"], "line": ["a"], "i": list("xsn"), "j": list("xsn")}
    error = xr.DataArray(np.full((2, 1, 1, 3, 3), 0.01), {"variant": ["C", "C_solid"], **places})
    error.loc[{"variant": "C_solid", "i": "s", "j": "n"}] = 0.03
    both = xr.full_like(error.sel(variant="C", drop=True), allowed)
    vanishes = xr.full_like(both.isel(line=0, drop=True), False, dtype=bool)
    errors = xr.Dataset({"error": error, "vanishes": vanishes, "estimate_both": both})
    attributes = {"components": json.dumps(["nn", "sn"])}
    ics = xr.Dataset(coords={"body": ["lower"], "line": ("point", ["a", "a"])}, attrs=attributes)
    (row,) = agreement_table(SceneICs(ics, errors)).rows
    assert row.cells == ["3.00% (sn)", f"sn: 3.00% of {allowed:.2%}", verdict]
