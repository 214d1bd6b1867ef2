"""The page of `femic shifts`: its sentences, tables and charts against the dataset."""

import json

import numpy as np
import pytest
import xarray as xr

from compare.pages import shift_figures as figures
from compare.pages import shifts as page
from compare.pages.shift_figures import (
    compared_ics,
    decisions,
    difference,
    difference_estimate,
    flange_limits,
    reference_names,
    reference_values,
)
from compare.report.parts import Note
from compare.report.tables import MINUS
from femic.results import wheelset_contacts as geometry
from femic.shifts.sides import lay_out_wheelset
from geometries.errors import Failure
from geometries.track.conicity import equivalent_conicity
from geometries.track.wheelset import curves_in_place, settle
from tests.compare.pages import read_chart, read_texts, read_traces
from tests.femic.shifts.fakes import SHIFTS, changed, known_dataset


@pytest.fixture
def dataset():
    return known_dataset().copy(deep=True)


@pytest.fixture(scope="module")
def shown():
    """The same as the page has it: differences and their estimates are found once. Nobody changes it."""
    return figures.with_differences(known_dataset().copy(deep=True))


def test_the_dataset_and_the_page_say_which_patch_carries_what(dataset):
    """At 2 mm a patch at 1.2 rad carries 10 kN along its normal, of which 3.3 % of the load is vertical."""
    own = dataset.sel(shift=2.0, side="left", ics="Bhat")
    np.testing.assert_allclose(own.patch_normal_force, [1e4, 9e4 / np.cos(0.05)])
    np.testing.assert_allclose(own.patch_angle, np.degrees([1.2, 0.05]))
    np.testing.assert_allclose(np.diff(own.patch_centre), 30.0)
    assert float(own.patch_end[1] - own.patch_start[1]) == pytest.approx(10.0)
    assert dataset.patch_normal_force.attrs["units"] == "N"
    alone = dataset.sel(shift=1.0, side="left", ics="Bhat")
    assert np.isnan(alone.patch_p_max[1])
    rows = {}
    for row in page.each_patch_table(dataset).rows:
        rows.setdefault(row.name or next(reversed(rows)), []).append([cell.text for cell in row.filled])
    flange, tread = rows["2 mm, left"]
    assert flange[2:5] == ["68.8", "10.00", "3.3"]
    assert tread[2:4] == ["2.9", "90.11"]
    assert {name: len(own) for name, own in rows.items() if len(own) > 1} == {
        "2 mm, left": 2,
        "2 mm, right": 2,
    }
    assert len(rows) == 10


def test_the_best_ics_are_c_where_it_is_known(dataset):
    names = reference_names(dataset)
    assert names.sel(shift=2.0, side="left").item() == "C"
    assert names.sel(shift=1.0, side="left").item() == "Bhat"
    assert np.all(reference_values(dataset, "p_max").values == 1000)
    assert np.isfinite(difference(dataset, "Bhat")).sum() == 1
    assert difference(dataset, "A").sel(shift=1.0, side="right").item() == pytest.approx(-0.035)


def test_the_summary_has_the_numbers_of_the_dataset(shown):
    """All are 1000 MPa with the best ICs; the first of them counts."""
    text = page.summary(shown)
    assert text.startswith("The largest pressure is 1000.0 ± 3.0 MPa")
    assert "with B̂, at −2 mm on the left wheel, on the tread." in text
    assert "With A, p_max is within 5 % of C (elsewhere B̂) at −2 to 0 mm, but not at 1 to 2 mm." in text
    assert "With B̂, p_max is within 5 % of C at 2 mm; elsewhere B̂ is the reference itself." in text
    assert "Largest difference of p_max: +20.0 ± 1.4 %, with A at 2 mm on the left wheel." in text
    assert f"at an amplitude of 0.5 mm is {shown.attrs['conicity']:.3f}." in text


