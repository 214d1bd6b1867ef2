"""Strange legal contacts: each is solved and obeys mechanics, or ends with words."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from fuzz import outcome
from outcomes import Outcome

from femic.contact.friction.motion import Creepages, LeadingEdge
from femic.contact.frictional import FrictionalContact
from femic.contact.loading import Loading
from femic.contact.motions import solve_with_friction
from femic.contact.motions.none import SolvedContact
from femic.contact.motions.rolling import Continuation
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.rolling import compressed
from femic.reference.run_options import RunOptions
from femic.results.contact import require_solvable, solve_scene
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.contours import Contour
from geometries.patches import N

ICS = ("A", "B", "Bhat", "mix")
MOTIONS = ("none", "rolling", "compression")
FORCE = 1e-5  # of the load, by which forces may be off; tolerances of tractions are 1e-6
SAME = 1e-7  # of the largest component of a force or moment
WORK = 1e-6  # of the largest work of friction, by which that of an element may be below 0
BOUND = 1e-6  # of the bound of friction, by which tractions may exceed it
OPTIONS = RunOptions(1)


def contacts(count: int, seed: int) -> Iterator[Outcome]:
    """Yield random contacts of odd sizes, bodies, places and motions."""
    for number in range(count):
        motion, chance = MOTIONS[number % len(MOTIONS)], np.random.default_rng([seed, number])
        yield outcome(f"{motion} {number}", partial(_solved, motion, chance))


def _solved(motion: str, chance: np.random.Generator) -> str:
    """Solve a random contact; raise AssertionError with what falls short."""
    scene = scene_from_table(strange(chance, motion), "strange")
    if short := CHECKS[motion](scene, chance):
        raise AssertionError(short)
    return "solved"


def strange(chance: np.random.Generator, motion: str) -> dict[str, Any]:
    """Return the table of a legal contact: radii over four decades, moduli over four, loads over eight."""
    radius = 10 ** chance.uniform(-0.5, 2.0)
    ratio = 1 + 10 ** chance.uniform(-3, 0.5)
    flanks = [float(flank) for flank in chance.uniform(0, 80, 2)]
    modulus = 10 ** chance.uniform(3, 6)
    bodies = {
        name: {
            "E": float(modulus * 10 ** chance.uniform(-1, 1)),
            "nu": float(chance.choice([0.0, 0.3, 0.4999, chance.uniform(0, 0.4999)])),
            "contour": {"kind": "arc", "radius": float(r), "flank_inclination_deg": flanks},
        }
        for name, r in (("lower", radius), ("upper", radius * ratio))
    }
    bodies["upper"]["rolling_radius"] = float(max(20.0, radius * 10 ** chance.uniform(0, 2)))
    load = float(modulus * radius**2 * 10 ** chance.uniform(-8, -2.5))
    contact: dict[str, Any] = {
        "loads": [load],
        "ics": [str(chance.choice(ICS))],
        "elements": int(chance.integers(8, 25)),
        "shift": float(chance.choice([0.0, 1.0]) * chance.uniform(-0.3, 0.3) * radius * (ratio - 1)),
        "flanks": bool(chance.random() < 0.5),
        "supports": False,
    }
    if motion != "none":
        contact |= {"motion": motion, "friction": [float(10 ** chance.uniform(-2, 0.5))]}
    if motion == "rolling":
        contact["longitudinal"] = [-1e-3, 1e-3]
    if motion == "compression":
        contact["loads"] = [load / 3, load]
    return {**bodies, "contact": contact}


def _without_friction(scene: Scene, _: np.random.Generator) -> str:
    """Return what falls short of a contact without friction."""
    (contact,) = solve_scene(scene, OPTIONS).contacts.values()
    return _of_pressures(contact, scene)


def _of_pressures(solved: SolvedContact, scene: Scene) -> str:
    normal, on_grid = solved.normal, solved.on_grid
    tractions = normal.p[..., None] * [0.0, 0.0, 1.0]
    force, moment = summed(tractions, scene.bodies["lower"].contour, on_grid)
    total, load = on_grid.resultant(tractions), scene.contact.loads[0]
    return _first(
        (np.any(normal.p < 0), "pulls"),
        (abs(force[2] - load) > FORCE * load, f"bears {force[2]:g} N of {load:g} N"),
        (differ(total.force, force), "other forces than its tractions"),
        (differ(total.moment, moment, arm_of(on_grid) * load), "other moments than its tractions"),
    )


def _rolling(scene: Scene, chance: np.random.Generator) -> str:
    """Return what falls short of a wheel that rolls at odd creepages, or without force along x."""
    friction = scene.contact.friction
    assert friction is not None
    size = 10 ** chance.uniform(-5, -1)
    along, aside, spin = (size * chance.uniform(-1, 1, 3)).tolist()
    creepages = Creepages(along, aside, spin / 10)
    free = {"longitudinal": 0.0} if chance.random() < 0.3 else {}

    def solved(pair: PairWithFriction) -> str:
        problem = pair.frictional(pair.operator(scene.contact.ics[0]), friction.coefficients[0])
        path = Continuation(pair, pair.rolling(problem), "strange")
        load = scene.contact.loads[0]
        total = path.problem.contact(creepages, Loading(load), forces=free)
        along = total.contact.force[0]
        return _of_friction(total.contact, pair, load) or _first(
            (bool(free) and abs(along) > 1e-4 * load * friction.coefficients[0], f"F_x is {along:g} N, not 0")
        )

    require_solvable(scene)
    return solve_with_friction(scene.contact_problem, solved, OPTIONS)


def _compression(scene: Scene, _: np.random.Generator) -> str:
    """Return what falls short of bodies that are pressed on each other in two steps."""
    friction = scene.contact.friction
    assert friction is not None

    def solved(pair: PairWithFriction) -> str:
        problem = pair.frictional(pair.operator(scene.contact.ics[0]), friction.coefficients[0])
        loads = scene.contact.loads
        steps = compressed(problem, [Loading(load) for load in loads])
        for load, contact in zip(loads, steps, strict=True):
            if short := _of_friction(contact, pair, load):
                return short
        return ""

    require_solvable(scene)
    return solve_with_friction(scene.contact_problem, solved, OPTIONS)


def _of_friction(contact: FrictionalContact, pair: PairWithFriction, load: float) -> str:
    """Return what falls short of equilibrium, Coulomb's law, and a work of friction that is not negative."""
    on_grid, p = replace(pair.on_grid, grid=contact.problem.grid), contact.p
    force, moment = summed(p, pair.problem.bodies["lower"].contour, on_grid)
    total = on_grid.resultant(p)
    bound, size = contact.problem.friction * p[..., N], np.hypot(p[..., 0], p[..., 1])
    work, free = contact.dissipation, LeadingEdge.find(bound, contact.motion.depth).free
    return _first(
        (np.any(p[..., N] < 0), "pulls"),
        (abs(force[2] - load) > FORCE * load, f"bears {force[2]:g} N of {load:g} N"),
        (np.any(size > bound + BOUND * np.max(bound)), "tractions exceed friction times pressure"),
        (np.min(work[free], initial=0.0) < -WORK * np.max(np.abs(work)), "friction gives energy"),
        (np.sum(work) < 0, "friction gives energy in all"),
        (differ(contact.force, force), "other forces than its tractions"),
        (differ(total.force, force), "other resultants than its tractions"),
        (differ(total.moment, moment, arm_of(on_grid) * load), "other moments than its tractions"),
    )


