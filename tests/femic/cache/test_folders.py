"""Folders of results are looked at before any work, and written by one run at a time."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest

from femic.cache import folders
from femic.cache.files import UNFINISHED, replacing
from femic.cache.folders import LOCK, locked, require_usable
from geometries.errors import Failure, WrongInput

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
    with pytest.raises(Failure, match=r"another femic writes there: wait .*--out"), locked(tmp_path):
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
    with pytest.raises(
        WrongInput, match=rf"--out {where}: nothing can be written there \(.*\): name another"
    ):
        require_usable(Path(where))


def test_a_file_system_without_locks_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(folders.FileLock, "acquire", Mock(side_effect=NotImplementedError("no flock")))
    with pytest.raises(WrongInput, match=r"nothing can be written there \(no flock\)"):
        require_usable(tmp_path)


def test_checked_folder_has_only_a_lock(tmp_path):
    require_usable(tmp_path / "new")
    assert [path.name for path in (tmp_path / "new").iterdir()] == [LOCK]
