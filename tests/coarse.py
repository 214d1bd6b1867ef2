"""Coarse C, for tests whose truth does not depend on the accuracy of C: a fourth of the time."""

from contextlib import contextmanager

import pytest

from femic.reference.engines import HarmonicEngine
from femic.reference.harmonic import request

SIZES = {
    (HarmonicEngine, "cells_per_half_strip"): 0.9,
    (HarmonicEngine, "growth_on_strips"): 1.0,
    (HarmonicEngine, "cells_per_half_side"): 5.0,
    (HarmonicEngine, "growth"): 0.6,
    (request, "LOOSEST_WAVES"): 0.2,
}
TUNED = {(owner, name): getattr(owner, name) for owner, name in SIZES}


@contextmanager
def coarse_sections(sizes=SIZES):
    """The harmonic engine begins with larger cells and fewer wavenumbers; its estimates know of them."""
    with pytest.MonkeyPatch.context() as patch:
        for (owner, name), value in sizes.items():
            patch.setattr(owner, name, value)
        yield


def tuned_sections():
    """Cells and wavenumbers as they are, for a test among others with coarse ones."""
    return coarse_sections(TUNED)
