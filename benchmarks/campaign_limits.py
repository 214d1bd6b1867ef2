"""Limits of campaigns: scenes that take nothing, tasks of the scheduler, files of the store, a slow store.

python benchmarks/campaign_limits.py [tasks] [files] [scenes] [--record]   # 100000, 100000 and 20000
"""

import os
from contextlib import nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time, sleep

import numpy as np
import xarray as xr
from campaign import campaign_in
from distributed import as_completed
from tables import Record, arguments, print_table

from compare.campaigns import dataset as outcomes
from compare.campaigns import kinds
from compare.campaigns.cluster import ClusterSize, local_cluster
from compare.campaigns.dataset import CampaignDataset, SceneOutcome
from compare.campaigns.kinds import ResultKind
from compare.campaigns.run import compute_sweep
from compare.campaigns.tasks import campaign_tasks
from femic.cache.store import Store
from femic.reference.engine import peak_memory

MEMORY = 1000.0  # MB of a worker
SLOW = 0.05  # s, of a slow store
RECORD = Record(
    "campaign_limits.rates",
    "Rates of campaigns",
    "What campaigns cost beside their computations: by the clock with 2 workers, and for client and "
    "scheduler alone; a store of results with three ICs, three lines and nine components.",
    "python benchmarks/campaign_limits.py",
)
CAMPAIGN = """
scene = "geometry1"
keep = ["errors"]
points = "random"
samples = {n}
[sweep.flank]
keys = ["lower.contour.flank_inclination_deg", "upper.contour.flank_inclination_deg"]
from = 0
to = 75
[sweep.ratio]
keys = {{ "upper.contour.radius" = 10 }}
from = 1.02
to = 2
"""


def main(n_tasks=100_000, n_files=100_000, n_scenes=20_000):
    print_table(("what", "rate"), rows(n_tasks, n_files, n_scenes), record=RECORD)


def rows(n_tasks, n_files, n_scenes):
    for n in (n_scenes // 10, n_scenes):
        yield from campaign(n)
    for n in (n_tasks // 10, n_tasks):
        yield scheduled(n)
    for n in (n_files // 10, n_files):
        yield files(n)
    yield slow()
    yield listed(2000)


def scheduled(n, window=8):
    """Return the seconds of empty tasks, a window of them at a time, as a campaign submits them."""
    with local_cluster(ClusterSize(2, MEMORY)) as client:
        start, cpu_start, left = perf_counter(), process_time(), n - window
        first = [client.submit(os.getpid, pure=False) for _ in range(window)]
        finishing = as_completed(first, loop=client.loop)
        for _ in finishing:
            if left:
                finishing.add(client.submit(os.getpid, pure=False))
                left -= 1
        wall, cpu = perf_counter() - start, process_time() - cpu_start
    rate = f"{1e3 * wall / n:.2f} ms, {1e3 * cpu / n:.2f} ms of a core for client and scheduler"
    return f"an empty task, of {n}", f"{rate}; {peak_memory():.0f} MB"


def errors():
    """Return an array as large as the results of a scene: three ICs, three lines, nine components."""
    values = np.random.default_rng(0).random((4, 1, 3, 3, 3))
    dims = ("variant", "body", "line", "i", "j")
    return xr.Dataset(dict.fromkeys(("error", "rms", "weight"), (dims, values)))


def files(n):
    """Return the seconds for files of results in one folder."""
    outcome = SceneOutcome(errors())
    with TemporaryDirectory() as folder:
        store, start = Store(folder), perf_counter()
        for number in range(n):
            outcomes.put(store, f"key{number}", outcome)
        written = perf_counter() - start
        size = np.mean([path.stat().st_size for path in Path(folder).rglob("key1*.npz")])
        start = perf_counter()
        keys = outcomes.keys_in(store)
        seconds = perf_counter() - start
        chosen = sorted(keys)[:: max(1, n // 1000)]
        start = perf_counter()
        for key in chosen:
            outcomes.get(store, key)
        read = perf_counter() - start
    write_and_read = f"{1e3 * written / n:.2f} ms to write, {1e3 * read / len(chosen):.2f} ms to read"
    what = f"results of a scene, one of {n} files of {size / 1e3:.1f} kB"
    return what, f"{write_and_read}, {seconds:.2f} s to list all"


class SlowStore(Store):
    """A store that takes its time for each access, and counts them."""

    accesses = 0

    @property
    def _fs(self):
        SlowStore.accesses += 1
        sleep(SLOW)
        return super()._fs


def slow():
    """Return the seconds of accesses to a slow store for the results of a scene."""
    with TemporaryDirectory() as folder:
        store, outcome = SlowStore(folder), SceneOutcome(errors())
        start = perf_counter()
        for number in range(20):
            outcomes.put(store, f"key{number}", outcome)
        written, of_writing = (perf_counter() - start) / 20, SlowStore.accesses / 20
        start, SlowStore.accesses = perf_counter(), 0
        for number in range(20):
            outcomes.get(store, f"key{number}")
        read, of_reading = (perf_counter() - start) / 20, SlowStore.accesses / 20
    write = f"{1e3 * written:.0f} ms to write ({of_writing:.0f} accesses)"
    what = f"results of a scene, in a store that takes {1e3 * SLOW:.0f} ms an access"
    return what, f"{write}, {1e3 * read:.0f} ms to read ({of_reading:.0f})"


def campaign(n):
    """Yield the seconds of a campaign with results of usual size, without computation; then once more."""
    with TemporaryDirectory() as folder, local_cluster(ClusterSize(2, MEMORY)) as client:
        client.run(_nothing_is_computed)
        _nothing_is_computed()
        timings = [_seconds_a_scene(folder, n, client) for _ in range(2)]
        dataset = max(Path(folder, "out").glob("sweep.*"), key=lambda path: path.suffix)
    for what, (wall, cpu) in zip(("first", "again"), timings, strict=True):
        rate = f"{1e3 * wall:.1f} ms, {1e3 * cpu:.1f} ms of a core for client and scheduler"
        yield (
            f"a scene without computations, of {n}, {what}",
            f"{rate}; {dataset.name}, {peak_memory():.0f} MB",
        )


def _seconds_a_scene(folder, n, client):
    swept = campaign_in(folder, CAMPAIGN.format(n=n))
    dataset, store = CampaignDataset(swept, Path(folder, "out")), Store(f"{folder}/store")
    start, cpu_start = perf_counter(), process_time()
    compute_sweep(dataset, store, lambda _: nullcontext(client))
    return (perf_counter() - start) / n, (process_time() - cpu_start) / n


def _nothing_is_computed():
    kinds.KINDS = {"errors": ResultKind(lambda *_: errors(), lambda _: [])}


def listed(n):
    """Return the seconds to make the tasks of a campaign one after the other."""
    with TemporaryDirectory() as folder:
        swept, start = campaign_in(folder, CAMPAIGN.format(n=n)), process_time()
        count = sum(1 for _ in campaign_tasks(swept, Store(folder)))
        return "to make the tasks of a scene", f"{1e3 * (process_time() - start) / count:.2f} ms of a core"


if __name__ == "__main__":
    main(*map(int, arguments()))
