"""Contact without friction at its limits: A against Hertz, others against finer elements and finer C."""

from dataclasses import replace

import numpy as np

from compare.validation.extremes.cases import CONTACT, Limit
from compare.validation.extremes.contacts import (
    APART,
    BeyondContact,
    Cases,
    ContactCase,
    ContactSolution,
    Truth,
    base_scene,
    bumps,
    conformal,
    contact_limits,
    crossed,
    error_scales,
    finer,
    hertz_bump,
    hertz_contact,
    same_as,
    two_bumps,
)
from compare.validation.extremes.engines import Changes
from femic.contact.motions.none import solve_frictionless
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.quantities import OF_FRICTIONLESS, measured, numbers
from femic.contact.specification import ContactProblem, Profile
from femic.reference.run_options import RunOptions
from geometries.patches import Grid

SHAPE = ("p_max", "a", "b", "approach", "stiffness")
COARSE, FINE = 8, 16  # elements across a patch with C, and with a finer one,
FINE_TOLERANCE = 0.03  # whose C has this tolerance


def press(problem: ContactProblem, options: RunOptions) -> ContactSolution:
    """Solve the contact with the only ICs under the only load of a problem, as `femic contact` does."""
    ((loading, ics),) = (contacts := solve_frictionless(problem, options).contacts)
    contact = contacts[loading, ics]
    on_grid, known = contact.on_grid, measured(contact.on_grid, contact.normal)

    def on(grid: Grid) -> dict[str, float]:
        other = replace(on_grid, grid=grid)
        return numbers(other, other.solve(other.operator(ics), loading).normal)

    scales = error_scales(known, OF_FRICTIONLESS)
    return ContactSolution(problem, on_grid, known.numbers, contact.estimated_errors(), scales, on, options)


def limits() -> list[Limit]:
    """Return the limits of contact without friction, with cases within and beyond them."""
    nearly = conformal(1e3, 0.01, bodies=_both({"nu": 0.4999}))
    table: dict[tuple[str, str], Cases] = {
        ("load", "1e-3 N … the end of a contour"): [
            against_hertz("1e-3 N", crossed(1e-3)),
            against_hertz("1e5 N", crossed(1e5)),
            against_hertz("tall, 1e-3 N", _tall(1e-3), base="tall"),
            against_finer("tall, 310 kN", _tall(310e3), base="tall"),
            _leaves("tall, 1e7 N", _tall(1e7), base="tall"),
            _beyond("tall, 1e8 N", _tall(1e8), base="tall"),
            _beyond("-1 N", crossed(-1.0)),
            _beyond("1e16 N", crossed(1e16)),
        ],
        ("modulus ratio", "0.01 … 100"): [
            against_hertz("0.01", crossed(100.0, bodies={"upper": {"E": 2.1e3}})),
            against_hertz("100", crossed(100.0, bodies={"upper": {"E": 2.1e7}})),
            against_finer("0.01, conformal", conformal(20.0, 0.01, bodies={"upper": {"E": 2.1e3}})),
            _beyond("E = 0", crossed(100.0, bodies={"upper": {"E": 0.0}})),
        ],
        ("ν", "0 … 0.4999"): [
            against_hertz("ν = 0", crossed(100.0, bodies=_both({"nu": 0.0}))),
            against_hertz("ν = 0.4999", crossed(100.0, bodies=_both({"nu": 0.4999}))),
            against_finer("ν = 0.4999, conformal", nearly),
            with_c("ν = 0.4999, C", nearly),
            _beyond("ν = 0.49995", crossed(100.0, bodies=_both({"nu": 0.49995}))),
        ],
        ("R_roll", "20 … 1e6 mm"): [
            against_hertz("20 mm", crossed(10.0, roller=20.0)),
            against_finer("20 mm, conformal", conformal(300.0, 0.01, roller=20.0)),
            against_hertz("1e6 mm", crossed(10.0, crown=1e6, roller=1e6)),
            _beyond("19 mm", crossed(10.0, roller=19.0)),
            _beyond("∞", crossed(10.0, roller=np.inf)),
        ],
        ("R_w / R_r − 1", "> 0"): [
            *(against_finer(f"{ratio:g}", conformal(10.0, ratio)) for ratio in (1e-4, 1e-3, 9.0)),
            with_c("0.001, C", conformal(10.0, 1e-3)),
            _beyond("0", conformal(10.0, 0.0)),
            _leaves("-0.01", conformal(10.0, -0.01)),
        ],
        ("patch aspect a/b", "any"): [
            against_hertz("1/46", crossed(10.0, crown=1e4, roller=20.0)),
            against_hertz("46", crossed(10.0, crown=20.0, roller=1e4)),
        ],
        ("elements across", "8 … 64"): [
            *(against_hertz(str(count), crossed(100.0, elements=count)) for count in (8, 64)),
            *(_beyond(str(count), crossed(100.0, elements=count)) for count in (7, 65)),
        ],
        ("element aspect dx/ds", "0.01 … 100"): [
            *(against_hertz(f"{aspect:g}", _elements(aspect)) for aspect in (0.05, 20.0)),
            _beyond("200", _elements(200.0)),
        ],
        ("patches", "1, 2, …"): [
            _two_patches("2, far apart, on a given grid"),
            _two_patches("2, far apart, on an automatic grid", automatic=True),
            _on_waves("waves of 6 µm under a groove", 3e-3),
            _on_waves("waves of 2 µm under a groove", 1e-3),
        ],
        ("units, sides, names", "any"): _invariances(),
    }
    return contact_limits(CONTACT, table)


