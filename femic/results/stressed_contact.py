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
from femic.contact.motions.compression import in_steps
from femic.contact.motions.none import solve_frictionless
from femic.contact.motions.rolling import Continuation, displaced
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.ics import GivenICs
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import (
    PairWithFriction,
    if_possible,
    on_larger_elements,
    with_perturbed_ics,
)
from femic.contact.rolling import RollingContact
from femic.contact.specification import ContactProblem, ContactSpecification
from femic.damage.estimates import RollingSolution
from femic.damage.worn import REACH, strips_beside
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
class EstimatedRolling:
    """A contact in steady rolling, and others of the same for its estimates; None: there is no such contact.

    `larger` are those on elements twice and four times as large; `changed` that with the distance of the
    displaced bodies, and that with ICs plus their estimated errors where errors of ICs are known.
    """

    own: RollingSolution
    larger: tuple[RollingSolution | None, ...] = ()
    changed: tuple[RollingSolution | None, ...] = ()


@dataclass(frozen=True, eq=False)
class Contacts:
    """Tractions [MPa] on the upper body of a contact with ICs by name, (n_x, n_s, 3) each, on one grid.

    `rolling` has the contacts in steady rolling, by ICs; of other motions it is empty. `load` is in words.
    """

    problem: ContactProblem
    on_grid: PairOnGrid
    tractions: Mapping[str, Array]
    rolling: Mapping[str, EstimatedRolling]
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
            f"{scene.name}: contact.ics: {maps[0]}: maps of C give pressures only; use C, or --ics A,Bhat,C"
        )
    require_none(scene.name, body_limit_misfits(scene))
    require_solvable(with_one_contact(scene))
    if scene.damage.wears and scene.damage.spread > 0:
        _require_room(scene)


def _require_room(scene: Scene) -> None:
    """Raise BadScene where the grid has no strips left for a contact beside those that spread wear needs."""
    ((grid, _),) = grids_of(with_one_contact(scene).contact_problem)
    most = (grid.n_s - 1) / 2
    if strips_beside(scene.damage.spread, grid.ds) > most:
        raise BadScene(
            f"{scene.name}: damage.spread = {scene.damage.spread:g} mm: wear is averaged over {REACH:g} "
            f"times that beside the contact, and its grid has {grid.n_s} strips of {grid.ds:.3g} mm: give "
            f"less than {most * grid.ds / REACH:.2g} mm, or contact.grid = 'scene' and a longer [grid]"
        )


def with_one_contact(scene: Scene) -> Scene:
    """Return a scene whose contact is the one whose stresses are computed."""
    return replace(scene, contact=_one_contact(scene))


def solve_contacts(scene: Scene, options: RunOptions, given: Mapping[str, GivenICs]) -> Contacts:
    """Solve the one contact of a scene, as of `with_one_contact`, with each of its ICs.

    `given` are ICs of the caller by name. Raises as `femic contact`.
    """
    problem = with_one_contact(scene).contact_problem
    if problem.specification.friction is None:
        return _frictionless(problem, options, given)

    def solve(pair: PairWithFriction) -> Contacts:
        if problem.specification.motion == "rolling":
            return _rolling(pair)
        return _compress(pair)

    return solve_with_friction(problem, solve, options, given)


def _one_contact(scene: Scene) -> ContactSpecification:
    """Return the specification of one contact: of the largest load; or of the friction and force of a scene.

    Where [stresses] has none, these are the largest coefficient of friction, and `equal_force`.
    """
    specification, friction, force = scene.contact, scene.stresses.friction, scene.stresses.force
    if (of_contact := specification.friction) is not None:
        one = replace(
            of_contact,
            coefficients=(friction or max(of_contact.coefficients),),
            equal_force=of_contact.equal_force if force is None else force,
        )
        return replace(specification, friction=one)
    if specification.loads:
        return replace(specification, loads=(max(specification.loads),), approaches=())
    return replace(specification, approaches=tuple(sorted(specification.approaches)[-1:]))


def _frictionless(problem: ContactProblem, options: RunOptions, given: Mapping[str, GivenICs]) -> Contacts:
    solved = solve_frictionless(problem, options, given)
    (loading,) = solved.loadings
    contacts = {name: solved.contacts[loading, name] for name in solved.ics}
    tractions = {name: one.normal.tractions for name, one in contacts.items()}
    on_grid = contacts[reference_name(solved.ics)].on_grid
    return Contacts(problem, on_grid, tractions, {}, str(loading))


def _rolling(pair: PairWithFriction) -> Contacts:
    solved = {name: _roll(pair, name) for name in pair.problem.specification.ics}
    tractions = {name: one.own.contact.p for name, one in solved.items()}
    return Contacts(pair.problem, pair.on_grid, tractions, solved, f"{pair.loads[0]:g} N")


