"""Contact of two meshed bodies under a load, on meshes made for the patch, with error estimates.

The patch is first found on rough meshes, from Hertz's on. Then meshes are made for it with `cells` / 2 and
`cells` cells along its shorter half-length; everything about the cells is twice as fine in the second. The
estimate of a number is the difference of both: it is right for an error of first order in the size of cells,
and too large for one of higher order. To that of lengths the error of reading an edge is added. Where gaps of
the coarser meshes tell no edge, because their vertices are too few, it lies next to the outermost of those in
contact, give or take half their spacing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.finite_elements import CELLS, require_enough
from femic.contact.finite_elements.bodies import Expected
from femic.contact.finite_elements.meshed_contact import (
    Bodies,
    MeshedContact,
    ZoneTooSmall,
    mesh_bodies,
    solved,
)
from femic.reference.engine import peak_memory
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput

ROUGH = 5.0  # cells along the shorter half-length of meshes on which the patch is found
NEAR_ENOUGH, MOST_TRIES = 0.2, 10  # change of half-lengths, up to which the patch counts as found
GROWTH = 1.4  # of an expected patch that was too small
READING = 0.1  # error of an edge in spacings of vertices, measured on Hertz's ellipses
LEAST_CURVATURE = 1e-6  # 1/mm, of surfaces that fit each other


@dataclass(frozen=True)
class Numbers:
    """The numbers of a contact; mm, rad, MPa, N. The last three vanish where all is symmetric."""

    a: float  # half-length along x
    b: float  # half-width along s, on the arc
    angle: float  # range of the inclination over the patch
    p_max: float
    approach: float  # of the far arcs: the compliance of the whole bodies is in it
    F_y: float  # lateral force on the upper body
    M_x: float  # moment on it about the x axis through the contact centre [N mm]
    s_centre: float  # centre of pressure along s


@dataclass(frozen=True, eq=False)
class FEContact:
    """A contact of meshed bodies: pressures [MPa] at points (x, s) [mm] of the lower surface, (m,) each.

    They are linear between the points, and cover the modelled part, x >= 0, and s >= 0 if all is symmetric.
    """

    x: Array
    s: Array
    p: Array
    s_range: tuple[float, float]  # arc lengths at which the patch ends [mm]
    numbers: Numbers
    estimate: Numbers  # of the errors of these
    load: float  # [N]
    load_of_pressures: float
    reactions: tuple[float, float]  # of the supports of lower and upper body, along z [N]
    tension: float  # largest, as a share of the largest pressure
    penetration: float  # largest mean about a vertex, as a share of the approach
    unknowns: tuple[int, int]  # of the modelled parts of lower and upper body
    steps: int  # of the search for the vertices in contact, on the finest meshes
    iterations: int  # of the linear problems there
    seconds: Mapping[str, float]
    memory: float  # largest that the process has had [MB]


def fe_contact(
    bodies: Bodies, load: float, *, cells: float = CELLS, expected: Expected | None = None
) -> FEContact:
    """Return the frictionless contact of two bodies under a vertical load [N].

    `expected` is a guess of the patch, Hertz's by default. Raises WrongInput for a load that is not positive
    and too few cells, and Failure where a mesh or the contact fails.
    """
    if not 0 < load < np.inf:
        raise WrongInput(f"load = {load!r}: must be positive and finite [N]")
    require_enough(cells)
    start = perf_counter()
    rough = _on_rough_meshes(bodies, load, expected or hertz_patch(bodies, load))
    patch_seconds = perf_counter() - start
    coarse = solved(bodies, mesh_bodies(bodies, rough.patch, cells / 2), load, rough)
    fine = solved(bodies, mesh_bodies(bodies, rough.patch, cells), load, coarse)
    solution = fine.solution
    return FEContact(
        fine.pair.x,
        fine.pair.s,
        fine.p,
        fine.s_range,
        compute_numbers(fine),
        estimates(fine, coarse),
        fine.load,
        fine.load_of_pressures,
        fine.reactions,
        solution.tension,
        solution.penetration,
        (fine.pair.lower.unknowns, fine.pair.upper.unknowns),
        solution.steps,
        solution.iterations,
        {"patch": patch_seconds, "coarse": coarse.seconds, "fine": fine.seconds},
        peak_memory(),
    )


def compute_numbers(contact: MeshedContact, patch: Expected | None = None) -> Numbers:
    """Return the numbers of a contact; with a `patch` where gaps do not tell its edges."""
    patch = patch or Expected(contact.a, contact.s_range)
    return Numbers(
        patch.a,
        patch.b,
        float(np.ptp(contact.bodies.lower.contour.inclination(np.array(patch.s)))),
        float(contact.p.max()),
        contact.solution.state.approach,
        contact.lateral_force,
        contact.moment,
        contact.centre_of_pressure,
    )


def estimates(fine: MeshedContact, coarse: MeshedContact) -> Numbers:
    """Return estimates of the errors of the numbers on the finer of two pairs of meshes."""
    numbers = compute_numbers(fine)
    try:
        coarser, reading = compute_numbers(coarse), READING * fine.spacing
    except Failure:
        coarser, reading = compute_numbers(coarse, coarse.patch), coarse.spacing / 2
    a, b, angle, *others = (abs(vars(numbers)[name] - vars(coarser)[name]) for name in vars(numbers))
    return Numbers(a + reading, b + reading, angle + reading * numbers.angle / numbers.b, *others)


def _on_rough_meshes(bodies: Bodies, load: float, expected: Expected) -> MeshedContact:
    """Return the contact on rough meshes made for its own patch."""
    contact = None
    for _ in range(MOST_TRIES):
        try:
            contact = solved(bodies, mesh_bodies(bodies, expected, ROUGH), load, contact)
        except ZoneTooSmall:
            middle, half = sum(expected.s) / 2, GROWTH * expected.b
            larger = Expected(GROWTH * expected.a, (middle - half, middle + half))
            expected = _within(bodies, larger)
            continue
        patch = contact.patch
        if max(abs(np.log(patch.a / expected.a)), abs(np.log(patch.b / expected.b))) < NEAR_ENOUGH:
            return contact
        expected = patch
    raise Failure(f"contact under {load:g} N: no patch found that its meshes fit; give `expected`")


def _within(bodies: Bodies, patch: Expected) -> Expected:
    """Return the part of a patch that lies where the bodies may touch."""
    low, high = bodies.s_range
    return replace(patch, s=(max(low, patch.s[0]), min(high, patch.s[1])))


def hertz_patch(bodies: Bodies, load: float) -> Expected:
    """Return the patch of Hertz where the bodies touch first, with the curvatures of the distance there."""
    touching = bodies.undeformed.touching[0]
    step = 1e-3 * (bodies.s_range[1] - bodies.s_range[0])
    before, middle, after = bodies.undeformed.distance(0.0, touching + np.array([-step, 0.0, step]))
    along_x = 2 * (float(bodies.undeformed.distance(step, touching)) - middle)
    along_s = float(before + after - 2 * middle)
    curvature_x, curvature_s = (max(rise / step**2, LEAST_CURVATURE) for rise in (along_x, along_s))
    modulus = combined_modulus(bodies.upper.material, bodies.lower.material)
    patch = PointContact(curvature_x, curvature_s, modulus).at_load(load)
    return _within(bodies, Expected(patch.a, (touching - patch.b, touching + patch.b)))