def test_the_summary_says_why_there_is_no_conicity(shown):
    rising = np.linspace(-5, 5, 11)
    for differences, amplitude, said in (
        (-rising, 3.0, "cannot be given: the rolling-radius difference goes from 5 to -5 mm and does not"),
        (rising, 9.0, "cannot be given: between the shifts from -5 to 5 mm, and where the wheelset"),
    ):
        with pytest.raises(Failure) as failure:
            equivalent_conicity(rising, differences, amplitude)
        reason = {"conicity": np.nan, "amplitude": amplitude, "conicity_reason": str(failure.value)}
        text = page.summary(shown.assign_attrs(reason))
        assert f"The equivalent conicity at an amplitude of {amplitude:g} mm {said}" in text
        assert "give more" not in text


def test_a_difference_is_decided_if_its_estimate_does_not_reach_the_limit(dataset):
    """A differs by 2 and -7 % on the left wheel; the floor of B-hat is 3 MPa, then 35 MPa."""
    shifts = [0.0, 1.0]
    own = dataset.sel(shift=shifts)
    assert decisions(own, "A", 0.05).values.tolist() == ["yes", "no"]
    rough = own.assign(floor_p_max=own.floor_p_max * 35 / 3)
    assert decisions(rough, "A", 0.05).values.tolist() == ["not decided"] * 2
    assert decisions(rough, "A", 0.10).values.tolist() == ["yes", "not decided"]
    assert decisions(rough, "A", 0.01).values.tolist() == ["not decided", "no"]
    unknown = own.assign(larger_p_max=np.nan * own.p_max)
    assert set(decisions(unknown, "A", 0.05).values) == {"not decided"}
    assert decisions(own, "Bhat", 0.05).values.tolist() == ["", ""]  # the best ICs themselves


def test_the_estimated_error_of_c_counts_in_full_and_common_elements_do_not(dataset):
    """C less 20 MPa: 1200 / 980 instead of 1.2. All numbers 10 % less on larger elements: no change."""
    at = {"shift": 2.0, "side": "left"}
    known = difference_estimate(dataset, "A").sel(at).item()
    doubtful = dataset.assign(change_p_max=20.0 * (dataset.ics == "C") + 0 * dataset.p_max)
    added = difference_estimate(doubtful, "A").sel(at).item() - known
    assert added == pytest.approx(1200 / 980 - 1.2, rel=1e-9)
    larger = dataset.assign(larger_p_max=0.9 * dataset.p_max)
    assert difference_estimate(larger, "A").sel(at).item() == pytest.approx(known, rel=1e-9)


def test_without_other_ics_nothing_is_compared(dataset):
    alone = dataset.sel(ics=["Bhat"])
    assert "No other ICs were used, so nothing was compared." in page.summary(alone)
    table = page.answer_table(alone)
    assert read_texts(table) == {"on the tread": ["1000.0 ± 3.0"], "in the flange root": ["1000.0 ± 3.0"]}
    assert [row.filled[0].below for row in table.rows] == [
        "−2 mm on the left wheel",
        "2 mm on the left wheel",
    ]


def test_flange_and_root_are_those_of_the_wheel():
    """An arc of 20 mm between a tread of 3 degrees and a flange of 70: 10 and 65 are where it says."""
    root, face, tread = 20.0, np.radians(70), np.radians(3)
    angle = np.linspace(face, tread, 400)
    y, z = -root * np.sin(angle), root * np.cos(angle)
    y, z = y - y[-1], z - z[-1]
    s = np.linspace(0, 1, 300)
    front = np.stack([y[0] - 5 * (1 - s) * np.cos(face), z[0] - 5 * (1 - s) * np.sin(face)])
    flat = np.stack([60 * s, 60 * s * np.tan(tread)])
    chamfer = flat[:, -1:] + 5 * np.stack([s, s])
    profile = np.concatenate([front[:, :-1], [y, z], flat[:, 1:], chamfer[:, 1:]], axis=1)
    dataset = xr.Dataset({"wheel_left": (("axis", "wheel_left_point"), profile)})
    expected = [float(np.interp(-np.radians(least), -angle, y)) for least in (65, 10)]
    assert flange_limits(dataset, "left") == pytest.approx(expected, abs=0.15)
    cone = xr.Dataset({"wheel_left": (("axis", "wheel_left_point"), flat)})
    assert flange_limits(cone, "left") is None


