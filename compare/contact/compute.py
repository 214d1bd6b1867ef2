"""Solves the contact of a scene's bodies with several ICs: grids, matrices of C, pressures, their errors."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from approx.variants import needs_effective
from compare.contact.automatic_grid import Sizing
from compare.contact.feasibility import impossible
from compare.contact.pair_on_grid import Case, Placed, Settled, placed_on
from compare.matrix.compute import matrix_jobs
from femic.campaigns.maps.c_map import open_map
from femic.contact.edges import MARGIN
from femic.contact.normal import NormalContact, Operator, PotentialAreaTooSmall
from femic.contact.operators.dense import GridOperator
from femic.reference.matrix.job import MatrixJob
from femic.reference.matrix.reference import MatrixReference, matrices
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.engine import matrix_engine_misfits
from femic.scenes.errors import BadScene, require_none
from femic.scenes.ic_names import is_map
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.grids import Grid
from geometries.patches import COMPONENTS, N

C = "C"
COARSE_MARGIN = 2 * MARGIN + 1  # elements beside a patch, so that elements twice as large have a margin
SAME = 1e-6  # difference of mirrored ICs over the largest, to which they are the same
FRICTIONLESS = ("nn",)  # the components of C that contact without friction needs


@dataclass(frozen=True, eq=False)
class SolvedContact:
    """A contact with some ICs; `perturbed` is the same with C plus its estimated error, None of others."""

    case: Case
    ics: str
    settled: Settled
    perturbed: Settled | None
    displaced: Settled | None  # by the reference with the exact distance, where it is found on the grid
    seconds: float

    @property
    def placed(self) -> Placed:
        """The bodies on the grid."""
        return self.settled.placed

    @property
    def normal(self) -> NormalContact:
        """The contact."""
        return self.settled.normal


@dataclass(frozen=True, eq=False)
class ReferenceICs:
    """C_nn of both bodies on a grid: operator, the same with C plus its estimate, and what C satisfies."""

    operator: GridOperator
    perturbed: GridOperator
    estimate: float  # largest estimated error over the largest C_nn
    asymmetry: float  # largest |C(I, J) - C(J, I)| over the largest C_nn, before their mean was taken
    eigenvalue: float  # smallest of C_nn over the least IC of an element on itself (`require_positive`)
    seconds: float


@dataclass(frozen=True, eq=False)
class MapICs:
    """C_nn of both bodies by a map: operator, and the same with all that it is known to added."""

    operator: GridOperator
    perturbed: GridOperator


KnownICs = ReferenceICs | MapICs


@dataclass(frozen=True, eq=False)
class ContactResults:
    """The contacts of a scene, by case and ICs, in the order in which the scene gives them."""

    scene: Scene
    cases: tuple[Case, ...]
    ics: tuple[str, ...]
    contacts: Mapping[tuple[Case, str], SolvedContact]
    references: Mapping[Grid, ReferenceICs]  # of the grids, where C is wanted
    seconds: float


def cases_of(scene: Scene) -> tuple[Case, ...]:
    """The loads or approaches of a scene; raises BadScene where its contact cannot be solved."""
    wanted = scene.contact
    side = wanted.lateral_force
    cases = [Case(load, None, side) for load in wanted.loads]
    cases += [Case(None, zeta, side) for zeta in wanted.approaches]
    if not cases:
        raise BadScene(f"{scene.name}: [contact]: give loads = [...] in N, or approaches = [...] in mm")
    if needs_effective(approximations_of(wanted.ics)) and not scene.pair.has_effective("combined"):
        raise BadScene(
            f"{scene.name}: contact.ics: Bhat_prime needs effective properties of both bodies: "
            "`femic calibrate` finds some"
        )
    if maps_of(wanted.ics) and wanted.friction:
        raise BadScene(
            f"{scene.name}: contact.ics: {maps_of(wanted.ics)[0]}: maps of C know nn only, for "
            "contact without friction; use C"
        )
    engine_misfits = matrix_engine_misfits(scene) if C in wanted.ics else ()
    require_none(scene.name, [*engine_misfits, *impossible(scene)])
    return tuple(cases)


def approximations_of(ics: Sequence[str]) -> list[str]:
    """The names of approximations among those of ICs."""
    return [name for name in ics if name != C and not is_map(name)]


def maps_of(ics: Sequence[str]) -> list[str]:
    """The names of maps of C among those of ICs."""
    return [name for name in ics if is_map(name)]


def reference_name(ics: Sequence[str]) -> str:
    """The ICs that others are compared with: C, or where it is not there a map of it, B-hat, or the last."""
    return next((name for name in (C, *maps_of(ics), "Bhat") if name in ics), ics[-1])


def compute_contact(scene: Scene, options: RunOptions = DEFAULT) -> ContactResults:
    """Solve all contacts of a scene; raises BadScene for what cannot be solved, and Failure as `contact`."""
    start, cases = perf_counter(), cases_of(scene)
    contacts: dict[tuple[Case, str], SolvedContact] = {}
    references: dict[Grid, ReferenceICs] = {}
    for grid, on_grid in grids_of(scene):
        solved, reference = _on_grid(scene, grid, on_grid, options)
        contacts |= solved
        if reference is not None:
            references[next(iter(solved.values())).placed.grid] = reference
    return ContactResults(scene, cases, scene.contact.ics, contacts, references, perf_counter() - start)


def grids_of(scene: Scene) -> list[tuple[Grid, list[Case]]]:
    """The grids and the cases on them: that of the scene, or automatic ones; raises as `cases_of`.

    A map of C has a grid of its own, on which all is solved.
    With friction there is one, that of the largest load, which the steps to it share.
    """
    cases = cases_of(scene)
    if maps := maps_of(scene.contact.ics):
        return [(_grid_of(scene, maps), list(cases))]
    sizing = sizing_of(scene)
    if not scene.contact.automatic:
        return [(scene.grid, list(cases))]
    if scene.contact.friction:
        largest = cases[-1:]
        return [(_large_enough(scene, sizing.grid([sizing.size(largest[0])]), largest), list(cases))]
    return [(_large_enough(scene, grid, on_grid), on_grid) for grid, on_grid in sizing.grids(cases)]


def _large_enough(scene: Scene, grid: Grid, cases: Sequence[Case]) -> Grid:
    return sizing_of(scene).large_enough(grid, cases, approximations_of(scene.contact.ics))


def _grid_of(scene: Scene, maps: Sequence[str]) -> Grid:
    """The grid of maps of C; raises BadScene where they have several."""
    grids = {name: open_map(name).grid for name in maps}
    if len(set(grids.values())) > 1:
        raise BadScene(f"{scene.name}: contact.ics: {', '.join(grids)} have different grids: name one")
    return grids[maps[0]]


def sizing_of(scene: Scene) -> Sizing:
    """What sizes the automatic grids of a scene; those with friction are also solved with larger elements."""
    placed, elements = placed_on(scene, scene.grid), scene.contact.elements
    return Sizing(placed, elements, COARSE_MARGIN) if scene.contact.friction else Sizing(placed, elements)


def _on_grid(
    scene: Scene, grid: Grid, cases: Sequence[Case], options: RunOptions
) -> tuple[dict[tuple[Case, str], SolvedContact], ReferenceICs | None]:
    """Contacts of all cases with all ICs on a grid, which is made longer where C needs it, and C on it."""
    placed, reference = placed_on(scene, grid), None
    options.watch.on_stage(
        f"  {grid.n_x} x {grid.n_s} elements of {grid.dx:.3g} x {grid.ds:.3g} mm: "
        + ", ".join(str(case) for case in cases)
    )
    contacts: dict[tuple[Case, str], SolvedContact] = {}
    for name in scene.contact.ics:
        known: KnownICs | None = None
        if name == C:
            known = reference = reference_ics(scene, placed, options)
        elif is_map(name):
            known = map_ics(scene, placed, name)
        for case in cases:
            try:
                contacts[case, name] = _solved(scene, placed, case, name, known)
            except PotentialAreaTooSmall as short:
                if not scene.contact.automatic or maps_of(scene.contact.ics):
                    raise Failure(f"contact at {case} with {name}: {short}") from short
                return _on_grid(scene, sizing_of(scene).longer(grid, short, case), cases, options)
    return contacts, reference


def _solved(scene: Scene, placed: Placed, case: Case, name: str, known: KnownICs | None) -> SolvedContact:
    """One contact; C also with its estimate added, the reference also with the exact distance."""
    start, exact = perf_counter(), scene.contact.exact
    operator: Operator = known.operator if known else placed.operator(name)
    settled = placed.settled(operator, case, exact=exact)
    seconds = perf_counter() - start
    perturbed = placed.settled(known.perturbed, case, exact=exact) if known else None
    try:
        wanted = name == reference_name(scene.contact.ics) and not exact
        displaced = placed.settled(operator, case, exact=True) if wanted else None
    except Failure:  # it is larger than the grid, or there is none: the contact itself stands
        displaced = None
    return SolvedContact(case, name, settled, perturbed, displaced, seconds)


def reference_ics(scene: Scene, placed: Placed, options: RunOptions) -> ReferenceICs:
    """C_nn of both bodies on a grid; raises Failure as `require_positive`."""
    start = perf_counter()
    ic, estimate = c_on(scene, placed, options)
    largest = float(np.max(np.abs(ic)))
    asymmetry = float(np.max(np.abs(ic - np.swapaxes(ic, 1, 2)))) / largest
    return ReferenceICs(
        _operator(ic),
        _operator(ic + estimate),
        float(np.max(estimate)) / largest,
        asymmetry,
        require_positive(scene, placed, ic),
        perf_counter() - start,
    )


def require_positive(scene: Scene, placed: Placed, ic: Array) -> float:
    """The smallest eigenvalue of C_nn (n_x, n_s, n_s) for the pressures that a contact may have.

    It is divided by the least IC of an element on itself. Where loads are given these pressures are all those
    without vertical load, by which solutions may differ; where all is symmetric they are symmetric. Raises
    Failure where the eigenvalue is not positive: then no solution is the only one, nor stable.
    """
    freed = placed.cosine[None] if scene.contact.loads else np.zeros((0, placed.grid.n_s))
    symmetric = placed.symmetric and np.allclose(
        ic, ic[:, ::-1, ::-1], rtol=0, atol=SAME * np.max(np.abs(ic))
    )
    eigenvalue = smallest_eigenvalue(ic, freed, symmetric=symmetric)
    if eigenvalue > 0:
        return eigenvalue
    raise Failure(
        f"C_nn on {placed.grid.n_x} x {placed.grid.n_s} elements, discount = {scene.discount!r}: its "
        f"smallest eigenvalue is {eigenvalue:.2g} of the least IC of an element on itself: some pressures"
        f"{' without vertical load' if len(freed) else ''} would do negative work. " + _remedy(scene)
    )


def _remedy(scene: Scene) -> str:
    if scene.discount == "source":
        return (
            "This discount takes the bending of the sections from C, more than the bodies have at long "
            "distances; use discount = 'approach'"
        )
    return "Give a smaller engine.tolerance, or larger elements" + (
        "" if scene.contact.loads else "; or loads instead of approaches"
    )


def c_on(scene: Scene, placed: Placed, options: RunOptions = DEFAULT) -> tuple[Array, Array]:
    """C_nn of both bodies on a grid and its estimate [mm/MPa], (n_x, n_s, n_s) each."""
    solved = matrices(c_jobs(scene, placed), options, combined=True)
    estimate = _sum_nn(solved, placed.grid, lambda reference, strip: reference.column(strip).estimate)
    return nn_of(solved, placed), estimate


def nn_operator(solved: Mapping[str, MatrixReference], placed: Placed, variation: str = "") -> GridOperator:
    """The operator of C_nn of both bodies; `variation` "nearer": with far arcs of half the radius."""
    return _operator(nn_of(solved, placed, variation))


def nn_of(solved: Mapping[str, MatrixReference], placed: Placed, variation: str = "") -> Array:
    """C_nn of both bodies [mm/MPa], shape (n_x, n_s, n_s).

    The approach that is subtracted moves the bodies as that of a contact does, along the lower normals: so
    pressures do not depend on it. (Each body's own would not cancel where contours differ: the bodies' M_zz
    are large and of opposite signs, and normals at equal arc lengths are not parallel.)
    """
    raw = _sum_nn(solved, placed.grid, lambda reference, strip: reference.paired_column(strip, variation))
    approach = placed.grid.area * sum(reference.approach(variation) for reference in solved.values())
    return raw - approach * np.outer(placed.cosine, placed.cosine)


def _sum_nn(
    solved: Mapping[str, MatrixReference], grid: Grid, column: Callable[[MatrixReference, int], Array]
) -> Array:
    """The sum of bodies' nn columns [mm/MPa], shape (n_x, n_s, n_s)."""
    values = np.zeros((grid.n_x, grid.n_s, grid.n_s))
    for reference in solved.values():
        for strip in range(grid.n_s):
            values[..., strip] += grid.area * column(reference, strip)[N, N]
    return values


