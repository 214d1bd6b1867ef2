"""Files of results are complete or as they were, whoever else writes them and whenever a process ends."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
import xarray as xr

from femic.cache.files import UNFINISHED, remove_unfinished, replacing, write_dataset, write_text
from geometries.errors import Failure

DATASET = xr.Dataset(
    {
        "p": (("s",), [1.0, np.nan, 3.0]),
        "named": (("s",), ["a", "b", "ü"]),
        "is_so": (("s",), [True, False, True]),
    },
    coords={"s": [0.0, 1.0, 2.0]},
    attrs={"title": "three", "count": 3},
)


def test_what_is_written_is_read(tmp_path):
    path = write_dataset(DATASET, tmp_path / "a.nc")
    xr.testing.assert_identical(xr.load_dataset(path, engine="h5netcdf"), DATASET)
    assert write_text("ü\n", tmp_path / "a.txt").read_text(encoding="utf-8") == "ü\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nc", "a.txt"]


def test_a_file_stays_as_it_was_where_writing_fails(tmp_path):
    path = write_text("before", tmp_path / "a.csv")

    def fail():
        with replacing(path) as unfinished:
            assert unfinished.suffix == ".csv"  # by which libraries choose the format
            unfinished.write_text("half", encoding="utf-8")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert path.read_text(encoding="utf-8") == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_dataset_that_cannot_be_read_back_is_not_written(tmp_path, monkeypatch):
    path = write_dataset(DATASET, tmp_path / "a.nc")
    opened = xr.open_dataset

    def other(*args, **named):
        result = opened(*args, **named).load()
        result["p"][2] = np.nan  # what a disk has lost
        return result

    monkeypatch.setattr(xr, "open_dataset", other)
    with pytest.raises(Failure, match=r"a\.nc: p of it cannot be read back"):
        write_dataset(DATASET.assign_attrs(title="new"), path)
    monkeypatch.undo()
    assert xr.load_dataset(path, engine="h5netcdf").title == "three"


def write_often(path, mark):
    for _ in range(30):
        write_dataset(xr.Dataset({"u": (("i",), np.full(20000, mark))}, attrs={"mark": mark}), path)


def test_of_two_processes_that_write_a_file_one_has_written_it(tmp_path):
    path = tmp_path / "a.nc"
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(write_often, [path] * 2, [1.0, 2.0]))
    result = xr.load_dataset(path, engine="h5netcdf")
    np.testing.assert_array_equal(result.u, np.full(20000, result.mark))
    assert list(tmp_path.iterdir()) == [path]


def test_killed_process_leaves_the_old_file_and_the_next_run_removes_the_unfinished_one(tmp_path):
    path = write_text("before", tmp_path / "a.txt")
    code = (
        "import sys, time; from pathlib import Path; from femic.cache.files import replacing\n"
        "with replacing(Path(sys.argv[1])) as unfinished:\n"
        "    unfinished.write_text('half'); print('written', flush=True); time.sleep(60)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, str(path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "written\n"
        os.kill(process.pid, signal.SIGKILL)
    assert path.read_text(encoding="utf-8") == "before"
    assert len(list(tmp_path.glob(f"{UNFINISHED}*"))) == 1
    remove_unfinished(tmp_path)
    assert list(tmp_path.iterdir()) == [path]
