"""Solves the contact of a scene's bodies with several ICs: grids, matrices of C, pressures, their errors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from approx.variants import needed
from compare.results.contact.grids import Sizing
from compare.results.contact.pairing import Case, Placed, placed_on
from compare.results.maps.c_map import open_map
from compare.results.matrix.compute import matrix_jobs
from compare.scenes.errors import BadScene
from compare.scenes.file import is_map
from compare.scenes.scene import Scene
from contact.edges import MARGIN
from contact.normal import NormalContact, Operator, PotentialAreaTooSmall
from contact.operators.dense import GridOperator
from femic.estimate import total
from femic.matrix.job import MatrixJob
from femic.matrix.reference import matrices
from femic.means import DEFAULT, Means
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.grids import Grid
from geometries.patches import COMPONENTS, N

C = "C"
COARSE_MARGIN = 2 * MARGIN + 1  # elements beside a patch, so that elements twice as large have a margin
FRICTIONLESS = ("nn",)  # the components of C that contact without friction needs


@dataclass(frozen=True, eq=False)
class SolvedContact:
    """A contact with some ICs; `perturbed` is the same with C plus its estimated error, None of others."""

    case: Case
    ics: str
    placed: Placed
    normal: NormalContact
    perturbed: NormalContact | None
    displaced: NormalContact | None  # by the reference with the exact distance, where it is found on the grid
    seconds: float


@dataclass(frozen=True, eq=False)
class ReferenceICs:
    """C_nn of both bodies on a grid: operator, the same with C plus its estimate, and what C satisfies."""

    operator: GridOperator
    perturbed: GridOperator
    estimate: float  # largest estimated error over the largest C_nn
    asymmetry: float  # largest |C(I, J) - C(J, I)| over the largest C_nn, before their mean was taken
    eigenvalue: float  # smallest, over the least IC of an element on itself, of pressures without resultant
    eigenvalue_of_load: float  # the same of pressures without vertical load
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
    """The loads or approaches of a scene; raises BadScene where there are none."""
    wanted = scene.contact
    cases = [Case(load, None) for load in wanted.loads] + [Case(None, zeta) for zeta in wanted.approaches]
    if not cases:
        raise BadScene(f"{scene.name}: [contact]: give loads = [...] in N, or approaches = [...] in mm")
    if "Bhat_prime" in needed(approximations_of(wanted.ics)) and not scene.pair.has_effective("combined"):
        raise BadScene(
            f"{scene.name}: contact.ics: Bhat_prime needs effective properties of both bodies: "
            "`femic calibrate` finds some"
        )
    if maps_of(wanted.ics) and wanted.friction:
        raise BadScene(
            f"{scene.name}: contact.ics: {maps_of(wanted.ics)[0]}: maps of C know nn only, for "
            "contact without friction; use C"
        )
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


def compute_contact(scene: Scene, means: Means = DEFAULT) -> ContactResults:
    """Solve all contacts of a scene; raises BadScene for what cannot be solved, and Failure as `contact`."""
    start, cases = perf_counter(), cases_of(scene)
    contacts: dict[tuple[Case, str], SolvedContact] = {}
    references: dict[Grid, ReferenceICs] = {}
    for grid, on_grid in grids_of(scene):
        solved, reference = _on_grid(scene, grid, on_grid, means)
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
    scene: Scene, grid: Grid, cases: Sequence[Case], means: Means
) -> tuple[dict[tuple[Case, str], SolvedContact], ReferenceICs | None]:
    """Contacts of all cases with all ICs on a grid, which is made longer where C needs it, and C on it."""
    placed, reference = placed_on(scene, grid), None
    means.watch.on_stage(
        f"  {grid.n_x} x {grid.n_s} elements of {grid.dx:.3g} x {grid.ds:.3g} mm: "
        + ", ".join(str(case) for case in cases)
    )
    contacts: dict[tuple[Case, str], SolvedContact] = {}
    for name in scene.contact.ics:
        known: KnownICs | None = None
        if name == C:
            known = reference = reference_ics(scene, placed, means)
        elif is_map(name):
            known = map_ics(scene, placed, name)
        for case in cases:
            try:
                contacts[case, name] = _solved(scene, placed, case, name, known)
            except PotentialAreaTooSmall as short:
                if not scene.contact.automatic or maps_of(scene.contact.ics):
                    raise Failure(f"contact at {case} with {name}: {short}") from short
                return _on_grid(scene, sizing_of(scene).longer(grid, short, case), cases, means)
    return contacts, reference


def _solved(scene: Scene, placed: Placed, case: Case, name: str, known: KnownICs | None) -> SolvedContact:
    """One contact; C also with its estimate added, the reference also with the exact distance."""
    start, exact = perf_counter(), scene.contact.exact
    operator: Operator = known.operator if known else placed.operator(name)
    normal = placed.contact(operator, case, exact=exact)
    seconds = perf_counter() - start
    perturbed = placed.contact(known.perturbed, case, exact=exact) if known else None
    try:
        wanted = name == reference_name(scene.contact.ics) and not exact
        displaced = placed.contact(operator, case, exact=True) if wanted else None
    except Failure:  # it is larger than the grid, or there is none: the contact itself stands
        displaced = None
    return SolvedContact(case, name, placed, normal, perturbed, displaced, seconds)


def reference_ics(scene: Scene, placed: Placed, means: Means) -> ReferenceICs:
    """C_nn of both bodies on a grid; raises Failure where it is not positive for pressures without load."""
    start, grid = perf_counter(), placed.grid
    ic, estimate = c_on(scene, placed, means)
    largest = float(np.max(np.abs(ic)))
    asymmetry = float(np.max(np.abs(ic - np.swapaxes(ic, 1, 2)))) / largest
    operator = _operator(ic)
    motions = placed.motions
    eigenvalue, of_load = (_smallest_eigenvalue(ic, freed) for freed in (motions, motions[:1]))
    if not eigenvalue > 0:
        raise Failure(
            f"C on {grid.n_x} x {grid.n_s} elements: its smallest eigenvalue is {eigenvalue:.2g} of the "
            "least IC of an element on itself: pressures without resultant would do negative work; give a "
            "smaller engine.tolerance, or larger elements"
        )
    return ReferenceICs(
        operator,
        _operator(ic + estimate),
        float(np.max(estimate)) / largest,
        asymmetry,
        eigenvalue,
        of_load,
        perf_counter() - start,
    )


def c_on(scene: Scene, placed: Placed, means: Means = DEFAULT) -> tuple[Array, Array]:
    """C_nn of both bodies on a grid and its estimate [mm/MPa], (n_x, n_s, n_s) each."""
    grid, solved = placed.grid, matrices(c_jobs(scene, placed), means, combined=True)
    ic, estimate = np.empty((2, grid.n_x, grid.n_s, grid.n_s))
    for strip in range(grid.n_s):
        column = total([reference.column(strip) for reference in solved.values()])
        ic[..., strip] = grid.area * column.ic[N, N]
        estimate[..., strip] = grid.area * column.estimate[N, N]
    return ic, estimate


def map_ics(scene: Scene, placed: Placed, name: str) -> MapICs:
    """C_nn of both bodies by a map; raises as `compare.results.maps.c_map.CMap.at`."""
    ic, known_to = open_map(name).at(scene, placed)
    return MapICs(_operator(ic), _operator(ic + known_to))


def components_of(scene: Scene) -> tuple[str, ...]:
    """The components of C that the contact of a scene needs."""
    return COMPONENTS if scene.contact.friction else FRICTIONLESS


def c_jobs(scene: Scene, placed: Placed) -> dict[str, MatrixJob]:
    """What C of both bodies on a grid asks for; strips of the upper body lie opposite, on its own contour."""
    jobs = matrix_jobs(replace(scene, grid=placed.grid, compared=("combined",)), components_of(scene))
    return jobs | {"upper": replace(jobs["upper"], grid=placed.upper_grid)}


def _operator(ic: Array) -> GridOperator:
    """The operator of nn ICs (lag, observed, loaded), which are made symmetric."""
    return GridOperator.of((ic + np.swapaxes(ic, 1, 2))[..., None, None] / 2, (N,))


def _smallest_eigenvalue(ic: Array, motions: Array) -> float:
    """The smallest eigenvalue over the least IC of an element on itself, of pressures that move no body.

    A give in the rigid `motions` (n, n_s) is added, as large as the largest IC: so it does not matter how
    much of it the discount has taken away.
    """
    own = float(np.min(np.diagonal(ic[0])))
    give = float(np.max(np.abs(ic))) * motions.T @ motions
    return _operator(ic + give).smallest_eigenvalue() / own
