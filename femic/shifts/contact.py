"""The contact of one wheel and its rail in a position of the wheelset, without friction, with several ICs.

All patches of the wheel are solved under one approach, with the distance of the displaced profiles
(`femic.contact.pairs.areas`): the wheel comes down perpendicular to the track until they carry the load. Of
each patch are known what it carries, where it lies, and its outline.
"""

from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from femic.contact.datasets import (
    CHANGE,
    FLOOR,
    LARGER,
    MISSED,
    OF_FLOOR,
    PREFIXES,
    WITHOUT_FRICTION,
    difference_errors,
)
from femic.contact.estimates import Measured, Numbers, changes, errors
from femic.contact.exact.hertz import combined_modulus
from femic.contact.normal import NormalContact
from femic.contact.pairs.area_grids import Sought, find_patches, fitting_grid, longer, refine, refined_grids
from femic.contact.pairs.areas import NO_COUPLING, Areas, AreasContact, AreaTooSmall
from femic.contact.pairs.ics import normal_reference_ics
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.pairs.planar import PLANAR, PlanarContact, PlanarPatch, solve_planar
from femic.contact.pairs.quantities import ALL, kinds, lacking, measured, numbers
from femic.contact.supports import other_supports
from femic.contact.undeformed import Undeformed
from femic.reference.run_options import DEFAULT, RunOptions
from femic.shifts.sides import Place, bodies_at, contact_problem
from femic.shifts.specification import C, ContactTable, ProfileTable
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid
from geometries.profiles.noise import peak_slope
from geometries.profiles.placement import STEEPEST

# --- the contact with all ICs ---

SIZING = "Bhat"  # the ICs that size grids
C_FLANK = float(np.radians(60.0))  # steeper ones are pillars that bend under lateral forces
C_STRIPS = 160  # of the one grid over all patches with C
MOST_TRIES = 20  # grids
NUMBERS = {  # of a contact, by name: unit and meaning
    "p_max": ("MPa", "largest pressure"),
    "estimate_p_max": ("MPa", "estimated error of p_max"),
    **{
        f"{prefix}p_max": ("MPa", f"largest pressure{PREFIXES[prefix]}") for prefix in (LARGER, CHANGE, FLOOR)
    },
    f"{MISSED}p_max": ("1", f"largest pressure{PREFIXES[MISSED]}"),
    "approach": ("mm", "approach of wheel and rail"),
    "vertical": ("N", "vertical force on the wheel, perpendicular to the track"),
    "lateral": ("N", "lateral force on the wheel, positive towards the middle of the track"),
    "estimate_lateral": ("N", "estimated error of the lateral force"),
    "angle": ("deg", "change of the rail inclination across the main patch"),
    "a": ("mm", "half-length of the main patch along the rail"),
    "b": ("mm", "half-width of the main patch, arc length"),
    "seconds": ("s", "time of the solution, without C"),
    "patches": ("1", "number of patches"),
    "beside": ("1", "fraction of the load outside the main patch"),
}
OF_PATCH = {  # of each patch of a contact, by growing arc length of the rail: unit, meaning
    "normal_force": ("N", "normal force on the patch"),
    "share": ("1", "fraction of the vertical load carried by the patch"),
    "p_max": ("MPa", "largest pressure of the patch"),
    "angle": (
        "deg",
        "contact angle from the track plane, averaged with the pressures as weights, positive on a flange",
    ),
    "centre": ("mm", "centre of pressure of the patch, arc length from the top of the rail"),
    "start": ("mm", "end of the patch on the gauge side, arc length from the top of the rail"),
    "end": ("mm", "end of the patch on the field side, arc length from the top of the rail"),
    "half_length": ("mm", "half-length of the patch along the rail"),
    "area": ("mm2", "area of the patch"),
}
PATCH = "patch_"  # before these names
POINTS = 400  # of the outlines of patches
Row = dict[str, Any]  # `NUMBERS` but for the last two, and patches: each `OF_PATCH` and an outline (2, n)


