"""Files and folders of results: complete or as they were, checked before any work, written by one run."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
import xarray as xr
from distributed import Client

from femic.cache import folders
from femic.cache.files import UNFINISHED, remove_unfinished, replacing, write_dataset, write_text
from femic.cache.folders import LOCK, locked, require_usable
from geometries.errors import Failure, WrongInput
from tests.compare.campaigns import campaigns

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


def test_no_cluster_is_asked_for_a_lock(tmp_path):
    """Each file would cost messages, and none could be written after the cluster has ended."""
    with campaigns.threads() as cluster:
        client = Client(cluster)
        client.submit(write_dataset, DATASET, tmp_path / "a.nc").result()
        assert not any(worker._client for worker in cluster.workers.values())
        client.sync(client.rpc.close)
        write_dataset(DATASET, tmp_path / "b.nc")
        client.close()
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


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
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path)[:-9] + bytes(9))  # what a disk has lost
    with pytest.raises(Failure, match=r"a\.nc: cannot be read back"):
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


# --- folders -------------------------------------------------------------------------------------------


HOLDING = (
    "import sys, time; from pathlib import Path; from femic.cache.folders import locked\n"
    "with locked(Path(sys.argv[1])):\n"
    "    print('held', flush=True); time.sleep(60)\n"
)


@pytest.fixture
def other_run(tmp_path):
    """Another process that writes into a folder."""
    command = [sys.executable, "-c", HOLDING, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def test_one_run_at_a_time_writes_into_a_folder(tmp_path, other_run):
    with pytest.raises(Failure, match=r"another femic run writes there\. Wait .*--out"), locked(tmp_path):
        pass
    os.kill(other_run.pid, signal.SIGKILL)
    other_run.wait()
    with locked(tmp_path) as folder:  # a lock ends with its process
        assert folder == tmp_path
    with locked(tmp_path):
        pass


def test_a_second_run_of_the_same_process_is_refused_too(tmp_path):
    with locked(tmp_path):
        with pytest.raises(Failure, match="another femic"), locked(tmp_path):
            pass
        with locked(tmp_path / "other"):
            pass


def test_run_removes_unfinished_files_of_killed_runs(tmp_path):
    (tmp_path / "figures").mkdir()
    mine = [tmp_path / "mine.txt", tmp_path / "figures" / "mine.png"]
    left = [path.with_name(f"{UNFINISHED}0.{path.name}") for path in mine]
    for path in (*mine, *left):
        path.touch()
    with locked(tmp_path):
        assert all(path.exists() for path in mine)
        assert not any(path.exists() for path in left)


def test_run_does_not_remove_unfinished_files_of_runs_in_subfolders(tmp_path):
    """As `femic calibrate` of several scenes writes into out/, where each scene has out/SCENE/."""
    with locked(tmp_path / "scene"), replacing(tmp_path / "scene" / "ics.nc") as unfinished:
        unfinished.touch()
        with locked(tmp_path):
            assert unfinished.exists()
    assert (tmp_path / "scene" / "ics.nc").exists()


@pytest.mark.parametrize(
    ("file_or_folder", "text"),
    [
        ("a", "is a file; name a folder"),
        ("a/figures", "figures in it is a file"),
        ("a/contact.nc/", "contact.nc in it is a folder"),
    ],
)
def test_obstacles_are_reported_before_any_work(tmp_path, file_or_folder, text):
    path = tmp_path / file_or_folder
    path.parent.mkdir(exist_ok=True)
    path.mkdir() if file_or_folder.endswith("/") else path.touch()
    with pytest.raises(WrongInput, match=text):
        require_usable(tmp_path / "a")


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs /proc, where nobody can write")
@pytest.mark.parametrize("where", ["/proc/nowhere", "/proc/self/task", "/dev/null/below"])
def test_unwritable_folder_is_reported_before_any_work(where):
    with pytest.raises(WrongInput, match=rf"--out {where}: cannot write there \(.*\): name another"):
        require_usable(Path(where))


def test_a_file_system_without_locks_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(folders.FileLock, "acquire", Mock(side_effect=NotImplementedError("no flock")))
    with pytest.raises(WrongInput, match=r"cannot write there \(no flock\)"):
        require_usable(tmp_path)


def test_checked_folder_has_only_a_lock(tmp_path):
    require_usable(tmp_path / "new")
    assert [path.name for path in (tmp_path / "new").iterdir()] == [LOCK]
