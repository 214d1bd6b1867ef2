"""The store: nothing finished is lost, nothing damaged is believed."""

import errno
import os
import random
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from femic.cache.digests import code_digest
from femic.cache.store import Store
from femic.reference.engines import HARMONIC
from femic.reference.harmonic import engine
from femic.reference.harmonic.elimination import LARGEST_BATCH
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.refinement import solve_models
from femic.reference.run_options import RunOptions
from tests.femic.reference.small_model import TASK

ENTRY = xr.Dataset({"u": (("i",), np.arange(5.0))})


@pytest.fixture(params=["folder", "memory"])
def store(request, tmp_path):
    location = tmp_path if request.param == "folder" else f"memory://{tmp_path.name}-{time.time_ns()}"
    return Store(location)


def files(folder):
    return sorted(path for path in Path(folder).rglob("*") if path.is_file())


# --- entries and parts -------------------------------------------------------------------------------


def test_what_is_put_is_got(store):
    key = store.key("kind", 1.5, "request")
    assert store.get(key) is None
    store.put(key, ENTRY)
    xr.testing.assert_identical(store.get(key), ENTRY)


@pytest.mark.parametrize(
    "entry",
    [
        xr.Dataset(
            {
                "real": (("i", "name"), np.arange(6.0).reshape(3, 2), {"units": "mm", "ends": [1.5, -2.5]}),
                "whole": (("i",), np.array([-1, 2, 30000]), {"count": 7}),
                "is_good": (("i",), np.array([True, False, True])),
                "number": np.nan,
                "none": (("empty",), np.zeros(0)),
            },
            coords={"name": ["A", "B̂"], "i": [0, 1, 4]},
            attrs={"title": "µ, ±", "none": "", "share": 0.1, "several": np.arange(3)},
        ),
        xr.Dataset({"large": (("i",), np.array([2**40]))}),
        xr.Dataset({"short": (("i",), np.arange(250, 256, dtype=np.uint8))}),
        xr.Dataset({"u": (("i",), np.arange(2.0))}, attrs={"words": ["one", "two"]}),
        xr.Dataset({"u": (("i",), np.zeros(2_100_000))}),
    ],
    ids=["all kinds", "64 bits", "8 bits", "words", "large"],
)
def test_entries_of_all_kinds_come_back_as_they_were(tmp_path, entry):
    """Also types, for which small files of the older form have no place."""
    store = Store(tmp_path)
    store.put("key", entry)
    found = store.get("key")
    xr.testing.assert_identical(found, entry)
    assert list(found.data_vars) == list(entry.data_vars)
    assert {name: found[name].dtype for name in found.variables} == {
        name: entry[name].dtype for name in entry.variables
    }
    for name, value in entry.attrs.items():
        assert np.asarray(found.attrs[name]).dtype == np.asarray(value).dtype, name
    assert all(variable.dtype.isnative for variable in found.variables.values())


def test_keys_depend_on_all_that_determines_a_result_and_on_nothing_else():
    """Lines along x do not determine the responses."""
    asked = TASK.request

    def key(**changes):
        return Store().key("harmonic", *engine.HarmonicRequest(**vars(asked) | changes).determined_by)

    longer = type(asked.points)(2 * asked.points.x, asked.points.s)
    assert key() == key(points=longer) == Store("elsewhere").key("harmonic", *asked.determined_by)
    assert key() != Store().key("solid", *asked.determined_by)
    for change in ({"accuracy": 2e-9}, {"cells": asked.cells.scaled(2)}, {"loads": asked.loads[:1]}):
        assert key() != key(**change)


def test_parts_are_there_until_the_entry_is(store):
    key = store.key("kind")
    store.put_part(key, "k0.5", {"responses": np.eye(3), "residual": np.float64(1e-12)})
    part = store.part(key, "k0.5")
    np.testing.assert_array_equal(part["responses"], np.eye(3))
    assert part["residual"] == 1e-12
    assert store.part(key, "k0.25") is None
    store.put(key, ENTRY)
    assert store.part(key, "k0.5") is None


def test_without_a_location_nothing_is_kept():
    store = Store()
    store.put("key", ENTRY)
    store.put_part("key", "part", {"u": np.eye(2)})
    store.remove_other_code()
    assert store.get("key") is store.part("key", "part") is None