def against_hertz(label: str, changes: Changes, base: str = "flat") -> ContactCase:
    """Return a case whose truth is Hertz."""

    def hertz(solved: ContactSolution) -> dict[str, float]:
        exact = hertz_contact(solved.problem)
        return {name: float(getattr(exact, name)) for name in SHAPE}

    return ContactCase(label, base, changes, press, Truth("Hertz", hertz))


def against_finer(label: str, changes: Changes, base: str = "geometry1") -> ContactCase:
    """Return a case whose truth is the same contact on elements four times smaller."""
    return ContactCase(label, base, changes, press, finer(*SHAPE, "area"))


def with_c(label: str, changes: Changes) -> ContactCase:
    """Return a conformal case with C, whose truth has a finer C on elements half as large."""
    contact = {**changes["contact"], "ics": ["C"]}
    coarse = {**changes, "contact": {**contact, "elements": COARSE}}
    fine = {
        "contact": {**contact, "elements": FINE},
        "engine": {**changes["engine"], "tolerance": FINE_TOLERANCE},
    }
    fine = {**changes, **fine}
    other = ContactCase(label, "geometry1", fine, press, finer(*SHAPE))
    truth = same_as("a finer C", other, dict.fromkeys(SHAPE, 1.0))
    return ContactCase(label, "geometry1", coarse, press, truth)


def _beyond(label: str, changes: Changes, base: str = "") -> BeyondContact:
    return BeyondContact(label, base or base_scene(changes), changes, press)


def _leaves(label: str, changes: Changes, base: str = "") -> BeyondContact:
    """Return a case whose contact grows beyond the ends of its contours, which its solution shows."""
    return replace(_beyond(label, changes, base), also=(PotentialAreaTooSmall,))


def _tall(load: float) -> Changes:
    return {"contact": {"loads": [load], "ics": ["Bhat"]}}


def _both(changes: Changes) -> dict[str, Changes]:
    """Return the same changes of both bodies."""
    return {"lower": changes, "upper": changes}


def _elements(aspect: float) -> Changes:
    """Return a circular contact on a grid whose elements are longer or shorter than wide.

    Eight of their longer sides are across the patch.
    """
    changes = crossed(100.0, crown=500.0, roller=500.0, grid="scene")
    size, room = 1.45, 2.0  # mm: of the patch; of the grid over it
    longer, shorter = size / 8, size / 8 / max(aspect, 1 / aspect)
    dx, ds = (longer, shorter) if aspect > 1 else (shorter, longer)
    n_x, n_s = (min(8 * round(room * size / step / 8), 512) for step in (dx, ds))
    return {**changes, "rotation_reach": 5.0, "grid": {"n_x": n_x, "n_s": n_s, "dx": dx, "ds": ds}}


def _two_patches(label: str, *, automatic: bool = False) -> ContactCase:
    """Return two equal patches side by side, each a Hertz contact that the other one pushes down a little.

    Far apart, as points: approach + half of the load / (pi E* distance).
    """

    def truth(solved: ContactSolution) -> dict[str, float]:
        one = hertz_bump(solved.problem)
        pushed = 1 / (np.pi * one.surfaces.modulus * APART)  # mm/N
        return {
            **{name: float(getattr(one, name)) for name in ("p_max", "a", "b")},
            "approach": one.approach + pushed * one.load,
            "stiffness": 2 / (1 / one.stiffness + pushed),
        }

    changes = bumps(automatic=automatic)
    return ContactCase(label, "flat", changes, press, Truth("two of Hertz", truth), two_bumps())


def _on_waves(label: str, depth: float) -> ContactCase:
    """Return a conformal contact that waves on the rail divide into patches side by side."""
    s = np.linspace(-5.0, 5.0, 201)
    waves = Profile(s, depth * (1 - np.cos(np.pi * s)))
    return replace(against_finer(label, conformal(2e3, 0.01, elements=40)), gap=waves)


def _invariances() -> list[ContactCase]:
    """Return contacts that must be others times a factor: other units, mirrored, with bodies exchanged."""
    cases = []
    for unit in (0.04, 1e6):  # lengths are larger by a factor, the load by its square: the same stresses
        changes = crossed(100.0 * unit**2, crown=300.0 * unit, roller=500.0 * unit)
        factors = {"p_max": 1.0, "a": unit, "b": unit, "approach": unit, "stiffness": unit}
        truth = same_as("the same in mm", against_hertz("", crossed(100.0)), factors)
        cases.append(ContactCase(f"lengths times {unit:g}", "flat", changes, press, truth))
    same = dict.fromkeys((*SHAPE, "area"), 1.0)
    here, there = (
        conformal(1e3, 0.02, flanks=flanks, shift=shift)
        for flanks, shift in (([60.0, 45.0], 0.1), ([45.0, 60.0], -0.1))
    )
    factors = {**same, "F_y": -1.0, "M_x": -1.0, "s_centre": -1.0}
    truth = same_as("its mirror image", against_finer("", there), factors)
    cases.append(ContactCase("away from the crown", "geometry1", here, press, truth))
    one, other = {"E": 70e3, "nu": 0.33}, {"E": 210e3, "nu": 0.28}
    here, there = (
        crossed(100.0, bodies={"lower": lower, "upper": upper})
        for lower, upper in ((one, other), (other, one))
    )
    truth = same_as("materials exchanged", against_hertz("", there), same)
    return [*cases, ContactCase("aluminium and steel", "flat", here, press, truth)]
