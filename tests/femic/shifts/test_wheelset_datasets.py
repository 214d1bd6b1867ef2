"""Datasets of wheelsets: shifts, conicity, what was assumed, stored and mirrored contacts, given rolls."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from femic.cache.store import Store
from femic.reference.run_options import RunOptions, Watch
from femic.results import wheelset as compute
from femic.results import wheelset_contacts as geometry
from femic.shifts.sides import lay_out_wheelset
from femic.shifts.specification import (
    ContactTable,
    ProfileTable,
    RollingTable,
    ShiftsFile,
    TrackTable,
    WheelsetTable,
    WheelTable,
    parse_specification,
)
from geometries.errors import Failure, WrongInput
from geometries.profiles.standards import standard
from tests.femic.shifts.fakes import (
    ALONE,
    FILE,
    ROLLING,
    SHARES,
    changed,
    fake_contact,
    fake_roll,
    faked,
    known_dataset,
)

S1002 = ShiftsFile(
    shifts=(-2.0, 2.0),
    rail=ProfileTable(profile="60E1"),
    wheel=WheelTable(profile="S1002"),
    contact=ContactTable(ics=("A",)),
)


class Solved(list):
    """Places at which contacts were solved, in their order; at the number `stop` a run is interrupted."""

    stop = None

    def note(self, place):
        self.append(place)
        if len(self) == self.stop:
            raise KeyboardInterrupt

    def contact(self, where, *rest):
        """In the place of `contact_at`."""
        self.note((where.position.given_shift, where.side))
        return fake_contact(where, *rest)

    def roll(self, sides, *rest):
        """In the place of `roll`."""
        self.note(sides[0].place.position.given_shift)
        return fake_roll(sides, *rest)


def test_the_dataset_has_what_the_contacts_have():
    dataset = known_dataset()
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


def test_numbers_of_rolling_are_labelled_and_c_is_that_of_its_own_wheel():
    dataset = known_dataset(ROLLING)
    assert dataset.F_x.dims == ("shift", "side", "ics")
    assert dataset.xi_0.dims == ("shift", "ics")
    assert dataset.F_x.sel(shift=-2.0, side="right", ics="Bhat").item() == 10_000
    assert dataset.estimate_F_x.sel(shift=-2.0, side="right", ics="A").item() == 50
    assert np.isnan(dataset.estimate_xi.sel(shift=-2.0, side="right", ics="A"))
    with_c = dataset.sel(ics="C", shift=2.0)  # of the left wheel alone
    assert np.isfinite(with_c.F_x.sel(side="left"))
    assert np.isnan(with_c.F_x.sel(side="right"))


def test_the_dataset_says_which_values_were_assumed():
    """The right wheel has nu of its own; of the track nothing is given."""
    dataset = known_dataset()
    used = json.loads(dataset.attrs["values"])
    for name, value, origin in (
        ("right_wheel.nu", 0.3, "given"),
        ("track.gauge", 1435.0, "assumed"),
        ("wheel.flange_back", pytest.approx(-70.0), "from the profile"),
    ):
        assert (used[name]["value"], used[name]["origin"]) == (value, origin)
    assert used["rolling"]["value"] == "none: the contacts are frictionless"
    assert "rail.tolerance" not in used  # a profile of the package has none
    (said,) = json.loads(dataset.attrs["doubts"])
    assert "track.gauge = 1435 mm, " in said
    assert "wheelset.nominal_radius = 460 mm, " in said
    assert "right_wheel.nu" not in said
    file = changed(track=TrackTable(gauge=1435.0))
    text = compute.assumed_text(compute.values_used(file, lay_out_wheelset(file)))
    assert "track.gauge =" not in text
    assert "track.gauge_depth = 14 mm" in text


def standing_below(limit):
    """The positions of wheelsets, of which there are none at larger shifts."""
    settle_all = compute.settle

    def settled(layout, shift, **keys):
        if abs(shift) > limit:
            raise Failure("the wheel stands on the tip of its flange")
        return settle_all(layout, shift, **keys)

    return settled


def test_shifts_left_out_are_said_before_the_first_contact(monkeypatch):
    """A wheelset that stands nowhere at 12 mm; a contact that is not found is said in its place."""
    said = []
    monkeypatch.setattr(compute, "settle", standing_below(10.0))

    def contact_at(*_):
        raise Failure("no grid")

    file = changed(shifts=(0.0, 12.0), wheel=WheelTable(profile="S1002"), right_wheel=None)
    options = RunOptions(1, watch=Watch(on_stage=said.append))
    with faked(contact_at), pytest.raises(Failure, match="shifts: no contact was found: "):
        compute.compute_shifts(file, options=options)
    assert said[0].startswith("Assumed values that the specification does not give: ")
    assert said[1].startswith("shift 12 mm was skipped: ")
    assert said[2] == "shift 0 mm (1 of 1), left is left out: no grid"
    assert len(said[1]) > len("shift 12 mm was skipped: ")
    with pytest.raises(Failure, match="none of the shifts is possible"):
        compute.compute_shifts(changed(shifts=(40.0,)))


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
    with pytest.raises(
        WrongInput, match=r"^rail\.profile is a file, .*give track\.gauge = 1435, or the actual values"
    ):
        compute.compute_shifts(file)
    compute.require_track(measured(tmp_path, track=TRACK, wheelset=WHEELSET))
    compute.require_track(FILE)
    wheel = {"rail": FILE.rail, "wheel": FILE.wheel.model_copy(update={"profile": "wheel.txt"})}
    compute.require_track(changed(**wheel))  # its rail lies as in its standard


def test_a_rail_that_its_file_calls_canted_is_not_turned_once_more_without_a_word(tmp_path):
    file = measured(tmp_path, 'points - already "canted"', track=TRACK, wheelset=WHEELSET)
    (said,) = compute.canted_rails(file)
    assert said.startswith("The file rail.txt (key rail) says “points - already 'canted'”, but ")
    assert "track.rail_inclination = 0.05 inclines its points once more." in said
    assert compute.canted_rails(measured(tmp_path, track=TRACK)) == ()
    inclined = measured(tmp_path, "already canted", track={"rail_inclination": 0.0})
    assert compute.canted_rails(inclined) == ()


def test_what_is_unusual_about_a_position_and_the_least_modulus_are_in_the_dataset(monkeypatch):
    settle = compute.settle

    def noted(*arguments, **keys):
        return replace(settle(*arguments, **keys), notes=("the left wheel touches 0.4 mm beyond",))

    monkeypatch.setattr(compute, "settle", noted)
    with faked():
        dataset = compute.compute_shifts(
            changed(S1002, wheel=WheelTable(profile="S1002", E=100e3)), options=ALONE
        )
    assert json.loads(dataset.attrs["unusual"])["2"] == "the left wheel touches 0.4 mm beyond"
    assert dataset.attrs["E"] == 100e3


# ---- what is solved


def test_finished_contacts_are_kept_and_failures_are_told(tmp_path):
    """A second run takes the first contacts from the store, and solves the one that was interrupted."""
    solved, said = Solved(), []

    def contact_at(where, *rest):
        found = solved.contact(where, *rest)
        if solved[-1] == (1.0, "right"):
            raise Failure("not found")
        return found

    solved.stop = 3
    file, options = changed(shifts=(0.0, 1.0)), RunOptions(1, Store(tmp_path), Watch(on_stage=said.append))
    with faked(contact_at):
        with pytest.raises(KeyboardInterrupt):
            compute.compute_shifts(file, "", options)
        result = compute.compute_shifts(file, "", options)
    assert solved == [(0.0, "left"), (0.0, "right"), (1.0, "left"), (1.0, "left"), (1.0, "right")]
    assert sum("stored by an earlier run" in text for text in said) == 2
    assert json.loads(result.attrs["refused"]) == {"1, right": "not found"}
    assert np.isnan(result.p_max.sel(shift=1.0, side="right")).all()
    assert np.isfinite(result.p_max.sel(shift=1.0, side="left", ics="A"))


def test_finished_positions_are_kept(tmp_path):
    solved, said = Solved(), []
    solved.stop = 2
    options = RunOptions(1, Store(tmp_path), Watch(on_stage=said.append))
    with faked(roll=solved.roll):
        with pytest.raises(KeyboardInterrupt):
            compute.compute_shifts(ROLLING, "", options)
        result = compute.compute_shifts(ROLLING, "", options)
        assert solved == [-2.0, 0.0, 0.0, 1.0, 2.0]
        other = changed(ROLLING, rolling=RollingTable(friction=0.4, lateral=0.001))
        compute.compute_shifts(other, "", options)
    assert len(solved) == 9
    assert any("rolling: stored by an earlier run" in text for text in said)
    reasons = {f"1, {side}, rolling": "A: not today" for side in ("left", "right")}
    assert json.loads(result.attrs["not_rolling"]) == reasons


@pytest.mark.parametrize("rolls", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_processes_find_what_one_finds(tmp_path, monkeypatch, rolls):
    """Contacts and rolling wheelsets side by side: same numbers, in the same order, kept in the store."""
    monkeypatch.setattr(geometry, "conicity", lambda *_, **__: xr.Dataset())
    rolling = RollingTable(friction=0.3, longitudinal=-1e-3) if rolls else None
    contact = ContactTable(ics=("A",), planar=False, elements=8)
    file = changed(shifts=(0.0, 1.5) if rolls else (0.0,), contact=contact, rolling=rolling)
    said = {workers: [] for workers in (1, 2)}
    found = {
        workers: compute.compute_shifts(
            file,
            "",
            RunOptions(workers, Store(tmp_path / str(workers)), Watch(on_stage=said[workers].append)),
        )
        for workers in said
    }
    for name in ("p_max", "estimate_p_max", *(("F_x", "work", "estimate_F_y") if rolls else ())):
        assert np.isfinite(found[1][name]).all()
        np.testing.assert_array_equal(found[2][name], found[1][name])
    one, two = ([text.split(":")[0] for text in said[workers] if "shift " in text] for workers in said)
    assert one == two
    assert len(one) == (6 if rolls else 2)
    compute.compute_shifts(file, "", RunOptions(2, Store(tmp_path / "2"), Watch(on_stage=said[2].append)))
    assert sum("stored by an earlier run" in text for text in said[2]) == len(one)


def test_alike_sides_are_solved_once():
    solved = Solved()
    with faked(solved.contact):
        result = compute.compute_shifts(changed(right_wheel=None, shifts=(-1.0, 0.0, 1.0)), options=ALONE)
    assert solved == [(-1.0, "left"), (-1.0, "right"), (0.0, "left")]
    mirrored = result.p_max.sel(shift=[1.0, 0.0, -1.0], side="right").values
    np.testing.assert_array_equal(result.p_max.sel(side="left").values, mirrored)
    # outlines are told from the top of each rail: those of alike sides are the same
    one, other = (
        result.outline_s.sel(shift=shift, side=side, ics="A").values
        for shift, side in ((1.0, "left"), (-1.0, "right"))
    )
    np.testing.assert_allclose(one, other, rtol=0, atol=2e-2)


def test_alike_sides_roll_once_and_the_mirrored_wheelset_steers_to_the_other_side():
    solved = Solved()
    alike = changed(ROLLING, right_wheel=None, shifts=(-2.0, 0.0, 2.0))
    with faked(roll=solved.roll):
        dataset = compute.compute_shifts(alike, options=ALONE).sel(ics="Bhat")
        assert solved == [-2.0, 0.0]
        solved.clear()
        compute.compute_shifts(
            changed(alike, rolling=RollingTable(friction=0.4, lateral=0.001)), options=ALONE
        )
        assert solved == [-2.0, 0.0, 2.0]
    here, there = (dataset.sel(shift=shift) for shift in (2.0, -2.0))
    for name in ("F_x", "F_y", "estimate_F_x"):
        np.testing.assert_array_equal(here[name].values, there[name].values[::-1])
    for name, sign in (("steering", -1), ("xi_0", 1), ("estimate_xi_0", 1)):
        assert here[name].item() == sign * there[name].item(), name


def test_given_rolls_are_those_of_the_positions():
    """Each wheel touches at a height of its own; both shifts are solved, though sides are alike."""
    solved, rolls = Solved(), set()

    def contact_at(where, *rest):
        rolls.add(where.position.roll)
        return solved.contact(where, *rest)

    with faked(contact_at):
        given = compute.compute_shifts(changed(S1002, rolls=(1.5, 1.5)), options=ALONE)
        np.testing.assert_allclose(given["roll"], 1.5)
        assert len(set(solved)) == 4
        assert rolls == {0.0015}
        solved.clear()
        compute.compute_shifts(changed(S1002, rolls=(-1.5, 1.5)), options=ALONE)
        assert len(solved) == 2  # the other two are mirror images


def test_a_roll_for_each_shift_or_none(tmp_path):
    table = {
        "shifts": [0.0, 1.0],
        "rolls": [1.0],
        "rail": {"profile": "60E1"},
        "wheel": {"profile": "S1002"},
    }
    with pytest.raises(WrongInput, match="rolls: 1 given for 2 shifts; give one for each shift"):
        parse_specification(table, tmp_path / "mine.toml")
    for roll in (150.0, "much"):
        with pytest.raises(WrongInput, match="rolls"):
            parse_specification(table | {"shifts": [0.0], "rolls": [roll]}, tmp_path / "mine.toml")
