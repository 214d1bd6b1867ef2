"""Crossings: the load and the angle at which the error of a number with some ICs passes a tolerance.

The contact is solved at some loads on one grid, with ICs and with C; between the two loads where the error
passes the tolerance first, the load at which it does so is solved for. Errors are differences of numbers on
the same elements, of which most of the error of the elements is no part; what is left of it comes from the
same difference on elements twice and four times as large.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from scipy.optimize import brentq

from femic.contact.estimates import BESIDE_FLOOR, Measured, Numbers, changes, errors, from_grids
from femic.contact.loading import Loading
from femic.contact.motions.none import load_at_angle
from femic.contact.normal import NormalContact
from femic.contact.operators.protocols import Operator
from femic.contact.pairs.grids import contact_size, grids_of, make_sizing, on_fitting_grid
from femic.contact.pairs.ics import C, normal_reference_ics
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.quantities import ALL, Quantity, kinds, measured
from femic.contact.patch import ACCURACY
from femic.contact.specification import ContactProblem
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.errors import Failure, WrongInput

LENGTHS = ("a", "b")
NUMBERS = ("p_max", *LENGTHS, "approach")  # whose errors are sought
QUANTITIES: Mapping[str, Quantity] = {name: ALL[name] for name in (*NUMBERS, "angle")}
PERTURBED = "C plus its estimated error"
LEAST, MOST = 1.0, 1e9  # loads [N] between which the one with an angle is sought
BEYOND = 180.0  # degrees, of patches that reach the end of a contour: more than any other
LOAD_ACCURACY = 0.01  # of a load, relative: the angle goes like its third root or slower
ANGLE_ACCURACY = 0.05  # of the load that has an angle on the grid, relative
MISSED, MISSED_OF_LENGTHS = 0.02, 0.1  # shares of an error that elements may miss
APART = {"a": 0.01, "b": 0.02}  # shares of the accuracy of a reading that two ICs do not have in common


@dataclass(frozen=True)
class Deviation:
    """The error of a number with some ICs relative to C at a load [N], and the angle of the patch with C.

    The error is a share [-], of what its law says; angles are in degrees. Estimates are those of both.
    """

    load: float
    angle: float
    angle_estimate: float
    error: float
    estimate: float


Law = Callable[[float], Deviation]  # by the load [N]
Outcome = TypeVar("Outcome")


@dataclass(frozen=True)
class Crossing:
    """Where the error passes a tolerance first, as the load grows.

    `at` is None where it stays within the tolerance up to the largest load, whose deviation is `end`;
    `largest` is the largest of the deviations at the loads that were solved first. `estimate` is the
    estimated error of the angle at the crossing [deg]. `before`: the tolerance is passed at the smallest load
    already. `stays`: the error is beyond the tolerance at all larger loads.
    """

    tolerance: float
    at: Deviation | None
    estimate: float
    before: bool
    stays: bool
    largest: Deviation
    end: Deviation


def crossing(law: Law, loads: Sequence[float], tolerance: float, accuracy: float = LOAD_ACCURACY) -> Crossing:
    """Return where the error of a law passes a tolerance first; `loads` [N] grow.

    `accuracy` is that of the load, relative. Raises WrongInput for less than two loads.
    """
    if len(loads) < 2 or np.any(np.diff(loads) <= 0):
        raise WrongInput(f"loads = {list(loads)}: give two or more that grow [N]")
    ladder = [law(load) for load in loads]
    beyond = [abs(deviation.error) > tolerance for deviation in ladder]
    largest = max(ladder, key=lambda deviation: abs(deviation.error))
    if not any(beyond):
        return Crossing(tolerance, None, np.nan, before=False, stays=False, largest=largest, end=ladder[-1])
    first = beyond.index(True)
    at = ladder[0] if first == 0 else _passing(law, (ladder[first - 1], ladder[first]), tolerance, accuracy)
    neighbours = ladder[max(first - 1, 0)], ladder[max(first, 1)]
    return Crossing(
        tolerance,
        at,
        _angle_error(at, neighbours) + _of_load(at, neighbours, 0.0 if first == 0 else accuracy, tolerance),
        before=first == 0,
        stays=all(beyond[first:]),
        largest=largest,
        end=ladder[-1],
    )


def _passing(law: Law, between: tuple[Deviation, Deviation], tolerance: float, accuracy: float) -> Deviation:
    """Return the deviation where its size is the tolerance, between a load within it and one beyond."""
    known = {float(np.log(end.load)): end for end in between}

    def excess(logarithm: float) -> float:
        deviation = known.get(logarithm) or law(float(np.exp(logarithm)))
        return abs(deviation.error) - tolerance

    root = float(brentq(excess, *known, xtol=accuracy))
    return known.get(root) or law(float(np.exp(root)))


def _angle_error(at: Deviation, neighbours: tuple[Deviation, Deviation]) -> float:
    """Return the estimated error of a crossing [deg]: that of the error over its slope, and the angle's."""
    within, beyond = neighbours
    rise = abs(abs(beyond.error) - abs(within.error))
    slope = rise / max(abs(beyond.angle - within.angle), np.finfo(float).tiny)
    return at.estimate / max(slope, np.finfo(float).tiny) + at.angle_estimate


