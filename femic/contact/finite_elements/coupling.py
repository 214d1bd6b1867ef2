"""Mortar coupling: weighted gaps of two meshed surfaces, and the forces of pressures on both bodies.

The gap along the lower normals n, between points opposite each other along n,

    g = h - zeta cos(delta) + (u_upper - u_lower).n,

is weighted with functions psi_i of the vertices of the lower surface, in its chart (x, s): g_i = integral of
psi_i g >= 0. The pressures are p = sum of p_i psi_i, with p_i >= 0 and g_i p_i = 0. These are the conditions
of least energy with bounds, so both bodies feel the same pressures.

The psi_i are dual to the linear hat functions phi_i: on a triangle 4 phi_i - 1, so that the integral of psi_i
phi_j vanishes for i != j, and that of psi_i phi_i is that of phi_i, the area of the vertex. So p_i is the
mean of p near a vertex: where the field of displacement is linear, the vertex bears p_i times its area. (Hat
functions themselves, p = sum of p_i phi_i, give pressures that alternate by 15 % of the largest one at the
edge of a patch; these do not.) Source: Wohlmuth (2011), Acta Numerica 20, 569-734.

Integrals are taken on the overlaps of the triangles of both surfaces, their common refinement. A field that
is a polynomial on each triangle of the one and of the other is one on each overlap, so that products of both
are integrated exactly. An overlap is convex: the triangles from its middle to its sides.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_matrix, diags_array, hstack
from skfem import MeshTri
from skfem.quadrature import get_quadrature
from skfem.refdom import RefTri

from femic.contact.exact.hertz import combined_modulus
from femic.contact.finite_elements.bodies import Elastic
from femic.contact.undeformed import Undeformed
from femic.reference.solid.mesh import Trace
from geometries.arrays import Array, Indices
from geometries.errors import Failure

# --- overlaps of two triangulations ---

ORDER = 5  # of the quadrature on each part of an overlap
ROUNDING = 1e-12  # of barycentric coordinates
SMALLEST = 1e-14  # area of a part that counts, as a share of that of the triangle


def overlaps(first: Array, second: Array) -> tuple[Array, Array, Indices, Indices]:
    """Quadrature on the overlaps of triangles with the corners first (2, 3, n) and second (2, 3, m).

    Returns points (2, k), weights (k,), and the triangle of each mesh in which each point lies, (k,).
    """
    (low_1, high_1), (low_2, high_2) = ((t.min(axis=1), t.max(axis=1)) for t in (first, second))
    near = np.ones((first.shape[2], second.shape[2]), dtype=bool)  # whose bounding boxes overlap
    for d in range(2):
        near &= (low_1[d][:, None] <= high_2[d]) & (low_2[d] <= high_1[d][:, None])
    i, j = np.nonzero(near)
    corners = _corners(first[:, :, i], second[:, :, j])  # (2, 15, n_pairs), nan where there is none
    parts, pair = _parts(corners)  # (2, 3, n_parts)
    area = np.abs(_cross(parts[:, 1] - parts[:, 0], parts[:, 2] - parts[:, 0])) / 2
    whole = np.abs(_cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])) / 2
    large_enough = area > SMALLEST * whole[i[pair]]
    parts, pair, area = parts[:, :, large_enough], pair[large_enough], area[large_enough]
    local, weights = get_quadrature(RefTri, ORDER)
    shares = np.stack([1 - local.sum(axis=0), *local])  # (3, n_q)
    points = np.einsum("dcn,cq->dnq", parts, shares).reshape(2, -1)
    pair = np.repeat(pair, len(weights))
    return points, np.outer(area, 2 * weights).ravel(), i[pair], j[pair]


def barycentric(corners: Array, points: Array) -> Array:
    """Barycentric coordinates (3, n) of points (2, n) in triangles (2, 3, n)."""
    origin = corners[:, 0]
    to_1, to_2, to_point = corners[:, 1] - origin, corners[:, 2] - origin, points - origin
    twice = _cross(to_1, to_2)
    second, third = _cross(to_point, to_2) / twice, _cross(to_1, to_point) / twice
    return np.stack([1 - second - third, second, third])


def _cross(a: Array, b: Array) -> Array:
    """Return the z component of the product of plane vectors (2, ...)."""
    return np.asarray(a[0] * b[1] - a[1] * b[0])


def _corners(first: Array, second: Array) -> Array:
    """Corners of the overlaps of pairs of triangles (2, 3, n), shape (2, 15, n), nan for missing ones.

    They are the corners of one triangle that lie in the other, and the places in which sides cross.
    """
    found = []
    for own, other in ((first, second), (second, first)):
        shares = np.stack([barycentric(other, own[:, k]) for k in range(3)], axis=1)  # (3, corner, n)
        found.append(np.where(np.all(shares >= -ROUNDING, axis=0), own, np.nan))
    for k, m in product(range(3), repeat=2):
        crossing = _crossing(first[:, [k, (k + 1) % 3]], second[:, [m, (m + 1) % 3]])
        found.append(crossing[:, None])
    return np.concatenate(found, axis=1)


def _crossing(a: Array, b: Array) -> Array:
    """Return points (2, n) in which segments a and b (2, 2 ends, n) cross; nan where they do not."""
    along_a, along_b, between = a[:, 1] - a[:, 0], b[:, 1] - b[:, 0], b[:, 0] - a[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        twice = _cross(along_a, along_b)
        on_a, on_b = _cross(between, along_b) / twice, _cross(between, along_a) / twice
    cross = (on_a >= 0) & (on_a <= 1) & (on_b >= 0) & (on_b <= 1)  # False for parallel ones
    return np.where(cross, a[:, 0] + np.where(cross, on_a, 0.0) * along_a, np.nan)


def _parts(corners: Array) -> tuple[Array, Indices]:
    """Triangles (2, 3, n_parts) from the middle of each overlap to its sides, and the overlap of each.

    Corners are sorted by their direction from the middle; the missing ones, nan, are put in the place of
    the first, where they make triangles without area.
    """
    pairs = np.flatnonzero(np.sum(~np.isnan(corners[0]), axis=0) >= 3)
    corners = corners[:, :, pairs]
    middle = np.nanmean(corners, axis=1)
    direction = np.arctan2(*(corners - middle[:, None])[::-1])
    order = np.argsort(direction, axis=0)  # nan come last
    ring = np.take_along_axis(corners, np.broadcast_to(order, corners.shape), axis=1)
    ring = np.where(np.isnan(ring), ring[:, :1], ring)
    following = np.roll(ring, -1, axis=1)
    parts = np.stack([np.broadcast_to(middle[:, None], ring.shape), ring, following], axis=1)
    return parts.reshape(2, 3, -1), np.tile(pairs, ring.shape[1])


# --- weighted gaps ---

COVERED = 1e-6  # share of the area of the lower surface that overlaps may miss, or cover twice
ROOM = 0.1  # around the part of the upper surface opposite the zone, as a share of its lengths


@dataclass(frozen=True, eq=False)
class CoupledBodies:
    """Two bodies, their weighted gaps g = h - zeta c + B_upper u_upper - B_lower u_lower, integrals of psi.

    Pressures are sought at m vertices of the lower surface. Everything is on the modelled part of the bodies.
    Held components have no entries. What pressures p do as a whole is the sum of p times an integral: the
    vertical force c.p, the lateral one sine.p.
    """

    lower: Elastic
    upper: Elastic
    vertices: Indices  # (m,), among those of the trace of the lower body
    x: Array  # (m,) places of the vertices [mm]
    s: Array  # (m,) [mm]
    B_lower: csr_matrix  # (m, unknowns of the lower body) [mm^2]
    B_upper: csr_matrix
    h: Array  # (m,) undeformed gap [mm^3]
    c: Array  # (m,) of cos(delta) [mm^2]
    sine: Array  # (m,) of sin(delta) [mm^2]
    arm: Array  # (m,) of the lever arm of the normal about the x axis through the contact centre [mm^3]
    s_moment: Array  # (m,) of the arc length [mm^3]
    area: Array  # (m,) of the functions themselves [mm^2]
    roughness: Array  # (m, m) [N^2 / (N mm) per MPa^2]: approximate inverse of the weighted compliance

    def gap(self, u_lower: Array, u_upper: Array, approach: float) -> Array:
        """Weighted gaps [mm^3], shape (m,), at displacements and an approach [mm]."""
        return np.asarray(self.h - approach * self.c + self.B_upper @ u_upper - self.B_lower @ u_lower)


def couple(lower: Elastic, upper: Elastic, undeformed: Undeformed, vertices: Indices) -> CoupledBodies:
    """Couple two bodies at vertices (m,) of the lower surface, at which pressures are sought.

    Raises Failure where these are not opposite the upper surface, or opposite several points of it.
    """
    trace, upper_mesh = lower.solid.trace, upper.solid.trace.basis.mesh
    mesh, contour = trace.basis.mesh, undeformed.lower.contour
    first = np.flatnonzero(np.isin(mesh.t, vertices).any(axis=0))
    second = _opposite(undeformed, mesh.p[:, np.unique(mesh.t[:, first])], upper_mesh)
    projected = on_lower(undeformed, upper_mesh.p)
    points, weights, in_first, in_second = overlaps(
        mesh.p[:, mesh.t[:, first]], projected[:, upper_mesh.t[:, second]]
    )
    whole, covered = float(trace.basis.dx[first].sum()), float(weights.sum())
    if not covered >= (1 - COVERED) * whole:
        raise Failure(
            f"potential contact area: {covered:g} of {whole:g} mm^2 lie opposite the upper surface; "
            "give a larger `far_radius`, or a smaller load"
        )
    if covered > (1 + COVERED) * whole:
        raise Failure(
            f"potential contact area: {covered - whole:g} of {whole:g} mm^2 are opposite several points of "
            "the upper surface; give a smaller load, or contours that end earlier"
        )
    distance = undeformed.distance(*points)
    normal = np.stack([np.zeros(points.shape[1]), *contour.normal(points[1])])
    y, z = contour.position(points[1])
    own = mesh.t[:, first[in_first]]
    duals = _rows(4 * barycentric(mesh.p[:, own], points) - 1, own, mesh.nvertices)[:, vertices]
    weighted = csr_matrix(duals.T @ diags_array(weights))  # (m, n)
    area = np.asarray(weighted.sum(axis=1)).ravel()
    modulus = combined_modulus(lower.solid.body.material, upper.solid.body.material)
    return CoupledBodies(
        lower,
        upper,
        vertices,
        mesh.p[0, vertices],
        mesh.p[1, vertices],
        _against(weighted, normal, lower, first[in_first], points),
        _against(weighted, normal, upper, second[in_second], on_upper(undeformed, points, distance)),
        weighted @ distance,
        weighted @ normal[2],
        weighted @ normal[1],
        weighted @ (y * normal[2] - z * normal[1]),
        weighted @ points[1],
        area,
        _roughness(trace, first, vertices, area, modulus),
    )


def on_lower(undeformed: Undeformed, chart: Array) -> Array:
    """Return points (x, s) whose lower normals meet the upper surface at chart points (xi, t), (2, n)."""
    x, y, z = undeformed.upper.position(*chart)
    section = np.stack([y + undeformed.shift, z + undeformed.touching[1]])
    reach = np.abs(chart[1]).max() + abs(undeformed.upper_offset)
    return np.stack([x, undeformed.lower.contour.nearest(section, (-reach, reach))])


def on_upper(undeformed: Undeformed, points: Array, distance: Array) -> Array:
    """Chart points (xi, t) of the upper surface opposite points (x, s) of the lower one, (2, n)."""
    x, s = points
    y, z = undeformed.lower.contour.position(s) + distance * undeformed.lower.contour.normal(s)
    xi, y, z = undeformed.upper.to_chart(np.stack([x, y - undeformed.shift, z - undeformed.touching[1]]))
    reach = np.abs(s).max() + abs(undeformed.upper_offset) + np.abs(distance).max()
    return np.stack([xi, undeformed.upper.contour.nearest(np.stack([y, z]), (-reach, reach))])


def _opposite(undeformed: Undeformed, points: Array, upper: MeshTri) -> Indices:
    """Return the upper triangles near the points that are opposite points (2, n) of the lower surface.

    Others may be projected onto the same part of it: the far side of a wheel, or what lies above the centre
    of a groove.
    """
    distance = undeformed.distance(*points)
    met = np.isfinite(distance)
    chart = on_upper(undeformed, points[:, met], distance[met])
    room = ROOM * np.ptp(chart, axis=1)
    low, high = chart.min(axis=1) - room, chart.max(axis=1) + room
    corners = upper.p[:, upper.t]  # (2, 3, n_triangles)
    apart = (corners.max(axis=1) < low[:, None]) | (corners.min(axis=1) > high[:, None])
    return np.flatnonzero(~apart.any(axis=0))


def _rows(values: Array, columns: Indices, n_columns: int) -> csr_matrix:
    """Return a matrix (n, n_columns) with some values per row, shape (k, n) like their columns."""
    n = values.shape[1]
    starts = np.arange(n + 1) * len(values)
    return csr_matrix((values.T.ravel(), columns.T.ravel(), starts), shape=(n, n_columns))


def _against(weighted: csr_matrix, normal: Array, body: Elastic, triangles: Indices, at: Array) -> csr_matrix:
    """Integrals of the functions psi times u.n, shape (m, unknowns), from chart points `at` (2, n)."""
    trace = body.solid.trace
    shares = barycentric(trace.basis.mesh.p[:, trace.basis.mesh.t[:, triangles]], at)
    edges = [4 * shares[i] * shares[j] for i, j in ((0, 1), (1, 2), (0, 2))]
    quadratic = np.stack([*(shares * (2 * shares - 1)), *edges])  # functions of vertices, of edges; (6, n)
    nodes = trace.nodes[trace.basis.element_dofs[:, triangles]]
    values = _rows(quadratic, nodes, body.solid.nodes.shape[1])
    blocks = hstack([weighted @ diags_array(n) @ values for n in normal], format="csc")
    by_node = np.arange(blocks.shape[1]).reshape(3, -1).T.ravel()  # x of all nodes, y, z: to x, y, z by node
    return csr_matrix(blocks[:, by_node] @ diags_array(np.where(body.held.ravel(), 0.0, 1.0)))


def _roughness(trace: Trace, triangles: Indices, vertices: Indices, area: Array, modulus: float) -> Array:
    """Approximate inverse of the weighted compliance: (E*/2) times the root of -Laplace + 1/size^2; (m, m).

    Waves of pressure of wavenumber k displace a surface by 2 p / (E* k), however it is shaped as long as
    they are short. It only preconditions: results do not depend on it.
    """
    mesh = trace.basis.mesh
    corners = mesh.p[:, mesh.t[:, triangles]]  # (2, 3, n)
    sides = np.roll(corners, -1, axis=1) - np.roll(corners, -2, axis=1)
    size = trace.basis.dx[triangles].sum(axis=1)
    products = np.einsum("din,djn->ijn", sides, sides) / (4 * size)  # of the gradients of hat functions
    i, j = (
        np.broadcast_to(mesh.t[:, triangles][index], products.shape)
        for index in (np.s_[:, None], np.s_[None])
    )
    n = mesh.nvertices
    matrix = csr_matrix((products.ravel(), (i.ravel(), j.ravel())), shape=(n, n))
    squares, waves = eigh(matrix[vertices][:, vertices].toarray(), np.diag(area))
    least = 1 / float(area.sum())
    return np.asarray((waves * (modulus / 2 * np.sqrt(np.maximum(squares, 0) + least))) @ waves.T)
