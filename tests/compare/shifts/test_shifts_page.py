"""The page of `femic shifts`: its sentences, tables and charts against the dataset; stored contacts."""

import json

import numpy as np
import pytest
import xarray as xr

from compare.pages import shift_figures as figures
from compare.pages import shifts as page
from compare.pages.shift_figures import compared_ics, difference, reference_names, reference_values
from compare.report.tables import MINUS
from femic.cache.store import Store
from femic.reference.run_options import RunOptions, Watch
from femic.results import wheelset as compute
from femic.results import wheelset as values
from femic.results import wheelset_contacts as contacts
from femic.results import wheelset_contacts as geometry
from femic.shifts.contact import label_contact
from femic.shifts.sides import lay_out_wheelset
from femic.shifts.specification import (
    ContactTable,
    ProfileTable,
    ShiftsFile,
    TrackTable,
    WheelsetTable,
    WheelTable,
    parse_specification,
)
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid
from geometries.profiles.standards import standard
from geometries.track.wheelset import curves_in_place, settle
from tests.compare.pages import read_chart, read_texts, read_traces

SHIFTS = (-2.0, -1.0, 0.0, 1.0, 2.0)
FILE = ShiftsFile(
    shifts=SHIFTS,
    conicity_amplitude=0.5,
    rail=ProfileTable(profile="60E1"),
    wheel=WheelTable(profile="cone-1-20"),
    right_wheel=WheelTable(profile="cone-1-20", nu=0.3),
    contact=ContactTable(ics=("A", "Bhat"), c_above_deg=20.0),
)
SHARES = {-2.0: 0.005, -1.0: 0.0, 0.0: 0.02, 1.0: -0.07, 2.0: 0.2}  # of A, left; the right wheel: half of it


def numbers(where, ics):
    shift = where.position.given_shift
    share = SHARES[shift] * (1.0 if where.side == "left" else 0.5) if ics == "A" else 0.0
    s = np.linspace(-5, 5, 31)
    outline = np.stack([where.touch.s_rail + s, 6 * np.sqrt(1 - (s / 5) ** 2)])
    largest = 1000 * (1 + share)
    patch = {
        "normal_force": 9e4 / np.cos(0.05),
        "share": 1.0,
        "p_max": largest,
        "angle": np.degrees(0.05),
        "centre": where.touch.s_rail,
        "start": outline[0, 0],
        "end": outline[0, -1],
        "half_length": 6.0,
        "area": 94.0,
        "outline": outline,
    }
    forces = {"vertical": 9e4, "lateral": 4e3, "estimate_lateral": 50.0}
    sizes = {"angle": 20 + shift, "a": 6.0, "b": 5.0, "seconds": 0.5, "patches": two_patches(patch, shift)}
    return {"p_max": largest, "estimate_p_max": 3.0, "approach": 0.1} | forces | sizes


def two_patches(patch, shift):
    """One patch, or at 2 mm the flange as well."""
    if shift != 2.0:
        return (patch,)
    places = {name: patch[name] - 30.0 for name in ("centre", "start", "end")}
    flange = patch | {"normal_force": 1e4, "share": 0.033, "angle": np.degrees(1.2)} | places
    return flange, patch | {"share": 0.967}


def fake(where, *_):
    ics = ["A", "Bhat"] + (["C"] if where.position.given_shift == 2.0 and where.side == "left" else [])
    rows = {name: numbers(where, name) for name in ics}
    return label_contact(rows, (Grid(40, 40, 0.5, 0.4),), notes=("a remark",))


def test_shifts_left_out_are_said_before_the_first_contact(monkeypatch):
    """A wheelset that stands nowhere at 12 mm; a contact that is not found is said in its place."""
    said = []
    monkeypatch.setattr(compute, "settle", standing_below(10.0))

    def contact_at(*_):
        raise Failure("no grid")

    monkeypatch.setattr(contacts, "contact_at", contact_at)
    monkeypatch.setattr(geometry, "conicity", lambda *_, **__: xr.Dataset())
    file = FILE.model_copy(update={"shifts": (0.0, 12.0), "wheel": WheelTable(profile="S1002")})
    file = file.model_copy(update={"right_wheel": None})
    with pytest.raises(Failure, match="shifts: no contact was found: "):
        compute.compute_shifts(file, options=RunOptions(watch=Watch(on_stage=said.append)))
    assert said[0].startswith("Assumed, because the specification does not say: ")
    assert said[1].startswith("shift 12 mm is left out: ")
    assert said[2] == "shift 0 mm (1 of 1), left is left out: no grid"
    assert len(said[1]) > len("shift 12 mm is left out: ")


