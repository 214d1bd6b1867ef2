"""`femic export` writes the IC matrix of both bodies as a file for the program CONTACT.

The grid is that of the scene's contact, and the distances on it are written beside the matrix.
"""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from approx.pair import column, matrix
from approx.variants import VARIANTS, needed_forms, needs_effective
from femic.cache import folders
from femic.cache.files import write_text
from femic.contact.loading import Loading
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.pairs.grids import SIZING, contact_size, grids_of
from femic.contact.pairs.ics import C, c_jobs
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.reference.matrix.job import Discount
from femic.reference.matrix.reference import matrices, pair_column
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results import contact_file
from femic.results.contact_file import ContactFile
from femic.results.matrices import compute_matrix
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import require_none
from femic.scenes.ic_names import is_map
from femic.scenes.lines import grid_misfits
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.patches import COMPONENTS

# --- the grid, and distances on it ----------------------------------------------------------------------


FILE = "contact_distances.txt"
FAR = 1000.0  # mm: written where no upper body is opposite, for CONTACT reads no infinite numbers


def grid_is_given(scene: Scene) -> bool:
    """Whether a file has the grid of the scene's table [grid]: it is there, or the contact has no loads."""
    own = set(tomllib.loads(scene.text).get("grid", {})) - {"check"}
    return bool(own) or not scene.contact.loadings or not scene.contact.automatic


def on_contact_grid(scene: Scene) -> Scene:
    """Return a scene with the grid of its contact under the largest load, or with its own where it has one.

    The grid is sized as for contact with C, so that it has no more strips than C is computed for.
    """
    if grid_is_given(scene):
        return scene
    problem = scene.contact_problem
    names = [name for name in problem.specification.ics if not is_map(name)]
    specification = replace(problem.specification, ics=tuple(dict.fromkeys((C, *names))))
    grid, _ = grids_of(replace(problem, specification=specification))[-1]
    return replace(scene, grid=grid)


def missed_contact(scene: Scene) -> str:
    """Return a sentence where the contact of a scene under the largest load leaves its grid; else nothing."""
    grid = scene.grid
    if (loading := largest_loading(scene)) is None:
        return ""
    try:
        size = contact_size(pair_on_grid(scene.contact_problem, grid), loading)
    except Failure as failure:
        return f"femic cannot tell whether the contact lies on the grid: {failure}"
    low, high = grid.extent
    half = grid.n_x * grid.dx / 2
    if low <= size.s[0] and size.s[1] <= high and size.x[1] <= half:
        return ""
    return (
        f"the grid misses contact: it covers s = {low:.4g} ... {high:.4g} mm, x = {-half:.4g} ... {half:.4g} "
        f"mm, and contact at {loading} is at s = {size.s[0]:.4g} ... {size.s[1]:.4g} mm, x = "
        f"{size.x[0]:.4g} ... {size.x[1]:.4g} mm: leave [grid] out and contact.grid at 'automatic', or give "
        f"grid.s = {(size.s[0] + size.s[1]) / 2:.3g} and elements that cover it"
    )


def largest_loading(scene: Scene) -> Loading | None:
    """Return the largest load of a scene's contact, or its largest approach; None where it has neither."""
    loadings = scene.contact.loadings
    return max(loadings, key=lambda each: (each.load or 0.0, each.approach or 0.0), default=None)


def distances(scene: Scene) -> tuple[Array, float, str]:
    """Return the distances on a scene's grid after an approach, the approach [mm], and which that is.

    It is that of the largest load, which B-hat tells. Without loads, and where contact is not on the grid,
    the bodies just touch.
    """
    on_grid, loading = pair_on_grid(scene.contact_problem, scene.grid), largest_loading(scene)
    approach, meaning = 0.0, "the bodies just touch; subtract zeta cos(delta) for an approach zeta"
    if loading is not None:
        try:
            contact = on_grid.solve(on_grid.operator(SIZING), loading)
        except Failure as failure:
            meaning = f"the bodies just touch, because no approach was found: {failure}"
        else:
            on_grid, approach = contact.on_grid, contact.normal.approach
            by_load = f"the approach by B-hat at {loading}; the load is a result"
            meaning = by_load if loading.approach is None else "as contact.approaches says"
            if scene.contact.exact:
                meaning += "; linearised, regardless of contact.gap"
    return distances_after(on_grid, approach), approach, meaning