def _of_load(
    at: Deviation, neighbours: tuple[Deviation, Deviation], accuracy: float, tolerance: float
) -> float:
    """Return what the accuracy of the load, relative, is of the angle of a crossing [deg].

    The angle bends over the logarithm of the load: of the slopes to both neighbours the steeper one is no
    smaller than that at the crossing. A neighbour that is nearer than the accuracy tells none, as readings of
    angles have errors. 0 where the error is the tolerance exactly, as it may be at a load solved first.
    """
    if abs(at.error) == tolerance:
        return 0.0
    within, beyond = neighbours
    pairs = ((within, beyond), (within, at), (at, beyond))
    spans = [(float(np.log(high.load / low.load)), high.angle - low.angle) for low, high in pairs]
    slopes = [
        abs(angle) / span for number, (span, angle) in enumerate(spans) if not number or span > accuracy
    ]
    return max(slopes) * accuracy


@dataclass(frozen=True, eq=False)
class PairDeviations:
    """Frictionless contacts of two bodies on one grid with some ICs and with C, solved when asked for."""

    on_grid: PairOnGrid
    operators: Mapping[str, Operator]  # by name, C among them
    perturbed: Operator | None = None  # C plus its estimated error
    _levels: dict[tuple[float, str], list[Measured]] = field(default_factory=dict)

    def law(self, number: str, name: str) -> Law:
        """Return the error of a number of `NUMBERS` with the ICs of a name over that with C, by the load."""

        def deviation(load: float) -> Deviation:
            error, estimate = self.error(number, name, load)
            return Deviation(load, *self.angle(load), error, estimate)

        return deviation

    def levels(self, load: float, name: str) -> list[Measured]:
        """Return the numbers of a contact, on the grid and on elements twice and four times as large.

        The name `PERTURBED` is that of C plus its estimated error. Raises as `PairOnGrid.solve_in_place`.
        """
        if (load, name) not in self._levels:
            operator = self.perturbed if name == PERTURBED else self.operators[name]
            assert operator is not None
            contact = self.on_grid.solve_in_place(operator, Loading(load))
            self._levels[load, name] = [
                measured(self.on_grid, level, QUANTITIES) for level in _with_coarser(contact)
            ]
        return self._levels[load, name]

    def value(self, load: float, name: str, number: str) -> float:
        """Return a number of `QUANTITIES` with the ICs of a name."""
        return self.levels(load, name)[0].numbers[number]

    def angle(self, load: float) -> tuple[float, float]:
        """Return the angle of the patch with C at a load [N] and its estimated error [deg]."""
        (fine, *larger), of_all, parts = self.levels(load, C), kinds(QUANTITIES), list[Numbers]()
        if self.perturbed is not None:
            parts.append(changes(fine, of_all, self.levels(load, PERTURBED)[0].numbers))
        return fine.numbers["angle"], errors(of_all, fine, larger, parts)["angle"]

    def error(self, number: str, name: str, load: float) -> tuple[float, float]:
        """Return the error of a number with the ICs of a name over that with C, and its estimated error."""
        ours, theirs = self.levels(load, name), self.levels(load, C)
        share = _share(number, ours[0], theirs[0])
        of_elements = self._of_length if number in LENGTHS else _of_elements
        estimate = of_elements(number, ours, theirs)
        if self.perturbed is not None:
            estimate += abs(_share(number, ours[0], self.levels(load, PERTURBED)[0]) - share)
        return share, estimate

    def _of_length(self, number: str, ours: Sequence[Measured], theirs: Sequence[Measured]) -> float:
        """Return by how much elements may falsify the error of a half-length or half-width.

        Readings of edges err nearly alike on the same elements, less so the more both contacts differ; on
        elements four times as large they are too crude.
        """
        step = self.on_grid.grid.dx if number == "a" else self.on_grid.grid.ds
        apart = APART[number] * ACCURACY * sum(step / solved[0].numbers[number] for solved in (ours, theirs))
        shares = _shares(number, ours, theirs)[:2]
        of_grids = BESIDE_FLOOR * from_grids(*shares) if len(shares) > 1 else 0.0
        follows = abs(shares[0]) + abs(_share("p_max", ours[0], theirs[0]))
        return of_grids + apart + MISSED_OF_LENGTHS * follows