def map_ics(scene: Scene, placed: Placed, name: str) -> MapICs:
    """C_nn of both bodies by a map; raises as `femic.campaigns.maps.c_map.CMap.at`."""
    ic, known_to = open_map(name).at(scene, placed)
    return MapICs(_operator(ic), _operator(ic + known_to))


def components_of(scene: Scene) -> tuple[str, ...]:
    """The components of C that the contact of a scene needs."""
    return COMPONENTS if scene.contact.friction else FRICTIONLESS


def c_jobs(scene: Scene, placed: Placed, components: tuple[str, ...] | None = None) -> dict[str, MatrixJob]:
    """What C of both bodies on a grid asks for; strips of the upper body lie opposite, on its own contour.

    Its `components` are by default those that the contact of the scene needs.
    """
    on_grid = replace(scene, grid=placed.grid, compared=("combined",))
    jobs = matrix_jobs(on_grid, components or components_of(scene))
    return jobs | {"upper": replace(jobs["upper"], grid=placed.upper_grid)}


def _operator(ic: Array) -> GridOperator:
    """The operator of nn ICs (lag, observed, loaded), which are made symmetric."""
    return GridOperator.of((ic + np.swapaxes(ic, 1, 2))[..., None, None] / 2, (N,))


def smallest_eigenvalue(ic: Array, freed: Array, *, symmetric: bool = False) -> float:
    """The smallest eigenvalue of nn ICs (n_x, n_s, n_s) over the least IC of an element on itself.

    It is that of pressures without resultant along the motions `freed` (n, n_s): a give in these is added, as
    large as the largest IC. `symmetric`: of pressures that are symmetric about the middle of the grid.
    """
    own = float(np.min(np.diagonal(ic[0])))
    give = float(np.max(np.abs(ic))) * freed.T @ freed
    constrained = ic + give
    return _operator(_folded(constrained) if symmetric else constrained).smallest_eigenvalue() / own


def _folded(ic: Array) -> Array:
    """The same for symmetric pressures: those on the strips of one half, and of the middle one."""
    n_s = ic.shape[1]
    half = (n_s + 1) // 2
    folded = ic[:, :half, :half] + ic[:, :half, ::-1][..., :half]
    if n_s % 2:  # the middle strip is its own mirror image; its pressures count once
        folded[..., -1] /= np.sqrt(2)
        folded[:, -1] /= np.sqrt(2)
    return np.asarray(folded)
