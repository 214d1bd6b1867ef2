"""What `femic contact` writes of rolling and compression: file, verdict, answer, charts, tables."""

import numpy as np
import pytest
import xarray as xr

from compare.pages import compression as compression_page
from compare.pages import rolling as rolling_page
from compare.pages.contact_numbers import verdict
from compare.pages.friction import (
    abscissa,
    contact_maps,
    difference,
    number_tables,
    numbers_chart,
    quantity_label,
    vanishes,
    worst_friction,
)
from compare.pages.friction_pages import PAGES
from compare.report.looks import ics_symbol
from compare.report.tables import number_text
from femic.results.friction import compute_with_friction
from tests.compare.friction.scenes import scene
from tests.compare.pages import read_chart, read_texts, require_number, require_room

COARSE = 8  # elements across the patch


@pytest.fixture(scope="module")
def rolled():
    keys = {"motion": "rolling", "loads": [1e4], "longitudinal": [-4e-3, 0.0, 4e-3]}
    return compute_with_friction(scene(10.3, elements=COARSE, friction=[0.3, 0.5], **keys))


@pytest.fixture(scope="module")
def pressed():
    return compute_with_friction(
        scene(10.3, elements=COARSE, friction=[0.2, 0.5], motion="compression", loads=[5e3, 1e4])
    )


def content(chart):
    """What a page has of a chart."""
    return read_chart(chart)


def drawn(cell):
    """The ordinates of the curves of a cell by their labels; the last ones of each label."""
    return {trace["name"]: trace["y"] for trace in cell["traces"] if trace.get("name")}


def test_page_and_file_of_rolling_agree(rolled, tmp_path):
    page = rolling_page.ROLLING.write(rolled, tmp_path).read_text(encoding="utf-8")
    written = xr.open_dataset(tmp_path / "contact.nc")
    assert {path.name for path in (tmp_path / "figures").iterdir()} == {
        f"contact_{name}.svg"
        for name in (
            "creep_force",
            "centre_line",
            "stick",
            "pressures",
            "work",
            "numbers_0.3",
            "numbers_0.5",
        )
    }
    assert rolling_page.parts(written).summary in page.replace("&#39;", "'")
    for name in ("A", "Bhat"):
        text = number_text(100 * written.zero_creepage.sel(ics=name, friction=0.5), ".3f")
        assert f"<td>{text}" in page
    assert np.all(written.F_x.diff("xi") > 0)


def test_the_summary_of_rolling_says_where_the_wheel_rolls_freely(rolled):
    text = rolling_page.parts(rolled).summary
    zero = 100 * rolled.zero_creepage.sel(ics="Bhat")
    assert f"at a creepage of {float(zero.min()):.2g} ... {float(zero.max()):.2g}% with B̂" in text
    assert "Under 10 kN" in text
    assert "friction 0.3 ... 0.5" in text


@pytest.mark.parametrize(
    ("off", "known", "said"),
    [
        (1.5, 0.1, "within 2 %"),
        (7.0, 0.1, "off by 7 %"),
        (1.9, 0.4, "not decided: ± 0.4 %"),
        (2.1, 0.4, "not decided: ± 0.4 %"),
    ],
)
def test_verdict_follows_from_the_largest_difference_and_its_estimate(rolled, off, known, said):
    """Though all are within 2 % by root mean square."""
    assert verdict(off, known, 2.0) == said
    largest = rolled.largest.copy(data=0.01 * np.array([[off / 2, 0.0], [off, 0.0]]))
    estimate = rolled.estimate_largest.copy(data=np.full((2, 2), 0.01 * known))
    moved = rolled.assign(largest=largest, estimate_largest=estimate, rms=0.01 * rolled.rms)
    rows = {row.name: row.filled[0] for row in rolling_page.answer(moved).rows}
    assert (rows["A"].below, rows["B̂"].text) == (said, "")


def test_one_ics_alone_has_a_page_that_compares_nothing(rolled):
    alone = rolled.sel(ics=["A"])
    assert [len(cells) for cells in rolling_page.creep_force(alone).steps.values()] == [1, 1]
    assert [row.name for row in rolling_page.answer(alone).rows] == ["A"]