def _of_elements(number: str, ours: Sequence[Measured], theirs: Sequence[Measured]) -> float:
    """Return by how much elements may falsify the error of another number, of which they may miss a part."""
    shares = _shares(number, ours, theirs)
    return MISSED * abs(shares[0]) + (from_grids(*shares) if len(shares) > 1 else 0.0)


def _shares(number: str, ours: Sequence[Measured], theirs: Sequence[Measured]) -> list[float]:
    """Return an error on elements of several sizes."""
    return [_share(number, *pair) for pair in zip(ours, theirs, strict=False)]


def _share(number: str, ours: Measured, theirs: Measured) -> float:
    return ours.numbers[number] / theirs.numbers[number] - 1


def _with_coarser(contact: NormalContact) -> list[NormalContact]:
    """Return a contact and the same on elements twice and four times as large, as far as there are any."""
    levels = [contact]
    while len(levels) < 3 and levels[-1].coarser is not None:
        levels.append(levels[-1].coarser)
    return levels


@dataclass(frozen=True)
class Ladder:
    """Which loads are solved first: how many, from which angle [deg] to which, the largest load [N]."""

    smallest_angle: float
    largest_angle: float
    largest_load: float = MOST
    steps: int = 9

    def loads(self, problem: ContactProblem) -> list[float]:
        """Return loads of a problem in equal ratios, by the angles of contact with B-hat.

        Raises Failure where the patch turns by more than an angle under any load.
        """
        bodies = make_sizing(problem).bodies
        largest = _load_at(bodies, self.largest_angle, self.largest_load)
        smallest = _load_at(bodies, self.smallest_angle, largest / 2)
        return [float(load) for load in np.geomspace(smallest, largest, self.steps)]


def _load_at(bodies: PairOnGrid, degrees: float, most: float) -> float:
    """Return the load [N] at which the patch with B-hat turns by an angle; `most` where it needs more.

    Raises Failure where it turns by more under any load.
    """

    def angle(load: float) -> float:
        try:
            size = contact_size(bodies, Loading(load))
        except Failure:  # it reaches the end of a contour
            return BEYOND
        ends = bodies.undeformed.lower.contour.inclination(np.array(size.s))
        return float(np.degrees(np.ptp(ends)))

    if angle(most) <= degrees:
        return most
    return load_at_angle(angle, degrees, (LEAST, most), ANGLE_ACCURACY, "the patch with B-hat")


def on_pair(
    problem: ContactProblem,
    loads: Sequence[float],
    names: Sequence[str],
    use: Callable[[PairDeviations], Outcome],
    options: RunOptions = DEFAULT,
) -> Outcome:
    """Return what `use` makes of the deviations of some ICs on the grid of the largest of some loads [N].

    The grid is made longer where a contact needs it. Raises Failure and NotConverged as C and contacts do.
    """
    specification = replace(problem.specification, loads=(max(loads),), approaches=(), ics=(*names, C))
    problem = replace(problem, specification=specification)
    ((grid, _),) = grids_of(problem)

    def on_grid(pair: PairOnGrid) -> Outcome:
        reference = normal_reference_ics(problem, pair, options)
        operators = {name: pair.operator(name) for name in names} | {C: reference.operator}
        return use(PairDeviations(pair, operators, reference.perturbed))

    return on_fitting_grid(problem, grid, on_grid)
