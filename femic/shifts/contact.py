"""The contact of one wheel and its rail in a position of the wheelset, without friction, with several ICs.

Both sections are seen from the touching point, in axes parallel to the axle: the rail is turned by its
inclination and against the roll, the wheel, a body of revolution, is not turned. The given load is vertical,
perpendicular to the track. Rolled by phi to it, the contact is solved under the load perpendicular to the
axle F_z' that gives F_y' sin(phi) + F_z' cos(phi) = load with B-hat; the lateral force follows.

All patches are solved on one grid: it covers the strips where the undeformed profiles overlap at the approach
of the main patch, which is more than that of several patches together.
"""

from dataclasses import dataclass, replace

import numpy as np

from approx.pair import Pair, Solid
from femic.contact.edges import Extent
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.normal import NormalContact
from femic.contact.pairs.automatic_grid import sizing_of
from femic.contact.pairs.contact_size import Size, contact_size
from femic.contact.pairs.frictionless import SolvedContact, solve_frictionless
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.quantities import angle
from femic.contact.pairs.supports import other_supports
from femic.contact.specification import APPROACH_SHARE, ContactProblem, ContactSpecification
from femic.reference.harmonic.tuned import FAR_RADIUS
from femic.reference.job import Settings
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.engine import EngineTable
from femic.shifts.specification import C, ProfileTable
from geometries.arrays import Array
from geometries.bodies import Body, common_extent
from geometries.errors import Failure
from geometries.grids import Grid
from geometries.materials import Material
from geometries.patches import Patch
from geometries.profiles.placement import STEEPEST, contour_at
from geometries.surfaces import LOWER, UPPER
from geometries.track.layout import Layout
from geometries.track.strips import Strip, strips
from geometries.track.wheelset import Position, SideName, Touch, side_of

SIZING = "Bhat"  # the ICs that size grids and balance the load
C_FLANK = float(
    np.radians(60.0)
)  # of the bodies of C: steeper ones are pillars that bend under lateral forces
BALANCE, BALANCE_STEPS = 1e-6, 8  # of the vertical load, as a share of it
MOST_STRIPS = 256  # of a grid over several patches
MOST_ALONG_X = 160  # elements of such a grid, and of finer ones
ACROSS = 8  # elements across each patch, at least, along x and s
COUNTS = 0.01  # share of the pressures from which on a patch counts
ACCURACY = 0.02  # estimated error of p_max, as a share of it, above which the grid is made finer along s
REFINEMENTS = 3  # largest number
LEAST_LENGTH, LARGEST_LENGTH = (
    10.0,
    300.0,
)  # reference length [mm]: the rail's radius of curvature within this


@dataclass(frozen=True, eq=False)
class PatchNumbers:
    """A patch: share of the vertical load, range of s on the rail and half-length along x [mm], p_max [MPa].

    `outline` are arc lengths of the rail and half-lengths along x [mm], (2, n), from the centres of the
    elements.
    """

    share: float
    s: tuple[float, float]
    half_length: float
    p_max: float
    outline: Array


@dataclass(frozen=True, eq=False)
class ICsNumbers:
    """The contact with some ICs: pressures in MPa, lengths in mm, forces in N, angle in degrees.

    `vertical` and `lateral` are forces on the wheel in axes of the track, the latter positive towards its
    middle. `angle` is the change of the rail's inclination across the main patch.
    """

    ics: str
    p_max: float
    estimate_p_max: float
    approach: float
    vertical: float
    lateral: float
    angle: float
    a: float
    b: float
    seconds: float
    patches: tuple[PatchNumbers, ...]


@dataclass(frozen=True, eq=False)
class SideContact:
    """The contact of a side with all ICs, on one grid; sentences about what was left out."""

    numbers: tuple[ICsNumbers, ...]
    grid: Grid
    load: float  # perpendicular to the axle [N]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Place:
    """Where a contact is: a side of a layout in a position, its main touching point, the roll of the side."""

    layout: Layout
    position: Position
    side: SideName

    @property
    def touch(self) -> Touch:
        """The main touching point."""
        return self.position.left[0] if self.side == "left" else self.position.right[0]

    @property
    def roll(self) -> float:
        """Roll [rad] in the axes of the side."""
        return self.position.pose(self.side)[1]


@dataclass(frozen=True)
class Wanted:
    """What a contact is solved for: load [N], ICs, elements across the main patch, and from where on C."""

    load: float
    ics: tuple[str, ...]
    elements: int = 20
    c_above_deg: float | None = None


