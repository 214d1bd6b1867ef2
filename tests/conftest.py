"""Settings of the whole run: one BLAS thread per process, repeatable examples, dear files first."""

import os
import sys
from functools import cache

# Before NumPy is imported. Tests run on all cores: more threads wait for each other most of the time.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
# Many tests start processes. Without compiled modules each would spend as long on compiling as on its work.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

import pytest  # noqa: E402
from hypothesis import settings  # noqa: E402

from tests.pages import started  # noqa: E402

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

# A file is run by one process. What starts last should be short, or the other processes wait for it.
DEAR = (
    "tests/compare/validation/statements/test_validation.py",
    "tests/compare/matrix/test_matrix.py",
    "tests/compare/frontier/test_frontier.py",
    "tests/compare/friction/test_page.py",
    "tests/compare/ics/test_overlay.py",
    "tests/femic/reference/solid/test_solid.py",
    "tests/compare/shifts/test_rolling_page.py",
    "tests/compare/campaigns/results/test_registry.py",
    "tests/compare/calibration/test_calibration.py",
    "tests/femic/results/test_stresses.py",
    "tests/femic/reference/matrix/test_matrix.py",
    "tests/compare/campaigns/running/test_run.py",
    "tests/compare/report/test_show.py",
    "tests/femic/reference/harmonic/test_condensation.py",
    "tests/femic/reference/harmonic/test_harmonic.py",
    "tests/femic/interface/test_contact.py",
    "tests/geometries/track/test_track_shifts.py",
    "tests/femic/cache/test_store.py",
    "tests/femic/cli/test_registered.py",
    "tests/femic/cli/test_cli.py",
    "tests/test_attack.py",
    "tests/test_docs.py",
    "tests/test_examples.py",
    "tests/femic/reference/harmonic/test_section_work.py",
    "tests/femic/shifts/test_rolling_wheelset.py",
    "tests/femic/reference/harmonic/test_outlines.py",
    "tests/compare/validation/statements/test_friction_details.py",
    "tests/femic/contact/motions/test_transient.py",
    "tests/femic/reference/matrix/test_nesting.py",
    "tests/femic/reference/test_discount_rules.py",
    "tests/compare/friction/test_transient.py",
    "tests/femic/results/test_rolling.py",
    "tests/femic/results/test_supports.py",
)


def pytest_collection_modifyitems(items):
    """The dear files first, all others in their own order."""
    items.sort(key=lambda item: not item.nodeid.startswith(DEAR))


@pytest.fixture(scope="session", autouse=True)
def _remembered_coefficients():
    """Kalker's coefficients of each ellipse are computed once: every scene that rolls asks for them."""
    from femic.contact.exact import creepage_coefficients  # noqa: PLC0415

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(creepage_coefficients, "_five", cache(creepage_coefficients._five))
        yield


@pytest.fixture(scope="session")
def browser():
    """The browser in which pages are tried."""
    yield from started()
