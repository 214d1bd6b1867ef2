"""The one contact of a scene whose stresses are computed, with each of its ICs, and the points below it.

Without friction it is that of the largest load, in rolling that at the prescribed force and one coefficient
of friction, in compression that after the last load. The points are a lattice in x, s and depth, and a column
that goes deeper.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.motions import solve_with_friction
from femic.contact.motions.compression import solve_steps
from femic.contact.motions.none import solve_frictionless
from femic.contact.motions.rolling import Continuation, displaced
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import (
    PairWithFriction,
    if_possible,
    on_larger_elements,
    with_perturbed_ics,
)
from femic.contact.specification import ContactProblem
from femic.damage.estimates import RollingSolution
from femic.damage.wear import REACH, strips_beside
from femic.reference.run_options import RunOptions
from femic.results.contact import map_names, reference_name, require_solvable
from femic.scenes.engine import body_limit_misfits
from femic.scenes.errors import BadScene, require_none
from femic.scenes.scene import Scene
from femic.stresses.points import InnerPoints, SurfaceTractions, require_inside
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid, N

# --- the contact ----------------------------------------------------------------------------------------


MOTIONS = "none", "rolling", "compression"
STEP = 0.02  # of friction times load, over which the slope of a creep-force curve is taken


@dataclass(frozen=True, eq=False)
class Contacts:
    """Tractions [MPa] on the upper body of a contact with ICs by name, (n_x, n_s, 3) each, on one grid.

    `rolling` has the contacts in steady rolling, by ICs; of other motions it is empty. `load` is in words.
    """

    problem: ContactProblem
    on_grid: PairOnGrid
    tractions: Mapping[str, Array]
    rolling: Mapping[str, RollingSolution]
    load: str

    @property
    def reference(self) -> str:
        """The ICs whose tractions load the bodies."""
        return reference_name(list(self.tractions))

    @property
    def grid(self) -> Grid:
        """The grid on the lower contour."""
        return self.on_grid.grid

    @property
    def friction(self) -> float:
        """The coefficient of friction, 0 without."""
        friction = self.problem.specification.friction
        return friction.coefficients[0] if friction else 0.0

    @property
    def upper_offset(self) -> float:
        """Arc lengths [mm] of the upper contour less those of the lower one opposite."""
        return self.on_grid.undeformed.upper_offset

    def offset(self, body: str) -> float:
        """Arc lengths [mm] of the contour of a body less those of the lower one opposite."""
        return self.upper_offset if body == "upper" else 0.0

    def on_body(self, body: str, ics: str) -> SurfaceTractions:
        """Return the tractions with some ICs on the strips of a body's own contour."""
        own = replace(self.grid, s=self.grid.s + self.offset(body))
        return SurfaceTractions(own, self.tractions[ics])

    def p_max(self, ics: str) -> float:
        """Return the largest pressure [MPa]."""
        return float(np.max(self.tractions[ics][..., N]))


def require_stresses(scene: Scene) -> None:
    """Raise BadScene where a scene has no contact whose stresses are computed, before any work."""
    motion = scene.contact.motion
    if motion not in MOTIONS:
        raise BadScene(
            f"{scene.name}: contact.motion = {motion!r}: stresses are those of one contact; use one of "
            f"{', '.join(MOTIONS)} (a transient ends as steady rolling)"
        )
    if maps := map_names(scene.contact.ics):
        raise BadScene(
            f"{scene.name}: contact.ics: {maps[0]}: maps of C only give pressures; use C, or --ics A,Bhat,C"
        )
    require_none(scene.name, body_limit_misfits(scene))
    one = with_one_contact(scene)
    require_solvable(one)
    spread = scene.damage.spread
    if scene.damage.wears and spread > 0:
        ((grid, _),) = grids_of(one.contact_problem)
        most = (grid.n_s - 1) / 2  # strips beside a contact of one strip
        if strips_beside(spread, grid.ds) > most:
            raise BadScene(
                f"{scene.name}: damage.spread = {spread:g} mm: wear is averaged over {REACH:g} times that "
                f"beside the contact, and its grid has {grid.n_s} strips of {grid.ds:.3g} mm: give less than "
                f"{most * grid.ds / REACH:.2g} mm, or contact.grid = 'scene' and a longer [grid]"
            )


