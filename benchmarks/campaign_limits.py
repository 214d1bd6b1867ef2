"""Limits of campaigns: tasks of the scheduler, files of the store, a slow store, scenes of this process.

python benchmarks/campaign_limits.py [tasks] [files]   # numbers of each; default 100000 and 100000
"""

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time, sleep

import numpy as np
import xarray as xr
from distributed import as_completed

from compare.results.sweep import kept
from compare.results.sweep.cluster import Size, local_cluster
from compare.results.sweep.compute import tasks_of
from compare.results.sweep.kept import Kept
from compare.scenes.campaign import load_campaign
from femic.models import peak_memory
from femic.work.store import Store

MEMORY = 1000.0  # MB of a worker
SLOW = 0.05  # s, of a slow store
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


def main(n_tasks=100_000, n_files=100_000):
    for n in (n_tasks // 10, n_tasks):
        scheduled(n)
    for n in (n_files // 10, n_files):
        files(n)
    slow()
    listed(2000)


def scheduled(n, window=8):
    """Tasks that do nothing, a window of them at a time, as a campaign hands them over."""
    with local_cluster(Size(2, MEMORY)) as client:
        start, begun, left = perf_counter(), process_time(), n - window
        first = [client.submit(os.getpid, pure=False) for _ in range(window)]
        finishing = as_completed(first, loop=client.loop)
        for _ in finishing:
            if left:
                finishing.add(client.submit(os.getpid, pure=False))
                left -= 1
        wall, cpu = perf_counter() - start, process_time() - begun
    print(
        f"{n} tasks that do nothing: {1e3 * wall / n:.2f} ms a task, {1e3 * cpu / n:.2f} ms of a core for "
        f"client and scheduler; {peak_memory():.0f} MB",
        flush=True,
    )


def errors():
    """As large as what is kept of a scene: three ICs, three lines, nine components."""
    values = np.random.default_rng(0).random((4, 1, 3, 3, 3))
    dims = ("variant", "body", "line", "i", "j")
    return xr.Dataset(dict.fromkeys(("error", "rms", "weight"), (dims, values)))


def files(n):
    """What scenes leave in a store, as files in one folder."""
    one = Kept(errors())
    with TemporaryDirectory() as folder:
        store, start = Store(folder), perf_counter()
        for number in range(n):
            kept.put(store, f"key{number}", one)
        written = perf_counter() - start
        size = sum(path.stat().st_size for path in Path(folder).rglob("key1*.npz")) / max(
            1, len(list(Path(folder).rglob("key1*.npz")))
        )
        start = perf_counter()
        keys = kept.kept_keys(store)
        found = perf_counter() - start
        chosen = sorted(keys)[:: max(1, n // 1000)]
        start = perf_counter()
        for key in chosen:
            kept.get(store, key)
        read = perf_counter() - start
    print(
        f"{n} files of {size / 1e3:.1f} kB in a store: {1e3 * written / n:.2f} ms to write one, "
        f"{1e3 * read / len(chosen):.2f} ms to read one, {found:.2f} s to list them",
        flush=True,
    )


class SlowStore(Store):
    """A store that takes its time for each access, and counts them."""

    accesses = 0

    @property
    def _fs(self):
        SlowStore.accesses += 1
        sleep(SLOW)
        return super()._fs


def slow():
    """Accesses to a slow store for what is kept of a scene."""
    with TemporaryDirectory() as folder:
        store, one = SlowStore(folder), Kept(errors())
        start = perf_counter()
        for number in range(20):
            kept.put(store, f"key{number}", one)
        written, of_writing = (perf_counter() - start) / 20, SlowStore.accesses / 20
        start, SlowStore.accesses = perf_counter(), 0
        for number in range(20):
            kept.get(store, f"key{number}")
        read, of_reading = (perf_counter() - start) / 20, SlowStore.accesses / 20
    print(
        f"store with {1e3 * SLOW:.0f} ms an access: {1e3 * written:.0f} ms to write what is kept of a scene "
        f"({of_writing:.0f} accesses), {1e3 * read:.0f} ms to read it ({of_reading:.0f})",
        flush=True,
    )


def listed(n):
    """The tasks of a campaign, made one after the other by this process."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "campaign.toml"
        path.write_text(CAMPAIGN.format(n=n), encoding="utf-8")
        campaign, start = load_campaign(path), process_time()
        count = sum(1 for _ in tasks_of(campaign, Store(folder)))
        print(f"tasks of scenes: {1e3 * (process_time() - start) / count:.2f} ms of a core each", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
