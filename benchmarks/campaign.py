"""Campaigns: scenes of one campaign against single runs, workers, memory, overhead.

python benchmarks/campaign.py [share] [--record]   # of the 200 scenes that are also run one by one; default 1
"""

from contextlib import nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

from tables import Record, arguments, print_table

from compare.campaigns import tasks
from compare.campaigns.cluster import ClusterSize, local_cluster
from compare.campaigns.dataset import CampaignDataset
from compare.campaigns.load import load_campaign
from compare.campaigns.run import compute_sweep
from femic.cache.store import Store
from femic.reference.engine import peak_memory
from femic.reference.run_options import RunOptions
from femic.results.ics import compute

SCENES = """
scene = "geometry1"
[set]
bodies = ["combined"]
components = ["nn"]
variants = ["A", "B", "Bhat"]
reference_length = 10.0
patch = {{ a = 1.0, b = 1.0 }}
lines = [{{ along = "x", s = 0.0, reach = 4.0, points = 9 }}]
engine = {{ tolerance = 0.2, check = false, far_radius = 100.0, smallest_cell = 1.0 }}
[sweep.flank]
keys = ["lower.contour.flank_inclination_deg", "upper.contour.flank_inclination_deg"]
from = 10
to = 50
count = {flanks}
[sweep.ratio]
keys = {{ "upper.contour.radius" = 10 }}
values = {ratios}
[sweep.E_ratio]
keys = {{ "lower.E" = 210e3 }}
values = {e_ratios}
"""
ALL = {
    "flanks": 5,
    "ratios": [1.02, 1.05, 1.1, 1.2, 1.5],
    "e_ratios": [0.25, 0.5, 0.7, 0.9, 1.0, 1.2, 1.5, 2.0],
}
SOME = {"flanks": 2, "ratios": [1.05, 1.2], "e_ratios": ALL["e_ratios"]}
MEMORY = 2000.0  # MB of a worker
COLUMNS = (
    "run",
    "scenes",
    "workers",
    "time [s]",
    "time of cores [s]",
    "models solved",
    "memory of a worker [MB]",
    "again, each scene [ms]",
)
RECORD = Record(
    "campaign.scenes",
    "A campaign and single runs",
    "Flanks, radius ratios and ratios of moduli, one line, nn, tolerance 0.2: as one campaign, and each "
    "scene as a run with a store of its own.",
    "python benchmarks/campaign.py",
)


def main(share=1.0):
    print_table(COLUMNS, rows(share), record=RECORD)


def rows(share):
    for axes, workers in ((ALL, 2), (SOME, 1), (SOME, 2)):
        yield swept(SCENES.format(**axes), workers)
    yield single(share)


def campaign_in(folder, text):
    path = Path(folder) / "campaign.toml"
    path.write_text(text, encoding="utf-8")
    return load_campaign(path)


def computed(campaign, folder, client):
    dataset, store = CampaignDataset(campaign, Path(folder)), Store(f"{folder}/store")
    return compute_sweep(dataset, store, lambda _: nullcontext(client))


def swept(text, workers):
    with TemporaryDirectory() as folder, local_cluster(ClusterSize(workers, MEMORY)) as client:
        client.run(tasks.results_digest)  # imports are not measured
        before, cpu_start = _of_workers(client), process_time()
        campaign, start = campaign_in(folder, text), perf_counter()
        done = computed(campaign, folder, client)
        seconds, of_cores = perf_counter() - start, process_time() - cpu_start + _of_workers(client) - before
        start = perf_counter()
        computed(campaign, folder, client)
        again = 1e3 * (perf_counter() - start) / done.scenes
    sizes = done.scenes, workers, f"{seconds:.0f}", f"{of_cores:.0f}", done.models
    return ["campaign", *sizes, f"{done.memory:.0f}", f"{again:.1f}"]


def single(share):
    """Compute the same scenes one by one on both cores, each with a store of its own."""
    with TemporaryDirectory() as folder:
        campaign = campaign_in(folder, SCENES.format(**ALL))
        numbers = [n for k, n in enumerate(campaign.order) if int(k * share) != int((k + 1) * share)]
        models, start, cpu_start = 0, perf_counter(), process_time()
        for number in numbers:
            scene = campaign.scene(campaign.point(number))
            models += len(compute(scene, RunOptions(2, Store(f"{folder}/{number}"))).models)
        seconds, of_cores = perf_counter() - start, process_time() - cpu_start
    times = campaign.size / len(numbers)  # all of them, from those that were run
    sizes = campaign.size, 2, f"{seconds * times:.0f}", f"{of_cores * times:.0f}", round(models * times)
    return ["single runs", *sizes, f"{peak_memory():.0f}", "–"]


def _of_workers(client):
    """Return the seconds of cores that all workers have used."""
    return sum(client.run(process_time).values())


if __name__ == "__main__":
    main(*map(float, arguments()))
