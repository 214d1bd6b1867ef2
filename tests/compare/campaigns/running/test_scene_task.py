"""Scenes as tasks: the keys of their results in the store."""

import pytest

from compare.campaigns.tasks import campaign_tasks, scene_task
from femic.cache.store import Store
from tests.compare.campaigns.campaigns import OF_UPPER, campaign_in


def test_check_with_the_other_engine_is_left_out(tmp_path):
    campaign = campaign_in(tmp_path, OF_UPPER.replace("check = false", "check = true"))
    ((_, task), *_) = campaign_tasks(campaign, Store(tmp_path))
    assert campaign.scene(campaign.point(0)).check is not None
    assert task.scene.check is None


def test_key_depends_on_table_and_kind_of_results(tmp_path):
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
def test_key_depends_on_the_contents_of_files(tmp_path, named):
    store, file = Store(tmp_path / "store"), tmp_path / "file.txt"
    file.write_text("1 2\n", encoding="utf-8")
    before = key_of(named(str(file)), store)
    assert key_of(named(str(file)), store) == before
    file.write_text("1 3\n", encoding="utf-8")
    assert key_of(named(str(file)), store) != before


def key_of(table, store):
    return scene_task(table, ("errors",), store).keys["errors"]
