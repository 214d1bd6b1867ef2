"""Turns between the local directions of two elements, and ICs turned by them: B, B-bar, B-hat.

With the local directions of an element in global axes as the columns of Q, T = Q_I^T Q_J takes load
directions into those of the observer. On a prismatic surface T = R_x(alpha), alpha = delta(s_I) -
delta(s_J), the same for both bodies. Source: [BVSV] section 3;
docs/theory/ics.md corrects B-bar.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.surfaces import Surface


@dataclass(frozen=True, eq=False)
class Turn:
    """Rotations T as unit quaternions, shape (4, ...)."""

    quaternion: Array

    @property
    def matrix(self) -> Array:
        """T, shape (3, 3, ...)."""
        w, i, j, k = self.quaternion
        return np.array(
            [
                [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)],
                [2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)],
                [2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)],
            ]
        )

    @property
    def half(self) -> "Turn":
        """T^(1/2): half the angle about the same axis."""
        w, *axis = self.quaternion
        return Turn(np.array([1 + w, *axis]) / np.sqrt(2 * (1 + w)))


def turn_about_x(alpha: ArrayLike) -> Turn:
    """The turn R_x(alpha) about the x axis, alpha in rad."""
    half = np.asarray(alpha, dtype=float) / 2
    return Turn(np.array([np.cos(half), np.sin(half), 0 * half, 0 * half]))


def turn_between(surface: Surface, points: tuple[Array, Array], s_load: float) -> Turn:
    """T of observers at (x, s) [mm] on a surface and a load at (0, s_load).

    T = R_x(delta_I) R_y(side theta) R_x(-delta_J), theta the angle between the two about the axis.
    """
    x, s = points
    delta_I, delta_J = surface.contour.inclination(s), surface.contour.inclination(s_load)
    half = surface.side * surface.chart_x(x, s, s_load) / surface.rolling_radius / 2
    alpha, mean = (delta_I - delta_J) / 2, (delta_I + delta_J) / 2
    along, about = np.cos(half), np.sin(half)
    return Turn(
        np.array([along * np.cos(alpha), along * np.sin(alpha), about * np.cos(mean), about * np.sin(mean)])
    )


def matmul(left: Array, right: Array) -> Array:
    """Matrix product over the first two axes, shape (3, 3, ...)."""
    return np.einsum("ik...,kj...->ij...", left, right)


def load_turned(a: Array, turn: Turn) -> Array:
    """B = A T: the load is turned into the observer's directions; shape and unit of A."""
    return matmul(a, turn.matrix)


def observer_turned(a: Array, turn: Turn) -> Array:
    """B-bar = T A: the displacement is turned; shape and unit of A."""
    return matmul(turn.matrix, a)


def both_turned(a: Array, turn: Turn) -> Array:
    """B-hat = S A S, S = T^(1/2): load and displacement are turned by half each, which keeps reciprocity."""
    half = turn.half.matrix
    return matmul(matmul(half, a), half)
