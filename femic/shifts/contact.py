"""The contact of one wheel and its rail in a position of the wheelset, without friction, with several ICs.

All patches of the wheel are solved under one approach, with the distance of the displaced profiles
(`femic.contact.pairs.areas`): the wheel comes down perpendicular to the track until they carry the load. Of
each patch are known what it carries, where it lies, and its outline.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from femic.contact.estimates import Measured, Numbers, changes, errors
from femic.contact.exact.hertz import combined_modulus
from femic.contact.normal import NormalContact
from femic.contact.pairs.area_grids import (
    Sought,
    find_patches,
    fitting_grid,
    longer,
    refine,
    refined_grids,
)
from femic.contact.pairs.areas import NO_COUPLING, Areas, AreasContact, AreaTooSmall
from femic.contact.pairs.ics import normal_reference_ics
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.planar import PLANAR, PlanarContact, PlanarPatch, solve_planar
from femic.contact.pairs.quantities import ALL, kinds, lacking, measured, numbers
from femic.contact.patch import Extent
from femic.contact.supports import other_supports
from femic.contact.undeformed import Undeformed
from femic.reference.run_options import DEFAULT, RunOptions
from femic.shifts.sides import ContactRequest, Place, bodies_at, problem_of
from femic.shifts.specification import C, ProfileTable
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid
from geometries.profiles.placement import STEEPEST
from geometries.profiles.rounding import peak_slope

# --- the contact with all ICs ---

SIZING = "Bhat"  # the ICs that size grids
C_FLANK = float(np.radians(60.0))  # steeper ones are pillars that bend under lateral forces
C_STRIPS = 160  # of the one grid over all patches with C
MOST_TRIES = 20  # grids
ESTIMATED = {name: ALL[name] for name in ("p_max", "F_y", "a", "b", "angle", "approach", "load")}
OF_PLANE = {name: ALL[name] for name in ("p_max", "a", "b")}


@dataclass(frozen=True, eq=False)
class PatchNumbers:
    """A patch: force [N] along its normal, share of the vertical load, largest pressure [MPa], area [mm^2].

    `angle` [rad] is the contact angle to the track plane, positive on a flange, the mean weighted with
    pressures. `centre` [mm] is the mean arc length of the rail's profile weighted so, `s` the range, and
    `half_length` that along x. `outline` are arc lengths of the rail and half-lengths along x [mm], (2, n).
    """

    normal_force: float
    share: float
    p_max: float
    angle: float
    centre: float
    s: tuple[float, float]
    half_length: float
    area: float
    outline: Array


@dataclass(frozen=True, eq=False)
class ICsNumbers:
    """The contact with some ICs: pressures in MPa, lengths in mm, forces in N, angle in degrees.

    `vertical` and `lateral` are forces on the wheel in axes of the track, the latter positive towards its
    middle. `angle` is the change of the rail's inclination across the main patch, a and b its half-lengths.
    `patches` are all patches by growing arc length of the rail.
    """

    ics: str
    p_max: float
    estimate_p_max: float
    approach: float
    vertical: float
    lateral: float
    estimate_lateral: float
    angle: float
    a: float
    b: float
    seconds: float
    patches: tuple[PatchNumbers, ...]


@dataclass(frozen=True, eq=False)
class SideContact:
    """The contact of a side with all ICs, on the same grids; sentences about what was left out.

    `steepest` [rad] is the inclination at which the bodies end in flanks.
    """

    numbers: tuple[ICsNumbers, ...]
    grids: tuple[Grid, ...]
    notes: tuple[str, ...] = ()
    steepest: float = STEEPEST


def contact_at(
    place: Place,
    rail: ProfileTable,
    wheel: ProfileTable,
    request: ContactRequest,
    options: RunOptions = DEFAULT,
) -> SideContact:
    """Return the contact of a side in a position with all ICs. Raises Failure and WrongInput.

    C and the planar contact are left out, with a sentence, where they have no solution.
    """
    names = tuple(name for name in request.ics if name != C) or (SIZING,)
    bodies = bodies_at(place, rail, wheel)
    pair, sought, contacts = _on_fine_grids(place, bodies, request, names)
    rows = tuple(
        replace(_numbers(place, name, contact), seconds=seconds)
        for name, (contact, seconds) in contacts.items()
    )
    first, _ = next(iter(contacts.values()))
    solved = SideContact(
        rows, first.areas.grids, _fineness_notes([contact for contact, _ in contacts.values()])
    )
    if C in request.ics or _turns_far(rows, request):
        try:
            solved = _with_c(place, rail, wheel, replace(request, ics=(*names, C)), options)
        except Failure as failure:
            solved = replace(solved, notes=(*solved.notes, f"C is left out: {failure}"))
    if not request.planar:
        return solved
    try:
        start = perf_counter()
        planar = solve_planar(
            pair, request.load, elements=request.elements, roll=place.roll, about=sought.approach
        )
    except (Failure, WrongInput) as error:
        return replace(solved, notes=(*solved.notes, f"planar contact is left out: {error}"))
    row = _planar_numbers(place, planar, perf_counter() - start)
    return replace(solved, numbers=(*solved.numbers, row))


def _turns_far(rows: Sequence[ICsNumbers], request: ContactRequest) -> bool:
    """Whether the rail's inclination changes by more across a patch than C is asked for."""
    return request.c_above_deg is not None and max(row.angle for row in rows) > request.c_above_deg


