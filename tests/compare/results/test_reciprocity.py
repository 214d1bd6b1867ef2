"""How reciprocal a matrix is, and where: matrices with one known defect."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from compare.results.matrix.reciprocity import described, reciprocity
from contact.operators.dense import PARITY
from geometries.contours import arc, plane
from geometries.grids import Grid

GRID = Grid(4, 6, 0.5, 0.4, s=0.1)  # strips from -1.1 to 1.3 mm
JOINTED = arc(2.0, 0.5, 0.31)  # joints at -1.0 (strip 0) and 0.62 mm (strip 4)


def reciprocal_matrix():
    rng = np.random.default_rng(3)
    half = rng.normal(size=(4, 6, 6, 3, 3))
    ics = half + PARITY * np.swapaxes(np.swapaxes(half, 1, 2), 3, 4)
    ics[..., 2, 2] /= np.max(np.abs(ics[..., 2, 2])) / 5.0  # largest C_nn: 5
    return ics


def with_defects(*, joint, elsewhere):
    ics = reciprocal_matrix()
    ics[2, 1, 4, 0, 1] += joint  # strip 4 has a joint
    ics[1, 3, 2, 1, 2] += elsewhere
    return ics


def test_the_worst_pair_and_the_worst_without_joints():
    found = reciprocity(with_defects(joint=0.01, elsewhere=0.002), JOINTED, GRID)
    assert found.worst == pytest.approx(0.01 / 5.0)
    assert sorted(found.strips) == [1, 4]
    assert found.at_joints == (0, 4)
    assert found.elsewhere == pytest.approx(0.002 / 5.0)
    assert described(found, GRID) == (
        "2.0e-03 (strips 1 and 4, s = -0.5, 0.7 mm); joints in strips 0, 4; 4.0e-04 without these"
    )


def test_without_joints_there_is_one_number():
    found = reciprocity(with_defects(joint=0.001, elsewhere=0.02), plane(), GRID)
    assert (sorted(found.strips), found.at_joints) == ([2, 3], ())
    assert found.worst == found.elsewhere == pytest.approx(0.02 / 5.0)
    assert described(found, GRID) == "4.0e-03 (strips 2 and 3, s = -0.1, 0.3 mm)"


def test_a_joint_on_an_edge_belongs_to_both_strips():
    on_edge = reciprocity(reciprocal_matrix(), arc(2.0, 0.25, 0.45), GRID)  # -0.5: centre; 0.9: edge
    assert on_edge.at_joints == (1, 4, 5)


def test_a_grid_of_joints_only_has_no_elsewhere():
    grid = Grid(4, 2, 0.5, 0.4)
    found = reciprocity(reciprocal_matrix()[:, :2, :2], arc(2.0, 0.1, 0.1), grid)
    assert (found.at_joints, found.elsewhere) == ((0, 1), None)
    assert "without" not in described(found, grid)


def test_it_can_be_written_into_a_file():
    found = reciprocity(with_defects(joint=0.01, elsewhere=0.002), JOINTED, GRID)
    assert json.loads(json.dumps(asdict(found)))["at_joints"] == [0, 4]
