"""Mortar coupling: weighted gaps of two meshed surfaces, and the forces of pressures on both bodies.

The gap along the lower normals n, between points opposite each other along n,

    g = h - zeta cos(delta) + (u_upper - u_lower).n,

is weighted with functions psi_i of the vertices of the lower surface, in its chart (x, s): g_i = integral
of psi_i g >= 0. The pressures are p = sum of p_i psi_i, with p_i >= 0 and g_i p_i = 0. These are the
conditions of least energy with bounds, so both bodies feel the same pressures.

The psi_i are dual to the linear hat functions phi_i: on a triangle 4 phi_i - 1, so that the integral of
psi_i phi_j vanishes for i != j, and that of psi_i phi_i is that of phi_i, the area of the vertex. So p_i is
the mean of p near a vertex: where the field of displacement is linear, the vertex bears p_i times its area.
(Hat functions themselves, p = sum of p_i phi_i, give pressures that alternate by 15 % of the largest one at
the edge of a patch; these do not.) Source: Wohlmuth (2011), Acta Numerica 20, 569-734.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, diags_array, hstack
from skfem import MeshTri

from femic.contact.finite_elements.bodies import Elastic
from femic.contact.finite_elements.overlap import barycentric, overlaps
from femic.contact.undeformed import Undeformed
from femic.reference.solid.mesh import Trace
from geometries.arrays import Array, Indices, Mask
from geometries.errors import Failure

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


def zone_of(trace: Trace, selected: Mask) -> Zone:
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