def contact_at(
    place: Place,
    rail: ProfileTable,
    wheel: ProfileTable,
    contact: ContactTable,
    options: RunOptions = DEFAULT,
) -> xr.Dataset:
    """Return the contact of a side in a position with all ICs, as `label_contact` does.

    C and the planar contact are left out, with a sentence, where they have no solution. Raises Failure and
    WrongInput.
    """
    names = tuple(name for name in contact.ics if name != C) or (SIZING,)
    bodies = bodies_at(place, rail, wheel)
    pair, sought, solved = _solve_on_fine_grids(place, bodies, contact, names)
    rows = {name: _numbers(place, one) | {"seconds": seconds} for name, (one, seconds) in solved.items()}
    grids, steepest, notes = solved[names[0]][0].areas.grids, STEEPEST, []
    lacks = max(
        lacking(on_grid, pressed) / _p_max(one)
        for one, _ in solved.values()
        for on_grid, pressed in one.parts
    )
    if lacks > 0:
        notes.append(
            "the curvature of the profiles changes within less than one strip of the finest grid; the "
            f"estimated error of p_max includes {100 * lacks:.2g} % for this"
        )
    turn = max(row["angle"] for row in rows.values())
    if C in contact.ics or (contact.c_above_deg is not None and turn > contact.c_above_deg):
        try:
            with_c = contact.model_copy(update={"ics": (*names, C)})
            rows, grids = _with_c(place, rail, wheel, with_c, options)
            steepest, notes = C_FLANK, []
        except Failure as failure:
            notes.append(f"C was not computed: {failure}")
    if contact.planar:
        try:
            start = perf_counter()
            planar = solve_planar(
                pair, contact.load, elements=contact.elements, roll=place.roll, about=sought.approach
            )
            rows[PLANAR] = _planar_numbers(place, planar) | {"seconds": perf_counter() - start}
        except (Failure, WrongInput) as error:
            notes.append(f"planar contact was not computed: {error}")
    return label_contact(rows, grids, steepest, notes)


def label_contact(
    rows: Mapping[str, Row], grids: Sequence[Grid], steepest: float = STEEPEST, notes: Sequence[str] = ()
) -> xr.Dataset:
    """Return `NUMBERS`, `OF_PATCH` and outlines (ics, patch or point); arc lengths from the profile's start.

    Attributes: `steepest` [rad], the inclination at which the bodies end in flanks; the grids; and sentences
    about what was left out.
    """
    patches = [row["patches"] for row in rows.values()]
    most = max(map(len, patches))
    figures = [
        row | {"patches": len(own), "beside": 1 - max(patch["share"] for patch in own)}
        for row, own in zip(rows.values(), patches, strict=True)
    ]
    variables: dict[str, Any] = {
        name: ("ics", [float(row[name]) for row in figures], {"units": unit, "long_name": meaning})
        for name, (unit, meaning) in NUMBERS.items()
    }
    for name, (unit, meaning) in OF_PATCH.items():
        array = np.full((len(rows), most), np.nan)
        for n, own in enumerate(patches):
            array[n, : len(own)] = [patch[name] for patch in own]
        variables[PATCH + name] = ("ics", "patch"), array, {"units": unit, "long_name": meaning}
    outlines = np.stack([_join_outlines([patch["outline"] for patch in own]) for own in patches])
    for k, (name, along) in enumerate(
        {"s": "arc length from the top of the rail", "x": "along the rail"}.items()
    ):
        meaning = f"outline of the patches: {along}"
        variables[f"outline_{name}"] = ("ics", "point"), outlines[:, k], {"units": "mm", "long_name": meaning}
    sizes = [(grid.n_x, grid.n_s, grid.dx, grid.ds, grid.s) for grid in grids]
    texts = [f"{n_x} x {n_s} elements of {dx:.3g} x {ds:.3g} mm" for n_x, n_s, dx, ds, _ in sizes]
    return xr.Dataset(
        variables,
        coords={"ics": list(rows), "patch": np.arange(1, most + 1)},
        attrs={
            "notes": "; ".join(notes),
            "grid": "; ".join(texts),
            "grids": [float(size) for each in sizes for size in each],
            "steepest": steepest,
        },
    )


def read_grids(entry: xr.Dataset) -> tuple[Grid, ...]:
    """Return the grids of a contact of `label_contact`."""
    rows = np.reshape(entry.attrs["grids"], (-1, 5))
    return tuple(Grid(int(n_x), int(n_s), float(dx), float(ds), float(s)) for n_x, n_s, dx, ds, s in rows)


def _join_outlines(outlines: Sequence[Array]) -> Array:
    """Return the outlines of all patches, NaN between them, as arc lengths of the rail and x, (2, POINTS)."""
    while True:
        closed = [
            np.concatenate([one, one[:, ::-1] * [[1.0], [-1.0]], np.full((2, 1), np.nan)], axis=1)
            for one in outlines
        ]
        points = np.concatenate(closed, axis=1)
        if points.shape[1] <= POINTS:
            return np.pad(points, ((0, 0), (0, POINTS - points.shape[1])), constant_values=np.nan)
        outlines = [  # every second strip, and the ends
            np.concatenate([one[:, :1], one[:, 1:-1][:, ::2], one[:, -1:]], axis=1) for one in outlines
        ]


