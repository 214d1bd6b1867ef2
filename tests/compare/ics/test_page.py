"""The page of a scene: three sentences, errors of the bodies together, curves by component."""

import json
import re

import numpy as np
import pytest

from compare.pages import ics_figures as curves
from compare.pages.ics import page_of, summary
from compare.pages.ics_figures import RunOutput
from compare.report.charts import Chart
from compare.report.interactive import as_json
from compare.report.looks import symbol_of
from compare.report.parts import Folded, Section, join_words
from femic.cli.main import DONE, exit_code
from geometries.patches import COMPONENTS
from tests.compare.conftest import on_line
from tests.pages import widest

COUNT = r"\.(?: |$)"  # ends of sentences, not decimal points


@pytest.fixture
def output(small, tmp_path):
    results, dataset, errors = small
    return RunOutput(results, dataset, errors, tmp_path)


def test_summary_has_three_sentences_with_the_numbers_of_the_errors(small):
    results, _, errors = small
    text = summary(results, errors)
    assert len(re.findall(COUNT, text)) == 3
    worst = errors.sel(body="combined").max("line")
    nn = worst.error.sel(i="n", j="n")
    values = {variant: nn.sel(variant=variant).item() for variant in results.scene.variants}
    within = min(values.values()) + nn.sel(variant="C").item()
    closest = [variant for variant in values if values[variant] <= within]
    assert 1 < len(closest) < len(values)
    assert text.startswith(
        f"In nn of both bodies together, {join_words(map(symbol_of, closest))} are closest"
    )
    assert f"closest to C: {100 * max(values[v] for v in closest):.2f} % off at most (A 4.80 %)." in text
    known = max(worst.weight.sel(variant="C", i=c[0], j=c[1]).item() for c in results.scene.components)
    assert f"C is known to {100 * known:.2f} % of C_nn" in text


def test_summary_names_the_error_with_the_largest_weight(small):
    results, _, errors = small
    worst = errors.sel(body="combined").max("line")
    others = [component for component in results.scene.components if component != "nn"]
    weights = {
        (worst.weight.sel(variant=variant, i=c[0], j=c[1]).item(), c, variant)
        for variant in results.scene.variants
        for c in others
    }
    weight, component, variant = max(weights)
    error = worst.error.sel(variant=variant, i=component[0], j=component[1]).item()
    expected = (
        f"with {symbol_of(variant)} it is {100 * error:.1f} % of {component} ({100 * weight:.1f} % of C_nn)."
    )
    assert expected in summary(results, errors)


def test_answer_has_the_worst_errors_of_both_bodies_and_their_weights(output):
    results, errors = output.results, output.errors.sel(body="combined")
    answer = page_of(output).answer
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


def test_curves_come_first_and_all_else_is_folded(output):
    blocks = list(page_of(output).sections)
    charts = [block for section in blocks if isinstance(section, Section) for block in section.blocks]
    assert [block.name for block in charts if isinstance(block, Chart)] == ["curves"]
    headings = [block.heading for block in blocks if isinstance(block, Folded)]
    assert headings == ["Errors of each body on each line", "The scene", "Accuracy of C", "Cost", "Settings"]


def test_curves_on_the_page_are_the_ics_and_their_differences_from_c(output):
    """[µm/kN] over [mm]; the bodies together come first, below them the differences."""
    dataset = output.ics
    content = json.loads(as_json(curves.chart(output.results.scene, dataset)))
    assert content["labels"] == list(output.results.scene.components)
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
        drawn = {trace["name"]: trace for trace in cell["traces"] if "name" in trace}
        np.testing.assert_allclose(drawn["B̂"]["x"], sn.s, rtol=1e-5)
        for variant, name in (("A", "A"), ("Bhat", "B̂"), ("C", "C")):
            values = expected.sel(variant=variant).values
            np.testing.assert_allclose(drawn[name]["y"], values, rtol=1e-5, atol=1e-12)
        (band,) = (trace for trace in cell["traces"] if trace.get("fill"))
        half = len(sn.s)
        size = np.subtract(band["y"][:half], band["y"][half:][::-1])
        np.testing.assert_allclose(size, 2e6 * sn.estimate.sel(body=body), rtol=1e-4, atol=1e-5)


def test_component_that_vanishes_by_symmetry_is_zero_on_the_page(output):
    dataset = output.ics.assign(ic=output.ics.ic * 1e-12)
    content = json.loads(as_json(curves.chart(output.results.scene, dataset)))
    assert all("annotations" in cell["layout"] for cells in content["steps"] for cell in cells)


@pytest.mark.slow
def test_page_of_all_components_is_not_wider_than_800_pixels(write_scene, tmp_path, browser):
    components = ", ".join(f'"{component}"' for component in COMPONENTS)
    path = write_scene(f"components = [{components}]")
    out = tmp_path / "out"
    assert exit_code(["run", str(path), "--out", str(out), "--workers", "1"]) == DONE
    page, table = widest(browser, out / "report.html", 800)
    assert page <= 800
    assert table <= 770