def _on_fine_grids(
    place: Place, bodies: dict[str, Body], request: ContactRequest, names: Sequence[str]
) -> tuple[PairOnGrid, Sought, dict[str, tuple[AreasContact, float]]]:
    """Return rail and wheel, the contact sought, and those with all ICs on the same grids, with seconds."""
    problem = problem_of(bodies, request, request.load)
    pair = pair_on_grid(problem, problem.grid)
    boxes, sought = find_patches(pair, SIZING, request.load, place.roll)
    grids = refined_grids(pair, boxes, sought, request.elements)
    for _ in range(MOST_TRIES):
        areas = [Areas.with_approximation(name, pair, grids, place.roll) for name in names]
        try:
            solved = [_timed(each, request.load, sought.approach) for each in areas]
            return pair, sought, dict(zip(names, solved, strict=True))
        except AreaTooSmall as short:
            grids = tuple(longer(areas[0], short))
    raise Failure(f"load = {request.load:g} N: no grids found that fit all ICs; take fewer elements")


def _timed(areas: Areas, load: float, about: float) -> tuple[AreasContact, float]:
    """Return a contact and the seconds of its solution."""
    start = perf_counter()
    return areas.solve(load, about), perf_counter() - start


def _fineness_notes(contacts: Sequence[AreasContact]) -> tuple[str, ...]:
    """Return a sentence where the finest grid does not resolve the distance of the profiles."""
    shares = [
        lacking(on_grid, pressed) / _p_max(contact)
        for contact in contacts
        for on_grid, pressed in contact.parts
    ]
    if max(shares) == 0:
        return ()
    return (
        "the curvature of the profiles changes within less than a strip of the finest grid: the estimated "
        f"error of p_max contains {100 * max(shares):.2g} % for that",
    )


# --- numbers with their errors ---


def _numbers(
    place: Place,
    name: str,
    contact: AreasContact,
    *,
    others: Sequence[AreasContact] = (),
    further: float = 0.0,
) -> ICsNumbers:
    """Return the numbers of a contact; changes by `others`, and `further` [MPa], add to estimated errors."""
    lateral, vertical = place.in_track(contact.force)
    patches = [
        patch
        for on_grid, pressed in contact.parts
        for patch in patches_on_grid(place, on_grid, pressed, vertical)
    ]
    main = max(range(len(contact.contacts)), key=lambda k: _largest_share(contact, k))
    own = numbers(contact.areas.on_grids[main], contact.contacts[main], ESTIMATED)
    known = [_errors(contact, k, others) for k in range(len(contact.contacts))]
    p_max = [float(np.max(pressed.p)) for pressed in contact.contacts]
    rounded = [_by_rounding(place, on_grid, pressed) for on_grid, pressed in contact.parts]
    uppermost = max(p + each["p_max"] + more for p, each, more in zip(p_max, known, rounded, strict=True))
    highest = int(np.argmax(p_max))
    return ICsNumbers(
        name,
        max(p_max),
        max(known[highest]["p_max"] + rounded[highest], uppermost - max(p_max)) + further,
        contact.approach,
        vertical,
        -lateral,
        float(sum(each["F_y"] for each in known)),
        own["angle"],
        own["a"],
        own["b"],
        np.nan,
        tuple(sorted(patches, key=lambda patch: patch.centre)),
    )