def test_the_chart_marks_where_another_part_of_the_wheel_is_reached(dataset, monkeypatch):
    """Between 0 and 1 mm, and between 1 and 2 mm; the second patch at 2 mm has its pressure."""
    own = {-2.0: "", -1.0: "tread", 0.0: "tread", 1.0: "flange root", 2.0: "flange"}
    monkeypatch.setattr(figures, "zones", lambda *_: list(own.values()))
    monkeypatch.setattr(figures, "flange_limits", lambda *_: (0.0, 0.0))
    left = figures.pressures(dataset).steps[""][0]
    assert left.marks == (0.5, 1.5)
    (written,) = [curve for curve in left.curves if curve.names]
    assert (written.x, written.names) == ((-1.0, 0.5, 1.5), ("tread", "flange root", "flange"))
    (further,) = [curve for curve in left.curves if curve.label == "further patches"]
    assert further.x == [2.0]


def test_drawn_sections_pass_all_points_and_are_small(dataset):
    """Within 0.02 mm, with less than a fifth of the points."""
    section = figures.places(dataset).steps["1 mm"][0]
    for curve in section.curves[:2]:
        x, y = curve.points
        assert len(x) < dataset.sizes[f"{curve.label}_left_point"] / 5
    rail = section.curves[0]
    y, z = dataset.rail_left.values[:, dataset.rail_left.values[1] > -5]
    np.testing.assert_allclose(np.interp(y, *rail.points), z, rtol=0, atol=0.03)


def test_planar_contact_is_compared_and_never_a_reference(dataset):
    """It differs by half from that with A."""
    planar = dataset.sel(ics=["A"]).assign_coords(ics=["planar"])
    planar["p_max"] = planar.p_max / 2
    planar = xr.concat([dataset, planar], "ics", data_vars="minimal")
    assert compared_ics(planar)[-1] == "planar"
    assert "planar" not in reference_names(planar).values
    rows = read_texts(page.answer_table(planar))
    assert rows["planar"][:3] == ["no: all shifts"] * 3
    assert rows["planar"][-1] == f"{MINUS}53.50 ± 0.60 %"  # both have an estimate of 3 MPa
    assert page.answer_table(planar.sel(ics=["A", "planar"])).rows[0].name == "planar"


def test_the_answer_table_has_the_numbers_of_the_dataset(dataset, shown):
    table = page.answer_table(shown)
    cells = read_texts(table)
    limits = ["yes: −2 to −1 mm", "yes: −2 to 0 mm", "yes: −2 to 1 mm"]
    assert cells["A"] == [*limits, "+20.0 ± 1.4 %"]  # 20 % / 20 + (1200 / 1003 - 1.2)
    below = [cell.below for cell in table.rows[0].filled]
    assert below == ["no: 0 to 2 mm", "no: 1 to 2 mm", "no: 2 mm", "2 mm on the left wheel"]
    assert cells["B̂, against C"] == ["yes: 2 mm"] * 3 + ["within ± 0.60 %"]  # the floors of both
    same = dataset.assign(dict.fromkeys(("p_max", "larger_p_max"), dataset.p_max * 0 + 1000))
    assert read_texts(page.answer_table(same))["A"][:3] == ["yes: all shifts"] * 3


def test_the_charts_have_the_numbers_of_the_dataset(dataset, shown):
    content = read_chart(figures.pressures(shown))
    traces = read_traces(content["steps"][0][0])
    np.testing.assert_allclose(traces["A"]["y"], dataset.p_max.sel(side="left", ics="A"), rtol=1e-5)
    differences = read_traces(content["steps"][0][2])
    np.testing.assert_allclose(
        differences["A"]["y"], 100 * difference(dataset, "A").sel(side="left"), rtol=1e-5, atol=1e-9
    )


