"""Statements 46 to 48: planar contact, narrow peaks, all patches of a wheel on its rail.

Planar contact is compared with the program CONTACT, with Hertz along the normal, and with A on the curved
surface; narrow peaks with smaller elements; several patches with one grid over all of them, and with contacts
of Hertz under one approach.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from approx.pair import Pair, Solid
from compare.report.charts import Panel, make_curves
from compare.report.looks import ics_symbol
from compare.validation.statements.closed_forms import CONE_LOAD, RADIUS, STEEL, Cone, on_grid
from compare.validation.statements.frame import Statement, Values, above, below
from compare.validation.statements.runs import Runs, solved_once
from femic.contact.estimates import Measured, errors
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.pairs.area_grids import Box, Sought, find_patches, fitting_grids, refined_grids
from femic.contact.pairs.areas import Areas, AreasContact
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.planar import PlanarContact, planar, solve_planar
from femic.contact.pairs.quantities import ALL, kinds, measured
from femic.contact.undeformed import Undeformed
from femic.shifts.sides import Place, bodies_at, contact_problem, lay_out_wheelset
from femic.shifts.specification import EXAMPLE, ContactTable, load_shifts
from geometries.arrays import Array
from geometries.patches import Grid
from geometries.profiles.pieces import ArcPiece, Outline, arc_above, line
from geometries.profiles.placement import contour_at
from geometries.surfaces import LOWER, UPPER, Surface
from geometries.track.wheelset import settle

ICS = ("A", "Bhat")
ELEMENTS, MOST_STRIPS = 20, 1024  # across the main patch, and of a grid, as by default

LOAD = 90e3  # N, of S1002 on 60E1
TOUCHING_A_JUMP, ON_FLANGE = 6.5, 7.0  # shifts [mm]
P_MAX, LATERAL = 2087.0, 238.5e3  # MPa and N there: the program CONTACT, planar, by an outside reader
SLOPES = (1 / 20, -1 / 10)  # of cones
LARGE, SMALL = 8e5, 1e5  # N: with an eighth of the load a patch is half as wide

SHARP, ROUND = 1.0, 12.0  # radii [mm] beside the place where a rail's curvature jumps to 1/200
KINKED_LOAD = 20e3  # N
UNREFINED = "without refined elements"
FINER = {"elements 2 times smaller": (2, 2), "strips 4 times narrower": (1, 4)}  # along x and s

ARC, TREAD, FLANGE = 80.0, 0.05, -0.5  # radius of a rail [mm], inclinations of a wheel of two cones [rad]
TWO_LOAD, ROLLS = 20e3, (0.0, 0.03)  # N; angles of the load to the z axis [rad]
BOTH = Grid(40, 256, 0.4, 0.2, -22.0)  # over both patches

CONTACT_TOLERANCE = 0.005  # of the p_max of CONTACT
HERTZ_TOLERANCE = 0.005  # elements of a twentieth of the patch; a patch is 3 % of the rail's radius wide
ORDER_TOLERANCE = 0.05
LACKS = 0.02  # of p_max, at least, without refined elements: they are refined until this is not lacking
SAME = 2e-3  # nodes and point forces of the coupling between areas leave 1e-3
LOAD_TOLERANCE = 1e-6


# --- contacts -------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Wheel:
    """A wheel on its rail under a load [N] at an angle `roll` [rad], with the grids of `femic shifts`."""

    bodies: PairOnGrid
    load: float
    roll: float = 0.0

    @cached_property
    def found(self) -> tuple[list[Box], Sought]:
        """The patches on coarse grids, and the approach."""
        return find_patches(self.bodies, "Bhat", self.load, self.roll)

    @cached_property
    def grids(self) -> tuple[Grid, ...]:
        """The grids, with strips as narrow as the distance needs."""
        return refined_grids(self.bodies, *self.found, ELEMENTS)

    def solve(self, ics: str, grids: Sequence[Grid] | None = None) -> AreasContact:
        """Return the contact on the grids, or on others."""
        areas = Areas.with_approximation(ics, self.bodies, grids or self.grids, self.roll)
        return areas.solve(self.load, self.found[1].approach)


def standard_wheel(shift: float) -> Wheel:
    """Return S1002 on 60E1, the left wheel at a shift of the wheelset at the rails [mm]."""
    file = load_shifts(EXAMPLE)[2]
    layout = lay_out_wheelset(file)
    place = Place(layout, settle(layout, shift, roll="about rails"), "left")
    problem = contact_problem(bodies_at(place, file.rail, file.wheel), ContactTable(load=LOAD, ics=ICS))
    return Wheel(pair_on_grid(problem, problem.grid), LOAD, place.roll)


def outlines(rail: Outline, wheel: Outline, at: tuple[float, float], s: tuple[float, float]) -> PairOnGrid:
    """Return a wheel on a rail that touch at arc lengths of both, and may do so in a range [mm] about it."""
    above = Surface(UPPER, contour_at(wheel, at[1]), RADIUS)
    below = Surface(LOWER, contour_at(rail, at[0]))
    pair = Pair(Solid(STEEL, above), Solid(STEEL, below))
    return PairOnGrid(pair, Undeformed(above, below, s), Grid(8, 8, 1.0, 1.0))


def kinked(radius: float = ROUND) -> PairOnGrid:
    """Return a rail whose curvature jumps from 1/radius to 1/200 where a hollow tread touches it."""
    steep = ArcPiece((-radius * np.sin(1.0), radius * (np.cos(1.0) - 1)), -1.0, 1 / radius, radius)
    rail = Outline((steep, ArcPiece((0.0, 0.0), 0.0, 1 / 200, 25.0)))
    tread = ArcPiece((-210 * np.sin(0.12), 210 - 210 * np.cos(0.12)), 0.12, -1 / 210, 420 * 0.12)
    return outlines(rail, Outline((tread,)), (radius, 210 * 0.12), (-radius * 2 / 3, 20.0))


def _on_arc(delta: float) -> tuple[float, float]:
    """Return the point (y, z) [mm] of the rail's arc with an inclination [rad]."""
    return float(ARC * np.sin(delta)), float(ARC * (np.cos(delta) - 1))


