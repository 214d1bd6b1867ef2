"""Datasets that tests of pages share: a grid, one axis, random points."""

import numpy as np
import pytest

from tests.compare.campaigns.report.datasets import FLANKS, RATIOS, campaign


@pytest.fixture
def grid():
    return campaign({"flank": FLANKS, "ratio": RATIOS}, FLANKS[:, None], RATIOS)


@pytest.fixture
def curve():
    return campaign({"flank": FLANKS}, FLANKS, 1.05)


@pytest.fixture
def samples():
    rng = np.random.default_rng(0)
    flank, ratio = rng.uniform(0, 60, 200), rng.uniform(1.05, 1.5, 200)
    return campaign({"flank": flank, "ratio": ratio}, flank, ratio, points="samples")
