"""Campaigns: nothing finished is lost, nothing is done twice, one failure does not stop the others."""

import numpy as np
import pytest
import xarray as xr

from compare.ics.compute import compute
from femic.cache.store import Store
from femic.campaigns import compute as computing
from femic.campaigns import kept, tasks
from femic.campaigns import plan as planning
from femic.campaigns.compute import Options, compute_sweep, impossible, require_computable
from femic.campaigns.dataset import Collected
from femic.campaigns.keeping import KEEPERS, Keeper
from femic.campaigns.opened import open_sweep
from femic.campaigns.plan import planned
from femic.campaigns.tasks import Receipt, scene_task
from femic.reference.run_options import RunOptions
from femic.scenes.errors import BadScene
from geometries.errors import Failure
from tests.femic.campaigns.campaigns import (
    CELLS_OF_PATCHES,
    LIGHT,
    OF_UPPER,
    campaign_in,
    errors_of,
    light,
    of_parts,
    swept,
)

OF_THE_RUN = ["seconds", "model_seconds", "ic_seconds", "digest", "checksum"]


# --- real scenes -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def real(client, tmp_path_factory):
    """A campaign of two scenes that share the lower body, its folder, the end, and its dataset."""
    folder = tmp_path_factory.mktemp("real")
    campaign = campaign_in(folder, OF_UPPER)
    return campaign, folder, *swept(campaign, folder, client)


def test_results_are_those_of_single_runs_to_the_last_digit(real):
    campaign, folder, _, dataset = real
    assert campaign.order[-1] == 1
    scene = campaign.scene((12.0,))
    store = Store(folder / "alone")
    results = compute(scene, RunOptions(2, store))
    alone = errors_of(results)
    of_campaign = dataset.sel(R=12)
    for name in ("error", "rms", "weight", "estimate_refinement", "vanishes"):
        expected = alone[name].transpose(*of_campaign[name].dims)
        np.testing.assert_array_equal(of_campaign[name], expected)
    assert of_campaign.error.isnull().any()  # components that the scene does not ask for
    assert of_campaign.unknowns == max(cost.unknowns for cost in results.models.values())
    assert float(of_campaign.error.sel(variant="C", i="n", j="n").max()) > 0


def test_models_that_scenes_share_are_solved_once(real):
    _, _, done, _ = real
    assert (done.scenes, done.finished, done.failed, done.found) == (2, 2, 0, 0)
    assert done.models == 3  # the lower body, and two upper ones
    assert done.models_found == 4  # both of each scene


def test_a_campaign_in_the_same_store_begins_with_what_is_there(real, client, tmp_path):
    """Another scene, the same bodies: nothing but approximations is left to do."""
    _, folder, _, dataset = real
    other = campaign_in(
        tmp_path, OF_UPPER.replace('"A", "Bhat"', '"A", "B"').replace("[11.0, 12.0]", "[12.0]")
    )
    done, found = swept(other, tmp_path, client, store=Store(folder / "store"))
    assert (done.models, done.found) == (0, 0)
    same = {"variant": ["A", "C"]}
    xr.testing.assert_equal(
        found.drop_vars(OF_THE_RUN).sel(same).isel(R=0), dataset.drop_vars(OF_THE_RUN).sel(same).sel(R=12)
    )
    again = campaign_in(tmp_path, OF_UPPER.replace("[sweep.R]", "[sweep.other]"), "third")
    done, found = swept(again, tmp_path / "third", client, store=Store(folder / "store"))
    assert (done.models, done.found) == (0, 2)
    xr.testing.assert_equal(found.rename(other="R"), dataset)


def test_the_plan_counts_models_and_what_is_kept(real, tmp_path):
    campaign, folder, _, _ = real
    plan = planned(campaign, Store(tmp_path))
    assert (plan.scenes, plan.found, plan.models) == (2, 0, 3)
    assert plan.seconds > 0
    assert 200 < plan.memory < 1000
    plan = planned(campaign, Store(folder / "store"))
    assert (plan.scenes, plan.found, plan.models) == (2, 2, 0)


def test_models_are_counted_for_a_while_only(real, tmp_path, monkeypatch):
    """Those of contact on grids of its own take seconds a scene; at least those of one scene are."""
    monkeypatch.setattr(planning, "LONGEST", 0.0)
    plan = planned(real[0], Store(tmp_path))
    assert (plan.counted, plan.models) == (1, 2)


# --- tasks and what they leave -----------------------------------------------------------------------