def test_wheels_are_drawn_on_their_rails(dataset):
    """In place, no point of a wheel is below the rail, and the touching point is on both."""
    for shift in SHIFTS:
        at = dataset.sel(shift=shift)
        for side in ("left", "right"):
            y, z = figures.wheel_in_place(dataset, at, side)
            rail = dataset[f"rail_{side}"].values
            head = rail[:, rail[1] > -10]
            gap = np.interp(head[0], *np.array(sorted(zip(y, z, strict=True))).T) - head[1]
            assert np.min(gap) == pytest.approx(0, abs=2e-3)  # of polygons 0.25 mm long on a radius of 80 mm
            where = float(at.y.sel(side=side))
            assert np.interp(where, *head) == pytest.approx(float(at.z.sel(side=side)), abs=2e-3)
            *_, patch = figures.patch_ranges(at, side)
            assert np.mean(patch) == pytest.approx(float(at.s_rail.sel(side=side)), abs=1e-9)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_rolled_wheel_is_drawn_as_it_stands(side):
    """A roll of 20 mrad: points of the drawing are those of the curve in its place."""
    file = changed(shifts=(1.0,))
    layout = lay_out_wheelset(file)
    position = settle(layout, 1.0 - 460 * 0.02, roll=0.02)
    drawn = geometry.wheelset(file, {1.0: position}).merge(geometry.sections(layout)).sel(shift=1.0)
    drawn["height"] = position.pose(side)[2]  # with a given roll each side has its own
    _, wheel = curves_in_place(layout, position, side)
    points = figures.wheel_in_place(drawn, drawn, side)
    t = np.linspace(*wheel.limits, points.shape[1])
    np.testing.assert_allclose(points, wheel.position(t), rtol=0, atol=1e-9)


def test_charts_have_the_signs_of_the_dataset_and_the_left_wheel_at_the_left(dataset):
    """Arc lengths and distances from the middle grow to the field side: to the left, of a left rail."""
    sections, patches = np.split(np.array(figures.places(dataset).steps["1 mm"], dtype=object), 2)
    own = dataset.sel(shift=1.0)
    for side, section, patch in zip(("left", "right"), sections, patches, strict=True):
        for curve in section.curves:
            assert np.min(curve.points[0]) > 0
        outline = next(curve for curve in patch.curves if curve.label == "A")
        expected = own.outline_s.sel(side=side, ics="A").values
        assert np.isin(outline.points[0], expected).all()
        for panel in (section, patch):
            inner, outer = panel.limits_x if side == "right" else panel.limits_x[::-1]
            assert inner < outer
            drawn = np.concatenate([curve.points[0] for curve in patch.curves])
        assert inner < np.nanmin(drawn) < np.nanmax(drawn) < outer


def test_the_page_says_what_was_left_out_unusual_or_assumed(dataset, tmp_path):
    refused = json.dumps({"8": "the left wheel climbs its rail", "1, left": "no"})
    dataset.p_max[3, 0] = np.nan
    unusual = json.loads(dataset.attrs["unusual"]) | {"2": "the left wheel touches 0.4 mm beyond"}
    shown = dataset.assign_attrs(refused=refused, unusual=json.dumps(unusual))
    text = page.write_shifts(shown, tmp_path).read_text()
    (assumed,) = json.loads(dataset.attrs["doubts"])
    for said in (
        "The curves have gaps. Contacts without a solution: 1 of 10.",
        "Not solved at 8 mm: the left wheel climbs its rail.",
        "Not solved at 1 mm (left wheel): no.",
        "At −2 mm (left wheel): a remark. The same holds at −2 mm (right wheel), −1 mm (left wheel)",
        "At 2 mm: the left wheel touches 0.4 mm beyond.",
        assumed,
    ):
        assert said in text
    assert (tmp_path / "shifts.nc").is_file()
    rows = read_texts(page.values_table(dataset))
    assert rows["track.rail_inclination"][:2] == ["0.025", "assumed"]
    assert rows["contact.ics"][:2] == ["A, Bhat", "given"]
    assert "contact.c_above_deg" in text


def test_finite_strain_is_said_of_the_largest_pressure(dataset):
    """1.3 p_max / E of p_max, E the least of all bodies."""
    soft = dataset.assign_attrs(E=100e3)
    strain = 1.3 * float(dataset.p_max.max()) ** 2 / 100e3
    first = next(page._sections(soft))
    notes = " ".join(block.text for block in first.blocks if isinstance(block, Note))
    assert f"may change the largest p_max by {strain:.0f} MPa" in notes
