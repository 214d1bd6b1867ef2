"""Steady rolling: a creep-force curve, and tractions at the force at which ICs are compared.

Contacts are solved from one creepage to the next, and at prescribed forces. The distance of the bodies is
linearised in the approach; what that does to the numbers is known from a few contacts with the distance of
the displaced body (`displaced`) and from contact without friction (`Linearisation`). Before a curve is
solved, `forces_beyond_creepages` tells whether its creepages reach the force at which ICs are compared, as
far as that can be known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
import scipy

from femic.contact.estimates import Measured, Numbers, Scale, changes, errors
from femic.contact.friction.motion import Creepages, largest_factor
from femic.contact.loading import Loading
from femic.contact.motions import motion
from femic.contact.motions.motion import COMMON, WITH_FRICTION, Motion, Want
from femic.contact.pairs.quantities import kinds, measured, select
from femic.contact.specification import CREEPAGES, ContactProblem, ContactSpecification
from femic.lazy import lazy_imports
from geometries.errors import Failure

with lazy_imports():
    import xarray as xr

    from femic.contact import datasets, frictional_problem, normal
    from femic.contact import rolling as solver
    from femic.contact.exact import creepage_coefficients as kalker
    from femic.contact.operators import protocols
    from femic.contact.pairs import grids, ics, pair_on_grid
    from femic.contact.pairs import pair_with_friction as pairs

OF_ROLLING = select(
    *("F_x", "dissipation", "F_y", "M_x", "M_z", "approach", "p_max", "a", "b", "angle", "area"),
    "sliding_share",
)
OF_CURVE = select("zero_creepage", "slope", "equal_creepage")  # of a curve, besides its points
OF_DISPLACED = select(*OF_ROLLING, "zero_creepage", "xi")
EDGE_SHARE = 0.015  # part of the work on elements at the edge
FORCES = {"longitudinal": "F_x", "lateral": "F_y", "spin": "M_z"}  # that creepages bring about


def measured_rolling(
    on_grid: pair_on_grid.PairOnGrid, problem: solver.RollingProblem, rolling: solver.RollingContact
) -> Measured:
    """Return the numbers of `OF_ROLLING`; the floor of work is that which the slip misses, and of the edge.

    Where little of a contact slides, grids miss much of the slip, and changes from grid to grid do not show
    that. Forces that creepages follow from are exact.
    """
    prescribed = [FORCES[name] for name in rolling.prescribed]
    known = measured(on_grid, rolling.contact, OF_ROLLING, prescribed)
    largest = known.scales["work"].changes
    if largest == 0.0:
        return known
    at_edge = float(np.sum(rolling.contact.dissipation[rolling.contact.slip_state.at_edge]))
    missed = problem.missed_work(rolling) + EDGE_SHARE * at_edge * problem.problem.grid.area
    return replace(known, floors={**known.floors, "work": missed / largest})


# --- contacts along a curve ---

MOST_HALVINGS = 2  # of a step of creepage that fails
ACCURACY = 1e-9  # of creepages that are searched for
AROUND_ZERO = 0.02  # forces over friction times load between which the slope at no force is taken


@dataclass(frozen=True, eq=False)
class CreepForceCurve:
    """A creep-force curve on one grid: contacts by creepage, and at certain forces."""

    contacts: Mapping[float, solver.RollingContact]
    points: Mapping[float, Measured]  # by creepage, as contacts
    free: Measured  # the numbers of `OF_CURVE`
    equal: solver.RollingContact  # with the force at which ICs are compared


@dataclass(frozen=True, eq=False)
class Continuation:
    """Continuation along a creep-force curve, outward from the creepage nearest 0."""

    pair: pairs.PairWithFriction
    problem: solver.RollingProblem
    label: str

    @property
    def xi(self) -> tuple[float, ...]:
        """The creepages, growing."""
        return self.pair.specification.longitudinal

    @property
    def largest(self) -> float:
        """Friction times load [N]."""
        return self.problem.problem.friction * self.pair.loads[0]

    def curve(self) -> CreepForceCurve:
        """Return the contacts at all creepages, each from its neighbour, and at prescribed forces.

        Creepages at which there is no solution are left out. Raises Failure where there is none at all.
        """
        first = self.first()
        by_creepage = {first.creepages.longitudinal: first}
        number = self.xi.index(first.creepages.longitudinal)
        for side in (self.xi[number + 1 :], self.xi[:number][::-1]):
            before = first
            for xi in side:
                if contact := self.at_if_possible(xi, before):
                    before = by_creepage[xi] = contact
        contacts = {xi: by_creepage[xi] for xi in sorted(by_creepage)}
        free, equal = self.free(list(contacts.values()))
        points = {xi: self.measured(contact) for xi, contact in contacts.items()}
        return CreepForceCurve(contacts, points, free, equal)

    def free(self, contacts: Sequence[solver.RollingContact]) -> tuple[Measured, solver.RollingContact]:
        """Return the numbers of `OF_CURVE` from `contacts`, and the contact at which ICs are compared."""
        zero, below, above, equal = (
            self.with_force(share * self.largest, contacts)
            for share in (0.0, -AROUND_ZERO, AROUND_ZERO, self.pair.specification.equal_force)
        )
        rise = float(above.creepages.longitudinal - below.creepages.longitudinal)
        slope = 2 * AROUND_ZERO * self.largest / rise
        numbers = {
            "zero_creepage": float(zero.creepages.longitudinal),
            "slope": slope,
            "equal_creepage": float(equal.creepages.longitudinal),
        }
        saturated = abs(self.largest / slope)  # the creepage at which the slope reaches friction times load
        scales = {"creepage": Scale(saturated, saturated)}
        return Measured(numbers, scales, self.measured(zero).floors), equal

    def first(self) -> solver.RollingContact:
        """Return the contact at the creepage nearest 0 that has a solution without a neighbour's."""
        for xi in sorted(self.xi, key=abs):
            if contact := self.at_if_possible(xi, None):
                return contact
        raise Failure(f"{self.label}: no contact solved at any creepage; use smaller or larger elements")

    def at_if_possible(self, xi: float, before: solver.RollingContact | None) -> solver.RollingContact | None:
        """Return the contact at a creepage; None where it has no solution, which is reported."""
        return pairs.if_possible(self.pair, "left out", lambda: self.at(xi, before))

    def with_force(self, force: float, contacts: Sequence[solver.RollingContact]) -> solver.RollingContact:
        """Return the contact with a longitudinal force [N], from where the curve of `contacts` has it.

        Where it is not found there, it is searched for over all creepages. Raises Failure where none has it.
        """
        forces = [contact.contact.force[0] for contact in contacts]
        xi = [contact.creepages.longitudinal for contact in contacts]
        nearest = contacts[int(np.argmin(np.abs(np.array(forces) - force)))]
        start = self.at(float(np.interp(force, forces, xi)), nearest)
        try:
            return self.solve(start.creepages.longitudinal, start, force)
        except Failure:
            by_creepage = {start.creepages.longitudinal: start}

        def beyond(xi: float) -> float:
            nearest = by_creepage[min(by_creepage, key=lambda other: abs(other - xi))]
            by_creepage[xi] = self.at(xi, nearest)
            return float(by_creepage[xi].contact.force[0]) - force

        if beyond(self.xi[0]) * beyond(self.xi[-1]) > 0:
            raise Failure(
                f"{self.label}: F_x = {force:g} N lies beyond the curve; give a wider range of creepages"
            )
        return by_creepage[float(scipy.optimize.brentq(beyond, self.xi[0], self.xi[-1], xtol=ACCURACY))]

    def at(
        self, xi: float, before: solver.RollingContact | None, halvings: int = MOST_HALVINGS
    ) -> solver.RollingContact:
        """Return the contact at a creepage, from a neighbour; where that fails, in two steps of this kind."""
        try:
            return self.solve(xi, before)
        except normal.PotentialAreaTooSmall:
            raise
        except Failure as failure:
            if before is None or halvings == 0:
                raise Failure(f"{self.label}, xi = {xi:g}: {failure}") from failure
            half_way = self.at((xi + before.creepages.longitudinal) / 2, before, halvings - 1)
            return self.at(xi, half_way, halvings - 1)

    def solve(
        self, xi: float, before: solver.RollingContact | None, force: float | None = None
    ) -> solver.RollingContact:
        """Return the contact at a creepage, or with a longitudinal force [N] near it."""
        specification = self.pair.specification
        return self.problem.contact(
            Creepages(xi, specification.lateral, specification.spin),
            Loading(self.pair.loads[0]),
            forces={} if force is None else {"longitudinal": force},
            start=None if before is None else before.contact,
        )

    def measured(self, rolling: solver.RollingContact) -> Measured:
        """Return the numbers of a contact, with what estimates need."""
        return measured_rolling(self.pair.on_grid, self.problem, rolling)


