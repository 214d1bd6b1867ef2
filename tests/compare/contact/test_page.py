"""What `femic contact` writes: numbers, sentences and pictures of a contact, and maps of two scenes."""

from itertools import product

import numpy as np
import pytest
import xarray as xr

from compare.pages import contact_figures as figures
from compare.pages.contact import doubts, mapped_contact, sensitivity_page, write_contact, write_sensitivity
from compare.pages.contact_numbers import (
    NO_BREAK,
    answer_sentence,
    answer_table,
    case_labels,
    deciding_text,
    differences,
    numbers_table,
    verdict_sentences,
)
from compare.report.tables import with_estimate
from compare.report.verdicts import verdict
from femic.contact.motions.none import map_pressures, sensitivities
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.results.contact import pressures, solve_scene, to_dataset
from femic.scenes.load import load_scene
from tests.compare.pages import read_chart, read_number, read_traces, require_room
from tests.femic.contact.wheel_on_rail import scene


def loaded_scene(name, loads):
    return load_scene(name, {"contact": {"ics": ["A", "Bhat"], "elements": 12, "loads": loads}})


TALL = loaded_scene("tall", [58e3, 310e3])


@pytest.fixture(scope="module")
def results():
    """Both built-in pairs by A and B-hat, at two loads each."""
    return {"wide": solve_scene(loaded_scene("wide", [660e3, 5300e3])), "tall": solve_scene(TALL)}


@pytest.fixture(scope="module")
def dataset(results):
    return to_dataset(TALL, results["tall"])


def test_the_file_has_pressures_that_carry_the_loads(results, dataset, tmp_path):
    assert write_contact(TALL, dataset, tmp_path).stat().st_size > 1e5
    written, solved = xr.open_dataset(tmp_path / "contact.nc"), results["tall"]
    for number, load in enumerate([58e3, 310e3]):
        case = written.sel(case=load)
        area = float(np.diff(case.x)[0] * np.diff(case.s)[0])
        carried = (case.p * np.cos(case.inclination)).sum(["x", "s"]) * area
        assert carried.values == pytest.approx([load, load])
        np.testing.assert_array_equal(case.p_max, case.p.max(["x", "s"]))
        assert np.nanmax(case.p * case.gap) == 0
        grid = next(c for (of, _), c in solved.contacts.items() if of.load == load).on_grid
        beyond = case.p.isnull().all("ics")
        assert (beyond == (case.x.isnull() | case.s.isnull())).all()
        assert (~beyond).sum() == grid.grid.n_x * grid.grid.n_s
        own = pressures(written, number)
        np.testing.assert_array_equal(own.x, grid.x)
        np.testing.assert_array_equal(own.s, grid.grid.strips)
    assert written.p.dims == ("case", "ics", "x", "s")
    # by the rule 1.3 p_max / E of it
    np.testing.assert_allclose(written.finite_strain_p_max, 1.3 * written.p_max**2 / 210e3)


def test_summary_states_pressure_and_patch(dataset):
    largest = dataset.isel(case=1).sel(ics="Bhat")
    text = answer_sentence(dataset, "Bhat", ["A"])
    assert text.startswith("With A, p_max differs from B̂ by more than 2 % at one load or more (+")
    known = with_estimate(largest.p_max, largest.estimate_p_max)
    assert f"At 310 kN, the largest pressure p_max is {known} MPa with B̂" in text
    assert f"2a × 2b = {2 * float(largest.a):.3g} × {2 * float(largest.b):.3g} mm" in text


@pytest.mark.parametrize(("tolerance", "second"), [(0.05, "no"), (0.3, "not decided"), (0.31, "yes")])
def test_verdicts_depend_on_the_case_and_on_the_tolerance_of_the_scene(dataset, tolerance, second):
    """Differences of 0 % and 30 %, known to the sum of two estimates, 0.1 % and 0.13 % of the reference."""
    alone = dataset.drop_vars(["larger_p_max", "change_p_max", "floor_p_max"])
    moved = alone.assign(p_max=dataset.p_max.copy(data=[[1.0, 1.0], [1.3, 1.0]]))
    moved["estimate_p_max"] = 0.001 * moved.p_max
    rows = answer_table(moved.assign_attrs(ics_tolerance=tolerance), "Bhat", ["A"]).rows
    assert [row.filled[-1].text for row in rows] == ["yes", second]
    assert [row.filled[-1].below for row in rows] == ["within ± 0.20 %", "+30.00 ± 0.23 %"]


