"""`femic export`: the IC matrix of both bodies as a file that CONTACT reads."""

from dataclasses import dataclass
from pathlib import Path

import h5netcdf
import numpy as np
from numpy.typing import NDArray

from approx.matrix import matrix
from compare import folders
from compare.matrix import contact_file
from compare.matrix.contact_file import ContactFile
from compare.matrix.report import Asked, write_matrix
from compare.scenes.checks import grid_misfits
from compare.scenes.load import BadScene
from compare.scenes.scene import Scene
from femic.refinement import Watch
from femic.store import Store
from geometries.errors import WrongInput

Array = NDArray[np.float64]

ALIKE = 1e-12  # of the largest IC: strips whose ICs differ less depend on their offset only


@dataclass(frozen=True)
class Exported:
    """A written file and what it holds."""

    path: Path
    file: ContactFile


def checked(scene: Scene, ics: str) -> None:
    """Raise BadScene where the grid does not fit, WrongInput where ICs of both bodies cannot be had."""
    if "combined" not in scene.compared:
        raise WrongInput("bodies: CONTACT needs the ICs of both bodies together: add 'combined'")
    if ics == "Bhat_prime" and not scene.pair.has_effective("combined"):
        raise WrongInput("ics = Bhat_prime: the scene has no effective properties; see femic calibrate")
    errors = list(grid_misfits(scene))
    if errors:
        raise BadScene(f"{scene.name}: {len(errors)} error(s)\n  " + "\n  ".join(errors))


def export(scene: Scene, ics: str, asked: Asked, store: Store, watch: Watch) -> Exported:
    """Write `contact_ICS.txt`: ICs of both bodies by C, computed if it is not there, or an approximation.

    Raises as `checked`.
    """
    checked(scene, ics)
    folders.made(asked.out)
    if ics == "C":
        write_matrix(scene, asked, store, watch)
        values = read_matrix(asked.out / "matrix.nc", "combined")
    else:
        values = matrix(ics, scene.pair, scene.grid)
    file = to_contact(scene, values)
    path = asked.out / f"contact_{ics}.txt"
    watch.on_stage("  writing")
    contact_file.write(file, path)
    return Exported(path, file)


def told(written: Exported) -> str:
    """What a user of CONTACT has to know about a file."""
    file = written.file
    strips = "one matrix for all strips" if file.one_for_all else f"{file.n_s} matrices, one a loaded strip"
    rows = f"at most {file.n_s}" if file.one_for_all else f"exactly {file.n_s}"
    return (
        f"CONTACT file: {written.path}: {strips}, {file.n_x} lags\n"
        f"note: CONTACT's grid must have MX of at most {file.n_x}, MY of {rows}, DX = {file.dx:g}, DY = "
        f"{file.ds:g} mm: beyond these ICs it goes on with zeros and a warning that is easily overlooked"
    )


def to_contact(scene: Scene, ics: Array) -> ContactFile:
    """CONTACT's form of the ICs of both bodies (n_x, n_s, n_s, 3, 3) [mm/MPa] on the scene's grid."""
    grid = scene.grid
    arranged = contact_file.of_offsets_only if depends_on_offset_only(ics) else contact_file.by_offsets
    values = arranged(ics)
    values *= scene.pair.constants.G
    return ContactFile(values, grid.dx, grid.ds, convex_body(scene))


def depends_on_offset_only(ics: Array) -> bool:
    """Whether all strips have the same ICs."""
    moved = np.abs(ics[:, 1:, 1:] - ics[:, :-1, :-1])
    return bool(np.max(moved, initial=0.0) <= ALIKE * np.max(np.abs(ics)))


def convex_body(scene: Scene) -> int:
    """1 the upper, 2 the lower body; 2 for a plane."""
    start, end = scene.bodies["lower"].contour.inclination(np.array(scene.grid.extent))
    return 1 if end < start else 2


def read_matrix(path: Path, body: str) -> Array:
    """C of a body from `matrix.nc` [mm/MPa], (n_x, n_s, n_s, 3, 3)."""
    with h5netcdf.File(path, "r") as file:
        bodies = [name.decode() if isinstance(name, bytes) else str(name) for name in file["body"][...]]
        return np.asarray(file["ic"][bodies.index(body)])


FORMATS = {"contact": export}