def _solve_on_fine_grids(
    place: Place, bodies: dict[str, Body], contact: ContactTable, names: Sequence[str]
) -> tuple[PairOnGrid, Sought, dict[str, tuple[AreasContact, float]]]:
    """Return rail and wheel, the contact sought, and those with all ICs on the same grids, with seconds."""
    problem = contact_problem(bodies, contact)
    pair = pair_on_grid(problem, problem.grid)
    boxes, sought = find_patches(pair, SIZING, contact.load, place.roll)
    grids = refined_grids(pair, boxes, sought, contact.elements)
    for _ in range(MOST_TRIES):
        areas = [Areas.with_approximation(name, pair, grids, place.roll) for name in names]
        try:
            solved = [_solve_timed(each, contact.load, sought.approach) for each in areas]
            return pair, sought, dict(zip(names, solved, strict=True))
        except AreaTooSmall as short:
            grids = tuple(longer(areas[0], short))
    raise Failure(f"load = {contact.load:g} N: no grids found that fit all ICs; take fewer elements")


def _solve_timed(areas: Areas, load: float, about: float) -> tuple[AreasContact, float]:
    """Return a contact and the seconds of its solution."""
    start = perf_counter()
    return areas.solve(load, about), perf_counter() - start


def _p_max(contact: AreasContact) -> float:
    return max(float(np.max(each.p)) for each in contact.contacts)


# --- C ---


def _with_c(
    place: Place, rail: ProfileTable, wheel: ProfileTable, contact: ContactTable, options: RunOptions
) -> tuple[dict[str, Row], tuple[Grid, ...]]:
    """Return the numbers with all ICs and C, of bodies with flanks as C has them, on one grid of their own.

    The estimated error of C has the change by nearer supports in it, and all have what B-hat shows that the
    grid, limited to `C_STRIPS`, lacks beside finer ones. Raises Failure.
    """
    inclination = abs(place.touch.angle - place.roll)
    if inclination >= C_FLANK:
        raise Failure(
            f"the contact angle is {np.degrees(inclination):.1f} degrees, but the bodies for C end in "
            f"flanks of {np.degrees(C_FLANK):.0f} degrees"
        )
    bodies, load = bodies_at(place, rail, wheel, C_FLANK), contact.load
    pair, sought, fine = _solve_on_fine_grids(place, bodies, contact, (SIZING,))
    boxes, _ = find_patches(pair, sought.variant, sought.load, sought.roll)
    wanted = fitting_grid(boxes, contact.elements)
    if wanted.n_s > 4 * C_STRIPS:
        raise Failure(f"one grid over all patches needs {wanted.n_s} strips; C is limited to {C_STRIPS}")
    grid = refine(pair, [fitting_grid(boxes, contact.elements, C_STRIPS)], sought, C_STRIPS)[0]
    names = [name for name in contact.ics if name != C]
    for _ in range(MOST_TRIES):
        problem = contact_problem(bodies, contact.model_copy(update={"ics": (C,)}), grid)
        on_grid = pair_on_grid(problem, grid)
        areas = {
            name: Areas.with_approximation(name, pair, (grid,), place.roll)
            for name in dict.fromkeys((SIZING, *names))
        }
        try:
            solved = {name: _solve_timed(each, load, sought.approach) for name, each in areas.items()}
            reference = normal_reference_ics(problem, on_grid, options)
            nearer = next(other_supports(problem, on_grid, options)).operator(on_grid, friction=False)
            (with_c, seconds), (perturbed, _), (supports, _) = (
                _solve_timed(Areas((on_grid,), (operator,), NO_COUPLING, place.roll), load, sought.approach)
                for operator in (reference.operator, reference.perturbed, nearer)
            )
            break
        except AreaTooSmall as short:
            (grid,) = longer(areas[SIZING], short)
    else:
        raise Failure(f"load = {load:g} N: no grid found that fits C")
    lacks = abs(_p_max(solved[SIZING][0]) - _p_max(fine[SIZING][0]))
    rows = {
        name: _numbers(place, solved[name][0], lacks=lacks) | {"seconds": solved[name][1]} for name in names
    }
    rows[C] = _numbers(place, with_c, lacks=lacks, changed=(perturbed, supports)) | {"seconds": seconds}
    return rows, (grid,)