@pytest.mark.parametrize(
    ("wheel", "jumps"), [("cone-1-20", 0), pytest.param("S1002", 2, marks=pytest.mark.slow)]
)
def test_conicity_of_equal_sides_needs_half_of_the_shifts(wheel, jumps):
    """The other half is the mirror image."""
    file = ShiftsFile(
        conicity_amplitude=0.5, rail=ProfileTable(profile="60E1"), wheel=WheelTable(profile=wheel)
    )
    layout, found, said = lay_out_wheelset(file), {}, {True: [], False: []}
    for alike in (True, False):
        watch = Watch(on_stage=said[alike].append)
        found[alike] = geometry.conicity(layout, file, watch, alike=alike)
    half, whole = found[True], found[False]
    assert len(whole.attrs["jumps"]) == jumps
    np.testing.assert_allclose(half.attrs["jumps"], whole.attrs["jumps"], atol=1e-3)
    for name in ("near", "rrd_near"):
        np.testing.assert_allclose(half[name], whole[name], atol=1e-5)
    assert half.attrs["conicity"] == pytest.approx(whole.attrs["conicity"], rel=1e-5)
    assert said[True][0] == said[False][0]
    assert len(said[True]) == len(said[False]) == 2


def test_unequal_wheels_run_about_a_shift_of_their_own():
    """Cones of 1:20 whose radii differ by 0.2 mm: about -2 mm, beyond the shifts that are taken first."""
    file = ShiftsFile(
        conicity_amplitude=0.5,
        rail=ProfileTable(profile="60E1"),
        wheel=WheelTable(profile="cone-1-20"),
        wheelset=WheelsetTable(nominal_radius=(460.1, 459.9)),
    )
    found = geometry.conicity(lay_out_wheelset(file), file, Watch(), alike=False)
    assert found.attrs["conicity"] == pytest.approx(0.05, rel=0.03)  # the roll adds 1 to 2 %
    assert found.near.values[0] == pytest.approx(-2.5)
    assert found.attrs["conicity_reason"] == ""


@pytest.fixture(scope="module")
def dataset():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contacts, "contact_at", fake)
        return compute.compute_shifts(FILE, "text of the file")


def test_the_dataset_has_what_the_contacts_have(dataset):
    assert dataset.p_max.dims == ("shift", "side", "ics")
    assert list(dataset.ics.values) == ["A", "Bhat", "C"]
    assert dataset.attrs["alike"] == 0
    for shift, share in SHARES.items():
        left = dataset.p_max.sel(shift=shift, side="left", ics="A").item()
        assert left == pytest.approx(1000 * (1 + share), rel=1e-12)
    assert np.isfinite(dataset.p_max.sel(ics="C")).sum() == 1
    # the cone: left minus right is 2 tan(gamma) times the shift of the axle, nearly
    np.testing.assert_allclose(dataset.rrd, 2 / 20 * dataset.axle_shift, rtol=0.1, atol=1e-9)
    assert dataset.attrs["conicity"] == pytest.approx(0.05, rel=0.1)


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
    assert text.startswith("The largest pressure is 1000 MPa with B̂, at -2 mm, left wheel, ")
    assert "18 degrees" in text
    assert f"at 0.5 mm is {dataset.attrs['conicity']:.3f}." in text
    assert "at 0.5 mm is –." in page.summary(dataset.assign_attrs(conicity=np.nan))


def with_planar(dataset, share):
    """Return the dataset with planar contacts whose p_max differs by a share from that with A."""
    planar = dataset.sel(ics=["A"]).assign_coords(ics=["planar"])
    planar["p_max"] = planar.p_max * (1 + share)
    return xr.concat([dataset, planar], "ics", data_vars="minimal")