def test_models_of_other_code_are_deleted_and_nothing_else(tmp_path):
    for name in ("0123456789ab", "0123456789abc", "mine", code_digest()):
        (tmp_path / name).mkdir()
    Store(tmp_path).remove_other_code()
    assert {path.name for path in tmp_path.iterdir()} == {"0123456789abc", "mine", code_digest()}
    Store(tmp_path / "none").remove_other_code()
    assert not (tmp_path / "none").exists()


# --- what may go wrong ---------------------------------------------------------------------------------


@pytest.mark.parametrize("damage", ["cut", "changed", "empty"])
def test_damage_is_noticed_and_mended(tmp_path, damage, caplog):
    store, key = Store(tmp_path), Store().key("kind")
    store.put(key, ENTRY)
    (path,) = files(tmp_path)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes({"cut": content[:-100], "changed": content, "empty": b""}[damage])
    assert store.get(key) is None
    assert "damaged" in caplog.text
    store.put(key, ENTRY)
    xr.testing.assert_identical(store.get(key), ENTRY)
    assert len(files(tmp_path)) == 1


@pytest.mark.parametrize(
    ("put", "get"),
    [
        (lambda store, n: store.put(f"{n}", n * ENTRY), lambda store, n: store.get(f"{n}")),
        (
            lambda store, n: store.put_part("key", f"{n}", {"u": n * ENTRY.u.values}),
            lambda store, n: store.part("key", f"{n}"),
        ),
    ],
    ids=["entries", "parts"],
)
def test_exchanged_entries_are_not_read(tmp_path, put, get, caplog):
    """Its content is undamaged; it may be copied, moved, or come from other code."""
    store = Store(tmp_path)
    for n in (1, 2):
        put(store, n)
    one, other = files(tmp_path)
    one.write_bytes(other.read_bytes())
    assert get(store, 1) is None
    np.testing.assert_array_equal(get(store, 2)["u"], 2 * ENTRY.u)
    assert "a different entry" in caplog.text


def test_entries_of_other_code_are_not_read(tmp_path, monkeypatch):
    store = Store(tmp_path)
    monkeypatch.setattr("femic.cache.store.code_digest", lambda: "0123456789ab")
    store.put("key", ENTRY)
    monkeypatch.undo()
    (tmp_path / "0123456789ab").rename(tmp_path / code_digest())
    assert store.get("key") is None


def test_folders_and_files_in_the_place_of_entries_are_replaced(tmp_path, caplog):
    store, place = Store(tmp_path), tmp_path / code_digest()
    (place / "key.nc" / "in").mkdir(parents=True)
    (place / "others.parts").touch()
    assert store.get("key") is store.part("others", "part") is None
    assert store.part_names("others") == []
    assert caplog.text.count("computed again") == 2
    store.put("key", ENTRY)
    store.put_part("others", "part", {"u": np.eye(2)})
    assert store.writable
    xr.testing.assert_identical(store.get("key"), ENTRY)
    np.testing.assert_array_equal(store.part("others", "part")["u"], np.eye(2))


def test_unparsable_entries_are_logged_and_computed_again(tmp_path, caplog, monkeypatch):
    """Undamaged, and not what the library that reads it expects."""
    store = Store(tmp_path)
    monkeypatch.setattr("femic.cache.store.compact_netcdf", lambda _: b"no NetCDF")
    monkeypatch.setattr(np, "savez", lambda buffer, **_: buffer.write(b"no archive"))
    store.put("key", ENTRY)
    store.put_part("key", "part", {"u": np.eye(2)})
    assert store.get("key") is store.part("key", "part") is None
    assert caplog.text.count("cannot be read") == 2