CHECKS = {"none": _without_friction, "rolling": _rolling, "compression": _compression}


def summed(tractions: Any, contour: Contour, on_grid: PairOnGrid) -> tuple[Any, Any]:
    """Return force and moment of tractions about the contact centre, with tangents by differences."""
    x, s, step = on_grid.x, on_grid.grid.strips, 1e-6
    ahead, behind, at = (np.stack(contour.position(s + shift)) for shift in (step, -step, 0.0))
    tangent = (ahead - behind) / np.linalg.norm(ahead - behind, axis=0)
    zero = np.zeros_like(s)
    along_x = np.stack([zero + 1.0, zero, zero])
    basis = np.stack([along_x, np.stack([zero, *tangent]), np.stack([zero, -tangent[1], tangent[0]])])
    forces = on_grid.grid.area * np.einsum("xsd,das->xsa", tractions, basis)
    places = np.empty_like(forces)
    places[..., 0], places[..., 1], places[..., 2] = x[:, None], at[0], at[1]
    return forces.sum(axis=(0, 1)), np.cross(places, forces).sum(axis=(0, 1))


def arm_of(on_grid: PairOnGrid) -> float:
    """Return the largest distance of an element from the contact centre [mm]."""
    return float(np.max(np.abs(on_grid.x)) + np.max(np.abs(on_grid.grid.strips)))


def differ(actual: Any, expected: Any, size: float = 0.0) -> bool:
    """Whether two vectors differ by more than differences of the contour explain; `size` is what cancels."""
    return bool(np.max(np.abs(actual - expected)) > SAME * max(size, np.max(np.abs(expected))))


def _first(*checks: tuple[Any, str]) -> str:
    """Return the text of the first check whose condition holds."""
    return next((text for holds, text in checks if holds), "")
