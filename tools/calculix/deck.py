"""CalculiX: its input from meshes, loads and steps, its run, and its output."""

import os
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from meshing import Mesh, quadratic

from geometries.arrays import Array, Indices
from geometries.errors import Failure
from geometries.materials import Material

PROGRAM = "ccx"
PER_LINE = 12  # numbers per line of a set
# area coordinates and weights of Gauss points on a triangle, exact to degree 4: Dunavant (1985), 6 points
_A, _B, _WA, _WB = 0.445948490915965, 0.091576213509771, 0.223381589678011, 0.109951743655322
GAUSS = np.array([np.roll([1 - 2 * c, c, c], k) for c in (_A, _B) for k in range(3)])
WEIGHTS = np.repeat([_WA, _WB], 3)


def installed() -> bool:
    """Whether CalculiX can be run."""
    return shutil.which(PROGRAM) is not None


def face_loads(mesh: Mesh, faces: Indices, traction: Array) -> Array:
    """Consistent forces [N] (n, 3) of a uniform traction [MPa] along the local x, s, n of faces (k, 6)."""
    shapes, slopes = quadratic(GAUSS), _slopes(GAUSS)
    corners = mesh.nodes[faces]  # (k, 6, 3)
    tangents = np.einsum("gan,knc->kgac", slopes, corners)
    area = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) / 2
    at = np.einsum("gn,knc->kgc", shapes, mesh.chart[faces])
    axes = mesh.body.surface.axes(*at.reshape(-1, 2).T).reshape(3, 3, *area.shape)
    force = np.einsum("d,dckg->kgc", traction, axes)
    of_nodes = np.einsum("g,kg,gn,kgc->knc", WEIGHTS, area, shapes, force)
    loads = np.zeros_like(mesh.nodes)
    np.add.at(loads, faces, of_nodes)
    return loads


def _slopes(areas: Array) -> Array:
    """Derivatives of the shape functions by the second and third area coordinate, shape (g, 2, 6)."""
    a, b, c = areas.T
    zero = np.zeros_like(a)
    by_b = [1 - 4 * a, 4 * b - 1, zero, 4 * (a - b), 4 * c, -4 * c]
    by_c = [1 - 4 * a, zero, 4 * c - 1, -4 * b, 4 * b, 4 * (a - c)]
    return np.stack([np.stack(by_b, axis=1), np.stack(by_c, axis=1)], axis=1)


@dataclass(frozen=True, eq=False)
class Part:
    """A meshed body in the input: its name, its material, and the numbers of its first node and cell."""

    name: str
    mesh: Mesh
    first_node: int = 1
    first_cell: int = 1

    def node(self, index: Indices) -> Indices:
        """CalculiX's numbers of nodes."""
        return np.asarray(index) + self.first_node

    def lines(self) -> Iterable[str]:
        """Nodes, cells, material and the sets FAR-name, CUT-name."""
        mesh, material = self.mesh, self.mesh.body.material
        yield "*NODE"
        for number, (x, y, z) in enumerate(mesh.nodes.tolist(), self.first_node):
            yield f"{number},{x:.14g},{y:.14g},{z:.14g}"
        yield f"*ELEMENT,TYPE=C3D10,ELSET=ALL-{self.name}"
        for number, cell in enumerate(self.node(mesh.cells).tolist(), self.first_cell):
            yield f"{number}," + ",".join(map(str, cell))
        yield from node_set(f"FAR-{self.name}", self.node(np.flatnonzero(mesh.supported)))
        yield from node_set(f"CUT-{self.name}", self.node(np.flatnonzero(mesh.symmetric & ~mesh.supported)))
        yield from elastic(self.name, material)


def elastic(name: str, material: Material) -> Iterable[str]:
    """A linear elastic material of all cells of a part."""
    yield f"*MATERIAL,NAME=OF-{name}"
    yield "*ELASTIC"
    yield f"{material.E:.10g},{material.nu:.10g}"
    yield f"*SOLID SECTION,ELSET=ALL-{name},MATERIAL=OF-{name}"


def node_set(name: str, numbers: Iterable[int]) -> Iterable[str]:
    """A named set of nodes."""
    yield f"*NSET,NSET={name}"
    yield from _listed(numbers)