@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EROFS, errno.EACCES])
def test_run_goes_on_with_one_warning_where_nothing_can_be_stored(tmp_path, error, monkeypatch, caplog):
    store, key = Store(tmp_path), Store().key("kind")
    store.put(key, ENTRY)

    def full(_, path, data):
        Path(path).write_bytes(data[: len(data) // 2])
        raise OSError(error, os.strerror(error))

    monkeypatch.setattr(type(store._fs), "pipe_file", full)
    for n in range(3):
        store.put(store.key("other", n), ENTRY)
        store.put_part(store.key("other", n), "part", {"u": np.eye(2)})
    assert caplog.text.count(os.strerror(error)) == 1
    assert store.get(store.key("other", 0)) is None
    xr.testing.assert_identical(store.get(key), ENTRY)  # what was there can still be read
    assert len(files(tmp_path)) == 1  # and no half of a file is left


def write_often(location, mark):
    store = Store(location)
    for n in range(20):
        store.put("key", ENTRY.assign_attrs(mark=mark, n=n))
        store.put_part("key", "part", {"u": np.full(1000, float(n))})
        if store.get("key") is None:
            return False
    return True


def test_two_processes_may_write_the_same(tmp_path):
    with ProcessPoolExecutor(2) as pool:
        assert all(pool.map(write_often, [tmp_path] * 2, ["one", "other"]))
    result = Store(tmp_path).get("key")
    np.testing.assert_array_equal(result.u, ENTRY.u)


# --- models ----------------------------------------------------------------------------------------------


def solve(store, workers=2):
    return next(iter(solve_models([(HARMONIC, TASK)], RunOptions(workers, store))))


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """A model and the folder that it is stored in."""
    folder = tmp_path_factory.mktemp("store")
    return solve(Store(folder)), folder


def test_a_second_run_opens_no_mesh_and_factors_no_matrix(first, monkeypatch):
    solved, folder = first
    monkeypatch.setattr(engine, "build_section", lambda _: pytest.fail("a mesh was made"))
    again = solve(Store(folder))
    assert (again.cached, solved.cached) == (True, False)
    assert again.model.cost == solved.model.cost
    for (name, result, k_max), (_, expected, same_k) in zip(
        again.model.variations(), solved.model.variations(), strict=True
    ):
        np.testing.assert_array_equal(result.responses, expected.responses, err_msg=name)
        np.testing.assert_array_equal(result.k, expected.k)
        assert k_max == same_k


def test_an_interrupted_model_goes_on_behind_its_last_wavenumber(tmp_path, monkeypatch):
    solved, interrupted, respond = [], [], SectionSolver.__call__

    def counted(self, k, shares=(1.0,)):
        if len(solved) >= 7 and not interrupted:
            interrupted.extend(k)
            raise KeyboardInterrupt
        solved.extend(k)
        return respond(self, k, shares)

    monkeypatch.setattr(SectionSolver, "__call__", counted)
    with pytest.raises(KeyboardInterrupt):
        solve(Store(tmp_path), workers=1)
    samples = solve(Store(tmp_path), workers=1).model.samples
    assert sorted(solved) == sorted([*samples.k, *samples.sparser.k])  # once each, and with coarser cells


def killed_again_and_again(folder, times):
    """Number of wavenumbers solved and kept by processes that are killed at random moments, and the last."""
    script = Path(__file__).parents[1] / "reference" / "small_model.py"
    log = folder / "log"
    log.touch()
    command = [sys.executable, str(script), str(folder / "store"), str(log)]
    chance = random.Random(1)
    for _ in range(times):
        before, started = log.stat().st_size, time.monotonic()
        process = subprocess.Popen(command, cwd=Path(__file__).parents[3])
        while process.poll() is None and log.stat().st_size == before:
            assert time.monotonic() - started < 60
            time.sleep(0.01)
        time.sleep(chance.uniform(0.0, 0.3))
        process.kill()
        process.wait()
    subprocess.run(command, check=True, cwd=Path(__file__).parents[3])
    return log.read_text().split()


@pytest.mark.parametrize("times", [1, pytest.param(20, marks=pytest.mark.slow)])
def test_killed_processes_lose_nothing_that_was_finished(tmp_path, times, first):
    solved = killed_again_and_again(tmp_path, times)
    result, alone = solve(Store(tmp_path / "store")), first[0].model.samples
    samples = result.model.samples
    assert result.cached
    np.testing.assert_array_equal(samples.k, alone.k)
    np.testing.assert_allclose(samples.responses, alone.responses, rtol=1e-9, atol=1e-18)
    once = len(samples.k) + len(samples.sparser.k)  # with the request's cells and with coarser ones
    assert once <= len(solved) <= once + 2 * LARGEST_BATCH * times  # at most what two threads had begun