def distances_after(on_grid: PairOnGrid, approach: float) -> Array:
    """Return h - approach cos(delta) [mm], (n_x, n_s); h are the distances of bodies that just touch."""
    values = on_grid.distance - approach * on_grid.cosine
    return np.where(np.isfinite(values), values, FAR)


def write_distances(values: Array, folder: Path) -> Path:
    """Write distances as a list for CONTACT, x fastest; return the path of the file."""
    lines = "\n".join(repr(float(value)) for value in values.T.ravel())
    return write_text(f"{lines}\n", folder / FILE)


# --- the file -------------------------------------------------------------------------------------------


SAME_ICS = 1e-12  # of the largest IC: below this difference, ICs of strips depend on their offset only
RAW = "; raw: with the rigid compliance of both bodies up to their clamped far arcs"
SUFFIXES: dict[Discount | None, str] = {None: "", "approach": "", "source": "_source", "none": "_raw"}


def require_exportable(scene: Scene, ics: str, discount: Discount | None = None) -> None:
    """Raise BadScene for a grid or an engine that does not fit, WrongInput for ICs that are not available."""
    if "combined" not in scene.compared:
        raise WrongInput("bodies: CONTACT needs the combined ICs of the two bodies; add 'combined'")
    if discount and ics != C:
        raise WrongInput(
            f"discount = {discount}, ics = {ics}: the discount applies to C only; leave --discount out, or "
            "give --ics C"
        )
    is_variant = ics in VARIANTS
    if is_variant and needs_effective(ics) and not scene.pair.has_effective("combined"):
        raise WrongInput(f"ics = {ics}: the scene has no effective properties; see femic calibrate")
    engine_misfits = () if is_variant else matrix_engine_misfits(scene)
    own_grid = grid_misfits(scene) if grid_is_given(scene) else ()
    require_none(scene.name, [*own_grid, *engine_misfits])


def export(
    scene: Scene, ics: str, discount: Discount | None, out: Path, options: RunOptions = DEFAULT
) -> str:
    """Write `contact_ICS.txt` with the ICs of both bodies; return text on the settings for CONTACT.

    `ics` is C, which is computed, after a `discount`, by default the scene's, or an approximation. The grid
    is that of the scene's contact, or its [grid] where it is given; the distances on it are written to
    `contact_distances.txt`. What is missing is said before any ICs are computed. C after the source's
    discount is written to `contact_C_source.txt`, without discount to `contact_C_raw.txt`; on the scene's own
    grid the matrix is kept beside it, `matrix.nc`. Raises as `require_exportable` does, and Failure where no
    grid fits.
    """
    require_exportable(scene, ics, discount)
    watch, discount = options.watch, (discount or scene.discount) if ics == C else None
    folders.make(out)
    placed = on_contact_grid(scene)
    require_none(scene.name, grid_misfits(placed))
    if missed := missed_contact(placed):
        watch.on_stage(f"note: {missed}")
    has_effective = scene.pair.has_effective("combined")
    if ics in VARIANTS and not has_effective and any(form.effective for form in needed_forms([ics])):
        watch.on_stage(
            f"note: {ics}: the scene has no effective properties, so xn is taken from A; femic calibrate "
            "fits them"
        )
    values, approach, meaning = distances(placed)
    on_grid = pair_on_grid(placed.contact_problem, placed.grid)
    if discount is None and on_grid.offset:
        matrix = approximate_matrix(ics, placed.pair, placed.grid, upper_offset=on_grid.offset)
        file = to_contact(placed, matrix)
    elif discount is None:
        file = approximate_file(placed, ics)
    elif discount != scene.discount or on_grid.offset or placed is not scene:
        file = to_contact(placed, discounted_matrix(placed, discount, options))
    else:
        compute_matrix(placed, out / "matrix.nc", options)
        with xr.open_dataset(out / "matrix.nc", engine="h5netcdf") as dataset:
            file = to_contact(placed, dataset.ic.sel(body="combined").values)
    path = out / f"contact_{ics}{SUFFIXES[discount]}.txt"
    watch.on_stage("  writing")
    contact_file.write(file, path)
    write_distances(values, out)
    return contact_settings(placed, file, path, approach, meaning)