def test_planar_contact_is_compared_and_never_a_reference(dataset):
    planar = with_planar(dataset, -0.5)
    assert compared_ics(planar)[-1] == "planar"
    assert "planar" not in reference_names(planar).values
    rows = read_texts(page.answer_table(planar))
    assert rows["planar"][:3] == ["no shift"] * 3
    assert rows["planar"][-1] == f"{MINUS}53.50"
    assert page.answer_table(planar.sel(ics=["A", "planar"])).rows[0].name == "planar"


def test_limits_may_hold_at_all_shifts(dataset):
    same = dataset.copy(deep=True)
    same["p_max"] = same.p_max * 0 + 1000
    row = page.answer_table(same).rows[0]
    assert [cell.text for cell in row.filled[:3]] == ["all shifts"] * 3


def test_the_answer_table_has_the_numbers_of_the_dataset(dataset):
    table = page.answer_table(dataset)
    cells = read_texts(table)
    assert cells["A"] == [
        "-2 to -1 mm",
        "-2 to 0 mm",
        "-2 to 1 mm",
        "1200",
        "1000",
        "+20.00",
    ]
    assert cells["B̂"][-1] == "0.00"
    assert table.rows[0].filled[-1].below == "2 mm, left"


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
    file = FILE.model_copy(update={"shifts": (1.0,)})
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


def test_the_page_is_written_with_everything_left_out(dataset, tmp_path):
    with_refusal = dataset.assign_attrs(
        refused=json.dumps({"8": "the left wheel climbs its rail", "1, left": "no"})
    )
    path = page.write_shifts(with_refusal, tmp_path)
    text = path.read_text()
    assert "the left wheel climbs its rail" in text
    assert "a remark" in text
    assert "8 mm: the left wheel climbs its rail" in text
    assert (tmp_path / "shifts.nc").is_file()


def test_page_dataset_and_progress_say_which_values_were_assumed(dataset, tmp_path):
    """The right wheel has nu of its own; of the track nothing is given."""
    used = json.loads(dataset.attrs["values"])
    assert used["right_wheel.nu"]["value"] == 0.3
    assert used["right_wheel.nu"]["origin"] == "given"
    assert (used["track.gauge"]["value"], used["track.gauge"]["origin"]) == (1435.0, "assumed")
    assert (used["wheel.flange_back"]["value"], used["wheel.flange_back"]["origin"]) == (
        pytest.approx(-70.0),
        "from the profile",
    )
    assert used["rolling"]["value"] == "none: contacts without friction"
    assert "rail.tolerance" not in used  # a profile of the package has none
    (said,) = json.loads(dataset.attrs["doubts"])
    assert "track.gauge = 1435 mm, " in said
    assert "wheelset.nominal_radius = 460 mm, " in said
    assert "right_wheel.nu" not in said
    text = page.write_shifts(dataset, tmp_path).read_text()
    assert said in text
    rows = read_texts(page.values_table(dataset))
    assert rows["track.rail_inclination"][:2] == ["0.025", "assumed"]
    assert rows["contact.ics"][:2] == ["A, Bhat", "given"]
    assert "contact.c_above_deg" in text


def test_all_that_is_given_is_not_said_to_be_assumed():
    file = FILE.model_copy(update={"track": TrackTable(gauge=1435.0)})
    text = values.assumed_text(values.values_used(file, lay_out_wheelset(file)))
    assert "track.gauge =" not in text
    assert "track.gauge_depth = 14 mm" in text


def measured(folder, comment="", **tables):
    """A specification of a rail from a file, on a wheel of the package."""
    outline = standard("60E1").outline
    points = outline.position(np.linspace(0, outline.length, 200)).T
    lines = "".join(f"{y:.6f} {z:.6f}\n" for y, z in points)
    (folder / "rail.txt").write_text(f"# {comment}\n{lines}")
    rail = {"profile": "rail.txt", "axes": "field up"}
    table = {"shifts": [0.0], "rail": rail, "wheel": {"profile": "S1002"}, **tables}
    return parse_specification(table, folder / "mine.toml")


TRACK = {"gauge": 1435.0, "rail_inclination": 0.05}
WHEELSET = {"flange_back_distance": 1360.0, "nominal_radius": 460.0}


