"""Cells that would fold far from a patch keep straight edges, and only these."""

import numpy as np
import pytest
from skfem import MeshTet, MeshTet2

from femic.reference.solid.mesh import _folded, unfold


@pytest.fixture
def straight():
    """Five tetrahedra that fill a box, with nodes in the middles of their edges."""
    return MeshTet2.from_mesh(MeshTet.init_tensor(*[np.array([0.0, side]) for side in (1.0, 1.3, 0.8)]))


def bent(straight, *, by):
    """Its nodes with the first mid-side node moved by a share of its edge, along the edge."""
    nodes = straight.doflocs.copy()
    first = straight.nvertices
    ends = straight.edges[:, 0]
    nodes[:, first] += by * (nodes[:, ends[1]] - nodes[:, ends[0]])
    return nodes, first


def test_a_cell_that_folds_gets_its_edge_back(straight):
    nodes, first = bent(straight, by=0.6)
    assert len(_folded(MeshTet2(nodes, straight.t))) > 0
    result = unfold(straight, nodes, np.array([first, first + 1]))
    np.testing.assert_array_equal(result, straight.doflocs)


def test_a_cell_that_does_not_fold_stays_curved(straight):
    nodes, first = bent(straight, by=0.1)
    assert len(_folded(MeshTet2(nodes, straight.t))) == 0
    np.testing.assert_array_equal(unfold(straight, nodes, np.array([first])), nodes)


def test_an_edge_that_must_be_curved_stays_so(straight):
    """The mesh is refused then, or made with other cells."""
    nodes, first = bent(straight, by=0.6)
    np.testing.assert_array_equal(unfold(straight, nodes, np.array([first + 1])), nodes)
