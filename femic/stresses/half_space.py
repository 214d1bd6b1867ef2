"""Displacements and stresses inside a half-space under rectangles of uniform traction, in closed form.

Depth z grows into the half-space; tractions act along +x, +y, +z on its surface z = 0. With the potentials h
and h1 of each traction (`corners`), psi1 = h1(t_x),x + h1(t_y),y + h1(t_z),z and psi = psi1,z:

    4 pi G u_a = 2 h(t_a),z - h(t_z),a + 2 nu psi1,a - z psi,a      a = x, y
    4 pi G u_z = h(t_z),z + (1 - 2 nu) psi - z psi,z

Stresses follow from the derivatives by Hooke's law. Source: Johnson (1985), Contact Mechanics, section 3.2;
Love (1929); Kalker (1990), Three-dimensional elastic bodies in rolling contact, appendix C.
"""

from collections.abc import Mapping

import numpy as np

from femic.stresses.centred import centred
from femic.stresses.corners import H1, Corners, H, derivative, derivatives
from femic.stresses.field import StressField
from femic.stresses.points import InnerPoints, require_inside
from femic.stresses.staircase import staircase
from femic.stresses.tractions import SurfaceTractions
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import WrongInput
from geometries.materials import Material

AXES = "xyz"


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
    samples = centred(tractions.grid, points)
    u, stress = on_half_space(body, tractions, samples.points)
    stress[samples.on_lattice] -= staircase(body, tractions, samples.lattice_points)
    return StressField(body, points, samples.at_points(u), samples.at_points(stress))


def on_half_space(body: Body, tractions: SurfaceTractions, points: InnerPoints) -> tuple[Array, Array]:
    """Displacements (..., 3) [mm] and stresses (..., 3, 3) [MPa] along x, s, n on a half-space.

    n points out of the lower body and into the upper one.
    """
    to_depth = np.array([1.0, 1.0, body.side])  # signs of x, s, n as x, y, z of the half-space
    corners = Corners.of_lattice(*tractions.edges, body.side * tractions.p * to_depth)
    flat = (values.ravel() for values in (points.x, points.s, points.depth))
    u, stress = fields(body.material, corners, *flat)
    return (
        (u * to_depth).reshape(*points.shape, 3),
        (stress * np.outer(to_depth, to_depth)).reshape(*points.shape, 3, 3),
    )


def fields(material: Material, corners: Corners, x: Array, y: Array, z: Array) -> tuple[Array, Array]:
    """Displacements (n, 3) [mm] and stresses (n, 3, 3) [MPa] along x, y and the depth z, at points (n,)."""
    of = derivatives(corners, x, y, z)
    scale = 1 / (4 * np.pi * material.G)
    u = np.stack([_displacement(of, z, material.nu, a) for a in AXES], axis=-1)
    gradient = np.stack(
        [np.stack([_slope(of, z, material.nu, a, b) for b in AXES], axis=-1) for a in AXES], axis=-2
    )
    return scale * u, stress_of(material, scale * gradient)


def stress_of(material: Material, gradient: Array) -> Array:
    """Return Hooke's stresses (..., 3, 3) [MPa] from the gradient du_a/dx_b of displacements (..., 3, 3).

    Raises WrongInput at nu = 0.5, where strains do not determine stresses.
    """
    if not np.isfinite(material.lame):
        raise WrongInput(f"nu = {material.nu!r}: stresses need a compressible material; give nu < 0.5")
    strain = (gradient + np.swapaxes(gradient, -1, -2)) / 2
    dilatation = np.trace(strain, axis1=-2, axis2=-1)[..., None, None]
    return np.asarray(2 * material.G * strain + material.lame * dilatation * np.eye(3))


def _displacement(of: Mapping[str, Array], z: Array, nu: float, a: str) -> Array:
    """4 pi G u_a, shape (n,)."""
    if a == "z":
        return _h(of, "z", "z") + (1 - 2 * nu) * _psi(of, H, "") - z * _psi(of, H, "z")
    return 2 * _h(of, a, "z") - _h(of, "z", a) + 2 * nu * _psi(of, H1, a) - z * _psi(of, H, a)


def _slope(of: Mapping[str, Array], z: Array, nu: float, a: str, b: str) -> Array:
    """4 pi G du_a/db, shape (n,)."""
    by_depth = _psi(of, H, a) if b == "z" else 0.0
    if a == "z":
        slope = _h(of, "z", "z" + b) + (1 - 2 * nu) * _psi(of, H, b) - z * _psi(of, H, "z" + b)
    else:
        slope = 2 * _h(of, a, "z" + b) - _h(of, "z", a + b) + 2 * nu * _psi(of, H1, a + b)
        slope = slope - z * _psi(of, H, a + b)
    return slope - by_depth


def _h(of: Mapping[str, Array], traction: str, by: str) -> Array:
    """A derivative of h of one traction, shape (n,)."""
    return derivative(of, H, by)[:, AXES.index(traction)]


def _psi(of: Mapping[str, Array], potential: str, by: str) -> Array:
    """A derivative of psi (from h) or psi1 (from h1), shape (n,)."""
    return np.sum([derivative(of, potential, d + by)[:, j] for j, d in enumerate(AXES)], axis=0)
