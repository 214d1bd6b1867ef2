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

import numpy as np
from scipy.sparse import csr_matrix, diags_array, hstack
from skfem import MeshTri
from skfem.quadrature import get_quadrature
from skfem.refdom import RefTri

from femic.contact.finite_elements.bodies import Elastic
from femic.contact.undeformed import Undeformed
from femic.reference.solid.mesh import Trace
from geometries.arrays import Array, Indices, Mask
from geometries.errors import Failure

# --- overlaps of two triangulations ---

ORDER = 5  # of the quadrature on each part of an overlap
ROUNDING = 1e-12  # of barycentric coordinates
SMALLEST = 1e-14  # area of a part that counts, as a share of that of the triangle


@dataclass(frozen=True, eq=False)
class Quadrature:
    """Points (2, n) and weights (n,) on overlaps; the triangle of each mesh in which each lies, (n,)."""

    points: Array
    weights: Array
    of_first: Indices
    of_second: Indices


def overlaps(first: Array, second: Array) -> Quadrature:
    """Quadrature on the overlaps of triangles with the corners first (2, 3, n) and second (2, 3, m)."""
    i, j = _near(first, second)
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
    return Quadrature(points, np.outer(area, 2 * weights).ravel(), i[pair], j[pair])


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


def _near(first: Array, second: Array) -> tuple[Indices, Indices]:
    """Return numbers of the pairs of triangles whose bounding boxes overlap, (n_pairs,) each."""
    (low_1, high_1), (low_2, high_2) = ((t.min(axis=1), t.max(axis=1)) for t in (first, second))
    near = np.ones((first.shape[2], second.shape[2]), dtype=bool)
    for d in range(2):
        near &= (low_1[d][:, None] <= high_2[d]) & (low_2[d] <= high_1[d][:, None])
    i, j = np.nonzero(near)
    return i, j


def _corners(first: Array, second: Array) -> Array:
    """Corners of the overlaps of pairs of triangles (2, 3, n), shape (2, 15, n), nan for missing ones."""
    inner = [_inside(first, second), _inside(second, first)]
    crossings = [
        _crossing(first[:, [k, (k + 1) % 3]], second[:, [m, (m + 1) % 3]])[:, None]
        for k in range(3)
        for m in range(3)
    ]
    return np.concatenate([*inner, *crossings], axis=1)


def _inside(corners: Array, triangles: Array) -> Array:
    """Return the corners (2, 3, n) that lie in the triangles (2, 3, n); nan for the others."""
    shares = np.stack([barycentric(triangles, corners[:, k]) for k in range(3)], axis=1)  # (3, corner, n)
    return np.where(np.all(shares >= -ROUNDING, axis=0), corners, np.nan)


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
class Zone:
    """The vertices of the lower surface at which pressures are sought, (m,): where contact is possible."""

    vertices: Indices  # among those of the trace
    x: Array  # [mm]
    s: Array  # [mm]


@dataclass(frozen=True, eq=False)
class Coupling:
    """Weighted gaps g = h - zeta c + upper u_upper - lower u_lower, and integrals of the functions psi.

    Everything on the modelled part of the bodies. Held components have no entries. What pressures p do as a
    whole is the sum of p times an integral: the vertical force c.p, the lateral one sine.p.
    """

    zone: Zone
    lower: csr_matrix  # (m, unknowns of the lower body) [mm^2]
    upper: csr_matrix
    h: Array  # (m,) undeformed gap [mm^3]
    c: Array  # (m,) of cos(delta) [mm^2]
    sine: Array  # (m,) of sin(delta) [mm^2]
    arm: Array  # (m,) of the lever arm of the normal about the x axis through the contact centre [mm^3]
    of_s: Array  # (m,) of the arc length [mm^3]
    area: Array  # (m,) of the functions themselves [mm^2]
    slopes: csr_matrix  # (m, m) of the products of the gradients of the hat functions


def select_zone(trace: Trace, selected: Mask) -> Zone:
    """Return the vertices of a surface that are `selected`, (n_vertices,)."""
    vertices = np.flatnonzero(selected)
    return Zone(vertices, *trace.basis.mesh.p[:, vertices])


