"""Stresses under a patch with pressure and shear: CalculiX at its Gauss points against `femic.stresses`."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import ics
import numpy as np
from deck import Output, Part, element_set, face_loads, nodal_forces, run
from meshing import Fineness, Mesh, mesh

from femic.stresses.engine import StressSettings, stress_field
from femic.stresses.field import in_section_axes, von_mises
from femic.stresses.points import SurfaceTractions, points_at
from geometries.arrays import Array, Indices
from geometries.bodies import Body, Domain
from geometries.patches import Grid, Patch

PATCH = Patch(1.0, 0.8, 3.0)
TRACTION = np.array([0.0, 300.0, -1000.0])  # MPa along x, s, n of the rail: pressure, and shear to the side
ELEMENTS = (10, 16)  # of femic's grid, along x and s
DEPTHS, REACH, MOST = (0.25, 2.0), 2.2, 400  # mm below the surface, and from the patch's centre; points
COMPONENTS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
HEADER = [
    "stress",
    "points",
    "largest [MPa]",
    "largest difference [MPa]",
    "largest difference",
    "root mean square difference",
]


def rows(growth: float, folder: Path) -> Iterator[list[str]]:
    """Rows by component along x, y, z, and for von Mises stresses."""
    loaded = replace(ics.rail(), patch=PATCH)
    points, theirs, nodes = by_calculix(loaded, growth, folder)
    ours = by_femic(loaded.body, points)
    largest = float(np.max(np.abs(theirs)))
    pairs = {name: (theirs[:, i, j], ours[:, i, j]) for name, (i, j) in COMPONENTS.items()}
    for name, (their, our) in (pairs | {"von Mises": (von_mises(theirs), von_mises(ours))}).items():
        apart = np.abs(their - our)
        mean = float(np.sqrt(np.mean(apart**2)))
        numbers = [f"{np.max(np.abs(our)):.1f}", f"{np.max(apart):.1f}"]
        yield [
            name,
            f"{len(points)}, of {nodes} nodes",
            *numbers,
            f"{np.max(apart) / largest:.2%}",
            f"{mean / largest:.2%}",
        ]


def by_calculix(loaded: ics.LoadedBody, growth: float, folder: Path) -> tuple[Array, Array, int]:
    """Points (n, 3) [mm], stresses there (n, 3, 3) [MPa] along x, y, z, and the number of nodes."""
    body, patch = loaded.body, loaded.patch
    x, s = np.meshgrid(np.linspace(0, patch.a, 5), np.linspace(patch.s - patch.b, patch.s + patch.b, 7))
    centres = body.surface.position(x.ravel(), s.ravel())
    meshed = mesh(body, Fineness(patch.b / 8, growth, centres), loaded.rectangle)
    part = Part("BODY", meshed)
    lines = [
        *part.lines(),
        *element_set("READ", part.first_cell + chosen(meshed, patch)),
        *("*BOUNDARY", "FAR-BODY,1,3", "CUT-BODY,1", "*STEP", "*STATIC,SOLVER=SPOOLES"),
        *nodal_forces(part, face_loads(meshed, meshed.faces_in(loaded.rectangle), TRACTION)),
        *("*EL PRINT,ELSET=READ", "S,COORD", "*END STEP"),
    ]
    return *at_gauss_points(run(lines, folder, "stresses")), len(meshed.nodes)


def chosen(meshed: Mesh, patch: Patch) -> Indices:
    """Numbers of cells below the patch, not more than `MOST` / 4."""
    body, centres = meshed.body, meshed.nodes[meshed.cells[:, :4]].mean(axis=1)
    y, z = body.contour.position(np.array([patch.s]))
    near = np.flatnonzero(np.linalg.norm(centres - [0.0, y[0], z[0]], axis=1) < REACH)
    depth = points_at(body, *centres[near].T).depth
    below = near[(depth > DEPTHS[0]) & (depth < DEPTHS[1])]
    return below[:: max(1, len(below) * 4 // MOST)]


def at_gauss_points(output: Output) -> tuple[Array, Array]:
    """Points (n, 3) and stresses (n, 3, 3) of a run."""
    stresses, points = (np.array(table) for table in output.at_gauss_points())
    xx, yy, zz, xy, xz, yz = stresses.T
    full = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1)
    return points, full.reshape(-1, 3, 3)


def by_femic(body: Body, points: Array) -> Array:
    """The same by femic (n, 3, 3) [MPa]."""
    endless = replace(body, domain=Domain(body.domain.far_radius, np.inf))
    grid = Grid(*ELEMENTS, 2 * PATCH.a / ELEMENTS[0], 2 * PATCH.b / ELEMENTS[1], PATCH.s)
    p = np.broadcast_to(body.side * TRACTION, (*ELEMENTS, 3))  # the lower body gets the opposite
    tractions = SurfaceTractions(grid, np.array(p))
    field = stress_field(endless, tractions, points_at(endless, *points.T), StressSettings(estimated=False))
    return in_section_axes(field)