def with_one_contact(scene: Scene) -> Scene:
    """Return a scene whose contact is the one whose stresses are computed.

    Without friction it is that of the largest load or else approach; with friction that of the friction and
    force of [stresses], or else the largest coefficient of friction, and `equal_force`.
    """
    specification, friction, force = scene.contact, scene.stresses.friction, scene.stresses.force
    if (given := specification.friction) is not None:
        one = replace(
            given,
            coefficients=(friction or max(given.coefficients),),
            equal_force=given.equal_force if force is None else force,
        )
        return replace(scene, contact=replace(specification, friction=one))
    if specification.loads:
        return replace(
            scene, contact=replace(specification, loads=(max(specification.loads),), approaches=())
        )
    return replace(
        scene, contact=replace(specification, approaches=tuple(sorted(specification.approaches)[-1:]))
    )


def solve_contacts(scene: Scene, options: RunOptions) -> Contacts:
    """Solve the one contact of a scene, as of `with_one_contact`, with each of its ICs.

    Raises as `femic contact`.
    """
    problem = with_one_contact(scene).contact_problem
    if problem.specification.friction is not None:
        is_rolling = problem.specification.motion == "rolling"
        return solve_with_friction(problem, _roll if is_rolling else _compress, options)
    solved = solve_frictionless(problem, options)
    (loading,) = solved.loadings
    contacts = {name: solved.contacts[loading, name] for name in solved.ics}
    tractions = {name: one.normal.tractions for name, one in contacts.items()}
    on_grid = contacts[reference_name(solved.ics)].on_grid
    return Contacts(problem, on_grid, tractions, {}, str(loading))


def _roll(pair: PairWithFriction) -> Contacts:
    """Return the contacts at the prescribed longitudinal force, with those that their estimates need."""
    (friction,), rolling = pair.specification.coefficients, {}
    for name in pair.problem.specification.ics:
        problem, label = pair.frictional(pair.operator(name), friction), f"friction {friction:g}, {name}"
        own = _with_force(pair, problem, label)
        pair.options.watch.on_stage(f"  {label}: xi = {own.rolling.creepages.longitudinal:.3g}")
        larger = on_larger_elements(pair, problem, label, _with_force)
        others: list[Callable[[], RollingSolution | None]] = [partial(_displace, pair, own, label)]
        if pair.perturbed(name) is not None:
            others += [partial(with_perturbed_ics, pair, friction, name, label, _with_force)]
        changed = [if_possible(pair, "not in estimates", other) for other in others]
        rolling[name] = replace(own, larger=tuple(larger), changed=tuple(changed))
    tractions = {name: solution.contact.p for name, solution in rolling.items()}
    return Contacts(pair.problem, pair.on_grid, tractions, rolling, f"{pair.loads[0]:g} N")


def _with_force(pair: PairWithFriction, problem: FrictionalProblem, label: str) -> RollingSolution:
    """Return the contact of a problem at the prescribed longitudinal force, and the slope of its curve.

    The slope dF_x/dxi [N] is that to a contact of less force; nan without this.
    """
    along = Continuation(pair, pair.rolling(problem), label)
    share = pair.specification.equal_force
    rolling = along.with_force(share * along.largest, [along.first()])
    less, slope = share - np.copysign(STEP, share), np.nan
    solve = partial(along.with_force, less * along.largest, [rolling])
    beside = if_possible(pair, "no slope of the creep-force curve", solve)
    if beside is not None:
        rise = rolling.creepages.longitudinal - beside.creepages.longitudinal
        slope = float((share - less) * along.largest / rise)
    return RollingSolution(along.problem, rolling, pair.loads[0], slope)


def _displace(pair: PairWithFriction, own: RollingSolution, label: str) -> RollingSolution:
    """Return a contact with the distance of the displaced bodies, under the same longitudinal force."""
    along = Continuation(pair, own.problem, f"{label}, exact distance")
    force = pair.specification.equal_force * along.largest
    return replace(own, rolling=displaced(along, own.rolling, force))


def _compress(pair: PairWithFriction) -> Contacts:
    (friction,), tractions = pair.specification.coefficients, {}
    for name in pair.problem.specification.ics:
        problem = pair.frictional(pair.operator(name), friction)
        tractions[name] = solve_steps(pair, problem, f"friction {friction:g}, {name}")[1].p
        pair.options.watch.on_stage(f"  friction {friction:g}, {name}: {pair.loads[-1]:g} N")
    return Contacts(pair.problem, pair.on_grid, tractions, {}, f"{pair.loads[-1]:g} N")


# --- the lattice ----------------------------------------------------------------------------------------


ALONG_X, ALONG_S, INTO_DEPTH, DEEPER_STILL = 17, 25, 13, 12  # points
WIDER, LONGER, DEEPER = 1.5, 1.3, 2.0  # over the width, the length and the half-width of the patch
GRADING = 1.5  # power of depths: closer together near the surface
SHRINKING, MOST_SHRINKINGS = 0.9, 40  # of the depth, until all normals stay inside the body and apart
LEAST_SPREAD = 0.25  # of the distance between normals at the surface: deeper they cross


