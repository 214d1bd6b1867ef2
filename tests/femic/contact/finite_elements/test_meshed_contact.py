"""Edges of patches near a joint of the contours, where gaps begin to grow otherwise."""

from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.finite_elements.meshed_contact import Bodies, MeshedContact
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.materials import Material
from geometries.surfaces import LOWER, UPPER

RADIUS, FLANK, EDGE, SPACING = 10.0, 0.9, 7.0, 0.8  # mm, rad, mm, mm
STEEL, DOMAIN = Material(210e3, 0.28), Domain(100.0, 100.0)


def contact(end=15.0, kink=100.0):
    """A patch that ends at `EDGE`, of vertices up to s = `end`; gaps are steep beyond the lower joint."""
    x, s = (
        grid.ravel()
        for grid in np.meshgrid(np.arange(0, 3, SPACING), np.arange(0.1, end, SPACING), indexing="ij")
    )
    gap = np.maximum(s - EDGE + 0.02 * x**2, 0) ** 1.5 + kink * np.maximum(s - RADIUS * FLANK, 0)
    bodies = Bodies(
        Body(LOWER, arc(RADIUS, FLANK, FLANK), STEEL, DOMAIN),
        Body(UPPER, arc(1.02 * RADIUS, FLANK, FLANK), STEEL, DOMAIN, rolling_radius=400.0),
        (-20.0, 20.0),
    )
    area = np.full(len(x), SPACING**2)
    pair = SimpleNamespace(x=x, s=s, area=area, gap=lambda *_: gap * area)
    state = SimpleNamespace(u_lower=None, u_upper=None, approach=None)
    solution = SimpleNamespace(state=state, active=gap == 0)
    return MeshedContact(bodies, None, 1.0, pair, solution, 0.0)


def test_edge_before_a_joint_is_read_from_gaps_before_the_joint():
    """A tenth of the spacing is what reading an edge is good to."""
    assert contact().s_range == pytest.approx((-EDGE, EDGE), abs=0.1 * SPACING)
    assert contact().s_range == pytest.approx(contact(kink=0.0).s_range, abs=0.03 * SPACING)
