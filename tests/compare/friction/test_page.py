"""What `femic contact` writes of rolling and compression: file, verdict, answer, charts, tables."""

import re

import numpy as np
import pytest
import xarray as xr

from compare.pages import compression as compression_page
from compare.pages import rolling as rolling_page
from compare.pages.friction import (
    abscissa,
    chart_notes,
    difference,
    difference_estimate,
    missing,
    number_tables,
    numbers_chart,
    outlines,
    quantity_label,
    support_tables,
    vanishes,
    work_maps,
    worst_friction,
)
from compare.pages.friction_pages import PAGES
from compare.report.looks import ics_symbol
from compare.report.tables import number_text
from femic.contact.motions import MOTIONS
from femic.results.friction import compute_with_friction
from tests.compare.pages import read_chart, read_number, read_texts, require_number, require_room
from tests.femic.contact.wheel_on_rail import scene


@pytest.fixture(scope="module")
def rolled():
    keys = {"motion": "rolling", "loads": [1e4], "longitudinal": [-4e-3, 0.0, 4e-3]}
    return compute_with_friction(scene(10.3, friction=[0.3, 0.5], **keys))


@pytest.fixture(scope="module")
def pressed():
    return compute_with_friction(scene(10.3, friction=[0.2, 0.5], motion="compression", loads=[5e3, 1e4]))


def drawn(cell):
    """The ordinates of the curves of a cell by their labels; the last ones of each label."""
    return {trace["name"]: trace["y"] for trace in cell["traces"] if trace.get("name")}


def test_page_and_file_of_rolling_agree(rolled, tmp_path):
    page = rolling_page.ROLLING.write(rolled, tmp_path).read_text(encoding="utf-8")
    written = xr.open_dataset(tmp_path / "contact.nc")
    drawn = "creep_force", "centre_line", "stick", "work", "numbers"
    assert set(re.findall(r'id="chart-([^"]+)"', page)) == set(drawn)
    assert rolling_page.parts(written).summary in page.replace("&#39;", "'")
    for name in ("A", "Bhat"):
        text = number_text(100 * written.zero_creepage.sel(ics=name, friction=0.5), ".3f")
        assert f"<td>{text}" in page
    assert np.all(written.F_x.diff("xi") > 0)


@pytest.mark.parametrize(
    ("off", "known", "said", "sentence"),
    [
        (1.5, 0.1, "yes", "With A, F_x differs from B̂ by at most 2 % of friction × load at every creepage."),
        (7.0, 0.1, "no", "With A, F_x differs from B̂ by more than 2 % of friction × load at one creepage or"),
        (1.9, 0.4, "not decided", "With A, it is not decided whether F_x differs from B̂ by at most 2 % of"),
        (2.1, 0.4, "not decided", "With A, it is not decided whether F_x differs from B̂ by at most 2 % of"),
        (
            1.0,
            np.nan,
            "not decided",
            "With A, it is not decided whether F_x differs from B̂ by at most 2 % of",
        ),
    ],
)
def test_verdict_follows_from_the_largest_difference_and_its_estimate(rolled, off, known, said, sentence):
    """Though all are within 2 % by root mean square."""
    largest = rolled.largest.copy(data=0.01 * np.array([[off / 2, 0.0], [off, 0.0]]))
    estimate = rolled.estimate_largest.copy(data=np.full((2, 2), 0.01 * known))
    moved = rolled.assign(largest=largest, estimate_largest=estimate, rms=0.01 * rolled.rms)
    rows = {row.name: row.filled[0] for row in rolling_page.answer(moved).rows}
    assert (rows["A"].text, rows["B̂"].text) == (said, "reference")
    summary = rolling_page.parts(moved).summary
    assert summary.startswith(sentence)
    assert "Load: 10 kN; friction: 0.3 and 0.5; creepages: −0.4 to 0.4 %" in summary
    looser = moved.assign_attrs(ics_tolerance=0.1)
    assert rolling_page.answer(looser).rows[1].filled[0].text == ("not decided" if np.isnan(known) else "yes")


