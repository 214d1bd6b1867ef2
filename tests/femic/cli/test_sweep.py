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
    OF_UPPER,
    in_this_process,
)

ROOT = Path(__file__).parents[3]
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
    code, printed = femic(LIGHT)
    assert code == DONE
    assert "27 scenes: 24 computed, 3 failed (0 by earlier runs)." in printed
    assert "failed: E=7,nu=0.1 and 2 more: seven" in printed
    assert "Dataset: out/mine/sweep.nc" in printed
    assert open_sweep(Path("out/mine")).attrs["failed"] == 3
    code, printed = femic(LIGHT)
    assert "(27 by earlier runs)" in printed


def test_sweep_fails_if_all_scenes_fail(femic):
    code, printed = femic(LIGHT.replace("from = 1\nto = 9\ncount = 9", "values = [7]"))
    assert code == FAILED
    assert "all 3 scenes failed" in printed


def test_wrong_campaigns_and_options_are_refused(femic):
    assert femic("scene = 1")[0] == WRONG_INPUT
    code, printed = femic(LIGHT, "--scheduler", "tcp://127.0.0.1:9", "--workers", "2")
    assert code == WRONG_INPUT
    assert "--workers are cores of this machine" in printed


def test_invalid_value_is_refused_before_computing(femic):
    code, printed = femic(LIGHT.replace("0.1, 0.2, 0.3", "0.1, 0.7, 0.3"))
    assert code == WRONG_INPUT
    assert "at E=1,nu=0.7" in printed
    assert not Path("out").exists()


def test_impossible_combinations_are_noted_and_fail(femic):
    code, printed = femic(CELLS_OF_PATCHES)
    assert code == DONE
    assert "note: a scene that will fail: at cell=0.2,b=0.1: " in printed
    assert "9 scenes: 7 computed, 2 failed" in printed


@pytest.mark.parametrize(
    ("address", "code", "message"),
    [
        ("nonsense", WRONG_INPUT, "is not the address of a Dask scheduler"),
        ("", WRONG_INPUT, "is not the address of a Dask scheduler"),
        ("tcp://127.0.0.1:9", FAILED, "no scheduler answers at tcp://127.0.0.1:9"),
    ],
)
def test_missing_schedulers_are_reported_before_any_work(femic, monkeypatch, address, code, message):
    monkeypatch.setattr("compare.campaigns.run.compute_sweep", None)
    actual, printed = femic(LIGHT, "--scheduler", address)
    assert actual == code
    assert message in " ".join(printed.split())
    assert not Path("out/mine/sweep.nc").exists()


def test_write_prints_only_the_paths_of_scenes(femic):
    code, printed = femic(LIGHT, "--write", "E=2.5,nu=0.3")
    assert (code, printed) == (DONE, "out/mine/E=2.5,nu=0.3.toml\n")
    scene = load_scene("out/mine/E=2.5,nu=0.3.toml")
    assert scene.bodies["lower"].material.E == 2.5
    assert scene.bodies["upper"].material.nu == 0.3
    assert femic(LIGHT, "--write", "E=2.5")[0] == WRONG_INPUT
    _, printed = femic(LIGHT, "--write", "E=2")
    assert printed.split() == [f"out/mine/E=2,nu={nu}.toml" for nu in (0.1, 0.2, 0.3)]
    assert femic(LIGHT, "--write", "E=2.5,nu=7")[0] == WRONG_INPUT