# --- numbers with their errors ---

ESTIMATED = {name: ALL[name] for name in ("p_max", "F_y", "a", "b", "angle", "approach", "load")}
OF_PLANE = {name: ALL[name] for name in ("p_max", "a", "b")}


def _numbers(
    place: Place,
    contact: AreasContact,
    *,
    lacks: float = 0.0,
    changed: tuple[AreasContact, AreasContact] | None = None,
) -> Row:
    """Return the numbers of a contact with their errors, and with the variations of `femic.contact.datasets`.

    `lacks` [MPa] is what p_max lacks on this grid. `changed` are the contact with the ICs plus their
    estimated error, and that with nearer supports. What the grid lacks and what rounded points of profiles do
    is nearly the same with all ICs, as are floors: the part `OF_FLOOR` of it is not in common.
    """
    lateral, vertical = place.in_track(contact.force)
    patches = [
        patch
        for on_grid, pressed in contact.parts
        for patch in patches_on_grid(place, on_grid, pressed, vertical)
    ]
    largest_forces = [
        max(
            (float(np.sum(pressed.p[patch.elements])) * on_grid.grid.area for patch in pressed.patches),
            default=0,
        )
        for on_grid, pressed in contact.parts
    ]
    main = int(np.argmax(largest_forces))
    own = numbers(contact.areas.on_grids[main], contact.contacts[main], ESTIMATED)
    known = [_errors(contact, k, changed[:1] if changed else ()) for k in range(len(contact.contacts))]
    p_max = [float(np.max(pressed.p)) for pressed in contact.contacts]
    rounded = [_rounding_error(place, on_grid, pressed) for on_grid, pressed in contact.parts]
    uppermost = max(p + each["p_max"] + more for p, each, more in zip(p_max, known, rounded, strict=True))
    highest = int(np.argmax(p_max))
    moved = [abs(_p_max(other) - max(p_max)) for other in changed or ()]
    estimate = max(known[highest]["p_max"] + rounded[highest], uppermost - max(p_max))
    on_grid, pressed = contact.areas.on_grids[highest], contact.contacts[highest]
    known_numbers = measured(on_grid, pressed, ESTIMATED)
    uncommon = difference_errors(known_numbers, {"p_max": ALL["p_max"]}, WITHOUT_FRICTION)
    return {
        "p_max": max(p_max),
        "estimate_p_max": estimate + lacks + sum(moved[1:]),
        f"{LARGER}p_max": np.nan if contact.coarser is None else _p_max(contact.coarser),
        f"{CHANGE}p_max": sum(moved),
        f"{FLOOR}p_max": uncommon[FLOOR]["p_max"] + OF_FLOOR * (rounded[highest] + lacks),
        f"{MISSED}p_max": uncommon[MISSED]["p_max"],
        "approach": contact.approach,
        "vertical": vertical,
        "lateral": -lateral,
        "estimate_lateral": float(sum(each["F_y"] for each in known)),
        **{name: own[name] for name in ("angle", "a", "b")},
        "patches": sorted(patches, key=lambda patch: patch["centre"]),
    }


def _rounding_error(place: Place, on_grid: PairOnGrid, pressed: NormalContact) -> float:
    """Return what the last decimals of the profiles' files may change p_max of an area by [MPa].

    Source: `geometries.profiles.noise`; 0 of the curves of standards.
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


def _errors(contact: AreasContact, number: int, others: Sequence[AreasContact]) -> dict[str, float]:
    """Return estimated errors of an area's numbers, from elements twice and four times as large."""
    levels, level = list[Measured](), contact if contact.contacts[number].in_contact.any() else None
    while level is not None and len(levels) < 3 and level.contacts[number].in_contact.any():
        levels.append(measured(level.areas.on_grids[number], level.contacts[number], ESTIMATED))
        level = level.coarser
    if not levels:
        return dict.fromkeys(ESTIMATED, 0.0)
    error_kinds = kinds(ESTIMATED)
    parts: list[Numbers] = [
        changes(
            levels[0], error_kinds, numbers(other.areas.on_grids[number], other.contacts[number], ESTIMATED)
        )
        for other in others
    ]
    return errors(error_kinds, levels[0], levels[1:], parts)