def test_ics_with_an_exchanged_component_are_named_and_one_alone_is_compared_to_nothing(rolled):
    named = rolled.assign_coords(ics=["Bhat+sn:B", "Bhat"])
    assert "B̂ (sn B)" in rolling_page.creep_force(named).legend
    assert {row.name for row in rolling_page.answer(named).rows} == {"B̂ (sn B)", "B̂"}
    alone = rolled.sel(ics=["A"])
    assert [len(cells) for cells in rolling_page.creep_force(alone).steps.values()] == [1, 1]
    assert [row.name for row in rolling_page.answer(alone).rows] == ["A"]


def test_the_answer_of_rolling_has_the_numbers_of_the_arrays(rolled):
    friction, table = worst_friction(rolled), rolling_page.answer(rolled)
    rows = read_texts(table)
    at = rolled.sel(friction=friction)
    for name in ("A", "Bhat"):
        curve, cells = at.sel(ics=name), rows[ics_symbol(name)]
        for text, key, factor in ((cells[1], "zero_creepage", 100), (cells[2], "slope", 1e-5)):
            require_number(text, factor * curve[key], factor * curve[f"estimate_{key}"])
    judged, _, slope = table.rows[1].filled
    largest, known = read_number(judged.below)
    assert largest in [
        pytest.approx(100 * float(each), abs=known / 10) for each in rolled.largest.sel(ics="A")
    ]
    off = at.slope.sel(ics="A") / at.slope.sel(ics="Bhat") - 1
    shown = float(slope.below.removesuffix(" %").replace("−", "-"))
    assert shown == pytest.approx(100 * float(off), abs=0.051)
    assert all(cell.below == "" for cell in table.rows[0].filled)
    assert f"friction {friction:g} [%]" in table.heads[1].title


def test_ics_differ_most_at_the_friction_shown_first(rolled):
    worst = float(rolled.friction[int(rolled.largest.sel(ics="A").argmax("friction"))])
    assert worst_friction(rolled) == worst_friction(rolled.isel(friction=slice(None, None, -1))) == worst
    judged = rolling_page.answer(rolled).rows[1].filled[0].below
    assert judged.endswith(f" at friction {worst:g}")
    assert judged in rolling_page.parts(rolled).summary
    assert " at friction " not in rolling_page.answer(rolled.isel(friction=[0])).rows[1].filled[0].below
    for chart in (rolling_page.creep_force(rolled), rolling_page.centre_line(rolled), numbers_chart(rolled)):
        content = read_chart(chart)
        assert content["labels"][content["start"]] == f"μ\u00a0=\u00a0{worst:g}"
        assert chart.slider == "friction"


def test_creep_force_curves_are_drawn_in_newtons_over_percent_beside_their_differences(rolled):
    steps = read_chart(rolling_page.creep_force(rolled))["steps"]
    assert len(steps) == 2
    for (force, away), friction in zip(steps, rolled.friction.values, strict=True):
        of_friction = rolled.sel(friction=friction)
        for name in ("A", "Bhat"):
            values = of_friction.F_x.sel(ics=name)
            np.testing.assert_allclose(drawn(force)[ics_symbol(name)], 1e-3 * values, rtol=1e-5)
            expected = 100 * (values - of_friction.F_x.sel(ics="Bhat")) / (friction * 1e4)
            np.testing.assert_allclose(drawn(away)[ics_symbol(name)], expected, rtol=1e-5)
        np.testing.assert_allclose(force["traces"][-1]["x"], [-0.4, 0.0, 0.4])
        assert force["layout"]["yaxis"]["title"]["text"] == "F_x [kN]"
        (bars,) = (trace["error_y"]["array"] for trace in away["traces"] if "error_y" in trace)
        np.testing.assert_allclose(bars, difference_estimate(of_friction).sel(ics="A"), rtol=1e-5)
        assert [line["y0"] for line in away["layout"]["shapes"]] == [-2.0, 2.0]


