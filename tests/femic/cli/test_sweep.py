"""The command `sweep`: exit codes, what it prints, interruption, death."""

import re
import signal
import subprocess
import sys
import time
import tomllib
from contextlib import contextmanager
from io import StringIO
from pathlib import Path

import h5py
import pytest
from rich.console import Console

from compare.campaigns import kinds
from compare.campaigns.cluster import ClusterSize
from compare.campaigns.dataset import open_sweep
from compare.campaigns.run import Progress
from femic.cli import scenes
from femic.cli.main import DONE, FAILED, INTERRUPTED, WRONG_INPUT, exit_code
from femic.cli.progress import EVERY
from femic.cli.sweep import campaign_lines, show_campaign
from femic.scenes.load import load_scene
from geometries.errors import Failure
from tests.compare.campaigns.campaigns import (
    CELLS_OF_PATCHES,
    LIGHT,
    LIGHT_KINDS,
    LONGER,
    OF_UPPER,
    in_this_process,
)

ROOT = Path(__file__).parents[3]
FEW = LIGHT.replace("from = 1\nto = 9\ncount = 5", "values = [6, 7]")  # those of 7 fail
INTERRUPTIBLE = """
import signal
from femic.cli.main import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # shells have it ignored in the background
main()
"""


@pytest.fixture(scope="module")
def client():
    with in_this_process() as client:
        yield client


@pytest.fixture
def femic(client, tmp_path, monkeypatch, capsys):
    """A function that sweeps a campaign whose scenes are not computed: the exit code, what was printed."""

    @contextmanager
    def cluster(_size):
        yield client

    monkeypatch.setattr(kinds, "KINDS", LIGHT_KINDS)
    monkeypatch.setattr("compare.campaigns.cluster.local_cluster", cluster)
    monkeypatch.setattr("compare.campaigns.plan.largest_memory", lambda _: 100.0)
    monkeypatch.chdir(tmp_path)

    def sweep(text, *options):
        Path("mine.toml").write_text(text, encoding="utf-8")
        code = exit_code(["sweep", "mine.toml", *options])
        printed = capsys.readouterr()
        return code, printed.out + printed.err

    return sweep


def test_scenes_that_fail_are_listed_and_do_not_stop_the_others(femic):
    code, printed = femic(FEW)
    assert code == DONE
    assert "6 scenes: 3 computed, 3 failed (0 by earlier runs)." in printed
    assert "failed: E=7,nu=0.1 and 2 more: seven" in printed
    assert "Dataset: out/mine/sweep.nc" in printed
    assert open_sweep(Path("out/mine")).attrs["failed"] == 3
    assert "(6 by earlier runs)" in femic(FEW)[1]
    code, printed = femic(FEW.replace("[6, 7]", "[7]"))
    assert code == FAILED
    assert "all 3 scenes failed" in printed


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("scene = 1", (), "scene = 1: "),
        (
            LIGHT,
            ("--scheduler", "tcp://127.0.0.1:9", "--workers", "2"),
            "--workers counts cores of this machine",
        ),
        (LIGHT.replace("0.1, 0.2, 0.3", "0.1, 0.7, 0.3"), (), "at E=1,nu=0.7"),
        (LIGHT, ("--scheduler", "nonsense"), "is not the address of a Dask scheduler"),
        (LIGHT, ("--scheduler", ""), "is not the address of a Dask scheduler"),
    ],
)
def test_wrong_campaigns_and_options_are_refused_before_computing(femic, text, options, message):
    code, printed = femic(text, *options)
    assert code == WRONG_INPUT
    assert message in " ".join(printed.split())
    assert not Path("out").exists()


def test_a_scheduler_that_does_not_answer_is_reported_before_any_work(femic, monkeypatch):
    monkeypatch.setattr("compare.campaigns.run.compute_sweep", None)
    code, printed = femic(LIGHT, "--scheduler", "tcp://127.0.0.1:9")
    assert code == FAILED
    assert "no scheduler answers at tcp://127.0.0.1:9" in " ".join(printed.split())
    assert not Path("out/mine/sweep.nc").exists()