def test_the_answer_of_rolling_has_the_numbers_of_the_arrays(rolled):
    friction, table = worst_friction(rolled), rolling_page.answer(rolled)
    rows = read_texts(table)
    at = rolled.sel(friction=friction)
    for name in ("A", "Bhat"):
        curve, cells = at.sel(ics=name), rows[ics_symbol(name)]
        for text, key, factor in ((cells[1], "zero_creepage", 100), (cells[3], "slope", 1e-5)):
            require_number(text, factor * curve[key], factor * curve[f"estimate_{key}"])
    largest, known = map(float, rows["A"][0].split(" ± "))
    assert largest == pytest.approx(100 * float(rolled.largest.sel(ics="A").max()), abs=known / 10)
    off = at.slope.sel(ics="A") / at.slope.sel(ics="Bhat") - 1
    assert float(rows["A"][4]) == pytest.approx(100 * float(off), abs=0.051)
    assert rows["B̂"][0] == rows["B̂"][2] == ""
    assert f"friction {friction:g} [%]" in table.heads[1].title


def test_ics_differ_most_at_the_friction_shown_first(rolled):
    largest = rolled.largest.sel(ics="A")
    assert worst_friction(rolled) == float(rolled.friction[int(largest.argmax("friction"))])
    assert worst_friction(rolled.isel(friction=slice(None, None, -1))) == worst_friction(rolled)
    for chart in (rolling_page.creep_force(rolled), rolling_page.centre_line(rolled), numbers_chart(rolled)):
        assert (
            content(chart)["labels"][content(chart)["start"]] == f"μ\u00a0=\u00a0{worst_friction(rolled):g}"
        )
        assert chart.slider == "friction"


def test_creep_force_curves_are_drawn_in_newtons_over_percent_beside_their_differences(rolled):
    steps = content(rolling_page.creep_force(rolled))["steps"]
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
        (band,) = (trace for trace in away["traces"] if trace.get("fill"))
        estimate = 100 * of_friction.estimate_F_x.sel(ics="Bhat") / (friction * 1e4)
        np.testing.assert_allclose(band["y"][:3], estimate, rtol=1e-5)


