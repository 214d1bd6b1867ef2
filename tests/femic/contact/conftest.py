"""Fixtures of contacts."""

import pytest

from femic.contact import small


@pytest.fixture
def for_any_grid(monkeypatch):
    """The solvers for grids of any size solve small ones, too."""
    monkeypatch.setattr(small, "MOST_ELEMENTS", 0)
