"""The page of stresses, wear and fatigue below a contact."""

import numpy as np
import pytest
import xarray as xr

from compare.pages.stress_figures import section_chart, wear_chart
from compare.pages.stress_tables import answer_table, damage_table, exceeds, stress_table
from compare.pages.stresses import doubts, summary, write_stresses
from compare.report.tables import with_estimate
from compare.report.verdicts import NO, NOT_DECIDED, YES
from femic.results.stresses import ACTUAL, HALF_SPACE_OF_A
from femic.stresses.field import von_mises
from tests.femic.results.solved_stresses import rolling_stresses


@pytest.fixture
def dataset():
    return rolling_stresses().dataset


def answers(dataset):
    """The cells of the answer, by the questions."""
    return {row.name: row.filled for row in answer_table(dataset).rows}


def test_page_has_sentences_tables_and_figures(dataset, tmp_path):
    page = write_stresses(dataset, tmp_path).read_text(encoding="utf-8")
    for text in (
        "not decided whether the lower body yields",  # elements so few leave no estimate
        "half-space, tractions of A",
        "T-gamma",
        "FI_surf",
        "wear depth: Archard",
        "depth [mm]",
    ):
        assert text in page


@pytest.mark.parametrize(
    ("limit", "verdict"), [(1.0, YES), (1.9, NOT_DECIDED), (2.1, NOT_DECIDED), (2.3, NO), (np.inf, NO)]
)
def test_within_the_estimate_nothing_is_decided(limit, verdict):
    assert exceeds(2.0, 0.2, limit) == verdict
    assert exceeds(2.0, np.nan, limit) == NOT_DECIDED


@pytest.mark.parametrize("body", ["lower", "upper"])
def test_bodies_yield_where_von_mises_exceeds_the_yield_stress(dataset, body):
    """The table has the verdict of the actual body in the first column."""
    actual = dataset.sel(body=body, source=ACTUAL)
    given, number = dataset.assign(estimate_von_mises=0 * dataset.von_mises + 10), float(actual.von_mises)
    for limit, verdict in ((number - 20, YES), (number + 5, NOT_DECIDED), (number + 20, NO)):
        asked = given.assign_attrs(yield_stress=limit)
        (cells,) = (cells for name, cells in answers(asked).items() if name.startswith(f"Does the {body}"))
        assert cells[0].text == verdict


def test_material_ratchets_below_a_load_factor_of_1(dataset):
    for factor, verdict in ((0.9, YES), (0.99, NOT_DECIDED), (1.1, NO)):
        values = {"load_factor": factor, "estimate_load_factor": 0.02}
        given = dataset.assign({name: 0 * dataset.p_max + value for name, value in values.items()})
        assert answers(given)["Does the material ratchet?"][0].text == verdict


def test_doubts_go_with_their_causes(dataset):
    sure = dataset.assign_attrs(reference="C", yield_stress=1e9, fineness=1.0).assign(
        {
            name: xr.zeros_like(values)
            for name, values in dataset.items()
            if str(name).startswith("estimate_")
            or name in {"x_von_mises", "s_von_mises", "deepest_von_mises"}
        }
    )
    calm = doubts(sure)
    causes = [
        sure.assign_attrs(reference="Bhat"),
        sure.assign_attrs(yield_stress=1.0),
        sure.assign_attrs(fineness=0.5),
        sure.assign(deepest_von_mises=xr.ones_like(sure.deepest_von_mises)),
        sure.assign(x_von_mises=0 * sure.x_von_mises + float(dataset.x_lower[0])),
        sure.assign(estimate_von_mises=np.nan * sure.von_mises),
        sure.assign(estimate_xi=np.nan * sure.xi),
        sure.drop_attrs().assign_attrs({name: one for name, one in sure.attrs.items() if name != "speed"}),
    ]
    assert len(calm) == 1  # the coefficients of wear
    assert all(len(doubts(doubtful)) > len(calm) for doubtful in causes)


def test_without_a_yield_stress_the_page_says_which_one_would_do(dataset):
    attrs = {name: value for name, value in dataset.attrs.items() if name != "yield_stress"}
    given = dataset.drop_attrs().assign_attrs(attrs)
    assert "The lower body yields if its yield stress is below" in summary(given)
    assert any(name.startswith("Yield stress below which the lower") for name in answers(given))


