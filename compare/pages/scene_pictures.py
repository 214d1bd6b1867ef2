"""Pictures of a scene for its page: sections, the developed surface, and the meshes of its bodies."""

import logging
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from skfem import MeshTri

from compare.report import views
from compare.report.charts import Chart, Curve, Panel, simple_chart
from compare.report.looks import FURTHER, INK, Look
from compare.report.parts import Picture
from femic.cache import folders
from femic.results.ics import Results
from femic.scenes.scene import Scene
from geometries.arrays import Array, Indices
from geometries.bodies import Body

log = logging.getLogger(__name__)

ON_HUB = 1e-9  # share of the depth: a contour that ends closer to the hub ends on it
BESIDE_OUTLINE = 1.1  # half-width of the whole section, over the size of an outline
BESIDE_LINES = 1.4  # half-width of the section near the contact, over the largest |s| of the lines
NEAR_PATCH = 8.0  # half-width of what is near the patch, over its larger half-side
BODIES = {"lower": Look("#0072b2"), "upper": Look("#d55e00")}
PATCH, MESH = Look("#cc79a7", width=5.0), Look("#0072b2", width=0.7)
JOINT = Look(INK, "", "circle-open")
CLAMPED_WIDTH = 3.0  # px
HEIGHTS = 1.3  # of the charts, over the usual height
SECTION, SURFACE = ("y [mm]", "z [mm]"), ("s [mm]", "x [mm]")


def pictures(results: Results, folder: Path) -> Iterator[Chart | Picture]:
    """Yield the sections of a scene, and the meshes of its solved bodies, in a folder for those in 3D."""
    scene = results.scene
    yield sections(scene)
    for body, reference in results.references.items():
        if reference.drawn is not None:
            yield section_mesh(*reference.drawn, scene, body)
    engine = scene.settings.engine
    if not engine.has_fields:
        return
    in_3d = views.can_render()
    if not in_3d:
        log.warning(f"no 3D pictures of the meshes: {views.NO_RENDERING}. All other figures are drawn")
    for body, job in results.jobs.items():
        solid = engine.mesh(job.request(results.references[body].level))
        side = -1 if solid.half_section and job.patch.s < 0 else 1  # a half section models s >= 0 only
        if in_3d:
            path = folders.make(folder) / f"mesh_{body}.png"
            patch = job.body.surface.position(0.0, side * job.patch.s)
            vertices, title = (
                solid.nodes[:, : solid.n_vertices],
                f"{body} body, {solid.mesh.nelements:,} cells",
            )
            views.draw_mesh(vertices, solid.mesh.t, patch, path, title=title)
            yield Picture(path.stem, path)
    yield surface_mesh(solid.trace.basis.mesh, scene, body, side=side)


# --- sections and the developed surface -----------------------------------------------------------------


def sections(scene: Scene) -> Chart:
    """Return both sections, whole and near the contact, and the developed surface, with patch and lines."""
    outlines = [body.outline.size for body in scene.bodies.values() if body.outline is not None]
    # with an outline the other body may have a far arc, and be much larger
    around = BESIDE_OUTLINE * max(outlines) if outlines else None
    whole = [curve for name in scene.bodies for curve in _outline(scene.bodies[name], name)]
    near = BESIDE_LINES * max(np.max(np.abs(line.s)) for line in scene.lines)
    contour = scene.bodies["lower"].contour
    reach = near + scene.patch.b  # of arc lengths that lie within the window
    drawn = []
    for name, look in BODIES.items():
        start, end = np.clip(scene.bodies[name].s_range, -reach, reach)
        points = scene.bodies[name].contour.position(np.linspace(start, end, 401))
        drawn.append(_curve(f"{name} body", points, look))
    patch = contour.position(scene.patch.s + np.linspace(-scene.patch.b, scene.patch.b, 9))
    drawn += [_curve("patch", patch, PATCH)]
    for line, look in zip(scene.lines, _line_looks(scene), strict=True):
        along = line.along == "s"
        mark = replace(look, dash="dot", marker="") if along else replace(look, dash="", marker="x")
        drawn.append(_curve(f"line {line.name}", contour.position(line.s if along else line.s[:1]), mark))
    if contour.joints:
        drawn.append(_curve("joint of contour", contour.position(np.array(contour.joints)), JOINT))
    limits = None if around is None else (-around, around)
    panels = [
        Panel(
            "sections, clamped at the thick lines",
            *SECTION,
            whole,
            to_scale=True,
            limits_x=limits,
            limits_y=limits,
        ),
        Panel(
            "near the contact", *SECTION, drawn, to_scale=True, limits_x=(-near, near), limits_y=(-near, near)
        ),
        Panel("developed surface", *SURFACE, _plan(scene), marks=contour.joints),
    ]
    alt = "sections of both bodies, whole and near the contact, and the patch and the lines on the surface"
    return simple_chart("sections", panels, 3, HEIGHTS, alt)


def _outline(body: Body, name: str) -> Iterator[Curve]:
    """Yield the boundary of a section: free, and clamped as a thick line."""
    far_radius, look = body.domain.far_radius, BODIES[name]
    start, end = body.s_range
    s_near_contact = np.linspace(max(start, -0.1 * far_radius), min(end, 0.1 * far_radius), 401)
    contour = body.contour.position(np.union1d(np.linspace(start, end, 801), s_near_contact))
    free, clamped = contour, _closing(body, contour[:, -1], contour[:, 0])
    if body.outline is not None:
        free = np.hstack([contour, body.outline.beyond(body.contour), contour[:, :1]])
        clamped = body.outline.support
    yield _curve(f"{name} body", free, look)
    yield _curve(f"{name} body", clamped, replace(look, width=CLAMPED_WIDTH))