def test_tractions_along_the_centre_line_are_those_of_the_maps(rolled):
    """And within friction times pressure, less by a factor of its strip."""
    (pressure, traction, away), _ = read_chart(rolling_page.centre_line(rolled))["steps"]
    strip = int(rolled.p.sel(direction="n", ics="Bhat").max(["friction", "x"]).argmax("s"))
    assert f"s = {float(rolled.s[strip]):.3g} mm" in pressure["title"]
    along = rolled.p.isel(friction=0, s=strip)
    p, p_x = (along.sel(direction=name) for name in ("n", "x"))
    inside = np.isin(np.round(rolled.x.values, 5), np.round(pressure["traces"][0]["x"], 5))
    near = {"rtol": 1e-5, "atol": 1e-9}
    np.testing.assert_allclose(drawn(pressure)["A"], p.sel(ics="A")[inside], **near)
    np.testing.assert_allclose(drawn(traction)["A"], p_x.sel(ics="A")[inside], **near)
    expected = (p_x.sel(ics="A") - p_x.sel(ics="Bhat"))[inside]
    np.testing.assert_allclose(drawn(away)["A"], expected, rtol=1e-4, atol=1e-3)
    bound = -0.3 * p.sel(ics="Bhat")[inside]
    np.testing.assert_allclose(drawn(traction)["friction × pressure"], bound, **near)
    assert float(p[:, ~inside].max()) == 0.0
    quarter = read_chart(rolling_page.centre_line(rolled.assign(friction_factor=rolled.friction_factor / 4)))
    np.testing.assert_allclose(drawn(quarter["steps"][0][1])["friction × pressure"], bound / 4, **near)


@pytest.mark.parametrize("of", ["rolled", "pressed"])
def test_maps_show_the_work_with_all_ics_in_the_same_colours(of, request):
    at = request.getfixturevalue(of).isel(friction=1)
    p, cells = at.p.sel(direction="n"), work_maps(at)
    assert [cell.title for cell in cells] == ["A", "B̂"]
    assert len({cell.range for cell in cells}) == 1
    for cell, ics in zip(cells, ("A", "Bhat"), strict=True):
        whole = at.work.where(p > 0).sel(ics=ics)
        np.testing.assert_array_equal(cell.values, whole.sel(x=cell.x, s=cell.y))
        assert np.isfinite(cell.values).sum() == int((p.sel(ics=ics) > 0).sum())


@pytest.mark.parametrize("of", ["rolled", "pressed"])
def test_lines_go_around_the_patch_and_around_what_sticks_in_it(of, request):
    at = request.getfixturevalue(of).isel(friction=1)
    p, dx, cell = at.p.sel(direction="n"), at.attrs["dx"], outlines(at)
    assert np.nanmax(cell.values) == float(p.sel(ics="Bhat").max())
    lines = [(curve.label, *curve.points) for curve in cell.curves]
    assert [label for label, *_ in lines] == ["B̂", "B̂", "A", "A"] or [label for label, *_ in lines] == [
        "A",
        "A",
        "B̂",
        "B̂",
    ]
    for label, ics in (("A", "A"), ("B̂", "Bhat")):
        own = p.sel(ics=ics) > 0
        inside = own, own & at.stick.sel(ics=ics).astype(bool)
        for (_, x, _), part in zip((line for line in lines if line[0] == label), inside, strict=True):
            reached = at.x.values[part.any("s").values]
            if not reached.size:
                assert np.isnan(x).all()
                continue
            assert np.nanmax(x) == pytest.approx(reached.max() + dx / 2)
            assert np.nanmin(x) == pytest.approx(reached.min() - dx / 2)
    slides = outlines(at.assign(stick=xr.zeros_like(at.stick))).curves
    assert sum(np.isnan(curve.points[0]).all() for curve in slides) == 2  # nothing sticks