@pytest.mark.parametrize(
    ("differences", "estimates", "said"),
    [
        ([1.5, -1.0], [0.1, 0.1], "yes"),
        ([1.5, -7.0], [0.1, 0.1], "no"),
        ([1.9, -1.0], [0.4, 0.1], "not decided"),
        ([-2.1, 1.0], [0.4, 0.1], "not decided"),
        ([-2.1, 9.0], [0.4, 0.1], "no"),
        ([0.0, 1.0], [np.nan, 0.1], "not decided"),  # not known
        ([np.nan, 1.0], [0.1, 0.1], "not decided"),
        ([np.nan, 9.0], [np.nan, 0.1], "no"),
        ([np.nan, np.nan], [0.1, 0.1], ""),
    ],
)
def test_a_verdict_is_yes_or_no_only_where_estimates_allow_it(differences, estimates, said):
    off, known = (xr.DataArray(values, dims="case") for values in (differences, estimates))
    assert verdict(abs(off), known, 2.0) == said


def test_the_difference_shown_is_one_that_the_verdict_follows_from():
    """The largest one need not be: 3 +- 2 leaves open what 2.5 +- 0.1 decides."""
    off, known = (xr.DataArray(values, dims="case") for values in ([3.0, -2.5, 0.5], [2.0, 0.1, 0.1]))
    assert deciding_text(off, known, 2.0) == "−2.50 ± 0.10 %"
    assert deciding_text(off, known, 2.45) == "+3 ± 2 %"
    assert deciding_text(off[2:], known[2:], 2.0, signed=False) == "0.50 ± 0.10 %"
    assert deciding_text(off, known.where(known < 1), 2.45) == "+3.0 ± ? %"
    places = {"case": ["1 N", "2 N", "3 N"]}
    assert deciding_text(off, known, 2.0, places=places) == "−2.50 ± 0.10 % at 2 N"
    assert deciding_text(off[:1], known[:1], 2.0, places={"case": ["1 N"]}) == "+3 ± 2 %"


def test_sentences_of_verdicts_name_each_of_the_ics_once():
    words = {"A": "no", "B": "yes", "B̂": "yes", "mix": "not decided", "B̄": "no"}
    text = verdict_sentences(
        words, dict.fromkeys(words, "+3 ± 1 %"), "p_max differs from C", "2 %", ("x", "y")
    )
    sentences = text.split(". ")
    assert [sentence.split(",")[0] for sentence in sentences] == ["With B and B̂", "With A and B̄", "With mix"]
    assert sentences[0] == "With B and B̂, p_max differs from C by at most 2 % x"
    assert sentences[1].endswith("more than 2 % y (A +3 ± 1 % and B̄ +3 ± 1 %)")
    assert sentences[2].endswith("(+3 ± 1 %).")


def test_differences_on_smaller_elements_are_within_their_estimates():
    """On the same elements much of both errors is common: the estimate is less than the sum of both."""
    coarse, fine = (
        to_dataset(of, solve_scene(of))
        for of in (
            load_scene("tall", {"contact": {"ics": ["A", "Bhat"], "elements": n, "loads": [150e3]}})
            for n in (10, 40)
        )
    )
    for key in ("p_max", "a", "approach"):
        (off, known), (better, _) = (differences(each, key, "Bhat") for each in (coarse, fine))
        assert abs(float(better.sel(ics="A")[0] - off.sel(ics="A")[0])) < float(known.sel(ics="A")[0])
        assert float(known.sel(ics="Bhat")[0]) == 0.0
    both = (coarse.estimate_p_max.sum("ics") / coarse.p_max.sel(ics="Bhat")).item()
    assert float(differences(coarse, "p_max", "Bhat")[1].sel(ics="A")[0]) < 50 * both


