"""Finished results with friction are stored: a second run and other scenes use them."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
import xarray as xr

from femic.cache.store import Store
from femic.contact.motions import MOTIONS
from femic.reference.run_options import RunOptions
from femic.results.friction import compute_with_friction
from tests.femic.contact.wheel_on_rail import REFERENCE_ICS, bhat_as_c, scene

ROLLING = {"motion": "rolling", "loads": [200.0], "friction": [0.2, 0.5], "longitudinal": [0.0, 1e-3]}
COMPRESSION = {"motion": "compression", "loads": [100.0, 200.0], "friction": [0.2, 0.5]}
COSTS = ["seconds"]


@pytest.fixture
def solved(monkeypatch):
    """By which friction and ICs parts were solved, in their order; raises at those in `interrupted`.

    Solutions are one number each: which ones are solved does not depend on what they are.
    """
    of = SimpleNamespace(calls=[], interrupted=set())

    def solve(_, *case):
        if case in of.interrupted:
            raise KeyboardInterrupt
        of.calls.append(case)
        return xr.Dataset({"number": ((), hash(case) % 1000), "seconds": ((), 1.0)})

    for name, motion in MOTIONS.items():
        alone = replace(motion, solve=solve, complete=lambda dataset, _: dataset)
        monkeypatch.setitem(MOTIONS, name, alone)
    return of


def same(first, second):
    """Equal in everything but what it took."""
    attributes = [{k: v for k, v in one.attrs.items() if k not in COSTS} for one in (first, second)]
    assert attributes[0] == attributes[1]
    xr.testing.assert_equal(first.drop_vars(COSTS), second.drop_vars(COSTS))


def test_interrupted_run_resumes_after_finished_solutions(solved, tmp_path):
    calls, interrupted = solved.calls, solved.interrupted
    of, options = scene(13.0, **COMPRESSION), RunOptions(store=Store(tmp_path))
    interrupted.add((0.2, "Bhat"))
    with pytest.raises(KeyboardInterrupt):
        compute_with_friction(of, options)
    assert calls == [(0.2, "A"), (0.5, "A")]
    interrupted.clear()
    resumed = compute_with_friction(of, options)
    assert calls[2:] == [(0.2, "Bhat"), (0.5, "Bhat")]
    assert list(resumed.friction.values) == [0.2, 0.5]
    assert list(resumed.ics.values) == ["A", "Bhat"]
    same(resumed, compute_with_friction(of))


def test_scenes_share_equal_solutions_only(solved, tmp_path):
    options, calls = RunOptions(store=Store(tmp_path)), solved.calls
    alone = ROLLING | {"ics": ["A"], "friction": [0.2]}
    others = ROLLING, alone | {"longitudinal": [0.0, 2e-3]}, alone | {"loads": [220.0]}
    for keys in (alone, *others, alone | {"rolling_radius": 401.0}):
        compute_with_friction(scene(13.0, **keys), options)
    anew = (0.2, "A")
    assert calls == [anew, (0.5, "A"), (0.2, "Bhat"), (0.5, "Bhat"), *[anew] * 3]


def test_c_and_its_quality_are_taken_from_stored_curves(solved, tmp_path, monkeypatch):
    made, calls = [], solved.calls

    def of_c(*on_grid, **how):
        made.append(on_grid)
        return bhat_as_c()(*on_grid, **how)

    monkeypatch.setattr(REFERENCE_ICS, of_c)
    options = RunOptions(store=Store(tmp_path))
    of = scene(13.0, **ROLLING | {"ics": ["C"], "friction": [0.2]})
    first, again = compute_with_friction(of, options), compute_with_friction(of, options)
    assert (len(made), calls) == (1, [(0.2, "C")])
    assert again.attrs["C_estimate"] == 0.02
    same(first, again)
    tighter = scene(13.0, tolerance=0.02, **ROLLING | {"ics": ["C"], "friction": [0.2]})
    compute_with_friction(tighter, options)
    assert len(made) == 2
