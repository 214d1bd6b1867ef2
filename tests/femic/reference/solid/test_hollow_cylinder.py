"""A hollow cylinder in plane strain, clamped outside, loaded inside: Lame's and Michell's solutions.

The section is not one of femic's own (closed, no far arc about the contact centre): the test builds
it, and everything behind the mesher is the engine's.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from femic.reference.engine import Points
from femic.reference.meshing import gmsh_session
from femic.reference.result import ESTIMATE_ORDER, SAFETY
from femic.reference.run_options import COARSER
from femic.reference.solid.engine import SolidModel, observe, solve
from femic.reference.solid.linear import stiffness
from femic.reference.solid.mesh import _collect, curved
from geometries.bodies import Body, Domain
from geometries.contours import Arc, Contour
from geometries.materials import Material
from geometries.patches import Load, Patch
from geometries.surfaces import UPPER
from tests.femic.reference.conftest import assert_honest
from tests.truths.hollow_cylinder import line_load_ics, pressure

INNER, THICKNESS = 10.0, 1.0  # mm; the slab 0 <= x <= THICKNESS slides on both faces
MESHES, OUTER = (0.8, 0.64, 0.5), (25.0, 40.0)
STRIP = 2.0
MATERIAL = Material(210e3, 0.28)
DELTA = np.linspace(0.5, np.pi, 61)  # observers off the strip


class Cavity(Body):
    """Upper body around a cylindrical cavity, s = 0 at its top; y >= 0 is modelled."""

    @property
    def s_range(self):
        """From the top to the bottom of the cavity."""
        return 0.0, np.pi * INNER


def cavity():
    contour = Contour(Arc(INNER), (-np.pi * INNER, np.pi * INNER))
    return Cavity(UPPER, contour, MATERIAL, Domain(3 * INNER, THICKNESS))


def tetrahedra(body, outer, factor):
    with gmsh_session() as gmsh:
        occ = gmsh.model.occ
        points = {
            (end, r): occ.addPoint(0, 0, -INNER + sign * r)
            for end, sign in (("top", 1), ("bottom", -1))
            for r in (INNER, outer)
        }
        sides = [occ.addPoint(0, r, -INNER) for r in (INNER, outer)]
        centre = occ.addPoint(0, 0, -INNER)
        arcs = []
        for side, r in zip(sides, (INNER, outer), strict=True):
            arcs.append(occ.addCircleArc(points["top", r], centre, side))
            arcs.append(occ.addCircleArc(side, centre, points["bottom", r]))
        top, bottom = (occ.addLine(points[end, INNER], points[end, outer]) for end in ("top", "bottom"))
        loop = occ.addCurveLoop([arcs[0], arcs[1], bottom, arcs[3], arcs[2], top])
        occ.extrude([(2, occ.addPlaneSurface([loop]))], THICKNESS, 0, 0)
        occ.synchronize()
        size = gmsh.model.mesh.field.add("MathEval")
        gmsh.model.mesh.field.setString(size, "F", f"{factor}*(0.4+0.12*sqrt(y^2+z^2))")
        gmsh.model.mesh.field.setAsBackgroundMesh(size)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        gmsh.model.mesh.generate(3)
        return _collect(gmsh, body)


def with_outer_surface(solid, outer):
    """The mesh with the nodes of its outer surface moved onto the cylinder, and which these are."""
    mesh = solid.mesh
    facets = mesh.boundary_facets()
    vertices = np.hypot(mesh.p[1], mesh.p[2] + INNER) > (1 - 1e-6) * outer
    on_outer = facets[np.all(vertices[mesh.facets[:, facets]], axis=0)]
    nodes = solid.nodes.copy()
    chosen = np.unique(mesh.dofs.get_facet_dofs(on_outer).flatten())
    centred = nodes[1:, chosen] + [[0.0], [INNER]]
    nodes[1:, chosen] = outer * centred / np.linalg.norm(centred, axis=0) - [[0.0], [INNER]]
    clamped = np.zeros(nodes.shape[1], dtype=bool)
    clamped[chosen] = True
    return replace(solid, mesh=replace(mesh, doflocs=nodes)), clamped


def displacements(outer, factor, load):
    """u (3, n) at angles DELTA in the middle of the slab under a load over its whole thickness."""
    body = cavity()
    solid, clamped = with_outer_surface(
        curved(body, tetrahedra(body, outer, factor), half_section=True), outer
    )
    sliding = np.abs(solid.nodes[0] - THICKNESS) < 1e-9
    supported = np.stack([clamped | sliding, clamped, clamped], axis=1)
    model = SolidModel(solid, stiffness(solid.mesh, MATERIAL), supported)
    points = Points(np.full_like(DELTA, THICKNESS / 2), DELTA * INNER)
    (field,) = solve(model, [load], "multigrid").values()
    return observe(model, load, field, points)


def with_estimate(outer, factor, load):
    fine, coarse = (displacements(outer, f, load) for f in (factor, COARSER * factor))
    return fine, SAFETY * np.abs(fine - coarse) / (COARSER**ESTIMATE_ORDER - 1)


QUICK = ((MESHES[0], OUTER[0]),)


@pytest.mark.parametrize(
    ("factor", "outer"),
    [
        case if case in QUICK else pytest.param(*case, marks=pytest.mark.slow)
        for case in product(MESHES, OUTER)
    ],
)
def test_internal_pressure(factor, outer):
    """A unit load on all of the inner surface: pressure 1 / (4 a b)."""
    everywhere = Patch(THICKNESS, np.pi * INNER)
    fine, estimate = with_estimate(outer, factor, Load(everywhere, 2))
    truth = pressure(MATERIAL, INNER, outer) / everywhere.area
    error, estimate = (np.max(np.abs(v)) / truth for v in (fine[2] - truth, estimate[2]))
    assert error <= estimate <= 10 * error, (error, estimate)
    assert error < 0.01
    assert np.abs(fine[:2]).max() < 0.01 * truth


@pytest.mark.slow
def test_line_load():
    """Unit loads along s and n on a strip along x: 1 / (2 THICKNESS) N/mm."""
    cases = [line_load_errors(outer, factor) for outer in OUTER for factor in MESHES]
    assert_honest(cases)
    assert all(np.all(error < 0.02) for error, _ in cases)


def line_load_errors(outer, factor):
    strip = Patch(THICKNESS, STRIP)
    truth = line_load_ics(MATERIAL, INNER, outer, STRIP, DELTA * INNER) / (2 * THICKNESS)
    errors, estimates = np.zeros((2, 2)), np.zeros((2, 2))
    for j in (0, 1):
        fine, estimate = with_estimate(outer, factor, Load(strip, j + 1))
        scale = np.abs(truth[:, j]).max(axis=1)
        errors[:, j] = np.abs(fine[1:] - truth[:, j]).max(axis=1) / scale
        estimates[:, j] = estimate[1:].max(axis=1) / scale
    return errors, estimates