def test_sections_have_the_stresses_of_the_lattice_at_its_points(dataset):
    """Between them there are no larger ones, and no gaps between colours."""
    actual, half, difference = section_chart(dataset).cells
    bodies = ("lower", "upper")
    for body, (points, values) in zip(bodies, actual.regions, strict=True):
        x = float(dataset.sel(body=body, source=ACTUAL).x_von_mises)
        stress = dataset[f"stress_{body}"].sel(source=ACTUAL).sel({f"x_{body}": x}, method="nearest")
        mises = von_mises(stress.values.astype(float))
        np.testing.assert_allclose(values[::4, ::4], mises, rtol=1e-9)
        assert values.max() == pytest.approx(mises.max())
        assert values.min() == pytest.approx(mises.min())
        outline, inward = (
            dataset[f"{name}_{body}"].sel({f"outline_s_{body}": dataset[f"s_{body}"].values})
            for name in ("outline", "inward")
        )
        expected = outline.values[..., None] + inward.values[..., None] * dataset[f"depth_{body}"].values
        np.testing.assert_allclose(points[:, ::4, ::4], expected, atol=1e-12)
    assert actual.levels[0] <= 0 < max(values.max() for _, values in actual.regions) <= actual.levels[-1]
    assert difference.levels[0] == -difference.levels[-1]
    for (_, less), (_, value), (_, away) in zip(
        *(one.regions for one in (actual, half, difference)), strict=True
    ):
        np.testing.assert_allclose(away[::4, ::4], (value - less)[::4, ::4], atol=1e-9)


def test_bars_are_the_estimates_of_the_largest_depths(dataset):
    panel = wear_chart(dataset).cells[0]
    bars = {curve.label: curve for curve in panel.curves if curve.bars}
    assert len(bars) == dataset.sizes["ics"]
    numbers = dataset.sel(ics="Bhat")
    assert bars["B̂"].band == [float(numbers.estimate_largest_depth_energy)]
    assert bars["B̂"].y == pytest.approx([float(numbers.largest_depth_energy)])


def test_ratios_to_nothing_are_none(dataset):
    changed = {name: 0 * dataset[name] for name in ("t_gamma", "work", "largest_depth_energy")}
    nothing = dataset.assign(changed | {"difference_dang_van": np.nan * dataset.difference_dang_van})
    tables = damage_table(nothing), stress_table(nothing), answer_table(nothing)
    shown = [cell.below + cell.text for table in tables for row in table.rows for cell in row.filled]
    assert not any("nan" in text or "inf" in text for text in shown)


@pytest.mark.parametrize("body", ["lower", "upper"])
def test_half_spaces_differ_by_the_share_of_the_dataset(dataset, body):
    """Only its size has a limit where the estimate of the actual body is larger."""
    share = 100 * float(dataset.difference_von_mises.sel(body=body, source=HALF_SPACE_OF_A))
    of_actual = 100 / float(dataset.von_mises.sel(body=body, source=ACTUAL))
    for estimate, resolved in ((0.4 * abs(share), True), (3 * abs(share), False)):
        known = dataset.assign(estimate_von_mises=xr.zeros_like(dataset.von_mises) + estimate / of_actual)
        (cells,) = (cells for name, cells in answers(known).items() if name.startswith(f"Does the {body}"))
        assert cells[2].text.startswith("within ± ") != resolved
        assert cells[2].text.lstrip("+") == f"{with_estimate(share, estimate)} %"


def test_without_rolling_there_are_only_stresses(dataset, tmp_path):
    still = dataset.drop_dims(["ics"])
    page = write_stresses(still, tmp_path).read_text(encoding="utf-8")
    assert "wears" not in summary(still)
    assert "wear depth" not in page
    assert len(answers(still)) == 4  # yield and Dang Van's limit of both bodies


def test_wear_after_all_passages_has_the_errors_of_steps_and_of_a_passage(dataset):
    depth = 2e-3 * dataset.depth.sel(law="energy", drop=True).expand_dims(worn_body=["lower", "upper"])
    estimate = xr.DataArray(np.full((2, 2), 0.1), dims=("worn_body", "ics"))
    changed = {"worn": depth, "estimate_worn": estimate, "wear_steps": 4, "turned": 0 * dataset.p_max + 3.0}
    worn = dataset.assign(changed).assign_attrs(passages=0.0, revolutions=1000.0)
    (cells,) = (cells for name, cells in answers(worn).items() if "after" in name)
    largest, numbers = float(depth.sel(ics="Bhat").max()), dataset.sel(ics="Bhat")
    share = float(numbers.estimate_largest_depth_energy / numbers.largest_depth_energy)
    assert cells[0].text == f"{with_estimate(largest, 0.1 + share * largest)} µm"
    assert len(doubts(worn)) == len(doubts(dataset)) + 1  # surfaces turn by 3 degrees
