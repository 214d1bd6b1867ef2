"""A cylindrical cavity in plane strain, clamped outside: Lame, Michell, and Persson's pin in it.

Half-space stresses are far off here. The section is closed, so the test meshes it; everything behind the
mesher is the engine's. Half of it is modelled: loads are symmetric. Only places far from the cut, where the
unrolled half-space has tractions on one side, are compared.
"""

from itertools import pairwise

import numpy as np
import pytest

from femic.reference.harmonic.section import SectionMesh, _curved
from femic.reference.meshing import collect_cells, gmsh_session
from femic.stresses.engine import SectionUnderWaves
from femic.stresses.half_space import half_space_field
from femic.stresses.points import SurfaceTractions
from femic.stresses.resolution import Resolution
from femic.stresses.waves import Spectra
from geometries.bodies import Body, Domain
from geometries.contours import Arc, Contour
from geometries.patches import Grid
from tests.femic.contact.exact.pin import PinInHole
from tests.femic.stresses.samples import STEEL, section_points
from tests.truths.hollow_cylinder import amplitudes, solutions

INNER, OUTER, LENGTH, STRIPS = 10.0, 20.0, 240.0, 48
KAPPA = 3 - 4 * STEEL.nu
DELTA = np.array([0.9, 1.3, 1.8, 2.2])
DEPTH = np.array([0.0, 0.1, 0.5, 1.5, 3.0, 7.0])


class HalfCavity(Body):
    """Upper body around a cavity, s = 0 at its top; y >= 0 is modelled."""

    @property
    def s_range(self):
        return 0.0, np.pi * INNER


class HalfMesh(SectionMesh):
    """Held outside, and across the plane of symmetry."""

    @property
    def supported(self):
        y, z = self.mesh.doflocs
        held = np.zeros((len(y), 3), dtype=bool)
        held[np.hypot(y, z + INNER) > (1 - 2e-3) * OUTER] = True
        held[np.abs(y) < 1e-9, 1] = True
        return held


BODY = HalfCavity(+1, Contour(Arc(INNER), (-np.pi * INNER, np.pi * INNER)), STEEL, Domain(2 * OUTER, np.inf))
GRID = Grid(48, STRIPS, LENGTH / 48, np.pi * INNER / STRIPS, np.pi * INNER / 2)


