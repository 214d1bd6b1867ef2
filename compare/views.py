"""The only module that loads PyVista: 3D pictures without a screen, where the machine can draw them."""

import logging
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
log = logging.getLogger(__name__)

PROBE = "import pyvista; p = pyvista.Plotter(off_screen=True); p.add_mesh(pyvista.Sphere()); p.screenshot()"
OFF_SCREEN = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow", "PYVISTA_OFF_SCREEN": "true"}
TETRAHEDRON = 10  # VTK's number of the 4-node tetrahedron


def can_render() -> bool:
    """Whether an off-screen 3D picture can be drawn; tried in a process of its own: it may crash."""
    command = [sys.executable, "-c", PROBE]
    try:
        subprocess.run(command, env=os.environ | OFF_SCREEN, capture_output=True, check=True, timeout=120)
    except subprocess.SubprocessError:
        log.warning(
            "no 3D picture: off-screen rendering does not work here. Install the system library "
            "libegl1 (apt-get install libegl1), or go on without: all other figures are drawn"
        )
        return False
    return True


def draw_mesh(points: Array, cells: NDArray[np.int64], path: Path, *, title: str) -> None:
    """PNG of a tetrahedral mesh, points (3, n) [mm], cells (4, m), beside a close-up of the contact."""
    import pyvista

    os.environ.update(OFF_SCREEN)
    grid = pyvista.UnstructuredGrid({TETRAHEDRON: cells.T}, points.T)
    plotter = pyvista.Plotter(off_screen=True, shape=(1, 2), window_size=(1400, 620))
    size = np.ptp(points[0])
    lower = points[2].min() < -points[2].max()
    for column, (distance, caption) in enumerate(((2.9 * size, title), (0.09 * size, "near the patch"))):
        plotter.subplot(0, column)
        plotter.add_mesh(grid, color="lightsteelblue", show_edges=True, line_width=0.5)
        plotter.add_text(caption, font_size=10)
        focus = np.array([0.0, 0.0, 0.0]) if column else points.mean(axis=1)
        away = np.array([-0.8, -1.0, 0.75 if lower else -0.75])
        plotter.camera_position = [focus + distance * away / 1.5, focus, (0, 0, 1)]
        plotter.show_axes()
    plotter.screenshot(str(path))
    plotter.close()