def element_set(name: str, numbers: Iterable[int]) -> Iterable[str]:
    """A named set of cells."""
    yield f"*ELSET,ELSET={name}"
    yield from _listed(numbers)


def _listed(numbers: Iterable[int]) -> Iterable[str]:
    """Lines of a set."""
    words = [str(int(number)) for number in numbers]
    for start in range(0, len(words), PER_LINE):
        yield ",".join(words[start : start + PER_LINE]) + ","


def element_faces(part: Part, faces: Indices) -> Iterable[str]:
    """CalculiX's element faces "number, Sk" of the given faces (k, 6) of a part."""
    corners = {tuple(sorted(face)): None for face in faces[:, :3].tolist()}
    sides = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))
    for side, of_side in enumerate(sides, 1):
        for cell, nodes in enumerate(np.sort(part.mesh.cells[:, of_side], axis=1).tolist(), part.first_cell):
            if tuple(nodes) in corners:
                yield f"{cell},S{side}"


def nodal_forces(part: Part, loads: Array) -> Iterable[str]:
    """Concentrated forces, which replace those of earlier steps."""
    yield "*CLOAD,OP=NEW"
    for node in np.flatnonzero(np.any(loads != 0, axis=1)):
        for direction, force in enumerate(loads[node].tolist(), 1):
            yield f"{part.node(node)},{direction},{force:.14g}"


@dataclass(frozen=True)
class Output:
    """The files that a run left."""

    folder: Path
    name: str

    def nodal(self) -> list[dict[int, Array]]:
        """The tables of nodal values that were printed, one per step and request: values by node."""
        tables: list[dict[int, Array]] = []
        for words in self._lines("dat"):
            if "set" in words:
                tables.append({})
            elif words and tables and words[0].isdigit():
                tables[-1][int(words[0])] = np.array([float(word) for word in words[1:]])
        return tables

    def at_gauss_points(self) -> list[list[Array]]:
        """The tables of values at Gauss points that were printed, point by point."""
        tables: list[list[Array]] = []
        for words in self._lines("dat"):
            if "set" in words:
                tables.append([])
            elif words and tables and words[0].isdigit():
                tables[-1].append(np.array([float(word) for word in words[2:]]))
        return tables

    def total_forces(self) -> dict[str, Array]:
        """The total forces [N] of sets that were printed last, (3,) by the name of the set."""
        forces, name = {}, ""
        for words in self._lines("dat"):
            if "force" in words and "set" in words:
                name = words[words.index("set") + 1]
            elif name and len(words) == 3:
                forces[name] = np.array([float(word) for word in words])
        return forces

    def contact_pressures(self) -> dict[int, float]:
        """Contact pressures [MPa] of the last increment by node."""
        pressures: dict[int, float] = {}
        reading = False
        for line in (self.folder / f"{self.name}.frd").read_text().splitlines():
            if line.startswith(" -4"):
                reading = line.split()[1] == "CONTACT"
                pressures = {} if reading else pressures
            elif line.startswith(" -3"):
                reading = False
            elif reading and line.startswith(" -1"):
                pressures[int(line[3:13])] = float(line[13 + 3 * 12 : 13 + 4 * 12])
        return pressures

    def _lines(self, ending: str) -> list[list[str]]:
        text = (self.folder / f"{self.name}.{ending}").read_text()
        return [line.split() for line in text.splitlines()]


def run(lines: Iterable[str], folder: Path, name: str, threads: int = 1) -> Output:
    """Write an input, run CalculiX, and return its output. Raises Failure where it ends early."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.inp").write_text("\n".join(lines) + "\n")
    for old in (".dat", ".frd", ".sta"):
        (folder / f"{name}{old}").unlink(missing_ok=True)
    environment = os.environ | {"OMP_NUM_THREADS": str(threads)}
    with (folder / f"{name}.log").open("w") as log:
        subprocess.run(
            [PROGRAM, "-i", name], cwd=folder, stdout=log, stderr=log, env=environment, check=False
        )
    text = (folder / f"{name}.log").read_text()
    if "Job finished" not in text:
        raise Failure(f"CalculiX did not finish: see {folder / name}.log")
    return Output(folder, name)