def _by_rounding(place: Place, on_grid: PairOnGrid, pressed: NormalContact) -> float:
    """Return what the last decimals of the profiles' files may change p_max of an area by [MPa].

    Source: `geometries.profiles.rounding`; 0 of the curves of standards.
    """
    if not pressed.in_contact.any():
        return 0.0
    grid, side = on_grid.grid, place.layout.side(place.side)
    strip = int(np.argmax(np.max(pressed.p, axis=0)))
    half_width = max(float(np.count_nonzero(pressed.in_contact.any(axis=0))) * grid.ds / 2, grid.ds)
    at = float(grid.strips[strip])
    on_wheel = on_grid.undeformed.opposite(at) if isinstance(on_grid.undeformed, Undeformed) else at
    slopes = [
        peak_slope(curve.curve, float(np.clip(s, 0.0, curve.curve.length)), half_width, grid.ds)
        for curve, s in (
            (side.rail, place.touch.s_rail + at),
            (side.wheel, place.touch.s_wheel + float(on_wheel)),
        )
    ]
    modulus = combined_modulus(on_grid.pair.upper.material, on_grid.pair.lower.material)
    return modulus / 2 * float(np.linalg.norm(slopes))


def _largest_share(contact: AreasContact, number: int) -> float:
    """Return the largest force [N] along its normals of a patch of an area."""
    pressed, grid = contact.contacts[number], contact.areas.grids[number]
    return max((float(np.sum(pressed.p[patch.elements])) * grid.area for patch in pressed.patches), default=0)


def _errors(contact: AreasContact, number: int, others: Sequence[AreasContact]) -> dict[str, float]:
    """Return estimated errors of an area's numbers, from elements twice and four times as large."""
    levels, level = list[Measured](), contact if contact.contacts[number].in_contact.any() else None
    while level is not None and len(levels) < 3 and level.contacts[number].in_contact.any():
        levels.append(measured(level.areas.on_grids[number], level.contacts[number], ESTIMATED))
        level = level.coarser
    if not levels:
        return dict.fromkeys(ESTIMATED, 0.0)
    of_all = kinds(ESTIMATED)
    parts: list[Numbers] = [
        changes(levels[0], of_all, numbers(other.areas.on_grids[number], other.contacts[number], ESTIMATED))
        for other in others
    ]
    return errors(of_all, levels[0], levels[1:], parts)


def _planar_numbers(place: Place, planar: PlanarContact, seconds: float) -> ICsNumbers:
    """Return the numbers of the planar contact; in its plane a patch does not turn."""
    angles = [place.roll - patch.plane.angle for patch in planar.patches]
    forces = [patch.normal_force for patch in planar.patches]
    vertical = float(np.dot(forces, np.cos(angles)))
    patches = [own for patch in planar.patches for own in planar_patches(place, patch, vertical)]
    main = max(patches, key=lambda patch: patch.normal_force)
    highest = max(planar.patches, key=lambda patch: float(np.max(patch.contact.p)))
    levels, contact = [measured(highest.on_grid, highest.contact, OF_PLANE)], highest.contact.coarser
    while contact is not None and len(levels) < 3:
        levels.append(measured(highest.on_grid, contact, OF_PLANE))
        contact = contact.coarser
    known = errors(kinds(OF_PLANE), levels[0], levels[1:])
    return ICsNumbers(
        PLANAR,
        float(np.max(highest.contact.p)),
        known["p_max"],
        planar.approach,
        vertical,
        float(np.dot(forces, np.sin(angles))),
        np.nan,
        0.0,
        main.half_length,
        (main.s[1] - main.s[0]) / 2,
        seconds,
        tuple(sorted(patches, key=lambda patch: patch.centre)),
    )


# --- C ---


