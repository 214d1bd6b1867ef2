"""Exact curves from pieces: arcs, lines and polynomials z(y), by arc length.

Inclinations and curvatures have the signs of contours: delta is positive where the curve falls as y grows,
the tangent is (cos delta, -sin delta), and the curvature is the derivative of delta by the arc length.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import comb
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PPoly

from geometries.arrays import Array
from geometries.contours import inverse_polynomials, invert
from geometries.quadrature import on_panels

PANELS = 32  # of a polynomial, on each of which its arc length is integrated
GAUSS_POINTS = 16  # per panel


class Piece(Protocol):
    """A smooth curve of a `length` [mm] by its own arc length, 0 at its start."""

    @property
    def length(self) -> float:
        """Length [mm]."""

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm], shape (2, *s.shape)."""

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""


@dataclass(frozen=True)
class ArcPiece:
    """A circular arc, or a line where its curvature is 0, from a point on at an inclination."""

    start: tuple[float, float]  # (y, z) [mm]
    start_inclination: float  # [rad]
    constant_curvature: float  # [1/mm], negative where the centre lies above
    length: float  # [mm]

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm], shape (2, *s.shape)."""
        half = self.constant_curvature * s / 2
        chord, direction = s * np.sinc(half / np.pi), self.start_inclination + half
        y, z = self.start
        return np.stack([y + chord * np.cos(direction), z - chord * np.sin(direction)])

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""
        return self.start_inclination + self.constant_curvature * s

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""
        return np.full_like(s, self.constant_curvature)

    @property
    def mirrored(self) -> "ArcPiece":
        """The mirror image in y -> -y, run through from its other end."""
        end = np.array(self.length)
        y, z = self.position(end)
        inclination = -float(self.inclination(end))
        return ArcPiece((-float(y), float(z)), inclination, self.constant_curvature, self.length)


def line(start: tuple[float, float], end: tuple[float, float]) -> ArcPiece:
    """Return the line between two points (y, z) [mm]."""
    dy, dz = end[0] - start[0], end[1] - start[1]
    return ArcPiece(start, float(np.arctan2(-dz, dy)), 0.0, float(np.hypot(dy, dz)))


def arc_above(centre: tuple[float, float], radius: float, y: tuple[float, float]) -> ArcPiece:
    """Return the arc above its centre (y, z) between two lateral positions y [mm]; y grows."""
    start, end = np.arcsin((np.array(y) - centre[0]) / radius)
    z = centre[1] + radius * np.cos(start)
    return ArcPiece((y[0], float(z)), float(start), 1 / radius, radius * float(end - start))


def arc_below(centre: tuple[float, float], radius: float, y: tuple[float, float]) -> ArcPiece:
    """Return the arc below its centre (y, z) between two lateral positions y [mm]; y grows."""
    start, end = np.arcsin((np.array(y) - centre[0]) / radius)
    z = centre[1] - radius * np.cos(start)
    return ArcPiece((y[0], float(z)), -float(start), -1 / radius, radius * float(end - start))


@dataclass(frozen=True)
class PolynomialPiece:
    """A polynomial z(y) between two lateral positions [mm]; coefficients by rising powers of y.

    It is expanded about its middle in exact arithmetic: about y = 0 its terms cancel.
    """

    coefficients: tuple[float, ...]
    y: tuple[float, float]
    expansion: np.polynomial.Polynomial = field(init=False, repr=False, compare=False)
    slopes: tuple[np.polynomial.Polynomial, ...] = field(init=False, repr=False, compare=False)
    ends: Array = field(init=False, repr=False, compare=False)  # of panels, y [mm], (PANELS + 1,)
    to_ends: Array = field(init=False, repr=False, compare=False)  # arc lengths [mm], (PANELS + 1,)

    def __post_init__(self) -> None:
        expansion = expanded(self.coefficients, sum(self.y) / 2)
        object.__setattr__(self, "expansion", expansion)
        object.__setattr__(self, "slopes", (expansion.deriv(1), expansion.deriv(2)))
        object.__setattr__(self, "ends", np.linspace(*self.y, PANELS + 1))
        panels = self._length_between(self.ends[:-1], self.ends[1:])
        object.__setattr__(self, "to_ends", np.concatenate([[0.0], np.cumsum(panels)]))

    @property
    def length(self) -> float:
        """Length [mm]."""
        return float(self.to_ends[-1])

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm], shape (2, *s.shape)."""
        y = self._lateral(s)
        return np.stack([y, self.expansion(y - sum(self.y) / 2)])

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""
        return -np.arctan(self._derivative(self._lateral(s), 1))

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""
        y = self._lateral(s)
        return np.asarray(-self._derivative(y, 2) / self._speed(y) ** 3)

    def _lateral(self, s: Array) -> Array:
        """Lateral position [mm] at arc length s."""
        inverse = self._inverse
        return self._inverted(np.asarray(s)) if inverse is None else np.asarray(inverse(s))

    def _inverted(self, s: Array) -> Array:
        """Lateral position [mm] at arc length s by Newton's method."""
        return invert(self._arc_length, self._speed, s, (self.ends, self.to_ends))

    @cached_property
    def _inverse(self) -> PPoly | None:
        """The lateral position by the arc length, None where it is not exact."""
        return inverse_polynomials(self._arc_length, self._inverted, self.ends)

    def _arc_length(self, y: Array) -> Array:
        """Arc length [mm] from the start to the lateral position y."""
        panel = np.clip(np.searchsorted(self.ends, y, side="right") - 1, 0, PANELS - 1)
        return np.asarray(self.to_ends[panel] + self._length_between(self.ends[panel], y))

    def _length_between(self, start: Array, end: Array) -> Array:
        """Arc length [mm] between lateral positions on one panel."""
        y, weights = on_panels(np.asarray(start), np.asarray(end), GAUSS_POINTS)
        return np.asarray(np.sum(weights * self._speed(y), axis=-1))

    def _speed(self, y: Array) -> Array:
        """Derivative of the arc length by y."""
        return np.hypot(1.0, self._derivative(y, 1))

    def _derivative(self, y: Array, order: int) -> Array:
        """Derivative of z by y."""
        return np.asarray(self.slopes[order - 1](y - sum(self.y) / 2))


