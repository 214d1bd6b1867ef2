"""Settings of the whole run: one BLAS thread per process, repeatable examples, dear files first."""

import os

# Before NumPy is imported. Tests run on all cores: more threads wait for each other most of the time.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

from tests.pages import started  # noqa: E402

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

# A file is run by one process. What starts last should be short, or the other processes wait for it.
DEAR = (
    "tests/femic/reference/harmonic/test_harmonic.py",
    "tests/femic/reference/matrix/test_matrix.py",
    "tests/test_docs.py",
    "tests/test_examples.py",
    "tests/compare/ics/test_geometry1.py",
    "tests/compare/overlay/test_overlay.py",
    "tests/femic/reference/harmonic/test_expected.py",
    "tests/femic/cache/test_store.py",
)


def pytest_collection_modifyitems(items):
    """The dear files first, all others in their own order."""
    items.sort(key=lambda item: not item.nodeid.startswith(DEAR))


@pytest.fixture(scope="session")
def browser():
    """The browser in which pages are tried."""
    yield from started()