def solve_nearest_to_no_creepage(
    pair: pairs.PairWithFriction, problem: frictional_problem.FrictionalProblem, label: str
) -> tuple[float, Numbers]:
    """Return the creepage nearest 0 and the numbers there; raises Failure where there is no such contact."""
    along = Continuation(pair, pair.rolling(problem), label)
    xi = min(along.xi, key=abs)
    return xi, along.measured(along.at(xi, None)).numbers


# --- distance of the displaced body ---

STEPS = 10  # largest number of contacts
TOLERANCE = 1e-4  # of the approach: of a change of the distance that is itself small


def displaced_numbers(along: Continuation, curve: CreepForceCurve) -> Mapping[str, float]:
    """Return the numbers of `OF_DISPLACED` at the creepage nearest 0; NaN where the grid has no such contact.

    They are NaN, too, where one of both contacts is found in a less accurate form than the other: that would
    change more than the distance does. The creepage without force is moved by the change of the force over
    the slope.
    """
    try:
        linear = along.at(min(along.xi, key=abs), curve.equal)
        exact = displaced(along, linear)
    except Failure:  # the patch is larger than the grid, or not found: the curve itself stands
        return dict.fromkeys(OF_DISPLACED, np.nan)
    if exact.contact.motion.depth != linear.contact.motion.depth:
        return dict.fromkeys(OF_DISPLACED, np.nan)
    change = float(exact.contact.force[0] - linear.contact.force[0])
    moved = curve.free.numbers["zero_creepage"] - change / curve.free.numbers["slope"]
    numbers = along.measured(exact).numbers
    return {**numbers, "zero_creepage": moved, "xi": exact.creepages.longitudinal}