def _closing(body: Body, right: Array, left: Array) -> Array:
    """Return points of far arc and hub from the contour's right end to its left end, (2, n) [mm]."""
    arcs = []  # from each end to the hub or the pole; an end that lies on the hub is returned alone
    far_radius = body.domain.far_radius
    for y, z in (right, left):
        if body.side * z > (1 - ON_HUB) * body.depth:
            arcs.append(np.array([[y], [z]]))
            continue
        ends = np.arctan2(body.side * z, abs(y)), np.arcsin(min(1.0, body.depth / far_radius))
        angle = np.linspace(*ends, 101)
        arcs.append(far_radius * np.stack([np.sign(y) * np.cos(angle), body.side * np.sin(angle)]))
    return np.hstack([arcs[0], arcs[1][:, ::-1]])


def _line_looks(scene: Scene) -> list[Look]:
    """Return the looks of the lines, which are those of the sections, too."""
    return [replace(FURTHER[number % len(FURTHER)], marker="") for number in range(len(scene.lines))]


def _plan(scene: Scene, side: int = 1) -> list[Curve]:
    """Return lines and patch on the developed surface; side -1: mirrored in s."""
    a, b, centre = scene.patch.a, scene.patch.b, side * scene.patch.s
    lines = [
        Curve(f"line {line.name}", side * line.s, line.x, look)
        for line, look in zip(scene.lines, _line_looks(scene), strict=True)
    ]
    corners = centre + b * np.array([-1, 1, 1, -1, -1]), a * np.array([-1, -1, 1, 1, -1])
    return [*lines, _curve("patch", np.stack(corners), replace(PATCH, width=2.0))]


# --- meshes ---------------------------------------------------------------------------------------------


def surface_mesh(chart: MeshTri, scene: Scene, body: str, *, side: int) -> Chart:
    """Return the contact surface's mesh in its chart (x, s): where the lines run, and near the patch.

    `side` -1: the model is the mirror image of the side of the patch.
    """
    x, s = chart.p
    reach = max(float(np.max(np.abs(line.running))) for line in scene.lines)
    windows = {
        "where the lines run": (0.0, 1.2 * reach),
        "near the patch": (side * scene.patch.s, NEAR_PATCH * max(scene.patch.a, scene.patch.b)),
    }
    panels = []
    for title, (centre, window) in windows.items():
        limits = (max(s.min(), centre - window), centre + window), (0.0, window)
        curves = [_mesh(np.stack([s, x]), chart.t, *limits), *_plan(scene, side)]
        panels.append(Panel(title, *SURFACE, curves, to_scale=True, limits_x=limits[0], limits_y=limits[1]))
    alt = f"surface mesh of the {body} body (the modelled part; symmetry gives the rest)"
    return simple_chart("mesh_surface", panels, 2, HEIGHTS, alt)


def section_mesh(vertices: Array, triangles: Indices, scene: Scene, body: str) -> Chart:
    """Return the section's mesh, whole and near the patch; vertices (2, n) [mm], triangles (3, m)."""
    window = NEAR_PATCH * max(scene.patch.a, scene.patch.b)
    patch = scene.bodies[body].contour.position(scene.patch.s)
    near = vertices[:, np.max(np.abs(vertices - patch[:, None]), axis=0) <= window]
    room = 0.05 * window
    limits = [
        (float(low) - room, float(high) + room) for low, high in zip(near.min(1), near.max(1), strict=True)
    ]
    half = " (y ≥ 0: the other half is its mirror image)" if np.min(vertices[0]) >= 0 else ""
    titles = f"{body} body{half}: {triangles.shape[1]:,} cells", f"{body} body, near the patch"
    panels = [
        Panel(titles[0], *SECTION, [_mesh(vertices, triangles)], to_scale=True),
        Panel(
            titles[1],
            *SECTION,
            [_mesh(vertices, triangles, *limits)],
            to_scale=True,
            limits_x=limits[0],
            limits_y=limits[1],
        ),
    ]
    return simple_chart(f"mesh_{body}", panels, 2, HEIGHTS, f"mesh of the section of the {body} body")


def _mesh(
    vertices: Array,
    triangles: Indices,
    across: tuple[float, float] = (-np.inf, np.inf),
    up: tuple[float, float] = (-np.inf, np.inf),
) -> Curve:
    """Return the edges of triangles, each once, with a vertex within limits; NaN separates them."""
    limits = np.array([across, up])
    inside = np.all((vertices >= limits[:, :1]) & (vertices <= limits[:, 1:]), axis=0)
    corners = triangles[:, inside[triangles].any(axis=0)]
    edges = np.unique(np.sort(np.hstack([corners[[0, 1]], corners[[1, 2]], corners[[2, 0]]]), axis=0), axis=1)
    points = np.full((2, edges.shape[1], 3), np.nan)
    points[:, :, :2] = vertices[:, edges.T]
    return _curve("mesh", points.reshape(2, -1), MESH)


def _curve(label: str, points: Array, look: Look) -> Curve:
    return Curve(label, points[0], points[1], look)
