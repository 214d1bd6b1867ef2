"""Displacements and stresses inside a half-space under rectangles of uniform traction, in closed form.

Depth z grows into the half-space; tractions act along +x, +y, +z on its surface z = 0. Boussinesq and
Cerruti's displacements derive from h, the integral over the rectangle of ln(R + z), and from h1, that of z
ln(R + z) - R, with h = dh1/dz (Love 1929; Johnson, Contact Mechanics, section 3.2). With these potentials of
each traction, psi1 = h1(t_x),x + h1(t_y),y + h1(t_z),z and psi = psi1,z:

    4 pi G u_a = 2 h(t_a),z - h(t_z),a + 2 nu psi1,a - z psi,a      a = x, y
    4 pi G u_z = h(t_z),z + (1 - 2 nu) psi - z psi,z

Stresses follow from the derivatives by Hooke's law. Source: Johnson (1985), Contact Mechanics, section 3.2;
Love (1929); Kalker (1990), Three-dimensional elastic bodies in rolling contact, appendix C.

**Potentials** are sums over the corners of rectangles. With X, Y = observer minus corner, every derivative is
a difference over both pairs of edges of a function of (X, Y, z). Terms that this difference cancels are left
out: so logarithms are odd in X or Y and lose no digits. h and h1 are harmonic, and homogeneous but for such
terms: hence the short forms.

**Staircase.** Uniform elements are a staircase, where tractions in truth grow steadily along y by g per
length. The difference is a sawtooth, the sum over n = 1, 2, ... of g h (-1)^n / (pi n) sin(2 pi n y / h), h
the side of elements, y from the centre of an element. Below the centre, at depth z, the half-space's stresses
of these waves add up to, with q = exp(-2 pi z / h), C = 2 g z q / (1 + q), L = (g h / pi) ln(1 + q),

    traction along y:  yy: C - 2 L,  zz: -C,  xx: -2 nu L
    along z: yz: -C;    along x: xy: -L

At the surface that is 0.44 g h in yy: an error that falls only like h. Without it stresses are of second
order. Waves of tractions on a half-plane: Johnson (1985), Contact Mechanics, section 13.2.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from femic.stresses.field import StressField
from femic.stresses.near_surface import sample_centres
from femic.stresses.points import InnerPoints, SurfaceTractions, require_inside
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import WrongInput
from geometries.materials import Material

# --- field of tractions ---


def half_space_field(
    body: Body, tractions: SurfaceTractions, points: InnerPoints, *, between_centres: bool = True
) -> StressField:
    """Return the field of the tractions on a half-space, unrolled by the arc lengths x and s.

    Tractions that are uniform on elements, but not in truth, cause waves in x and s at depths of less than an
    element. So there the fields below the four nearest centres of elements are interpolated, less what the
    `staircase` adds to them, unless `between_centres` is False: then elements are taken at their word.
    Raises WrongInput for points outside the body, and at nu = 0.5.
    """
    require_inside(body, points)
    if not between_centres:
        return StressField(body, points, *on_half_space(body, tractions, points))
    samples = sample_centres(tractions.grid, points)
    u, stress = on_half_space(body, tractions, samples.points)
    stress[samples.on_lattice] -= staircase(body, tractions, samples.lattice_points)
    return StressField(body, points, samples.at_points(u), samples.at_points(stress))


def on_half_space(body: Body, tractions: SurfaceTractions, points: InnerPoints) -> tuple[Array, Array]:
    """Displacements (..., 3) [mm] and stresses (..., 3, 3) [MPa] along x, s, n on a half-space.

    n points out of the lower body and into the upper one.
    """
    to_depth = np.array([1.0, 1.0, body.side])  # signs of x, s, n as x, y, z of the half-space
    corners = lattice_corners(*tractions.edges, body.side * tractions.p * to_depth)
    flat = (values.ravel() for values in (points.x, points.s, points.depth))
    u, stress = fields(body.material, corners, *flat)
    return (
        (u * to_depth).reshape(*points.shape, 3),
        (stress * np.outer(to_depth, to_depth)).reshape(*points.shape, 3, 3),
    )


# --- potentials of rectangles ---

LEAST = 1e-150  # of a squared length [mm^2]: edges and corners themselves, where fields are singular
AT_ONCE = 2**16  # pairs of point and corner that are worked on at a time
H, H1 = "h", "h1"


Corners = tuple[Array, Array, Array]  # x, y [mm], (n,), and second differences of three tractions (n, 3)


def lattice_corners(x_edges: Array, y_edges: Array, tractions: Array) -> Corners:
    """The corners of a lattice of elements with tractions (n_x, n_y, 3), only those that count.

    At each corner it has the difference over both directions of its tractions.
    """
    padded = np.pad(tractions, ((1, 1), (1, 1), (0, 0)))
    differences = np.diff(np.diff(padded, axis=0), axis=1).reshape(-1, 3)
    counts = np.any(differences != 0, axis=1)
    x, y = (edges.ravel()[counts] for edges in np.meshgrid(x_edges, y_edges, indexing="ij"))
    return x, y, differences[counts]


def derivatives(corners: Corners, x: Array, y: Array, z: Array) -> dict[str, Array]:
    """Derivatives of h and h1 for the tractions of all rectangles, at points (n,); (n, 3 tractions) each.

    The key is the potential and what it is differentiated by, e.g. "h_xxz". All second and third derivatives
    of h are among them, by Laplace's equation.
    """
    corners_x, corners_y, differences = corners
    sums: dict[str, list[Array]] = {}
    n = max(1, AT_ONCE // max(1, len(corners_x)))
    for start in range(0, len(x), n):
        part = slice(start, start + n)
        terms = _terms(x[part, None] - corners_x, y[part, None] - corners_y, z[part, None])
        for name, values in terms:
            sums.setdefault(name, []).append(values @ differences)
    known = {name: np.concatenate(parts) for name, parts in sums.items()}
    return known | {
        "h_zz": -known["h_xx"] - known["h_yy"],
        "h_zzz": -known["h_xxz"] - known["h_yyz"],
        "h_xxx": -known["h_xyy"] - known["h_xzz"],
        "h_yyy": -known["h_xxy"] - known["h_yzz"],
    }


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


def derivative(known: Mapping[str, Array], potential: str, by: str) -> Array:
    """A derivative of h or h1 from those of `derivatives`, whatever the order of `by`; shape (n, 3)."""
    by = "".join(sorted(by))
    if potential == H1 and "z" in by:
        potential, by = H, by.replace("z", "", 1)
    return known[f"{potential}_{by}"]


# --- displacements and stresses of the potentials ---

AXES = "xyz"


def fields(material: Material, corners: Corners, x: Array, y: Array, z: Array) -> tuple[Array, Array]:
    """Displacements (n, 3) [mm] and stresses (n, 3, 3) [MPa] along x, y and the depth z, at points (n,)."""
    known, nu = derivatives(corners, x, y, z), material.nu

    def h(traction: str, by: str) -> Array:
        """A derivative of h of one traction, shape (n,)."""
        return derivative(known, H, by)[:, AXES.index(traction)]

    def psi(potential: str, by: str) -> Array:
        """A derivative of psi (from h) or psi1 (from h1), shape (n,)."""
        return np.sum([derivative(known, potential, d + by)[:, j] for j, d in enumerate(AXES)], axis=0)

    def displacement(a: str, b: str = "") -> Array:
        """4 pi G u_a, shape (n,), or its derivative by b."""
        if a == "z":
            value = h("z", "z" + b) + (1 - 2 * nu) * psi(H, b) - z * psi(H, "z" + b)
        else:
            value = 2 * h(a, "z" + b) - h("z", a + b) + 2 * nu * psi(H1, a + b) - z * psi(H, a + b)
        return value - psi(H, a) if b == "z" else value

    scale = 1 / (4 * np.pi * material.G)
    u = np.stack([displacement(a) for a in AXES], axis=-1)
    gradient = np.stack([np.stack([displacement(a, b) for b in AXES], axis=-1) for a in AXES], axis=-2)
    return scale * u, hooke_stress(material, scale * gradient)


def hooke_stress(material: Material, gradient: Array) -> Array:
    """Return Hooke's stresses (..., 3, 3) [MPa] from the gradient du_a/dx_b of displacements (..., 3, 3).

    Raises WrongInput at nu = 0.5, where strains do not determine stresses.
    """
    if not np.isfinite(material.lame):
        raise WrongInput(f"nu = {material.nu!r}: stresses need a compressible material; give nu < 0.5")
    strain = (gradient + np.swapaxes(gradient, -1, -2)) / 2
    dilatation = np.trace(strain, axis1=-2, axis2=-1)[..., None, None]
    return np.asarray(2 * material.G * strain + material.lame * dilatation * np.eye(3))


# --- staircase of uniform elements ---

Z = 2


def staircase(
    body: Body, tractions: SurfaceTractions, centres: InnerPoints, *, along_x: bool = True
) -> Array:
    """Stresses (n, 3, 3) along x, s, n of the staircase less the steady tractions, below centres (n,).

    Without `along_x` only the steps from strip to strip count, and points may lie anywhere along x.
    """
    to_depth, grid = np.array([1.0, 1.0, body.side]), tractions.grid
    p = np.pad(tractions.p, ((3, 4), (3, 3), (0, 0)))
    place = np.clip((centres.x - tractions.x[0]) / grid.dx + 3, 1, grid.n_x + 4)
    i = np.floor(place).astype(int)
    share = (place - i)[:, None]
    j = np.clip(np.rint((centres.s - grid.strips[0]) / grid.ds).astype(int) + 3, 1, grid.n_s + 4)

    def near(ahead: int, aside: int) -> Array:
        return (1 - share) * p[i + ahead, j + aside] + share * p[i + 1 + ahead, j + aside]

    # Mean steps to the next elements along x and along s [MPa], (n, 3) each; 0 beyond the grid.
    steps_x, steps_s = (near(1, 0) - near(-1, 0)) / 2, (near(0, 1) - near(0, -1)) / 2
    stress = np.zeros((len(centres.x), 3, 3))
    for y, x, h, steps in ((0, 1, grid.dx, along_x * steps_x), (1, 0, grid.ds, steps_s)):
        rise = body.side * steps * to_depth  # g h
        ratio = centres.depth / h
        q = np.exp(-2 * np.pi * ratio)
        C, L = rise * (2 * ratio * q / (1 + q))[:, None], rise * (np.log1p(q) / np.pi)[:, None]
        stress[:, y, y] += C[:, y] - 2 * L[:, y]
        stress[:, x, x] -= 2 * body.material.nu * L[:, y]
        stress[:, Z, Z] -= C[:, y]
        for a, b, value in ((y, Z, C[:, Z]), (x, y, L[:, x])):
            stress[:, a, b] -= value
            stress[:, b, a] -= value
    return np.asarray(stress * np.outer(to_depth, to_depth))