def displaced(
    along: Continuation, contact: solver.RollingContact, force: float | None = None
) -> solver.RollingContact:
    """Return the contact with the distance at its own approach: a fixed point.

    It is at the same creepages, or under the same longitudinal `force` [N].
    Heights of rolling circles stay those of the linearised contact: the displacements of the same size that
    they lack along s are not known from the approach, and would make slip depend on the rigid-body discount.
    """
    on_grid, rolling = along.pair.on_grid, along.problem
    for _ in range(STEPS):
        approach = contact.contact.approach
        distance = on_grid.distance_at(approach) + approach * on_grid.cosine
        problem = replace(rolling, problem=replace(rolling.problem, distance=distance))
        contact = replace(along, problem=problem).solve(contact.creepages.longitudinal, contact, force)
        if abs(contact.contact.approach - approach) <= TOLERANCE * abs(approach):
            return contact
    raise Failure(f"{along.label}: the approach with the exact distance does not converge")


# --- a curve with some ICs ---


def solve_curve(pair: pairs.PairWithFriction, friction: float, name: str) -> xr.Dataset:
    """Return the creep-force curve with the ICs of a name: numbers by creepage `xi`, maps at equal force.

    Each number has `estimate_NAME`, and `larger_NAME`, `change_NAME` and `floor_NAME` as in
    `femic.contact.datasets`. `simplified` marks contacts with the less accurate solution only.
    `displaced_NAME` is a number at the creepage nearest 0 with the distance of the displaced wheel, which is
    linearised otherwise. Raises Failure where no contact is found at any creepage, or where the curve does
    not reach the force at which ICs are compared.
    """
    operator, start = pair.operator(name), perf_counter()  # C has its own seconds
    label, problem = f"friction {friction:g}, {name}", pair.frictional(operator, friction)
    along = Continuation(pair, pair.rolling(problem), label)
    xis, curve = along.xi, along.curve()
    seconds = perf_counter() - start
    pair.options.watch.on_stage(f"  {label}: {len(curve.points)} of {len(xis)} creepages, {seconds:.1f} s")

    changed = _with_ics(along, curve, pair.perturbed(name))
    larger = pairs.on_larger_elements(pair, problem, label, _curve)
    moved = displaced_numbers(along, curve)
    estimates, free_estimates = _estimates(along, curve, larger, changed, moved)

    changed_points, changed_free, changed_equal = changed
    rows = {
        xi: pairs.differences(curve.points[xi].numbers, numbers) for xi, numbers in changed_points.items()
    }
    p, coarse = curve.equal.contact.p, larger[0] if larger else None
    by_creepage = {
        "": _points(curve, xis),
        "estimate_": estimates,
        datasets.LARGER: _points(coarse, xis),
        datasets.CHANGE: [between(rows, xi) for xi in xis],
        **datasets.difference_errors_of_all((curve.points.get(xi) for xi in xis), OF_ROLLING),
    }
    free = {
        "": curve.free.numbers,
        "estimate_": free_estimates,
        datasets.LARGER: coarse.free.numbers if coarse else dict.fromkeys(OF_CURVE, np.nan),
        datasets.CHANGE: pairs.differences(curve.free.numbers, changed_free),
        **datasets.difference_errors(curve.free, OF_CURVE),
    }
    simplified = [xi in curve.contacts and curve.contacts[xi].simplified for xi in xis]
    numbers = {
        **datasets.variables(OF_ROLLING, "xi", by_creepage),
        **datasets.variables(OF_CURVE, (), free),
        **datasets.variables(OF_DISPLACED, (), {datasets.DISPLACED: moved}),
        "simplified": ("xi", simplified, datasets.SIMPLIFIED),
        "seconds": ((), seconds, datasets.SECONDS),
    }
    xi = "xi", list(xis), {"units": "1", "long_name": "longitudinal creepage"}
    varied = datasets.varied_tractions(
        pair.on_grid,
        coarse.equal.contact if coarse else None,
        np.full_like(p, np.nan) if changed_equal is None else changed_equal.contact.p - p,
    )
    maps = datasets.maps(pair.on_grid, curve.equal.contact)
    return xr.Dataset(numbers, coords={"xi": xi}).merge(maps).merge(varied)