@dataclass(frozen=True, eq=False)
class Lattice:
    """Points at x (n_x,), arc lengths s (n_s,) of the lower contour, and depths (n_d,) in a body [mm].

    The column below the middle of the patch, s[middle], goes on to the depths `deeper` (n_c,), which may be
    none. `offset` [mm] is added to s on the body's own contour.
    """

    x: Array
    s: Array
    depth: Array
    deeper: Array
    middle: int
    offset: float

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of x, s and depths."""
        return len(self.x), len(self.s), len(self.depth)

    @property
    def column(self) -> Array:
        """Depths [mm] below the middle of the patch, (n_d + n_c,)."""
        return np.concatenate([self.depth, self.deeper])

    @property
    def points(self) -> InnerPoints:
        """All points on the body's own contour, in one row: the lattice, then what is deeper."""
        on_lattice = InnerPoints(self.x[:, None, None], self.s[:, None], self.depth).flat
        below = InnerPoints(self.x[:, None], np.asarray(self.s[self.middle]), self.deeper).flat
        x, s, depth = (
            np.concatenate([getattr(part, name) for part in (on_lattice, below)])
            for name in ("x", "s", "depth")
        )
        return InnerPoints(x, s + self.offset, depth)

    def split(self, values: Array) -> tuple[Array, Array]:
        """Return values (n, ...) at all points on the lattice, (n_x, n_s, n_d, ...), and on the column.

        The column has shape (n_x, n_d + n_c, ...).
        """
        count, rest = int(np.prod(self.shape)), values.shape[1:]
        on_lattice = values[:count].reshape(*self.shape, *rest)
        below = values[count:].reshape(len(self.x), len(self.deeper), *rest)
        return on_lattice, np.concatenate([on_lattice[:, self.middle], below], axis=1)


def lattice_below(contacts: Contacts, body: str) -> Lattice:
    """Return the lattice below the contacts with all ICs in a body.

    s goes over 1.5 widths of the patch, as far as both contours go, and has its middle; x over 1.3 lengths,
    and has 0; depths go to two half-widths, or where that is less as far as normals stay inside the body and
    apart. Below the middle alone they go on to two half-widths, if that is inside the body.
    """
    pressed = np.any([p[..., N] > 0 for p in contacts.tractions.values()], axis=0)
    along, grid = contacts.on_grid.x, contacts.grid
    half_length = float(np.max(np.abs(along[pressed.any(axis=1)]))) + grid.dx / 2
    strips = grid.strips[pressed.any(axis=0)]
    low, high = float(strips[0]) - grid.ds / 2, float(strips[-1]) + grid.ds / 2
    half_width, middle = (high - low) / 2, (low + high) / 2
    first, last = contacts.problem.extent
    offset, solid = contacts.offset(body), contacts.problem.bodies[body]
    low = max(first, middle - WIDER * half_width, solid.s_range[0] - offset)
    high = min(last, middle + WIDER * half_width, solid.s_range[1] - offset)
    before = ALONG_S // 2
    s = np.concatenate(
        [np.linspace(low, middle, before + 1), np.linspace(middle, high, ALONG_S - before)[1:]]
    )
    x = LONGER * half_length * np.linspace(-1, 1, ALONG_X)
    wanted = DEEPER * min(half_width, half_length)
    deepest = _deepest(solid, s + offset, wanted)
    below = _deepest(solid, s[[before]] + offset, wanted)
    deeper = np.linspace(deepest, below, DEEPER_STILL + 1)[1:] if below > deepest else np.zeros(0)
    return Lattice(x, s, deepest * np.linspace(0, 1, INTO_DEPTH) ** GRADING, deeper, before, offset)


def _deepest(body: Body, s: Array, depth: float) -> float:
    """Return the largest depth [mm] up to `depth` at which points below s are in the body and in their order.

    Below a convex contour normals meet in the centre of curvature, and cross beyond it: the distances of
    neighbours along s, over those at the surface, tell.
    """
    for _ in range(MOST_SHRINKINGS):
        points = InnerPoints(np.zeros_like(s), s, np.full_like(s, depth))
        try:
            require_inside(body, points)
        except WrongInput:
            depth *= SHRINKING
            continue
        n_y, n_z = body.contour.normal((s[1:] + s[:-1]) / 2)
        along = np.diff(points.in_section(body), axis=1)  # (2, n - 1)
        if np.all((along[0] * n_z - along[1] * n_y) / np.diff(s) >= LEAST_SPREAD):
            return depth
        depth *= SHRINKING
    raise Failure("the body is too thin below the contact to compute stresses inside it")