def bodies_at(
    place: Place, rail: ProfileTable, wheel: ProfileTable, steepest: float = STEEPEST
) -> dict[str, Body]:
    """Return rail and wheel seen from the touching point, with flanks where they are `steepest` [rad].

    Raises WrongInput where they are steeper at the touching point.
    """
    side, touch = side_of(place.layout, place.side), place.touch
    turn = side.rail.angle - place.roll
    lower = contour_at(side.rail.curve, touch.s_rail, turn=turn, steepest=steepest)
    upper = contour_at(side.wheel.curve, touch.s_wheel, steepest=steepest)
    domain = EngineTable().domain
    return {
        "lower": Body(LOWER, lower, Material(rail.E, rail.nu), domain),
        "upper": Body(UPPER, upper, Material(wheel.E, wheel.nu), domain, touch.radius),
    }


def problem_of(
    bodies: dict[str, Body], wanted: Wanted, load: float, grid: Grid | None = None
) -> ContactProblem:
    """Return the contact of two bodies under a load perpendicular to the axle [N], on a grid if given."""
    curvature = abs(float(bodies["lower"].contour.curvature(0.0)))
    length = float(np.clip(1 / max(curvature, 1 / LARGEST_LENGTH), LEAST_LENGTH, LARGEST_LENGTH))
    solids = {name: Solid(body.material, body.surface) for name, body in bodies.items()}
    specification = ContactSpecification(
        loads=(load,),
        ics=tuple(dict.fromkeys(wanted.ics)),
        elements=wanted.elements,
        grid="scene" if grid else "automatic",
        supports=False,
    )
    return ContactProblem(
        "shift",
        bodies,
        Pair(solids["upper"], solids["lower"]),
        specification,
        grid or Grid(8, 8, 1.0, 1.0),
        _settings(bodies, length),
        "approach",
        FAR_RADIUS,
        length,
    )


def _settings(bodies: dict[str, Body], length: float) -> Settings:
    """Return settings of C as of scenes with these bodies and reference length [mm]."""
    extent, domain = common_extent(bodies), bodies["lower"].domain
    turn = 2 * np.pi * bodies["upper"].rolling_radius
    room = float(min(domain.far_radius / 8, turn / 6, -extent[0], extent[1]))
    reach, table = min(2 * length, room), EngineTable()
    return Settings(
        engine=table.engine,
        tolerance=table.tolerance,
        cells=table.cells(Patch(reach / 100, reach / 100)),
        most_unknowns=table.most_unknowns,
        rotation_reach=reach,
        moment_arm=min(length / 2, room / 2),
        approach_side=length / APPROACH_SHARE,
        solver=table.solver,
    )


def contact_at(
    place: Place,
    rail: ProfileTable,
    wheel: ProfileTable,
    wanted: Wanted,
    options: RunOptions = DEFAULT,
) -> SideContact:
    """Return the contact of a side in a position with all ICs. Raises Failure and WrongInput.

    C is left out, with a sentence, where it has no solution.
    """
    others = tuple(name for name in wanted.ics if name != C) or (SIZING,)
    without_c = replace(wanted, ics=others)
    bodies = bodies_at(place, rail, wheel)
    grid, load, notes = _fitted(place, bodies, without_c)
    solved = _solved(bodies, without_c, load, grid, options)
    numbers = tuple(_numbers(place, contact) for contact in solved)
    contact = SideContact(numbers, grid, load, notes)
    beyond = wanted.c_above_deg is not None and max(row.angle for row in numbers) > wanted.c_above_deg
    if C not in wanted.ics and not beyond:
        return contact
    try:
        return _with_c(place, rail, wheel, replace(wanted, ics=(*others, C)), options)
    except Failure as failure:
        return replace(contact, notes=(*notes, f"C is left out: {failure}"))


def _with_c(
    place: Place, rail: ProfileTable, wheel: ProfileTable, wanted: Wanted, options: RunOptions
) -> SideContact:
    """Return the contact with all ICs and C, of bodies with flanks as C has them, on a grid of their own.

    The estimated error of C has the change by nearer supports in it. Raises Failure.
    """
    inclination = abs(place.touch.angle - place.roll)
    if inclination >= C_FLANK:
        raise Failure(
            f"the contact angle is {np.degrees(inclination):.1f} degrees; the bodies of C end in flanks of "
            f"{np.degrees(C_FLANK):.0f} degrees"
        )
    bodies = bodies_at(place, rail, wheel, C_FLANK)
    grid, load, notes = _fitted(place, bodies, wanted)
    solved = _solved(bodies, wanted, load, grid, options)
    problem = problem_of(bodies, replace(wanted, ics=(C,)), load, grid)
    on_grid = pair_on_grid(problem, grid)
    nearer = next(other_supports(problem, on_grid, options)).operator(on_grid, friction=False)
    change = abs(
        float(np.max(on_grid.solve(nearer, Loading(load)).normal.p)) - float(np.max(solved[-1].normal.p))
    )
    *others, c = (_numbers(place, contact) for contact in solved)
    return SideContact((*others, replace(c, estimate_p_max=c.estimate_p_max + change)), grid, load, notes)


