"""Coulomb's law for given bounds on half-spaces, for tests: in an ellipse with a hole, turning and moving."""

from dataclasses import replace

import numpy as np

from femic.contact.friction.coulomb import Coulomb, FreeAmplitudes
from femic.contact.friction.law import Strips
from femic.contact.friction.motion import LeadingEdge, Shift, SteadyRolling
from femic.contact.operators.approximations import half_space_operator
from geometries.materials import Material
from geometries.patches import Grid, S, X
from tests.femic.contact.problems import level, x_of

MATERIAL = Material(2 * 1.28 * 82000.0, 0.28)  # G = 82 GPa


def law(operator, motion, bound):
    """The problem of a motion with given bounds."""
    return Coulomb(
        lambda p: motion.elastic_slip(operator(p)),
        Strips.on_half_spaces(operator, motion),
        motion.given,
        bound,
        LeadingEdge.find(bound, motion.depth),
        motion,
        no_forces(bound),
    )


def no_forces(bound):
    """No free amplitudes."""
    none = np.zeros((0, *bound.shape, 2))
    return FreeAmplitudes(none, none, np.zeros(0))


def on_half_spaces(grid):
    return half_space_operator(level((MATERIAL, MATERIAL)), grid, (X, S))


GRID = Grid(8, 7, 0.5, 0.7)


def bounds(seed=0):
    """In an ellipse with a hole; elsewhere none."""
    x, s = x_of(GRID)[:, None] / 1.7, GRID.strips / 2.2
    g = 200.0 * np.sqrt(np.maximum(1 - x**2 - s**2, 0))
    g *= np.random.default_rng(seed).uniform(0.7, 1.3, (8, 7))
    g[3, 4] = 0.0
    return g


def swirl(size):
    """Rigid slip with a turn, over which some elements stick."""
    w = np.zeros((8, 7, 2))
    w[..., 0], w[..., 1] = 0.5 - 0.4 * GRID.strips, -0.3 + 0.4 * x_of(GRID)[:, None]
    return size * w


MOTIONS = {
    "shift": Shift(swirl(4e-3)),
    "first": SteadyRolling(swirl(4e-3), dx=GRID.dx, order=1),
    "second": SteadyRolling(swirl(4e-3), dx=GRID.dx, order=2),
}


WAYS = np.zeros((2, 8, 7, 2))
WAYS[0, ..., 0] = WAYS[1, ..., 1] = 1.0


def with_forces(targets, bound=None, motion=MOTIONS["second"]):
    bound = bounds() if bound is None else bound
    free = FreeAmplitudes(np.array([motion.half_way(way) for way in WAYS]), WAYS, np.array(targets))
    return replace(law(on_half_spaces(GRID), motion, bound), free=free)