def _with_c(
    place: Place,
    rail: ProfileTable,
    wheel: ProfileTable,
    request: ContactRequest,
    options: RunOptions,
) -> SideContact:
    """Return the contact with all ICs and C, of bodies with flanks as C has them, on one grid of their own.

    The estimated error of C has the change by nearer supports in it, and all have what B-hat shows that the
    grid, limited to `C_STRIPS`, lacks beside finer ones. Raises Failure.
    """
    inclination = abs(place.touch.angle - place.roll)
    if inclination >= C_FLANK:
        raise Failure(
            f"the contact angle is {np.degrees(inclination):.1f} degrees; the bodies of C end in flanks of "
            f"{np.degrees(C_FLANK):.0f} degrees"
        )
    bodies = bodies_at(place, rail, wheel, C_FLANK)
    pair, sought, fine = _on_fine_grids(place, bodies, request, (SIZING,))
    grid = _grid_of_c(pair, sought, request.elements)
    for _ in range(MOST_TRIES):
        problem = problem_of(bodies, replace(request, ics=(C,)), request.load, grid)
        on_grid = pair_on_grid(problem, grid)
        named = {
            name: Areas.with_approximation(name, pair, (grid,), place.roll)
            for name in request.ics
            if name != C
        }
        try:
            contacts = {
                name: _timed(areas, request.load, sought.approach)
                for name, areas in (
                    {SIZING: Areas.with_approximation(SIZING, pair, (grid,), place.roll)} | named
                ).items()
            }
            reference = normal_reference_ics(problem, on_grid, options)
            nearer = next(other_supports(problem, on_grid, options)).operator(on_grid, friction=False)
            (with_c, seconds), (perturbed, _), (supports, _) = (
                _timed(Areas((on_grid,), (operator,), NO_COUPLING, place.roll), request.load, sought.approach)
                for operator in (reference.operator, reference.perturbed, nearer)
            )
            break
        except AreaTooSmall as short:
            (grid,) = longer(Areas.with_approximation(SIZING, pair, (grid,), place.roll), short)
    else:
        raise Failure(f"load = {request.load:g} N: no grid found that fits C")
    lacking = abs(_p_max(contacts[SIZING][0]) - _p_max(fine[SIZING][0]))
    rows = [
        replace(_numbers(place, name, contacts[name][0], further=lacking), seconds=contacts[name][1])
        for name in named
    ]
    further = lacking + abs(_p_max(supports) - _p_max(with_c))
    row = _numbers(place, C, with_c, others=(perturbed,), further=further)
    rows.append(replace(row, seconds=seconds))
    return SideContact(tuple(rows), (grid,), (), C_FLANK)


def _p_max(contact: AreasContact) -> float:
    return max(float(np.max(each.p)) for each in contact.contacts)


def _grid_of_c(pair: PairOnGrid, sought: Sought, elements: int) -> Grid:
    """Return one grid over all patches, of at most `C_STRIPS` strips; raises Failure where they are few."""
    boxes, _ = find_patches(pair, sought.variant, sought.load, sought.roll)
    wanted = fitting_grid(boxes, elements)
    if wanted.n_s > 4 * C_STRIPS:
        raise Failure(
            f"one grid over all patches has {wanted.n_s} strips, and C is solved on {C_STRIPS} at most"
        )
    return refine(pair, [fitting_grid(boxes, elements, C_STRIPS)], sought, C_STRIPS)[0]


# --- patches ---


def patches_on_grid(
    place: Place, on_grid: PairOnGrid, contact: NormalContact, vertical: float
) -> list[PatchNumbers]:
    """Return the patches of a contact on a grid; `vertical` [N] is the load of all patches of the wheel."""
    return [_patch_numbers(place, on_grid, contact, patch, vertical) for patch in contact.patches]


def planar_patches(place: Place, patch: PlanarPatch, vertical: float) -> list[PatchNumbers]:
    """Return the patches in a plane; coordinates in it are turned into arc lengths of the rail."""

    def arc_length(s: Array) -> Array:
        on_rail = patch.plane.lower_arc_length(s - place.touch.s_rail)
        return np.where(np.isnan(on_rail), s, on_rail + place.touch.s_rail)

    turned = []
    for own in patches_on_grid(place, patch.on_grid, patch.contact, vertical):
        start, end = arc_length(np.array(own.s)).tolist()
        centre = float(arc_length(np.array([own.centre]))[0])
        outline = np.stack([arc_length(own.outline[0]), own.outline[1]])
        turned.append(replace(own, centre=centre, s=(start, end), outline=outline))
    return turned


def _patch_numbers(
    place: Place, on_grid: PairOnGrid, contact: NormalContact, patch: Extent, vertical: float
) -> PatchNumbers:
    grid, p = on_grid.grid, np.where(patch.elements, contact.p, 0.0)
    strips = np.sum(p, axis=0)
    angles = place.roll - on_grid.undeformed.lower.contour.inclination(grid.strips)
    low, high = (place.touch.s_rail + grid.strips[0] + end * grid.ds for end in patch.s)
    carried = float(np.sum(strips * np.cos(angles))) * grid.area
    return PatchNumbers(
        normal_force=float(np.sum(strips)) * grid.area,
        share=carried / vertical,
        p_max=float(np.max(p)),
        angle=float(np.average(angles, weights=strips)),
        centre=float(place.touch.s_rail + np.average(grid.strips, weights=strips)),
        s=(float(low), float(high)),
        half_length=(patch.x[1] - patch.x[0]) / 2 * grid.dx,
        area=int(np.count_nonzero(p)) * grid.area,
        outline=_outline(place, grid, p, (float(low), float(high))),
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