def _fitted(place: Place, bodies: dict[str, Body], wanted: Wanted) -> tuple[Grid, float, tuple[str, ...]]:
    """Return a grid, the load perpendicular to the axle [N], and sentences about what is left out."""
    load = float(wanted.load * np.cos(place.touch.angle - place.roll) / np.cos(place.touch.angle))
    grid, notes = _grid(place, bodies, wanted, load)
    return *_balanced(place, bodies, wanted, load, _refined(bodies, wanted, load, grid)), notes


def _solved(
    bodies: dict[str, Body], wanted: Wanted, load: float, grid: Grid, options: RunOptions
) -> list[SolvedContact]:
    """Return the contacts with all ICs on a grid."""
    contacts = solve_frictionless(problem_of(bodies, wanted, load, grid), options)
    return [contacts.contacts[loading, name] for loading in contacts.loadings for name in contacts.ics]


def _grid(place: Place, bodies: dict[str, Body], wanted: Wanted, load: float) -> tuple[Grid, tuple[str, ...]]:
    """Return a grid that covers all patches, and sentences about those that it had to leave out."""
    sizing, loading = sizing_of(problem_of(bodies, wanted, load)), Loading(load)
    size = contact_size(sizing.bodies, loading)
    grid = sizing.large_enough(sizing.grid([size]), [loading], [SIZING])
    approach = _solve_on(sizing.bodies, grid, loading).approach
    further = _beside(place, grid, approach)
    if not further:
        return grid, ()
    s = [edge - place.touch.s_rail for strip in further for edge in strip.s_rail]
    wider = sizing.grid([size, Size(size.x, (min(size.s[0], *s), max(size.s[1], *s)))])
    if wider.n_s <= MOST_STRIPS:
        return sizing.large_enough(wider, [loading], [SIZING]), ()
    return grid, tuple(_neglected(bodies, strip, approach, load) for strip in further)


def _solve_on(bodies: PairOnGrid, grid: Grid, loading: Loading) -> NormalContact:
    """Return the contact with the ICs that size grids."""
    on_grid = replace(bodies, grid=grid)
    return on_grid.solve(on_grid.operator(SIZING), loading).normal


def _refined(bodies: dict[str, Body], wanted: Wanted, load: float, grid: Grid) -> Grid:
    """Return a grid with enough elements across all patches that count, and for p_max; or the finest one."""
    sizing, loading = sizing_of(problem_of(bodies, wanted, load)), Loading(load)

    def solve(on_grid: PairOnGrid) -> SolvedContact:
        return SolvedContact(loading, SIZING, on_grid.solve(on_grid.operator(SIZING), loading))

    for _ in range(REFINEMENTS):
        contact = sizing.on_long_enough_grid(grid, solve)
        grid, (along_x, along_s) = contact.on_grid.grid, _factors(contact)
        finer = Grid(along_x * grid.n_x, along_s * grid.n_s, grid.dx / along_x, grid.ds / along_s, grid.s)
        if finer == grid or finer.n_x > MOST_ALONG_X or finer.n_s > MOST_STRIPS:
            break
        grid = finer
    return grid


def _factors(contact: SolvedContact) -> tuple[int, int]:
    """Return how many times as many elements along x and along s a contact needs: 1 or 2."""
    normal = contact.normal
    shares = [float(np.sum(normal.p[patch.elements]) / np.sum(normal.p)) for patch in normal.patches]
    counting = [patch for patch, share in zip(normal.patches, shares, strict=True) if share >= COUNTS]
    few_x = any(patch.x[1] - patch.x[0] < ACROSS for patch in counting)
    few_s = any(patch.s[1] - patch.s[0] < ACROSS for patch in counting)
    rough = contact.estimated_errors()["p_max"] > ACCURACY * float(np.max(normal.p))
    return 2 if few_x else 1, 2 if few_s or rough else 1


def _beside(place: Place, grid: Grid, approach: float) -> list[Strip]:
    """Return the strips at an approach [mm] that reach beyond a grid and hold a touching point there."""
    start, end = (place.touch.s_rail + edge for edge in grid.extent)
    candidates = strips(place.layout, place.position, place.side, approach)
    return [strip for strip in candidates if any(not start < touch.s_rail < end for touch in strip.touches)]