@pytest.mark.usefixtures("light_scenes")
def test_the_dataset_has_the_swept_keys_as_dims(client, tmp_path):
    done, dataset = swept(campaign_in(tmp_path, LIGHT), tmp_path, client)
    assert dict(dataset.sizes) == {"E": 9, "nu": 3, "power": 2}
    ok = dataset.sel(E=[1, 2, 3, 4, 5, 6, 8, 9])
    np.testing.assert_array_equal(ok["sum"], (ok.E + ok.nu).transpose("E", "nu"))
    np.testing.assert_array_equal(ok.powers.sel(power="two"), (ok.E**2 + 0 * ok.nu))
    assert dataset["sum"].attrs["units"] == "1"
    assert done.finished == 27


@pytest.mark.usefixtures("light_scenes")
def test_a_failed_scene_is_recorded_and_the_others_go_on(client, tmp_path):
    done, dataset = swept(campaign_in(tmp_path, LIGHT), tmp_path, client)
    assert done.failed == 3
    assert np.all(dataset.failure.sel(E=7) == "seven")
    assert np.all(np.isnan(dataset["sum"].sel(E=7)))
    assert np.sum(dataset.failure.values != "") == 3
    assert np.all(dataset.seconds >= 0)


def test_a_second_run_computes_nothing_not_even_failures(light_scenes, client, tmp_path):
    campaign = campaign_in(tmp_path, LIGHT)
    _, first = swept(campaign, tmp_path, client)
    assert len(light_scenes) == 27

    def no_cluster(_):
        raise AssertionError("a cluster was started")

    done = compute_sweep(Collected(campaign, tmp_path), Store(tmp_path / "store"), no_cluster)
    assert (len(light_scenes), done.found, done.failed) == (27, 27, 3)
    xr.testing.assert_identical(open_sweep(tmp_path), first)


def test_failures_are_tried_again_when_asked(light_scenes, client, tmp_path):
    campaign = campaign_in(tmp_path, LIGHT)
    swept(campaign, tmp_path, client)
    del light_scenes[:]
    done, _ = swept(campaign, tmp_path, client, Options(retry=True))
    assert sorted(light_scenes) == [(7, 0.1), (7, 0.2), (7, 0.3)]
    assert (done.found, done.failed) == (24, 3)


@pytest.mark.usefixtures("light_scenes")
def test_errors_of_the_program_are_recorded_but_tried_again(client, tmp_path, monkeypatch):
    campaign = campaign_in(tmp_path, LIGHT)
    monkeypatch.setattr(tasks, "KEEPERS", {"errors": Keeper(lambda *_: 1 / 0, lambda _: [])})
    _, dataset = swept(campaign, tmp_path, client)
    assert set(dataset.failure.values.ravel()) == {"ZeroDivisionError: division by zero"}
    monkeypatch.undo()
    assert len(kept.kept_keys(Store(tmp_path / "store"))) == 1  # the probe


def test_an_interrupted_campaign_goes_on(light_scenes, client, tmp_path):
    """What is finished is in the dataset, too."""
    campaign = campaign_in(tmp_path, LIGHT)

    def interrupt(progress):
        if progress.finished == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        swept(campaign, tmp_path, client, Options(interrupt))
    early = open_sweep(tmp_path)
    assert int(np.sum(early.seconds.notnull())) == 5
    done, dataset = swept(campaign, tmp_path, client)
    assert done.finished == 27
    assert done.found >= 5
    assert len(light_scenes) - len(set(light_scenes)) == 0  # none was computed twice
    seen = early.seconds.notnull() & (early.failure == "")
    np.testing.assert_array_equal(dataset["sum"].values[seen], early["sum"].values[seen])


def test_more_values_take_only_what_is_new(light_scenes, client, tmp_path):
    swept(campaign_in(tmp_path, LIGHT), tmp_path, client)
    del light_scenes[:]
    more = campaign_in(tmp_path, LIGHT.replace("[0.1, 0.2, 0.3]", "[0.1, 0.15, 0.2, 0.3]"))
    done, dataset = swept(more, tmp_path, client)
    assert {nu for _, nu in light_scenes} == {0.15}
    assert (done.found, dataset.sizes["nu"]) == (27, 4)


@pytest.mark.usefixtures("light_scenes")
def test_random_points_are_samples(client, tmp_path):
    text = LIGHT.replace("count = 9", "").replace("values = [0.1, 0.2, 0.3]", "from = 0.1\nto = 0.3")
    campaign = campaign_in(tmp_path, 'points = "random"\nsamples = 6\n' + text)
    _, dataset = swept(campaign, tmp_path, client)
    assert dict(dataset.sizes) == {"sample": 6, "power": 2}
    np.testing.assert_array_equal(np.column_stack([dataset.E, dataset.nu]), campaign.listed)
    np.testing.assert_array_equal(dataset["sum"], dataset.E + dataset.nu)


