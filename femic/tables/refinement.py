"""The nodes of a table: refined until contacts between them, solved on smaller elements, agree with it.

Contacts at random places, which are no nodes of any axis, are solved on elements of half the size. While less
than 95 % of their numbers are within the tolerance, the axis along which the table is worst gets more nodes:
where contacts in the middle of its intervals differ most from the table. A table that is good enough is
judged by contacts at random places that it has not met, whose deviations it states; if it fails there, they
join the others. Where both bodies are symmetric,
contacts are solved on one side.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import product
from typing import Any

import joblib
import numpy as np
import xarray as xr

from femic.cache.digests import results_digest
from femic.cache.store import Store
from femic.cache.workers import one_blas_thread
from femic.contact.specification import ContactProblem
from femic.reference.run_options import RunOptions
from femic.tables.columns import BEYOND, CONTACT, FORCES, Column, Place, Slip, creepages, solve_column
from femic.tables.creep_table import Table
from femic.tables.specification import TableSpecification
from geometries.arrays import Array
from geometries.errors import Failure

AXES = "shift", "load", "friction", "spin", "turn", "creepage"
OUTER, INNER = AXES[:3], AXES[3:]
ANGLES = 8  # of creepages, at first; this number is doubled
CREEPAGES = (0.0, 0.12, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0)  # m / (1 + m), at first
SPINS = (-1.0, 0.0, 1.0)  # over the largest one, at first
MOST_ROUNDS = 40
MOST_NODES = 129  # of an axis
AT_INTERVAL = 8  # contacts in the middle of an interval
HELD_OUT, IN_HELD_OUT = 40, 6  # places, and contacts at each, with which a table is judged
WITHIN = 0.95  # share of their numbers that have to be within the tolerance
NEARLY_WORST = 0.5  # intervals with this share of the largest deviation of an axis are halved
DRIVING = "f_x", "f_y", "m_n", "p_max", "normal_force"  # numbers that are judged
REPORTS = 5  # of progress, while contacts are solved
SEED = 20261128

Nodes = dict[str, tuple[Any, ...]]
Spread = Callable[[Callable[["Job"], Column], Iterable["Job"]], Iterator[Column]]


@dataclass(frozen=True, eq=False)
class Job:
    """Contacts at a place, solved by a worker, or taken from the store."""

    problem: ContactProblem
    place: Place
    slips: tuple[Slip, ...]
    elements: int
    store: Store

    def key(self) -> str:
        """Return the key of its contacts in a store."""
        facts = self.place, self.slips, self.elements, results_digest()
        return self.store.key("creep", joblib.hash(self.problem), *facts)


def solve_job(job: Job) -> Column:
    """Return the contacts of a job, and store them. Raises Failure."""
    store, key = job.store, job.key()
    if (entry := store.get(key)) is not None:
        return Column({name: float(entry.attrs[name]) for name in CONTACT}, entry.shares.values)
    with one_blas_thread():
        column = solve_column(job.problem, job.place, job.slips, job.elements, RunOptions(1, store))
    store.put(key, xr.Dataset({"shares": (("slip", "share"), column.shares)}, attrs=column.contact))
    return column


@dataclass(eq=False)
class Contacts:
    """Contacts that are solved: what is at a place without friction, and shares by slip."""

    problem: ContactProblem
    elements: int
    symmetric: bool
    options: RunOptions
    spread: Spread
    contact: dict[Place, dict[str, float]] = field(default_factory=dict)
    shares: dict[Place, dict[Slip, Array]] = field(default_factory=dict)

    def solve(self, wanted: Mapping[Place, Iterable[Slip]], what: str) -> None:
        """Solve the contacts that are not known yet; `what` they are for is reported."""
        jobs = [
            Job(self.problem, place, tuple(sorted(slips)), self.elements, self.options.store)
            for place, slips in self.unknown(wanted).items()
        ]
        done, total = 0, sum(len(job.slips) for job in jobs)
        for job, column in zip(jobs, self.spread(solve_job, jobs), strict=True):
            self.contact[job.place] = column.contact
            self.shares.setdefault(job.place, {}).update(zip(job.slips, column.shares, strict=True))
            before, done = done, done + len(job.slips)
            if before * REPORTS // total < done * REPORTS // total:
                self.options.watch.on_stage(f"{what}: {done} of {total} contacts")

    def unknown(self, wanted: Mapping[Place, Iterable[Slip]]) -> dict[Place, set[Slip]]:
        """Return the contacts that have to be solved for others."""
        missing: dict[Place, set[Slip]] = {}
        for place, slips in wanted.items():
            for slip in slips:
                at, near, _ = self._canonical(place, slip)
                if near not in self.shares.get(at, {}):
                    missing.setdefault(at, set()).add(near)
        return missing

    def at(self, place: Place, slip: Slip) -> Array:
        """Return the shares of a contact, (6,)."""
        at, near, mirrored = self._canonical(place, slip)
        signs = [sign if mirrored else 1 for sign, _ in FORCES.values()]
        return self.shares[at][near] * signs

    def without_friction(self, place: Place) -> dict[str, float]:
        """Return the quantities of the contact without friction."""
        mirrored = self.symmetric and place.shift < 0
        known = self.contact[place._replace(shift=-place.shift) if mirrored else place]
        return {name: known[name] * (CONTACT[name][2] if mirrored else 1) for name in CONTACT}

    def _canonical(self, place: Place, slip: Slip) -> tuple[Place, Slip, bool]:
        """Return the contact that is solved for another, and whether it is its mirror image."""
        if slip.creepage == 0:
            slip = slip._replace(turn=Fraction(0))
        if not self.symmetric:
            return place, slip, False
        mirror = Slip(-slip.spin, (1 - slip.turn) % 1, slip.creepage)
        if (-place.shift, mirror.spin, -mirror.turn) > (place.shift, slip.spin, -slip.turn):
            return place._replace(shift=-place.shift), mirror, True
        return place, slip, False


# --- nodes ---


def first_nodes(specification: TableSpecification) -> Nodes:
    """Return the nodes with which a table begins."""
    spins = [spin * specification.spin for spin in SPINS] if specification.spin else [0.0]
    return {
        "shift": specification.shifts,
        "load": specification.loads,
        "friction": specification.friction,
        "spin": tuple(spins),
        "turn": tuple(Fraction(k, ANGLES) for k in range(ANGLES)),
        "creepage": CREEPAGES,
    }


def all_contacts(nodes: Nodes) -> dict[Place, list[Slip]]:
    """Return the contacts at all nodes."""
    slips = [Slip(*slip) for slip in product(*(nodes[axis] for axis in INNER))]
    return {Place(*place): slips for place in product(*(nodes[axis] for axis in OUTER))}


def make_table(contacts: Contacts, nodes: Nodes) -> Table:
    """Return the table of contacts at nodes."""
    shape = tuple(len(nodes[axis]) for axis in AXES)
    at_nodes = all_contacts(nodes)
    quantities = [contacts.without_friction(place) for place in at_nodes]
    shares = [contacts.at(place, slip) for place, slips in at_nodes.items() for slip in slips]
    by_share = np.moveaxis(np.reshape(shares, (*shape, len(FORCES))), -1, 0)
    whole = quantities[:: shape[2]]  # they do not depend on friction
    return Table(
        {("angle" if axis == "turn" else axis): values_of(axis, nodes[axis]) for axis in AXES},
        {name: np.reshape([each[name] for each in whole], shape[:2]) for name in CONTACT},
        [name for name, (_, scale, _, _) in CONTACT.items() if scale == "log"],
        dict(zip(FORCES, by_share, strict=True)),
    )


def values_of(axis: str, nodes: tuple[Any, ...]) -> Array:
    """Return the nodes of an axis as numbers: angles in radians."""
    return np.array([2 * np.pi * node for node in nodes] if axis == "turn" else nodes, float)


def insert(nodes: Nodes, axis: str, places: Iterable[int]) -> Nodes:
    """Return the nodes with the middles of some intervals; angles are all doubled, spins on both sides."""
    own, numbers = nodes[axis], set(places)
    if axis == "turn":
        return nodes | {axis: tuple(Fraction(k, 2 * len(own)) for k in range(2 * len(own)))}
    if axis == "spin":
        numbers |= {len(own) - 2 - k for k in numbers}
    return nodes | {axis: tuple(sorted({*own, *((own[k] + own[k + 1]) / 2 for k in numbers)}))}


# --- errors ---


def deviations(table: Table, contacts: Contacts, place: Place, slip: Slip) -> dict[str, float]:
    """Return numbers of the table less those of a contact, as shares of friction times normal force.

    Of p_max and the normal force: as shares of these; of work: as a share of that at the same creepage.
    """
    contact, shares = contacts.without_friction(place), contacts.at(place, slip)
    own = creepages(contact, place.friction, slip)
    here = table.contact(place.shift, place.load)
    per_spin = place.friction * here["creepage_scale"] / here["half_size"]
    spin = np.clip(own.spin, *(end * per_spin for end in table.axes["spin"][[0, -1]]))
    found = table.forces(*place, own.longitudinal, own.lateral, spin)
    unit = place.friction * contact["normal_force"]
    f_x, f_y, f_n, m_n, p, work = shares
    sine, cosine = np.sin(contact["contact_angle"]), np.cos(contact["contact_angle"])
    creepage = 1 / (1 - min(slip.creepage, BEYOND))
    per_work = unit * place.friction * contact["creepage_scale"] * creepage
    return {
        "f_x": found["F_x"] / unit - f_x,
        "f_y": (found["F_y"] * cosine + found["F_z"] * sine) / unit - f_y,
        "m_n": found["M_n"] / (unit * contact["half_size"]) - m_n,
        "p_max": found["p_max"] / (contact["p_max"] * p) - 1,
        "normal_force": (found["F_z"] * cosine - found["F_y"] * sine) / (contact["normal_force"] * f_n) - 1,
        "work": found["work"] / per_work - work,
        "contact_angle": here["contact_angle"] - contact["contact_angle"],
    }


def driving(table: Table, contacts: Contacts, place: Place, slip: Slip) -> float:
    """Return the largest deviation that counts."""
    own = deviations(table, contacts, place, slip)
    return max(abs(own[name]) for name in DRIVING)


# --- refinement ---


@dataclass(frozen=True, eq=False)
class Judged:
    """A table, and its deviations from contacts at random places: (n,) by number, and where they are."""

    table: Table
    nodes: Nodes
    places: list[tuple[Place, Slip]]
    deviations: dict[str, Array]
    solved: int

    def error(self, name: str) -> float:
        """Return the deviation that a share of `WITHIN` has at most."""
        return float(np.quantile(np.abs(self.deviations[name]), WITHIN))

    @property
    def worst(self) -> float:
        """The largest error of the numbers that count."""
        return max(self.error(name) for name in DRIVING)


def refined_table(
    problem: ContactProblem, specification: TableSpecification, options: RunOptions, spread: Spread
) -> Judged:
    """Return a table that is within its tolerance. Raises Failure where there is none."""
    contacts = Contacts(problem, specification.elements, is_symmetric(problem), options, spread)
    finer = replace(contacts, elements=2 * specification.elements, contact={}, shares={})
    nodes, random = first_nodes(specification), np.random.default_rng(SEED)
    held_out = random_contacts(nodes, random)
    finer.solve(held_out, "contacts that judge the table")
    for round_ in range(1, MOST_ROUNDS + 1):
        contacts.solve(all_contacts(nodes), f"nodes, round {round_}")
        judged = judge(contacts, finer, nodes, held_out)
        options.watch.on_stage(f"round {round_}: 95 % of other contacts within {judged.worst:.3g}")
        if judged.worst <= specification.tolerance:
            others = random_contacts(nodes, random)
            finer.solve(others, "other contacts that judge the table")
            judged = judge(contacts, finer, nodes, others)
            if judged.worst <= specification.tolerance:
                return judged
            for place, slips in others.items():
                held_out.setdefault(place, []).extend(slips)
        refined = refine(contacts, nodes, random, f"between nodes, round {round_}")
        if refined is None:
            break
        nodes = refined
    raise not_reached(judged, specification.tolerance)


def is_symmetric(problem: ContactProblem) -> bool:
    """Return whether contacts at opposite shifts are mirror images."""
    bodies = problem.bodies.values()
    return all(body.symmetric for body in bodies) and problem.specification.extra_gap is None


def random_contacts(nodes: Nodes, random: np.random.Generator) -> dict[Place, list[Slip]]:
    """Return contacts at random places within the nodes."""

    def between(axis: str) -> float:
        return float(random.uniform(nodes[axis][0], nodes[axis][-1]))

    contacts: dict[Place, list[Slip]] = {}
    for _ in range(HELD_OUT):
        place = Place(*(between(axis) for axis in OUTER))
        contacts.setdefault(place, []).extend(
            Slip(between("spin"), Fraction(int(random.integers(1 << 30)), 1 << 30), between("creepage"))
            for _ in range(IN_HELD_OUT)
        )
    return contacts


def refine(contacts: Contacts, nodes: Nodes, random: np.random.Generator, what: str) -> Nodes | None:
    """Return nodes with more on the axis along which the table is worst; None where no axis takes more."""
    table = make_table(contacts, nodes)
    probes = {
        (axis, k): probe(nodes, axis, k, random)
        for axis in AXES
        for k in range(len(nodes[axis]) - 1)
        if 2 * len(nodes[axis]) <= MOST_NODES
    }
    wanted: dict[Place, list[Slip]] = {}
    for probed in probes.values():
        for place, slip in probed:
            wanted.setdefault(place, []).append(slip)
    contacts.solve(wanted, what)
    by_axis: dict[str, dict[int, list[float]]] = {}
    for (axis, k), probed in probes.items():
        by_axis.setdefault(axis, {})[k] = [driving(table, contacts, *each) for each in probed]
    if not by_axis:
        return None
    axis = max(by_axis, key=lambda axis: np.quantile([*by_axis[axis].values()], WITHIN))
    worst = {k: max(values) for k, values in by_axis[axis].items()}
    least = NEARLY_WORST * max(worst.values())
    return insert(nodes, axis, [k for k, value in worst.items() if value >= least])


def probe(nodes: Nodes, axis: str, k: int, random: np.random.Generator) -> list[tuple[Place, Slip]]:
    """Return contacts in the middle of an interval of an axis, at random nodes of the others.

    Those at a shift, a load or a friction that is no node are at one place.
    """

    def at(axes: tuple[str, ...]) -> list[Any]:
        drawn = {other: nodes[other][int(random.integers(len(nodes[other])))] for other in axes}
        return [(nodes[axis][k] + nodes[axis][k + 1]) / 2 if each == axis else drawn[each] for each in axes]

    places = [Place(*at(OUTER)) for _ in range(1 if axis in OUTER else AT_INTERVAL)]
    return [(places[turn % len(places)], Slip(*at(INNER))) for turn in range(AT_INTERVAL)]


def judge(contacts: Contacts, finer: Contacts, nodes: Nodes, held_out: Mapping[Place, list[Slip]]) -> Judged:
    """Return the table at nodes with its deviations from other contacts."""
    table = make_table(contacts, nodes)
    places = [(place, slip) for place, slips in held_out.items() for slip in slips]
    found = [deviations(table, finer, place, slip) for place, slip in places]
    by_number = {name: np.array([each[name] for each in found]) for name in found[0]}
    return Judged(table, nodes, places, by_number, sum(map(len, contacts.shares.values())))


def not_reached(judged: Judged, tolerance: float) -> Failure:
    """Return the failure of a table that is not within its tolerance."""
    name = max(DRIVING, key=judged.error)
    worst = int(np.argmax(np.abs(judged.deviations[name])))
    place, _ = judged.places[worst]
    return Failure(
        f"table: {name} of 95 % of other contacts is within {judged.error(name):.3g}, not the tolerance of "
        f"{tolerance:g}; most differ at a shift of {place.shift:.4g} mm and {place.load:.4g} N. Give shifts "
        "that leave out where contacts jump, more elements, or a larger tolerance; solved contacts are stored"
    )


def expected_contacts(problem: ContactProblem, specification: TableSpecification) -> tuple[int, int]:
    """Return the numbers of places and of contacts with which a table begins, and that judge it."""
    contacts = Contacts(problem, specification.elements, is_symmetric(problem), RunOptions(), map)
    unknown = contacts.unknown(all_contacts(first_nodes(specification)))
    return len(unknown) + HELD_OUT, sum(map(len, unknown.values())) + HELD_OUT * IN_HELD_OUT
