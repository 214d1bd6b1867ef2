"""The numbers of contacts: moments, the main patch, and that all motions have theirs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.motions.compression import OF_COMPRESSION
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.quantities import main_patch
from femic.contact.patch import extents
from geometries.patches import Grid
from tests.femic.contact.pairs.problems import problem


def test_moment_includes_all_tractions_on_inclined_elements():
    """By cross products of places and forces, of pressures too, element by element."""
    on_grid = pair_on_grid(problem(10.3, shift=0.1), Grid(4, 5, 0.7, 0.9, 1.3))
    p = np.random.default_rng(2).normal(size=(4, 5, 3))
    contour, moment = on_grid.undeformed.lower.contour, np.zeros(3)
    for i, x in enumerate(on_grid.x):
        for j, s in enumerate(on_grid.grid.strips):
            delta = float(contour.inclination(np.array([s]))[0])
            sin, cos = np.sin(delta), np.cos(delta)
            directions = np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
            y, z = (float(v[0]) for v in contour.position(np.array([s])))
            moment += np.cross([x, y, z], p[i, j] @ directions) * on_grid.grid.area
    m_z = OF_COMPRESSION["M_z"].evaluate
    assert m_z(on_grid, SimpleNamespace(tractions=p)) == pytest.approx(moment[2])
    assert OF_COMPRESSION["M_x"].evaluate(on_grid, SimpleNamespace(tractions=p)) == pytest.approx(moment[0])
    level = replace(on_grid, grid=Grid(4, 5, 0.7, 0.9, 0.0))
    assert m_z(on_grid, SimpleNamespace(tractions=p)) != pytest.approx(
        m_z(level, SimpleNamespace(tractions=p)), rel=0.01
    )


def test_main_patch_carries_the_largest_load():
    """Not the largest, and not the first."""
    p, gap = np.zeros((12, 20)), np.ones((12, 20))
    p[4:8, 3:9], p[5:7, 12:15] = 1.0, 50.0
    contact = SimpleNamespace(pressures=p, patches=extents(p, np.where(p > 0, 0.0, gap)))
    assert len(contact.patches) == 2
    assert main_patch(contact).s[0] > 10
    mirrored = SimpleNamespace(
        pressures=p[:, ::-1], patches=extents(p[:, ::-1], np.where(p > 0, 0.0, gap)[:, ::-1])
    )
    assert main_patch(mirrored).s[1] < 9