def two_cones() -> PairOnGrid:
    """Return a wheel of two cones, tread and flange, of which both touch the arc of a rail."""
    (y, z), (y_f, z_f) = _on_arc(TREAD), _on_arc(FLANGE)
    slope, slope_f = -np.tan(TREAD), -np.tan(FLANGE)
    root = (z_f - z + slope * y - slope_f * y_f) / (slope - slope_f)  # where both lines meet
    corner = (float(root), float(z + slope * (root - y)))
    flange = line((-60.0, float(z_f + slope_f * (-60.0 - y_f))), corner)
    tread = line(corner, (40.0, float(z + slope * (40.0 - y))))
    rail = arc_above((0.0, -ARC), ARC, (-70.0, 50.0))
    at = ARC * (TREAD - rail.start_inclination), flange.length + float(np.hypot(y - corner[0], z - corner[1]))
    return outlines(Outline((rail,)), Outline((flange, tread)), at, (-65.0, 45.0))


def estimated_error(contact: AreasContact, name: str) -> float:
    """Return the estimated error of a number: the sum of those of all areas."""
    quantity, total = {name: ALL[name]}, 0.0
    level: AreasContact | None
    for k in range(len(contact.contacts)):
        levels, level = list[Measured](), contact
        while level is not None and len(levels) < 3:
            levels.append(measured(level.areas.on_grids[k], level.contacts[k], quantity))
            level = level.coarser
        total += errors(kinds(quantity), levels[0], levels[1:])[name]
    return total


def p_max(contact: AreasContact | PlanarContact) -> float:
    """Return the largest pressure [MPa]."""
    areas = (
        [patch.contact for patch in contact.patches]
        if isinstance(contact, PlanarContact)
        else contact.contacts
    )
    return max(float(np.max(area.p)) for area in areas)


