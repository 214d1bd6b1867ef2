"""How reciprocal a matrix is, and where: matrices with one known defect."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from compare.pages.matrix import reciprocity_text
from femic.contact.operators.dense import PARITY, reciprocity
from geometries.contours import arc, plane
from geometries.patches import Grid

GRID = Grid(4, 6, 0.5, 0.4, s=0.1)  # strips from -1.1 to 1.3 mm
JOINTED = arc(2.0, 0.5, 0.31)  # joints at -1.0 (strip 0) and 0.62 mm (strip 4)


def reciprocal_matrix():
    rng = np.random.default_rng(3)
    half = rng.normal(size=(4, 6, 6, 3, 3))
    ics = half + PARITY * np.swapaxes(np.swapaxes(half, 1, 2), 3, 4)
    ics[..., 2, 2] /= np.max(np.abs(ics[..., 2, 2])) / 5.0  # largest C_nn: 5
    return ics


def size_of(component):
    """The largest value of a component of `reciprocal_matrix`, the same of its transpose."""
    i, j = ("xsn".index(direction) for direction in component)
    return np.max(np.abs(reciprocal_matrix()[..., i, j]))


def with_defects(*, joint, elsewhere):
    ics = reciprocal_matrix()
    ics[2, 1, 4, 0, 1] += joint  # strip 4 has a joint
    ics[1, 3, 2, 1, 2] += elsewhere
    return ics


def test_the_worst_pair_and_the_worst_without_joints():
    result = reciprocity(with_defects(joint=0.01, elsewhere=0.002), JOINTED, GRID)
    xs, sn = size_of("xs"), size_of("sn")
    assert result.worst == pytest.approx(0.01 / xs)
    assert result.component == "xs"
    assert sorted(result.strips) == [1, 4]
    assert result.at_joints == (0, 4)
    assert result.elsewhere == pytest.approx(0.002 / sn)
    assert reciprocity_text(result, GRID) == (
        f"{0.01 / xs:.1e} of xs (strips 1 and 4, s = -0.5, 0.7 mm); joints in strips 0, 4; "
        f"{0.002 / sn:.1e} without these"
    )


def test_defects_of_small_components_are_relative_to_their_own_size():
    """The same defect, in the component that is a hundred times smaller than the others."""
    small = np.ones((3, 3))
    small[1, 2] = small[2, 1] = 0.01
    ics = with_defects(joint=0.01, elsewhere=0.0) * small
    ics[1, 3, 2, 1, 2] += 0.002
    result = reciprocity(ics, JOINTED, GRID)
    assert (result.component, sorted(result.strips)) == ("sn", [2, 3])
    assert result.worst == pytest.approx(0.2 / size_of("sn"))


def test_a_component_that_is_zero_has_no_defect():
    ics = with_defects(joint=0.01, elsewhere=0.0)
    ics[..., [1, 2], [2, 1]] *= 1e-12
    ics[1, 3, 2, 1, 2] += 1e-12
    assert reciprocity(ics, JOINTED, GRID).component == "xs"


def test_contour_without_joints_has_equal_worst_and_elsewhere():
    result = reciprocity(with_defects(joint=0.001, elsewhere=0.02), plane(), GRID)
    assert (sorted(result.strips), result.at_joints) == ([2, 3], ())
    assert result.worst == result.elsewhere == pytest.approx(0.02 / size_of("sn"))
    assert reciprocity_text(result, GRID) == f"{result.worst:.1e} of sn (strips 2 and 3, s = -0.1, 0.3 mm)"


def test_a_joint_on_an_edge_belongs_to_both_strips():
    on_edge = reciprocity(reciprocal_matrix(), arc(2.0, 0.25, 0.45), GRID)  # -0.5: centre; 0.9: edge
    assert on_edge.at_joints == (1, 4, 5)


def test_grid_of_joints_only_has_no_defect_elsewhere():
    grid = Grid(4, 2, 0.5, 0.4)
    result = reciprocity(reciprocal_matrix()[:, :2, :2], arc(2.0, 0.1, 0.1), grid)
    assert (result.at_joints, result.elsewhere) == ((0, 1), None)
    assert "without" not in reciprocity_text(result, grid)


def test_reciprocity_can_be_written_to_a_file():
    result = reciprocity(with_defects(joint=0.01, elsewhere=0.002), JOINTED, GRID)
    assert json.loads(json.dumps(asdict(result)))["at_joints"] == [0, 4]