def _planar_numbers(place: Place, planar: PlanarContact) -> Row:
    """Return the numbers of the planar contact; in its plane a patch does not turn."""
    angles = [place.roll - patch.plane.angle for patch in planar.patches]
    forces = [patch.normal_force for patch in planar.patches]
    vertical = float(np.dot(forces, np.cos(angles)))
    patches = [own for patch in planar.patches for own in planar_patches(place, patch, vertical)]
    main = max(patches, key=lambda patch: patch["normal_force"])
    highest = max(planar.patches, key=lambda patch: float(np.max(patch.contact.p)))
    levels, contact = [measured(highest.on_grid, highest.contact, OF_PLANE)], highest.contact.coarser
    while contact is not None and len(levels) < 3:
        levels.append(measured(highest.on_grid, contact, OF_PLANE))
        contact = contact.coarser
    return {
        "p_max": float(np.max(highest.contact.p)),
        "estimate_p_max": errors(kinds(OF_PLANE), levels[0], levels[1:])["p_max"],
        **{f"{prefix}p_max": np.nan for prefix in (LARGER, CHANGE, FLOOR, MISSED)},  # elements of its own
        "approach": planar.approach,
        "vertical": vertical,
        "lateral": float(np.dot(forces, np.sin(angles))),
        "estimate_lateral": np.nan,
        "angle": 0.0,
        "a": main["half_length"],
        "b": (main["end"] - main["start"]) / 2,
        "patches": sorted(patches, key=lambda patch: patch["centre"]),
    }


# --- patches ---


def patches_on_grid(place: Place, on_grid: PairOnGrid, contact: NormalContact, vertical: float) -> list[Row]:
    """Return the patches of a contact on a grid; `vertical` [N] is the load of all patches of the wheel.

    Arc lengths are those of the rail's profile from its start. Outlines (2, n) are arc lengths and
    half-lengths along x of strips of a patch, and of its ends.
    """
    grid, rows = on_grid.grid, []
    angles = place.roll - on_grid.undeformed.lower.contour.inclination(grid.strips)
    for patch in contact.patches:
        p = np.where(patch.elements, contact.p, 0.0)
        strips, pressed = np.sum(p, axis=0), np.flatnonzero(p.any(axis=0))
        start, end = (float(place.touch.s_rail + grid.strips[0] + edge * grid.ds) for edge in patch.s)
        half = [_half_length(on_grid.x, p[:, strip], grid.dx) for strip in pressed]
        s = place.touch.s_rail + grid.strips[pressed]
        rows.append(
            {
                "normal_force": float(np.sum(strips)) * grid.area,
                "share": float(np.sum(strips * np.cos(angles))) * grid.area / vertical,
                "p_max": float(np.max(p)),
                "angle": float(np.degrees(np.average(angles, weights=strips))),
                "centre": float(place.touch.s_rail + np.average(grid.strips, weights=strips)),
                "start": start,
                "end": end,
                "half_length": (patch.x[1] - patch.x[0]) / 2 * grid.dx,
                "area": int(np.count_nonzero(p)) * grid.area,
                "outline": np.array([[start, *s, end], [0.0, *half, 0.0]]),
            }
        )
    return rows


def planar_patches(place: Place, patch: PlanarPatch, vertical: float) -> list[Row]:
    """Return the patches in a plane; coordinates in it are turned into arc lengths of the rail."""

    def arc_length(s: Array) -> Array:
        on_rail = patch.plane.lower_arc_length(s - place.touch.s_rail)
        return np.where(np.isnan(on_rail), s, on_rail + place.touch.s_rail)

    turned = []
    for own in patches_on_grid(place, patch.on_grid, patch.contact, vertical):
        start, centre, end = arc_length(np.array([own[name] for name in ("start", "centre", "end")])).tolist()
        outline = np.stack([arc_length(own["outline"][0]), own["outline"][1]])
        turned.append(own | {"start": start, "centre": centre, "end": end, "outline": outline})
    return turned


def _half_length(x: Array, p: Array, dx: float) -> float:
    """Return the half-length [mm] of a strip: its squared pressure falls nearly linearly in x^2."""
    inside = np.flatnonzero((p > 0) & (x >= 0))
    if len(inside) < 4:
        return float(np.count_nonzero(p > 0) * dx / 2)
    second, third = inside[-2], inside[-4]
    slope = (p[second] ** 2 - p[third] ** 2) / (x[second] ** 2 - x[third] ** 2)
    last = float(x[inside[-1]])
    edge = np.sqrt(max(x[second] ** 2 - p[second] ** 2 / slope, 0.0)) if slope < 0 else last + dx / 2
    return float(np.clip(edge, last, last + dx))