def test_all_numbers_are_drawn_and_listed_but_those_that_vanish(rolled):
    names = "F_x", "p_max", "area", "sliding_share", "F_y", "M_x", "M_z"
    assert [vanishes(rolled, name) for name in names] == 4 * [False] + 3 * [True]
    steps = read_chart(numbers_chart(rolled))["steps"]
    by_title = {cell["title"]: drawn(cell)["A"] for cell in steps[1]}
    with_a = rolled.sel(friction=0.5, ics="A")
    np.testing.assert_allclose(by_title["largest pressure"], with_a.p_max, rtol=1e-5)
    shares = by_title[quantity_label(rolled, "sliding_share").meaning]
    np.testing.assert_allclose(shares, 100 * with_a.sliding_share, rtol=1e-5)
    *folded, symmetric = number_tables(rolled)
    assert len(folded) == len(steps[0]) == 9
    assert symmetric.startswith("Zero by symmetry: F_y (estimated error at most ")
    table = folded[0].blocks[1]
    assert table.caption == "friction 0.5: F_x [kN]"
    assert [row.name for row in table.rows] == ["−0.4 %", "0 %", "0.4 %"]
    cell, contact = table.rows[2].cells[0], with_a.sel(xi=4e-3)
    require_number(f"{cell.text} {cell.below}", 1e-3 * contact.F_x, 1e-3 * contact.estimate_F_x)
    turned = rolled.assign(M_z=rolled.M_z + 5.0)  # no rounding
    assert not vanishes(turned, "M_z")
    assert len(numbers_chart(turned).cells) == 2 * 10


def test_doubts_say_which_contacts_are_less_accurate_or_missing(rolled):
    simplified = xr.zeros_like(rolled.simplified)
    assert not [text for text in rolling_page.doubts(rolled) if "less accurate" in text]
    simplified[0, 0] = [True, False, True]
    (text,) = (
        text for text in rolling_page.doubts(rolled.assign(simplified=simplified)) if "less accurate" in text
    )
    assert text.endswith("at the leading edge: 2 of 6. They are less accurate.")
    assert [*missing(rolled)] == []
    lost = rolled.assign(F_x=rolled.F_x.where((rolled.xi < 0) | (rolled.ics != "A")))
    assert [*missing(lost)] == ["With A, no contact was found at 4 of 6 points."]
    (alone,) = missing(rolled.sel(ics=["A"]))
    assert alone.startswith("Only A was computed.")


def test_remarks_say_what_the_displaced_wheel_does_if_known(rolled):
    def remarks(**changes):
        return " ".join(rolling_page.remarks(rolled.assign(changes)))

    zero, p_max = rolled.zero_creepage, rolled.p_max.sel(xi=0.0)
    text = remarks(displaced_zero_creepage=zero - 3e-5, displaced_p_max=0.97 * p_max)
    assert "two numbers: the creepage at F_x = 0 (within ± 0.01" in text  # one of them differs by 0.003 %
    assert text.endswith("%) and p_max (−3.0 %).")
    assert "With B̂, the exact distance of the displaced wheel" in text
    assert "displaced wheel" not in remarks(displaced_zero_creepage=np.nan * zero)


def test_forces_beyond_friction_times_load_are_explained_where_there_are_any(rolled):
    def said(dataset):
        return rolling_page.PRESSED in list(rolling_page.doubts(dataset))

    limit = rolled.friction * 1e4
    assert said(rolled.assign(F_x=1.01 * limit.broadcast_like(rolled.F_x)))
    assert not said(rolled.assign(F_x=0.99 * limit.broadcast_like(rolled.F_x)))
    assert not said(rolled.assign(F_x=1.01 * rolled.F_x).assign_attrs(friction_by_angle="1 at 5°"))


def test_pages_say_what_planar_contact_makes_of_friction_by_angle(rolled):
    for words, notes in (("", 1), ("1 at 5°.", 2)):
        texts = [note.text for note in chart_notes(rolled.assign_attrs(friction_by_angle=words), "own")]
        assert len(texts) == notes
        assert ("one friction coefficient to each plane" in texts[-1]) == bool(words)


def test_the_verdict_of_compression_says_how_much_slides(pressed):
    text = compression_page.parts(pressed).summary
    shares = 100 * pressed.isel(load=-1).sliding_share.sel(ics="Bhat").values
    assert f"{min(shares):.0f} to {max(shares):.0f} % of the contact area slides with B̂" in text


def test_the_verdict_of_compression_knows_what_estimates_cover(pressed):
    share = xr.zeros_like(pressed.sliding_share)
    for off, known, said in (
        (0.11, 0.05, "not decided"),
        (0.13, 0.05, "no"),
        (0.0, 0.005, "yes"),
    ):
        moved = xr.where(share.ics == "Bhat", 0.5, 0.5 + off).broadcast_like(share)
        estimate = xr.full_like(share, known)
        table = compression_page.parts(
            pressed.assign(sliding_share=moved, estimate_sliding_share=estimate)
        ).answer
        assert table.rows[1].filled[0].text == said
    (alone,) = compression_page.parts(pressed.sel(ics=["A"])).answer.rows
    assert alone.filled[0].text == "reference"