def _curve(
    pair: pairs.PairWithFriction, problem: frictional_problem.FrictionalProblem, label: str
) -> CreepForceCurve:
    """Return the curve of a problem; raises Failure."""
    return Continuation(pair, pair.rolling(problem), label).curve()


def _points(curve: CreepForceCurve | None, xis: Sequence[float]) -> list[Numbers]:
    """Return the numbers of a curve by creepage; NaN where there is no contact."""
    unknown = dict.fromkeys(OF_ROLLING, np.nan)
    return [curve.points[xi].numbers if curve and xi in curve.points else unknown for xi in xis]


# numbers at a few growing creepages, those of the curve, the contact with the force at which ICs are compared
Changed = tuple[Mapping[float, Numbers], Numbers | None, "solver.RollingContact | None"]


def _with_ics(
    along: Continuation, curve: CreepForceCurve, operator: protocols.FullOperator | None
) -> Changed:
    """Return what is known of a curve with other ICs, None: with its own, from the contacts of the curve.

    Its creepages are the one nearest 0 and those with the largest forces, without those of no contact.
    """
    pair, xis = along.pair, deciding_creepages(curve)
    if operator is None:
        return {xi: curve.points[xi].numbers for xi in xis}, curve.free.numbers, curve.equal
    problem = pair.frictional(operator, along.problem.problem.friction)
    other = Continuation(pair, pair.rolling(problem), f"{along.label} plus its estimate")
    found = {xi: other.at_if_possible(xi, curve.contacts[xi]) for xi in xis}
    points = {xi: other.measured(contact).numbers for xi, contact in found.items() if contact}
    free = pairs.if_possible(pair, "no estimates", lambda: other.free([*curve.contacts.values()]))
    return points, *((free[0].numbers, free[1]) if free else (None, None))