def contact_settings(scene: Scene, file: ContactFile, path: Path, approach: float, meaning: str) -> str:
    """Return text on the settings for CONTACT, and on wrong settings that CONTACT does not notice.

    `scene` has the grid of the file; the distances are those after an `approach` [mm] of this `meaning`.
    """
    grid, raw = scene.grid, path.stem.endswith(SUFFIXES["none"])
    strips = (
        "one matrix for all strips, one strip and one lag more than CONTACT's grid"
        if file.one_for_all
        else f"{file.n_s} matrices, one per loaded strip, {file.n_x} lags"
    )
    upper, lower = (scene.bodies[name].material for name in ("upper", "lower"))
    return (
        f"CONTACT file: {path}: {strips}{RAW if raw else ''}\nset in CONTACT: MX = {grid.n_x} or less, MY "
        f"= {grid.n_s}{' or less' if file.one_for_all else ''}, XL = {-grid.n_x * grid.dx / 2:g}, YL = "
        f"{grid.extent[0]:g}, DX = {grid.dx:g}, DY = {grid.ds:g} mm; CHI = 0, DQ = {grid.dx:g} if it "
        f"rolls; body 1 = upper: POISS = {upper.nu:g}, {lower.nu:g}, GG = {upper.G:.8g}, {lower.G:.8g} "
        f"MPa; MAXOUT > 1\ndistances: {path.with_name(FILE)}: h(x, s) - zeta cos(delta(s)) [mm], x "
        f"fastest, for IBASE = 9 with N = 0, PEN = 0; zeta = {approach:.6g} mm, {meaning}\nnote: CONTACT "
        "does not detect wrong XL, YL, CHI, DQ, POISS, GG, or swapped bodies; keep the contact at least "
        "three elements away from the edges of the grid"
    )


def to_contact(scene: Scene, ics: Array) -> ContactFile:
    """Return a file with a matrix per loaded strip, from combined ICs (n_x, n_s, n_s, 3, 3) [mm/MPa]."""
    return to_contact_units(scene, contact_file.by_offsets(ics))


def approximate_file(scene: Scene, variant: str) -> ContactFile:
    """Return a file with an approximation.

    It has one matrix for all strips if ICs depend on their offset only, with one strip and one lag more than
    the scene's grid: CONTACT's preconditioner transforms 2 MX by 2 MY offsets, including -MY, and zeros there
    may make it indefinite.
    """
    pair, grid = scene.pair, scene.grid
    ics = matrix(variant, pair, grid)
    if grid.n_s == 1 or not depends_on_offset_only(ics):
        return to_contact(scene, ics)
    longer = replace(grid, n_x=grid.n_x + 1)
    larger = replace(longer, n_s=grid.n_s + 1)  # the outermost centres lie on the edges of the grid
    ahead, behind = (column(variant, pair, larger, strip) for strip in (0, grid.n_s))
    first, last = (np.moveaxis(end, -1, 0)[None, None] for end in (behind[..., 0], ahead[..., -1]))
    inner = contact_file.common_by_offsets(matrix(variant, pair, longer))
    return to_contact_units(scene, np.concatenate([first, inner, last], axis=1))


def to_contact_units(scene: Scene, by_offset: Array) -> ContactFile:
    """Return a file of ICs arranged by offset [mm/MPa], which become ICs times G.

    The convex body is the lower one, or the upper one where the lower contour is hollow.
    """
    start, end = scene.bodies["lower"].contour.inclination(np.array(scene.grid.extent))
    by_offset *= scene.pair.constants.G
    return ContactFile(by_offset, scene.grid.dx, scene.grid.ds, 1 if end < start else 2)


def discounted_matrix(scene: Scene, discount: Discount, options: RunOptions) -> Array:
    """Return C of both bodies after a discount [mm/MPa], (n_x, n_s, n_s, 3, 3), as for contact.

    Where the upper body is moved along y, its strips lie opposite the strips of the lower body. Models are
    solved unless they are stored.
    """
    problem = replace(scene.contact_problem, discount=discount)
    jobs = c_jobs(problem, pair_on_grid(problem, scene.grid), COMPONENTS)
    solved, contour = matrices(jobs, options, combined=True), scene.bodies["lower"].contour
    columns = [pair_column(solved, contour, strip).ic for strip in range(scene.grid.n_s)]
    return scene.grid.area * np.moveaxis(np.stack(columns), (0, 1, 2, 3, 4), (2, 3, 4, 0, 1))


def depends_on_offset_only(ics: Array) -> bool:
    """Whether ICs (n_x, n_s, n_s, 3, 3) are the same for all pairs of strips with the same offset."""
    moved = np.abs(ics[:, 1:, 1:] - ics[:, :-1, :-1])
    return bool(np.max(moved, initial=0.0) <= SAME_ICS * np.max(np.abs(ics)))


FORMATS = {"contact": export}
