"""Campaigns for tests: cheap ones, and ones whose scenes are not computed at all."""

import gc
from contextlib import contextmanager

import numpy as np
import xarray as xr
from distributed import Client, LocalCluster

from compare.campaigns import kinds
from compare.campaigns.cluster import NO_DASHBOARD
from compare.campaigns.dataset import CampaignDataset, SceneOutcome, open_sweep
from compare.campaigns.kinds import ResultKind
from compare.campaigns.load import load_campaign
from compare.campaigns.run import Options, compute_sweep
from femic.cache.store import Store
from femic.results.ics_dataset import errors, to_dataset
from geometries.errors import Failure

CHEAP = """
scene = "geometry1"
[set]
bodies = ["combined"]
components = ["nn"]
variants = ["A", "Bhat"]
patch = { a = 1.0, b = 1.0 }
lines = [{ along = "x", s = 0.0, reach = 4.0, points = 4 }]
reference_length = 10.0
engine = { check = false, tolerance = 0.2, far_radius = 100.0, smallest_cell = 1.0 }
"""
OF_UPPER = (
    CHEAP
    + """
[sweep.R]
keys = ["upper.contour.radius"]
values = [11.0, 12.0]
unit = "mm"
"""
)
LIGHT = """
scene = "geometry1"
[sweep.E]
keys = ["lower.E"]
from = 1
to = 9
count = 5
[sweep.nu]
keys = ["upper.nu"]
values = [0.1, 0.2, 0.3]
"""
LONGER = LIGHT.replace("from = 1\nto = 9\ncount = 5", "values = [1, 3, 5, 7, 9, 10]")  # by a value of E
RANDOM = """
scene = "geometry1"
points = "random"
samples = %d
[sweep.E]
keys = ["lower.E"]
from = 1
to = 9
[sweep.nu]
keys = ["upper.nu"]
from = 0.1
to = 0.3
"""
CELLS_OF_PATCHES = """
scene = "geometry1"
[sweep.cell]
keys = ["engine.smallest_cell"]
values = [0.02, 0.05, 0.2]
[sweep.b]
keys = ["patch.b"]
values = [0.2, 0.15, 0.1]
"""  # the largest cell is too large for the narrower patches


def all_are_large(monkeypatch, chunk=50.0):
    """All datasets are written as large ones are."""
    for name, value in {"LARGEST_FILE": 1, "LARGEST_BUFFER": 200, "CHUNK": chunk}.items():
        monkeypatch.setattr(f"compare.campaigns.dataset.{name}", value)


def campaign_in(folder, text, name="mine"):
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return load_campaign(path)


def light(scene, options):
    """Numbers of a scene without any models; scenes with lower.E = 7 fail."""
    e, nu = scene.bodies["lower"].material.E, scene.bodies["upper"].material.nu
    if e == 7:
        raise Failure("seven")
    options.watch.on_stage("light")
    return xr.Dataset(
        {"sum": ((), e + nu, {"units": "1"}), "powers": ("power", e ** np.array([1.0, 2.0]))},
        coords={"power": ["one", "two"]},
    )


LIGHT_KINDS = {"errors": ResultKind(light, lambda _: [])}


def register(monkeypatch, **computed):
    """Register other kinds of results than those of the program, without models."""
    registered = {name: ResultKind(compute, lambda _: []) for name, compute in computed.items()}
    monkeypatch.setattr(kinds, "KINDS", registered)


def assert_sums(dataset):
    """All scenes have the results of `light`; those with E = 7 have failed."""
    computed = dataset.drop_sel(E=7)
    np.testing.assert_array_equal(computed["sum"], (computed.E + computed.nu).transpose("E", "nu"))
    assert dataset["sum"].sel(E=7).isnull().all()
    assert set(dataset.failure.sel(E=7).values) == {"seven"}


def clusters_of(client):
    """A cluster that is there already."""

    @contextmanager
    def cluster(_scenes):
        yield client

    return cluster


def threads(**options):
    """A cluster of workers in this process, by default of one."""
    gc.collect()  # a client that was never closed closes itself when it is deleted: not while a loop starts
    here = {"threads_per_worker": 1, "processes": False, "scheduler_kwargs": NO_DASHBOARD}
    return LocalCluster(**{"n_workers": 1, **here, **options})


@contextmanager
def in_this_process(**options):
    """A client of a cluster in this process."""
    with threads(**options) as cluster, Client(cluster, set_as_default=False) as client:
        yield client


def swept(campaign, folder, client, options=None, store=None):
    """The progress at the end of a campaign, and its dataset."""
    store = store or Store(folder / "store")
    done = compute_sweep(CampaignDataset(campaign, folder), store, clusters_of(client), options or Options())
    return done, open_sweep(folder)


def collect(campaign, folder, compute, failing=()):
    """The path of a dataset of results that are computed in this process; some scenes have failed."""
    dataset = CampaignDataset(campaign, folder)
    for number in range(campaign.size):
        if number in failing:
            dataset.add(number, SceneOutcome(failure="did not converge"))
        else:
            dataset.add(number, SceneOutcome(compute(campaign.scene(campaign.point(number)))), 1)
    return dataset.write()


def errors_of(results):
    """The errors of a single run, of the components of its scene, as floats."""
    compared = [[i + j in results.scene.components for j in "xsn"] for i in "xsn"]
    return errors(results, to_dataset(results)).astype(float).where(xr.DataArray(compared, dims=("i", "j")))