def test_doubts_are_what_changes_p_max_by_more_than_the_tolerance(dataset):
    def said(**changes):
        return " ".join(doubts(dataset.assign(changes).assign_attrs(ics_tolerance=0.1)))

    p_max, small = dataset.p_max, dataset.p_max.where(dataset.case < 1e5, 0.0)
    same = {"displaced_p_max": p_max, "finite_strain_p_max": 0.01 * p_max}
    assert said(**same) == (
        "C was not computed. Differences are those from B̂, which is itself an approximation. Add C to "
        "contact.ics to see how far each of the ICs is from C."
    )
    assert "p_max would change by −20 % at 58 kN." in said(**same | {"displaced_p_max": p_max - 0.2 * small})
    assert "may change p_max by up to 30 % at 58 kN." in said(**same | {"finite_strain_p_max": 0.3 * small})
    unknown = dataset.estimate_p_max.where(dataset.case < 1e5)
    text = said(**same, estimate_p_max=unknown)
    assert "Estimated errors are unknown (± ?) at 310 kN:" in text
    (alone, *_) = doubts(dataset.sel(ics=["A"]))
    assert alone.startswith("Only A was computed.")


def test_the_answer_has_a_row_per_load_with_differences_beside_it_or_one_for_each_of_the_ics(dataset):
    table = answer_table(dataset, "Bhat", ["A"])
    assert [row.name.replace(NO_BREAK, " ") for row in table.rows] == ["58 kN", "310 kN"]
    for number, row in enumerate(table.rows):
        case = dataset.isel(case=number).sel(ics="Bhat")
        angle, p_max, judged = row.filled
        assert float(angle.text) == pytest.approx(float(case.angle), abs=0.51)
        assert p_max.text == with_estimate(case.p_max, case.estimate_p_max)
        assert judged.text == "no"
        off = float(dataset.p_max.sel(ics="A")[number] / case.p_max) - 1
        value, estimate = read_number(judged.below)
        assert value == pytest.approx(100 * off, abs=estimate / 10)
    single = answer_table(dataset.isel(case=[1]), "Bhat", ["A"])
    assert [row.name for row in single.rows] == ["p_max [MPa]", "a [mm]", "b [mm]", "approach [mm]"]
    for row, key in zip(single.rows, ("p_max", "a", "b", "approach"), strict=True):
        case = dataset.isel(case=1).sel(ics="Bhat")
        assert row.filled[0].text == with_estimate(case[key], case[f"estimate_{key}"])


def test_all_numbers_are_in_a_table_with_a_row_per_quantity(dataset):
    case = dataset.isel(case=1)
    solutions = {"B̂": case.sel(ics="Bhat"), "A": case.sel(ics="A")}
    table = numbers_table("t", OF_FRICTIONLESS, solutions, solutions["B̂"])
    rows = {row.name: row.filled for row in table.rows}
    assert len(rows) == len(OF_FRICTIONLESS)
    p_max = rows["p_max [MPa]"][1]
    assert p_max.text == with_estimate(solutions["A"].p_max, solutions["A"].estimate_p_max)
    assert p_max.below == f"{float(solutions['A'].p_max / solutions['B̂'].p_max) - 1:+.2%}"
    for side in rows["F_y [N]"]:  # rounding: not resolved, and no share of it
        assert (side.text.split(" ± ")[0], side.below) == ("within", "")