def test_impossible_combinations_are_noted_and_fail(femic):
    code, printed = femic(CELLS_OF_PATCHES)
    assert code == DONE
    assert "note: this scene will fail: at cell=0.2,b=0.1: " in printed
    assert "9 scenes: 7 computed, 2 failed" in printed


def test_write_prints_only_the_paths_of_scenes(femic):
    code, printed = femic(LIGHT, "--write", "E=2.5,nu=0.3")
    assert (code, printed) == (DONE, "out/mine/E=2.5,nu=0.3.toml\n")
    scene = load_scene("out/mine/E=2.5,nu=0.3.toml")
    assert scene.bodies["lower"].material.E == 2.5
    assert scene.bodies["upper"].material.nu == 0.3
    assert femic(LIGHT, "--write", "E=2.5")[0] == WRONG_INPUT
    _, printed = femic(LIGHT, "--write", "E=3")
    assert printed.split() == [f"out/mine/E=3,nu={nu}.toml" for nu in (0.1, 0.2, 0.3)]
    assert femic(LIGHT, "--write", "E=2.5,nu=7")[0] == WRONG_INPUT


def test_scenes_of_a_campaign_are_compared_with_its_stored_models(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(OF_UPPER, encoding="utf-8")
    computed = []

    def compute(scene, folder, work, _):
        radius = tomllib.loads(scene.text)["upper"]["contour"]["radius"]
        computed.append((scene.name, radius, folder, work.store))
        if len(computed) == 2:
            raise Failure("enough")

    monkeypatch.setattr(scenes, "_computed", compute)
    Path("out/mine/store").mkdir(parents=True)
    assert exit_code(["compare", "mine.toml@R=11", "mine.toml@R=12"]) == FAILED
    assert computed == [(f"R={R}", R, Path(f"out/R={R}"), "out/mine/store") for R in (11, 12)]
    assert exit_code(["compare", "mine.toml@R=13,x=1", "mine.toml@R=12"]) == WRONG_INPUT
    Path("light.toml").write_text(LONGER, encoding="utf-8")
    assert exit_code(["compare", "light.toml@nu=0.1"]) == WRONG_INPUT
    assert "light.toml@nu=0.1: 6 scenes; at most 5 are compared" in capsys.readouterr().err


@pytest.mark.parametrize("large", [False, True])
def test_page_is_written_without_computing_and_not_of_what_is_missing_or_damaged(femic, monkeypatch, large):
    if large:
        monkeypatch.setattr("compare.campaigns.dataset.LARGEST_FILE", 1)
    code, printed = femic(FEW, "--page")
    assert code == FAILED
    assert "out/mine: no finished scenes yet" in printed
    assert f"Dataset: out/mine/sweep.{'zarr' if large else 'nc'}" in femic(FEW)[1]
    Path("out/mine/sweep.html").unlink()
    with monkeypatch.context() as patch:
        patch.setattr("compare.campaigns.run.compute_sweep", None)
        assert femic(FEW, "--page") == (DONE, "Report: out/mine/sweep.html\n")
    assert "seven" in Path("out/mine/sweep.html").read_text(encoding="utf-8")
    path = Path("out/mine/sweep.zarr/sum/c/0/0" if large else "out/mine/sweep.nc")
    content, place = bytearray(path.read_bytes()), 0
    if not large:
        with h5py.File(path) as file:
            place = file["sum"].id.get_chunk_info(0).byte_offset
    content[place] ^= 1
    path.write_bytes(content)
    code, printed = femic(FEW, "--page")
    assert code == FAILED
    assert "damaged (" in printed
    assert "run the campaign again" in printed
    assert ("it is written again" in femic(FEW)[1]) == large
    assert femic(FEW, "--page")[0] == DONE
    if not large:
        path.write_text("none", encoding="utf-8")
        code, printed = femic(FEW, "--page")
        assert code == FAILED
        assert "sweep.nc: damaged" in printed


def test_written_scene_has_no_check(femic):
    checked = LIGHT.replace("[sweep.E]", "[set.engine]\ncheck = true\n[sweep.E]")
    _, printed = femic(checked, "--write", "E=2,nu=0.1")
    engine = tomllib.loads(Path(printed.strip()).read_text(encoding="utf-8"))["engine"]
    assert engine["check"] is False


def test_fewer_workers_are_explained(femic, monkeypatch):
    size = ClusterSize(1, 100.0, "1 instead of 2 workers: ...")
    monkeypatch.setattr("compare.campaigns.cluster.size_for", lambda *_: size)
    assert "note: 1 instead of 2 workers" in femic(FEW)[1]


def test_plan_of_a_campaign_computes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(OF_UPPER, encoding="utf-8")
    assert exit_code(["sweep", "mine.toml", "--plan", "--workers", "1"]) == DONE
    printed = capsys.readouterr().out
    assert re.search(r"2 scenes, 0 of them finished; the others have 3 different models", printed)
    assert re.search(r"About \d+ s with 1 workers, \d+ MB each", printed)
    assert not Path("out/mine/sweep.nc").exists()


# --- progress ----------------------------------------------------------------------------------------


def test_a_campaign_has_a_line_every_few_seconds_and_a_last_one():
    written, clock = [], iter([0.0, 1.0, EVERY, EVERY + 1])
    write_if_due = campaign_lines(written.append, lambda: next(clock))
    for n in (1, 2, 3, 4):
        write_if_due(Progress(4, finished=n, reused=0, models=5, models_reused=2, seconds=60.0 * n))
    details = "(0 finished before, 0 failed; models: 5 solved, 2 times reused)"
    assert written == [
        f"  1 of 4 scenes {details}, about 3 min left",
        f"  3 of 4 scenes {details}, about 60 s left",
        f"  4 of 4 scenes {details}",
    ]


def test_terminal_shows_a_bar_of_scenes():
    console = Console(file=StringIO(), force_terminal=True, width=150)
    with show_campaign(console) as show:
        show(Progress(10, finished=3, reused=1, failed=1, models=5, seconds=20.0))
    text = re.sub("\x1b\\[[0-9;?]*[A-Za-z]", "", console.file.getvalue())
    assert "scenes (1 finished before, 1 failed; models: 5 solved, 0 times reused)" in text
    assert "3/10" in text
    assert "about 70 s left" in text


# --- processes ---------------------------------------------------------------------------------------


@contextmanager
def begun(folder):
    """A campaign in a process of its own, of which a scene is finished, and the workers' process ids."""
    (folder / "mine.toml").write_text(
        OF_UPPER.replace("11.0, 12.0", "11.0, 12.0, 13.0, 14.0"), encoding="utf-8"
    )
    log = folder / "log"
    command = [sys.executable, "-c", INTERRUPTIBLE, "sweep", str(folder / "mine.toml"), "--workers", "2"]
    with (
        log.open("w") as output,
        subprocess.Popen([*command, "--out", str(folder)], cwd=ROOT, stdout=output, stderr=output) as process,
    ):
        started = time.monotonic()
        while " of 4 scenes" not in log.read_text():
            assert process.poll() is None, log.read_text()
            assert time.monotonic() - started < 120
            time.sleep(0.05)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        everywhere = Path(f"/proc/{process.pid}/task").glob("*/children")
        assert children.exists()
        yield process, [int(pid) for file in everywhere for pid in file.read_text().split()]


def at_work(pids):
    """Which processes still run; not those that have ended and that nobody has asked about."""
    stats = [Path(f"/proc/{pid}/stat") for pid in pids]
    return [path for path in stats if path.exists() and path.read_text().rpartition(")")[2].split()[0] != "Z"]


@pytest.mark.slow
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_interrupted_campaign_leaves_no_worker_and_continues(tmp_path, end):
    with begun(tmp_path) as (process, workers):
        assert len(workers) >= 2
        process.send_signal(end)
        started = time.monotonic()
        code = process.wait()
        took = time.monotonic() - started
    time.sleep(1.0)
    assert not at_work(workers)
    assert code == (INTERRUPTED if end == signal.SIGINT else -signal.SIGKILL)
    assert took < 10
    subprocess.run(
        [sys.executable, "-m", "femic", "sweep", str(tmp_path / "mine.toml"), "--out", str(tmp_path)],
        cwd=ROOT,
        check=True,
    )
    assert open_sweep(tmp_path).attrs["computed"] == 4
