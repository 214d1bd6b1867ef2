"""The page of a scene, drawn from its datasets alone: errors, curves by component, agreement of engines."""

import json

import numpy as np
import pytest
import xarray as xr

from compare.pages.ics import LEAST_ESTIMATE, largest_errors, page
from compare.pages.ics_details import SceneICs, accuracy_table, agreement_table, details, disagreements
from compare.pages.ics_figures import chart, components_in, further_chart
from compare.report.charts import Chart
from compare.report.parts import Folded, Section
from femic.cli.main import DONE, exit_code
from geometries.patches import COMPONENTS
from tests.compare.conftest import on_line
from tests.compare.pages import read_chart, read_traces, require_number, require_room


@pytest.fixture(scope="module")
def scene(small):
    """The datasets of a coarse scene with unlike bodies."""
    _, dataset, errors = small
    return SceneICs(dataset, errors)


@pytest.fixture(scope="module")
def shown(scene):
    return page("small", {"small": scene}, details(scene, []))


def test_summary_has_the_errors_of_the_answer_the_closest_first(shown):
    errors = {row.name: row.filled[0].below for row in shown.answer.rows}
    places = [
        shown.summary.index(text) for text in sorted(errors.values(), key=lambda text: float(text.split()[0]))
    ]
    assert places == sorted(places)
    assert shown.summary.startswith("Largest error of the combined ICs in nn: ")


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
        vanish = [
            c for c in components_in(scene.ics) if known.solved_vanishes.sel(i=c[0], j=c[1]).values.any()
        ]
        assert row.filled[-1].text == (", ".join(vanish) or "–")


def test_answer_has_the_worst_errors_of_both_bodies_and_the_estimate_of_c_there(scene, shown):
    answer, worst = shown.answer, scene.errors.sel(body="combined").max("line")
    components = components_in(scene.ics)
    kinds = {"nn": ["nn"], "tangential components": ["xx", "ss", "xs"], "cross terms": ["xn", "sn"]}
    assert [column.head for column in answer.heads] == list(kinds)
    assert sorted(c for members in kinds.values() for c in members) == sorted(components)
    assert [row.name for row in answer.rows] == ["A", "B", "B̄", "B̂", "mix"]
    for variant, row in zip(("A", "B", "Bbar", "Bhat", "mix"), answer.rows, strict=True):
        for members, cell in zip(kinds.values(), row.filled, strict=True):
            error = worst.error.sel(variant=variant)
            largest = max(members, key=lambda c: error.sel(i=c[0], j=c[1]).item())
            at = {"i": largest[0], "j": largest[1]}
            numbers, _, place = cell.below.split("; weight")[0].partition(" %")
            estimate = max(worst.error.sel(variant="C").sel(at).item(), LEAST_ESTIMATE)
            require_number(numbers, 100 * error.sel(at), 100 * estimate)
            assert place.removesuffix(" †)").strip(" ()") == ("" if largest == "nn" else largest)
            assert cell.text in ("yes", "no", "not decided")


@pytest.mark.parametrize(
    ("errors", "estimate", "expected"),
    [
        ({"nn": 0.015}, 0.004, "yes"),
        ({"nn": 0.025}, 0.004, "no"),
        ({"nn": 0.018}, 0.004, "not decided"),
        ({"nn": 0.022}, 0.004, "not decided"),
        ({"ss": 0.001, "xx": 0.025}, 0.004, "no"),
        ({"ss": 0.001, "xx": 0.018}, 0.004, "not decided"),
    ],
)
def test_error_is_within_the_tolerance_only_with_its_estimate(errors, estimate, expected):
    """The tolerance of a scene is 2 % unless it says otherwise."""
    assert [one.verdict.item() for one in largest_errors(made(errors, estimate)).values()] == [expected]


def test_tolerance_is_that_of_the_scene():
    scene = made({"nn": 0.025}, 0.004, "ics_tolerance = 0.03")
    assert largest_errors(scene)["nn"].verdict.item() == "yes"


@pytest.mark.parametrize(("estimate", "is_open"), [(0.004, False), (0.006, True)])
def test_closest_form_is_not_decided_if_errors_differ_by_less_than_the_estimate(estimate, is_open):
    scene = made({"nn": 0.01}, estimate, B=0.005)
    sentence = "Which of A and B is closest to C is not decided."
    assert (sentence in page("", {"": scene}, []).summary) == is_open


@pytest.mark.parametrize(("estimate", "doubted"), [(0.04, False), (0.06, True)])
def test_c_that_misses_its_tolerance_is_a_doubt(estimate, doubted):
    """The engine's tolerance is 5 %."""
    shown = page("", {"": made({"nn": 0.01}, estimate)}, [])
    assert len(shown.doubts) == doubted
    assert ("C is not converged" in shown.summary) == doubted


