"""Potentials of a uniformly loaded rectangle of a half-space, as sums over its corners.

Boussinesq and Cerruti's displacements derive from h, the integral over the rectangle of ln(R + z), and from
h1, that of z ln(R + z) - R, with h = dh1/dz (Love 1929; Johnson, Contact Mechanics, section 3.2). z is the
depth. With X, Y = observer minus corner, every derivative is a difference over both pairs of edges of a
function of (X, Y, z). Terms that this difference cancels are left out: so logarithms are odd in X or Y and
lose no digits. h and h1 are harmonic, and homogeneous but for such terms: hence the short forms.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array

LEAST = 1e-150  # of a squared length [mm^2]: edges and corners themselves, where fields are singular
AT_ONCE = 2**16  # pairs of point and corner that are worked on at a time
H, H1 = "h", "h1"


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners of rectangles at x, y [mm], shape (n,), and second differences of three tractions there (n, 3).

    A lattice of elements has the difference over both directions of its tractions at each corner.
    """

    x: Array
    y: Array
    differences: Array

    @classmethod
    def of_lattice(cls, x_edges: Array, y_edges: Array, tractions: Array) -> "Corners":
        """The corners of a lattice of elements with tractions (n_x, n_y, 3), only those that count."""
        padded = np.pad(tractions, ((1, 1), (1, 1), (0, 0)))
        differences = np.diff(np.diff(padded, axis=0), axis=1).reshape(-1, 3)
        counts = np.any(differences != 0, axis=1)
        x, y = (edges.ravel()[counts] for edges in np.meshgrid(x_edges, y_edges, indexing="ij"))
        return cls(x, y, differences[counts])


def derivatives(corners: Corners, x: Array, y: Array, z: Array) -> dict[str, Array]:
    """Derivatives of h and h1 for the tractions of all rectangles, at points (n,); (n, 3 tractions) each.

    The key is the potential and what it is differentiated by, e.g. "h_xxz".
    """
    sums: dict[str, list[Array]] = {}
    n = max(1, AT_ONCE // max(1, len(corners.x)))
    for start in range(0, len(x), n):
        part = slice(start, start + n)
        terms = _terms(x[part, None] - corners.x, y[part, None] - corners.y, z[part, None])
        for name, values in terms:
            sums.setdefault(name, []).append(values @ corners.differences)
    return _completed({name: np.concatenate(parts) for name, parts in sums.items()})


def _terms(X: Array, Y: Array, z: Array) -> Iterator[tuple[str, Array]]:
    """Independent derivatives at X, Y = point minus corner and depth z >= 0; arrays broadcast."""
    XX, YY, zz = X * X, Y * Y, z * z
    from_x, from_y = np.maximum(XX + zz, LEAST), np.maximum(YY + zz, LEAST)  # from the edges along y, along x
    R = np.sqrt(np.maximum(XX + from_y, LEAST))
    sum_ = R + z
    XY, raised = X * Y, (XX + YY) / sum_  # R - z
    log_y, log_x = np.arcsinh(Y / np.sqrt(from_x)), np.arcsinh(X / np.sqrt(from_y))
    log_z = np.log(sum_)
    angle_x = np.arctan2(XY * raised, XX * R + z * YY)
    angle_y = np.arctan2(XY * raised, YY * R + z * XX)
    x_share, y_share = X / sum_, Y / sum_
    yield "h_xx", angle_x
    yield "h_yy", angle_y
    yield "h_xy", log_z
    yield "h_xz", log_y
    yield "h_yz", log_x
    yield "h_x", Y * log_z + z * log_y + X * angle_x
    yield "h_y", X * log_z + z * log_x + Y * angle_y
    yield "h_z", X * log_y + Y * log_x - z * (angle_x + angle_y)
    yield "h1_xx", z * angle_x - X * log_y
    yield "h1_yy", z * angle_y - Y * log_x
    yield "h1_xy", z * log_z - R
    yield "h1_xxx", y_share - log_y
    yield "h1_yyy", x_share - log_x
    yield "h1_xxy", -x_share
    yield "h1_xyy", -y_share
    yield "h_xxy", x_share / R
    yield "h_xyy", y_share / R
    yield "h_xyz", 1 / R
    yield "h_xxz", -XY / (R * from_x)
    yield "h_yyz", -XY / (R * from_y)
    yield "h_xzz", -z * Y / (R * from_x)
    yield "h_yzz", -z * X / (R * from_y)


def _completed(of: dict[str, Array]) -> dict[str, Array]:
    """All second and third derivatives of h, by Laplace's equation."""
    return of | {
        "h_zz": -of["h_xx"] - of["h_yy"],
        "h_zzz": -of["h_xxz"] - of["h_yyz"],
        "h_xxx": -of["h_xyy"] - of["h_xzz"],
        "h_yyy": -of["h_xxy"] - of["h_yzz"],
    }


def derivative(of: Mapping[str, Array], potential: str, by: str) -> Array:
    """A derivative of h or h1 from those of `derivatives`, whatever the order of `by`; shape (n, 3)."""
    by = "".join(sorted(by))
    if potential == H1 and "z" in by:
        potential, by = H, by.replace("z", "", 1)
    return of[f"{potential}_{by}"]
