"""Settings of the whole test run: one BLAS thread for each of its processes, examples that are repeatable."""

import os

# Before NumPy is imported. Tests run on all cores: more threads wait for each other most of the time.
for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

from hypothesis import settings  # noqa: E402

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")
