"""Scenes with several kinds of results, some of which fail."""

import numpy as np
import xarray as xr

from compare.campaigns import tasks
from compare.campaigns.tasks import TaskReport
from femic.cache.store import Store
from geometries.errors import Failure
from tests.compare.campaigns.campaigns import LIGHT, light, register

BOTH = 'keep = ["errors", "advice"]' + LIGHT


def test_failed_kind_of_results_leaves_the_others(sweep, monkeypatch):
    """The first scenes in the order are among those that fail."""

    def not_below_six(scene, _means):
        e = scene.bodies["lower"].material.E
        if e < 6:
            raise Failure(f"{e:g} is too soft")
        return xr.Dataset({"hard": ((), e)})

    register(monkeypatch, errors=light, advice=not_below_six)
    done, dataset = sweep(BOTH)
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


def test_kinds_that_fail_alike_give_one_message(sweep, monkeypatch):
    register(monkeypatch, errors=light, advice=light)
    _, dataset = sweep(BOTH)
    assert set(dataset.failure.sel(E=7).values) == {"seven"}


def test_model_that_kills_workers_leaves_stored_results(sweep, tmp_path, monkeypatch):
    def killed(*_):
        return TaskReport("its worker died 4 times")

    register(monkeypatch, errors=light, advice=light)
    sweep(folder=tmp_path / "first", store=Store(tmp_path / "store"))
    monkeypatch.setattr(tasks, "list_models", killed)
    done, dataset = sweep(BOTH)
    assert done.failed == 27
    assert set(dataset.failure.values.ravel()) == {"its worker died 4 times"}
    np.testing.assert_array_equal(dataset["sum"].sel(E=5), 5 + dataset.nu)
    assert not dataset.digest.any()  # it is tried again
