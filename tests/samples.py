"""Sample files of profiles, which lie beside the project, and points that tests of profiles share."""

import os
from pathlib import Path

import numpy as np

SAMPLES = Path(os.environ.get("FEMIC_PROFILES", Path(__file__).resolve().parents[2] / "shared" / "profiles"))
ERROR = 0.02  # mm, of the points below along the normal


def write_head(path):
    """Write a file of an arc of 30 mm, its crown at (2, 1), with errors of alternating sign."""
    angle = np.linspace(-1.4, 1.4, 241)
    radius = 30 + ERROR * (-1.0) ** np.arange(241)
    np.savetxt(path, np.stack([2 + radius * np.sin(angle), radius * np.cos(angle) - 29]).T, fmt="%.12f")