def deciding_creepages(curve: CreepForceCurve) -> list[float]:
    """Return the creepages nearest 0, and with the largest forces both ways, growing."""
    force = {xi: point.numbers["F_x"] for xi, point in curve.points.items()}
    return sorted({min(force, key=abs), min(force, key=force.__getitem__), max(force, key=force.__getitem__)})


def between(rows: Mapping[float, Numbers], xi: float) -> dict[str, float]:
    """Return numbers at a creepage from rows at growing ones: linear between them, and constant beyond."""
    if not rows:
        return dict.fromkeys(OF_ROLLING, np.nan)
    return {
        name: float(np.interp(xi, list(rows), [row[name] for row in rows.values()])) for name in OF_ROLLING
    }


def _estimates(
    along: Continuation,
    curve: CreepForceCurve,
    larger: Sequence[CreepForceCurve | None],
    changed: Changed,
    moved: Numbers,
) -> tuple[list[dict[str, float]], dict[str, float]]:
    """Return estimated errors of the points at all creepages, and of the curve as a whole.

    They are sums of what larger elements, the distance of the displaced body (`moved` numbers), and changed
    ICs change.
    """
    pair, operator = along.pair, along.problem.problem.operator
    linearised = pairs.Linearisation.measure(pair.on_grid, operator, pair.loads[0])
    changed_points, changed_free, _ = changed
    point_kinds, curve_kinds = kinds(OF_ROLLING), kinds(OF_CURVE)
    rows = {xi: changes(curve.points[xi], point_kinds, numbers) for xi, numbers in changed_points.items()}
    points = []
    for xi in along.xi:
        point = curve.points.get(xi)
        parts = (
            [between(rows, xi)] if point is None else [linearised.part(point, point_kinds), between(rows, xi)]
        )
        coarse = [one.points.get(xi) if one else None for one in larger]
        points.append(errors(point_kinds, point, coarse, parts))
    parts = [
        linearised.part_of_curve(curve.free, moved["zero_creepage"]),
        changes(curve.free, curve_kinds, changed_free or dict.fromkeys(OF_CURVE, np.nan)),
    ]
    return points, errors(curve_kinds, curve.free, [one.free if one else None for one in larger], parts)


# --- all curves of a dataset ---


def add_distances(dataset: xr.Dataset, specification: ContactSpecification) -> xr.Dataset:
    """Return the dataset of all ICs with distances of their curves to the reference's: `rms` and `largest`.

    Creepages without a contact do not count. Estimates are those of the differences, and 0 for the reference.
    """
    friction = specification.friction
    assert friction is not None
    dataset = dataset.assign_attrs(load=specification.loads[0], equal_force=friction.equal_force)
    return dataset.assign(curve_distances(dataset))


def scaled_force(dataset: xr.Dataset, name: str = "F_x") -> xr.DataArray:
    """Return the longitudinal force, or what goes with it, over friction times load."""
    return dataset[name].drop_attrs(deep=False) / (dataset.friction * dataset.attrs["load"])