def _roll(pair: PairWithFriction, name: str) -> EstimatedRolling:
    """Return the contact at the prescribed longitudinal force."""
    friction = pair.specification.coefficients[0]
    problem, label = pair.frictional(pair.operator(name), friction), f"friction {friction:g}, {name}"
    own = _with_force(pair, problem, label)
    pair.options.watch.on_stage(f"  {label}: xi = {own.rolling.creepages.longitudinal:.3g}")
    larger = on_larger_elements(pair, problem, label, _with_force)
    changed: list[Callable[[], RollingSolution | None]] = [partial(_displace, pair, own, label)]
    if pair.perturbed(name) is not None:
        changed += [partial(with_perturbed_ics, pair, friction, name, label, _with_force)]
    in_estimates = partial(if_possible, pair, "not in estimates")
    return EstimatedRolling(own, tuple(larger), tuple(map(in_estimates, changed)))


def _with_force(pair: PairWithFriction, problem: FrictionalProblem, label: str) -> RollingSolution:
    """Return the contact of a problem at the prescribed longitudinal force, and the slope of its curve."""
    along = Continuation(pair, pair.rolling(problem), label)
    share = pair.specification.equal_force
    rolling = along.with_force(share * along.largest, [along.first()])
    return RollingSolution(along.problem, rolling, pair.loads[0], _slope(along, share, rolling))


def _displace(pair: PairWithFriction, own: RollingSolution, label: str) -> RollingSolution:
    """Return a contact with the distance of the displaced bodies, under the same longitudinal force."""
    along = Continuation(pair, own.problem, f"{label}, exact distance")
    force = pair.specification.equal_force * along.largest
    return replace(own, rolling=displaced(along, own.rolling, force))


def _slope(along: Continuation, share: float, rolling: RollingContact) -> float:
    """Return dF_x/dxi [N] of the creep-force curve from a contact to one of less force; nan without this."""
    less = share - np.copysign(STEP, share)
    solve = partial(along.with_force, less * along.largest, [rolling])
    beside = if_possible(along.pair, "no slope of the creep-force curve", solve)
    if beside is None:
        return np.nan
    rise = rolling.creepages.longitudinal - beside.creepages.longitudinal
    return float((share - less) * along.largest / rise)


def _compress(pair: PairWithFriction) -> Contacts:
    friction, tractions = pair.specification.coefficients[0], {}
    for name in pair.problem.specification.ics:
        problem = pair.frictional(pair.operator(name), friction)
        tractions[name] = in_steps(pair, problem, f"friction {friction:g}, {name}")[1].p
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
    half_length, (low, high) = _patch(contacts)
    half_width, middle = (high - low) / 2, (low + high) / 2
    first, last = contacts.problem.extent
    offset, of_body = contacts.offset(body), contacts.problem.bodies[body]
    low = max(first, middle - WIDER * half_width, of_body.s_range[0] - offset)
    high = min(last, middle + WIDER * half_width, of_body.s_range[1] - offset)
    before = ALONG_S // 2
    s = np.concatenate(
        [np.linspace(low, middle, before + 1), np.linspace(middle, high, ALONG_S - before)[1:]]
    )
    x = LONGER * half_length * np.linspace(-1, 1, ALONG_X)
    wanted = DEEPER * min(half_width, half_length)
    deepest = _deepest(of_body, s + offset, wanted)
    below = _deepest(of_body, s[[before]] + offset, wanted)
    deeper = np.linspace(deepest, below, DEEPER_STILL + 1)[1:] if below > deepest else np.zeros(0)
    return Lattice(x, s, deepest * np.linspace(0, 1, INTO_DEPTH) ** GRADING, deeper, before, offset)


def _patch(contacts: Contacts) -> tuple[float, tuple[float, float]]:
    """Half-length about x = 0 and ends along s of the contacts with all ICs [mm]."""
    pressed = np.any([p[..., N] > 0 for p in contacts.tractions.values()], axis=0)
    x, s, grid = contacts.on_grid.x, contacts.grid.strips, contacts.grid
    half_length = float(np.max(np.abs(x[pressed.any(axis=1)]))) + grid.dx / 2
    strips = s[pressed.any(axis=0)]
    return half_length, (float(strips[0]) - grid.ds / 2, float(strips[-1]) + grid.ds / 2)


def _deepest(body: Body, s: Array, depth: float) -> float:
    """The largest depth [mm] up to `depth` at which points below s are inside the body, and in their order.

    Below a convex contour normals meet in the centre of curvature, and cross beyond it.
    """
    for _ in range(MOST_SHRINKINGS):
        try:
            points = InnerPoints(np.zeros_like(s), s, np.full_like(s, depth))
            require_inside(body, points)
        except WrongInput:
            depth *= SHRINKING
            continue
        if np.all(_spread(body, points) >= LEAST_SPREAD):
            return depth
        depth *= SHRINKING
    raise Failure("the body is too thin below the contact for stresses inside it")


def _spread(body: Body, points: InnerPoints) -> Array:
    """Distances of neighbours along s over those at the surface, (n - 1,); negative where normals cross."""
    middle = (points.s[1:] + points.s[:-1]) / 2
    n_y, n_z = body.contour.normal(middle)
    along = np.diff(points.in_section(body), axis=1)  # (2, n - 1)
    return np.asarray((along[0] * n_z - along[1] * n_y) / np.diff(points.s))
