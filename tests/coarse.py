"""Coarse C, for tests whose truth does not depend on the accuracy of C: a fourth of the time."""

from contextlib import contextmanager

import pytest

from femic.reference.harmonic import request as tuned

SIZES = {
    "CELLS_PER_HALF_STRIP": 0.9,
    "GROWTH_ON_STRIPS": 1.0,
    "CELLS_PER_HALF_SIDE": 5.0,
    "GROWTH": 0.6,
    "LOOSEST_WAVES": 0.2,
}
TUNED = {name: getattr(tuned, name) for name in SIZES}


@contextmanager
def coarse_sections(sizes=SIZES):
    """The harmonic engine begins with larger cells and fewer wavenumbers; its estimates know of them."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in sizes.items():
            patch.setattr(tuned, name, value)
        yield


def tuned_sections():
    """Cells and wavenumbers as they are, for a test among others with coarse ones."""
    return coarse_sections(TUNED)