def curve_distances(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return distances of curves to the reference's over friction times load, and their estimates."""
    reference = ics.reference_name([str(name) for name in dataset.ics.values])

    def from_reference(contacts: xr.Dataset) -> xr.DataArray:
        force = scaled_force(contacts)
        return force - force.sel(ics=reference)

    norms: dict[str, tuple[str, datasets.Norm]] = {
        "rms": ("root mean square", lambda away: (away**2).mean("xi") ** 0.5),
        "largest": ("largest", lambda away: abs(away).max("xi")),
    }
    distances = {}
    for name, (word, norm) in norms.items():
        meaning = f"{word} difference from the reference curve, relative to friction times load"
        estimate = datasets.estimate_of_difference(dataset, from_reference, norm)
        both = {"": norm(from_reference(dataset)), "estimate_": estimate.where(dataset.ics != reference, 0.0)}
        for prefix, distance in both.items():
            about = meaning + datasets.PREFIXES[prefix]
            distances[prefix + name] = distance.assign_attrs(units="1", long_name=about)
    return distances


# --- whether creepages reach a force ---

BEYOND = 3.0  # times the force without slip from which no curve reaches a force: patches are no ellipses


def forces_beyond_creepages(problem: ContactProblem, sizing: grids.Sizing) -> Iterator[str]:
    """Yield with which friction the force at which ICs are compared is beyond all creepages.

    It need not be within those of the scene: it is found up to the default ones at least. Without slip forces
    are the largest. They are Kalker's, of the ellipse of Hertz, which is larger than the patch of bodies that
    fit each other; circles of other radii beside the crown add to the creepage.
    """
    friction = problem.specification.friction
    if friction is None or problem.specification.extra_gap is not None:
        return
    largest = largest_factor(friction.friction_by_angle)
    if abs(friction.equal_force) > BEYOND * largest:
        yield (
            f"contact.equal_force = {friction.equal_force:g}: tractions are compared at F_x = equal_force "
            f"friction load, and the factors of friction_by_angle are at most {largest:g}: give a smaller "
            "equal_force, or larger factors"
        )
    (load,) = problem.specification.loads
    ellipse, combined = grids.hertz(sizing.bodies, Loading(load)), problem.pair.constants
    G, nu = float(combined.G), float(combined.nu)
    b = float(np.clip(ellipse.b, ellipse.a / kalker.WIDEST, ellipse.a * kalker.WIDEST))
    coefficients = kalker.creepage_coefficients(ellipse.a, b, nu)
    creepage = max(*map(abs, friction.longitudinal), *CREEPAGES)
    rise = np.ptp(problem.bodies["lower"].contour.position(np.array([-1.0, 0.0, 1.0]) * ellipse.b)[1])
    beside = float(rise) / problem.bodies["upper"].rolling_radius
    reached, _, _ = coefficients.forces(G, creepage + abs(friction.lateral) + beside, 0.0, 0.0)
    for number, coefficient in enumerate(friction.coefficients):
        force = abs(friction.equal_force) * coefficient * load
        if force > BEYOND * reached:
            yield (
                f"contact.friction.{number} = {coefficient:g}: tractions are compared at F_x = equal_force "
                f"friction load = {force:.3g} N, and creepages to {creepage:g} give about {reached:.2g} N "
                "even without slip: give larger ones in contact.longitudinal, less friction, or a smaller "
                "equal_force"
            )


# --- registration ---

F_Y, F_Y_OVER_LIMIT, SLIDING = WITH_FRICTION
MOTION = Motion(
    description="steady rolling along x with friction, one load",
    title="Rolling with friction",
    keys=("friction", "friction_by_angle", "longitudinal", "lateral", "spin", "equal_force"),
    dimension="xi",
    quantities=OF_ROLLING,
    wants=(
        Want("F_x", "F_x", motion.ITSELF_WHERE_KNOWN),
        Want("F_x/limit", "F_x", motion.LIMIT),
        F_Y,
        F_Y_OVER_LIMIT,
        Want("dissipation", "dissipation", motion.ITSELF_WHERE_KNOWN),
        SLIDING,
        Want("zero_creepage", "zero_creepage", motion.SATURATION),
        Want("slope", "slope", motion.ITSELF),
        Want("equal_creepage", "equal_creepage", motion.SATURATION),
        *COMMON,
    ),
    growing=("longitudinal",),
    wheel_rolls=True,
    solve=solve_curve,
    solve_point=solve_nearest_to_no_creepage,
    complete=add_distances,
    misfits=forces_beyond_creepages,
)