def test_scenes_come_in_the_order_of_the_campaign(light_scenes, client, tmp_path):
    campaign = campaign_in(tmp_path, LIGHT)
    swept(campaign, tmp_path, client)
    assert set(light_scenes[:9]) == {(e, nu) for e in (1, 5, 9) for nu in (0.1, 0.2, 0.3)}


@pytest.mark.usefixtures("light_scenes")
def test_no_more_than_a_window_is_with_the_scheduler(client, tmp_path, monkeypatch):
    with_scheduler = []
    finish = computing._Run._finish_scene

    def counted(run, *rest):
        with_scheduler.append(len(run.scenes) + 1)
        finish(run, *rest)

    monkeypatch.setattr(computing._Run, "_finish_scene", counted)
    swept(campaign_in(tmp_path, LIGHT), tmp_path, client)
    assert max(with_scheduler) == computing.SCENES_PER_WORKER


@pytest.mark.usefixtures("light_scenes")
def test_a_scene_of_another_shape_has_failed(client, tmp_path, monkeypatch):
    def longer(scene, _means):
        n = 3 if scene.bodies["lower"].material.E == 3 else 2
        return xr.Dataset({"y": ("k", np.ones(n))}, coords={"k": np.arange(n)})

    monkeypatch.setattr(tasks, "KEEPERS", {"errors": Keeper(longer, lambda _: [])})
    done, dataset = swept(campaign_in(tmp_path, LIGHT), tmp_path, client)
    assert done.failed == 3
    assert "other shapes than those of scenes before: y has {'k': 3}" in str(
        dataset.failure.sel(E=3)[0].item()
    )


@pytest.mark.usefixtures("light_scenes")
def test_labels_that_differ_are_numbered(client, tmp_path, monkeypatch):
    def named(scene, _means):
        return xr.Dataset(
            {"y": (("line", "k"), np.ones((1, 2)))},
            coords={"line": [f"s = {scene.bodies['lower'].material.E:g} mm"], "k": ["a", "b"]},
        )

    monkeypatch.setattr(tasks, "KEEPERS", {"errors": Keeper(named, lambda _: [])})
    _, dataset = swept(campaign_in(tmp_path, LIGHT), tmp_path, client)
    assert list(dataset.line.values) == ["line 0"]
    assert list(dataset.k.values) == ["a", "b"]


@pytest.mark.parametrize("name", ["seconds", "variant", "digest", "checksum", "sample"])
def test_an_axis_may_not_have_the_name_of_a_result(tmp_path, name):
    """That is said before any work."""
    campaign = campaign_in(tmp_path, LIGHT.replace("[sweep.nu]", f"[sweep.{name}]"))
    with pytest.raises(BadScene, match=rf"sweep\.{name}: .*rename the axis"):
        require_computable(campaign)


@pytest.mark.parametrize("value", ["0.5", "'soft'", "-0.2", "1e29"])
def test_a_value_in_the_middle_is_said_before_any_work(tmp_path, value):
    """Of either axis; that it is of one axis only does not matter."""
    middle = LIGHT.replace("0.1, 0.2, 0.3", f"0.1, {value}, 0.3")
    with pytest.raises(BadScene, match=r"(?s)mine: 1 error\(s\)\n  at E=1,nu=.*upper\.nu = "):
        require_computable(campaign_in(tmp_path, middle))
    require_computable(campaign_in(tmp_path, LIGHT))


def test_something_that_only_a_scene_in_the_middle_lacks_is_said_before_any_work(tmp_path):
    loads = "[sweep.forces]\nkeys = ['contact.loads']\nvalues = [[1e3], [], [2e3]]\n"
    campaign = campaign_in(tmp_path, 'keep = ["contact"]\n' + OF_UPPER + loads)
    with pytest.raises(BadScene, match=r"at R=11,forces=\[\]: \[contact\]: give loads"):
        require_computable(campaign)


def test_combinations_that_are_impossible_are_told_and_do_not_stop_the_others(tmp_path):
    campaign = campaign_in(tmp_path, CELLS_OF_PATCHES)
    require_computable(campaign)
    (told,) = impossible(campaign)
    assert told.startswith("at cell=0.2,b=0.1: ")
    assert "engine.smallest_cell = 0.2: at most 0.1" in told
    assert not impossible(campaign_in(tmp_path, OF_UPPER))


