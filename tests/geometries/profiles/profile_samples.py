"""Points of the sample files of profiles, which lie beside the project."""

import numpy as np
import pytest

from tests.samples import SAMPLES


def sample(name):
    """Points (y, z), z up, of a spline block among the samples, (2, n)."""
    if not (SAMPLES / name).exists():
        pytest.skip(f"{SAMPLES / name}: the samples of profile files are not here; set FEMIC_PROFILES")
    block = (SAMPLES / name).read_text().split("point.begin")[1].split("point.end")[0]
    rows = [row.split("!")[0].split() for row in block.splitlines()]
    return np.array([row[:2] for row in rows if row], dtype=float).T * [[1], [-1]]
