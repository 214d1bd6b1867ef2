"""Pictures of a scene for its page: sections, the developed surface, and the meshes of its bodies."""

import logging
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from skfem import MeshTri

from compare.report import views
from compare.report.parts import Picture
from compare.report.static import RC
from femic.cache import folders
from femic.results.ics import Results
from femic.scenes.scene import Scene
from geometries.arrays import Array, Indices
from geometries.bodies import Body

log = logging.getLogger(__name__)

ON_HUB = 1e-9  # share of the depth: a contour that ends closer to the hub ends on it
BESIDE_OUTLINE = 1.1  # half-width of the whole section, over the size of an outline
ON_TOP = 4  # order of drawing of lines and their marks: the patch does not hide them
PATCH = "#f0e442"  # its colour: black marks of lines are seen upon it
HALF_WINDOW = 1.4  # half-width of the zoomed section, over the largest |s| of the lines


def pictures(results: Results, folder: Path) -> Iterator[Picture]:
    """Yield the sections of a scene, and the meshes of its solved bodies, in a folder for those in 3D."""
    scene = results.scene
    yield Picture("sections", sections(scene))
    for body, reference in results.references.items():
        if reference.drawn is not None:
            yield Picture(f"mesh_{body}", section_mesh(*reference.drawn, scene, body))
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
    yield Picture("mesh_surface", surface_mesh(solid.trace.basis.mesh, scene, body, side=side))


def sections(scene: Scene) -> Figure:
    """Draw both sections, whole and near the contact, with the patch and the offset lines."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(11, 4.6), layout="constrained")
        whole, near, plan = figure.subplots(1, 3)
        for axes in (whole, near):
            for name, colour in (("lower", "tab:blue"), ("upper", "tab:red")):
                _draw_body(axes, scene.bodies[name], name, colour)
            axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]")
        window = HALF_WINDOW * max(np.max(np.abs(line.s)) for line in scene.lines)
        near.set(xlim=(-window, window), ylim=(-window, window))
        contour = scene.bodies["lower"].contour
        patch = contour.position(scene.patch.s + np.linspace(-scene.patch.b, scene.patch.b, 9))
        near.plot(*patch, color=PATCH, linewidth=4, label="patch")
        for number, line in enumerate(scene.lines):  # in the colours that they have on the developed surface
            points = contour.position(line.s if line.along == "s" else line.s[:1])
            look = {"color": f"C{number}", "markeredgewidth": 1.5, "zorder": ON_TOP}
            near.plot(*points, ":" if line.along == "s" else "x", label=f"line {line.name}", **look)
        if contour.joints:
            joints = contour.position(np.array(contour.joints))
            near.plot(*joints, "ko", markersize=4, mfc="white", label="arc/flank joint")
        outlines = [body.outline.size for body in scene.bodies.values() if body.outline is not None]
        if outlines:  # the other body may have a far arc, and be much larger
            limits = BESIDE_OUTLINE * max(outlines) * np.array([-1, 1])
            whole.set(xlim=limits, ylim=limits)
        whole.set_title("sections, clamped at the thick lines")
        near.set_title("near the contact")
        near.legend(loc="upper left", fontsize=8)
        _draw_plan(plan, scene)
        return figure


def _draw_body(axes: Axes, body: Body, name: str, colour: str) -> None:
    far_radius = body.domain.far_radius
    start, end = body.s_range
    s_near_contact = np.linspace(max(start, -0.1 * far_radius), min(end, 0.1 * far_radius), 401)
    s = np.union1d(np.linspace(start, end, 801), s_near_contact)
    contour = body.contour.position(s)
    free = np.empty((2, 0)) if body.outline is None else body.outline.beyond(body.contour)
    clamped = _closing(body, contour[:, -1], contour[:, 0]) if body.outline is None else body.outline.support
    boundary = np.hstack([contour, clamped if body.outline is None else free])
    axes.fill(*boundary, facecolor=colour, alpha=0.15, label=f"{name} body")
    if body.outline is not None:
        axes.plot(*np.hstack([contour[:, -1:], free, contour[:, :1]]), color=colour, linewidth=1)
    axes.plot(*clamped, color=colour, linewidth=2.5)
    axes.plot(*contour, color=colour, linewidth=1)


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


def _draw_plan(axes: Axes, scene: Scene, side: int = 1) -> None:
    """Draw lines and patch on the developed surface; side -1: mirrored in s."""
    for number, line in enumerate(scene.lines):
        axes.plot(side * line.s, line.x, color=f"C{number}", linewidth=1.2, label=f"line {line.name}")
    a, b, centre = scene.patch.a, scene.patch.b, side * scene.patch.s
    axes.fill(centre + b * np.array([-1, 1, 1, -1]), [-a, -a, a, a], color=PATCH, label="patch", zorder=3)
    for s in scene.bodies["lower"].contour.joints:
        axes.axvline(side * s, color="grey", linestyle=":", linewidth=1)
    axes.set(xlabel="s [mm]", ylabel="x [mm]", title="developed surface")
    axes.legend(loc="upper left", fontsize=8)


def surface_mesh(chart: MeshTri, scene: Scene, body: str, *, side: int) -> Figure:
    """Draw the contact surface's mesh in its chart (x, s): where the lines run, and near the patch.

    `side` -1: the model is the mirror image of the side of the patch.
    """
    x, s = chart.p
    with mpl.rc_context(RC | {"axes.grid": False}):
        figure = Figure(figsize=(10, 4.8), layout="constrained")
        reach = max(float(np.max(np.abs(line.running))) for line in scene.lines)
        windows = {
            "where the lines run": (0.0, 1.2 * reach),
            "near the patch": (side * scene.patch.s, 8 * max(scene.patch.a, scene.patch.b)),
        }
        for axes, (title, (centre, window)) in zip(figure.subplots(1, 2), windows.items(), strict=True):
            axes.triplot(s, x, chart.t.T, linewidth=0.3, color="tab:blue")
            _draw_plan(axes, scene, side)
            axes.set(xlim=(max(s.min(), centre - window), centre + window), ylim=(0, window))
            axes.set(aspect="equal", title=title)
            axes.get_legend().remove()
        figure.suptitle(f"surface mesh of the {body} body (modelled part; symmetry gives the rest)")
        return figure


def section_mesh(vertices: Array, triangles: Indices, scene: Scene, body: str) -> Figure:
    """Draw the section's mesh, whole and near the patch; vertices (2, n) [mm], triangles (3, m)."""
    y, z = vertices
    with mpl.rc_context(RC | {"axes.grid": False}):
        figure = Figure(figsize=(10, 4.8), layout="constrained")
        patch_y, patch_z = scene.bodies[body].contour.position(scene.patch.s)
        half_window = 8 * max(scene.patch.a, scene.patch.b)
        whole, close_up = figure.subplots(1, 2)
        for axes in (whole, close_up):
            axes.triplot(y, z, triangles.T, linewidth=0.3, color="tab:blue")
            axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]")
        whole.set_title(f"{triangles.shape[1]:,} cells")
        near = np.maximum(np.abs(y - patch_y), np.abs(z - patch_z)) <= half_window
        room = 0.05 * half_window
        close_up.set(
            title="near the patch",
            xlim=(np.min(y[near]) - room, np.max(y[near]) + room),
            ylim=(np.min(z[near]) - room, np.max(z[near]) + room),
        )
        half = " (y ≥ 0: the other half is its mirror image)" if np.min(y) >= 0 else ""
        figure.suptitle(f"section of the {body} body{half}")
        return figure
