"""`femic export`: the IC matrix of both bodies as a file that CONTACT reads."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import h5netcdf
import numpy as np

from approx.matrix import column, matrix
from compare.reports.matrix import contact_file
from compare.reports.matrix.contact_file import ContactFile
from compare.reports.matrix.page import Asked, write_matrix
from compare.results import folders
from compare.results.matrix.compute import matrix_jobs
from compare.scenes.checks import grid_misfits
from compare.scenes.errors import require_none
from compare.scenes.scene import Scene
from femic.matrix.reference import matrices
from femic.means import DEFAULT, Means
from geometries.arrays import Array
from geometries.errors import WrongInput

ALIKE = 1e-12  # of the largest IC: strips whose ICs differ less depend on their offset only
RAW = "; raw: with the rigid give of both bodies up to their clamped far arcs, without an estimate"


Discount = Literal["rule", "none"]


@dataclass(frozen=True)
class Wanted:
    """Which ICs a file is to have: C, after the rigid-body discount or before it, or an approximation."""

    ics: str
    discount: Discount = "rule"

    @property
    def name(self) -> str:
        """Of the file."""
        return f"contact_{self.ics}{'_raw' if self.discount == 'none' else ''}.txt"


@dataclass(frozen=True)
class Exported:
    """A written file, what it holds and of what."""

    path: Path
    file: ContactFile
    scene: Scene
    wanted: Wanted


def checked(scene: Scene, wanted: Wanted) -> None:
    """Raise BadScene where the grid does not fit, WrongInput where ICs of both bodies cannot be had."""
    if "combined" not in scene.compared:
        raise WrongInput("bodies: CONTACT needs the ICs of both bodies together: add 'combined'")
    if wanted.discount == "none" and wanted.ics != "C":
        raise WrongInput(
            f"discount = none, ics = {wanted.ics}: only C is raw before it is discounted, approximations "
            "have no discount: leave --discount out, or give --ics C"
        )
    if wanted.ics == "Bhat_prime" and not scene.pair.has_effective("combined"):
        raise WrongInput("ics = Bhat_prime: the scene has no effective properties; see femic calibrate")
    require_none(scene.name, grid_misfits(scene))


def export(scene: Scene, wanted: Wanted, out: Path, means: Means = DEFAULT) -> Exported:
    """Write `contact_ICS.txt`: ICs of both bodies by C, computed if it is not there, or an approximation.

    C without the discount goes to `contact_C_raw.txt`. Raises as `checked`.
    """
    checked(scene, wanted)
    folders.made(out)
    file = _file(scene, wanted, out, means)
    path = out / wanted.name
    means.watch.on_stage("  writing")
    contact_file.write(file, path)
    return Exported(path, file, scene, wanted)


def _file(scene: Scene, wanted: Wanted, out: Path, means: Means) -> ContactFile:
    if wanted.ics != "C":
        return approximated(scene, wanted.ics)
    if wanted.discount == "none":
        return to_contact(scene, raw_matrix(scene, means))
    write_matrix(scene, Asked(out), means)
    return to_contact(scene, read_matrix(out / "matrix.nc", "combined"))


def told(written: Exported) -> str:
    """What a user of CONTACT has to set, and what CONTACT would not notice."""
    file, grid = written.file, written.scene.grid
    strips = (
        "one matrix for all strips, one strip and one lag more than CONTACT's grid"
        if file.one_for_all
        else f"{file.n_s} matrices, one a loaded strip, {file.n_x} lags"
    )
    upper, lower = (written.scene.bodies[name].material for name in ("upper", "lower"))
    return (
        f"CONTACT file: {written.path}: {strips}{RAW if written.wanted.discount == 'none' else ''}\n"
        f"set in CONTACT: MX = {grid.n_x} or less, MY = {grid.n_s}{' or less' if file.one_for_all else ''}, "
        f"XL = {-grid.n_x * grid.dx / 2:g}, YL = {grid.extent[0]:g}, DX = {grid.dx:g}, DY = {grid.ds:g} mm; "
        f"CHI = 0, DQ = {grid.dx:g} if it rolls; body 1 = upper: POISS = {upper.nu:g}, {lower.nu:g}, "
        f"GG = {upper.G:.8g}, {lower.G:.8g} MPa; MAXOUT > 1\n"
        "note: CONTACT does not notice other XL, YL, CHI, DQ, POISS, GG, or swapped bodies; contact must "
        "stay clear of the grid's edges: docs/contact-export.md"
    )


def to_contact(scene: Scene, ics: Array) -> ContactFile:
    """ICs of both bodies (n_x, n_s, n_s, 3, 3) [mm/MPa] on the scene's grid: one matrix a loaded strip."""
    return _scaled(scene, contact_file.by_offsets(ics))


def approximated(scene: Scene, variant: str) -> ContactFile:
    """An approximation: one matrix for all strips if it depends on their offset only.

    Such a file has one strip and one lag more than the scene's grid: CONTACT's preconditioner transforms
    2 MX by 2 MY offsets, -MY among them, and zeros there may make it indefinite.
    """
    pair, grid = scene.pair, scene.grid
    ics = matrix(variant, pair, grid)
    if grid.n_s == 1 or not depends_on_offset_only(ics):
        return to_contact(scene, ics)
    longer = replace(grid, n_x=grid.n_x + 1)
    larger = replace(longer, n_s=grid.n_s + 1)  # the outermost centres lie on the edges of the grid
    ahead, behind = (column(variant, pair, larger, strip) for strip in (0, grid.n_s))
    first, last = (np.moveaxis(end, -1, 0)[None, None] for end in (behind[..., 0], ahead[..., -1]))
    inner = contact_file.of_offsets_only(matrix(variant, pair, longer))
    return _scaled(scene, np.concatenate([first, inner, last], axis=1))


def _scaled(scene: Scene, values: Array) -> ContactFile:
    values *= scene.pair.constants.G
    return ContactFile(values, scene.grid.dx, scene.grid.ds, convex_body(scene))


def raw_matrix(scene: Scene, means: Means) -> Array:
    """C of both bodies before the discount [mm/MPa], (n_x, n_s, n_s, 3, 3); models are solved, or kept.

    It contains the rigid give of both bodies up to their clamped far arcs; its error is not estimated.
    """
    found = matrices(matrix_jobs(scene), means, combined=True)
    columns = [
        np.sum([one.raw_column(strip) for one in found.values()], axis=0) for strip in range(scene.grid.n_s)
    ]
    return scene.grid.area * np.moveaxis(np.stack(columns), (0, 1, 2, 3, 4), (2, 3, 4, 0, 1))


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