def test_charts_have_pressures_in_mpa_and_numbers_of_the_dataset(dataset):
    content = read_chart(figures.answer_chart(dataset))
    assert (content["labels"], content["slider"], content["start"]) == (["58 kN", "310 kN"], "load", 1)
    assert figures.answer_chart(dataset.isel(case=[1, 0])).first == 0  # the largest load
    angle = dataset.angle.sel(ics="Bhat").values
    for step in (0, 1):
        p = pressures(dataset, step)
        middle = p.isel(x=p.sizes["x"] // 2).set_xindex("s")
        drawn = [read_traces(cell) for cell in content["steps"][step]]
        for name, symbol in (("A", "A"), ("Bhat", "B̂")):
            s, values = (np.array(drawn[0][symbol][axis], dtype=float) for axis in "xy")
            expected = middle.sel(ics=name).interp(s=s).values
            np.testing.assert_allclose(values, expected, atol=1e-4 * float(middle.max()))
            assert values.max() == pytest.approx(float(middle.sel(ics=name).max()), rel=1e-5)
            np.testing.assert_allclose(drawn[3][symbol]["y"], values - drawn[0]["B̂"]["y"], atol=0.02)
            np.testing.assert_allclose(drawn[1][symbol]["x"], angle, rtol=1e-5)
            np.testing.assert_allclose(drawn[1][symbol]["y"], dataset.p_max.sel(ics=name), rtol=1e-5)
            ratio = dataset.b.sel(ics=name) / dataset.b.sel(ics="Bhat")
            np.testing.assert_allclose(drawn[5][symbol]["y"], 100 * (ratio - 1), rtol=1e-5)
        known = differences(dataset, "b", "Bhat")[1].sel(ics="A")
        np.testing.assert_allclose(drawn[5]["A"]["error_y"]["array"], known, rtol=1e-5)
        assert [line["y0"] for line in content["steps"][step][5]["layout"]["shapes"]] == [-2.0, 2.0]


def test_pressures_on_the_rail_lie_on_it_and_rise_with_the_pressure(dataset):
    lower = TALL.bodies["lower"].surface
    for step, (cell,) in enumerate(figures.on_rail(dataset, lower).steps.values()):
        p = dataset.p.isel(case=step).sel(ics="Bhat")
        assert np.nanmax(cell.values) == float(p.max())
        assert np.isfinite(cell.values).sum() == int((p > 0).sum())
        body, part = (points.reshape(3, -1).T for points in (cell.body, cell.part))
        top = np.unravel_index(np.nanargmax(cell.values), cell.values.shape)
        height = cell.part[2][top] - body[:, 2].max()
        assert 0 < height < np.ptp(part[:, 0])


def test_edges_go_around_the_patch_between_elements_inside_and_outside():
    x, s = np.arange(6.0), 10 + 0.5 * np.arange(5.0)
    inside = np.zeros((6, 5), dtype=bool)
    inside[1:4, 1:3] = True
    along_x, along_s = figures.edge(x, s, inside)
    assert (along_x.min(), along_x.max()) == (0.5, 3.5)
    assert (along_s.min(), along_s.max()) == (10.25, 11.25)
    inside[5, 4] = False
    inside[4, 3] = True  # touches by a corner
    assert len(figures.edge(x, s, inside)[0]) > len(along_x)
    assert np.isnan(figures.edge(x, s, np.zeros_like(inside))).all()  # about nothing


def test_patches_have_maps_of_the_reference_and_of_differences_with_common_colours(dataset):
    charts = (
        chart.steps.values() for chart in (figures.patches(dataset), figures.pressure_differences(dataset))
    )
    for p, (reference,), (difference,) in zip(dataset.p, *charts, strict=True):
        assert np.nanmax(reference.values) == float(p.sel(ics="Bhat").max())
        assert {curve.label for curve in reference.curves} == {"A", "B̂"}
        largest = float(abs(p.sel(ics="A") - p.sel(ics="Bhat")).max())
        assert difference.range == pytest.approx((-largest, largest))


@pytest.mark.slow
def test_nothing_is_wider_than_the_window(results, dataset, browser, tmp_path):
    require_room(browser, write_contact(TALL, dataset, tmp_path))
    require_room(browser, write_sensitivity(results, tmp_path / "maps"))


def test_maps_show_displacements_with_a_minus_displacements_with_bhat_in_percent(results, tmp_path):
    """Of every pair of scenes; A turns no load away from the normals, so it moves them further.

    The worst are those of `wide`, which are spread, as [BVSV] says.
    """
    shapes = {name: mapped_contact(contacts) for name, contacts in results.items()}
    wide, tall = shapes["wide"], shapes["tall"]
    assert wide.loading.load == 5300e3  # as the scene says, and not the largest
    np.testing.assert_allclose(map_pressures(wide, wide), wide.normal.p, atol=1e-9 * wide.normal.p.max())
    maps = list(sensitivities(shapes))
    assert [(one.pressures, one.patch) for one in maps] == [*product(("wide", "tall"), repeat=2)]
    assert all(0 < np.min(one.inside) < np.max(one.inside) < 0.4 for one in maps)
    u_a, u_bhat = (tall.on_grid.operator(ics)(tall.normal.p[..., None])[..., 0] for ics in ("A", "Bhat"))
    np.testing.assert_allclose(maps[3].difference, (u_a - u_bhat) / u_bhat.max(), atol=1e-9)
    assert write_sensitivity(results, tmp_path).stat().st_size > 1e4
    page, worst = sensitivity_page(results), max(maps, key=lambda one: np.max(np.abs(one.inside)))
    assert worst.pressures == "wide"
    largest = f"{np.max(np.abs(worst.inside)):.1%}"
    assert f"differ from B̂ by up to {largest} of the largest displacement" in page.summary
    chart, _ = page.sections[0].blocks
    assert chart.columns == 2
    assert [row.name for row in page.answer.rows] == ["wide", "tall"]
    cells = [cell for row in page.answer.rows for cell in row.filled]
    for one, drawn, cell in zip(maps, chart.cells, cells, strict=True):
        np.testing.assert_allclose(drawn.values[np.isfinite(drawn.values)], 100 * one.inside)
        low, high = map(float, cell.text.split(" ... "))
        assert (low, high) == pytest.approx((100 * one.inside.min(), 100 * one.inside.max()), abs=0.051)
        assert drawn.range == chart.cells[0].range


SLOW = pytest.mark.slow
STRANGE = {  # extra gaps at (x, s): what becomes of the contact
    "two patches along x": lambda x, s: 0.05 * np.maximum(0, 1 - np.abs(x) / 2) + 0 * s,
    "two patches along s": lambda x, s: 0.05 * np.maximum(0, 1 - np.abs(s) / 2) + 0 * x,
    "a spot that is raised": lambda x, s: -0.05 * np.exp(-4 * ((x - 1) ** 2 + s**2)),
    "a row of elements beside a step": lambda x, s: np.where(np.abs(x) < 4.9, 1e3, 0.0) + 0 * s,
}


@pytest.mark.parametrize("name", [pytest.param(k, marks=SLOW if "two" in k else ()) for k in STRANGE])
def test_contacts_of_any_shape_have_a_page_and_lengths_above_0(name, tmp_path):
    """Nothing may touch at x = 0, approaches may be negative, and patches as narrow as an element."""
    x, s = (values.ravel() for values in np.meshgrid(*[np.linspace(-5, 5, 11)] * 2, indexing="ij"))
    gap = tmp_path / "gap.txt"
    np.savetxt(gap, np.column_stack([x, s, STRANGE[name](x, s)]))
    given = scene(10.2, 300.0, loads=[3e3], elements=12, extra_gap=str(gap))
    solved = solve_scene(given)
    dataset = to_dataset(given, solved)
    assert write_contact(given, dataset, tmp_path).stat().st_size > 1e5
    for length in ("a", "b", "aspect", "area"):
        assert np.all(dataset[length] > 0), length
    patches = [len(contact.normal.patches) for contact in solved.contacts.values()]
    assert patches == ([1, 1] if name == "a spot that is raised" else [2, 2])


def test_a_number_of_the_reference_that_is_0_has_differences_in_its_unit(dataset):
    """As the approach over a raised spot may be."""
    at_0 = dataset.assign(approach=dataset.approach.where(dataset.ics != "Bhat", 0.0))
    case = at_0.isel(case=0)
    solutions = {name: case.sel(ics=name) for name in ("Bhat", "A")}
    (row,) = numbers_table("t", {"approach": OF_FRICTIONLESS["approach"]}, solutions, solutions["Bhat"]).rows
    assert row.filled[1].below == f"{float(at_0.approach.sel(ics='A')[0]):+.3g}"
    judged = answer_table(at_0.isel(case=[0]), "Bhat", ["A"]).rows[3].filled[1]
    assert (judged.text, judged.below) == ("–", "–")  # there is no share of 0
    _, below = figures.over_angle(at_0, ["approach"], "Bhat")
    assert all(np.isnan(curve.y).all() for curve in below[0].curves)


@pytest.mark.parametrize(
    ("cases", "unit", "labels"),
    [
        ([2000.0, 2000.0001, 5.3e6], "N", ["2 kN", "2.0000001 kN", "5300 kN"]),
        ([2.0, 30.5], "N", ["2 N", "30.5 N"]),
        ([0.1, -0.02], "mm", ["0.1 mm", "-0.02 mm"]),
    ],
)
def test_loads_of_kilonewtons_are_in_kn_and_stay_distinct(cases, unit, labels):
    assert case_labels(xr.Dataset(coords={"case": ("case", cases, {"units": unit})})) == labels