def on_centre_line(contact: AreasContact) -> tuple[Array, Array]:
    """Return arc lengths [mm] and pressures [MPa] of the strips of all areas beside x = 0."""
    parts = [(on_grid.grid.strips, pressed.p[on_grid.grid.n_x // 2]) for on_grid, pressed in contact.parts]
    s, p = (np.concatenate(each) for each in zip(*parts, strict=True))
    return s, p


# --- 46 -------------------------------------------------------------------------------------------------


@solved_once(f"planar contact of S1002 on 60E1 at {TOUCHING_A_JUMP:g} mm")
def planar_wheel(_: Runs) -> PlanarContact:
    """Return the planar contact where the curvature jumps."""
    wheel = standard_wheel(TOUCHING_A_JUMP)
    return solve_planar(wheel.bodies, LOAD, elements=ELEMENTS, roll=wheel.roll)


@below(CONTACT_TOLERANCE, "CONTACT", "|p_max over that of CONTACT (2087 MPa) - 1|")
def _over_contact(runs: Runs) -> Values:
    return {"S1002 on 60E1, 6.5 mm": abs(p_max(planar_wheel(runs)) / P_MAX - 1)}


def planar_lateral(_: Runs) -> Values:
    """Return the difference of the lateral force on a flange from that of CONTACT, as a share."""
    wheel = standard_wheel(ON_FLANGE)
    patches = solve_planar(wheel.bodies, LOAD, elements=ELEMENTS, roll=wheel.roll).patches
    force = sum(patch.normal_force * np.sin(patch.plane.angle - wheel.roll) for patch in patches)
    return {"S1002 on 60E1, 7 mm: lateral force over CONTACT's - 1": float(abs(force) / LATERAL - 1)}


@below(
    HERTZ_TOLERANCE,
    "Hertz",
    "cones, half-width of 0.2 % of the rail's radius: |p_max or approach over Hertz's - 1|",
)
def _planar_over_hertz(_: Runs) -> Values:
    measured = {}
    for slope in SLOPES:
        cone = Cone(float(np.arctan(slope)))
        contact, exact = solve_planar(on_grid(cone), CONE_LOAD, elements=ELEMENTS), cone.ellipse
        along = contact.approach * np.cos(cone.delta)
        measured[f"cone {slope:+g}, p_max"] = abs(p_max(contact) / exact.p_max - 1)
        measured[f"cone {slope:+g}, approach"] = abs(float(along) / exact.approach - 1)
    return measured


@below(
    ORDER_TOLERANCE,
    "order",
    "cones, half-widths of 3.6 and 1.8 % of the radius: |order of (planar over A - 1) - 2|",
)
def _planar_order(_: Runs) -> Values:
    """Measure p_max where the contact is level, the lateral force where it is not.

    Beside the crown edges lie otherwise on both grids, which p_max shows.
    """

    def planar_over_curved(cone: Cone, load: float) -> float:
        bodies, larger = on_grid(cone), (load / CONE_LOAD) ** (1 / 3)
        grid = replace(bodies.grid, dx=bodies.grid.dx * larger, ds=bodies.grid.ds * larger)
        curved = replace(bodies, grid=grid)
        flat = replace(planar(curved, cone.s), grid=replace(grid, s=0.0))
        one, other = (each.solve(each.flat, Loading(load)) for each in (flat, curved))
        if cone.delta == 0:
            return float(np.max(one.normal.p) / np.max(other.normal.p) - 1)
        return one.lateral_force / other.lateral_force - 1

    orders = {}
    for slope in (0.0, *SLOPES):
        large, small = (planar_over_curved(Cone(float(np.arctan(slope))), load) for load in (LARGE, SMALL))
        name = "F_y" if slope else "p_max"
        orders[f"cone {slope:+g}, {name}"] = abs(float(np.log2(large / small)) - 2)
    return orders


def _planar_panels(runs: Runs) -> list[Panel]:
    s, p = on_centre_line(standard_wheel(TOUCHING_A_JUMP).solve("A"))
    (patch,) = planar_wheel(runs).patches
    grid = patch.on_grid.grid
    on_rail = patch.plane.lower_arc_length(grid.strips)
    known = np.isfinite(on_rail)
    in_plane = np.interp(s, on_rail[known], patch.contact.p[grid.n_x // 2][known])
    curves = make_curves(s, {"A": p, "planar": in_plane})
    return [Panel("S1002 on 60E1, 6.5 mm, 90 kN", "s  [mm]", "p_n  [MPa]", curves)]


# --- 47 -------------------------------------------------------------------------------------------------


@solved_once("narrow peaks")
def peaks(_: Runs) -> Mapping[str, Mapping[str, AreasContact]]:
    """Return contacts of rails whose curvature jumps where a wheel touches them, by their grids.

    "default", without refined elements, and with smaller ones than by default.
    """
    contacts = {}
    for radius in (SHARP, ROUND):
        wheel = Wheel(kinked(radius), KINKED_LOAD)
        grids: dict[str, Sequence[Grid]] = {
            "default": wheel.grids,
            UNREFINED: fitting_grids(wheel.bodies, wheel.found[0], ELEMENTS, MOST_STRIPS),
        }
        for label, (x, s) in FINER.items():
            grids[label] = [
                replace(grid, n_x=grid.n_x * x, n_s=grid.n_s * s, dx=grid.dx / x, ds=grid.ds / s)
                for grid in wheel.grids
            ]
        for ics in ICS:
            name = f"{radius:g} mm beside 200 mm, {ics_symbol(ics)}"
            contacts[name] = {label: wheel.solve(ics, each) for label, each in grids.items()}
    return contacts


@below(1.0, "within", "change of p_max by smaller elements over its estimated error")
def _peaks_within(runs: Runs) -> Values:
    measured = {}
    for name, by_grid in peaks(runs).items():
        default = by_grid["default"]
        for label in FINER:
            change = abs(p_max(by_grid[label]) - p_max(default))
            measured[f"{name}, {label}"] = change / estimated_error(default, "p_max")
    return measured


@above(LACKS, "unrefined", "share of p_max that 20 elements across the patch lack")
def _unrefined(runs: Runs) -> Values:
    return {
        name: 1 - p_max(by_grid[UNREFINED]) / p_max(by_grid["default"])
        for name, by_grid in peaks(runs).items()
        if name.startswith(f"{SHARP:g} mm")
    }


def _peak_details(runs: Runs) -> Values:
    return {
        f"{name}: p_max {'by default' if label == 'default' else label} [MPa]": p_max(contact)
        for name, by_grid in peaks(runs).items()
        for label, contact in by_grid.items()
    }


def _peak_panels(runs: Runs) -> Iterator[Panel]:
    for name, by_grid in peaks(runs).items():
        lines = {label: on_centre_line(by_grid[label]) for label in (*FINER, "default", UNREFINED)}
        s = np.unique(np.concatenate([places for places, _ in lines.values()]))
        curves = make_curves(s, {label: np.interp(s, *line) for label, line in lines.items()})
        yield Panel(f"radius of {name}", "s  [mm]", "p_n  [MPa]", curves)


# --- 48 -------------------------------------------------------------------------------------------------


@solved_once("two patches")
def two_patches(_: Runs) -> Mapping[float, AreasContact]:
    """Return contacts of a wheel of two cones with A on the default grids, by the angle of the load."""
    return {roll: Wheel(two_cones(), TWO_LOAD, roll).solve("A") for roll in ROLLS}


def patch_forces(contact: AreasContact) -> Array:
    """Return forces [N] along y and z on flange and tread, with normals of the rail's circle, (2, 2)."""
    forces = np.zeros((2, 2))
    for grid, pressed in zip(contact.areas.grids, contact.contacts, strict=True):
        delta, on_strips = TREAD + grid.strips / ARC, np.sum(pressed.p, axis=0) * grid.area
        place = 1 if grid.s > ARC * (FLANGE - TREAD) / 2 else 0
        forces[:, place] += np.sum(on_strips * [np.sin(delta), np.cos(delta)], axis=1)
    return forces


def two_points(roll: float) -> tuple[Array, float]:
    """Return the normal forces [N] of flange and tread, and the approach [mm]: Hertz at both points.

    Each comes nearer by zeta cos(delta - roll), less the displacement of the half-space by the other force at
    their distance along the rail.
    """
    deltas, modulus = np.array([FLANGE, TREAD]), combined_modulus(STEEL, STEEL)
    circles = [RADIUS + _on_arc(TREAD)[1] - _on_arc(delta)[1] for delta in deltas]
    points = [
        PointContact(float(np.cos(delta)) / circle, 1 / ARC, modulus)
        for delta, circle in zip(deltas, circles, strict=True)
    ]
    cosine, per_force = np.cos(deltas - roll), 1 / (np.pi * modulus * ARC * (TREAD - FLANGE))

    def forces(zeta: float) -> Array:
        found = np.zeros(2)
        for _ in range(30):  # the other force counts for two percent
            near = zeta * cosine - per_force * found[::-1]
            found = np.array([point.at_approach(z).load for point, z in zip(points, near, strict=True)])
        return found

    zeta = scipy.optimize.brentq(lambda z: float(forces(z) @ cosine) - TWO_LOAD, 1e-3, 1.0, xtol=1e-9)
    return forces(zeta), float(zeta)


@below(
    HERTZ_TOLERANCE,
    "Hertz",
    "two cones: |force of a patch, or approach, over that of two contacts of Hertz - 1|",
)
def _over_two_of_hertz(runs: Runs) -> Values:
    differences: dict[str, float] = {}
    for roll, contact in two_patches(runs).items():
        exact, approach = two_points(roll)
        own, case = np.hypot(*patch_forces(contact)), f"load at {roll:g} rad"
        numbers = zip(("flange", "tread"), own, exact, strict=True)
        differences |= {f"{case}, {name}": abs(float(one / other) - 1) for name, one, other in numbers}
        differences[f"{case}, approach"] = abs(contact.approach / approach - 1)
    return differences


@below(LOAD_TOLERANCE, "load", "two cones: |sum of all forces over the load - 1|")
def _over_load(runs: Runs) -> Values:
    return {
        f"load at {roll:g} rad": abs(
            float(np.array([np.sin(roll), np.cos(roll)]) @ patch_forces(contact).sum(axis=1)) / TWO_LOAD - 1
        )
        for roll, contact in two_patches(runs).items()
    }


@solved_once("one grid and two areas")
def one_grid(_: Runs) -> Mapping[str, tuple[AreasContact, AreasContact]]:
    """Return the contact on one grid over both patches, and on the same cut in two, by ICs."""
    wheel, half = Wheel(two_cones(), TWO_LOAD), BOTH.n_s // 2
    middles = (float(np.mean(BOTH.strips[:half])), float(np.mean(BOTH.strips[half:])))
    halves = [replace(BOTH, n_s=half, s=middle) for middle in middles]
    return {ics: (wheel.solve(ics, [BOTH]), wheel.solve(ics, halves)) for ics in ICS}


@below(SAME, "one grid", "two areas and one grid: difference over p_max, or over the approach")
def _one_grid_or_two(runs: Runs) -> Values:
    differences: dict[str, float] = {}
    for ics, (one, two) in one_grid(runs).items():
        p, parts = one.contacts[0].p, np.concatenate([each.p for each in two.contacts], axis=1)
        differences[f"{ics_symbol(ics)}, pressures"] = float(np.max(np.abs(p - parts)) / np.max(p))
        differences[f"{ics_symbol(ics)}, approach"] = abs(two.approach / one.approach - 1)
    return differences


@above(1.0, "second patch", "change of F_y without the second patch over its estimated error")
def _without_second_patch(runs: Runs) -> Values:
    effects = {}
    for roll, contact in two_patches(runs).items():
        main = contact.areas.grids[int(np.argmax([np.sum(each.p) for each in contact.contacts]))]
        alone = Wheel(two_cones(), TWO_LOAD, roll).solve("A", [main])
        change = abs(float(patch_forces(contact)[0].sum() - patch_forces(alone)[0].sum()))
        effects[f"load at {roll:g} rad"] = change / estimated_error(contact, "F_y")
    return effects


def _patch_panels(runs: Runs) -> Iterator[Panel]:
    for ics, (one, two) in one_grid(runs).items():
        (s, p), (_, parts) = on_centre_line(one), on_centre_line(two)
        curves = make_curves(s, {"one grid": p, "two areas": parts})
        yield Panel(f"two cones on a rail, 20 kN, {ics_symbol(ics)}", "s  [mm]", "p_n  [MPa]", curves)


STATEMENTS = (
    Statement(
        46,
        "Planar contact agrees with the planar program CONTACT within 0.5 % of p_max on S1002 on 60E1, with "
        "Hertz along the normal where patches are small, and tends to A on the curved surface with the "
        "square of the half-width.",
        (_over_contact, _planar_over_hertz, _planar_order),
        _planar_panels,
        planar_lateral,
        columns=1,
    ),
    Statement(
        47,
        "Where the rail's curvature jumps at the touching point, p_max on the default grid agrees with p_max "
        "on smaller elements within its estimated error; beside a radius of 1 mm a grid that is not refined "
        "lacks more than 2 % of it.",
        (_peaks_within, _unrefined),
        _peak_panels,
        _peak_details,
    ),
    Statement(
        48,
        "All patches of a wheel carry its load under one approach: two areas give what one grid over both "
        "patches gives, forces are those of two contacts of Hertz, and omitting the second patch changes "
        "F_y by more than its estimated error.",
        (_one_grid_or_two, _over_two_of_hertz, _over_load, _without_second_patch),
        _patch_panels,
    ),
)