def test_the_answer_of_compression_has_the_numbers_of_the_arrays(pressed):
    at = pressed.sel(friction=worst_friction(pressed)).isel(load=-1)
    rows = read_texts(compression_page.parts(pressed).answer)
    for name in ("A", "Bhat"):
        contact, cells = at.sel(ics=name), rows[ics_symbol(name)]
        for text, key, factor, least in ((cells[1], "sliding_share", 100, 1e-3), (cells[2], "p_max", 1, 0.0)):
            known = factor * float(contact[f"estimate_{key}"])
            shown, expected = read_number(text)[0], factor * float(contact[key])
            miss = known / 2 if text.startswith("within") else known / 10  # 0 stands for what is not resolved
            assert shown == pytest.approx(expected, abs=max(miss, least))
    away = abs(difference(pressed)).sel(ics="A")
    judged = compression_page.parts(pressed).answer.rows[1].filled[0].below
    shown, known = read_number(judged)
    assert np.any(np.isclose(shown, away, atol=known))


def test_sliding_shares_are_drawn_in_percent_and_their_band_ends_at_0_and_100(pressed):
    wide = pressed.assign(estimate_sliding_share=xr.full_like(pressed.sliding_share, 0.9))
    for step, friction in zip(read_chart(compression_page.sliding(wide))["steps"], (0.2, 0.5), strict=True):
        over_load, away, over_angle = step
        share = 100 * pressed.sliding_share.sel(friction=friction)
        for cell in (over_load, over_angle):
            np.testing.assert_allclose(drawn(cell)["A"], share.sel(ics="A"), rtol=1e-5)
            (band,) = (trace["y"] for trace in cell["traces"] if trace.get("fill"))
            ends = share.sel(ics="Bhat") + 90, (share.sel(ics="Bhat") - 90)[::-1]
            np.testing.assert_allclose(band, np.clip(np.concatenate(ends), 0, 100), rtol=1e-5)
        expected = share.sel(ics="A") - share.sel(ics="Bhat")
        np.testing.assert_allclose(drawn(away)["A"], expected, rtol=1e-5)
        np.testing.assert_allclose(over_load["traces"][-1]["x"], [5.0, 10.0])
    assert abscissa(pressed).title == "load [kN]"


def test_page_has_a_table_of_changes_with_other_supports(pressed, tmp_path):
    """At the place of the numbers that supports change, here the approach by a fifth."""
    dataset = pressed.assign_coords(ics=["A", "C"], supports=["same", "softer"])
    given = dataset.sel(ics="C", friction=0.2, load=1e4)
    names = MOTIONS["compression"].quantities
    numbers = {
        f"supported_{name}": ("supports", float(given[name]) * np.array([1, 1 + (name == "approach") / 5]))
        for name in names
    }
    dataset = dataset.assign(numbers | {"supported_friction": 0.2, "supported_load": 1e4})
    page = PAGES["compression"].write(dataset, tmp_path).read_text(encoding="utf-8")
    assert '<th class="name" scope="col">computed with C, friction 0.2, 10 kN</th>' in page
    assert '<th scope="col">change with softer</th>' in page
    rows = read_texts(*support_tables(dataset))
    shown = [name for name in names if not vanishes(dataset, name)]
    assert list(rows) == [quantity_label(dataset, name).title for name in shown]
    before, same, softer = rows["ζ [mm]"]
    require_number(before, given.approach, given.estimate_approach)
    assert same == "0"
    assert float(softer) == pytest.approx(0.2 * float(given.approach), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("of", ["rolled", "pressed"])
def test_nothing_is_wider_than_the_window(of, request, browser, tmp_path):
    dataset = request.getfixturevalue(of)
    page = PAGES["rolling" if of == "rolled" else "compression"].write(dataset, tmp_path)
    require_room(browser, page, {800: 800})