def test_tractions_along_the_centre_line_are_those_of_the_maps(rolled):
    (pressure, traction, away), _ = content(rolling_page.centre_line(rolled))["steps"]
    strip = int(rolled.p.sel(direction="n", ics="Bhat").max(["friction", "x"]).argmax("s"))
    assert f"s = {float(rolled.s[strip]):.3g} mm" in pressure["title"]
    along = rolled.p.isel(friction=0, s=strip)
    p, p_x = (along.sel(direction=name) for name in ("n", "x"))
    inside = np.isin(np.round(rolled.x.values, 5), np.round(pressure["traces"][0]["x"], 5))
    np.testing.assert_allclose(drawn(pressure)["A"], p.sel(ics="A")[inside], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(drawn(traction)["A"], p_x.sel(ics="A")[inside], rtol=1e-5, atol=1e-9)
    expected = (p_x.sel(ics="A") - p_x.sel(ics="Bhat"))[inside]
    np.testing.assert_allclose(drawn(away)["A"], expected, rtol=1e-4, atol=1e-3)
    bound = 0.3 * p.sel(ics="Bhat")[inside]
    np.testing.assert_allclose(drawn(traction)["friction times pressure"], -bound, rtol=1e-5, atol=1e-9)
    assert float(p[:, ~inside].max()) == 0.0


@pytest.mark.parametrize("of", ["rolled", "pressed"])
def test_maps_show_the_contact_with_all_ics_in_the_same_colours(of, request):
    at = request.getfixturevalue(of).isel(friction=1)
    p = at.p.sel(direction="n")
    expected = {"pressures": p, "work": at.work, "stick": 1.0 - at.stick}
    for name, values in expected.items():
        cells = contact_maps(at, name)
        assert [cell.title for cell in cells] == ["A", "B̂"]
        assert len({cell.range for cell in cells}) == 1
        for cell, ics in zip(cells, ("A", "Bhat"), strict=True):
            whole = values.where(p > 0).sel(ics=ics)
            np.testing.assert_array_equal(cell.values, whole.sel(x=cell.x, s=cell.y))
            assert np.isfinite(cell.values).sum() == int((p.sel(ics=ics) > 0).sum())


def test_all_numbers_are_drawn_and_listed_but_those_that_vanish(rolled):
    names = "F_x", "p_max", "area", "sliding_share", "F_y", "M_x", "M_z"
    assert [vanishes(rolled, name) for name in names] == 4 * [False] + 3 * [True]
    steps = content(numbers_chart(rolled))["steps"]
    by_title = {cell["title"]: drawn(cell) for cell in steps[1]}
    np.testing.assert_allclose(
        by_title["largest pressure"]["A"], rolled.p_max.sel(friction=0.5, ics="A"), rtol=1e-5
    )
    shares = 100 * rolled.sliding_share.sel(friction=0.5, ics="A")
    np.testing.assert_allclose(
        by_title[quantity_label(rolled, "sliding_share").meaning]["A"], shares, rtol=1e-5
    )
    *folded, symmetric = number_tables(rolled)
    assert len(folded) == len(steps[0]) == 9
    assert symmetric.startswith("0 by symmetry: F_y (estimated error at most ")
    table = folded[0].blocks[1]
    assert table.caption == "friction 0.5: F_x [kN]"
    assert [row.name for row in table.rows] == ["-0.4%", "0%", "0.4%"]
    cell, contact = table.rows[2].cells[0], rolled.sel(friction=0.5, ics="A", xi=4e-3)
    require_number(f"{cell.text} {cell.below}", 1e-3 * contact.F_x, 1e-3 * contact.estimate_F_x)


def test_a_moment_that_is_not_rounding_is_drawn(rolled):
    turned = rolled.assign(M_z=rolled.M_z + 5.0)
    assert not vanishes(turned, "M_z")
    assert len(numbers_chart(turned).cells) == 2 * 10


def test_remarks_say_which_contacts_are_less_accurate(rolled):
    assert "less accurate" not in " ".join(rolling_page.remarks(rolled))
    some = rolled.assign(simplified=xr.zeros_like(rolled.simplified))
    some.simplified[0, 0] = [True, False, True]
    text = " ".join(rolling_page.remarks(some))
    assert "A: 2 of 6 contacts were solved only with fewer elements" in text
    assert "B̂: " not in text


def test_remarks_state_the_effect_of_the_displaced_wheel_if_known(rolled):
    moved = rolled.assign(
        displaced_zero_creepage=rolled.zero_creepage - 3e-5, displaced_p_max=0.97 * rolled.p_max.sel(xi=0.0)
    )
    text = " ".join(rolling_page.remarks(moved))
    assert "would move the creepage without force by 0% and change p_max by −3.0%, with B̂." in text
    unknown = rolled.assign(displaced_zero_creepage=np.nan * rolled.zero_creepage)
    assert "displaced wheel" not in " ".join(rolling_page.remarks(unknown))


def test_ics_with_an_exchanged_component_are_named(rolled):
    named = rolled.assign_coords(ics=["Bhat+sn:B", "Bhat"])
    assert "B̂ (sn B)" in rolling_page.creep_force(named).legend
    assert {row.name for row in rolling_page.answer(named).rows} == {"B̂ (sn B)", "B̂"}


def test_the_verdict_of_compression_says_how_much_slides(pressed):
    text = compression_page.parts(pressed).summary
    shares = 100 * pressed.isel(load=-1).sliding_share.sel(ics="Bhat").values
    assert f"{min(shares):.0f} ... {max(shares):.0f} % of the contact area slides with B̂" in text


def test_the_verdict_of_compression_knows_what_estimates_cover(pressed):
    share = xr.zeros_like(pressed.sliding_share)
    for off, known, said in (
        (0.14, 0.05, "not decided: ± 10 %"),
        (0.16, 0.05, "off by 16 %"),
        (0.02, 0.01, "within 5 %"),
    ):
        moved = xr.where(share.ics == "Bhat", 0.5, 0.5 + off).broadcast_like(share)
        estimate = xr.full_like(share, known)
        table = compression_page.parts(
            pressed.assign(sliding_share=moved, estimate_sliding_share=estimate)
        ).answer
        assert table.rows[0].filled[2].below == said
    (alone,) = compression_page.parts(pressed.sel(ics=["A"])).answer.rows
    assert alone.filled[2].text == ""


def test_the_answer_of_compression_has_the_numbers_of_the_arrays(pressed):
    at = pressed.sel(friction=worst_friction(pressed)).isel(load=-1)
    rows = read_texts(compression_page.parts(pressed).answer)
    for name in ("A", "Bhat"):
        share, p_max = (float(rows[ics_symbol(name)][column].split(" ± ")[0]) for column in (0, 3))
        known = 100 * float(at.estimate_sliding_share.sel(ics=name))
        assert share == pytest.approx(100 * float(at.sliding_share.sel(ics=name)), abs=max(known / 10, 1e-3))
        assert p_max == pytest.approx(
            float(at.p_max.sel(ics=name)), abs=float(at.estimate_p_max.sel(ics=name)) / 10
        )
    away = abs(difference(pressed)).sel(ics="A")
    largest, known = map(float, rows["A"][2].split(" ± "))
    assert largest == pytest.approx(float(away.max()), abs=known / 10)


def test_sliding_shares_are_drawn_in_percent_and_their_band_ends_at_0_and_100(pressed):
    wide = pressed.assign(estimate_sliding_share=xr.full_like(pressed.sliding_share, 0.9))
    for step, friction in zip(content(compression_page.sliding(wide))["steps"], (0.2, 0.5), strict=True):
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


@pytest.mark.slow
@pytest.mark.parametrize("of", ["rolled", "pressed"])
def test_nothing_is_wider_than_the_window(of, request, browser, tmp_path):
    dataset = request.getfixturevalue(of)
    page = PAGES["rolling" if of == "rolled" else "compression"].write(dataset, tmp_path)
    require_room(browser, page, {800: 800})


# ---- friction that depends on the contact angle


@pytest.fixture(scope="module")
def flanged():
    """Friction of the contact in the middle by far larger than beside it."""
    keys = {"motion": "rolling", "loads": [1e4], "longitudinal": [-4e-3, 0.0, 4e-3], "ics": ["A"]}
    law = {"friction_by_angle": [[5, 1.0], [15, 0.25]], "equal_force": 0.3}
    return compute_with_friction(scene(10.3, elements=COARSE, friction=[0.3], **keys, **law))


def test_files_have_the_factors_of_friction_and_tractions_within_them(rolled, flanged):
    angle = np.degrees(np.abs(flanged.inclination))
    np.testing.assert_allclose(flanged.friction_factor, np.interp(angle, [5, 15], [1.0, 0.25]))
    assert np.all(rolled.friction_factor == 1.0)
    pressure = flanged.p.sel(direction="n")
    tangential = np.hypot(flanged.p.sel(direction="x"), flanged.p.sel(direction="s"))
    share = (tangential / (0.3 * pressure)).where(pressure > 0)
    assert np.all((share <= flanged.friction_factor * (1 + 1e-5)) | np.isnan(share))
    assert float(share.max()) > 0.5


def test_pages_say_how_friction_depends_on_the_angle_where_it_does(rolled, flanged):
    said = "multiplied by a factor that depends on the contact angle: 1 at 5°, 0.25 at 15°, linear"
    assert said in str(flanged.attrs["friction_by_angle"])
    assert rolled.attrs["friction_by_angle"] == ""
    assert "flanks are pressed together" in rolling_page.parts(rolled).note
    assert "flanks are pressed together" not in rolling_page.parts(flanged).note


def test_limits_along_the_centre_line_are_those_of_its_strip(flanged):
    """A factor of a quarter there makes limits a quarter of friction times pressure."""
    quarter = flanged.assign(friction_factor=0 * flanged.friction_factor + 0.25)
    one, other = (
        drawn(content(rolling_page.centre_line(of))["steps"][0][1])["friction times pressure"]
        for of in (flanged, quarter)
    )
    np.testing.assert_allclose(other, 0.25 * np.array(one), rtol=1e-5)
    assert np.any(one)
