"""A worker that is killed in the middle of a campaign."""

import os

import numpy as np
import pytest

from compare.campaigns.cluster import local_cluster, size_for
from compare.campaigns.dataset import CampaignDataset, open_sweep
from compare.campaigns.run import Options, compute_sweep
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.results.ics import compute
from tests.compare.campaigns.campaigns import OF_UPPER, campaign_in, clusters_of, errors_of


@pytest.mark.slow  # test_parts.py has a model that kills workers without solving any
def test_killed_worker_costs_one_task(tmp_path):
    """With one worker the task at hand is begun again; the results are those of a run by itself."""
    campaign, killed = campaign_in(tmp_path, OF_UPPER), []
    with local_cluster(size_for(1, 2, 400.0)) as client:

        def kill(_):
            if not killed:
                (pid,) = client.run(os.getpid).values()
                killed.append(pid)
                os.kill(pid, 9)

        collected, store = CampaignDataset(campaign, tmp_path), Store(tmp_path / "store")
        done = compute_sweep(collected, store, clusters_of(client), Options(on_progress=kill))
    assert killed
    assert (done.finished, done.failed) == (2, 0)
    assert 3 <= done.models <= 4  # the lower body and two upper ones, one of them perhaps twice
    results = compute(campaign.scene((12.0,)), RunOptions(1, Store(tmp_path / "alone")))
    computed = open_sweep(tmp_path).sel(R=12).error
    np.testing.assert_array_equal(computed, errors_of(results).error.transpose(*computed.dims))
