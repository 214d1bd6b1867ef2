"""3D pictures, drawn without a screen where the machine can; the only module that loads PyVista."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from femic.cache.files import replacing
from femic.lazy import lazy_imports
from geometries.arrays import Array, Indices
from geometries.errors import WrongInput

with lazy_imports():
    import pyvista

Dataset = Any  # of PyVista, which has no types
Plotter = Any

PROBE = "import pyvista; p = pyvista.Plotter(off_screen=True); p.add_mesh(pyvista.Sphere()); p.screenshot()"
OFF_SCREEN = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow", "PYVISTA_OFF_SCREEN": "true"}
NO_RENDERING = (
    "off-screen rendering does not work here: install the system library libegl1 (apt-get install libegl1)"
)
TETRAHEDRON = 10  # VTK's number of the 4-node tetrahedron

HOT = 0.02  # share of the largest stress; the block that is shown contains all larger stresses
STRESS_DECADES = 2  # range of the colour scale
LARGEST_SHIFT = 0.35  # largest drawn displacement over the reach of the block
SHADE = {"ambient": 0.5, "diffuse": 0.65, "specular": 0.0}
CELLS = {"color": "lightsteelblue", "show_edges": True, "line_width": 0.5, "edge_opacity": 0.6}
RIM = {"color": "black", "line_width": 1.5}
COLOUR_BAR = {
    "vertical": True,
    "position_x": 0.87,
    "position_y": 0.2,
    "width": 0.07,
    "height": 0.6,
    "n_labels": 5,
    "title_font_size": 22,
    "label_font_size": 20,
    "fmt": "%.2g",
    "color": "black",
}


def can_render() -> bool:
    """Return whether an off-screen 3D picture can be drawn; tested in a subprocess, since it may crash."""
    command = [sys.executable, "-c", PROBE]
    try:
        subprocess.run(command, env=os.environ | OFF_SCREEN, capture_output=True, check=True, timeout=120)
    except subprocess.SubprocessError:
        return False
    return True


@contextmanager
def _picture(path: Path, **named: Any) -> Iterator[Plotter]:
    """Yield a plotter without a screen; afterwards write its picture as PNG."""
    plotter = pyvista.Plotter(off_screen=True, **named)
    yield plotter
    with replacing(path) as unfinished:
        plotter.screenshot(str(unfinished))
    plotter.close()


def draw_mesh(points: Array, cells: Indices, patch: Array, path: Path, *, title: str) -> None:
    """Write a PNG of a tetrahedral mesh, points (3, n) [mm], cells (4, m), beside a close-up of the patch."""
    os.environ.update(OFF_SCREEN)
    grid = pyvista.UnstructuredGrid({TETRAHEDRON: cells.T}, points.T)
    size = np.ptp(points[0])
    lower = points[2].min() < -points[2].max()
    camera_direction = np.array([-0.8, -1.0, 0.75 if lower else -0.75])
    with _picture(path, shape=(1, 2), window_size=(1400, 620)) as plotter:
        for column, (focus, caption) in enumerate(((points.mean(axis=1), title), (patch, "near the patch"))):
            plotter.subplot(0, column)
            plotter.add_mesh(grid, **CELLS, **SHADE)
            plotter.add_text(caption, font_size=10)
            plotter.camera_position = [focus + 0.06 * size * camera_direction, focus, (0, 0, 1)]
            if column == 0:
                plotter.reset_camera()
            plotter.show_axes()


@dataclass(frozen=True, eq=False)
class LoadedBody:
    """A body under a load; the block around it that is shown has x >= 0, `reach` [mm] to each side."""

    grid: Dataset
    centre: Array
    reach: float

    @property
    def seen_from(self) -> Array:
        """Direction from which the contact surface is seen, (3,): from above for the lower body."""
        low, high = self.grid.bounds[4:]
        return np.array([-1.0, -1.0, 1.0 if low < -high else -1.0])


def read_loaded_body(path: Path) -> LoadedBody:
    """Read a .vtu file with displacements and stresses as femic writes it; raises WrongInput for others.

    The block is centred where the displacement is largest and reaches as far as stresses are high.
    """
    if not path.is_file():
        raise WrongInput(f"{path}: no such file")
    grid = pyvista.read(path)
    if not {"displacement", "von_mises"} <= set(grid.point_data):
        raise WrongInput(f"{path}: has no displacement and von_mises; give a .vtu file that femic wrote")
    grid["size"] = np.linalg.norm(grid["displacement"], axis=1)
    hot_points = grid.points[grid["von_mises"] > HOT * grid["von_mises"].max()]
    load_point = grid.points[np.argmax(grid["size"])]
    reach = round_number(np.abs(hot_points - load_point).max())
    return LoadedBody(grid, np.array([0, 1, 1]) * reach * np.round(load_point / reach, 1), reach)


def round_number(value: float) -> float:
    """Return the largest number of the form 1, 2 or 5 times a power of ten that is not above a value."""
    power = 10 ** np.floor(np.log10(value))
    return float(max(digit * power for digit in (1, 2, 5) if digit * power <= value))


def draw_fields(loaded: LoadedBody, path: Path, *, title: str, window: bool = False) -> None:
    """Write a PNG of a loaded body: the whole body; cells, displacements and stresses near the load.

    With `window` the same panels also open on the screen, where they can be turned.
    """
    if not window:
        os.environ.update(OFF_SCREEN)
    look = {"shape": (2, 2), "window_size": (1600, 1200), "border": False, "lighting": "none"}
    with _picture(path, **look) as plotter:
        _draw_four_panels(plotter, loaded, title)
    if window:
        plotter = pyvista.Plotter(off_screen=False, **look)
        _draw_four_panels(plotter, loaded, title)
        plotter.show(title=title)
        plotter.close()


def _draw_four_panels(plotter: Plotter, loaded: LoadedBody, title: str) -> None:
    plotter.add_light(pyvista.Light(light_type="headlight", intensity=0.8))
    side = (-0.3, loaded.seen_from[2], 0.5)
    plotter.add_light(pyvista.Light(light_type="camera light", position=side, intensity=0.4))
    plotter.enable_anti_aliasing("ssaa")
    grid, skin, rim = loaded.grid, *block(loaded)
    plotter.subplot(0, 0)
    plotter.add_mesh(surface(grid, 0), **CELLS, **SHADE)
    plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", line_width=3)
    _set_view(plotter, loaded, grid, f"{title}: {grid.n_cells:,} cells")
    plotter.subplot(0, 1)
    cells = near_cells(loaded, loaded.reach)
    plotter.add_mesh(surface(cells, 0), **CELLS, **SHADE)
    _set_view(plotter, loaded, cells, "cells near the load, cut at x = 0")
    plotter.subplot(1, 0)
    factor = round_number(LARGEST_SHIFT * loaded.reach / skin["size"].max())
    deformed = skin.warp_by_vector("displacement", factor=factor)
    _add_coloured(plotter, deformed, "size", "displacement\n[mm/N]\n")
    _add_frame(plotter, loaded, rim)
    _set_view(plotter, loaded, skin, f"displacements, enlarged {factor:,.0f} times")
    plotter.subplot(1, 1)
    _add_coloured(plotter, skin, "von_mises", "von Mises\n[MPa/N]\n")
    _add_frame(plotter, loaded, rim)
    _set_view(plotter, loaded, skin, "von Mises stress")


def _add_coloured(plotter: Plotter, skin: Dataset, field: str, title: str) -> None:
    largest = skin[field].max()
    scale: dict[str, Any] = {"cmap": "YlGnBu", "clim": (0, largest)}
    if field == "von_mises":
        scale = {"cmap": "YlOrRd", "log_scale": True, "clim": (10.0**-STRESS_DECADES * largest, largest)}
    plotter.add_mesh(
        skin.copy(), scalars=field, scalar_bar_args=COLOUR_BAR | {"title": title}, **scale, **SHADE
    )


def _set_view(plotter: Plotter, loaded: LoadedBody, shown: Dataset, caption: str) -> None:
    """Point the camera at what is shown and write the caption."""
    size, sideways = shown.length, np.array([1.0, -1.0, 0.0])
    focus = np.array(shown.center) + size * (0.04 * sideways + [0, 0, 0.04])  # room for bar and caption
    plotter.add_text(caption, position=(0.02, 0.93), viewport=True, font_size=13, color="black")
    plotter.camera_position = [focus + 10 * size * loaded.seen_from, focus, (0, 0, 1)]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.55 * size
    plotter.reset_camera_clipping_range()


def _add_frame(plotter: Plotter, loaded: LoadedBody, rim: Dataset) -> None:
    """Add the rim, and rulers along three edges of the block; a ruler has its numbers on its right."""
    plotter.add_mesh(rim, **RIM)
    reach, gap = loaded.reach, 0.05 * loaded.reach
    _, y, z = loaded.centre
    from_above = loaded.seen_from[2] > 0
    bottom = z - reach if from_above else z + reach
    rulers = [
        ((0, y - reach - gap, bottom), (reach, y - reach - gap, bottom)),
        ((-gap, y + reach, bottom), (-gap, y - reach, bottom)),
        ((0, y + reach + gap, max(z, bottom)), (0, y + reach + gap, min(z, bottom))),
    ]
    for axis, (low, high) in enumerate(rulers):
        start, end = (low, high) if from_above or axis == 2 else (high, low)
        title = f"{'xyz'[axis]} [mm]"
        ruler = plotter.add_ruler(start, end, title=title, number_labels=3, label_format="%.3g")
        ruler.SetRange(start[axis], end[axis])
        for text in (ruler.GetTitleTextProperty(), ruler.GetLabelTextProperty()):
            text.SetItalic(False)
            text.SetBold(False)
            text.SetShadow(False)


def near_cells(loaded: LoadedBody, reach: float) -> Dataset:
    """Return the cells of the half x >= 0 whose centres are within `reach` of the load along each axis."""
    centres = loaded.grid.cell_centers().points
    near = np.abs(centres - loaded.centre).max(axis=1) < reach
    return loaded.grid.extract_cells(near & (centres[:, 0] > 0))


def surface(grid: Dataset, subdivision: int) -> Dataset:
    """Return the surface of quadratic cells as triangles: one per facet, or four with `subdivision` 1."""
    return grid.extract_surface(nonlinear_subdivision=subdivision, algorithm="dataset_surface")


def block(loaded: LoadedBody) -> tuple[Dataset, Dataset]:
    """Return the surface of the block around the load with its fields, and the rim of its contact surface."""
    normals = np.array([(1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], dtype=float)
    cells = near_cells(loaded, 3 * loaded.reach)
    skin = _clip(surface(cells, 1), loaded, normals)
    straight = cells.triangulate()
    faces = [
        _clip(straight.slice(n, origin=loaded.centre + loaded.reach * n), loaded, normals[normals @ n == 0])
        for n in normals
    ]
    contact = skin.extract_cells(skin.cell_centers().points[:, 0] > 1e-6 * loaded.reach)
    rim = surface(contact, 0).extract_feature_edges(feature_edges=False, manifold_edges=False)
    return pyvista.merge([skin, *(face for face in faces if face.n_cells)], merge_points=False), rim


def _clip(shape: Dataset, loaded: LoadedBody, normals: Array) -> Dataset:
    """Return the part of a shape inside of planes with some normals, at `reach` from the centre."""
    for normal in normals:
        shape = shape.clip(normal, origin=loaded.centre + loaded.reach * normal)
    return shape