def triangles(gmsh):
    occ = gmsh.model.occ
    centre = occ.addPoint(0, 0, -INNER)
    inner, outer = (
        [occ.addPoint(0, r * np.sin(t), -INNER + r * np.cos(t)) for t in (0, np.pi / 2, np.pi)]
        for r in (INNER, OUTER)
    )
    arcs = [[occ.addCircleArc(a, centre, b) for a, b in pairwise(p)] for p in (inner, outer)]
    bottom, top = occ.addLine(inner[2], outer[2]), occ.addLine(outer[0], inner[0])
    loop = occ.addCurveLoop([*arcs[0], bottom, *[-arc for arc in arcs[1][::-1]], top])
    occ.addPlaneSurface([loop])
    occ.synchronize()
    field = gmsh.model.mesh.field
    tag = field.add("MathEval")
    field.setString(tag, "F", f"{GRID.ds}+0.1*(sqrt(y^2+(z+{INNER})^2)-{INNER})")
    field.setAsBackgroundMesh(tag)
    for curve in arcs[0]:
        gmsh.model.mesh.setTransfiniteCurve(curve, STRIPS // 2 + 1)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.generate(2)
    points, cells, on_contour = collect_cells(gmsh, 2, arcs[0])
    return np.ascontiguousarray(points[1:]), cells, on_contour


@pytest.fixture(scope="module")
def section():
    with gmsh_session() as gmsh:
        mesh = _curved(BODY, *triangles(gmsh), True)
    return HalfMesh(mesh.body, mesh.mesh, mesh.knots, mesh.contour_nodes, True)


def computed(section, pressure, shear, delta, depth):
    """Stresses (..., 3, 3) under pressure(delta) and shear(delta) at the middle of the length."""
    s = GRID.strips / INNER
    p = np.stack([0 * s, shear(s), pressure(s)], axis=-1) * profile()[:, None, None]
    tractions, resolution = SurfaceTractions(GRID, p), Resolution.at_fineness(0.7)
    points = section_points(INNER * delta, depth)
    model = SectionUnderWaves(
        section, Spectra.from_tractions(BODY, tractions, resolution.largest), resolution, GRID.ds, 0.0
    )
    return half_space_field(BODY, tractions, points).stress + model.body_correction(points, 1)[1]


def profile():
    """Share of the tractions along x: 1 over a third of the length, then falling smoothly to 0."""
    x = LENGTH * ((np.arange(GRID.n_x) + 0.5) / GRID.n_x - 0.5)
    return np.cos(np.pi / 2 * np.clip((np.abs(x) - LENGTH / 6) / (LENGTH / 3), 0, 1)) ** 2


def exact(pressure_orders, shear_orders, delta, depth):
    """Stresses ss, nn, sn under sums of cos(m delta) in pressure and sin(m delta) in shear, by order m."""
    r, delta = 1 + depth / INNER, delta[:, None]
    total = np.zeros((3, len(delta), len(depth)))
    for m, p_n in enumerate(pressure_orders):
        if m == 0:
            nn, ss = lame(r)
            total += p_n * np.stack([ss, nn, 0 * r])[:, None]
            continue
        parts = amplitudes(m, KAPPA, OUTER / INNER) @ [p_n, shear_orders[m]]

        def radial(at, m=m, parts=parts):
            return np.array([solutions(m, KAPPA, one, OUTER / INNER)[2:] @ parts for one in at]).T

        (nn, sn), step = radial(r), 1e-5
        slope = ((r + step) * radial(r + step)[0] - (r - step) * radial(r - step)[0]) / (2 * step)
        hoop = slope + m * sn  # radial equilibrium
        total += np.stack([hoop * np.cos(m * delta), nn * np.cos(m * delta), sn * np.sin(m * delta)])
    return total


def lame(r):
    """Stresses nn, ss under unit pressure, u = 0 at OUTER, radii over INNER: A - B / r^2, A + B / r^2."""
    c, r_o = 1 - 2 * STEEL.nu, OUTER / INNER
    B = 1 / (1 + 1 / (c * r_o**2))  # u = 0: A c = -B / r_o^2, in the units of 2 G u / r
    A = B - 1
    return A - B / r**2, A + B / r**2


def assert_same(stress, expected, tolerance):
    for (i, j), values in zip(((1, 1), (2, 2), (1, 2)), expected, strict=True):
        np.testing.assert_allclose(stress[..., i, j], values, atol=tolerance * np.max(np.abs(expected)))
    plane_strain = STEEL.nu * (expected[0] + expected[1])
    np.testing.assert_allclose(stress[..., 0, 0], plane_strain, atol=tolerance * np.max(np.abs(expected)))


def test_a_pressurised_cavity(section):
    """Lame; a half-space has hoop stresses of the other sign."""
    stress = computed(section, lambda d: 1 + 0 * d, lambda d: 0 * d, DELTA, DEPTH)
    assert_same(stress, exact([1.0], [0.0], DELTA, DEPTH), 5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("p_n", "p_s"), [(1.0, 0.0), (0.0, 1.0)])
def test_pressure_and_shear_that_vary_round_the_cavity(section, p_n, p_s):
    """Michell, order 2; strips have the mean of their tractions within (2 ds / INNER)^2 / 24 = 1e-3."""
    stress = computed(section, lambda d: p_n * np.cos(2 * d), lambda d: p_s * np.sin(2 * d), DELTA, DEPTH)
    assert_same(stress, exact([0, 0, p_n], [0, 0, p_s], DELTA, DEPTH), 1e-2)


@pytest.mark.slow
def test_a_pin_in_the_hole(section):
    """Persson's pressures over 2 x 70 degrees at the bottom, as a sum of orders."""
    pin = PinInHole(STEEL, STEEL, INNER, 0.05)
    load = pin.load(np.radians(70.0))
    p_max = pin.pressure(load, 0.0)
    fine = (np.arange(4000) + 0.5) * np.pi / 4000

    def pressure(delta):
        return pin.pressure(load, np.pi - np.asarray(delta)) / p_max

    orders = [np.mean(pressure(fine) * np.cos(m * fine)) * (2 if m else 1) for m in range(60)]
    delta, depth = np.array([1.6, 2.1, 2.4]), np.array([0.0, 0.2, 0.6, 1.5, 5.0])
    stress = computed(section, pressure, lambda d: 0 * d, delta, depth)
    assert_same(stress, exact(orders, np.zeros(60), delta, depth), 1e-2)