def test_scenes_of_a_campaign_are_compared_with_its_stored_models(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(OF_UPPER, encoding="utf-8")
    computed = []

    def compute(scene, folder, work, _):
        computed.append(
            (scene.name, tomllib.loads(scene.text)["upper"]["contour"]["radius"], folder, work.store)
        )
        if len(computed) == 2:
            raise Failure("enough")

    monkeypatch.setattr(scenes, "_computed", compute)
    Path("out/mine/store").mkdir(parents=True)
    assert exit_code(["compare", "mine.toml@R=11", "mine.toml@R=12"]) == FAILED
    store = "out/mine/store"
    assert computed == [
        ("R=11", 11.0, Path("out/R=11"), store),
        ("R=12", 12.0, Path("out/R=12"), store),
    ]
    assert exit_code(["compare", "mine.toml@R=13,x=1", "mine.toml@R=12"]) == WRONG_INPUT


def test_page_is_written_without_computing(femic, monkeypatch):
    code, printed = femic(LIGHT, "--page")
    assert code == FAILED
    assert "out/mine: nothing is finished yet" in printed
    femic(LIGHT)
    Path("out/mine/sweep.html").unlink()
    monkeypatch.setattr("compare.campaigns.run.compute_sweep", None)
    assert femic(LIGHT, "--page") == (DONE, "Report: out/mine/sweep.html\n")
    assert Path("out/mine/sweep.html").is_file()


@pytest.mark.parametrize("large", [False, True])
def test_page_of_a_damaged_dataset_is_refused(femic, monkeypatch, large):
    if large:
        monkeypatch.setattr("compare.campaigns.dataset.LARGEST_FILE", 1)
    femic(LIGHT)
    path = Path("out/mine/sweep.zarr/sum/c/0/0" if large else "out/mine/sweep.nc")
    content, place = bytearray(path.read_bytes()), 0
    if not large:
        with h5py.File(path) as file:
            place = file["sum"].id.get_chunk_info(0).byte_offset
    content[place] ^= 1
    path.write_bytes(content)
    code, printed = femic(LIGHT, "--page")
    assert code == FAILED
    assert "damaged (" in printed
    assert "run the campaign again" in printed
    assert ("it is written anew" in femic(LIGHT)[1]) == large
    assert femic(LIGHT, "--page")[0] == DONE


def test_page_of_an_invalid_file_is_refused(femic):
    Path("out/mine").mkdir(parents=True)
    Path("out/mine/sweep.nc").write_text("none", encoding="utf-8")
    code, printed = femic(LIGHT, "--page")
    assert code == FAILED
    assert "sweep.nc: damaged" in printed


def test_written_scene_has_no_check(femic):
    checked = LIGHT.replace("[sweep.E]", "[set.engine]\ncheck = true\n[sweep.E]")
    _, printed = femic(checked, "--write", "E=2,nu=0.1")
    engine = tomllib.loads(Path(printed.strip()).read_text(encoding="utf-8"))["engine"]
    assert engine["check"] is False


def test_a_large_campaign_has_a_page(femic, monkeypatch):
    monkeypatch.setattr("compare.campaigns.dataset.LARGEST_FILE", 1)
    code, printed = femic(LIGHT)
    assert code == DONE
    assert "Dataset: out/mine/sweep.zarr" in printed
    assert "seven" in Path("out/mine/sweep.html").read_text(encoding="utf-8")


def test_compare_refuses_too_many_scenes_of_a_campaign(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(LIGHT, encoding="utf-8")
    assert exit_code(["compare", "mine.toml@nu=0.1"]) == WRONG_INPUT
    assert "mine.toml@nu=0.1: 9 scenes; at most 5 are compared" in capsys.readouterr().err
    assert not Path("out").exists()


def test_fewer_workers_are_explained(femic, monkeypatch):
    size = ClusterSize(1, 100.0, "1 instead of 2 workers: ...")
    monkeypatch.setattr("compare.campaigns.cluster.size_for", lambda *_: size)
    assert "note: 1 instead of 2 workers" in femic(LIGHT)[1]


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
    for finished in (1, 2, 3, 4):
        write_if_due(
            Progress(4, finished=finished, reused=0, models=5, models_reused=2, seconds=60.0 * finished)
        )
    assert written == [
        "  1 of 4 scenes (0 finished before, 0 failed; models: 5 solved, 2 times reused), about 3 min left",
        "  3 of 4 scenes (0 finished before, 0 failed; models: 5 solved, 2 times reused), about 60 s left",
        "  4 of 4 scenes (0 finished before, 0 failed; models: 5 solved, 2 times reused)",
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