def _neglected(bodies: dict[str, Body], strip: Strip, approach: float, load: float) -> str:
    """Return a sentence about a patch that is not solved: where it is, and what it carries at most."""
    touch = max(strip.touches, key=lambda each: approach - each.gap)
    modulus = combined_modulus(bodies["upper"].material, bodies["lower"].material)
    depth = (approach - touch.gap) * np.cos(touch.angle)
    across = max(touch.curvature_rail - touch.curvature_wheel, 1e-4)
    point = PointContact(float(np.cos(touch.angle) / touch.radius), across, modulus).at_approach(float(depth))
    share = point.load * np.cos(touch.angle) / load
    return (
        f"a second patch at a contact angle of {np.degrees(touch.angle):.1f} degrees, {touch.gap:.4f} mm "
        "above its rail at first touch, is neglected: by Hertz, with the curvatures there, it carries "
        f"{100 * share:.2g} % of the load at most"
    )


def _balanced(
    place: Place, bodies: dict[str, Body], wanted: Wanted, load: float, grid: Grid
) -> tuple[Grid, float]:
    """Return a grid that fits all ICs, and the load perpendicular to the axle [N] that balances."""
    names = [name for name in wanted.ics if name != C] or [SIZING]
    sizing = sizing_of(problem_of(bodies, wanted, load))
    for _ in range(BALANCE_STEPS):
        grid = sizing.large_enough(grid, [Loading(load)], [*dict.fromkeys((*names, SIZING))])
        on_grid = replace(sizing.bodies, grid=grid)
        contact = on_grid.solve(on_grid.operator(SIZING), Loading(load)).normal
        vertical = _in_track(place, on_grid, contact)[1]
        if abs(vertical / wanted.load - 1) <= BALANCE:
            return grid, load
        load *= wanted.load / vertical
    raise Failure(
        f"load = {wanted.load:g} N: the vertical force does not settle ({vertical:.1f} N); "
        "take a smaller shift"
    )


def _in_track(place: Place, on_grid: PairOnGrid, contact: NormalContact) -> tuple[float, float]:
    """Return the lateral force on the wheel, to the field side, and the vertical one [N], in the track."""
    _, across, up = on_grid.resultant(contact.tractions).force
    cos, sin = np.cos(place.roll), np.sin(place.roll)
    return float(across * cos - up * sin), float(across * sin + up * cos)


def _numbers(place: Place, solved: SolvedContact) -> ICsNumbers:
    """Return the numbers of a contact."""
    on_grid, contact = solved.on_grid, solved.normal
    lateral, vertical = _in_track(place, on_grid, contact)
    patches = tuple(_patch(place, on_grid, contact, patch) for patch in contact.patches)
    main = max(patches, key=lambda patch: patch.share)
    return ICsNumbers(
        solved.ics,
        float(np.max(contact.p)),
        solved.estimated_errors()["p_max"],
        contact.approach,
        vertical,
        -lateral,
        angle(on_grid, contact),
        main.half_length,
        (main.s[1] - main.s[0]) / 2,
        solved.seconds,
        patches,
    )


def _patch(place: Place, on_grid: PairOnGrid, contact: NormalContact, patch: Extent) -> PatchNumbers:
    """Return the numbers of a patch; arc lengths are those of the rail's profile."""
    grid, p = on_grid.grid, np.where(patch.elements, contact.p, 0.0)
    vertical = contact.p * on_grid.cosine
    low, high = (place.touch.s_rail + grid.strips[0] + end * grid.ds for end in patch.s)
    return PatchNumbers(
        float(np.sum(p * on_grid.cosine) / np.sum(vertical)),
        (float(low), float(high)),
        (patch.x[1] - patch.x[0]) / 2 * grid.dx,
        float(np.max(p)),
        _outline(place, grid, p, (float(low), float(high))),
    )


def _outline(place: Place, grid: Grid, p: Array, ends: tuple[float, float]) -> Array:
    """Return arc lengths of the rail and half-lengths [mm], (2, n), of strips of a patch, and of its ends.

    On a strip the squared pressure falls to 0 nearly linearly in x^2.
    """
    strips_in = np.flatnonzero(p.any(axis=0))
    x = np.asarray(grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2))
    half = [_half_length(x, p[:, strip], grid.dx) for strip in strips_in]
    s = place.touch.s_rail + grid.strips[strips_in]
    return np.array([[ends[0], *s, ends[1]], [0.0, *half, 0.0]])


def _half_length(x: Array, p: Array, dx: float) -> float:
    """Return the half-length [mm] of a strip in contact."""
    inside = np.flatnonzero((p > 0) & (x >= 0))
    if len(inside) < 4:
        return float(np.count_nonzero(p > 0) * dx / 2)
    second, third = inside[-2], inside[-4]
    slope = (p[second] ** 2 - p[third] ** 2) / (x[second] ** 2 - x[third] ** 2)
    last = float(x[inside[-1]])
    edge = np.sqrt(max(x[second] ** 2 - p[second] ** 2 / slope, 0.0)) if slope < 0 else last + dx / 2
    return float(np.clip(edge, last, last + dx))