def test_the_check_by_the_other_engine_is_left_out(tmp_path):
    """It would take minutes for every scene."""
    campaign = campaign_in(tmp_path, OF_UPPER.replace("check = false", "check = true"))
    ((_, task), *_) = computing.tasks_of(campaign, Store(tmp_path))
    assert campaign.scene(campaign.point(0)).check is not None
    assert task.scene.check is None


def test_what_is_kept_is_known_by_all_that_determines_it(tmp_path):
    table, store = {"lower": {"E": 1.0}, "upper": {"E": 1}}, Store(tmp_path)
    key = key_of(table, store)
    assert key_of(dict(table), store) == key
    assert scene_task(table, ("ics",), store).keys["ics"] != key
    assert key_of(table | {"upper": {"E": 2}}, store) != key


@pytest.mark.parametrize(
    "named",
    [
        lambda file: {"lower": {"contour": {"kind": "points", "file": file}}},
        lambda file: {"upper": {"contour": {"kind": "points", "file": file}}},
        lambda file: {"contact": {"extra_gap": file}},
        lambda file: {"contact": {"ics": ["A", f"map:{file}"]}},
    ],
)
def test_what_is_in_files_counts(tmp_path, named):
    store, file = Store(tmp_path / "store"), tmp_path / "file.txt"
    file.write_text("1 2\n", encoding="utf-8")
    before = key_of(named(str(file)), store)
    assert key_of(named(str(file)), store) == before
    file.write_text("1 3\n", encoding="utf-8")
    assert key_of(named(str(file)), store) != before


def key_of(table, store):
    return scene_task(table, ("errors",), store).keys["errors"]


# --- several parts of a scene ------------------------------------------------------------------------


def test_a_part_that_fails_leaves_the_others(client, tmp_path, monkeypatch):
    """The first scenes in the order are among those that fail."""

    def not_below_six(scene, _means):
        e = scene.bodies["lower"].material.E
        if e < 6:
            raise Failure(f"{e:g} is too soft")
        return xr.Dataset({"hard": ((), e)})

    of_parts(monkeypatch, errors=light, advice=not_below_six)
    campaign = campaign_in(tmp_path, 'keep = ["errors", "advice"]' + LIGHT)
    done, dataset = swept(campaign, tmp_path, client)
    assert done.failed == 18  # 1 ... 5, and 7
    soft, both = dataset.sel(E=2), dataset.sel(E=8)
    assert set(soft.failure.values) == {"advice: 2 is too soft"}
    assert set(dataset.failure.sel(E=7).values) == {"errors: seven"}
    assert soft.hard.isnull().all()
    assert dataset["sum"].sel(E=7).isnull().all()
    np.testing.assert_array_equal(soft["sum"], 2 + soft.nu)
    np.testing.assert_array_equal(dataset.hard.sel(E=7), 7)
    np.testing.assert_array_equal(both.hard, 8)
    assert set(both.failure.values) == {""}


def test_parts_that_fail_alike_say_so_once(client, tmp_path, monkeypatch):
    of_parts(monkeypatch, errors=light, advice=light)
    campaign = campaign_in(tmp_path, 'keep = ["errors", "advice"]' + LIGHT)
    _, dataset = swept(campaign, tmp_path, client)
    assert set(dataset.failure.sel(E=7).values) == {"seven"}


def test_a_model_that_kills_workers_leaves_what_needs_none(client, tmp_path, monkeypatch):
    def killed(*_):
        return Receipt("its worker died 4 times")

    of_parts(monkeypatch, errors=light, advice=light)
    campaign = campaign_in(tmp_path, 'keep = ["errors", "advice"]' + LIGHT)
    swept(campaign_in(tmp_path, LIGHT), tmp_path / "first", client, store=Store(tmp_path / "store"))
    monkeypatch.setattr(computing, "find_models", killed)
    done, dataset = swept(campaign, tmp_path, client)
    assert done.failed == 27
    assert set(dataset.failure.values.ravel()) == {"its worker died 4 times"}
    np.testing.assert_array_equal(dataset["sum"].sel(E=5), 5 + dataset.nu)
    assert not dataset.digest.any()  # it is tried again


def test_names_of_contacts_are_those_of_nothing_else():
    """Parts of a scene are one dataset."""
    others = [keeper.names for keep, keeper in KEEPERS.items() if keep != "contact"]
    assert not any(KEEPERS["contact"].names & names for names in others)