def made(errors, estimate, text="", **further):
    """Errors of A by component, of further forms 0.5 % larger ..., with the estimate of C, on one line."""
    variants = ["A", *further, "C"]
    places = {"i": list("xsn"), "j": list("xsn")}
    error = xr.DataArray(
        np.zeros((1, len(variants), 1, 3, 3)),
        {"body": ["lower"], "variant": variants, "line": ["s = 0"], **places},
    )
    for component, value in errors.items():
        at = {"i": component[0], "j": component[1]}
        for name, more in {"A": 0.0, **further}.items():
            error.loc[at | {"variant": name}] = value + more
        error.loc[at | {"variant": "C"}] = estimate
    solved = error.sel(variant="C", drop=True).rename(body="solved").expand_dims(part=["all"])
    vanishes = xr.zeros_like(error.isel(variant=0, line=0, drop=True), dtype=bool)
    variables = {"error": error, "rms": error, "weight": error, "vanishes": vanishes}
    attributes = {
        "components": json.dumps(list(errors)),
        "scene": text,
        "settings": json.dumps({"tolerance": 0.05}),
        "warnings": "[]",
    }
    ics = xr.Dataset(
        coords={"body": ["lower"], "variant": variants, "line": ("point", ["s = 0", "s = 0"])},
        attrs=attributes,
    )
    return SceneICs(ics, xr.Dataset(variables | {"solved_refinement": solved}))


def test_curves_of_one_line_come_first_and_all_else_is_folded(scene):
    blocks = list(page("small", {"small": scene}, details(scene, [])).sections)
    charts = [block for section in blocks if isinstance(section, Section) for block in section.blocks]
    assert [block.name for block in charts if isinstance(block, Chart)] == ["curves"]
    headings = [block.heading for block in blocks if isinstance(block, Folded)]
    assert headings == [
        "ICs on the other lines, and of each body",
        "Errors of each body on each line",
        "The scene",
        "Accuracy of C",
        "Cost",
        "Settings",
    ]


def test_curves_on_the_page_are_the_ics_and_their_differences_from_c(scene):
    """[µm/kN] over [mm]; what lines between the drawn points leave out is not seen."""
    dataset, shown = scene.ics, {"small": scene.ics}
    cells = {}
    for drawn in (chart(shown), further_chart(shown)):
        content = read_chart(drawn)
        assert content["labels"] == json.loads(dataset.components)
        assert content["labels"][content["start"]] == "nn"
        cells |= {cell["title"]: cell for cell in content["steps"][content["labels"].index("sn")]}
    assert list(cells) == [
        "combined, x = 1.6 mm",
        "combined, x = 1.6 mm: minus C",
        "combined, s = 1.6 mm",
        "combined, s = 1.6 mm: minus C",
        "lower, x = 1.6 mm",
        "upper, x = 1.6 mm",
    ]
    sn = on_line(dataset, "x = 1.6 mm").sel(i="s", j="n")
    sn = sn.isel(point=np.flatnonzero(sn.s.values >= 0))
    for body, title in (("combined", ""), ("combined", ": minus C"), ("lower", "")):
        ic = sn.ic.sel(body=body)
        expected = 1e6 * (ic - ic.sel(variant="C")) if title else 1e6 * ic
        cell, seen = cells[f"{body}, x = 1.6 mm{title}"], 1.01e-3 * float(expected.max() - expected.min())
        drawn = read_traces(cell)
        for variant, name in (("A", "A"), ("Bhat", "B̂"), ("C", "C")):
            between = np.interp(sn.s, drawn[name]["x"], drawn[name]["y"])
            np.testing.assert_allclose(between, expected.sel(variant=variant).values, atol=seen)
        (band,) = (trace for trace in cell["traces"] if trace.get("fill"))
        half = len(band["y"]) // 2
        size = np.subtract(band["y"][:half], band["y"][half:][::-1]) / 2
        estimate = 1e6 * sn.estimate.sel(body=body)
        np.testing.assert_allclose(np.interp(sn.s, band["x"][:half], size), estimate, atol=seen)


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
    require_room(browser, out / "report.html", {800: np.inf, 400: np.inf})  # wide tables scroll in their box


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
    scene = SceneICs(ics, errors)
    assert disagreements(scene) == ([] if verdict == "yes" else ["lower, a, sn"])
    (row,) = agreement_table(scene).rows
    assert row.cells == ["3.00% (sn)", f"sn: 3.00% of {allowed:.2%}", verdict]