def couple(lower: Elastic, upper: Elastic, undeformed: Undeformed, zone: Zone) -> Coupling:
    """Couple two bodies in a zone; raises Failure where the zone is not opposite the upper surface."""
    lower_mesh, upper_mesh = lower.solid.trace.basis.mesh, upper.solid.trace.basis.mesh
    first = np.flatnonzero(np.isin(lower_mesh.t, zone.vertices).any(axis=0))
    second = _opposite(undeformed, lower_mesh.p[:, np.unique(lower_mesh.t[:, first])], upper_mesh)
    projected = on_lower(undeformed, upper_mesh.p)
    quadrature = overlaps(lower_mesh.p[:, lower_mesh.t[:, first]], projected[:, upper_mesh.t[:, second]])
    of_lower, of_upper, points = first[quadrature.of_first], second[quadrature.of_second], quadrature.points
    _check_covered(lower.solid.trace, first, quadrature.weights)
    distance = undeformed.distance(*points)
    normal = np.stack([np.zeros(points.shape[1]), *undeformed.lower.contour.normal(points[1])])
    y, z = undeformed.lower.contour.position(points[1])
    duals = _duals(lower.solid.trace, of_lower, points, zone.vertices)
    weighted = csr_matrix(duals.T @ diags_array(quadrature.weights))  # (m, n)
    at_upper = on_upper(undeformed, points, distance)
    return Coupling(
        zone,
        _against(weighted, normal, lower, of_lower, points),
        _against(weighted, normal, upper, of_upper, at_upper),
        weighted @ distance,
        weighted @ normal[2],
        weighted @ normal[1],
        weighted @ (y * normal[2] - z * normal[1]),
        weighted @ points[1],
        np.asarray(weighted.sum(axis=1)).ravel(),
        _slopes(lower.solid.trace, first, zone.vertices),
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


def _check_covered(trace: Trace, triangles: Indices, weights: Array) -> None:
    """Raise Failure where the overlaps leave out a part of the lower surface, or cover some of it twice."""
    whole, covered = float(trace.basis.dx[triangles].sum()), float(weights.sum())
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


def _duals(trace: Trace, triangles: Indices, points: Array, vertices: Indices) -> csr_matrix:
    """Return the functions psi of some vertices at points (2, n) in triangles (n,), shape (n, m)."""
    mesh = trace.basis.mesh
    values = 4 * barycentric(mesh.p[:, mesh.t[:, triangles]], points) - 1
    return _rows(values, mesh.t[:, triangles], mesh.nvertices)[:, vertices]


def _quadratic(shares: Array) -> Array:
    """Return the quadratic functions at barycentric coordinates (3, n), (6, n): of vertices, of edges."""
    edges = [4 * shares[i] * shares[j] for i, j in ((0, 1), (1, 2), (0, 2))]
    return np.stack([*(shares * (2 * shares - 1)), *edges])


def _rows(values: Array, columns: Indices, n_columns: int) -> csr_matrix:
    """Return a matrix (n, n_columns) with some values per row, shape (k, n) like their columns."""
    n = values.shape[1]
    starts = np.arange(n + 1) * len(values)
    return csr_matrix((values.T.ravel(), columns.T.ravel(), starts), shape=(n, n_columns))


def _against(weighted: csr_matrix, normal: Array, body: Elastic, triangles: Indices, at: Array) -> csr_matrix:
    """Integrals of the functions psi times u.n, shape (m, unknowns), from chart points `at` (2, n)."""
    trace = body.solid.trace
    shares = barycentric(trace.basis.mesh.p[:, trace.basis.mesh.t[:, triangles]], at)
    nodes = trace.nodes[trace.basis.element_dofs[:, triangles]]
    values = _rows(_quadratic(shares), nodes, body.solid.nodes.shape[1])
    blocks = hstack([weighted @ diags_array(n) @ values for n in normal], format="csc")
    by_node = np.arange(blocks.shape[1]).reshape(3, -1).T.ravel()  # x of all nodes, y, z: to x, y, z by node
    return csr_matrix(blocks[:, by_node] @ diags_array(np.where(body.held.ravel(), 0.0, 1.0)))


def _slopes(trace: Trace, triangles: Indices, vertices: Indices) -> csr_matrix:
    """Integrals of the products of the gradients of hat functions over some triangles, shape (m, m)."""
    mesh = trace.basis.mesh
    corners = mesh.p[:, mesh.t[:, triangles]]  # (2, 3, n)
    sides = np.roll(corners, -1, axis=1) - np.roll(corners, -2, axis=1)
    area = trace.basis.dx[triangles].sum(axis=1)
    products = np.einsum("din,djn->ijn", sides, sides) / (4 * area)
    i, j = (
        np.broadcast_to(mesh.t[:, triangles][index], products.shape)
        for index in (np.s_[:, None], np.s_[None])
    )
    n = mesh.nvertices
    matrix = csr_matrix((products.ravel(), (i.ravel(), j.ravel())), shape=(n, n))
    return csr_matrix(matrix[vertices][:, vertices])