def expanded(coefficients: Sequence[float], about: float) -> np.polynomial.Polynomial:
    """Return the polynomial in y - about, in exact arithmetic from the decimal coefficients in y."""
    exact = [Fraction(repr(float(value))) for value in coefficients]
    powers = range(len(exact))
    shift = Fraction(repr(float(about)))
    moved = [sum(comb(j, k) * exact[j] * shift ** (j - k) for j in powers[k:]) for k in powers]
    return np.polynomial.Polynomial([float(value) for value in moved])


@dataclass(frozen=True)
class Outline:
    """Pieces, one after the other, by arc length; s = 0 at the start of the first.

    Where the pieces of a standard do not meet exactly, the gap stays (see `gaps`).
    """

    pieces: tuple[Piece, ...]

    @cached_property
    def joints(self) -> Array:
        """Arc lengths [mm] of both ends and of the joints between pieces, (n_pieces + 1,)."""
        return np.concatenate([[0.0], np.cumsum([piece.length for piece in self.pieces])])

    @property
    def length(self) -> float:
        """Length [mm]."""
        return float(self.joints[-1])

    def position(self, s: ArrayLike) -> Array:
        """Points (y, z) [mm], shape (2, *s.shape)."""
        return self._evaluate(s, lambda piece, own: piece.position(own), (2,))

    def inclination(self, s: ArrayLike) -> Array:
        """Inclination delta [rad], shape of s."""
        return self._evaluate(s, lambda piece, own: piece.inclination(own))

    def curvature(self, s: ArrayLike) -> Array:
        """Derivative of the inclination by the arc length [1/mm]; at joints of the next piece. Shape of s."""
        return self._evaluate(s, lambda piece, own: piece.curvature(own))

    @property
    def jumps(self) -> tuple[float, ...]:
        """Arc lengths [mm] of the joints between pieces, at which the curvature jumps."""
        return tuple(self.joints[1:-1].tolist())

    @property
    def gaps(self) -> tuple[Array, Array]:
        """Distances [mm] and differences of inclination [rad] of pieces at their joints, (n_pieces - 1,)."""
        ends = [np.array(piece.length) for piece in self.pieces[:-1]]
        start = np.array(0.0)
        pairs = list(zip(self.pieces[:-1], self.pieces[1:], ends, strict=True))
        apart = [np.hypot(*(b.position(start) - a.position(end))) for a, b, end in pairs]
        turn = [float(b.inclination(start) - a.inclination(end)) for a, b, end in pairs]
        return np.array(apart), np.array(turn)

    def sampled(self, spacing: float) -> Array:
        """Points (y, z) [mm], shape (2, n), at most `spacing` [mm] apart; each joint is one of them."""
        points = [self.pieces[0].position(np.zeros(1))]
        for piece in self.pieces:
            count = int(np.ceil(piece.length / spacing))
            points.append(piece.position(np.linspace(0, piece.length, count + 1)[1:]))
        return np.concatenate(points, axis=1)

    def _evaluate(
        self, s: ArrayLike, value: Callable[[Piece, Array], Array], parts: tuple[int, ...] = ()
    ) -> Array:
        """Return a value of each piece at the arc lengths s that lie on it, shape (*parts, *s.shape)."""
        at, last = np.asarray(s, dtype=float), len(self.pieces) - 1
        index = np.clip(np.searchsorted(self.joints, at, side="right") - 1, 0, last)
        first, last = (int(index.min()), int(index.max())) if index.size else (0, 0)
        if first == last:  # as many are
            return value(self.pieces[first], self._on_piece(first, at))
        result = np.empty((*parts, *at.shape))
        for k in range(first, last + 1):
            here = index == k
            if here.any():
                result[..., here] = value(self.pieces[k], self._on_piece(k, at[here]))
        return result

    def _on_piece(self, k: int, s: Array) -> Array:
        """Return arc lengths s [mm] from the start of a piece, at most its length; shape of s."""
        return np.clip(s - self.joints[k], 0, self.pieces[k].length)
