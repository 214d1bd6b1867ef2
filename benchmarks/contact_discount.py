"""What the rigid-body discount is worth in normal contact: print the tables of docs/how-to/contact-file.md.

    python benchmarks/contact_discount.py [approach in mm ...]

Geometry 2, frictionless, at fixed vertical approaches: load, contact lengths and largest pressure with C
after the discount, raw C, A and B-hat. Pressures p >= 0 and gaps >= 0 on the grid of the scene, of which only
the nn part of the matrices is used: a dense active set method, no contact program.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from approx.matrix import matrix
from compare.export.export import discounted_matrix, read_matrix
from compare.matrix.compute import compute_matrix
from femic.cache.store import Store
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.contours import Contour
from geometries.patches import N

APPROACHES = (0.01, 0.015, 0.02)  # mm
STEPS = 60  # of Newton's method, and of the active set


def distances(scene: Scene) -> Array:
    """Return undeformed distances along n from the lower to the upper surface [mm], (n_x, n_s)."""
    grid, upper = scene.grid, scene.bodies["upper"]
    contour = scene.bodies["lower"].contour
    x = grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2)[:, None]
    (y, z), slope = contour.position(grid.strips), contour.inclination(grid.strips)
    gap = np.zeros((grid.n_x, grid.n_s))
    for _ in range(STEPS):
        ahead, height = y + gap * np.sin(slope), z + gap * np.cos(slope)
        gap -= (height - surface(upper.contour, upper.rolling_radius, x, ahead)) * np.cos(slope)
    return gap


def surface(contour: Contour, radius: float, x: Array, y: Array) -> Array:
    """Return height z [mm] of a surface of revolution, or of a prismatic one, at x, y."""
    s = np.linspace(-30.0, 30.0, 600_001)
    z = np.interp(y, *contour.position(s))
    return z if np.isinf(radius) else radius - np.sqrt((radius - z) ** 2 - x**2)


def pressures(ics: Array, gap: Array) -> Array:
    """Return pressures [MPa], (n_x, n_s), without penetration, of ICs (n_x, n_s, n_s, 3, 3) [mm/MPa]."""
    n_x, n_s = gap.shape
    lag = np.abs(np.arange(n_x)[:, None] - np.arange(n_x))
    whole = ics[lag][..., N, N].transpose(0, 2, 1, 3).reshape(n_x * n_s, n_x * n_s)
    flat, p = gap.ravel(), np.zeros(n_x * n_s)
    active = flat < 0
    for _ in range(STEPS):
        p[:] = 0.0
        p[active] = np.linalg.solve(whole[np.ix_(active, active)], -flat[active])
        new = np.where(active, p > 0, flat + whole @ p < 0)
        if np.array_equal(new, active):
            return p.reshape(n_x, n_s)
        active = new
    raise RuntimeError("the contact area does not settle")


def row(scene: Scene, name: str, ics: Array, approach: float) -> str:
    """Return a line of the table."""
    grid, slope = scene.grid, scene.bodies["lower"].contour.inclination(scene.grid.strips)
    p = pressures(ics, distances(scene) - approach * np.cos(slope))
    load = float(np.sum(p * np.cos(slope)) * grid.area)
    along, across = np.any(p > 0, axis=1), np.any(p > 0, axis=0)
    edge = max(p[0].max(), p[-1].max(), p[:, 0].max(), p[:, -1].max())
    cells = (
        f"{approach:g}",
        name,
        f"{load:,.0f}",
        f"{np.sum(along) * grid.dx:.1f} x {np.sum(across) * grid.ds:.1f}",
        f"{p.max():.0f}",
        f"{edge:.0f}",
    )
    return f"| {' | '.join(cells)} |"


def main(approaches: list[float]) -> None:
    """Print the tables."""
    scene = load_scene("geometry2", {"engine": {"check": False}})
    with tempfile.TemporaryDirectory() as folder:
        store, path = Store(Path(folder) / "store"), Path(folder) / "matrix.nc"
        compute_matrix(scene, path, RunOptions(1, store))
        found = {
            "C": read_matrix(path, "combined"),
            "raw C": discounted_matrix(scene, "none", RunOptions(1, store)),
            **{name: matrix(name, scene.pair, scene.grid) for name in ("A", "Bhat")},
        }
    print("| approach, mm | ICs | load, N | contact, mm | largest pressure, MPa | at an edge, MPa |")
    print("|---|---|---|---|---|---|")
    for approach in approaches:
        for name, ics in found.items():
            print(row(scene, name, ics, approach), flush=True)


if __name__ == "__main__":
    main([float(word) for word in sys.argv[1:]] or list(APPROACHES))
