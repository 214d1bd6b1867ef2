"""The page of `femic shifts`: its sentences, tables and charts against the dataset."""

import json

import numpy as np
import pytest
import xarray as xr

from compare.pages import shift_figures as figures
from compare.pages import shifts as page
from compare.pages.shift_figures import compared_ics, difference, reference_names, reference_values
from compare.report.tables import MINUS
from femic.results import wheelset_contacts as geometry
from femic.shifts.sides import lay_out_wheelset
from geometries.track.wheelset import curves_in_place, settle
from tests.compare.pages import read_chart, read_texts, read_traces
from tests.femic.shifts.fakes import SHIFTS, changed, known_dataset


@pytest.fixture
def dataset():
    return known_dataset()


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
    for row in page.each_patch_table(dataset, several=True).rows:
        rows.setdefault(row.name or next(reversed(rows)), []).append([cell.text for cell in row.filled])
    assert set(rows) == {"2 mm, left", "2 mm, right"}  # those of several patches
    flange, tread = rows["2 mm, left"]
    assert flange[:4] == ["1", "68.8", "10.00", "3.3"]
    assert tread[:3] == ["2", "2.9", "90.11"]
    assert len(page.each_patch_table(dataset, several=False).rows) == 12
    assert page.each_patch_table(dataset.sel(shift=[1.0]), several=True) is None


def test_the_best_ics_are_c_where_it_is_known(dataset):
    names = reference_names(dataset)
    assert names.sel(shift=2.0, side="left").item() == "C"
    assert names.sel(shift=1.0, side="left").item() == "Bhat"
    assert np.all(reference_values(dataset, "p_max").values == 1000)
    assert np.isfinite(difference(dataset, "Bhat")).sum() == 1
    assert difference(dataset, "A").sel(shift=1.0, side="right").item() == pytest.approx(-0.035)


def test_the_summary_has_the_numbers_of_the_dataset(dataset):
    """All are 1000 MPa with the best ICs; the first of them counts."""
    text = page.summary(dataset)
    assert text.startswith("The largest pressure is 1000 MPa with B̂, at a shift of -2 mm on the left wheel.")
    assert "18 degrees" in text
    assert f"at an amplitude of 0.5 mm is {dataset.attrs['conicity']:.3f}." in text
    assert "at an amplitude of 0.5 mm is –." in page.summary(dataset.assign_attrs(conicity=np.nan))


def test_planar_contact_is_compared_and_never_a_reference(dataset):
    """It differs by half from that with A."""
    planar = dataset.sel(ics=["A"]).assign_coords(ics=["planar"])
    planar["p_max"] = planar.p_max / 2
    planar = xr.concat([dataset, planar], "ics", data_vars="minimal")
    assert compared_ics(planar)[-1] == "planar"
    assert "planar" not in reference_names(planar).values
    rows = read_texts(page.answer_table(planar))
    assert rows["planar"][:3] == ["no shift"] * 3
    assert rows["planar"][-1] == f"{MINUS}53.50"
    assert page.answer_table(planar.sel(ics=["A", "planar"])).rows[0].name == "planar"


def test_the_answer_table_has_the_numbers_of_the_dataset(dataset):
    table = page.answer_table(dataset)
    cells = read_texts(table)
    assert cells["A"] == ["-2 to -1 mm", "-2 to 0 mm", "-2 to 1 mm", "1200", "1000", "+20.00"]
    assert cells["B̂"][-1] == "0.00"
    assert table.rows[0].filled[-1].below == "2 mm, left"
    same = dataset.assign(p_max=dataset.p_max * 0 + 1000)
    assert read_texts(page.answer_table(same))["A"][:3] == ["all shifts"] * 3


def test_the_charts_have_the_numbers_of_the_dataset(dataset):
    content = read_chart(figures.pressures(dataset))
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
        np.testing.assert_array_equal(outline.points[0], expected[: len(outline.points[0])])
        for panel in (section, patch):
            inner, outer = panel.limits_x if side == "right" else panel.limits_x[::-1]
            assert inner < outer
            drawn = np.concatenate([curve.points[0] for curve in patch.curves])
        assert inner < np.nanmin(drawn) < np.nanmax(drawn) < outer


def test_the_page_says_what_was_left_out_unusual_or_assumed(dataset, tmp_path):
    refused = json.dumps({"8": "the left wheel climbs its rail", "1, left": "no"})
    unusual = json.loads(dataset.attrs["unusual"]) | {"2": "the left wheel touches 0.4 mm beyond"}
    shown = dataset.assign_attrs(refused=refused, unusual=json.dumps(unusual))
    text = page.write_shifts(shown, tmp_path).read_text()
    (assumed,) = json.loads(dataset.attrs["doubts"])
    for said in (
        "a remark",
        "8 mm: the left wheel climbs its rail",
        "Unusual contacts",
        "2 mm: the left wheel touches 0.4 mm beyond",
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
    assert f"may change the largest p_max by {strain:.0f} MPa" in page._load_note(soft)