def test_the_track_of_a_measured_profile_is_asked_for_before_any_work(tmp_path):
    file = measured(tmp_path, track={"rail_inclination": 0.0}, wheelset=WHEELSET)
    with pytest.raises(WrongInput, match=r"^rail\.profile is a file, .*give track\.gauge = 1435, or what"):
        compute.compute_shifts(file)
    values.require_track(measured(tmp_path, track=TRACK, wheelset=WHEELSET))
    values.require_track(FILE)
    wheel = {"rail": FILE.rail, "wheel": FILE.wheel.model_copy(update={"profile": "wheel.txt"})}
    values.require_track(FILE.model_copy(update=wheel))  # its rail lies as in its standard


def test_a_rail_that_its_file_calls_canted_is_not_turned_once_more_without_a_word(tmp_path):
    file = measured(tmp_path, "points - already canted", track=TRACK, wheelset=WHEELSET)
    (said,) = values.canted_rails(file)
    assert said.startswith('rail, rail.txt: its file says "# points - already canted", and ')
    assert "track.rail_inclination = 0.05 turns it once more" in said
    assert values.canted_rails(measured(tmp_path, track=TRACK)) == ()
    inclined = measured(tmp_path, "already canted", track={"rail_inclination": 0.0})
    assert values.canted_rails(inclined) == ()


def test_finished_contacts_are_kept_and_failures_are_told(tmp_path, monkeypatch):
    """A second run takes the first contacts from the store, and solves the one that was interrupted."""
    solved, said = [], []

    def interrupted(where, *rest):
        solved.append((where.position.given_shift, where.side))
        if len(solved) == 3:
            raise KeyboardInterrupt
        if where.position.given_shift == 1.0 and where.side == "right":
            raise Failure("not found")
        return fake(where, *rest)

    monkeypatch.setattr(contacts, "contact_at", interrupted)
    file = FILE.model_copy(update={"shifts": (0.0, 1.0)})
    options = RunOptions(1, Store(tmp_path), Watch(on_stage=said.append))
    with pytest.raises(KeyboardInterrupt):
        compute.compute_shifts(file, "", options)
    result = compute.compute_shifts(file, "", options)
    assert solved == [(0.0, "left"), (0.0, "right"), (1.0, "left"), (1.0, "left"), (1.0, "right")]
    assert sum("stored by an earlier run" in text for text in said) == 2
    assert json.loads(result.attrs["refused"]) == {"1, right": "not found"}
    assert np.isnan(result.p_max.sel(shift=1.0, side="right")).all()
    assert np.isfinite(result.p_max.sel(shift=1.0, side="left", ics="A"))


def test_alike_sides_are_solved_once(monkeypatch):
    solved = []

    def counted(where, *rest):
        solved.append((where.position.given_shift, where.side))
        return fake(where, *rest)

    monkeypatch.setattr(contacts, "contact_at", counted)
    result = compute.compute_shifts(FILE.model_copy(update={"right_wheel": None, "shifts": (-1.0, 0.0, 1.0)}))
    assert solved == [(-1.0, "left"), (-1.0, "right"), (0.0, "left")]
    mirrored = result.p_max.sel(shift=[1.0, 0.0, -1.0], side="right").values
    np.testing.assert_array_equal(result.p_max.sel(side="left").values, mirrored)
    # outlines are told from the top of each rail: those of alike sides are the same
    one, other = (
        result.outline_s.sel(shift=shift, side=side, ics="A").values
        for shift, side in ((1.0, "left"), (-1.0, "right"))
    )
    np.testing.assert_allclose(one, other, rtol=0, atol=2e-2)


def standing_below(limit):
    """The positions of wheelsets, of which there are none at larger shifts."""
    settle_all = compute.settle

    def settled(layout, shift, **keys):
        if abs(shift) > limit:
            raise Failure("the wheel stands on the tip of its flange")
        return settle_all(layout, shift, **keys)

    return settled


def test_shifts_at_which_nothing_stands_are_refused(monkeypatch):
    monkeypatch.setattr(compute, "settle", standing_below(10.0))
    with pytest.raises(Failure, match="none is possible"):
        compute.compute_shifts(replace_shifts(FILE, (40.0,)))


def replace_shifts(file, shifts):
    return file.model_copy(update={"shifts": shifts})
