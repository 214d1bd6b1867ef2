"""Fixtures of contacts."""

import pytest

from femic.contact import small


@pytest.fixture
def for_any_grid(monkeypatch):
    """The solvers for grids of any size solve small ones, too."""
    monkeypatch.setattr(small, "MOST_ELEMENTS", 0)


@pytest.fixture(params=["compiled", "for any grid"])
def either_solver(request, monkeypatch):
    """Small contacts are solved in compiled loops, or by the solvers for grids of any size."""
    if request.param != "compiled":
        monkeypatch.setattr(small, "MOST_ELEMENTS", 0)
