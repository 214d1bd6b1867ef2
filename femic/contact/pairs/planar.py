"""Planar contact of two bodies: all elements in the tangent plane where they touch, on half-spaces.

It is what programs for planar contact solve: ICs A, one contact angle for all elements, and the distance
along the normal of the plane over the coordinate in it. Pressures act along this normal, so without friction
their sum is the vertical load over the cosine of the contact angle. Grids are sized as those of other
contacts; s is the coordinate in the plane. Theory: docs/theory/contact.md.
"""

from dataclasses import replace
from time import perf_counter

from approx.pair import Pair, Solid
from femic.contact.loading import Loading
from femic.contact.pairs.automatic_grid import sizing_of
from femic.contact.pairs.contact_size import contact_size
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.sizing import Sizing
from femic.contact.specification import ContactProblem
from femic.contact.tangent_plane import TangentPlane
from femic.contact.undeformed import Undeformed
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.surfaces import UPPER, Surface

PLANAR, ICS = "planar", "A"  # the name of the contact, and its ICs


def planar(bodies: PairOnGrid, at: float | None = None) -> PairOnGrid:
    """Return bodies in planar contact, the plane tangent at an arc length [mm] of the lower contour.

    None: where they touch first. Raises WrongInput for bodies with an extra gap, and as `TangentPlane`.
    """
    if bodies.extra_gap is not None:
        raise WrongInput(
            "extra_gap: it is along the normals of the lower surface: leave it out of planar contact"
        )
    if not isinstance(bodies.undeformed, Undeformed):
        return bodies
    plane = TangentPlane(bodies.undeformed, at)
    upper = Solid(bodies.pair.upper.material, Surface(UPPER, plane.lower.contour))
    lower = Solid(bodies.pair.lower.material, plane.lower)
    return PairOnGrid(Pair(upper, lower), plane, bodies.grid)


def planar_sizing(problem: ContactProblem, at: float | None = None) -> Sizing:
    """Return the sizing of grids of the planar contact of a problem, as of its other contacts."""
    sizing = sizing_of(problem)
    return replace(sizing, bodies=planar(sizing.bodies, at))


def solve_planar(
    problem: ContactProblem, loading: Loading, at: float | None = None, *, grid: Grid | None = None
) -> SolvedContact:
    """Return the planar contact of a problem without friction, on a grid in the plane, sized if not given.

    The plane is tangent at an arc length [mm] of the lower contour, None: where the bodies touch first. A
    grid that is too short is made longer. Raises as `planar`, and Failure where no grid fits.
    """
    sizing = planar_sizing(problem, at)
    grid = grid or sizing.grid([contact_size(sizing.bodies, loading)])

    def solved(on_grid: PairOnGrid) -> SolvedContact:
        start = perf_counter()
        contact = on_grid.solve(on_grid.operator(ICS), loading)
        return SolvedContact(loading, PLANAR, contact, seconds=perf_counter() - start)

    return sizing.on_long_enough_grid(grid, solved)
